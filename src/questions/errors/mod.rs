//! Errors of a calibration for each recording and axis, and the traces of loads and errors.

pub mod asked;
pub(crate) mod factory;
pub(crate) mod fit;
pub(crate) mod intervals;
pub mod query;
pub(crate) mod shown;
pub(crate) mod trace_values;
pub(crate) mod traces;
pub(crate) mod view;

pub use shown::errors;
pub(crate) use shown::factory_note;
