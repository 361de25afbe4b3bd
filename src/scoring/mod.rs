//! Computations that several kinds of results need: cross-validation, loops, intervals of constant load, lag, faults of the
//! rig, traces to draw.

pub mod budget;
pub(crate) mod coverage;
pub(crate) mod cross_validation;
pub(crate) mod faults;
pub(crate) mod holds;
pub(crate) mod information;
mod inverse;
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
pub(crate) mod score_set;
pub(crate) mod series;
pub(crate) mod straight_lines;

pub(crate) use series::Series;

/// Maximum number of samples whose computed loads are kept in memory. With more samples, the loads are computed again at each
/// use.
pub const MANY_SAMPLES: usize = 2_000_000;
