//! Simulated robot arm: turns the sensor along a path of attitudes, and computes the load of the weight along the path. Roll,
//! pitch and their rates are continuous. A path is the same curve at every speed.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::{
    random::Random,
    recording::kinetics::{Weight, gravity_load, rotation_from_roll_pitch_yaw},
};

/// Mass of the weight in Koike et al. (2019, section 4.1.2).
pub(super) const MASS_KG: f64 = 1.128;

/// Mounting points of the weight (m): the centre, then the four points (±0.02 m, ±0.015 m) of Koike et al. (2019). The points
/// lie in the sensor's plane, so a weight at the centre causes no moment.
pub(super) const MOUNTS_M: [[f64; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [0.02, 0.015, 0.0],
    [-0.02, 0.015, 0.0],
    [-0.02, -0.015, 0.0],
    [0.02, -0.015, 0.0],
];

/// Length of a path in cycles of roll and pitch: 95 s at 0.05 Hz, as in the fast run.
pub(super) const CYCLES: f64 = 4.75;

/// Number of random amplitudes of an angle: one for the start of each cycle, and one for the end of
/// the last complete cycle.
const N_KNOTS: usize = 6;

/// Course of roll or pitch: a sinusoid whose amplitude changes smoothly from cycle to cycle.
struct Swing {
    phase: f64,
    amplitudes: [f64; N_KNOTS],
}

impl Swing {
    fn angle(&self, cycle: f64) -> f64 {
        let knot = (cycle as usize).min(N_KNOTS - 2);
        let along = cycle - knot as f64;
        // The amplitude follows a raised cosine, whose slope is zero at its ends. So the rates of amplitude and angle are
        // continuous.
        let blend = 0.5 - 0.5 * (PI * along).cos();
        let (from, to) = (self.amplitudes[knot], self.amplitudes[knot + 1]);
        (from + (to - from) * blend) * (self.phase + TAU * cycle).sin()
    }
}

pub(super) struct Path {
    roll: Swing,
    pitch: Swing,
}

impl Path {
    /// Creates the random path with this index and seed. Roll covers up to ±170° and pitch up to ±86°, so that gravity
    /// reaches nearly every direction. Pitch lags roll by 30° to 150° of phase on odd paths, and leads roll on even paths.
    /// With equal phases, a path would go back the way it came. With one sign on all paths, the load of one axis would
    /// predict another axis's hysteresis.
    pub fn new(seed: u64, path: u64) -> Self {
        let mut random = Random::new(seed, &[path]);
        let phase = random.between(0.0, TAU);
        let sense = if path % 2 == 1 { 1.0 } else { -1.0 };
        let lag = sense * random.between(PI / 6.0, 5.0 * PI / 6.0);
        let mut swing = |phase, low, high| Swing {
            phase,
            amplitudes: std::array::from_fn(|_| random.between(low, high)),
        };
        Self {
            roll: swing(phase, PI / 4.0, 0.95 * PI),
            pitch: swing(phase - lag, 0.1 * FRAC_PI_2, 0.95 * FRAC_PI_2),
        }
    }

    /// Returns the loads (N, N·m) of `n_samples` evenly spaced samples along the path, with the weight's centre at
    /// `centre_m`.
    pub fn loads(&self, n_samples: usize, centre_m: [f64; 3]) -> Vec<[f64; 6]> {
        let weight = Weight { mass_kg: MASS_KG, centre_m };
        (0..n_samples)
            .map(|k| {
                let cycle = CYCLES * k as f64 / n_samples as f64;
                let (roll, pitch) = (self.roll.angle(cycle), self.pitch.angle(cycle));
                gravity_load(&rotation_from_roll_pitch_yaw(roll, pitch, 0.0), &weight)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::kinetics::STANDARD_GRAVITY;

    /// In 1e-6 cycles, the angle changes by less than 2π · 0.95π · 1e-6 < 2e-5 rad, and the rate by less than 1e-6 of
    /// (2π)² · 0.95π < 120 plus the change of the amplitude.
    #[test]
    fn angle_and_rate_are_continuous_at_the_knots() {
        let step = 1e-6;
        for path in 1..=6 {
            let path = Path::new(1, path);
            for knot in 1..=4 {
                let at = |side: f64| path.roll.angle(f64::from(knot) + side * step);
                assert!((at(1.0) - at(-1.0)).abs() < 4e-5);
                let (before, after) = (at(0.0) - at(-1.0), at(1.0) - at(0.0));
                assert!((after - before).abs() / step < 1e-3);
            }
        }
    }

    #[test]
    fn the_same_path_at_another_speed_meets_the_same_loads() {
        let path = Path::new(3, 2);
        let fast = path.loads(1900, MOUNTS_M[1]);
        let slow = path.loads(3800, MOUNTS_M[1]);
        assert!(fast.iter().zip(slow.iter().step_by(2)).all(|(f, s)| f == s));
    }

    #[test]
    fn every_force_axis_swings_through_most_of_the_weight_both_ways() {
        let most = 0.8 * MASS_KG * STANDARD_GRAVITY;
        for seed in 0..20 {
            let loads: Vec<_> =
                (1..=5).flat_map(|path| Path::new(seed, path).loads(1900, MOUNTS_M[0])).collect();
            for axis in 0..3 {
                assert!(loads.iter().any(|load| load[axis] > most));
                assert!(loads.iter().any(|load| load[axis] < -most));
            }
        }
    }
}
