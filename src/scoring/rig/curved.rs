//! Held-out error of gauges that are straightened: without the squares and cubes of the signals that their loads predict.

use crate::{
    calibration::NormalEquations,
    recording::Recording,
    scoring::rig::{Rig, cause::error, fits::Fit, units},
};

/// Approximate number of samples from which the curves of the gauges are fitted.
const ENOUGH_SAMPLES: usize = 20_000;

impl Rig {
    /// Returns the held-out error of the loads after each gauge was straightened. A curve of all recordings may look like a
    /// changed sensitivity of those with other loads.
    pub fn error_when_straight(&self, recordings: &[&Recording]) -> f64 {
        let shape = &self.shape;
        let (g, a) = (shape.n_gauges, shape.axes.len());
        let linear = Fit::forward(&self.total(|_| true), shape);
        let signal = |gauge: usize, loads: &[f64]| -> f64 {
            loads.iter().enumerate().map(|(at, load)| linear.map[(gauge, 1 + at)] * load).sum()
        };
        let n: usize = recordings.iter().map(|own| own.n_samples()).sum();
        let step = n.div_ceil(ENOUGH_SAMPLES).max(1);
        let is_used = |_, sample: usize| sample.is_multiple_of(step);
        // Columns: one, loads, squares, cubes, gauges.
        let mut sums = NormalEquations::new(1 + a + 3 * g, 0);
        let mut row = vec![0.0; sums.stride()];
        units(recordings, self, is_used, &mut |gauges, loads| {
            row[0] = 1.0;
            row[1..=a].copy_from_slice(loads);
            for (gauge, value) in gauges.iter().enumerate() {
                let signal = signal(gauge, loads);
                row[1 + a + gauge] = signal.powi(2);
                row[1 + a + g + gauge] = signal.powi(3);
                row[1 + a + 2 * g + gauge] = *value;
            }
            sums.add_rows(&row);
        });
        let width = 1 + a + 3 * g;
        let sums = faer::Mat::from_fn(width, width, |i, j| sums.feature_product(i, j));
        let curve = |gauge: usize| {
            let curved = [1 + a + gauge, 1 + a + g + gauge];
            let inputs: Vec<usize> = (0..=a).chain(curved).collect();
            let own = 1 + a + 2 * g + gauge;
            let fit = Fit::of(&sums, &inputs, own..own + 1);
            [fit.map[(0, 1 + a)], fit.map[(0, 2 + a)]]
        };
        let curves: Vec<[f64; 2]> = (0..g).map(curve).collect();
        let straight = units(recordings, self, is_used, &mut |gauges, loads| {
            for (gauge, (value, [square, cube])) in gauges.iter_mut().zip(&curves).enumerate() {
                let signal = signal(gauge, loads);
                *value -= square * signal.powi(2) + cube * signal.powi(3);
            }
        });
        error(&straight, shape)
    }
}
