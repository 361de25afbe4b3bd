//! Map of errors over both thresholds of a look-back: its grid (one row for each force threshold F_th, one column for each
//! time threshold t_th), measures that combine the errors of several axes in one number, and the suggested pair.
//!
//! Guarantees: rows may arrive in any order. A missing row is `None`, and every function accepts missing rows. The thresholds
//! of a [`ThresholdGrid`] are finite, not negative, and ascending. There is at least one F_th and one t_th. Every measure is
//! the root of a weighted sum of the axes' squared errors, so the same weights apply to sums of squared errors.

use serde::{Deserialize, Serialize};

use crate::{
    calibration::{CrossValidation, ErrorBlocks, NoCrossValidation, weighed},
    features::{Distance, Thresholds},
    min_max::MinMax,
    questions::{
        error::AnalysisError,
        thresholds::{saved::ShownFTh, study::PointScores},
    },
    recording::Axis,
    scoring::{
        metrics::percent_change,
        numbers::{decimals, round_step, significant},
        score_set::ScoreSet,
    },
};

/// Threshold that varies along a curve of errors, while the other one is fixed.
#[derive(Clone, Copy, Debug)]
pub enum Along {
    F,
    T,
}

impl Along {
    pub fn of(self, pair: Thresholds) -> f64 {
        match self {
            Self::F => pair.f_th,
            Self::T => pair.t_th_secs,
        }
    }

