//! Quality of the search for the best model, on simulated sensors for which no rule was tuned. The bench compares the proposed model
//! with the candidate that has the lowest error on unseen recordings.
//!
//! `cargo bench --bench choosing` prints the table of the guide. A number after `--` is a seed for other sensors of the same kinds;
//! a word selects the sensors with this word in their names.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::Duration;

use loopscope::calibration::FitSettings;
use loopscope::progress::{Progress, processor_time};
use loopscope::questions::{Search, WITHIN, find_best};
use loopscope::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

/// Generator of random numbers (xorshift64*). The numbers are the same on every machine.
struct Numbers(u64);

impl Numbers {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// Returns a number between 0 and 1.
    fn share(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Returns a normally distributed number with mean 0 and variance 1.
    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.share().max(1e-300).ln()).sqrt();
        radius * (TAU * self.share()).cos()
    }
}

/// Kind of hysteresis or delay of a gauge.
#[derive(Clone, Copy)]
enum Past {
    None,
    /// Half-width of the loop, and strain at which the loop turns over.
    BoucWen(f64, f64),
    /// Weight of elements that slip at increasing strains.
    Slip(f64),
    /// Share of the signal that creeps, and time constants (s).
    Creep(f64, [f64; 2]),
    /// Time constant of a first-order low-pass (s).
    Delay(f64),
}

/// Kind of load motion.
#[derive(Clone, Copy)]
enum Motion {
    /// Sums of slow sines.
    Smooth,
    /// Steps and dwells.
    Stairs,
    /// Repeated presses: the load rises from zero and returns to zero.
    Presses,
    /// Like [`Motion::Smooth`], but with an offset, so that the first sample is already loaded.
    Loaded,
    /// Six kinds of presses, with other peaks and durations, one kind after the other.
    Programmes,
}

struct Sensor {
    name: &'static str,
    n_gauges: usize,
    axes: &'static [Axis],
    pasts: &'static [Past],
    square: f64,
    noise: f64,
    /// Amplitude of the drift of the zeros within a recording.
    drift: f64,
    motion: Motion,
    n_train: usize,
    secs: f64,
}

const FORCES: &[Axis] = &[Axis::Fx, Axis::Fy, Axis::Fz];
const ONE: &[Axis] = &[Axis::Fz];
const WRENCH: &[Axis] = &[Axis::Fx, Axis::Fy, Axis::Fz, Axis::Mx, Axis::My, Axis::Mz];

const RATE: f64 = 25.0;

const PLAIN: Sensor = Sensor {
    name: "",
    n_gauges: 6,
    axes: FORCES,
    pasts: &[Past::None],
    square: 0.0,
    noise: 0.002,
    drift: 0.0,
    motion: Motion::Smooth,
    n_train: 8,
    secs: 60.0,
};

