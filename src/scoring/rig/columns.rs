//! Finds columns of recordings that were loaded as gauges but are something else: the reference, or a constant.

use faer::Mat;

use crate::{
    finding::{Finding, Id, Verdict},
    recording::median,
    scoring::rig::{
        Rig,
        fits::{self, Forward, Moments},
    },
    shown::first_clauses,
};

/// Maximum residual of a column that counts as computed from the loads, as a share of its standard deviation, if several axes
/// move. Crosstalk, nonlinearity and noise of a real gauge leave a larger residual.
const EXACT: f64 = 3e-4;
/// Maximum residual of a column that counts as computed from the loads, as a share of its standard deviation, if one axis
/// moves. Even good load cells have residuals of some thousandths.
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
        let is_constant = |sums: &Mat<f64>, gauge: usize| {
            sums[(0, 0)] >= FEWEST_SAMPLES && deviation(sums, shape.gauge(gauge)) < MOVES
        };
        let mut found = Vec::new();
        for (gauge, name) in gauges.iter().enumerate() {
            let stands = |run: &usize| {
                let own = self.total(|of| of == *run);
                let moments = Moments::about(&own, &fits::column_means(&own), &forward, shape);
                let predicted = moments.sensitivity(gauge, &forward).1 / own[(0, 0)];
                is_constant(&own, gauge) && predicted > SHOULD_MOVE * SHOULD_MOVE
            };
            let run = (0..self.n_runs()).find(stands);
            if run.is_some() || is_constant(&all, gauge) {
                let place = run.map_or("all recordings", |run| &runs[run]);
                found
                    .push(format!("the gauge {name} has the same value in all samples of {place}"));
            }
        }
        let moving: Vec<usize> =
            (0..shape.n_gauges).filter(|gauge| !is_constant(&all, *gauge)).collect();
        for &gauge in moving.iter().filter(|gauge| left[**gauge].is_finite()) {
            let name = &gauges[gauge];
            if is_exact(gauge) && usual > OTHERS_LEAVE * left[gauge].max(exact / OTHERS_LEAVE) {
                found.push(format!(
                    "the gauge column {name} equals a linear combination of the reference loads"
                ));
            }
        }
        let seen = first_clauses(NAMED, &found);
        (!found.is_empty()).then(|| Finding::new(Id::NoGauge, Verdict::Doubtful, seen))
    }
}
