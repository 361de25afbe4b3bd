//! Columns that are taken for gauges and are none: the reference again, a clock or counter, a gauge that is there twice.
//!
//! A real gauge has noise, hysteresis and curvature of its own. A column that follows from the reference to rounding has none, and where
//! the gauges beside it have, it is no gauge. Where all of them follow so, the data are computed ones, and nothing is said.

use std::fmt;
use std::ops::RangeInclusive;

use crate::recording::{Axis, Recording, load_ranges, median};
use crate::scoring::load_spread::LoadSpread;
use crate::scoring::straight_lines;

/// So many samples are looked at, spread evenly over the recordings ...
const LOOKED_AT: usize = 8192;
/// ... and of each as many as this.
const FEWEST_OF_EACH: usize = 16;
/// For each number that is found so many samples are needed.
const SAMPLES_EACH: usize = 4;
/// What is left of a gauge under loads that move on their own, as a share of its standard deviation: no sensor is so free of crosstalk,
/// curvature and noise. What is explained by rounding counts where rounding is finer than the second number.
const EXACT: Exact = (3e-4, 1e-2);
/// The same where one load moves: good load cells come to a part in some thousands.
const EXACT_ON_ONE: Exact = (3e-5, 5e-4);
/// What is left over what rounding makes in the mean.
const AS_ROUNDED: RangeInclusive<f64> = 0.85..=1.15;
/// Two gauges are one, but for rounding.
const SAME: Exact = (1e-5, 5e-3);
/// The other gauges leave so many times more.
const OTHERS_LEAVE: f64 = 10.0;
/// Of an axis that has a part in a gauge, the least share of the gauge's standard deviation.
const PART: f64 = 1e-3;
/// Fewer samples of a recording say nothing of a clock ...
const CLOCK_SAMPLES: usize = 50;
/// ... and fewer rows of a table.
const CLOCK_ROWS: usize = 20;
/// A clock stays this near to a straight line, as a share of how far it goes.
const CLOCK_OFF: f64 = 5e-3;
/// A load so near to a straight line says that a ramp was recorded.
const RAMP_OFF: f64 = 0.1;
/// A counter that begins anew makes the same step on this share of the samples.
const SAME_STEPS: f64 = 0.98;
/// Two gauges that may be one are looked at closely from this correlation on.
const MAY_BE_SAME: f64 = 0.999;

/// What is left at most, as a share of the standard deviation, and how fine rounding must be to count.
type Exact = (f64, f64);

/// A column that is taken for a gauge and seems to be none.
#[derive(Clone, Debug, PartialEq)]
pub enum NoGauge {
    /// A gauge that follows from these axes of the reference to rounding.
    Reference(String, Vec<Axis>),
    /// An axis that follows from the gauges to rounding.
    Computed(Axis),
    /// A gauge that makes the same step all along.
    Clock(String),
    /// A gauge that is another one, but for a factor and an offset.
    Copy(String, String),
}

impl fmt::Display for NoGauge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reference(gauge, axes) => {
                let axes = symbols(axes);
                write!(f, "{gauge} seems to be {axes}, which it follows from to rounding")
            }
            Self::Computed(axis) => {
                let axis = axis.symbol();
                write!(f, "{axis} is computed from the gauges, which it follows from to rounding")
            }
            Self::Clock(gauge) => {
                write!(f, "{gauge} seems to be a clock: it always makes the same step")
            }
            Self::Copy(gauge, of) => {
                write!(f, "{gauge} is {of} again, but for a factor and an offset")
            }
        }
    }
}

fn symbols(axes: &[Axis]) -> String {
    let symbols: Vec<&str> = axes.iter().map(|axis| axis.symbol()).collect();
    match &symbols[..] {
        [others @ .., last] if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => symbols.join(""),
    }
}

