//! Finds columns of recordings that were loaded as gauges but are something else: the reference, or a constant.

use faer::Mat;

use crate::{
    finding::{Finding, Id, Verdict},
    recording::median,
    scoring::rig::{
        Rig,
        fits::{self, Fit, Moments},
    },
    shown::first_clauses,
};

/// Maximum residual of a column that counts as computed from the loads, as a share of its standard deviation, if several axes
/// move, and if one axis moves. Crosstalk, nonlinearity and noise of a real gauge leave a larger residual; that of good load
/// cells is some thousandths.
const EXACT: f64 = 3e-4;
const EXACT_ON_ONE: f64 = 3e-5;
/// Minimum ratio of the median residual of the real gauges to the residual of a column that counts as computed from the
/// loads.
const OTHERS_LEAVE: f64 = 10.0;
/// Standard deviation of a gauge below which it counts as constant, as a share of its standard deviation in all recordings.
/// Rounding errors are smaller than this.
const MOVES: f64 = 1e-6;
/// Minimum standard deviation that the loads predict for a gauge whose constant value is reported. It is a share of the
/// gauge's standard deviation in all recordings.
const SHOULD_MOVE: f64 = 0.1;
/// Minimum number of samples with the same value for the report that a gauge is constant.
const FEWEST_SAMPLES: f64 = 10.0;
/// Maximum number of columns that the finding names.
const NAMED: usize = 6;

impl Rig {
    /// Returns the finding that columns are probably no gauges. The names of the gauges and of the runs are given. If all
    /// columns follow exactly from the reference, the gauges were computed from the loads, and there is no finding.
    pub fn no_gauges(&self, gauges: &[String], runs: &[String]) -> Option<Finding> {
        let shape = &self.shape;
        let all = self.total(|_| true);
        let fit = Fit::forward(&all, shape);
        let variance = |sums: &Mat<f64>, gauge: usize| {
            let (n, at) = (sums[(0, 0)], shape.gauge(gauge));
            (sums[(at, at)] / n - (sums[(0, at)] / n).powi(2)).max(0.0)
        };
        let is_constant = |sums: &Mat<f64>, gauge: usize| {
            sums[(0, 0)] >= FEWEST_SAMPLES && variance(sums, gauge) < MOVES * MOVES
        };
        let left = fit.variances(&all).into_iter().enumerate();
        let left = left.map(|(gauge, square)| (square / variance(&all, gauge)).sqrt());
        let left: Vec<f64> = left.collect();
        let exact = if shape.axes.len() > 1 { EXACT } else { EXACT_ON_ONE };
        let usual = median(left.iter().copied().filter(|left| *left > exact)).unwrap_or(0.0);
        let mut found = Vec::new();
        for (gauge, name) in gauges.iter().enumerate() {
            let stands = |run: &usize| {
                let sums = self.total(|of| of == *run);
                let moments = Moments::about(&sums, &fits::column_means(&sums), &fit, shape);
                let predicted = moments.sensitivity(gauge, &fit).1 / sums[(0, 0)];
                is_constant(&sums, gauge) && predicted > SHOULD_MOVE * SHOULD_MOVE
            };
            let is_copy = left[gauge] <= exact
                && usual > OTHERS_LEAVE * left[gauge].max(exact / OTHERS_LEAVE);
            if is_constant(&all, gauge) {
                found.push(format!("the gauge {name} has the same value in all samples"));
            } else if let Some(run) = (0..self.n_runs()).find(stands) {
                let run = &runs[run];
                found.push(format!("the gauge {name} has the same value in all samples of {run}"));
            } else if is_copy {
                found.push(format!(
                    "the gauge column {name} equals a linear combination of the reference loads"
                ));
            }
        }
        let seen = first_clauses(NAMED, &found);
        (!found.is_empty()).then(|| Finding::new(Id::NoGauge, Verdict::Doubtful, seen))
    }
}
