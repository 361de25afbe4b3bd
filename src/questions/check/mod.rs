//! Checks the recordings: finds faults of the test rig, and whether the loads determine the coefficients of the model.

mod alternating;
pub(crate) mod cautions;
pub(crate) mod cold_start;
pub(crate) mod faulty;
pub(crate) mod independent_loads;
mod judgement;
pub(crate) mod load_count;
pub mod query;
pub mod rig;
pub(crate) mod shown;

pub(crate) use shown::sufficiency_tables;
