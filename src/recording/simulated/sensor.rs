//! Simulated sensor with six gauges on a resin body: computes gauge readings from the history of the load.
//!
//! A gauge reads, in mV/V, `offset + gain · (e + q e² + c e³ − h z + Σ aⱼ lowpass_τⱼ(e)) + noise`, where `e` is the elastic
//! strain (about 1 at the rated load) and `z` the hysteresis, which depends on the order of strains but not on their rate.
//! The hysteresis is bounded and every number finite.

use crate::random::Random;

/// Rated load of each axis (N, N·m): 12 N as in Koike et al. (2019), and a moment of our choice.
pub(super) const RATED_LOAD: [f64; 6] = [12.0, 12.0, 12.0, 0.25, 0.25, 0.25];

/// Elastic strain of each gauge (row) for the rated load of each axis (column). Each gauge responds mainly to one axis, as on
/// a cross-shaped body, with up to a quarter of crosstalk. The condition number is 1.39.
const ELASTICITY: [[f64; 6]; 6] = [
    [0.94, 0.11, -0.17, 0.06, 0.19, -0.04],
    [-0.13, 1.03, 0.14, -0.21, 0.05, 0.08],
    [0.16, -0.09, 0.98, 0.12, -0.07, 0.15],
    [0.05, 0.22, -0.10, 1.05, 0.13, -0.09],
    [-0.24, 0.07, 0.12, -0.06, 0.91, 0.17],
    [0.10, -0.14, 0.05, 0.18, -0.11, 1.08],
];

/// Half-width `h` of each gauge's hysteresis loop, as a strain. The values make the mean hysteresis equal to the 2.64 N of
/// Koike et al. (2019).
const HYSTERESIS: [f64; 6] = [0.154, 0.145, 0.163, 0.149, 0.159, 0.14];

/// Strain `1 / A` after a reversal, at which the hysteresis `z` has returned from its limit to 0. The strain is above `h`, so
/// that a reading follows the load right after a reversal.
const TURNOVER_STRAIN: f64 = 0.3;

/// Two components of the creep: for each, its share of the strain and its time constant (s).
const CREEP: [(f64, f64); 2] = [(0.05, 6.0), (0.06, 40.0)];

/// Coefficients of the square (for each gauge) and of the cube of the strain, which make a gauge slightly nonlinear.
const SQUARE: [f64; 6] = [0.031, -0.027, 0.036, 0.022, -0.032, 0.025];
const CUBE: f64 = -0.03;

/// Reading of each unloaded gauge, and gain per unit of strain (mV/V).
const OFFSET: [f64; 6] = [0.137, -0.082, 0.214, -0.156, 0.048, -0.191];
const GAIN: f64 = 0.8;

/// Standard deviation (mV/V) of the logger's white noise: 0.1 % of the reading at the rated load.
const NOISE: f64 = 0.0008;

/// Time (s) in which the weight is attached, before the start of a recording.
const ONSET_SECS: f64 = 5.0;

/// Hysteresis of one gauge: a Bouc-Wen element, `ż = A ẋ − β |ẋ| |z|ⁿ⁻¹ z − γ ẋ |z|ⁿ` with `n = 1` and `β = γ = A / 2`, so
/// that `|z| ≤ 1`. After a reversal, `z` returns to 0 at a constant rate and then nears its limit exponentially.
#[derive(Clone, Copy, Debug, Default)]
struct BoucWen {
    strain: f64,
    z: f64,
}

impl BoucWen {
    /// Changes the strain monotonically to this value, and returns the hysteresis `z`. The result is exact for any step
    /// length.
    fn go_to(&mut self, strain: f64) -> f64 {
        let step = strain - self.strain;
        self.strain = strain;
        if step != 0.0 {
            let limit = step.signum();
            let way = step.abs() / TURNOVER_STRAIN;
            let unwound = way.min((-limit * self.z).max(0.0));
            let z = self.z + limit * unwound;
            self.z = limit + (z - limit) * (unwound - way).exp();
        }
        self.z
    }
}

/// A first-order low-pass with a fixed time step, one component of the creep.
#[derive(Clone, Copy, Debug)]
struct LowPass {
    share: f64,
    value: f64,
}

impl LowPass {
    fn new(time_constant_secs: f64, step_secs: f64) -> Self {
        Self { share: -(-step_secs / time_constant_secs).exp_m1(), value: 0.0 }
    }

    /// Advances the low-pass by one time step with a constant input, and returns its output. The result is exact.
    fn step(&mut self, input: f64) -> f64 {
        self.value += self.share * (input - self.value);
        self.value
    }
}

#[derive(Clone, Debug)]
struct Gauge {
    index: usize,
    hysteresis: BoucWen,
    creep: [LowPass; 2],
}

impl Gauge {
    /// Returns the gauge's reading (mV/V) without noise after a monotonic change of the load to `load`.
    fn read(&mut self, load: &[f64; 6]) -> f64 {
        let i = self.index;
        let strain: f64 =
            (0..6).map(|axis| ELASTICITY[i][axis] * load[axis] / RATED_LOAD[axis]).sum();
        let lag = HYSTERESIS[i] * self.hysteresis.go_to(strain);
        let filters = self.creep.iter_mut().zip(CREEP);
        let crept: f64 =
            filters.map(|(filter, (amplitude, _))| amplitude * filter.step(strain)).sum();
        let curved = strain * (1.0 + strain * (SQUARE[i] + strain * CUBE));
        OFFSET[i] + GAIN * (curved - lag + crept)
    }
}

