//! Do the recordings determine the model, and what is wrong with them?

mod alternating;
pub mod cautions;
pub mod cold_start;
pub mod faulty;
pub mod independent_loads;
mod judgement;
pub(crate) mod load_count;
pub mod query;
pub mod rig;
pub(crate) mod shown;

pub(crate) use shown::sufficiency_tables;