    /// Returns the pair with another threshold.
    pub fn with(self, pair: Thresholds, value: f64) -> Thresholds {
        match self {
            Self::F => Thresholds { f_th: value, ..pair },
            Self::T => Thresholds { t_th_secs: value, ..pair },
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdMap {
    pub grid: ThresholdGrid,
    pub distance: Distance,
    pub scale: MeasureScale,
    /// Number of training samples.
    pub n_train: u64,
    pub n_test: u64,
    /// Number of samples of each part of the training recordings that cross-validation leaves out.
    pub part_samples: Vec<u64>,
    pub cross_validation: CrossValidation,
    pub conventional: PointScores,
    pub rows: Vec<Option<Vec<PointScores>>>,
}

impl ThresholdMap {
    pub fn new(
        grid: ThresholdGrid,
        distance: Distance,
        scale: MeasureScale,
        conventional: PointScores,
        part_samples: Vec<u64>,
    ) -> Self {
        Self {
            rows: vec![None; grid.f_ths.len()],
            n_train: part_samples.iter().sum(),
            n_test: 0,
            cross_validation: CrossValidation::default(),
            grid,
            distance,
            scale,
            part_samples,
            conventional,
        }
    }

    /// Stores the scores of one row: those of the F_th with index `f_at`, one for each t_th.
    ///
    /// # Panics
    /// If the grid has no such row, or if `points` does not have one entry for each t_th.
    pub fn set_row(&mut self, f_at: usize, points: Vec<PointScores>) {
        assert_eq!(points.len(), self.grid.t_ths_secs.len(), "one per t_th");
        self.rows[f_at] = Some(points);
    }

    pub fn is_complete(&self) -> bool {
        self.rows.iter().all(Option::is_some)
    }

    pub fn n_rows_done(&self) -> usize {
        self.rows.iter().flatten().count()
    }

    /// Returns the scores at row `f_at` and column `t_at` of the grid; `None` for a missing row.
    pub fn point(&self, f_at: usize, t_at: usize) -> Option<&PointScores> {
        self.rows.get(f_at)?.as_ref()?.get(t_at)
    }

    /// Returns the thresholds and the scores of all points that are computed, with t_th running faster.
    pub fn points(&self) -> impl Iterator<Item = (Thresholds, &PointScores)> {
        let n_t = self.grid.t_ths_secs.len();
        let all = (0..self.rows.len() * n_t).map(move |at| (at / n_t, at % n_t));
        all.filter_map(|(f_at, t_at)| Some((self.thresholds(f_at, t_at), self.point(f_at, t_at)?)))
    }

    /// Returns the thresholds at row `f_at` and column `t_at` of the grid. Panics if there is no such row or column.
    pub fn thresholds(&self, f_at: usize, t_at: usize) -> Thresholds {
        Thresholds { f_th: self.grid.f_ths[f_at], t_th_secs: self.grid.t_ths_secs[t_at] }
    }

    /// Returns the row and the column of the pair that is nearest to these thresholds.
    pub fn nearest(&self, thresholds: Thresholds) -> (usize, usize) {
        let nearest = |values: &[f64], wanted: f64| {
            let distance = |at: &usize| (values[*at] - wanted).abs();
            let all = 0..values.len();
            all.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
        };
        (
            nearest(&self.grid.f_ths, thresholds.f_th),
            nearest(&self.grid.t_ths_secs, thresholds.t_th_secs),
        )
    }

    pub fn value(&self, set: ScoreSet, measure: Measure, f_at: usize, t_at: usize) -> Option<f64> {
        let scores = &self.point(f_at, t_at)?.scores;
        measure.of_rmse(&self.scale, set.rmse(scores)?)
    }

    pub fn conventional_value(&self, set: ScoreSet, measure: Measure) -> Option<f64> {
        measure.of_rmse(&self.scale, set.rmse(&self.conventional.scores)?)
    }

    /// Returns the errors of all pairs of thresholds, `n_f_th × n_t_th` row-major.
    pub fn values(&self, set: ScoreSet, measure: Measure) -> Vec<Option<f64>> {
        let n_t = self.grid.t_ths_secs.len();
        (0..self.rows.len() * n_t).map(|at| self.value(set, measure, at / n_t, at % n_t)).collect()
    }

    /// Returns the smallest and the largest error of the colour scale; `None` without any error. The few largest errors lie
    /// above the scale, because a look-back that finds hardly any earlier sample can have a far larger error.
    pub fn shades(&self, set: ScoreSet, measure: Measure) -> Option<(f64, f64)> {
        let known = self.values(set, measure);
        let (least, greatest) = known.iter().flatten().collect::<MinMax>().ends()?;
        let without = self.conventional_value(set, measure).unwrap_or(greatest);
        Some((least, if without > least { without } else { greatest }))
    }

    /// Returns the points `(threshold, error)` of the curve along one threshold through this pair, ascending. Pairs without
    /// an error are left out.
    pub fn curve(
        &self,
        along: Along,
        set: ScoreSet,
        measure: Measure,
        (f_at, t_at): (usize, usize),
    ) -> Vec<(f64, f64)> {
        let thresholds = match along {
            Along::F => &self.grid.f_ths,
            Along::T => &self.grid.t_ths_secs,
        };
        let value = |at: usize| match along {
            Along::F => self.value(set, measure, at, t_at),
            Along::T => self.value(set, measure, f_at, at),
        };
        let thresholds = thresholds.iter().enumerate();
        thresholds.filter_map(|(at, threshold)| Some((*threshold, value(at)?))).collect()
    }

    /// Returns the row, the column and the value of the lowest error. Of several equal errors, the one with the smallest
    /// thresholds is returned.
    pub fn minimum(&self, set: ScoreSet, measure: Measure) -> Option<((usize, usize), f64)> {
        let n_t = self.grid.t_ths_secs.len();
        let values = self.values(set, measure).into_iter().enumerate();
        let known = values.filter_map(|(at, value)| Some(((at / n_t, at % n_t), value?)));
        known.min_by(|(_, a), (_, b)| a.total_cmp(b))
    }
}

/// Maximum number of values of one threshold. A plot could not distinguish more values.
pub const MAX_VALUES: usize = 2000;
/// Maximum number of pairs of thresholds. The errors of more pairs would fill the memory.
const MAX_PAIRS: usize = 250_000;
/// Approximate number of force thresholds F_th in the coarsest level of [`ThresholdGrid::coarse_to_fine`], which spans the
/// whole range.
const COARSEST: usize = 5;

/// All pairs of the listed force thresholds F_th and time thresholds t_th.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdGrid {
    /// Force thresholds F_th, ascending (N, or share of full scale).
    pub(crate) f_ths: Vec<f64>,
    /// Time thresholds t_th, ascending (s).
    pub(crate) t_ths_secs: Vec<f64>,
}

#[derive(Debug, thiserror::Error)]
pub enum GridError {
    #[error(
        "{what} has no values; enter start:stop:step, or ascending numbers separated by commas"
    )]
    Empty { what: &'static str },
    #[error("the step of {what} is {step}; enter a number above zero")]
    Step { what: &'static str, step: f64 },
    #[error("the range of {what} goes from {start} down to {stop}; enter the smaller value first")]
    Reversed { what: &'static str, start: f64, stop: f64 },
    #[error(
        "the values of {what} are not ascending: {next} comes after {before}; enter ascending values"
    )]
    Order { what: &'static str, before: f64, next: f64 },
    #[error("{value} is not a possible value of {what}; enter numbers from zero up")]
    Value { what: &'static str, value: f64 },
    #[error("{what} has {count} values, but at most {MAX_VALUES} can be tried; use a larger step")]
    TooMany { what: &'static str, count: f64 },
    #[error(
        "{f_ths} values of F_th and {t_ths} values of t_th make more pairs than the {MAX_PAIRS} that can be tried; use larger steps"
    )]
    TooManyPairs { f_ths: usize, t_ths: usize },
}

impl From<GridError> for AnalysisError {
    fn from(error: GridError) -> Self {
        Self::Because(error.to_string())
    }
}

/// Returns the values from `start` to `stop` in steps of `step`. `stop` is included if a step reaches it.
///
/// # Errors
/// [`GridError`] for a step that is not positive, a reversed range, or too many values.
pub fn even_values(
    what: &'static str,
    start: f64,
    stop: f64,
    step: f64,
) -> Result<Vec<f64>, GridError> {
    for value in [start, stop] {
        check_value(what, value)?;
    }
    if !(step > 0.0 && step.is_finite()) {
        return Err(GridError::Step { what, step });
    }
    if start > stop {
        return Err(GridError::Reversed { what, start, stop });
    }
    // Steps like 0.1 are not exact in binary numbers. Without the tolerance, rounding could lose the last value.
    let steps = ((stop - start) / step + 1e-9).floor();
    if steps >= MAX_VALUES as f64 {
        let count = steps + 1.0;
        return Err(GridError::TooMany { what, count });
    }
    let decimals = decimals_of(start).max(decimals_of(step));
    Ok((0..=steps as usize).map(|at| rounded(start + at as f64 * step, decimals)).collect())
}

fn rounded(value: f64, decimals: Option<usize>) -> f64 {
    let written = decimals.map(|decimals| format!("{value:.decimals$}"));
    written.and_then(|text| text.parse().ok()).unwrap_or(value)
}

/// Returns the number of decimal places of a value; `None` for more than nine.
fn decimals_of(value: f64) -> Option<usize> {
    Some(decimals(value)).filter(|decimals| *decimals <= 9)
}

fn check_value(what: &'static str, value: f64) -> Result<(), GridError> {
    if value >= 0.0 && value.is_finite() { Ok(()) } else { Err(GridError::Value { what, value }) }
}

impl ThresholdGrid {
    /// Creates the grid of all pairs of these thresholds.
    ///
    /// **Units** F_th in N or as a share of full scale; t_th in s.
    ///
    /// # Errors
    /// [`GridError`] for the first invalid value.
    pub fn new(f_ths: Vec<f64>, t_ths_secs: Vec<f64>) -> Result<Self, GridError> {
        for (what, values) in [("F_th", &f_ths), ("t_th", &t_ths_secs)] {
            if values.is_empty() {
                return Err(GridError::Empty { what });
            }
            if values.len() > MAX_VALUES {
                let count = values.len() as f64;
                return Err(GridError::TooMany { what, count });
            }
            values.iter().try_for_each(|&value| check_value(what, value))?;
            if let Some(pair) = values.windows(2).find(|pair| pair[0] >= pair[1]) {
                let (before, next) = (pair[0], pair[1]);
                return Err(GridError::Order { what, before, next });
            }
        }
        if f_ths.len() * t_ths_secs.len() > MAX_PAIRS {
            return Err(GridError::TooManyPairs { f_ths: f_ths.len(), t_ths: t_ths_secs.len() });
        }
        Ok(Self { f_ths, t_ths_secs })
    }

    /// Creates a grid for a sensor. `largest_distance` is the largest full scale of its axes, in the unit of F_th. The `n_f`
    /// force thresholds F_th go from zero to at least 1.2 times this full scale, in equal, round steps. The `n_t` time
    /// thresholds t_th go from half a second to a minute, each in the same ratio to the one before.
    ///
    /// # Errors
    /// [`GridError`] if `n_f` or `n_t` is zero or too large.
    pub fn covering(largest_distance: f64, n_f: usize, n_t: usize) -> Result<Self, GridError> {
        let reach = if largest_distance > 0.0 && largest_distance.is_finite() {
            1.2 * largest_distance
        } else {
            1.0
        };
        let step = round_step(reach / n_f.saturating_sub(1).max(1) as f64);
        let decimals = decimals_of(step);
        let f_ths = (0..n_f).map(|at| rounded(at as f64 * step, decimals)).collect();
        let (shortest, longest) = (0.5_f64, 60.0_f64);
        let ratio = (longest / shortest).powf(1.0 / n_t.saturating_sub(1).max(1) as f64);
        let t_ths_secs =
            (0..n_t).map(|at| rounded(shortest * ratio.powi(at as i32), Some(3))).collect();
        Self::new(f_ths, t_ths_secs)
    }

    /// Returns the row numbers of the grid (one row for each F_th) in levels from coarse to fine. Each level halves the
    /// distances between the rows so far. A map of errors computed in this order shows the whole range of F_th from the first
    /// level on.
    pub fn coarse_to_fine(&self) -> Vec<Vec<usize>> {
        let n = self.f_ths.len();
        let mut stride = 1;
        while n.div_ceil(stride) > COARSEST {
            stride *= 2;
        }
        let mut levels = vec![(0..n).step_by(stride).collect::<Vec<_>>()];
        if !(n - 1).is_multiple_of(stride) {
            levels[0].push(n - 1);
        }
        while stride > 1 {
            let half = stride / 2;
            let between = (half..n).step_by(stride);
            levels.push(between.filter(|at| !levels[0].contains(at)).collect());
            stride = half;
        }
        levels
    }
}

/// Error that the choice of thresholds or feature values minimises: that of one axis, or that of several axes in one number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// RMSE of the axis with this index, in the unit of the axis.
    Axis(usize),
    /// Root mean square of the RMSEs of the force axes (N).
    Forces,
    /// Root mean square of the RMSEs of the moment axes (N·m).
    Moments,
    /// Root mean square of the RMSEs of all axes, each in percent of its full scale. Axes without a full scale do not count.
    FullScale,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasureScale {
    /// Load axes of the sensor, in the order in which lists give the errors of the axes.
    pub axes: Vec<Axis>,
    pub full_scale: Vec<f64>,
}

impl MeasureScale {
    /// Returns all measures that exist for these axes: first those that combine several axes, then each axis alone.
    pub fn measures(&self) -> Vec<Measure> {
        let groups = [Measure::Forces, Measure::Moments, Measure::FullScale];
        let axes = (0..self.axes.len()).map(Measure::Axis);
        groups.into_iter().chain(axes).filter(|measure| measure.weights(self).is_some()).collect()
    }

    /// Returns the default measure: the error of the force axes or, without a force axis, of all axes in percent of full
    /// scale.
    pub fn default_measure(&self) -> Measure {
        if Measure::Forces.weights(self).is_some() { Measure::Forces } else { Measure::FullScale }
    }
}

impl Measure {
    /// Returns the weight of each axis' squared error in the measure; `None` if no axis of the sensor belongs to the measure.
    pub fn weights(self, scale: &MeasureScale) -> Option<Vec<f64>> {
        let weight = |(at, (axis, full)): (usize, (&Axis, &f64))| {
            let (counts, factor) = match self {
                Self::Axis(only) => (only == at, 1.0),
                Self::Forces => (axis.is_force(), 1.0),
                Self::Moments => (!axis.is_force(), 1.0),
                Self::FullScale => (*full > 0.0, 100.0 / full),
            };
            if counts { factor.powi(2) } else { 0.0 }
        };
        let axes = scale.axes.iter().zip(&scale.full_scale).enumerate();
        let mut weights: Vec<f64> = axes.map(weight).collect();
        let count = weights.iter().filter(|weight| **weight > 0.0).count();
        for weight in &mut weights {
            *weight /= count.max(1) as f64;
        }
        (count > 0).then_some(weights)
    }

    /// Returns the value of the measure, computed from the RMSE of each axis; `None` if no axis of the sensor belongs to it.
    pub fn of_rmse(self, scale: &MeasureScale, rmse: &[f64]) -> Option<f64> {
        let weights = self.weights(scale)?;
        let squares = weights.iter().zip(rmse).map(|(w, rmse)| w * rmse * rmse);
        Some(squares.sum::<f64>().sqrt())
    }

    pub(crate) fn unit(self, scale: &MeasureScale) -> &'static str {
        match self {
            Self::Axis(at) => scale.axes.get(at).map_or("", |axis| axis.unit()),
            Self::Forces => Axis::Fx.unit(),
            Self::Moments => Axis::Mx.unit(),
            Self::FullScale => "% FS",
        }
    }

    /// Returns the name with a capital letter.
    pub(crate) fn title(self, scale: &MeasureScale) -> &'static str {
        match self {
            Self::Forces => "Forces",
            Self::Moments => "Moments",
            Self::FullScale => "All axes",
            Self::Axis(_) => self.label(scale),
        }
    }