const SENSORS: &[Sensor] = &[
    Sensor { name: "linear, no past", ..PLAIN },
    Sensor { name: "linear, six axes, much noise", axes: WRENCH, noise: 0.03, ..PLAIN },
    Sensor { name: "nonlinear, no past", square: 0.1, ..PLAIN },
    Sensor { name: "Bouc-Wen", pasts: &[Past::BoucWen(0.15, 0.3)], ..PLAIN },
    Sensor {
        name: "Bouc-Wen, three recordings",
        pasts: &[Past::BoucWen(0.1, 0.2)],
        n_train: 3,
        ..PLAIN
    },
    Sensor {
        name: "Bouc-Wen, six axes, noise",
        pasts: &[Past::BoucWen(0.08, 0.3)],
        axes: WRENCH,
        n_gauges: 8,
        noise: 0.01,
        ..PLAIN
    },
    Sensor {
        name: "Maxwell slip, stairs",
        pasts: &[Past::Slip(0.06)],
        motion: Motion::Stairs,
        ..PLAIN
    },
    Sensor {
        name: "slip elements, one recording",
        pasts: &[Past::Slip(0.05)],
        n_gauges: 2,
        axes: ONE,
        n_train: 1,
        secs: 300.0,
        ..PLAIN
    },
    Sensor {
        name: "creep, stairs",
        pasts: &[Past::Creep(0.12, [3.0, 25.0])],
        motion: Motion::Stairs,
        ..PLAIN
    },
    Sensor {
        name: "Bouc-Wen, creep, nonlinear",
        pasts: &[Past::BoucWen(0.12, 0.3), Past::Creep(0.08, [2.0, 15.0])],
        square: 0.06,
        ..PLAIN
    },
    Sensor {
        name: "presses, one-sided, slip",
        pasts: &[Past::Slip(0.08)],
        n_gauges: 3,
        axes: ONE,
        motion: Motion::Presses,
        noise: 0.01,
        n_train: 20,
        secs: 12.0,
        ..PLAIN
    },
    Sensor {
        name: "soft skin, 12 gauges, presses",
        pasts: &[Past::Slip(0.05), Past::Creep(0.2, [1.0, 8.0])],
        square: 0.3,
        n_gauges: 12,
        axes: ONE,
        motion: Motion::Presses,
        noise: 0.02,
        n_train: 12,
        secs: 20.0,
        ..PLAIN
    },
    Sensor { name: "slow gauges", pasts: &[Past::Delay(0.15)], ..PLAIN },
    Sensor { name: "gauges slower by one sample", pasts: &[Past::Delay(0.04)], ..PLAIN },
    Sensor {
        name: "wide play, begun under load",
        pasts: &[Past::BoucWen(0.15, 1.2)],
        motion: Motion::Loaded,
        secs: 30.0,
        ..PLAIN
    },
    Sensor {
        name: "presses of one long recording, slip and creep",
        pasts: &[Past::Slip(0.08), Past::Creep(0.1, [2.0, 20.0])],
        n_gauges: 3,
        axes: ONE,
        motion: Motion::Presses,
        noise: 0.01,
        n_train: 1,
        secs: 400.0,
        ..PLAIN
    },
    Sensor {
        name: "drifting zeros, one long recording",
        pasts: &[Past::BoucWen(0.1, 0.3)],
        drift: 0.3,
        n_train: 1,
        secs: 400.0,
        ..PLAIN
    },
    Sensor { name: "drifting zeros, no past", drift: 0.2, ..PLAIN },
    Sensor {
        name: "presses of six kinds, slip and creep",
        pasts: &[Past::Slip(0.08), Past::Creep(0.1, [0.5, 4.0])],
        n_gauges: 3,
        axes: ONE,
        motion: Motion::Programmes,
        noise: 0.01,
        n_train: 6,
        ..PLAIN
    },
    Sensor {
        name: "slow stretch, one recording",
        pasts: &[Past::Slip(0.1), Past::Creep(0.3, [5.0, 40.0]), Past::Delay(0.4)],
        n_gauges: 2,
        axes: ONE,
        square: 0.2,
        noise: 0.005,
        n_train: 1,
        secs: 300.0,
        ..PLAIN
    },
    Sensor {
        name: "30 gauges, 7,000 samples",
        pasts: &[Past::BoucWen(0.1, 0.4), Past::Creep(0.08, [2.0, 15.0])],
        n_gauges: 30,
        axes: WRENCH,
        square: 0.05,
        noise: 0.01,
        n_train: 4,
        secs: 70.0,
        ..PLAIN
    },
    Sensor {
        name: "8 gauges, 40,000 samples",
        pasts: &[Past::BoucWen(0.1, 0.3), Past::Creep(0.05, [2.0, 15.0])],
        n_gauges: 8,
        noise: 0.005,
        secs: 200.0,
        ..PLAIN
    },
];

struct Memory {
    past: Past,
    before: f64,
    states: [f64; 4],
}

impl Memory {
    fn step(&mut self, strain: f64) -> f64 {
        let step = strain - self.before;
        self.before = strain;
        let states = &mut self.states;
        match self.past {
            Past::None => 0.0,
            Past::BoucWen(half_width, turnover) => {
                let z = states[0];
                let change = step - 0.5 * (step.abs() * z + step * z.abs());
                states[0] = (z + change / turnover).clamp(-1.0, 1.0);
                -half_width * states[0]
            }
            Past::Slip(weight) => {
                for (at, state) in states.iter_mut().enumerate() {
                    let limit = 0.05 * 2f64.powi(at as i32);
                    *state = (*state + step).clamp(-limit, limit);
                }
                -weight * states.iter().sum::<f64>()
            }
            Past::Creep(share, taus) => {
                for (state, tau) in states.iter_mut().zip(taus) {
                    *state += (strain - *state) * (1.0 - (-1.0 / (RATE * tau)).exp());
                }
                share * 0.5 * (states[0] + states[1])
            }
            Past::Delay(tau) => {
                states[0] += (strain - states[0]) * (1.0 - (-1.0 / (RATE * tau)).exp());
                states[0] - strain
            }
        }
    }
}

