//! Compares the expected error with the errors on fresh recordings of the same simulated sensor. Run by hand:
//! `EXPECTED_SENSORS=30 cargo test --release --test expected -- --ignored --nocapture`.

use std::f64::consts::TAU;
use std::sync::{Arc, Mutex};

use loopscope::calibration::{Calibration, Estimator, FitSettings};
use loopscope::features::FeatureSettings;
use loopscope::progress::Progress;
use loopscope::questions::{Request, analyse, expected_error};
use loopscope::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

const AXES: [Axis; 6] = [Axis::Fx, Axis::Fy, Axis::Fz, Axis::Mx, Axis::My, Axis::Mz];
const KINDS: [(&str, usize, Kind); 6] = [
    ("5 staircases", 5, Kind::Staircase),
    ("6 recordings of poses", 6, Kind::Poses),
    ("6 recordings of pushes", 6, Kind::Pushes),
    ("3 recordings of ramps", 3, Kind::Ramps),
    ("table of 20 cases", 20, Kind::Table),
    ("table of 40 cases", 40, Kind::Table),
];
const RATE_HZ: f64 = 20.0;
const FRESH_RECORDINGS: usize = 15;
const FRESH_CASES: usize = 400;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Staircase,
    Poses,
    Pushes,
    Ramps,
    Table,
}

/// Random numbers (SplitMix64).
struct Dice(u64);

impl Dice {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.between(0.0, n as f64) as usize).min(n - 1)
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.between(1e-300, 1.0).ln()).sqrt();
        radius * (TAU * self.between(0.0, 1.0)).cos()
    }

    fn normals(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.normal()).collect()
    }

    fn sign(&mut self) -> f64 {
        [-1.0, 1.0][self.below(2)]
    }

    /// Returns a size between two bounds, evenly distributed over decades; 0 in three of ten calls.
    fn size(&mut self, low: f64, high: f64) -> f64 {
        let size = 10_f64.powf(self.between(low.log10(), high.log10()));
        if self.between(0.0, 1.0) < 0.7 { size } else { 0.0 }
    }

    fn order(&mut self, n: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..n).collect();
        (1..n).rev().for_each(|last| order.swap(last, self.below(last + 1)));
        order
    }
}

struct Sensor {
    dice: Dice,
    n_axes: usize,
    n_gauges: usize,
    /// Sensitivities, `n_gauges × n_axes` row-major.
    matrix: Vec<f64>,
    /// Squares and products of gauges that each gauge contains, and its cube.
    curved: Vec<f64>,
    cubes: Vec<f64>,
    widths: Vec<f64>,
    creeps: Vec<f64>,
    tau_samples: f64,
    /// Sizes of curvature, hysteresis, creep, zeros, drift, sensitivity and noise, as shares of full scale.
    sizes: [f64; 7],
}

impl Sensor {
    fn new(seed: u64) -> Self {
        let mut dice = Dice(seed.wrapping_mul(0x2545_F491_4F6C_DD1D));
        let n_axes = [1, 3, 6, 6][dice.below(4)];
        let n_gauges = n_axes + [0, 0, 1, 2][dice.below(4)];
        let diagonal = |at: usize| f64::from(u8::from(at / n_axes % n_axes == at % n_axes));
        let matrix = (0..n_gauges * n_axes).map(|at| diagonal(at) + 0.3 * dice.normal()).collect();
        let curved = dice.normals(n_gauges * n_gauges * n_gauges);
        Self {
            n_axes,
            n_gauges,
            matrix,
            curved: curved.into_iter().map(|part| part / n_gauges as f64).collect(),
            cubes: dice.normals(n_gauges),
            widths: dice.normals(n_gauges),
            creeps: dice.normals(n_gauges),
            tau_samples: RATE_HZ * 10_f64.powf(dice.between(0.5, 1.7)),
            sizes: [
                dice.size(0.003, 0.03),
                dice.size(0.003, 0.03),
                dice.size(0.002, 0.02),
                dice.size(0.001, 0.01),
                dice.size(0.001, 0.01),
                dice.size(0.001, 0.01),
                10_f64.powf(dice.between(-3.5, -2.0)),
            ],
            dice,
        }
    }

    fn pose(&mut self, arm: [f64; 3]) -> Vec<f64> {
        let weight = [0.3, 0.6, 1.0][self.dice.below(3)];
        let down = self.dice.normals(3);
        let length = down.iter().map(|part| part * part).sum::<f64>().sqrt();
        let force: Vec<f64> = down.iter().map(|part| weight * part / length).collect();
        let moment = |a: usize, b: usize| 1.5 * (arm[a] * force[b] - arm[b] * force[a]);
        let moments = [moment(1, 2), moment(2, 0), moment(0, 1)];
        [&force[..], &moments].concat()[..self.n_axes].to_vec()
    }

