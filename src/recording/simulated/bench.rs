//! Simulated calibration bench: loads one axis at a time, in repeated cycles and in steps with dwells.

use super::sensor::RATED_LOAD;
use crate::recording::axis::Axis;

/// Time from zero to the rated load in the repeated cycles (s).
const RAMP_SECS: f64 = 5.0;
/// Number of load cycles, each to the rated load in both directions.
const CYCLES: usize = 4;
/// Load steps as shares of the rated load. The last step is held longest.
const STEPS: [f64; 4] = [0.2, 0.4, 0.6, 0.8];
/// Time for the change from one load step to the next, and time for which a step is held (s).
const STEP_SECS: (f64, f64) = (1.0, 8.0);
/// Time for which the largest load step is held, and time without load after the steps (s).
const LONG_SECS: f64 = 60.0;
/// Time without load before the first cycle (s).
const REST_SECS: f64 = 10.0;

pub(super) fn loads(axis: Axis, rate_hz: f64) -> Vec<[f64; 6]> {
    let mut shares = Shares { rate_hz, shares: vec![0.0] };
    shares.hold(REST_SECS);
    for _ in 0..CYCLES {
        shares.go_to(1.0, RAMP_SECS * (1.0 - shares.last()));
        shares.go_to(-1.0, 2.0 * RAMP_SECS);
    }
    shares.go_to(0.0, RAMP_SECS);
    shares.hold(LONG_SECS);
    for step in STEPS {
        shares.go_to(step, STEP_SECS.0);
        shares.hold(STEP_SECS.1);
    }
    shares.hold(LONG_SECS);
    for step in STEPS.into_iter().rev().skip(1).chain([0.0]) {
        shares.go_to(step, STEP_SECS.0);
        shares.hold(STEP_SECS.1);
    }
    shares.hold(LONG_SECS);
    let load = |share: &f64| {
        let mut load = [0.0; 6];
        load[axis as usize] = share * RATED_LOAD[axis as usize];
        load
    };
    shares.shares.iter().map(load).collect()
}

struct Shares {
    rate_hz: f64,
    shares: Vec<f64>,
}

impl Shares {
    fn last(&self) -> f64 {
        self.shares.last().copied().unwrap_or(0.0)
    }

    fn go_to(&mut self, share: f64, secs: f64) {
        let (from, n) = (self.last(), (secs * self.rate_hz).round() as usize);
        let way = |k| from + (share - from) * k as f64 / n as f64;
        self.shares.extend((1..=n).map(way));
    }

    fn hold(&mut self, secs: f64) {
        self.go_to(self.last(), secs);
    }
}