/// Which of the gauges of these recordings of one sensor seem to be none.
pub fn no_gauges(recordings: &[&Recording]) -> Vec<NoGauge> {
    let Some(first) = recordings.first() else {
        return Vec::new();
    };
    let (tables, series): (Vec<&Recording>, Vec<&Recording>) =
        (recordings.iter().copied()).partition(|own| own.is_static());
    let table = (!tables.is_empty()).then(|| Recording::table_of(&tables).without_times());
    let recordings: Vec<&Recording> = table.iter().chain(series).collect();

    let names = first.gauge_names();
    let gauges = Channels::of(&recordings, names.len(), Recording::gauges);
    let loads = Channels::of(&recordings, first.axes().len(), Recording::loads);
    let is_clock = |gauge: &usize| is_clock(&recordings, *gauge);
    let clocks: Vec<usize> = (0..names.len()).filter(is_clock).collect();
    let moving: Vec<usize> = gauges.moving();
    let moving: Vec<usize> = (moving.into_iter()).filter(|gauge| !clocks.contains(gauge)).collect();
    let axes = loads.moving();
    let mut found = Vec::new();

    let rows =
        recordings.iter().flat_map(|own| own.loads().chunks_exact(first.axes().len().max(1)));
    let rows = rows.step_by(gauges.every.max(1));
    let spread = LoadSpread::of(rows, &load_ranges(recordings.iter().copied()));
    let exact = match spread.n_directions {
        0 | 1 => EXACT_ON_ONE,
        _ => EXACT,
    };
    let by_loads: Vec<Option<Explained>> =
        (moving.iter()).map(|gauge| gauges.explained(*gauge, &loads, &axes)).collect();
    let is_exact = |of: &Option<Explained>| of.as_ref().is_some_and(|own| own.is(exact));
    let left = by_loads.iter().flatten();
    let usual = median(left.filter(|own| !own.is(exact)).map(|own| own.left));
    let mut repeats = Vec::new();
    for (gauge, own) in moving.iter().zip(&by_loads) {
        let Some(own) = own.as_ref().filter(|own| own.is(exact)) else {
            continue;
        };
        if usual.is_some_and(|usual| usual > (OTHERS_LEAVE * own.left).max(3.0 * exact.0)) {
            let alone = axes.iter().find(|axis| {
                let by = gauges.explained(*gauge, &loads, &[**axis]);
                by.is_some_and(|by| by.is(exact))
            });
            let parts = axes.iter().zip(&own.parts);
            let parts = parts.filter(|(_, part)| **part > PART);
            let of = match alone {
                Some(axis) => vec![first.axes()[*axis]],
                None => parts.map(|(axis, _)| first.axes()[*axis]).collect(),
            };
            repeats.push(*gauge);
            found.push(NoGauge::Reference(names[*gauge].clone(), of));
        }
    }
    let others = moving.iter().filter(|gauge| !repeats.contains(gauge));
    let others: Vec<usize> = others.copied().collect();
    if !by_loads.iter().all(is_exact) {
        for axis in &axes {
            let by = loads.explained(*axis, &gauges, &others);
            if by.is_some_and(|by| by.is(EXACT_ON_ONE)) {
                found.push(NoGauge::Computed(first.axes()[*axis]));
            }
        }
    }
    found.extend((clocks.into_iter()).map(|gauge| NoGauge::Clock(names[gauge].clone())));
    let exact_ones = moving.iter().zip(&by_loads);
    let exact_ones = exact_ones.filter(|(_, own)| is_exact(own));
    let exact_ones: Vec<usize> = exact_ones.map(|(gauge, _)| *gauge).collect();
    let mut copies: Vec<usize> = Vec::new();
    for (at, one) in moving.iter().enumerate() {
        for other in &moving[at + 1..] {
            let both_exact = exact_ones.contains(one) && exact_ones.contains(other);
            let is_known = copies.contains(one) || copies.contains(other) || both_exact;
            if !is_known && gauges.may_be_same(*one, *other) {
                let by = gauges.explained(*other, &gauges, &[*one]);
                if by.is_some_and(|by| by.is(SAME)) {
                    copies.push(*other);
                    let [other, one] = [other, one].map(|gauge| names[*gauge].clone());
                    found.push(NoGauge::Copy(other, one));
                }
            }
        }
    }
    found
}