    pub(crate) fn label(self, scale: &MeasureScale) -> &'static str {
        match self {
            Self::Axis(at) => scale.axes.get(at).map_or("", |axis| axis.symbol()),
            Self::Forces => "forces",
            Self::Moments => "moments",
            Self::FullScale => "all axes",
        }
    }
}

/// Range of one threshold in which the cross-validation error is as low as the minimum: it is nowhere above the minimum with
/// 90 % confidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FlatRange {
    pub from: f64,
    pub to: f64,
    /// True if `from`, the lower end of the range, is the smallest tried value. Smaller values may then be as good.
    pub from_is_first_tried: bool,
    /// True if `to`, the upper end of the range, is the largest tried value. Larger values may then be as good.
    pub to_is_last_tried: bool,
}

impl FlatRange {
    pub fn in_words(&self, text: impl Fn(f64) -> String) -> String {
        let first = if self.from_is_first_tried { " (the first tried)" } else { "" };
        let last = if self.to_is_last_tried { " (the last tried)" } else { "" };
        if self.from == self.to {
            return text(self.from) + first + last;
        }
        format!("{}{first} to {}{last}", text(self.from), text(self.to))
    }
}

/// Pair of thresholds with the lowest cross-validation error in the map. Test recordings are not used.
///
/// A pair counts as good as the minimum unless its error is higher with 90 % confidence (see
/// [`ErrorBlocks::is_below`]). A range is the run of equally good values around the minimum, with the other threshold fixed.
/// Within the ranges, the choice hardly matters.
///
/// The error at the minimum is too low for new samples, because the lowest of many errors was chosen.
#[derive(Debug, PartialEq, Serialize)]
pub struct Suggestion {
    pub thresholds: Thresholds,
    /// Row and column of the minimum in the map.
    pub at: (usize, usize),
    /// Cross-validation error at the minimum.
    pub left_out: f64,
    pub conventional: f64,
    /// True if the fit is eligible by the rule that also chooses among models: its error is below that of the conventional
    /// calibration with 90 % confidence, and in no left-out part more than a tenth above it.
    pub beats_conventional: bool,
    /// Range of F_th that is as good as the suggested F_th, with t_th as suggested.
    pub f_th_range: FlatRange,
    /// Range of t_th that is as good as the suggested t_th, with F_th as suggested (s).
    pub t_th_range: FlatRange,
    pub n_parts: usize,
    /// True if cross-validation leaves out contiguous blocks of samples, because there are fewer than three training
    /// recordings.
    pub parts_are_blocks: bool,
    pub cross_validation: CrossValidation,
}

