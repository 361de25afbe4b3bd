//! Choice of thresholds: the errors at each pair of F_th and t_th, and the pair with the lowest cross-validation error.
//!
//! | contents | type |
//! |---|---|
//! | pairs to try, and their order | [`ThresholdGrid`] |
//! | scores of one F_th at all t_th, from sums | [`Scorer`](scorer::Scorer) |
//! | one number from the errors of all axes | [`Measure`] |
//! | errors over both thresholds, and curves through them | [`ThresholdMap`] |
//! | suggested pair, and the range of equally good pairs | [`Suggestion`] |
//! | ages of the past samples that a pair finds | [`PastAges`] |
//! Guarantees: every error equals the error of a new fit at the same thresholds, up to rounding. If no past sample differs from
//! the present sample, the error is exactly the conventional error. Test recordings are scored, but do not influence a
//! suggestion.

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
pub(crate) use map::{Along, ScoreSet, ThresholdMap};
pub use measure::Measure;
pub(crate) use measure::MeasureScale;
pub(crate) use past_ages::PastAges;
pub(crate) use saved::{
    MAP_FORMATS, ShownFTh, map_format, threshold_curve, threshold_heat_map, write_threshold_csv,
    write_threshold_svg,
};
pub(crate) use suggestion::{FlatRange, NoSuggestion, Suggestion};
