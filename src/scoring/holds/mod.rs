//! Dwells: intervals in which the load is constant, and the drift of the output in them.
//!
//! In a dwell, the load of every axis stays within a narrow band for some seconds. If the output still changes, it creeps.
//! [`Drift`] describes this change by a first-order exponential.

mod drift;
mod stillness;

pub use drift::Drift;
pub(crate) use drift::NoTimeConstant;
pub(crate) use stillness::Hold;
pub use stillness::holds;