impl ThresholdMap {
    /// Returns the suggested thresholds for this measure of error, or an error if the map has no cross-validation
    /// errors of it.
    pub fn suggestion(&self, measure: Measure) -> Result<Suggestion, AnalysisError> {
        let weights = measure.weights(&self.scale).ok_or(AnalysisError::NoSuchAxis)?;
        let conventional = self
            .conventional_value(ScoreSet::LeftOut, measure)
            .ok_or(NoCrossValidation::FewSamples)?;
        let (at, left_out) =
            self.minimum(ScoreSet::LeftOut, measure).ok_or(AnalysisError::EmptyMap)?;
        let best = self.point(at.0, at.1).ok_or(AnalysisError::EmptyMap)?;
        let parts = ErrorBlocks::of_parts(&self.part_samples);
        let lowest = weighed(&best.left_out_squares, &weights);
        let is_worse = |point: &PointScores| {
            parts.is_below(&lowest, &weighed(&point.left_out_squares, &weights), 1.0)
        };
        let conventional_squares = weighed(&self.conventional.left_out_squares, &weights);
        let is_flat = |f_at: usize, t_at: usize| Some(!is_worse(self.point(f_at, t_at)?));
        Ok(Suggestion {
            thresholds: self.thresholds(at.0, at.1),
            at,
            left_out,
            conventional,
            beats_conventional: parts
                .choose(2, 0.0, |at| [&conventional_squares, &lowest][at])
                .refused[1]
                .is_none(),
            f_th_range: flat_range(&self.grid.f_ths, at.0, |f_at| is_flat(f_at, at.1)),
            t_th_range: flat_range(&self.grid.t_ths_secs, at.1, |t_at| is_flat(at.0, t_at)),
            n_parts: self.part_samples.len(),
            parts_are_blocks: self.cross_validation.is_by_block(),
            cross_validation: self.cross_validation.clone(),
        })
    }
}