    /// Returns the loads of one recording, `n × n_axes` row-major, in units of the full scale.
    fn programme(&mut self, kind: Kind) -> Vec<f64> {
        let n_axes = self.n_axes;
        let mut loads: Vec<Vec<f64>> = vec![vec![0.0; n_axes]];
        let mut go = |next: &[f64], moving: f64, resting: f64| {
            let before = loads[loads.len() - 1].clone();
            let n = (moving * RATE_HZ).max(2.0) as usize;
            for k in 1..=n {
                let share = k as f64 / n as f64;
                let share = share * share * (3.0 - 2.0 * share);
                let step = before.iter().zip(next).map(|(a, b)| a + (b - a) * share);
                loads.push(step.collect());
            }
            (0..(resting * RATE_HZ) as usize).for_each(|_| loads.push(next.to_vec()));
        };
        match kind {
            Kind::Staircase => {
                for axis in self.dice.order(n_axes) {
                    let top = self.dice.between(0.8, 1.0) * self.dice.sign();
                    for level in [0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0, -0.5, -1.0, -0.5, 0.0]
                    {
                        let mut load: Vec<f64> =
                            (0..n_axes).map(|_| 0.01 * self.dice.normal()).collect();
                        load[axis] = level * top;
                        go(&load, 0.3, self.dice.between(0.8, 1.4));
                    }
                }
            }
            Kind::Poses => {
                let arm = [(); 3].map(|()| self.dice.between(-0.5, 0.5));
                for _ in 0..14 {
                    let load = self.pose(arm);
                    go(&load, self.dice.between(1.0, 1.5), self.dice.between(1.0, 3.0));
                }
            }
            Kind::Pushes => {
                for _ in 0..20 {
                    let load = self.dice.normals(n_axes);
                    let largest = load.iter().fold(0.0, |most: f64, own| most.max(own.abs()));
                    let factor = self.dice.between(0.3, 1.0) / largest;
                    let load: Vec<f64> = load.iter().map(|own| factor * own).collect();
                    let secs = self.dice.between(0.3, 1.0);
                    go(&load, secs, 0.0);
                    go(&vec![0.0; n_axes], secs, self.dice.between(0.3, 1.0));
                }
            }
            Kind::Ramps => {
                for axis in self.dice.order(n_axes) {
                    let mut load: Vec<f64> =
                        (0..n_axes).map(|_| 0.15 * self.dice.normal()).collect();
                    load[axis] = self.dice.between(0.8, 1.0) * self.dice.sign();
                    for share in [1.0, -1.0, 1.0, -1.0, 0.0] {
                        let next: Vec<f64> = load.iter().map(|own| share * own).collect();
                        go(&next, self.dice.between(1.5, 2.5), 0.0);
                    }
                }
            }
            Kind::Table => unreachable!("a table has no programme"),
        }
        loads.concat()
    }

    /// Returns one of `n` different load cases. The loads of a single axis are evenly spread.
    fn case(&mut self, at: usize, n: usize) -> Vec<f64> {
        if self.n_axes == 1 {
            let place = (7 * at % n) as f64 + self.dice.between(0.2, 0.8);
            return vec![2.0 * place / n as f64 - 1.0];
        }
        let load = |axis: usize| {
            let share = [1.0, 1.0, 0.3, if axis == 0 { 0.3 } else { 0.0 }][self.dice.below(4)];
            share * self.dice.between(-1.0, 1.0)
        };
        (0..self.n_axes).map(load).collect()
    }

    /// Returns the gauges of one recording under these loads. In a table, only curvature and noise matter.
    fn gauges(&mut self, loads: &[f64], is_table: bool) -> Vec<f64> {
        let g = self.n_gauges;
        let n = loads.len() / self.n_axes;
        let [curvature, hysteresis, creep, zero, drift, sensitivity, noise] = self.sizes;
        let (zeros, factors) = (self.dice.normals(g), self.dice.normals(g));
        let mut walk = vec![0.0; g];
        let mut plays = vec![[0.0_f64; 3]; g];
        let mut crept = vec![0.0; g];
        let mut gauges = Vec::with_capacity(n * g);
        for load in loads.chunks_exact(self.n_axes) {
            let strain: Vec<f64> = (self.matrix.chunks_exact(self.n_axes))
                .map(|row| row.iter().zip(load).map(|(a, b)| a * b).sum())
                .collect();
            for gauge in 0..g {
                let own = strain[gauge];
                let parts = self.curved[gauge * g * g..][..g * g].iter().enumerate();
                let square: f64 =
                    parts.map(|(at, part)| part * strain[at / g] * strain[at % g]).sum();
                let curved = 0.5 * square + 0.3 * self.cubes[gauge] * own.powi(3);
                let mut value = own + curvature * curved + noise * self.dice.normal();
                if !is_table {
                    let mut behind = 0.0;
                    for (play, radius) in plays[gauge].iter_mut().zip([0.05, 0.15, 0.4]) {
                        *play = play.max(own - radius).min(own + radius);
                        behind += *play - own;
                    }
                    crept[gauge] += (own - crept[gauge]) / self.tau_samples;
                    walk[gauge] += self.dice.normal() / (n as f64).sqrt();
                    value += hysteresis * self.widths[gauge] * behind / 0.6
                        + 3.0 * creep * self.creeps[gauge] * crept[gauge]
                        + zero * zeros[gauge]
                        + drift * walk[gauge]
                        + sensitivity * factors[gauge] * own;
                }
                gauges.push(value);
            }
        }
        gauges
    }