#[derive(Clone, Debug)]
pub(super) struct Sensor([Gauge; 6]);

impl Sensor {
    /// Creates a sensor that has never been loaded, and that is read once in each time step.
    pub fn relaxed(step_secs: f64) -> Self {
        Self::with_creep(CREEP.map(|(_, tau)| LowPass::new(tau, step_secs)))
    }

    /// Creates a sensor without creep that has never been loaded. Its readings depend only on the order of loads, not on
    /// time.
    #[cfg(test)]
    pub fn without_creep() -> Self {
        Self::with_creep([LowPass { share: 0.0, value: 0.0 }; 2])
    }

    fn with_creep(creep: [LowPass; 2]) -> Self {
        Self(std::array::from_fn(|index| Gauge { index, hysteresis: BoucWen::default(), creep }))
    }

    /// Changes the load monotonically to `load` within one time step, and returns the six readings (mV/V) without noise.
    pub fn read(&mut self, load: &[f64; 6]) -> [f64; 6] {
        self.0.each_mut().map(|gauge| gauge.read(load))
    }
}

/// Returns the gauge readings (mV/V) with noise, six for each load. The weight is attached in the [`ONSET_SECS`] before the
/// first sample.
pub(super) fn gauges_from_loads(loads: &[[f64; 6]], rate_hz: f64, random: &mut Random) -> Vec<f64> {
    let mut sensor = Sensor::relaxed(1.0 / rate_hz);
    let onset_steps = (ONSET_SECS * rate_hz).round() as usize;
    for k in 0..onset_steps {
        let part = k as f64 / onset_steps as f64;
        sensor.read(&loads[0].map(|axis| part * axis));
    }
    loads
        .iter()
        .flat_map(|load| sensor.read(load))
        .map(|reading| reading + NOISE * random.normal())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the hysteresis along the corner strains, with `steps` steps between two corners.
    fn followed(corners: &[f64], steps: usize) -> Vec<f64> {
        let mut element = BoucWen::default();
        corners
            .windows(2)
            .flat_map(|pair| {
                (1..=steps).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / steps as f64)
            })
            .map(|strain| element.go_to(strain))
            .collect()
    }

    #[test]
    fn hysteresis_does_not_depend_on_the_rate() {
        let corners = [0.0, 1.0, -0.6, 0.3, -1.0];
        let fast = followed(&corners, 7);
        let slow = followed(&corners, 70);
        for (f, s) in fast.iter().zip(slow.iter().skip(9).step_by(10)) {
            assert!((f - s).abs() < 1e-12);
        }
    }

    /// From −1 to 1, `z` keeps `exp(−2 / 0.5)` = 1.8 % of its distance from the limit, so the loop soon repeats.
    #[test]
    fn hysteresis_saturates_and_its_loop_closes() {
        let ends = followed(&[0.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0], 1);
        assert!((ends[6] - ends[4]).abs() < 1e-6 && (ends[5] - ends[3]).abs() < 1e-6);
        assert!(ends[6] > 0.9 && ends[5] < -0.9);
        let far = followed(&[0.0, 50.0, -50.0], 3);
        assert_eq!((far[2], far[5]), (1.0, -1.0));
    }

    /// After a unit step, a low-pass reaches `1 − 1/e` at its time constant.
    #[test]
    fn creep_settles_with_its_time_constants() {
        for (_, tau) in CREEP {
            let mut filter = LowPass::new(tau, 0.05);
            let steps = (tau / 0.05).round() as usize;
            let values: Vec<f64> = (0..20 * steps).map(|_| filter.step(1.0)).collect();
            assert!((values[steps - 1] - (1.0 - (-1.0_f64).exp())).abs() < 1e-9);
            assert!((values[20 * steps - 1] - 1.0).abs() < 1e-6);
        }
    }

    /// At equal load, the reading is greater while the load falls.
    #[test]
    fn readings_lag_behind_the_load() {
        for axis in 0..6 {
            let mut sensor = Sensor::without_creep();
            let mut at = |share: f64| {
                let mut load = [0.0; 6];
                load[axis] = share * RATED_LOAD[axis];
                sensor.read(&load)[axis]
            };
            at(-1.0);
            let rising = at(0.0);
            at(1.0);
            assert!(at(0.0) > rising);
        }
    }

    /// The rated load is held for 400 s, ten times the long time constant. Creep adds its shares with the sign of the strain.
    #[test]
    fn a_held_load_creeps_by_the_shares() {
        let load = [12.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let mut creeping = Sensor::relaxed(0.05);
        let mut stiff = Sensor::without_creep();
        let mut reading = [0.0; 6];
        for _ in 0..8000 {
            reading = creeping.read(&load);
        }
        let crept = reading[0] - stiff.read(&load)[0];
        assert!((crept / (GAIN * 0.11 * ELASTICITY[0][0]) - 1.0).abs() < 1e-3);
    }
}
