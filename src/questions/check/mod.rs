//! Do the recordings determine the model, and what is wrong with them?

pub mod cautions;
pub mod faulty;
pub mod independent_loads;
mod judgement;
pub(crate) mod load_count;
pub(crate) mod odd;
pub mod query;
pub(crate) mod shown;

#[cfg(feature = "gui")]
pub(crate) use shown::pair_figure;
pub(crate) use shown::sufficiency_tables;
