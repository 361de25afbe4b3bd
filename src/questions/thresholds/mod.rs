//! Choice of thresholds: the errors at every pair of F_th and t_th, and the pair with the lowest held-out error.
//!
//! | contents | type |
//! |---|---|
//! | pairs to try, and their order | [`ThresholdGrid`] |
//! | all scores of one F_th over every t_th, from sums | [`Scorer`](scorer::Scorer) |
//! | one number for the errors of six axes | [`Measure`] |
//! | errors over both thresholds, and curves through them | [`ThresholdMap`] |
//! | proposed pair, and the range of equally good pairs | [`Suggestion`] |
//! | effect of a pair on the samples | [`PastAges`] |
//! Guarantees: every number equals that of a new fit at its pair, up to rounding. If no past sample differs, it is exactly
//! that of the conventional calibration. Test recordings are scored, but do not influence a proposal.

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
