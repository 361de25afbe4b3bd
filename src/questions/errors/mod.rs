//! Errors of a calibration for each recording and axis, and the traces of loads and errors.

pub(crate) mod cold_start;
pub(crate) mod factory;
pub mod findings;
pub(crate) mod intervals;
pub mod query;
pub(crate) mod shown;
pub(crate) mod trace_values;
pub(crate) mod traces;

pub use shown::errors;
pub(crate) use shown::factory_note;
