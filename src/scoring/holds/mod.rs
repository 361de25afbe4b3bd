//! Dwells: intervals in which the load stands still, and the drift of the output in them.
//!
//! In a dwell, every axis stays within its band for some seconds. An output that still moves creeps; [`Drift`] fits a
//! first-order exponential to it.

mod drift;
mod stillness;

pub use drift::Drift;
pub(crate) use drift::NoTimeConstant;
pub(crate) use stillness::Hold;
pub use stillness::holds;
