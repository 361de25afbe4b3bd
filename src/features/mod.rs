//! What a sample is described by: its gauges, and what each chosen block appends about the past.
//!
//! Blocks see *standardised* gauges `z = (s − shift) / scale` ([`GaugeScale`]), so that every column has a size near
//! one. A column that is itself a past gauge enters the fit relative to the present one (`z_past − z`): where the past
//! never differs it is zero, and the answer is the conventional one.

mod gauge_scale;
pub mod look_back;

pub use gauge_scale::GaugeScale;
pub use look_back::{Distance, LoadPath, Thresholds};
