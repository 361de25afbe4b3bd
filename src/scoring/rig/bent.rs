//! Finds a gauge that is more nonlinear than the others, for example because its amplifier limits softly.

use rayon::prelude::*;

use crate::finding::{Finding, Id, Verdict};
use crate::min_max::MinMax;
use crate::recording::Recording;
use crate::scoring::numbers::percent;
use crate::scoring::rig::Rig;
use crate::scoring::rig::cause::matters;
use crate::scoring::rig::fits::FEWEST_RUNS;
use crate::scoring::rig::samples::Rest;
use crate::scoring::straight_lines;

/// Values of a gauge, scaled to the range −1 to 1, beyond which a tried curve bends.
const KNEES: [f64; 5] = [0.0, 0.3, 0.5, 0.65, 0.8];
/// Ends of a gauge's range at which a tried curve bends: the upper end (1), the lower end (−1), or both.
const ENDS: [&[f64]; 3] = [&[1.0], &[-1.0], &[1.0, -1.0]];
/// Maximum number of samples from which held-out errors are computed, to save time.
const MOST_SAMPLES: usize = 5_000;
/// Minimum share of a gauge's squared residual, given the loads, that the curve of a reported gauge explains. Up to four
/// coefficients explain this share by chance if the load changes its direction forty times.
const EXPLAINED: f64 = 0.1;

/// Curve of a gauge: one of the [`KNEES`] and one entry of [`ENDS`].
type Curve = (f64, &'static [f64]);

/// Returns the columns of a curve for a value of the gauge within `ends`: on each bent end, the excess over the knee and its
/// square.
fn curved(value: f64, ends: MinMax, (knee, signs): Curve) -> impl Iterator<Item = f64> {
    let value = (2.0 * value - ends.min - ends.max) / ends.span().max(f64::MIN_POSITIVE);
    signs.iter().flat_map(move |sign| {
        let over = (sign * value - knee).max(0.0);
        [over, over * over]
    })
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
        let n_samples: usize = recordings.iter().map(|own| own.n_samples()).sum();
        let step = n_samples.div_ceil(MOST_SAMPLES);
        let is_used = |_, k: usize| k.is_multiple_of(step);
        let ends = |gauge: usize| -> MinMax {
            let values = recordings.iter().flat_map(|own| own.gauges()[gauge..].iter().step_by(n));
            values.copied().collect()
        };
        let ends: Vec<MinMax> = (0..n).map(ends).collect();
        let error_of = |gauge: usize, curve: Curve, with_others: bool| {
            let added = |gauges: &[f64], row: &mut Vec<f64>| {
                row.extend(curved(gauges[gauge], ends[gauge], curve));
                let others = self.standard(gauges).enumerate();
                let others = others.filter(|own| with_others && own.0 != gauge);
                row.extend(others.flat_map(|(_, own)| [own.powi(2), own.powi(3)]));
            };
            let n_others = if with_others { n - 1 } else { 0 };
            self.error_of(recordings, 2 * (curve.1.len() + n_others), added, is_used)
        };
        let curves = KNEES.iter().flat_map(|knee| ENDS.map(|ends| (*knee, ends)));
        let tried: Vec<_> = curves.flat_map(|own| (0..n).map(move |gauge| (gauge, own))).collect();
        let errors = tried.par_iter().map(|own| (error_of(own.0, own.1, false), *own));
        let (without, (gauge, curve)) = errors.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let with = self.error_of(recordings, 0, |_, _| (), is_used);
        let is_found = matters(with, without)
            && with - without > without - error_of(gauge, curve, true)
            && self.bends(rests, gauge, curve);
        let seen = format!(
            "the gauge {} is more nonlinear than the other gauges",
            recordings[0].gauge_names()[gauge]
        );
        let figures = format!(
            "if a curve is fitted to this gauge, the held-out error is {} instead of {} of full scale",
            percent(without),
            percent(with)
        );
        let found = Finding::new(Id::Bent, Verdict::Doubtful, seen);
        is_found.then(|| found.with(figures).costing(with - without))
    }

    /// Returns true if this curve also reduces the residual of the gauge, if the gauge is predicted from the loads. If it does
    /// not, the gauge only shows which of several loads is present.
    fn bends(&self, rests: &[Rest], gauge: usize, curve: Curve) -> bool {
        let of_gauge = |values: fn(&Rest) -> &[f64]| -> Vec<f64> {
            let n = self.shape.n_gauges;
            let all = rests.iter().flat_map(|own| values(own)[gauge..].iter().step_by(n));
            all.copied().collect()
        };
        let (fitted, left) = (of_gauge(|own| &own.fitted), of_gauge(|own| &own.left));
        let ends: MinMax = fitted.iter().copied().collect();
        let column = |k: usize, i: usize| {
            let line = [1.0, fitted[k]].into_iter();
            line.chain(curved(fitted[k], ends, curve)).nth(i).unwrap_or(0.0)
        };
        let squares = |columns: usize| {
            let factors =
                straight_lines::factors(left.len(), columns, (0, 0.0), column, |k| left[k]);
            let explained = |k| (0..columns).map(|i| factors[i] * column(k, i)).sum::<f64>();
            (0..left.len()).map(|k| (left[k] - explained(k)).powi(2)).sum::<f64>()
        };
        squares(2 + 2 * curve.1.len()) < (1.0 - EXPLAINED) * squares(2)
    }
}
