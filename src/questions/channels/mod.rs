//! One channel of a recording over time or over another channel, with its noise, drift and spectrum. No calibration is needed.

mod figures;
pub(crate) mod query;
mod shown;
mod spectrum;
