//! Scores of calibrations: cross-validation, loops, dwells, lag, faults of the rig, and traces to draw.

pub(crate) mod coverage;
pub(crate) mod cross_validation;
pub(crate) mod faults;
pub(crate) mod holds;
pub(crate) mod information;
pub mod lag;
pub(crate) mod left_out;
pub(crate) mod load_spread;
pub mod loops;
pub(crate) mod mean_hysteresis;
pub(crate) mod metrics;
pub mod numbers;
pub(crate) mod part_squares;
#[cfg(test)]
pub(crate) mod pixels;
pub(crate) mod quantile;
pub mod rig;
pub(crate) mod series;
mod straight_lines;

pub(crate) use series::Series;

/// Maximum number of samples whose loads are kept in memory. Loads of longer data are computed again at each use.
pub const MANY_SAMPLES: usize = 2_000_000;