/// Some samples of channels, each less its mean over its recording: what a tare takes off says nothing.
struct Channels {
    /// By channel.
    values: Vec<Vec<f64>>,
    deviations: Vec<f64>,
    /// How far apart two values are at least that differ.
    resolutions: Vec<f64>,
    /// How many numbers the means took.
    n_means: usize,
    /// Every how many-th sample is looked at, about.
    every: usize,
}

/// A channel by others.
struct Explained {
    /// What is left, as a share of its standard deviation.
    left: f64,
    /// The most that is left, as a share of what rounding makes at most.
    in_roundings: f64,
    /// What rounding makes at most, as a share of its standard deviation.
    rounding: f64,
    /// Whether what is left is as large as rounding of it, of the others or of both makes it: what is good but real is not.
    is_rounding: bool,
    /// The standard deviation of what each of the others has in it, as a share of its own.
    parts: Vec<f64>,
}

impl Explained {
    fn is(&self, (left, rounding): Exact) -> bool {
        let by_rounding = self.is_rounding && self.in_roundings <= 1.1;
        self.left <= left || (by_rounding && self.rounding <= rounding)
    }
}

impl Channels {
    fn of(recordings: &[&Recording], width: usize, all: fn(&Recording) -> &[f64]) -> Self {
        let of_each = (LOOKED_AT / recordings.len().max(1)).max(FEWEST_OF_EACH);
        let mut values = vec![Vec::new(); width];
        let mut every = 1;
        let mut resolutions = vec![f64::INFINITY; width];
        for recording in recordings {
            let step = recording.n_samples().div_ceil(of_each).max(1);
            every = every.max(step);
            for (channel, values) in values.iter_mut().enumerate() {
                let own = all(recording)[channel..].iter().step_by(width * step);
                let own: Vec<f64> = own.copied().collect();
                let mean = own.iter().sum::<f64>() / own.len() as f64;
                let resolution = &mut resolutions[channel];
                *resolution = resolution.min(least_step(&own));
                values.extend(own.iter().map(|value| value - mean));
            }
        }
        let deviation = |values: &Vec<f64>| {
            let squares: f64 = values.iter().map(|value| value * value).sum();
            (squares / values.len().max(1) as f64).sqrt()
        };
        Self {
            deviations: values.iter().map(deviation).collect(),
            values,
            resolutions,
            n_means: recordings.len(),
            every,
        }
    }

    fn moving(&self) -> Vec<usize> {
        let moves = |channel: &usize| self.resolutions[*channel].is_finite();
        (0..self.values.len()).filter(moves).collect()
    }

    /// A channel by some of others in straight lines; `None` where these are too many for the samples, or none.
    fn explained(&self, channel: usize, by: &Self, of: &[usize]) -> Option<Explained> {
        let (own, deviation) = (&self.values[channel], self.deviations[channel]);
        let (n, d) = (own.len(), of.len());
        if d == 0 || n < self.n_means + SAMPLES_EACH * (d + 1) {
            return None;
        }
        let scaled =
            |row: usize, at: usize| by.values[of[at]][row] / by.deviations[of[at]].max(1e-300);
        let ridge = (d, 1e-6 * (n as f64).sqrt());
        let factors = straight_lines::factors(n, d, ridge, scaled, |row| own[row] / deviation);
        let left = (0..n).map(|row| {
            let said: f64 = (0..d).map(|at| factors[at] * scaled(row, at)).sum();
            (own[row] / deviation - said).abs()
        });
        let (squares, most) = left.fold((0.0_f64, 0.0_f64), |(squares, most), left| {
            (squares + left * left, most.max(left))
        });
        let rounding =
            |of: &Self, channel: usize| 0.5 * of.resolutions[channel] / of.deviations[channel];
        let by_others = factors.iter().zip(of);
        let by_others = by_others.map(|(factor, at)| factor.abs() * rounding(by, *at));
        let by_others: Vec<f64> = by_others.collect();
        let of_own = rounding(self, channel);
        let of_others = by_others.iter().map(|own| own * own).sum::<f64>();
        let freedom = n - self.n_means - d;
        let left = (squares / freedom as f64).sqrt();
        // What is rounded is anywhere within half a step: its mean square is a third of that of the half.
        let made = [of_own * of_own, of_others, of_own * of_own + of_others];
        let is_as = |made: &f64| AS_ROUNDED.contains(&(left / (made / 3.0).sqrt()));
        let rounding = of_own + by_others.iter().sum::<f64>();
        left.is_finite().then(|| Explained {
            left,
            in_roundings: most / rounding.max(1e-300),
            rounding,
            is_rounding: made.iter().any(is_as),
            parts: factors.iter().map(|factor| factor.abs()).collect(),
        })
    }

