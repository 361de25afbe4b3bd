//! Recordings of simulated rigs, without a fault ("sound") or with a single fault. The simulator shares no code with the built-in
//! sensor.

use loopscope::recording::{Axis, Recording, Source};

/// Generator of random numbers (xorshift, Marsaglia 2003).
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        let mut own = Self((seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
        (0..8).for_each(|_| {
            own.unit();
        });
        own
    }

    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }

    /// Returns a nearly normally distributed number: the sum of twelve uniform numbers minus six.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Programme {
    Steps,
    Ramps,
    Random,
    Poses,
}

pub const PROGRAMMES: [Programme; 4] =
    [Programme::Steps, Programme::Ramps, Programme::Random, Programme::Poses];

#[derive(Clone, Debug)]
pub struct Run {
    pub programme: Programme,
    pub times: Vec<f64>,
    pub gauges: Vec<Vec<f64>>,
    pub loads: Vec<Vec<f64>>,
}

/// A set of recordings of one rig.
#[derive(Clone, Debug)]
pub struct Set {
    pub seed: u64,
    pub axes: Vec<Axis>,
    pub full_scale: Vec<f64>,
    pub n_gauges: usize,
    pub hysteresis: f64,
    pub noise: f64,
    /// Range of each gauge.
    pub span: Vec<f64>,
    pub runs: Vec<Run>,
}

const RATE_HZ: f64 = 20.0;

fn knots(dice: &mut Dice, n: usize, n_axes: usize) -> Vec<Vec<f64>> {
    (0..n).map(|_| (0..n_axes).map(|_| dice.between(-1.0, 1.0)).collect()).collect()
}

/// Returns the loads of a recording, one row per sample, from −1 to 1 on each axis.
fn programme(dice: &mut Dice, kind: Programme, n_axes: usize) -> Vec<Vec<f64>> {
    let secs = dice.between(40.0, 90.0);
    let n = (secs * RATE_HZ) as usize;
    match kind {
        Programme::Poses => {
            let n = 30 + dice.below(50);
            knots(dice, n, n_axes)
        }
        Programme::Steps => {
            let held = knots(dice, (secs / 2.5) as usize, n_axes);
            let at = |k: usize| (k * held.len() / n).min(held.len() - 1);
            // Rows are a third of a second apart.
            let row = |k: usize| -> Vec<f64> {
                let (from, to) = (k.saturating_sub(3), (k + 3).min(n - 1));
                let mean = |axis: usize| {
                    (from..=to).map(|k| held[at(k)][axis]).sum::<f64>() / (to - from + 1) as f64
                };
                (0..n_axes).map(mean).collect()
            };
            (0..n).map(row).collect()
        }
        Programme::Ramps => {
            let ends = knots(dice, (secs / 4.0) as usize + 2, n_axes);
            let row = |k: usize| -> Vec<f64> {
                let at = k as f64 / n as f64 * (ends.len() - 1) as f64;
                let (from, part) = (at as usize, at.fract());
                let between =
                    |axis: usize| ends[from][axis] * (1.0 - part) + ends[from + 1][axis] * part;
                (0..n_axes).map(between).collect()
            };
            (0..n).map(row).collect()
        }
        Programme::Random => {
            let mut waves = Vec::new();
            for _ in 0..n_axes {
                let own: Vec<[f64; 3]> = (0..6)
                    .map(|_| {
                        [dice.between(0.05, 0.6), dice.between(0.0, 6.3), dice.between(0.3, 1.0)]
                    })
                    .collect();
                waves.push(own);
            }
            let value = |k: usize, own: &[[f64; 3]]| -> f64 {
                let t = k as f64 / RATE_HZ;
                let all = own
                    .iter()
                    .map(|[hz, phase, size]| size * (std::f64::consts::TAU * hz * t + phase).sin());
                all.sum::<f64>() / (0.6 * own.iter().map(|own| own[2]).sum::<f64>())
            };
            (0..n)
                .map(|k| waves.iter().map(|own| value(k, own).clamp(-1.0, 1.0)).collect())
                .collect()
        }
    }
}

