//! Bouc-Wen benchmark of nonlinear system identification. The program chooses a model that computes the displacement of an
//! oscillator with hysteresis from the force.
//!
//! `cargo bench --bench bouc_wen` integrates the oscillator and searches a model on multisines. The bench prints the model's RMS
//! errors on an unseen multisine and an unseen swept sine, beside published errors.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::{Duration, Instant};

use loopscope::calibration::FitSettings;
use loopscope::progress::Progress;
use loopscope::questions::{Request, Search, WITHIN, find_best, train};
use loopscope::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

/// Sample rate after decimation (Hz).
const RATE: f64 = 750.0;
const STEPS: usize = 20;
/// Number of samples of a multisine.
const SAMPLES: usize = 8_192;
/// Factor from metres to millimetres, the unit of the displacements in the recordings.
const MILLIMETRES: f64 = 1e3;

/// Mass (kg), damping (N s/m) and stiffness (N/m) of the oscillator.
const MASS: f64 = 2.0;
const DAMPING: f64 = 10.0;
const STIFFNESS: f64 = 5e4;
/// Parameters of the hysteresis; its exponent ν is 1.
const ALPHA: f64 = 5e4;
const BETA: f64 = 1e3;
const GAMMA: f64 = 0.8;
const DELTA: f64 = -1.1;

/// Generator of random numbers (xorshift64*). The numbers are the same on every machine.
struct Numbers(u64);

impl Numbers {
    fn share(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.share().max(1e-300).ln()).sqrt() * (TAU * self.share()).cos()
    }
}

/// Returns the time derivatives of displacement, velocity and hysteretic force.
fn change([y, v, z]: [f64; 3], force: f64) -> [f64; 3] {
    let acceleration = (force - DAMPING * v - STIFFNESS * y - z) / MASS;
    [v, acceleration, ALPHA * v - BETA * (GAMMA * v.abs() * z + DELTA * v * z.abs())]
}

/// Returns the displacement (m) after every [`STEPS`] steps of Runge and Kutta's method.
fn displacements(forces: &[f64]) -> Vec<f64> {
    let dt = 1.0 / (RATE * STEPS as f64);
    let mut state = [0.0; 3];
    let mut kept = Vec::with_capacity(forces.len() / STEPS);
    for (k, &force) in forces.iter().enumerate() {
        if k % STEPS == 0 {
            kept.push(state[0]);
        }
        let next = forces.get(k + 1).copied().unwrap_or(force);
        let moved = |by: [f64; 3], share: f64| -> [f64; 3] {
            std::array::from_fn(|at| state[at] + share * dt * by[at])
        };
        let first = change(state, force);
        let second = change(moved(first, 0.5), 0.5 * (force + next));
        let third = change(moved(second, 0.5), 0.5 * (force + next));
        let fourth = change(moved(third, 1.0), next);
        for at in 0..3 {
            state[at] += dt / 6.0 * (first[at] + 2.0 * (second[at] + third[at]) + fourth[at]);
        }
    }
    kept
}

/// Returns one period of a multisine of 5 to 150 Hz with random phases and 50 N rms, at the sample rate of the integration.
fn multisine(numbers: &mut Numbers) -> Vec<f64> {
    let n = SAMPLES * STEPS;
    let mut forces = vec![0.0; n];
    let lines = (1..SAMPLES / 2).map(|line| (line, line as f64 * RATE / SAMPLES as f64));
    for (line, _) in lines.filter(|(_, hertz)| (5.0..=150.0).contains(hertz)) {
        let phase = TAU * numbers.share();
        // Each step rotates a complex number, which is faster than a cosine.
        let (mut re, mut im) = (phase.cos(), phase.sin());
        let (cos, sin) =
            ((TAU * line as f64 / n as f64).cos(), (TAU * line as f64 / n as f64).sin());
        for force in &mut forces {
            *force += re;
            (re, im) = (re * cos - im * sin, re * sin + im * cos);
        }
    }
    let rms = (forces.iter().map(|force| force * force).sum::<f64>() / n as f64).sqrt();
    forces.iter().map(|force| 50.0 * force / rms).collect()
}

fn recording(name: String, forces: &[f64], displacements: Vec<f64>) -> Recording {
    let times = (0..displacements.len()).map(|k| k as f64 / RATE).collect();
    let forces: Vec<f64> =
        forces.iter().step_by(STEPS).take(displacements.len()).copied().collect();
    let targets = displacements.iter().map(|own| MILLIMETRES * own).collect();
    let (gauges, axes) = (vec!["u".to_owned()], vec![Axis::Fz]);
    Recording::new(name, Source::Simulated, times, gauges, forces, axes, targets)
        .expect("the parts make a valid recording")
}

/// Returns the second of two periods of a multisine. In the second period the effect of the start has decayed.
fn steady(numbers: &mut Numbers, noise: f64, name: String) -> Recording {
    let forces = multisine(numbers);
    let all = displacements(&[forces.clone(), forces.clone()].concat());
    let steady = all[SAMPLES..].iter().map(|own| own + noise * numbers.normal()).collect();
    recording(name, &forces, steady)
}

fn sweep() -> Recording {
    let secs = (50.0 - 20.0) / (10.0 / 60.0);
    let n = (secs * RATE) as usize * STEPS;
    let force = |k: usize| {
        let t = k as f64 / (RATE * STEPS as f64);
        40.0 * (TAU * (20.0 * t + 0.5 * (10.0 / 60.0) * t * t)).sin()
    };
    let forces: Vec<f64> = (0..n).map(force).collect();
    recording("sweep".to_owned(), &forces, displacements(&forces))
}

fn main() {
    let mut numbers = Numbers(0x9e37_79b9_7f4a_7c15);
    let mut set = RecordingSet::default();
    for at in 0..4 {
        let own = steady(&mut numbers, 8e-6, format!("multisine {at}"));
        set.push(Entry::new(own, Role::Train)).expect("the same columns");
    }
    let tests = [steady(&mut numbers, 0.0, "multisine".to_owned()), sweep()];
    let recordings = Arc::new(set);
    let search = Search {
        recordings: Arc::clone(&recordings),
        settings: FitSettings::default(),
        candidates: loopscope::questions::Candidates::All,
        limit: Duration::from_secs(600),
        within: WITHIN,
    };
    let start = Instant::now();
    let best = find_best(&search, &Progress::default(), &|_| {}).expect("the model can be fitted");
    let secs = start.elapsed().as_secs_f64();
    let proposed = best.proposed().expect("the search proposes a model");
    println!("{} ({}) in {secs:.0} s\n", proposed.name, proposed.blocks);
    let request = Request::fit(recordings, proposed.model.settings.clone());
    let calibration =
        train(&request, &Progress::default(), &mut |_| {}).expect("the model can be fitted");
    println!("| test | rms of the displacement (m) | error of the proposed model (m) |");
    println!("|---|---|---|");
    for test in tests {
        let root_mean_square = |values: &[f64]| {
            let square: f64 = values.iter().map(|own| own * own).sum();
            (square / values.len() as f64).sqrt() / MILLIMETRES
        };
        let applied = calibration.apply(&test).expect("the same gauges");
        let errors = applied.compensated.iter().zip(test.loads()).map(|(own, load)| own - load);
        let errors: Vec<f64> = errors.collect();
        let (rms, error) = (root_mean_square(test.loads()), root_mean_square(&errors));
        println!("| {} | {rms:.3e} | {error:.3e} |", test.name());
    }
    println!(
        "\nPublished on the multisine: linear 1.6e-4 m, polynomial state space 1.2e-5 m, state-space networks 7.5e-6 m"
    );
}