impl Suggestion {
    /// Returns the suggested thresholds and their errors as a clause.
    pub fn in_words(&self, map: &ThresholdMap, measure: Measure) -> String {
        let (label, unit) = (measure.label(&map.scale), measure.unit(&map.scale));
        let [error, conventional] =
            [self.left_out, self.conventional].map(|rmse| significant(rmse, 4));
        let change = percent_change(self.conventional, self.left_out)
            .map_or_else(String::new, |change| format!(", {change:+.1} %"));
        let f_th = ShownFTh::of(map.distance).text(self.thresholds.f_th);
        let (t_th, how) = (self.thresholds.t_th_secs, &self.cross_validation);
        let doubt = if self.beats_conventional {
            ""
        } else {
            "; this is not below the uncompensated error with 90 % confidence, or more than a tenth above it in a left-out part"
        };
        format!(
            "cross-validation minimum of {label} at F_th {f_th} and t_th {t_th} s: error {error} {unit} (uncompensated: {conventional} \
             {unit}{change}; {how}){doubt}"
        )
    }

    /// Returns the ranges of equally good thresholds as a clause.
    pub fn ranges_in_words(&self, distance: Distance) -> String {
        let shown = ShownFTh::of(distance);
        let f_th = self.f_th_range.in_words(|f_th| shown.text(f_th));
        let t_th = self.t_th_range.in_words(|t_th_secs| format!("{t_th_secs} s"));
        format!("as good within the uncertainty: F_th {f_th}; t_th {t_th}")
    }
}