    /// Makes training recordings, or fresh recordings of the same kind.
    fn recordings(&mut self, kind: Kind, n: usize) -> Vec<Recording> {
        (0..n)
            .map(|at| {
                let is_table = kind == Kind::Table;
                let loads = if is_table { self.case(at, n) } else { self.programme(kind) };
                let gauges = self.gauges(&loads, is_table);
                let time = |k: usize| if is_table { at as f64 } else { k as f64 / RATE_HZ };
                let recording = Recording::new(
                    format!("press {at}"),
                    Source::Simulated,
                    (0..loads.len() / self.n_axes).map(time).collect(),
                    (1..=self.n_gauges).map(|gauge| format!("S{gauge}")).collect(),
                    gauges,
                    AXES[..self.n_axes].to_vec(),
                    loads,
                )
                .unwrap();
                if is_table { recording.without_times() } else { recording }
            })
            .collect()
    }
}

/// Returns the share of the errors on recordings that lie within a value for each axis.
fn inside(calibration: &Calibration, recordings: &[Recording], within: &[f64]) -> Vec<f64> {
    let design = calibration.design();
    let mut n = 0;
    let mut counts = vec![0; within.len()];
    for recording in recordings {
        let mut estimator = Estimator::new(calibration, &design).unwrap();
        let loads = recording.loads().chunks_exact(within.len());
        for (k, load) in loads.enumerate() {
            let (_, found) =
                estimator.update(recording.times()[k], recording.gauges_at(k)).unwrap();
            n += 1;
            for (axis, count) in counts.iter_mut().enumerate() {
                *count += usize::from((found[axis] - load[axis]).abs() <= within[axis]);
            }
        }
    }
    counts.into_iter().map(|count| count as f64 / f64::from(n)).collect()
}

/// Returns the coverage of each axis of one sensor.
fn coverage(seed: u64, kind: Kind, n: usize) -> Vec<f64> {
    let mut sensor = Sensor::new(seed);
    let mut set = RecordingSet::default();
    for recording in sensor.recordings(kind, n) {
        set.push(Entry::new(recording, Role::Train)).unwrap();
    }
    let is_table = kind == Kind::Table;
    let features = if is_table { FeatureSettings::present() } else { FeatureSettings::default() };
    let request = Request::fit(Arc::new(set), FitSettings { features, ..FitSettings::default() });
    let progress = Progress::default();
    let calibration = analyse(&request, &progress).unwrap().calibration;
    let expected = expected_error(&request, &calibration, true, &progress).unwrap().unwrap();
    let within: Vec<f64> = expected.axes.iter().map(|axis| axis.value.unwrap()).collect();
    let n_fresh = if is_table { FRESH_CASES } else { FRESH_RECORDINGS };
    inside(&calibration, &sensor.recordings(kind, n_fresh), &within)
}

#[test]
#[ignore = "takes minutes"]
fn fresh_errors_lie_within_the_expected_error() {
    let number = |name: &str, default: u64| {
        std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
    };
    let (first, n_sensors) = (number("EXPECTED_FROM", 1), number("EXPECTED_SENSORS", 30));
    let mut all = Vec::new();
    for (name, n, kind) in KINDS {
        let found = Mutex::new(Vec::new());
        std::thread::scope(|scope| {
            for half in 0..2 {
                let found = &found;
                scope.spawn(move || {
                    for seed in (first..first + n_sensors).filter(|seed| seed % 2 == half) {
                        let covered = coverage(seed, kind, n);
                        found.lock().unwrap().extend(covered);
                    }
                });
            }
        });
        let found = found.into_inner().unwrap();
        print(name, &found);
        all.extend(found);
    }
    let (mean, below) = print("all", &all);
    assert!((mean - 0.95).abs() <= 0.015 && below <= 0.1, "{mean} {below}");
}

/// Returns the mean coverage, and the share of axes below 90 %.
fn print(name: &str, found: &[f64]) -> (f64, f64) {
    let n = found.len() as f64;
    let mean = found.iter().sum::<f64>() / n;
    let below = found.iter().filter(|share| **share < 0.9).count() as f64 / n;
    let worst = found.iter().copied().fold(1.0, f64::min);
    println!(
        "{name}: mean {:.1} %, below 90 %: {:.0} % of {n} axes, worst {:.0} %",
        100.0 * mean,
        100.0 * below,
        100.0 * worst
    );
    (mean, below)
}