/// Returns the load of one axis for each sample, with a size of about 1. Presses are never negative.
fn motion(kind: Motion, n: usize, numbers: &mut Numbers) -> Vec<f64> {
    match kind {
        Motion::Smooth | Motion::Loaded => {
            let sines: Vec<[f64; 3]> = (0..4)
                .map(|_| {
                    [
                        numbers.between(0.02, 0.4),
                        numbers.between(0.0, TAU),
                        numbers.between(0.1, 0.4),
                    ]
                })
                .collect();
            let at = |k| {
                let of_sine =
                    |[f, phase, size]: &[f64; 3]| size * (TAU * f * k as f64 / RATE + phase).sin();
                sines.iter().map(of_sine).sum::<f64>()
            };
            let offset = if matches!(kind, Motion::Loaded) { 0.7 } else { 0.0 };
            (0..n).map(|k| offset + at(k)).collect()
        }
        Motion::Stairs => {
            let (mut now, mut target, mut hold) = (0.0_f64, 0.0_f64, 0.0);
            let mut one = || {
                if hold <= 0.0 {
                    target = numbers.between(-1.0, 1.0);
                    hold = numbers.between(1.0, 6.0);
                }
                hold -= 1.0 / RATE;
                now += (target - now).clamp(-2.0 / RATE, 2.0 / RATE);
                now
            };
            (0..n).map(|_| one()).collect()
        }
        Motion::Programmes => {
            let mut loads = Vec::with_capacity(n);
            while loads.len() < n {
                let kind = numbers.between(0.0, 6.0) as usize;
                let (peak, steps) = (0.3 + 0.14 * kind as f64, 10 + 5 * (kind * 5 % 6));
                let noise = 1.0 + 0.02 * numbers.normal();
                let at = |k| peak * noise * (0.5 * TAU * k as f64 / steps as f64).sin();
                loads.extend((0..steps).map(at));
                loads.extend(std::iter::repeat_n(0.0, (0.4 * RATE) as usize));
            }
            loads.truncate(n);
            loads
        }
        Motion::Presses => {
            let mut loads = Vec::with_capacity(n);
            while loads.len() < n {
                let (peak, secs) = (numbers.between(0.2, 1.0), numbers.between(1.5, 4.0));
                let steps = (secs * RATE) as usize;
                loads
                    .extend((0..steps).map(|k| peak * (0.5 * TAU * k as f64 / steps as f64).sin()));
                loads.extend(std::iter::repeat_n(0.0, (0.5 * RATE) as usize));
            }
            loads.truncate(n);
            loads
        }
    }
}

/// Returns one recording. The gauges also depend on loads before its start.
fn recording(
    sensor: &Sensor,
    compliance: &[f64],
    name: String,
    numbers: &mut Numbers,
) -> Recording {
    let (g, q) = (sensor.n_gauges, sensor.axes.len());
    let before = (5.0 * RATE) as usize;
    let n = (sensor.secs * RATE) as usize;
    let sizes: Vec<f64> =
        sensor.axes.iter().map(|axis| if axis.unit() == "N" { 20.0 } else { 0.8 }).collect();
    let moved: Vec<Vec<f64>> = (0..q).map(|_| motion(sensor.motion, before + n, numbers)).collect();
    let mut memories: Vec<Vec<Memory>> = (0..g)
        .map(|_| {
            sensor
                .pasts
                .iter()
                .map(|past| Memory { past: *past, before: 0.0, states: [0.0; 4] })
                .collect()
        })
        .collect();
    let (mut gauges, mut loads) = (Vec::new(), Vec::new());
    let mut zeros: Vec<f64> = (0..g).map(|_| 0.3 * sensor.drift * numbers.normal()).collect();
    let wander = sensor.drift / (n as f64).sqrt();
    #[expect(clippy::needless_range_loop, reason = "the same sample of several axes")]
    for k in 0..before + n {
        for (gauge, memories) in memories.iter_mut().enumerate() {
            let strain: f64 =
                (0..q).map(|axis| compliance[gauge * q + axis] * moved[axis][k]).sum();
            let past: f64 = memories.iter_mut().map(|memory| memory.step(strain)).sum();
            let reads =
                strain + sensor.square * strain * strain + past + sensor.noise * numbers.normal();
            if sensor.drift > 0.0 {
                zeros[gauge] += wander * numbers.normal();
            }
            if k >= before {
                gauges.push(0.3 + zeros[gauge] + reads);
            }
        }
        if k >= before {
            loads.extend((0..q).map(|axis| sizes[axis] * moved[axis][k]));
        }
    }
    let times = (0..n).map(|k| k as f64 / RATE).collect();
    let names = (1..=g).map(|at| format!("S{at}")).collect();
    Recording::new(name, Source::Simulated, times, names, gauges, sensor.axes.to_vec(), loads)
        .expect("the parts make a valid recording")
}

