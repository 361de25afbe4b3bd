//! How good a calibration is, and what to draw of it.

pub mod cross_validation;
pub mod holds;
pub mod left_out;
pub mod loops;
pub mod mean_hysteresis;
pub mod metrics;
pub mod metrology;
pub mod numbers;
pub mod quantile;
pub mod series;
pub mod threshold_study;

pub use series::Series;
