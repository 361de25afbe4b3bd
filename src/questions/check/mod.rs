//! Checks the recordings: finds faults of the test rig, and whether the loads determine the coefficients of the model.

pub(crate) mod independent_loads;
mod judgement;
pub mod query;
pub(crate) mod shown;

pub(crate) use shown::{rig_and_axes, rig_figures};
