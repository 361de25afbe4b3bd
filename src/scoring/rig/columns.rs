//! Columns that are loaded as gauges but are none: the reference, a clock, a repeated gauge, a constant.

use faer::Mat;

use crate::recording::median;
use crate::scoring::rig::Rig;
use crate::scoring::rig::fits::{self, Forward, Moments};

/// Maximum residual of a gauge that is computed from the loads, as a share of its standard deviation, with several moving
/// axes. Crosstalk, curvature and noise of a sensor leave more.
const EXACT: f64 = 3e-4;
/// The same with one moving axis: good load cells leave some thousandths.
const EXACT_ON_ONE: f64 = 3e-5;
/// Minimum ratio of the other gauges' residuals to this residual.
const OTHERS_LEAVE: f64 = 10.0;
/// Maximum residual of a gauge that repeats another one, as a share of its standard deviation.
const SAME: f64 = 1e-5;
/// Maximum deviation of a clock from a straight line over time. A load deviates by more than ten times this.
const CLOCK: f64 = 5e-3;

/// Minimum standard deviation of a moving gauge in a run, relative to that of all its samples; rounding is smaller.
const MOVES: f64 = 1e-6;
/// Minimum standard deviation that the loads predict for a gauge that is reported as constant.
const SHOULD_MOVE: f64 = 0.1;
/// Minimum number of samples of a constant gauge.
const FEWEST_SAMPLES: f64 = 10.0;

/// Position of a column among the gauges, and its suspected kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoGauge {
    /// Computed from the reference.
    Reference(usize),
    /// A clock.
    Clock(usize),
    /// Repeats an earlier gauge.
    Copy(usize, usize),
    /// Has one value in all runs, or in one run.
    Constant(usize, Option<usize>),
}

impl Rig {
    /// Returns the columns that are no gauges; none if all follow from the reference, because the data are then computed.
    pub fn no_gauges(&self) -> Vec<NoGauge> {
        let shape = &self.shape;
        let all = self.total(|_| true);
        let deviation = |sums: &Mat<f64>, at: usize| {
            (fits::product(sums, at, at) / sums[(0, 0)]).max(0.0).sqrt()
        };
        let forward = Forward::of(&all, shape);
        let left: Vec<f64> = (forward.variances(&all, shape).iter().enumerate())
            .map(|(gauge, square)| square.sqrt() / deviation(&all, shape.gauge(gauge)))
            .collect();
        let exact = if shape.axes.len() > 1 { EXACT } else { EXACT_ON_ONE };
        let usual = median(left.iter().copied().filter(|own| *own > exact)).unwrap_or(0.0);
        let is_exact = |gauge: usize| left[gauge] <= exact;
        // Smallest share of a column that a straight line in time leaves in a run.
        let off_time = |at: usize| {
            let of_run = |run: usize| {
                let own = self.total(|of| of == run);
                let product = |i: usize, j: usize| fits::product(&own, i, j);
                let explained = product(at, 1).powi(2) / product(1, 1);
                (1.0 - explained / product(at, at)).max(0.0).sqrt()
            };
            (0..self.n_runs()).map(of_run).fold(0.0, f64::max)
        };
        let loads_move =
            (0..shape.axes.len()).all(|axis| off_time(shape.load(axis)) > 10.0 * CLOCK);
        let is_constant = |sums: &Mat<f64>, gauge: usize| {
            sums[(0, 0)] >= FEWEST_SAMPLES && deviation(sums, shape.gauge(gauge)) < MOVES
        };
        let mut found = Vec::new();
        for gauge in 0..shape.n_gauges {
            let stands = |run: &usize| {
                let own = self.total(|of| of == *run);
                let moments = Moments::about(&own, &fits::column_means(&own), &forward, shape);
                let predicted = moments.sensitivity(gauge, &forward).1 / own[(0, 0)];
                is_constant(&own, gauge) && predicted > SHOULD_MOVE * SHOULD_MOVE
            };
            let run = (0..self.n_runs()).find(stands);
            if run.is_some() || is_constant(&all, gauge) {
                found.push(NoGauge::Constant(gauge, run));
            }
        }
        let moving: Vec<usize> =
            (0..shape.n_gauges).filter(|gauge| !is_constant(&all, *gauge)).collect();
        for &gauge in moving.iter().filter(|gauge| left[**gauge].is_finite()) {
            let same = |other: &usize| {
                let [a, b] = [shape.gauge(gauge), shape.gauge(*other)];
                let product = |i: usize, j: usize| fits::product(&all, i, j);
                let both_exact = is_exact(gauge) && is_exact(*other);
                !both_exact
                    && 1.0 - product(a, b).powi(2) / (product(a, a) * product(b, b)) < SAME * SAME
            };
            if is_exact(gauge) && usual > OTHERS_LEAVE * left[gauge].max(exact / OTHERS_LEAVE) {
                found.push(NoGauge::Reference(gauge));
            } else if loads_move && off_time(shape.gauge(gauge)) < CLOCK {
                found.push(NoGauge::Clock(gauge));
            } else if let Some(&other) =
                moving.iter().filter(|own| **own < gauge).find(|own| same(own))
            {
                found.push(NoGauge::Copy(gauge, other));
            }
        }
        found
    }
}
