//! Choice of a look-back's thresholds: the errors at each pair of a force threshold F_th and a time threshold t_th, and the
//! pair with the lowest cross-validation error.
//!
//! | contents | type |
//! |---|---|
//! | pairs to try, and their order | [`ThresholdGrid`] |
//! | errors at one F_th and all t_th, computed from sums over the samples | [`Scorer`](study::Scorer) |
//! | one number from the errors of all axes | [`Measure`] |
//! | errors over both thresholds, and curves through them | [`ThresholdMap`] |
//! | suggested pair, and the range of equally good pairs | [`Suggestion`] |
//! | ages of the earlier samples that a look-back with one pair finds | [`PastAges`] |
//!
//! Guarantees: every error equals the error of a new fit with the same thresholds, up to rounding. If the look-back finds no
//! earlier sample, the error is exactly that of the conventional calibration. Test recordings are scored, but do not
//! influence a suggestion.

pub mod asked;
mod map;
mod saved;
pub(crate) mod study;

pub(crate) use map::{Along, GridError, MeasureScale, Suggestion, ThresholdMap, even_values};
pub use map::{Measure, ThresholdGrid};
pub(crate) use saved::{
    MAP_FORMATS, ShownFTh, map_format, threshold_curve, threshold_heat_map, write_threshold_csv,
    write_threshold_svg,
};
pub(crate) use study::PastAges;
