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
        let first = 1 + a;
        let (square_of, cube_of) = (|gauge| first + gauge, |gauge| first + g + gauge);
        let (reading_of, width) = (|gauge| first + 2 * g + gauge, first + 3 * g);
        let mut sums = NormalEquations::new(width, 0);
        let mut row = vec![0.0; sums.stride()];
        units(recordings, self, is_used, &mut |gauges, loads| {
            row[0] = 1.0;
            row[1..=a].copy_from_slice(loads);
            for (gauge, value) in gauges.iter().enumerate() {
                let signal = signal(gauge, loads);
                row[square_of(gauge)] = signal.powi(2);
                row[cube_of(gauge)] = signal.powi(3);
                row[reading_of(gauge)] = *value;
            }
            sums.add_rows(&row);
        });
        let sums = faer::Mat::from_fn(width, width, |i, j| sums.feature_product(i, j));
        let curve = |gauge: usize| {
            let inputs: Vec<usize> = (0..first).chain([square_of(gauge), cube_of(gauge)]).collect();
            let reading = reading_of(gauge);
            let fit = Fit::of(&sums, &inputs, reading..reading + 1);
            [fit.map[(0, first)], fit.map[(0, first + 1)]]
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