/// Returns the run of equally good values around the value with index `best`. Values without a result (`None`), from missing
/// rows of the map, are skipped.
fn flat_range(values: &[f64], best: usize, is_flat: impl Fn(usize) -> Option<bool>) -> FlatRange {
    let last_flat = |candidates: &mut dyn Iterator<Item = usize>| {
        let known = candidates.filter_map(|at| Some((at, is_flat(at)?)));
        let flat = known.take_while(|(_, flat)| *flat);
        flat.last().map_or(best, |(at, _)| at)
    };
    let from = last_flat(&mut (0..best).rev());
    let to = last_flat(&mut (best + 1..values.len()));
    FlatRange {
        from: values[from],
        to: values[to],
        from_is_first_tried: from == 0,
        to_is_last_tried: to + 1 == values.len(),
    }
}

#[cfg(test)]
mod tests {
    use crate::questions::thresholds::map::*;

    #[test]
    fn even_values_are_written_as_people_write_them() {
        assert_eq!(
            even_values("F_th", 0.0, 0.6, 0.1).unwrap(),
            [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
        );
        assert_eq!(even_values("t_th", 1.0, 6.0, 2.0).unwrap(), [1.0, 3.0, 5.0]);
        assert_eq!(even_values("t_th", 3.0, 3.0, 1.0).unwrap(), [3.0]);
    }

    #[test]
    fn invalid_grids_are_refused_with_a_remedy() {
        let even = |start, stop, step| even_values("F_th", start, stop, step);
        assert!(matches!(even(0.0, 1.0, 0.0), Err(GridError::Step { .. })));
        assert!(matches!(even(0.0, 1.0, f64::NAN), Err(GridError::Step { .. })));
        assert!(matches!(even(2.0, 1.0, 0.1), Err(GridError::Reversed { .. })));
        assert!(matches!(even(0.0, 1.0, 1e-9), Err(GridError::TooMany { .. })));
        assert!(matches!(even(-1.0, 1.0, 0.1), Err(GridError::Value { .. })));
        let lists = |f: &[f64], t: &[f64]| ThresholdGrid::new(f.to_vec(), t.to_vec());
        assert!(matches!(lists(&[], &[1.0]), Err(GridError::Empty { what: "F_th" })));
        assert!(matches!(lists(&[1.0], &[]), Err(GridError::Empty { what: "t_th" })));
        assert!(matches!(lists(&[1.0], &[5.0, 3.0]), Err(GridError::Order { .. })));
        assert!(matches!(lists(&[1.0, 1.0], &[5.0]), Err(GridError::Order { .. })));
        assert!(matches!(lists(&[1.0], &[f64::INFINITY]), Err(GridError::Value { .. })));
    }

    #[test]
    fn a_grid_that_would_fill_the_memory_is_refused() {
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        let error = ThresholdGrid::new(values.clone(), values.clone()).unwrap_err();
        assert!(error.to_string().contains("1000 values of F_th"), "{error}");
        assert!(ThresholdGrid::new(values, vec![1.0, 2.0]).is_ok());
    }

    #[test]
    fn coarse_to_fine_visits_all_and_halves_the_gaps() {
        for n in [1, 2, 3, 5, 6, 40, 41, 97] {
            let f_ths = (0..n).map(f64::from).collect();
            let grid = ThresholdGrid::new(f_ths, vec![1.0]).unwrap();
            let mut seen = Vec::new();
            let mut widest = n as usize;
            for level in grid.coarse_to_fine() {
                seen.extend(level);
                seen.sort_unstable();
                assert!(seen.contains(&0) && seen.contains(&(n as usize - 1)));
                let gap = seen.windows(2).map(|pair| pair[1] - pair[0]).max();
                assert!(gap.unwrap_or(1) <= widest.div_ceil(2), "{n}: {seen:?}");
                widest = gap.unwrap_or(1);
            }
            assert_eq!(seen, (0..n as usize).collect::<Vec<_>>());
        }
    }

    /// 12 N plus a fifth, in 39 steps, is 0.369 N per step. The next round step is 0.5 N.
    #[test]
    fn a_grid_covers_the_sensor_in_round_steps() {
        let grid = ThresholdGrid::covering(12.0, 40, 40).unwrap();
        assert_eq!(grid.f_ths[..3], [0.0, 0.5, 1.0]);
        assert_eq!((grid.f_ths.len(), grid.t_ths_secs.len()), (40, 40));
        assert_eq!((grid.t_ths_secs[0], grid.t_ths_secs[39]), (0.5, 60.0));
        let small = ThresholdGrid::covering(3e-4, 21, 1).unwrap();
        assert_eq!(small.f_ths[1], 2e-5);
        assert!(ThresholdGrid::covering(f64::NAN, 3, 3).is_ok());
        assert!(ThresholdGrid::covering(1.0, 0, 3).is_err());
    }
}

#[cfg(test)]
mod measure_tests {
    use crate::questions::thresholds::map::*;
    use crate::scoring::metrics::Group;

