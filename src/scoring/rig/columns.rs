//! Columns that are taken for gauges and are none: the reference again, a clock, a gauge that is there twice, a constant.

use faer::Mat;

use crate::recording::median;
use crate::scoring::rig::Rig;
use crate::scoring::rig::fits::{self, Forward};

/// Share of a gauge's standard deviation that loads leave of it, below which it follows from them to rounding: no sensor is so free of
/// crosstalk, curvature and noise where several axes move.
const EXACT: f64 = 3e-4;
/// The same where one axis moves: good load cells come to a part in some thousands.
const EXACT_ON_ONE: f64 = 3e-5;
/// The other gauges leave this many times more.
const OTHERS_LEAVE: f64 = 10.0;
/// Share of a gauge's standard deviation that another leaves of it where it is the same one.
const SAME: f64 = 1e-5;
/// A clock stays this near to a straight line over time, a load farther than ten times this.
const CLOCK: f64 = 5e-3;

/// Deviation of a gauge, over that of all its samples, from which it moves; rounding is smaller.
const MOVES: f64 = 1e-6;
/// Deviation that loads say a gauge has where it is reported as constant.
const SHOULD_MOVE: f64 = 0.1;
/// Fewest samples of a constant gauge.
const FEWEST_SAMPLES: f64 = 10.0;

/// A gauge by its position, and what it seems to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoGauge {
    /// It follows from the reference to rounding.
    Reference(usize),
    /// It follows the time.
    Clock(usize),
    /// It is an earlier gauge again.
    Copy(usize, usize),
    /// It has one value in all runs, or in one.
    Constant(usize, Option<usize>),
}

impl Rig {
    /// Gauges that seem to be none. Where all follow from the reference, the data are computed ones, and nothing is found.
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
        // Least share of a column that a straight line in time leaves in a run.
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
                let [sum, squares, _] =
                    forward.said(&own, shape, gauge).map(|all| all / own[(0, 0)]);
                is_constant(&own, gauge) && squares - sum * sum > SHOULD_MOVE * SHOULD_MOVE
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
