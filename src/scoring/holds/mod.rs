//! Where a load stands still, and how the output drifts there.
//!
//! A **hold** is an interval of one recording in which every axis stays within a band of its own for some seconds. In it
//! an output that still moves creeps: [`Drift`] fits a first-order exponential to it.

mod drift;
mod stillness;

pub use drift::Drift;
pub(crate) use drift::NoTimeConstant;
pub(crate) use stillness::Hold;
pub use stillness::holds;
