//! Finds a gauge that is nonlinear although the others are not, for example because its amplifier limits softly.

use std::iter;
use std::ops::Range;

use faer::Mat;

use crate::finding::{Finding, Id, Verdict};
use crate::min_max::MinMax;
use crate::recording::Recording;
use crate::scoring::numbers::percent;
use crate::scoring::rig::cause::{error, matters};
use crate::scoring::rig::fits::{FEWEST_RUNS, Shape};
use crate::scoring::rig::samples::Rest;
use crate::scoring::rig::{Rig, Unit, units};
use crate::scoring::straight_lines;

/// Values of a gauge beyond which a curve is tried. The gauge's range is −1 to 1.
const KNEES: [f64; 4] = [0.3, 0.5, 0.65, 0.8];
/// Number of columns that are computed for the curves of a gauge: its square and cube, and four for each knee.
const CURVES: usize = 2 + 4 * KNEES.len();
/// Maximum number of samples that are used, to save time.
const MOST_SAMPLES: usize = 20_000;
/// Minimum share of a gauge's squared residual, given the loads, that the curve of a reported gauge explains. Up to four
/// coefficients explain this share by chance if the load changes its direction forty times.
const EXPLAINED: f64 = 0.1;

/// Returns the columns of each curve: square and cube, and for each knee a bend above it, below its negative, or both.
fn curves() -> impl Iterator<Item = Range<usize>> {
    let of_knee = |first: usize| [first..first + 2, first + 2..first + 4, first..first + 4];
    iter::once(0..2).chain((2..CURVES).step_by(4).flat_map(of_knee))
}

/// Returns the columns for the curves of a gauge at this value.
fn curved(value: f64) -> impl Iterator<Item = f64> {
    let beyond = KNEES.into_iter().flat_map(move |knee| [value - knee, -value - knee]);
    let bends = beyond.flat_map(|own| [own.max(0.0), own.max(0.0).powi(2)]);
    [value.powi(2), value.powi(3)].into_iter().chain(bends)
}

impl Rig {
    /// Returns the finding that a curve of one gauge reduces the held-out error, and more than the squares and cubes of all
    /// other gauges do in addition. If all gauges are nonlinear, it is a property of the sensor and no fault. With fewer than
    /// three recordings, hysteresis can look like a curve.
    pub(super) fn bent(&self, recordings: &[&Recording], rests: &[Rest]) -> Option<Finding> {
        let n = self.shape.n_gauges;
        if n < 2 || self.n_runs() < FEWEST_RUNS {
            return None;
        }
        let of_gauge = |gauge: usize| {
            let all = self.with_curves(recordings, gauge);
            let error_of = |curve: Range<usize>| self.error_with(&all, curve.collect());
            let tried = curves().map(|own| (error_of(own.clone()), own));
            let (without, curve) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
            Some((gauge, curve, error_of(0..0), without, all))
        };
        let best = (0..n).filter_map(of_gauge).min_by(|a, b| a.3.total_cmp(&b.3));
        let (gauge, curve, with, without, all) = best?;
        let of_others = CURVES..CURVES + 2 * (n - 1);
        let without_any = self.error_with(&all, curve.clone().chain(of_others).collect());
        let seen = format!(
            "the gauge {} is nonlinear, but the other gauges are not",
            recordings[0].gauge_names()[gauge]
        );
        let figures = format!(
            "if a curve is fitted to this gauge, the held-out error is {} instead of {} of full scale",
            percent(without),
            percent(with)
        );
        let is_alone = with - without > without - without_any;
        (is_alone && matters(with, without) && self.bends(rests, gauge, curve)).then(|| {
            let found = Finding::new(Id::Bent, Verdict::Doubtful, seen);
            found.with(figures).costing(with - without)
        })
    }

    /// Returns sums of products that also contain the curves of one gauge, and the squares and cubes of the others.
    fn with_curves(&self, recordings: &[&Recording], gauge: usize) -> Vec<Unit> {
        let n = self.shape.n_gauges;
        let values = recordings.iter().flat_map(|own| own.gauges()[gauge..].iter().step_by(n));
        let (low, high) = values.copied().collect::<MinMax>().ends().unwrap_or((0.0, 0.0));
        let columns = |gauges: &[f64], row: &mut Vec<f64>| {
            row.extend(self.standard(gauges));
            let value = (2.0 * gauges[gauge] - low - high) / (high - low).max(f64::MIN_POSITIVE);
            row.extend(curved(value));
            let others = self.standard(gauges).enumerate().filter(|own| own.0 != gauge);
            row.extend(others.flat_map(|(_, own)| [own.powi(2), own.powi(3)]));
        };
        let shape = Shape { n_gauges: n + CURVES + 2 * (n - 1), ..self.shape.clone() };
        let n_samples: usize = recordings.iter().map(|own| own.n_samples()).sum();
        let step = n_samples.div_ceil(MOST_SAMPLES);
        units(recordings, &self.runs, &shape, columns, |_, k| k % step == 0)
    }

    /// Returns true if this curve also reduces the residual of the gauge, if the gauge is predicted from the loads. If it does
    /// not, the gauge only shows which of several loads is present.
    fn bends(&self, rests: &[Rest], gauge: usize, curve: Range<usize>) -> bool {
        let n = self.shape.n_gauges;
        let of_gauge = |values: fn(&Rest) -> &[f64]| -> Vec<f64> {
            let all = rests.iter().flat_map(|own| values(own)[gauge..].iter().step_by(n));
            all.copied().collect()
        };
        let (fitted, left) = (of_gauge(|own| &own.fitted), of_gauge(|own| &own.left));
        let ends: MinMax = fitted.iter().copied().collect();
        let (low, high) = ends.ends().unwrap_or((0.0, 0.0));
        let column = |k: usize, i: usize| {
            let value = (2.0 * fitted[k] - low - high) / (high - low).max(f64::MIN_POSITIVE);
            match i {
                0 => 1.0,
                1 => value,
                _ => curved(value).nth(curve.start + i - 2).unwrap_or(0.0),
            }
        };
        let squares = |columns: usize| {
            let factors =
                straight_lines::factors(left.len(), columns, (0, 0.0), column, |k| left[k]);
            let explained = |k| (0..columns).map(|i| factors[i] * column(k, i)).sum::<f64>();
            (0..left.len()).map(|k| (left[k] - explained(k)).powi(2)).sum::<f64>()
        };
        squares(2 + curve.len()) < (1.0 - EXPLAINED) * squares(2)
    }

    /// Returns the held-out error with these columns of [`Rig::with_curves`].
    fn error_with(&self, all: &[Unit], added: Vec<usize>) -> f64 {
        let n = self.shape.n_gauges;
        let shape = Shape { n_gauges: n + added.len(), ..self.shape.clone() };
        let loads = 2 + n + CURVES + 2 * (n - 1);
        let columns = (0..2 + n).chain(added.into_iter().map(|own| 2 + n + own));
        let columns: Vec<usize> = columns.chain(loads..loads + self.shape.axes.len()).collect();
        let part = |own: &Unit| {
            let at = |i: usize, j: usize| own.sums[(columns[i], columns[j])];
            Unit { run: own.run, sums: Mat::from_fn(columns.len(), columns.len(), at) }
        };
        error(&all.iter().map(part).collect::<Vec<_>>(), &shape)
    }
}
