//! Choosing thresholds: the errors at every pair of F_th and t_th, and which pair the left-out recordings favour.
//!
//! | part | file |
//! |---|---|
//! | which pairs, and in which order | [`ThresholdGrid`] |
//! | all scores of one F_th over every t_th, from sums | [`Scorer`](scorer::Scorer) |
//! | what is shown of six axes: one number | [`Measure`] |
//! | the errors over both thresholds, and the curves in them | [`ThresholdMap`] |
//! | the pair to take, and how flat the choice is | [`Suggestion`] |
//! | what a pair does to the samples | [`PastAges`] |
//!
//! Guarantees: every number is that of a fresh fit at that pair, up to rounding; where the past never differs, it is that
//! of the conventional calibration exactly. Test recordings are scored, and take no part in a suggestion.

pub mod asked;
mod grid;
mod map;
mod measure;
mod past_ages;
pub(crate) mod scorer;
pub(crate) mod study;
mod suggestion;

pub use grid::ThresholdGrid;
pub(crate) use grid::{GridError, even_values};
pub(crate) use map::{Along, ScoreSet, ThresholdMap};
pub use measure::Measure;
pub(crate) use measure::MeasureScale;
pub(crate) use past_ages::PastAges;
pub(crate) use suggestion::{FlatRange, NoSuggestion, Suggestion};