impl Set {
    /// Returns a set without faults: one to eight recordings, one to six axes, 0 to 10 % of hysteresis, 0.05 to 1 % of noise.
    pub fn sound(seed: u64, fewest_runs: usize) -> Self {
        let mut dice = Dice::new(seed);
        let n_runs = (1 + dice.below(8)).max(fewest_runs);
        let n_axes = 1 + dice.below(6);
        let n_gauges = n_axes + dice.below(4);
        let hysteresis = [0.0, 0.01, 0.03, 0.06, 0.1][dice.below(5)];
        let noise = 0.0005 * 20.0_f64.powf(dice.unit());
        let mut axes = Axis::ALL.to_vec();
        while axes.len() > n_axes {
            axes.remove(dice.below(axes.len()));
        }
        let full_scale: Vec<f64> =
            axes.iter().map(|axis| if axis.is_force() { 100.0 } else { 5.0 }).collect();
        // Each gauge mainly measures one axis. Gauges beyond the number of axes measure all axes.
        let slopes: Vec<Vec<f64>> = (0..n_gauges)
            .map(|gauge| {
                let own = |axis: usize| if gauge == axis { 1.5 } else { 0.0 };
                (0..n_axes).map(|axis| own(axis) + 0.5 * dice.normal()).collect()
            })
            .collect();
        let span: Vec<f64> = slopes
            .iter()
            .map(|own| 0.6 * own.iter().map(|slope| slope.abs()).sum::<f64>())
            .collect();
        let zeros: Vec<f64> = span.iter().map(|span| 0.3 * span * dice.normal()).collect();
        let one_kind = (dice.unit() < 0.5).then(|| PROGRAMMES[dice.below(4)]);
        let mut runs = Vec::new();
        for _ in 0..n_runs {
            let kind = one_kind.unwrap_or_else(|| PROGRAMMES[dice.below(4)]);
            let loads = programme(&mut dice, kind, n_axes);
            let mut plays = vec![[0.0_f64; 2]; n_gauges];
            let rest: Vec<f64> = span.iter().map(|span| 0.0002 * span * dice.normal()).collect();
            let mut gauges = Vec::new();
            for load in &loads {
                let row = (0..n_gauges).map(|gauge| {
                    let printed: f64 =
                        slopes[gauge].iter().zip(load).map(|(slope, load)| slope * load).sum();
                    let mut lag = 0.0;
                    for (play, radius) in plays[gauge].iter_mut().zip([0.2, 0.6]) {
                        *play = play
                            .clamp(printed - radius * span[gauge], printed + radius * span[gauge]);
                        lag += 0.5 * (*play - printed);
                    }
                    printed
                        + lag * hysteresis / 0.4
                        + zeros[gauge]
                        + rest[gauge]
                        + noise * span[gauge] * dice.normal()
                });
                gauges.push(row.collect());
            }
            let scaled =
                |load: &Vec<f64>| load.iter().zip(&full_scale).map(|(a, b)| a * b).collect();
            runs.push(Run {
                programme: kind,
                times: (0..loads.len()).map(|k| k as f64 / RATE_HZ).collect(),
                gauges,
                loads: loads.iter().map(scaled).collect(),
            });
        }
        Self { seed, axes, full_scale, n_gauges, hysteresis, noise, span, runs }
    }

    pub fn recordings(&self) -> Vec<Recording> {
        let recording = |(at, run): (usize, &Run)| {
            let names = (1..=self.n_gauges).map(|gauge| format!("S{gauge}")).collect();
            let own = Recording::new(
                format!("run {}", at + 1),
                Source::File(format!("run {}.csv", at + 1).into()),
                run.times.clone(),
                names,
                run.gauges.concat(),
                self.axes.clone(),
                run.loads.concat(),
            );
            own.unwrap()
        };
        self.runs.iter().enumerate().map(recording).collect()
    }
}

/// Kind of fault of a rig. A fault of size 0 has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    Tare,
    Drift,
    GaugeFrom,
    GaugeOnce,
    AmplifierFrom,
    PoundsOnce,
    MillimetresOnce,
    TurnedOnce,
    SwappedGauges,
    SwappedAxes,
    MirroredAxis,
    MirroredGauge,
    Clipped,
    ClippedReference,
    Late,
}

pub const FAULTS: [Fault; 15] = [
    Fault::Tare,
    Fault::Drift,
    Fault::GaugeFrom,
    Fault::GaugeOnce,
    Fault::AmplifierFrom,
    Fault::PoundsOnce,
    Fault::MillimetresOnce,
    Fault::TurnedOnce,
    Fault::SwappedGauges,
    Fault::SwappedAxes,
    Fault::MirroredAxis,
    Fault::MirroredGauge,
    Fault::Clipped,
    Fault::ClippedReference,
    Fault::Late,
];

impl Fault {
    pub fn has_size(self) -> bool {
        use Fault::*;
        !matches!(
            self,
            PoundsOnce
                | MillimetresOnce
                | SwappedGauges
                | SwappedAxes
                | MirroredAxis
                | MirroredGauge
        )
    }

    /// Minimum number of recordings with which the fault can be identified.
    pub fn fewest_runs(self) -> usize {
        match self {
            Self::Clipped | Self::ClippedReference | Self::Late => 1,
            _ => 2,
        }
    }

    /// Returns true if the set can have this fault, for example if it has two axes to exchange.
    pub fn fits(self, set: &Set) -> bool {
        let forces = set.axes.iter().filter(|axis| axis.is_force()).count();
        let moments = set.axes.len() - forces;
        match self {
            Self::MillimetresOnce => moments > 0 && forces > 0,
            Self::TurnedOnce => forces > 1 || moments > 1,
            Self::SwappedGauges => set.n_gauges > 1,
            Self::SwappedAxes => set.axes.len() > 1,
            // Load cases have no order in time.
            Self::Late => set.runs.iter().all(|run| run.programme != Programme::Poses),
            _ => true,
        }
    }

