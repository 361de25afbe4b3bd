//! Choice of a look-back's thresholds: the errors at each pair of a force threshold F_th and a time threshold t_th, and the
//! pair with the lowest cross-validation error.
//!
//! | contents | type |
//! |---|---|
//! | pairs to try, and their order | [`ThresholdGrid`] |
//! | errors at one F_th and all t_th, computed from sums over the samples | [`Scorer`](scorer::Scorer) |
//! | one number from the errors of all axes | [`Measure`] |
//! | errors over both thresholds, and curves through them | [`ThresholdMap`] |
//! | suggested pair, and the range of equally good pairs | [`Suggestion`] |
//! | ages of the earlier samples that a look-back with one pair finds | [`PastAges`] |
//!
//! Guarantees: every error equals the error of a new fit with the same thresholds, up to rounding. If the look-back finds no
//! earlier sample, the error is exactly that of the conventional calibration. Test recordings are scored, but do not
//! influence a suggestion.

pub mod asked;
mod grid;
mod map;
mod measure;
mod past_ages;
mod saved;
pub(crate) mod scorer;
pub(crate) mod study;
mod suggestion;

pub use grid::ThresholdGrid;
pub(crate) use grid::{GridError, even_values};
pub(crate) use map::{Along, ThresholdMap};
pub use measure::Measure;
pub(crate) use measure::MeasureScale;
pub(crate) use past_ages::PastAges;
pub(crate) use saved::{
    MAP_FORMATS, ShownFTh, map_format, threshold_curve, threshold_heat_map, write_threshold_csv,
    write_threshold_svg,
};
pub(crate) use suggestion::Suggestion;
