//! Simulated sensors whose sources of error can be switched on and off.

use std::f64::consts::TAU;
use std::sync::Arc;

use loopscope::calibration::FitSettings;
use loopscope::progress::Progress;
use loopscope::questions::{Request, analyse};
use loopscope::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

pub const SOURCES: [&str; 8] =
    ["curvature", "hysteresis", "creep", "lag", "zeros", "drift", "sensitivity", "temperature"];
/// Largest load of the programmes (N).
const LARGEST: f64 = 10.0;

/// Random numbers (SplitMix64).
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x2545_F491_4F6C_DD1D) ^ 0x9E37_79B9)
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.between(0.0, n as f64) as usize).min(n - 1)
    }

    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.between(1e-300, 1.0).ln()).sqrt();
        radius * (TAU * self.between(0.0, 1.0)).cos()
    }

    fn normals(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.normal()).collect()
    }
}

/// What one source adds to the gauges of each recording, `n_samples × n_gauges` row-major.
type Added = Vec<Vec<f64>>;

pub struct Sensor {
    pub n_axes: usize,
    pub n_gauges: usize,
    pub rate: f64,
    pub active: Vec<&'static str>,
    /// Loads of each recording (N), `n_samples × n_axes` row-major.
    loads: Vec<Vec<f64>>,
    /// Gauges that follow the loads alone.
    strains: Added,
    added: Vec<(&'static str, Added)>,
    temperatures: Vec<Vec<f64>>,
    /// Factor of each source.
    scales: Vec<(&'static str, f64)>,
    has_channel: bool,
}

fn eased(from: &[f64], to: &[f64], share: f64, smooth: bool) -> Vec<f64> {
    let share = if smooth { share * share * (3.0 - 2.0 * share) } else { share };
    from.iter().zip(to).map(|(a, b)| a + (b - a) * share).collect()
}

/// Returns loads that move from one random load to the next, with rests between them on ramps and stairs.
fn programme(dice: &mut Dice, kind: usize, n: usize, rate: f64, n_axes: usize) -> Vec<f64> {
    let mut out = Vec::new();
    let mut before = vec![0.0; n_axes];
    let mut step = 0;
    while out.len() < n * n_axes {
        let mut next: Vec<f64> = (0..n_axes).map(|_| LARGEST * dice.between(-1.0, 1.0)).collect();
        let (moving, resting): (f64, f64) = match kind {
            0 => (dice.between(0.5, 1.5), 0.0),
            1 => (dice.between(0.5, 2.5), dice.between(0.5, 3.0)),
            _ => {
                // Up and down in steps, one axis after another.
                let (axis, at) = ((step / 14) % n_axes, step % 14);
                let level = [1, 2, 3, 4, 3, 2, 1, 0, -1, -2, -4, -3, -1, 0][at];
                next = vec![0.1 * f64::from(level); n_axes];
                next[axis] = LARGEST * f64::from(level) / 4.0;
                (0.4, dice.between(0.6, 1.4))
            }
        };
        let n_moving = ((moving * rate) as usize).max(2);
        for k in 1..=n_moving {
            out.extend(eased(&before, &next, k as f64 / n_moving as f64, kind != 1));
        }
        (0..(resting * rate) as usize).for_each(|_| out.extend(&next));
        before = next;
        step += 1;
    }
    out.truncate(n * n_axes);
    out
}

/// Returns what a sum of backlashes adds to each gauge.
fn hysteresis(strain: &[f64], weights: &[f64], is_bouc_wen: bool) -> Vec<f64> {
    let g = weights.len();
    let widths: Vec<f64> = (0..12).map(|k| 0.3 * 1.35_f64.powi(k)).collect();
    let mut states = vec![vec![0.0_f64; g]; widths.len()];
    let mut before = vec![0.0; g];
    let mut turning = vec![0.0_f64; g];
    let mut out = Vec::with_capacity(strain.len());
    for row in strain.chunks_exact(g) {
        for (gauge, value) in row.iter().enumerate() {
            let mut sum = 0.0;
            if is_bouc_wen {
                let (change, z) = ((value - before[gauge]) / 3.0, turning[gauge]);
                turning[gauge] += change * (1.0 - z.abs() * (0.4 + 0.6 * (change * z).signum()));
                before[gauge] = *value;
                sum = turning[gauge];
            } else {
                for (width, states) in widths.iter().zip(&mut states) {
                    states[gauge] = states[gauge].max(value - width).min(value + width);
                    sum += states[gauge] - value;
                }
            }
            out.push(weights[gauge] * sum);
        }
    }
    out
}

fn creep(strain: &[f64], weights: &[f64], taus: &[f64]) -> Vec<f64> {
    let g = weights.len();
    let mut states = vec![vec![0.0; g]; taus.len()];
    let mut out = Vec::with_capacity(strain.len());
    for row in strain.chunks_exact(g) {
        for (gauge, value) in row.iter().enumerate() {
            let mut sum = 0.0;
            for (tau, states) in taus.iter().zip(&mut states) {
                states[gauge] += (value - states[gauge]) / tau;
                sum += states[gauge];
            }
            out.push(weights[gauge] * sum);
        }
    }
    out
}

fn late(gauges: &[f64], g: usize, samples: f64) -> Vec<f64> {
    let n = gauges.len() / g;
    let of = |k: usize, gauge: usize| {
        let at = (k as f64 - samples).max(0.0);
        let (low, share) = (at.floor() as usize, at.fract());
        let high = (low + 1).min(n - 1);
        gauges[low * g + gauge] * (1.0 - share) + gauges[high * g + gauge] * share
    };
    (0..gauges.len()).map(|at| of(at / g, at % g)).collect()
}

impl Sensor {
    /// Makes a sensor with these sources. Each source alone gives about the same error.
    pub fn new(seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        let (kind, n_axes) = (dice.below(3), 1 + dice.below(3));
        let n_recordings = 4 + dice.below(5);
        let rate = [20.0, 50.0, 100.0][dice.below(3)];
        let n = ((dice.between(15.0, 40.0) * rate) as usize).clamp(600, 1800);
        let n_gauges = n_axes + usize::from(dice.below(3) == 0);
        let mut sources = SOURCES.to_vec();
        for last in (1..sources.len()).rev() {
            sources.swap(last, dice.below(last + 1));
        }
        let active: Vec<&str> = sources[..[0, 1, 1, 2, 2, 3, 3, 4][dice.below(8)]].to_vec();
        let matrix: Vec<f64> = (0..n_gauges * n_axes)
            .map(|at| {
                f64::from(u8::from(at / n_axes % n_axes == at % n_axes)) + 0.25 * dice.normal()
            })
            .collect();
        let loads: Vec<Vec<f64>> =
            (0..n_recordings).map(|_| programme(&mut dice, kind, n, rate, n_axes)).collect();
        let strain = |loads: &Vec<f64>| -> Vec<f64> {
            let row = |load: &[f64]| -> Vec<f64> {
                let own = matrix.chunks_exact(n_axes);
                own.map(|row| row.iter().zip(load).map(|(a, b)| a * b).sum()).collect()
            };
            loads.chunks_exact(n_axes).flat_map(row).collect()
        };
        let strains: Added = loads.iter().map(strain).collect();
        let bends = dice.normals(n_gauges);
        let widths: Vec<f64> = (0..n_gauges).map(|_| dice.between(0.5, 1.5)).collect();
        let is_bouc_wen = dice.below(2) == 0;
        let creeps: Vec<f64> = (0..n_gauges).map(|_| dice.between(0.5, 1.5)).collect();
        let taus = [dice.between(2.0, 5.0) * rate, dice.between(6.0, 15.0) * rate];
        let warmths = dice.normals(n_gauges);
        let temperatures: Vec<Vec<f64>> = (0..n_recordings)
            .map(|_| {
                let mut now = dice.normal();
                let step = (1.0 / n as f64).sqrt();
                (0..n)
                    .map(|_| {
                        now += step * dice.normal();
                        now
                    })
                    .collect()
            })
            .collect();
        let mut added: Vec<(&str, Added)> = Vec::new();
        for source in active.iter().filter(|own| **own != "lag").copied().chain(["noise"]) {
            let of = |at: usize, dice: &mut Dice| -> Vec<f64> {
                let strain = &strains[at];
                let repeated = |values: Vec<f64>| values.repeat(n);
                match source {
                    "curvature" => {
                        let rows = strain.chunks_exact(n_gauges);
                        let curved = |row: &[f64]| -> Vec<f64> {
                            row.iter().zip(&bends).map(|(own, bend)| bend * own * own).collect()
                        };
                        rows.flat_map(curved).collect()
                    }
                    "hysteresis" => hysteresis(strain, &widths, is_bouc_wen),
                    "creep" => creep(strain, &creeps, &taus),
                    "zeros" => repeated(dice.normals(n_gauges)),
                    "drift" => {
                        let slopes = dice.normals(n_gauges);
                        let time = |k: usize| k as f64 / n as f64 - 0.5;
                        let row = |k: usize| slopes.iter().map(move |own| own * time(k));
                        (0..n).flat_map(row).collect()
                    }
                    "sensitivity" => {
                        let factor = dice.normal();
                        strain.iter().map(|own| factor * own).collect()
                    }
                    "temperature" => {
                        let row = |warm: &f64| {
                            let warm = *warm;
                            warmths.iter().map(move |own| own * warm).collect::<Vec<f64>>()
                        };
                        temperatures[at].iter().flat_map(row).collect()
                    }
                    _ => dice.normals(n * n_gauges),
                }
            };
            added.push((source, (0..n_recordings).map(|at| of(at, &mut dice)).collect()));
        }
        let has_channel = active.contains(&"temperature") || dice.below(4) == 0;
        let mut sensor = Self {
            n_axes,
            n_gauges,
            rate,
            active,
            loads,
            strains,
            added,
            temperatures,
            scales: Vec::new(),
            has_channel,
        };
        let error = 10_f64.powf(dice.between(-2.3, -1.5));
        let noise = [0.05, 0.2, 0.5][dice.below(3)];
        sensor.set_scales(error, noise, &mut dice);
        sensor
    }

    fn set_scales(&mut self, error: f64, noise: f64, dice: &mut Dice) {
        let active = self.active.clone();
        for source in active.into_iter().chain(["noise"]) {
            let weight = if source == "noise" { noise } else { dice.between(0.5, 1.5) };
            self.scales.push((source, if source == "lag" { 0.5 } else { 0.01 }));
            for _ in 0..5 {
                let settings = FitSettings::default();
                let found = analyse(&self.request(&[source], settings), &Progress::default());
                let quality = &found.unwrap().calibration.quality;
                let rmse = quality.conventional.cv_rmse.clone().unwrap();
                let mean = rmse.iter().map(|own| (own / LARGEST).powi(2)).sum::<f64>();
                let now = (mean / rmse.len() as f64).sqrt();
                let last = self.scales.last_mut().unwrap();
                last.1 *= (error * weight / now).clamp(0.1, 10.0);
            }
        }
    }

    /// Returns a request for a fit to the recordings with these sources and noise.
    pub fn request(&self, sources: &[&str], settings: FitSettings) -> Request {
        let scale = |source: &str| {
            let own = self.scales.iter().find(|own| own.0 == source);
            own.map_or(0.0, |own| own.1)
        };
        let mut set = RecordingSet::default();
        for at in 0..self.loads.len() {
            let n = self.loads[at].len() / self.n_axes;
            let mut gauges = self.strains[at].clone();
            for (source, added) in &self.added {
                if *source != "noise" && sources.contains(source) {
                    let factor = scale(source);
                    gauges.iter_mut().zip(&added[at]).for_each(|(own, add)| *own += factor * add);
                }
            }
            if sources.contains(&"lag") {
                gauges = late(&gauges, self.n_gauges, scale("lag"));
            }
            let noise = self.added.iter().find(|own| own.0 == "noise").unwrap();
            let factor = scale("noise").max(1e-5);
            gauges.iter_mut().zip(&noise.1[at]).for_each(|(own, add)| *own += factor * add);
            let recording = Recording::new(
                format!("run {at}"),
                Source::Simulated,
                (0..n).map(|k| k as f64 / self.rate).collect(),
                (0..self.n_gauges).map(|gauge| format!("S{}", gauge + 1)).collect(),
                gauges,
                [Axis::Fx, Axis::Fy, Axis::Fz][..self.n_axes].to_vec(),
                self.loads[at].clone(),
            );
            let mut recording = recording.unwrap();
            if self.has_channel {
                let (names, units) = (vec!["T".to_owned()], vec!["°C".to_owned()]);
                let values = self.temperatures[at].clone();
                recording = recording.with_auxiliary(names, units, values).unwrap();
            }
            set.push(Entry::new(recording, Role::Train)).unwrap();
        }
        let full_scale = vec![Some(LARGEST); self.n_axes];
        Request::fit(Arc::new(set), FitSettings { full_scale, ..settings })
    }

    pub fn tests_temperature(&self) -> bool {
        self.has_channel
    }

    pub fn largest() -> f64 {
        LARGEST
    }
}