    /// Returns a copy of the set `sound` with this fault.
    pub fn of(self, sound: &Set, size: f64) -> Set {
        let mut set = sound.clone();
        let mut dice = Dice::new(sound.seed + 1000);
        let n = set.runs.len();
        let first = 1 + dice.below((n - 1).max(1));
        let own = dice.below(n);
        let gauge = dice.below(set.n_gauges);
        let other = (gauge + 1 + dice.below((set.n_gauges - 1).max(1))) % set.n_gauges;
        let axis = dice.below(set.axes.len());
        let other_axis = (axis + 1 + dice.below((set.axes.len() - 1).max(1))) % set.axes.len();
        let shift: Vec<f64> = set.span.iter().map(|span| span * dice.normal()).collect();
        let way = [(); 3].map(|()| dice.normal());
        let ends = |of: &dyn Fn(&Run, usize) -> f64| {
            let values =
                sound.runs.iter().flat_map(|run| (0..run.loads.len()).map(move |k| of(run, k)));
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), own| {
                (low.min(own), high.max(own))
            })
        };
        let (low, high) = ends(&|run, k| run.gauges[k][gauge]);
        let (least, most) = ends(&|run, k| run.loads[k][axis]);
        for (run, rows) in set.runs.iter_mut().enumerate() {
            let n_rows = rows.gauges.len();
            for k in 0..n_rows {
                let (gauges, loads) = (&mut rows.gauges[k], &mut rows.loads[k]);
                let time = (run as f64 + k as f64 / n_rows as f64) / n as f64;
                match self {
                    Self::Tare if run >= first => {
                        gauges.iter_mut().zip(&shift).for_each(|(own, shift)| *own += size * shift);
                    }
                    Self::Drift => {
                        let shift = shift.iter().map(|shift| size * time * shift);
                        gauges.iter_mut().zip(shift).for_each(|(own, shift)| *own += shift);
                    }
                    Self::GaugeFrom if run >= first => gauges[gauge] *= 1.0 + size,
                    Self::GaugeOnce if run == own => gauges[gauge] *= 1.0 + size,
                    Self::AmplifierFrom if run >= first => {
                        gauges.iter_mut().for_each(|own| *own *= 1.0 - size);
                    }
                    Self::PoundsOnce if run == own => {
                        loads.iter_mut().for_each(|own| *own /= 4.448_221_6);
                    }
                    Self::MillimetresOnce if run == own => {
                        let all = loads.iter_mut().zip(&set.axes);
                        all.filter(|(_, axis)| !axis.is_force())
                            .for_each(|(own, _)| *own *= 1000.0);
                    }
                    Self::TurnedOnce if run == own => *loads = turned(loads, &set.axes, way, size),
                    Self::SwappedGauges if run == own => gauges.swap(gauge, other),
                    Self::SwappedAxes if run == own => loads.swap(axis, other_axis),
                    Self::MirroredAxis if run == own => loads[axis] = -loads[axis],
                    Self::MirroredGauge if run == own => gauges[gauge] = -gauges[gauge],
                    Self::Clipped => gauges[gauge] = gauges[gauge].min(high - size * (high - low)),
                    Self::ClippedReference => {
                        loads[axis] = loads[axis].min(most - size * (most - least))
                    }
                    Self::Late => {
                        let rate = 1.0 / (rows.times[1] - rows.times[0]);
                        let at = (k as f64 + size * rate).min(n_rows as f64 - 1.0);
                        let (from, to) = (at as usize, (at as usize + 1).min(n_rows - 1));
                        let source = &sound.runs[run].loads;
                        let both = source[from].iter().zip(&source[to]);
                        *loads = both.map(|(a, b)| a + at.fract() * (b - a)).collect();
                    }
                    _ => {}
                }
            }
        }
        set
    }
}

/// Returns loads after rotations about the coordinate axes, one after the other. The angles are `angle` (rad) times the
/// components of `way`, scaled to length 1.
fn turned(loads: &[f64], axes: &[Axis], way: [f64; 3], angle: f64) -> Vec<f64> {
    let length = way.iter().map(|own| own * own).sum::<f64>().sqrt();
    let mut all = [0.0; 6];
    axes.iter().zip(loads).for_each(|(axis, load)| all[*axis as usize] = *load);
    for (about, part) in way.into_iter().enumerate() {
        let (sin, cos) = (angle * part / length).sin_cos();
        for start in [0, 3] {
            let (a, b) = (start + (about + 1) % 3, start + (about + 2) % 3);
            (all[a], all[b]) = (cos * all[a] - sin * all[b], sin * all[a] + cos * all[b]);
        }
    }
    axes.iter().map(|axis| all[*axis as usize]).collect()
}