    /// Whether some of the samples speak for it that two of them are one.
    fn may_be_same(&self, one: usize, other: usize) -> bool {
        let [one, other] = [one, other].map(|channel| &self.values[channel]);
        let step = one.len().div_ceil(256).max(1);
        let both = || one.iter().zip(other).step_by(step);
        let product = |of: fn((&f64, &f64)) -> f64| both().map(of).sum::<f64>();
        let squares = product(|(a, _)| a * a) * product(|(_, b)| b * b);
        product(|(a, b)| a * b).powi(2) >= MAY_BE_SAME.powi(2) * squares
    }
}

/// The step by whose multiples all of them differ; next to nothing where there is none, infinite where they are all the same.
fn least_step(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (sorted.first().unwrap_or(&0.0), sorted.last().unwrap_or(&0.0));
    let range = high - low;
    let steps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    let steps = steps.filter(|step| *step > 1e-9 * range);
    let least = steps.fold(f64::INFINITY, f64::min);
    let is_multiple = |value: &f64| {
        let steps = (value - low) / least;
        (steps - steps.round()).abs() < 0.02
    };
    match least.is_infinite() || sorted.iter().all(is_multiple) {
        true => least,
        false => 1e-9 * range,
    }
}

/// Whether a gauge makes the same step from sample to sample in every recording, and the load is no ramp.
fn is_clock(recordings: &[&Recording], gauge: usize) -> bool {
    let fewest = |own: &Recording| match own.is_static() {
        true => CLOCK_ROWS,
        false => CLOCK_SAMPLES,
    };
    let mut long = recordings.iter().filter(|own| own.n_samples() >= fewest(own));
    let mut said = None;
    let is_one = long.all(|recording| {
        let of_gauge = |k: usize| recording.gauges_at(k)[gauge];
        let n_axes = recording.axes().len();
        let of_load = |axis: usize| move |k: usize| recording.loads()[k * n_axes + axis];
        let is_ramp =
            || (0..n_axes).any(|axis| steps(recording, of_load(axis), RAMP_OFF).is_some());
        let own = steps(recording, of_gauge, CLOCK_OFF);
        let is_own = own.is_some() && *said.get_or_insert(own) == own;
        is_own && !is_ramp()
    });
    is_one && said.is_some()
}

