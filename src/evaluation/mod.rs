//! How good a calibration is, and what to draw of it.

pub mod cross_validation;
pub mod holds;
pub mod loops;
pub mod metrics;
pub mod metrology;
pub mod numbers;
pub mod quantile;
pub mod series;

pub use series::Series;