    fn scale() -> MeasureScale {
        MeasureScale { axes: vec![Axis::Fx, Axis::Fz, Axis::Mx], full_scale: vec![10.0, 20.0, 0.0] }
    }

    #[test]
    fn groups_are_those_of_the_table_of_errors() {
        let (scale, rmse) = (scale(), [1.0, 7.0, 9.0]);
        let of = |measure: Measure| measure.of_rmse(&scale, &rmse);
        assert_eq!(of(Measure::Forces), Group::Force.rmse(&scale.axes, &rmse));
        assert_eq!(of(Measure::Moments), Group::Moment.rmse(&scale.axes, &rmse));
        assert_eq!(of(Measure::Axis(1)), Some(7.0));
        assert_eq!(of(Measure::Axis(3)), None);
    }

    /// The errors are 10 % of 10 N and 35 % of 20 N: √((100 + 1225) / 2). The axis without a full scale does not count.
    #[test]
    fn full_scale_counts_each_axis_in_percent_of_its_own() {
        let value = Measure::FullScale.of_rmse(&scale(), &[1.0, 7.0, 9.0]);
        assert!((value.unwrap() - 662.5_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn only_measures_with_an_axis_are_offered() {
        let moment = MeasureScale { axes: vec![Axis::Mz], full_scale: vec![0.5] };
        assert_eq!(moment.measures(), [Measure::Moments, Measure::FullScale, Measure::Axis(0)]);
        assert_eq!(moment.default_measure(), Measure::FullScale);
        assert_eq!(scale().default_measure(), Measure::Forces);
    }
}

#[cfg(test)]
mod suggestion_tests {
    use crate::calibration::Scores;
    use crate::questions::thresholds::map::MeasureScale;
    use crate::questions::thresholds::map::ThresholdGrid;
    use crate::questions::thresholds::map::*;
    use crate::recording::Axis;

    /// Returns a point with these mean squared errors on four parts of ten samples.
    fn point(mean_squares: [f64; 4]) -> PointScores {
        let mean = mean_squares.iter().sum::<f64>() / 4.0;
        PointScores {
            scores: Scores {
                train_rmse: Some(vec![0.0]),
                test_rmse: None,
                cv_rmse: Some(vec![mean.sqrt()]),
            },
            left_out_squares: mean_squares.map(|square| 10.0 * square).to_vec(),
        }
    }

    fn map(rows: &[[f64; 4]]) -> ThresholdMap {
        let f_ths = (0..rows.len()).map(|at| at as f64).collect();
        let grid = ThresholdGrid::new(f_ths, vec![15.0]).unwrap();
        let scale = MeasureScale { axes: vec![Axis::Fz], full_scale: vec![10.0] };
        let mut map = ThresholdMap::new(grid, Distance::Force, scale, point(rows[0]), vec![10; 4]);
        for (at, row) in rows.iter().enumerate() {
            map.set_row(at, vec![point(*row)]);
        }
        map
    }

    /// The first row is without compensation, with an error of 3 N. The lowest error is 2 N. In the last row the look-back finds
    /// hardly any earlier sample.
    #[test]
    fn the_shades_reach_from_the_lowest_error_to_that_without_compensation() {
        let mut rows: Vec<[f64; 4]> = (0..40).map(|at| [4.0 + 0.01 * f64::from(at); 4]).collect();
        (rows[0], rows[1], rows[39]) = ([9.0; 4], [4.0; 4], [1e6; 4]);
        let map = map(&rows);
        let (set, measure) = (ScoreSet::LeftOut, Measure::Axis(0));
        assert_eq!(map.shades(set, measure), Some((2.0, 3.0)));
        assert!(map.value(set, measure, 39, 0).unwrap() > 3.0);
    }

    /// Row 3 is best. Row 2 alternates between better and worse: mean +0.05, far below its standard error. Row 4 is worse by
    /// 0.1 on every part, without spread. Row 5 would be as good, but lies beyond row 4. Row 1 is much worse.
    #[test]
    fn the_range_holds_neighbours_that_are_not_significantly_worse() {
        let map = map(&[
            [9.0, 9.0, 9.0, 9.1],
            [4.0, 4.1, 4.2, 4.0],
            [1.5, 0.6, 1.5, 0.6],
            [1.0, 1.0, 1.0, 1.0],
            [1.1, 1.1, 1.1, 1.1],
            [1.5, 0.6, 1.5, 0.6],
        ]);
        let found = map.suggestion(Measure::Forces).unwrap();
        assert_eq!((found.thresholds.f_th, found.left_out), (3.0, 1.0));
        assert_eq!((found.f_th_range.from, found.f_th_range.to), (2.0, 3.0));
        assert!(!found.f_th_range.from_is_first_tried && !found.f_th_range.to_is_last_tried);
        assert!(found.beats_conventional);
    }

    #[test]
    fn a_gain_that_may_be_luck_is_called_so() {
        let map = map(&[[1.5, 0.6, 1.5, 0.6], [1.0, 1.0, 1.0, 1.0]]);
        let found = map.suggestion(Measure::Forces).unwrap();
        assert!(!found.beats_conventional);
        assert!(found.f_th_range.from_is_first_tried && found.f_th_range.to_is_last_tried);
    }

    #[test]
    fn an_unfinished_map_suggests_among_its_computed_rows() {
        let full = map(&[[3.0; 4], [2.0; 4], [1.0; 4]]);
        let mut half = map(&[[3.0; 4], [2.0; 4], [1.0; 4]]);
        half.rows[2] = None;
        assert_eq!(full.suggestion(Measure::Forces).unwrap().thresholds.f_th, 2.0);
        assert_eq!(half.suggestion(Measure::Forces).unwrap().thresholds.f_th, 1.0);
        half.rows = vec![None; 3];
        assert_eq!(half.suggestion(Measure::Forces), Err(AnalysisError::EmptyMap));
        assert_eq!(half.suggestion(Measure::Moments), Err(AnalysisError::NoSuchAxis));
        half.conventional.scores.cv_rmse = None;
        assert_eq!(half.suggestion(Measure::Forces), Err(NoCrossValidation::FewSamples.into()));
    }
}