/// Whether a channel rises, or falls, on a straight line over time or sample number but for `off`; or makes one step nearly always.
fn steps(recording: &Recording, value: impl Fn(usize) -> f64, off: f64) -> Option<bool> {
    let (n, times) = (recording.n_samples(), recording.times());
    let every = n.div_ceil(LOOKED_AT).max(1);
    let pairs = || (0..n - 1).step_by(every).map(|k| value(k + 1) - value(k));
    let (first, span) = (value(0), value(n - 1) - value(0));
    let is_strict = off > CLOCK_OFF || pairs().all(|step| step * span > 0.0);
    let is_line = |at: &dyn Fn(usize) -> f64| {
        let (start, length) = (at(0), at(n - 1) - at(0));
        let said = |k: usize| first + span * (at(k) - start) / length;
        length > 0.0
            && span != 0.0
            && (0..n).step_by(every).all(|k| (value(k) - said(k)).abs() <= off * span.abs())
    };
    if is_strict && (is_line(&|k| k as f64) || is_line(&|k| times[k])) {
        return Some(span > 0.0);
    }
    let step = median(pairs())?;
    let is_same = |own: &f64| (own - step).abs() <= 1e-6 * step.abs();
    let n_same = pairs().filter(is_same).count() as f64;
    let goes_on = pairs().all(|own| own != 0.0);
    (step != 0.0 && goes_on && n_same >= SAME_STEPS * pairs().count() as f64).then_some(step > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::recording::{Source, simulated};

    const N: usize = 3000;

    /// Gauges of a recording under the loads of a sample, and a generator of noise.
    type Make<'a> = &'a dyn Fn(usize, [f64; 3], &mut Random) -> Vec<f64>;

    /// Three axes that move on their own, given to two decimals, and the gauges that are made of them.
    fn recording(n_axes: usize, seed: u64, make: Make<'_>) -> Recording {
        let mut random = Random::new(seed, &[]);
        let (mut gauges, mut loads) = (Vec::new(), Vec::new());
        for k in 0..N {
            let t = 0.05 * k as f64 + seed as f64;
            let load =
                [10.0 * (0.9 * t).sin(), 8.0 * (1.3 * t).cos(), 20.0 * (0.7 * t + 1.0).sin() - 5.0];
            let load = load.map(|load| (100.0 * load).round() / 100.0);
            gauges.extend(make(k, load, &mut random));
            loads.extend(&load[3 - n_axes..]);
        }
        let names = (1..=gauges.len() / N).map(|at| format!("S{at}")).collect();
        let axes = [Axis::Fx, Axis::Fy, Axis::Fz][3 - n_axes..].to_vec();
        let times = (0..N).map(|k| 0.01 * k as f64).collect();
        Recording::new("r", Source::Simulated, times, names, gauges, axes, loads).unwrap()
    }

    fn of(n_axes: usize, make: Make<'_>) -> Vec<NoGauge> {
        let both = [1, 2].map(|seed| recording(n_axes, seed, make));
        no_gauges(&both.iter().collect::<Vec<_>>())
    }

    /// Four gauges with noise and some curvature.
    fn real([x, y, z]: [f64; 3], random: &mut Random) -> Vec<f64> {
        let mut noise = || 0.02 * random.normal();
        vec![
            x + 0.3 * y + 0.5 * z + noise(),
            -0.5 * x + y + 0.5 * z + 1e-3 * x * z + noise(),
            -0.5 * x - y + 0.5 * z + noise(),
            0.1 * x + 0.2 * y + z + noise(),
        ]
    }

    fn with(more: impl Fn(usize, [f64; 3], &[f64]) -> Vec<f64>) -> Vec<NoGauge> {
        of(3, &|k, load, random| {
            let real = real(load, random);
            let more = more(k, load, &real);
            [real, more].concat()
        })
    }

    #[test]
    fn gauges_are_gauges_however_good_and_computed_data_contradict_nothing() {
        assert_eq!(with(|_, _, _| Vec::new()), []);
        for n_axes in [1, 3] {
            let exact = of(n_axes, &|_, [x, y, z], _| vec![x + z, y - z, 2.0 * z, z + 0.1 * x]);
            let named = |one: &NoGauge| matches!(one, NoGauge::Clock(_) | NoGauge::Copy(..));
            assert!(!exact.iter().any(named), "{exact:?}");
        }
        assert_eq!(of(3, &|_, [x, y, z], _| vec![3.0 * x, y + z, z, x + y]), []);
        // A load cell of a part in ten thousand, alone and beside a poor one.
        let cell = |z: f64, random: &mut Random| 2.0 * z + 2e-5 * z * z + 1e-3 * random.normal();
        assert_eq!(of(1, &|_, [_, _, z], random| vec![cell(z, random)]), []);
        let beside = of(1, &|_, [x, _, z], random| vec![cell(z, random), z + x]);
        assert_eq!(beside, []);
        let all = simulated::recordings(simulated::DEFAULT_SEED);
        let all: Vec<&Recording> = all.entries().iter().map(|own| &*own.recording).collect();
        assert_eq!(no_gauges(&all), []);
    }

    #[test]
    fn a_load_among_the_gauges_is_named() {
        let one = with(|_, [_, _, z], _| vec![7.0 - 0.37 * z]);
        assert_eq!(one, [NoGauge::Reference("S5".into(), vec![Axis::Fz])]);
        let counts = with(|_, [x, _, _], _| vec![(812.5 * x).round()]);
        assert_eq!(counts, [NoGauge::Reference("S5".into(), vec![Axis::Fx])]);
        let raw = with(|_, [x, y, z], _| vec![0.2 * x + 0.1 * z, 0.3 * y, y - z - x]);
        let axes = |gauge: &str, axes: &[Axis]| NoGauge::Reference(gauge.into(), axes.to_vec());
        let expected = [
            axes("S5", &[Axis::Fx, Axis::Fz]),
            axes("S6", &[Axis::Fy]),
            axes("S7", &[Axis::Fx, Axis::Fy, Axis::Fz]),
        ];
        assert_eq!(raw, expected);
        assert!(raw[2].to_string().contains("Fx, Fy and Fz"));
        // On one axis, too, where the gauge beside it is a real one.
        let alone = of(1, &|_, [_, _, z], random| vec![z + 0.02 * random.normal(), 3.0 * z]);
        assert_eq!(alone, [NoGauge::Reference("S2".into(), vec![Axis::Fz])]);
        // All raw channels of a reference of which one axis was kept.
        let raw = of(1, &|_, [x, y, z], random| {
            [real([x, y, z], random), vec![x + y, x - z, 0.5 * y + z]].concat()
        });
        assert_eq!(raw, [NoGauge::Computed(Axis::Fz)]);
    }

    #[test]
    fn clocks_counters_and_gauges_that_are_there_twice_are_named() {
        let clock = |gauge: &str| NoGauge::Clock(gauge.into());
        let t = |k: usize| 1e9 + 10.0 * k as f64 + ((k * 7) % 3) as f64;
        assert_eq!(with(|k, _, _| vec![t(k)]), [clock("S5")]);
        assert_eq!(with(|k, _, _| vec![(k % 256) as f64, -(k as f64)]), ["S5", "S6"].map(clock));
        let twice = with(|_, _, real| vec![4.0 - 1.3 * real[1], real[0]]);
        let copy = |gauge: &str, of: &str| NoGauge::Copy(gauge.into(), of.into());
        assert_eq!(twice, [copy("S6", "S1"), copy("S5", "S2")]);
        // A slow ramp to the full load is no clock, nor are two gauges side by side one.
        let mut random = Random::new(4, &[]);
        let ramp: Vec<f64> = (0..N).map(|k| 0.01 * k as f64).collect();
        let gauges = ramp.iter().flat_map(|load| {
            let shared = 1e-3 * (0.1 * load).sin();
            [1.0, 1.1].map(|slope| slope * load + shared + 1e-3 * random.normal())
        });
        let one = Recording::new(
            "ramp",
            Source::Simulated,
            ramp.clone(),
            vec!["S1".into(), "S2".into()],
            gauges.collect(),
            vec![Axis::Fz],
            ramp,
        );
        assert_eq!(no_gauges(&[&one.unwrap()]), []);
    }

    #[test]
    fn a_table_says_the_same() {
        let whole = recording(3, 1, &|k, load, random| {
            [real(load, random), vec![load[1], (k / 100) as f64]].concat()
        });
        let rows = |k: usize| {
            let k = 100 * k;
            let own = Recording::new(
                "case",
                Source::Simulated,
                vec![0.0],
                whole.gauge_names().to_vec(),
                whole.gauges_at(k).to_vec(),
                whole.axes().to_vec(),
                whole.loads()[3 * k..3 * k + 3].to_vec(),
            );
            own.unwrap().without_times()
        };
        let cases: Vec<Recording> = (0..30).map(rows).collect();
        let found = no_gauges(&cases.iter().collect::<Vec<_>>());
        let expected =
            [NoGauge::Reference("S5".into(), vec![Axis::Fy]), NoGauge::Clock("S6".into())];
        assert_eq!(found, expected);
    }
}