fn recordings(sensor: &Sensor, seed: u64) -> RecordingSet {
    let mut numbers = Numbers::new(seed);
    let compliance: Vec<f64> = (0..sensor.n_gauges * sensor.axes.len())
        .map(|at| {
            let own = at / sensor.axes.len() % sensor.axes.len() == at % sensor.axes.len();
            numbers.between(-0.3, 0.3) + if own { 1.0 } else { 0.0 }
        })
        .collect();
    let mut set = RecordingSet::default();
    for (role, count) in [(Role::Train, sensor.n_train), (Role::Test, sensor.n_train.max(4))] {
        for at in 0..count {
            let name = format!("{role:?} {at}");
            let made = recording(sensor, &compliance, name, &mut numbers);
            set.push(Entry::new(made, role)).expect("all have the same columns");
        }
    }
    set
}

/// Returns the root of the mean squared error of all axes, divided by the same root for the conventional calibration.
fn relative(rmse: &[f64], conventional: &[f64]) -> f64 {
    let ratios = rmse.iter().zip(conventional).map(|(own, other)| (own / other).powi(2));
    (ratios.sum::<f64>() / rmse.len() as f64).sqrt()
}

/// Returns the largest memory of this process since the last call (MB), where the system tells it.
fn peak_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = peak.and_then(|peak| peak.trim().trim_end_matches(" kB").parse::<f64>().ok());
    // If the system refuses this, the peak is that since the start of the process.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    kilobytes.unwrap_or(f64::NAN) / 1024.0
}

fn main() {
    let words: Vec<String> =
        std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let seed = words.iter().find_map(|word| word.parse().ok()).unwrap_or(1);
    let chosen: Vec<&String> = words.iter().filter(|word| word.parse::<u64>().is_err()).collect();
    println!("| recordings | proposal | own | test | best tried | seconds | MB |");
    println!("|---|---|---|---|---|---|---|");
    let (mut n_all, mut n_near, mut n_true, mut worst) = (0, 0, 0, 0.0_f64);
    for (at, sensor) in SENSORS.iter().enumerate() {
        if !chosen.is_empty() && !chosen.iter().any(|word| sensor.name.contains(&***word)) {
            continue;
        }
        let search = Search {
            recordings: Arc::new(recordings(sensor, seed * 1000 + at as u64)),
            settings: FitSettings::default(),
            candidates: loopscope::questions::Candidates::All,
            limit: Duration::from_secs(600),
            within: WITHIN,
        };
        peak_memory();
        let start = processor_time();
        let best = find_best(&search, &Progress::default(), &|_| {}).expect("all can be fitted");
        let (secs, memory) = ((processor_time() - start).as_secs_f64(), peak_memory());
        let test = |at: usize| {
            let scores = &best.tried[at].model.scores;
            scores.test_rmse.as_deref().expect("there are test recordings")
        };
        let errors: Vec<f64> =
            (0..best.tried.len()).map(|at| relative(test(at), test(0))).collect();
        let lowest = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let chosen =
            best.tried.iter().position(|tried| tried.is_proposed).expect("a candidate is proposed");
        let (proposed, error) = (&best.tried[chosen], errors[chosen]);
        n_all += 1;
        n_near += usize::from(error <= 1.05 * lowest);
        n_true += usize::from((0.8..=1.25).contains(&(proposed.relative / error)));
        worst = worst.max(error);
        println!(
            "| {} | {} | {:.3} | {error:.3} | {lowest:.3} | {secs:.0} | {memory:.0} |",
            sensor.name, proposed.name, proposed.relative
        );
        if std::env::var_os("ALL_CANDIDATES").is_some() {
            for (tried, error) in best.tried.iter().zip(&errors) {
                eprintln!(
                    "    {:36} cv {:.3} ± {:.3} test {:.3} {:6.2} s {} {}",
                    tried.name,
                    tried.relative,
                    tried.model.spread.unwrap_or_default(),
                    error,
                    tried.model.seconds.unwrap_or_default(),
                    if tried.is_smallest { "=" } else { " " },
                    tried.refused.as_ref().unwrap_or(&tried.blocks)
                );
            }
            for (name, why) in &best.failed {
                eprintln!("    {name}: {why}");
            }
        }
    }
    println!(
        "\n{n_near} of {n_all} within 5 % of the best tried; {n_true} of {n_all} own errors within 25 % of the test; the worst proposal has {worst:.3} of the conventional error"
    );
}
