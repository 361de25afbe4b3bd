//! Samples that a sensor, its logger or its reference got wrong: clipped, stuck, dropped out, spikes, overload.
//!
//! What one channel should show is expected of the others: of the reference load for a gauge, of the gauges for a load, of the other
//! gauges where there is no reference. So a sensor at rest is not taken for a clipped one, nor a blow for a spike.
//!
//! **Shapes** samples are counted in the recording that is looked at.

mod misread;
mod noisy;

use std::fmt;
use std::ops::Range;

use rayon::prelude::*;

use crate::recording::{GaugeRange, Judged, LeftOut, Recording, ValidRange, median};
use crate::scoring::quantile::quantile;
use crate::scoring::straight_lines;

/// Samples that say what to expect of a channel; of more, as many spread evenly.
const LOOKED_AT: usize = 4096;
/// A channel that is expected to move by this share of its range, and so many standard deviations of what the others say of it,
/// does not stand still by itself.
const MOVES: (f64, f64) = (0.1, 6.0);
/// So many equal values in a row are stuck, if the others move.
const STUCK_SAMPLES: usize = 10;
/// Of load cases, which differ, so many.
const STUCK_CASES: usize = 4;
/// A jump is so many times the usual step, and this share of the range.
const JUMP: (f64, f64) = (30.0, 0.05);
/// Of a jump that is real, the others show at least this share.
const SHOWN_BY_OTHERS: f64 = 0.3;
/// What repeats one value this share of the span, and so many standard deviations, from where the others say that it is, dropped out.
const ELSEWHERE: (f64, f64) = (0.5, 20.0);
/// After a spike the channel is where it was, but for this share of it.
const BACK_AGAIN: f64 = 0.25;
/// No spike is longer than this (samples) …
const SPIKE_SAMPLES: usize = 3;
/// … and no dropout, unless it is stuck.
const DROPOUT_SAMPLES: usize = 50;
/// An auxiliary channel that drops out jumps by so many times what it does on nearly all samples ...
const AUXILIARY_JUMP: f64 = 20.0;
/// ... and not on more than this share of the samples: then it is a switch.
const DROPOUT_SHARE: f64 = 0.05;
/// A channel whose range is so many times its usual step carries more than noise.
const SIGNAL: f64 = 20.0;
/// An extreme is clipped if it is so many times as frequent as each of the values beside it.
const PILES_UP: usize = 3;

/// A channel of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    /// A gauge by its position.
    Gauge(usize),
    /// An axis of the reference by its position.
    Load(usize),
    /// An auxiliary channel by its position.
    Auxiliary(usize),
}

impl Channel {
    fn of(self, recording: &Recording, k: usize) -> f64 {
        match self {
            Self::Gauge(gauge) => recording.gauges_at(k)[gauge],
            Self::Load(axis) => recording.loads()[k * recording.axes().len() + axis],
            Self::Auxiliary(at) => recording.auxiliary().at(k)[at],
        }
    }

    /// What it is called.
    pub fn name(self, recording: &Recording) -> &str {
        match self {
            Self::Gauge(gauge) => &recording.gauge_names()[gauge],
            Self::Load(axis) => recording.axes()[axis].symbol(),
            Self::Auxiliary(at) => &recording.auxiliary().names()[at],
        }
    }
}

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaultKind {
    /// It stands at the end of what the logger can write, where the load goes on.
    Saturated,
    /// It repeats one value, or noise around one, while the load moves.
    Stuck,
    /// For some samples it shows a value that it shows nowhere near, such as zero.
    Dropout,
    /// A few samples are far off, and no other channel shows it.
    Spike,
    /// The load is beyond the rated one.
    Overload,
    /// It shows one value throughout.
    Dead,
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Saturated => "saturated",
            Self::Stuck => "stuck",
            Self::Dropout => "dropped out",
            Self::Spike => "spikes",
            Self::Overload => "overloaded",
            Self::Dead => "dead",
        })
    }
}

/// One fault of one channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What is wrong.
    pub kind: FaultKind,
    /// With what.
    pub channel: Channel,
    /// From when to when.
    pub samples: Range<usize>,
}

/// What is wrong with a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    /// Each channel's, in order of kind, channel and time.
    pub found: Vec<Fault>,
    /// Between which values each gauge is not clipped, as the logger writes them, where it is clipped.
    pub unclipped: Vec<(Option<f64>, Option<f64>)>,
}

impl Faults {
    /// The samples that cannot be used, in order and apart. A dead channel spoils no sample.
    pub fn samples(&self) -> Vec<Range<usize>> {
        let spoiled = |fault: &&Fault| fault.kind != FaultKind::Dead;
        let faults = self.found.iter().filter(spoiled);
        let mut ranges: Vec<Range<usize>> = faults.map(|fault| fault.samples.clone()).collect();
        ranges.sort_by_key(|range| range.start);
        joined(ranges)
    }

    /// How many samples cannot be used.
    pub fn n_samples(&self) -> usize {
        self.samples().iter().map(ExactSizeIterator::len).sum()
    }

    /// Each kind in words, with how many samples and which channels: `30 saturated (S3 S4)`.
    pub fn in_words(&self, recording: &Recording) -> Vec<String> {
        let kinds = self.found.chunk_by(|a, b| a.kind == b.kind);
        let words = kinds.map(|faults| {
            let kind = faults[0].kind;
            let mut channels: Vec<&str> = Vec::new();
            for fault in faults {
                let name = fault.channel.name(recording);
                if !channels.contains(&name) {
                    channels.push(name);
                }
            }
            let named = match &channels[..] {
                [first, .., last] if channels.len() > 8 => format!("{first} … {last}"),
                all => all.join(" "),
            };
            let own = Self { found: faults.to_vec(), ..Self::default() };
            match kind {
                FaultKind::Dead => format!("{named} {kind}: one value throughout"),
                _ => format!("{} {kind} ({named})", own.n_samples()),
            }
        });
        words.collect()
    }

    /// The recording without the samples that cannot be used: one, or more where history must not cross what is missing; none where
    /// nothing remains.
    pub fn left_out_of(&self, recording: &Recording, range: &ValidRange) -> Vec<Recording> {
        let left_out = LeftOut {
            of: recording.name().to_owned(),
            judged: Judged { range: range.clone(), tared: recording.tare() },
            n_samples: self.n_samples(),
            unclipped: self.unclipped.clone(),
        };
        recording.without(&self.samples(), &left_out)
    }
}

/// What is wrong with each of these recordings. Load cases of one table are judged together: each alone says next to nothing.
pub fn faults_of(recordings: &[&Recording], range: &ValidRange) -> Vec<Faults> {
    let mut all: Vec<Option<Faults>> = vec![None; recordings.len()];
    for at in 0..recordings.len() {
        if all[at].is_some() {
            continue;
        }
        let first = recordings[at];
        if !first.is_static() {
            all[at] = Some(faults(first, range));
            continue;
        }
        let is_own = |of: &usize| {
            let other = recordings[*of];
            let is_alike = other.axes() == first.axes() && other.n_gauges() == first.n_gauges();
            other.is_static() && is_alike && other.source() == first.source()
        };
        let own: Vec<usize> = (at..recordings.len()).filter(is_own).collect();
        let cases: Vec<&Recording> = own.iter().map(|of| recordings[*of]).collect();
        let Faults { found, unclipped } = faults(&Recording::table_of(&cases), range);
        let mut start = 0;
        for of in own {
            let rows = start..start + recordings[of].n_samples();
            start = rows.end;
            let of_case = found.iter().filter_map(|fault| {
                let from = fault.samples.start.max(rows.start);
                let to = fault.samples.end.min(rows.end);
                (from < to)
                    .then(|| Fault { samples: from - rows.start..to - rows.start, ..fault.clone() })
            });
            all[of] = Some(Faults { found: of_case.collect(), unclipped: unclipped.clone() });
        }
    }
    all.into_iter().flatten().collect()
}

/// What is wrong with a recording, as far as its channels and what is known of them say.
pub fn faults(recording: &Recording, range: &ValidRange) -> Faults {
    let gauges = (0..recording.n_gauges()).map(Channel::Gauge);
    let loads = (0..recording.axes().len()).map(Channel::Load);
    let channels: Vec<Channel> = gauges.chain(loads).collect();
    let own = channels.par_iter().map(|channel| Own::of(recording, *channel));
    let own: Vec<Own> = own.collect();
    let moves = |own: &&Own| own.high > own.low;
    let moving: Vec<Channel> = own.iter().filter(moves).map(|own| own.channel).collect();
    // More than noise does: then a channel of one value is no resting one.
    let something_moves = match recording.is_static() {
        // From one load case to the next a step is no noise: they differ where a load does.
        true => own.iter().any(|own| matches!(own.channel, Channel::Load(_)) && moves(&own)),
        false => own.iter().any(|own| own.span > SIGNAL * own.step),
    };
    let of_channel = |own: &Own| {
        let mut found: Vec<Fault> = Vec::new();
        if !moves(&own) {
            if matches!(own.channel, Channel::Gauge(_)) && something_moves {
                found.push(Fault {
                    kind: FaultKind::Dead,
                    channel: own.channel,
                    samples: 0..recording.n_samples(),
                });
            }
            return (found, Vec::new(), (None, None), None);
        }
        let is_load = |channel: &Channel| matches!(channel, Channel::Load(_));
        let others = |wanted: bool| -> Vec<Channel> {
            let others = moving.iter().filter(|other| is_load(other) == wanted);
            let others = others.copied().filter(|other| *other != own.channel);
            others.collect()
        };
        let by = match own.channel {
            Channel::Load(_) | Channel::Auxiliary(_) => others(false),
            Channel::Gauge(_) if moving.iter().any(is_load) => others(true),
            Channel::Gauge(_) => others(false),
        };
        let expected = Expected::of(recording, own, by, |_| false);
        let channel = Watched { recording, own, expected: expected.as_ref() };
        let unclipped = channel.clipped(range.gauges.as_ref(), &mut found);
        channel.stuck(&mut found);
        let mut in_noise = Vec::new();
        // The order of load cases is none, so nothing jumps.
        if !recording.is_static() {
            channel.jumps(&mut found);
            in_noise = channel.stuck_in_noise(&found);
        }
        (found, in_noise, unclipped, expected)
    };
    let watched: Vec<_> = own.par_iter().map(of_channel).collect();
    let (mut found, mut unclipped, mut expected) = (Vec::new(), Vec::new(), Vec::new());
    let mut in_noise = Vec::new();
    for (own, own_in_noise, limits, of_others) in watched {
        found.extend(own);
        in_noise.extend(own_in_noise);
        unclipped.push(limits);
        expected.push(of_others);
    }
    // Where what says what to expect is wrong itself, it accuses nobody.
    let is_sure = |fault: &Fault| {
        let others = found.iter().filter(|other| other.channel != fault.channel);
        let shared = others.map(|other| {
            let start = other.samples.start.max(fault.samples.start);
            other.samples.end.min(fault.samples.end).saturating_sub(start)
        });
        shared.sum::<usize>() < fault.samples.len() / 10
    };
    in_noise.retain(is_sure);
    found.extend(in_noise);
    if recording.is_static() {
        let channels: Vec<_> = (own.iter()).zip(expected.iter().map(Option::as_ref)).collect();
        let misread = misread::misread(recording, &channels);
        let is_known = |fault: &Fault| {
            let mut known = found.iter().filter(|own| own.kind != FaultKind::Dead);
            known.any(|own| own.samples.contains(&fault.samples.start))
        };
        let misread: Vec<Fault> = misread.into_iter().filter(|own| !is_known(own)).collect();
        found.extend(misread);
    } else {
        let auxiliary = (0..recording.auxiliary().len()).map(Channel::Auxiliary);
        found.extend(auxiliary.flat_map(|channel| dropouts(recording, channel)));
    }
    unclipped.truncate(recording.n_gauges());
    let n_axes = recording.axes().len();
    for (axis, rated) in range.rated.iter().enumerate().take(n_axes) {
        let Some(rated) = rated else { continue };
        let loads = recording.loads()[axis..].iter().step_by(n_axes);
        let is_over = loads.map(|load| load.abs() > rated * (1.0 + 1e-9));
        push_runs(is_over, FaultKind::Overload, Channel::Load(axis), &mut found);
    }
    if unclipped.iter().all(|own| *own == (None, None)) {
        unclipped.clear();
    }
    found.sort_by_key(|fault| (fault.kind, fault.channel, fault.samples.start));
    Faults { found, unclipped }
}

/// A channel by itself.
#[derive(Debug)]
struct Own {
    channel: Channel,
    low: f64,
    high: f64,
    /// Where nearly all of its values lie: without what is far off.
    span: f64,
    /// The median step from sample to sample.
    step: f64,
    /// The least step that is not zero.
    resolution: f64,
    /// Its extremes, as far as they are so much more frequent than what lies beside them that the logger may end there.
    piles_up: Vec<f64>,
    /// Where it repeats one value, whatever the others do.
    flat: Vec<Range<usize>>,
}

impl Own {
    fn of(recording: &Recording, channel: Channel) -> Self {
        let n = recording.n_samples();
        let value = |k: usize| channel.of(recording, k);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut resolution = f64::INFINITY;
        let least = match recording.is_static() {
            true => STUCK_CASES,
            false => STUCK_SAMPLES,
        };
        let (mut flat, mut start) = (Vec::new(), 0);
        for k in 0..n {
            let own = value(k);
            if own != value(start) {
                flat.extend((k - start >= least).then_some(start..k));
                start = k;
            }
            (low, high) = (low.min(own), high.max(own));
            let step = if k > 0 { (own - value(k - 1)).abs() } else { 0.0 };
            if step > 0.0 {
                resolution = resolution.min(step);
            }
        }
        flat.extend((n - start >= least).then_some(start..n));
        let looked_at = looked_at(n);
        let mut values: Vec<f64> = looked_at.clone().map(value).collect();
        let [low_share, high_share] =
            [0.02, 0.98].map(|share| quantile(&mut values, share).unwrap_or(0.0));
        let steps = looked_at.filter(|k| *k > 0);
        let steps = median(steps.map(|k| (value(k) - value(k - 1)).abs()));
        let piles_up = |extreme: &f64, inward: f64| {
            let mut counts = [0_usize; 4];
            for k in 0..n {
                let steps = inward * (value(k) - extreme) / resolution;
                if steps < 3.25 && (steps - steps.round()).abs() < 0.25 {
                    counts[steps.round() as usize] += 1;
                }
            }
            let [at, beside @ ..] = counts;
            let most_beside = beside.into_iter().max().unwrap_or(0);
            low < high && at >= PILES_UP.max(PILES_UP * most_beside)
        };
        let ends = [(low, 1.0), (high, -1.0)].into_iter();
        let piles_up = ends.filter(|(extreme, inward)| piles_up(extreme, *inward));
        Self {
            channel,
            low,
            high,
            piles_up: piles_up.map(|(extreme, _)| extreme).collect(),
            flat,
            span: high_share - low_share,
            step: steps.unwrap_or(0.0),
            resolution,
        }
    }
}

fn looked_at(n: usize) -> std::iter::StepBy<Range<usize>> {
    (0..n).step_by(n.div_ceil(LOOKED_AT).max(1))
}

/// What the other channels say of one: a straight line in each.
#[derive(Debug)]
struct Expected {
    /// The channels, with the mean that is taken off and the factor.
    by: Vec<(Channel, f64, f64)>,
    constant: f64,
    /// How far off it is in general: a standard deviation, whatever lies far out.
    sigma: f64,
}

impl Expected {
    /// By least squares, three times: each time without what is far from the one before; values that are `odd` say nothing.
    fn of(
        recording: &Recording,
        own: &Own,
        by: Vec<Channel>,
        odd: impl Fn(f64) -> bool,
    ) -> Option<Self> {
        let all = || looked_at(recording.n_samples());
        let is_flat = |k: usize| {
            let at = own.flat.partition_point(|run| run.end <= k);
            own.flat.get(at).is_some_and(|run| run.start <= k)
        };
        let is_inside = |k: &usize| {
            let value = own.channel.of(recording, *k);
            !own.piles_up.contains(&value) && !odd(value) && !is_flat(*k)
        };
        let fewest = 2 * (by.len() + 1);
        // What may be clipped or stuck would bend the line.
        let mut samples: Vec<usize> = all().filter(is_inside).collect();
        if samples.len() < fewest {
            samples = all().collect();
        }
        if by.is_empty() || samples.len() < fewest {
            return None;
        }
        let scaled: Vec<(Channel, f64, f64)> = (by.into_iter())
            .map(|channel| {
                let values = samples.iter().map(|k| channel.of(recording, *k));
                let mean = values.clone().sum::<f64>() / samples.len() as f64;
                let squares: f64 = values.map(|value| (value - mean).powi(2)).sum();
                let deviation = (squares / samples.len() as f64).sqrt();
                (channel, mean, if deviation > 0.0 { 1.0 / deviation } else { 0.0 })
            })
            .collect();
        let mut found = None;
        for _ in 0..3 {
            let n = samples.len();
            let value = |k: usize| own.channel.of(recording, k);
            let mean = samples.iter().map(|k| value(*k)).sum::<f64>() / n as f64;
            let ridge = (scaled.len(), 1e-4 * (n as f64).sqrt());
            let of = |row: usize, column: usize| match scaled.get(column) {
                None => 1.0,
                Some((channel, mean, factor)) => {
                    (channel.of(recording, samples[row]) - mean) * factor
                }
            };
            let target = |row: usize| value(samples[row]) - mean;
            let solved = straight_lines::factors(n, scaled.len() + 1, ridge, of, target);
            let by = scaled.iter().enumerate();
            let mut expected = Self {
                by: by
                    .map(|(at, (channel, mean, factor))| (*channel, *mean, solved[at] * factor))
                    .collect(),
                constant: mean + solved[scaled.len()],
                sigma: 0.0,
            };
            let off = |k: &usize| (value(*k) - expected.at(recording, *k)).abs();
            let sigma = 1.4826 * median(samples.iter().map(off))?;
            let near: Vec<usize> =
                (samples.iter().copied()).filter(|k| off(k) <= 4.0 * sigma).collect();
            expected.sigma = sigma;
            let is_finite = expected.by.iter().all(|(_, _, factor)| factor.is_finite());
            found = Some(expected).filter(|_| is_finite && sigma.is_finite());
            if near.len() <= scaled.len() + 1 {
                break;
            }
            samples = near;
        }
        found
    }

    fn at(&self, recording: &Recording, k: usize) -> f64 {
        let by = self.by.iter();
        let by = by.map(|(channel, mean, factor)| (channel.of(recording, k) - mean) * factor);
        self.constant + by.sum::<f64>()
    }

    /// How far it goes in a run of samples, of which some are looked at; what a tenth of them says alone does not count.
    fn spread(&self, recording: &Recording, samples: impl ExactSizeIterator<Item = usize>) -> f64 {
        let every = samples.len().div_ceil(256).max(1);
        let values = samples.step_by(every).map(|k| self.at(recording, k));
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let cut = values.len().div_ceil(10);
        match values.len() > 2 * cut {
            true => values[values.len() - 1 - cut] - values[cut],
            false => 0.0,
        }
    }
}

/// A channel that is looked at.
struct Watched<'a> {
    recording: &'a Recording,
    own: &'a Own,
    expected: Option<&'a Expected>,
}

impl Watched<'_> {
    fn value(&self, k: usize) -> f64 {
        self.own.channel.of(self.recording, k)
    }

    fn n(&self) -> usize {
        self.recording.n_samples()
    }

    /// Whether the others say that it moves where it does not.
    fn should_move(&self, samples: impl ExactSizeIterator<Item = usize>) -> bool {
        let Own { span, resolution, .. } = self.own;
        self.expected.is_some_and(|expected| {
            let least = (MOVES.0 * span).max(MOVES.1 * expected.sigma.max(*resolution));
            expected.spread(self.recording, samples) > least
        })
    }

    /// Finds where the logger could not write more, and says between which values (as the logger writes them) it could.
    fn clipped(
        &self,
        entered: Option<&GaugeRange>,
        found: &mut Vec<Fault>,
    ) -> (Option<f64>, Option<f64>) {
        let Channel::Gauge(gauge) = self.own.channel else {
            return (None, None);
        };
        let entered = entered.and_then(|range| range.of(gauge));
        let tared_by = self.recording.tared_by(gauge);
        let limits = match entered {
            Some((low, high)) => (Some(low - tared_by), Some(high - tared_by)),
            None => {
                let limit = |extreme: f64, inward: f64| match self.is_clipped(extreme) {
                    true => Some(extreme),
                    false => self.noisy_limit(inward),
                };
                (limit(self.own.low, 1.0), limit(self.own.high, -1.0))
            }
        };
        let beyond = |k: usize| {
            let value = self.value(k);
            limits.0.is_some_and(|low| value <= low) || limits.1.is_some_and(|high| value >= high)
        };
        let beyond = (0..self.n()).map(beyond);
        push_runs(beyond, FaultKind::Saturated, self.own.channel, found);
        match entered {
            Some((low, high)) => (Some(low), Some(high)),
            None => [limits.0, limits.1].map(|limit| limit.map(|limit| limit + tared_by)).into(),
        }
    }

    /// Whether an extreme is where the logger ends: it is often exactly the same, and the others say that the channel should move there,
    /// and mostly farther out.
    fn is_clipped(&self, extreme: f64) -> bool {
        let Own { resolution, span, .. } = self.own;
        if !self.own.piles_up.contains(&extreme) {
            return false;
        }
        let at: Vec<usize> = (0..self.n()).filter(|k| self.value(*k) == extreme).collect();
        let inward = if extreme == self.own.high { -1.0 } else { 1.0 };
        let Some(expected) = self.expected else {
            return false;
        };
        let farther = at.iter().map(|k| inward * (extreme - expected.at(self.recording, *k)));
        let least = resolution.max(expected.sigma);
        let is_farther = median(farther).is_some_and(|farther| farther > least);
        let spread = expected.spread(self.recording, at.iter().copied());
        is_farther && spread > (3.0 * resolution).max(0.03 * span)
    }

    /// Finds where it repeats one value though the others say that it moves, or is elsewhere.
    fn stuck(&self, found: &mut Vec<Fault>) {
        for run in &self.own.flat {
            if is_known(found, run) {
                continue;
            }
            if !self.recording.is_static() && self.is_elsewhere(run) {
                found.push(self.fault(FaultKind::Dropout, run.clone()));
            } else if self.should_move(run.clone()) {
                found.push(self.fault(FaultKind::Stuck, run.clone()));
            }
        }
    }

    /// Whether it jumps to one value that is far from where the others say that it is, and jumps back.
    fn is_elsewhere(&self, run: &Range<usize>) -> bool {
        let Some(expected) = self.expected else {
            return false;
        };
        let value = self.value(run.start);
        let every = run.len().div_ceil(256).max(1);
        let off = run.clone().step_by(every);
        let off = median(off.map(|k| (value - expected.at(self.recording, k)).abs()));
        let least = (ELSEWHERE.0 * self.own.span).max(ELSEWHERE.1 * expected.sigma);
        let inside = [run.start.checked_sub(1), Some(run.end)];
        let mut beside = (inside.into_iter().flatten())
            .filter(|k| *k < self.n())
            .map(|k| (self.value(k) - value).abs())
            .peekable();
        let jumps = beside.peek().is_some();
        off.is_some_and(|off| off > least && jumps && beside.all(|jump| jump > 0.5 * off))
    }

    /// Finds where it jumps away and back, and nothing else does.
    fn jumps(&self, found: &mut Vec<Fault>) {
        let Own { step, span, resolution, .. } = self.own;
        let certain = if self.expected.is_some() { 1.0 } else { 2.0 };
        let least = certain * (JUMP.0 * step).max(JUMP.1 * span).max(4.0 * resolution);
        let mut away: Vec<(Range<usize>, bool)> = Vec::new();
        let mut k = 1;
        while k < self.n() {
            let jump = self.value(k) - self.value(k - 1);
            let end = match jump.abs() >= least {
                true => self.back_again(k, jump),
                false => None,
            };
            let Some(end) = end else {
                k += 1;
                continue;
            };
            let is_one_value = (k + 1..end).all(|at| self.value(at) == self.value(k));
            let is_short = end - k <= SPIKE_SAMPLES;
            let shown = self.expected.map_or(0.0, |expected| {
                let at = |k: usize| expected.at(self.recording, k);
                ((at(k) - at(k - 1)) / jump).max((at(end - 1) - at(end)) / jump)
            });
            if (is_one_value || is_short) && shown < SHOWN_BY_OTHERS {
                away.push((k..end, is_one_value));
                k = end;
            }
            k += 1;
        }
        // A value that comes again is one that stands for none.
        for (at, (samples, is_one_value)) in away.iter().enumerate() {
            let value = self.value(samples.start);
            let again = |(other, (samples, _)): (usize, &(Range<usize>, bool))| {
                other != at && self.value(samples.start) == value
            };
            let stands_for_none =
                value == 0.0 || samples.len() > SPIKE_SAMPLES || away.iter().enumerate().any(again);
            let kind = match *is_one_value && stands_for_none {
                true => FaultKind::Dropout,
                false => FaultKind::Spike,
            };
            if !is_known(found, samples) {
                found.push(self.fault(kind, samples.clone()));
            }
        }
    }

    /// Where a channel that jumped before sample `k` is back where it was.
    fn back_again(&self, k: usize, jump: f64) -> Option<usize> {
        let before = self.value(k - 1);
        let is_back = |at: &usize| (self.value(*at) - before).abs() <= BACK_AGAIN * jump.abs();
        (k + 1..self.n().min(k + 1 + DROPOUT_SAMPLES)).find(is_back)
    }

    fn fault(&self, kind: FaultKind, samples: Range<usize>) -> Fault {
        Fault { kind, channel: self.own.channel, samples }
    }
}

/// Ranges that are sorted by their starts, those that touch made one.
fn joined(ranges: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let mut joined: Vec<Range<usize>> = Vec::new();
    for range in ranges {
        match joined.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => joined.push(range),
        }
    }
    joined
}

/// Whether these samples have a fault already; `found` are those of one channel.
fn is_known(found: &[Fault], samples: &Range<usize>) -> bool {
    let is_all =
        |fault: &Fault| fault.samples.start <= samples.start && samples.end <= fault.samples.end;
    found.iter().any(is_all)
}

/// Where a channel that nothing says what to expect of, and that changes slowly, is one other value for a while: zero, or one that comes again.
fn dropouts(recording: &Recording, channel: Channel) -> Vec<Fault> {
    let n = recording.n_samples();
    let value = |k: usize| channel.of(recording, k);
    // Runs of one value; a channel that is written now and then has long ones.
    let mut starts: Vec<usize> = vec![0];
    starts.extend((1..n).filter(|k| value(*k) != value(k - 1)));
    let n_runs = starts.len();
    let longest = DROPOUT_SAMPLES.max(3 * n / n_runs.max(1));
    let ends = starts.iter().skip(1).chain([&n]).copied();
    let runs: Vec<Range<usize>> = starts.iter().copied().zip(ends).map(|(a, b)| a..b).collect();
    let looked_at = looked_at(n).filter(|k| *k > 0);
    let mut steps: Vec<f64> = looked_at.map(|k| (value(k) - value(k - 1)).abs()).collect();
    let usual = AUXILIARY_JUMP * quantile(&mut steps, 0.95).unwrap_or(0.0);
    let is_away = |at: &usize| {
        let [before, own, after] = [0, 1, 2].map(|next| value(runs[at + next - 1].start));
        let jump = own - before;
        let is_back = (after - before).abs() <= BACK_AGAIN * jump.abs();
        runs[*at].len() <= longest && jump.abs() > usual && is_back
    };
    let away: Vec<usize> = (1..n_runs.saturating_sub(1)).filter(is_away).collect();
    let own = |at: usize| value(runs[at].start);
    let jump = |at: usize| (own(at) - own(at - 1)).abs();
    let others = (1..n_runs).filter(|at| {
        let is_away = |at: &usize| away.binary_search(at).is_ok();
        !is_away(at) && !is_away(&(at - 1))
    });
    let step = median(others.map(jump));
    // What is a step of its own resolution is rounding, or a switch.
    let far = |at: &&usize| {
        let again = || away.iter().any(|other| *other != **at && own(*other) == own(**at));
        let is_far = step.is_none_or(|step| jump(**at) > 4.0 * step);
        is_far && (own(**at) == 0.0 || (step.is_some() && again()))
    };
    let found: Vec<Range<usize>> = away.iter().filter(far).map(|at| runs[*at].clone()).collect();
    let n_away: usize = found.iter().map(|run| run.len()).sum();
    if n_away as f64 > DROPOUT_SHARE * n as f64 {
        return Vec::new();
    }
    let fault = |samples: Range<usize>| Fault { kind: FaultKind::Dropout, channel, samples };
    found.into_iter().map(fault).collect()
}

/// Notes each run of samples that are so.
fn push_runs(
    samples: impl Iterator<Item = bool>,
    kind: FaultKind,
    channel: Channel,
    found: &mut Vec<Fault>,
) {
    let mut start = None;
    for (k, is_so) in samples.chain([false]).enumerate() {
        match (is_so, start) {
            (true, None) => start = Some(k),
            (false, Some(from)) => {
                found.push(Fault { kind, channel, samples: from..k });
                start = None;
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::recording::{Axis, Source, simulated};

    const N: usize = 2000;

    /// Two axes at 100 Hz that move on their own, and the first rests at times; three gauges that show them with some hysteresis and noise, in
    /// counts where `counts` says how fine.
    pub(crate) fn sensor(counts: Option<f64>) -> (Vec<f64>, Vec<f64>) {
        let mut random = Random::new(3, &[]);
        let (mut gauges, mut loads) = (Vec::new(), Vec::new());
        let mut play = 0.0_f64;
        for k in 0..N {
            let t = k as f64 / 100.0;
            let x = (20.0 * (0.7 * t).sin()).max(-5.0);
            let y = 3.0 * (1.3 * t + 1.0).sin() + 1.0 * (0.31 * t).cos();
            play = play.clamp(x - 1.0, x + 1.0);
            for (a, b) in [(1.0, 0.5), (-0.4, 2.0), (0.7, -1.5)] {
                let value = a * x + b * y + 0.05 * play + 0.02 * random.normal();
                gauges.push(counts.map_or(value, |counts| (value * counts).round()));
            }
            loads.extend([x, y]);
        }
        (gauges, loads)
    }

    pub(crate) fn recording(gauges: Vec<f64>, loads: Vec<f64>) -> Recording {
        let axes = match loads.len() / N {
            0 => Vec::new(),
            _ => vec![Axis::Fx, Axis::Fz],
        };
        let times = (0..N).map(|k| k as f64 / 100.0).collect();
        let names = ["S1", "S2", "S3"].map(str::to_owned).to_vec();
        Recording::new("r", Source::Simulated, times, names, gauges, axes, loads).unwrap()
    }

    pub(crate) fn words(recording: &Recording) -> Vec<String> {
        faults(recording, &ValidRange::default()).in_words(recording)
    }

    #[test]
    fn nothing_is_wrong_with_a_sensor_that_rests_turns_or_is_coarse() {
        for counts in [None, Some(1000.0), Some(10.0), Some(1.0)] {
            let (gauges, loads) = sensor(counts);
            for loads in [loads, Vec::new()] {
                let recording = recording(gauges.clone(), loads);
                assert_eq!(words(&recording), Vec::<String>::new(), "{counts:?}");
            }
        }
        for recording in simulated::recordings(simulated::DEFAULT_SEED).entries() {
            assert_eq!(words(&recording.recording), Vec::<String>::new());
        }
    }

    #[test]
    fn a_clipped_gauge_is_found_with_and_without_a_reference() {
        let (mut gauges, loads) = sensor(Some(100.0));
        for row in gauges.chunks_exact_mut(3) {
            row[0] = row[0].min(1500.0);
        }
        let clipped = gauges.iter().step_by(3).filter(|value| **value == 1500.0);
        let expected = format!("{} saturated (S1)", clipped.count());
        for loads in [loads, Vec::new()] {
            let recording = recording(gauges.clone(), loads);
            assert_eq!(words(&recording), [expected.as_str()]);
            let found = faults(&recording, &ValidRange::default());
            assert_eq!(found.unclipped[0], (None, Some(1500.0)));
            let rest = found.left_out_of(&recording, &ValidRange::default());
            assert!(rest.len() > 1, "the load goes on for longer than a gap");
            let left: usize = rest.iter().map(Recording::n_samples).sum();
            assert_eq!(left + found.n_samples(), N);
            assert!(rest.iter().all(|part| part.left_out().is_some()));
        }
    }

    #[test]
    fn limits_that_were_entered_are_those_of_the_logger_whatever_was_tared() {
        let (gauges, loads) = sensor(None);
        let range = ValidRange {
            gauges: Some(GaugeRange::All((-12.0, 12.0))),
            rated: vec![Some(19.0), None],
        };
        let recording = recording(gauges.clone(), loads.clone());
        let found = faults(&recording, &range);
        let outside = gauges.chunks_exact(3).zip(loads.chunks_exact(2));
        let outside = outside.filter(|(gauges, loads)| {
            gauges.iter().any(|gauge| gauge.abs() >= 12.0) || loads[0] > 19.0
        });
        assert_eq!(found.n_samples(), outside.count());
        assert!(found.in_words(&recording)[1].contains("overloaded (Fx)"));
        let tared = recording.tared("0:1".parse().unwrap()).unwrap().0;
        assert_eq!(faults(&tared, &range), found);
    }

    #[test]
    fn a_gauge_that_stands_still_over_load_cases_is_told() {
        let table = |change: &dyn Fn(usize, &mut [f64])| {
            let mut random = Random::new(8, &[]);
            let (mut gauges, mut loads) = (Vec::new(), Vec::new());
            for case in 0..24_usize {
                let load = [(case % 5) as f64 - 2.0, (case * 7 % 9) as f64 - 4.0];
                let mut row = [(1.0, 0.5), (-0.4, 2.0), (0.7, -1.5)]
                    .map(|(a, b)| (1e3 * (a * load[0] + b * load[1]) + random.normal()).round());
                change(case, &mut row);
                gauges.extend(row);
                loads.extend(load);
            }
            let recording = Recording::new(
                "cases",
                Source::Simulated,
                (0..24).map(f64::from).collect(),
                ["S1", "S2", "S3"].map(str::to_owned).to_vec(),
                gauges,
                vec![Axis::Fx, Axis::Fz],
                loads,
            );
            words(&recording.unwrap().without_times())
        };
        assert_eq!(table(&|_, _| {}), Vec::<String>::new());
        let dead = table(&|_, row| row[1] = 512.0);
        assert_eq!(dead, ["S2 dead: one value throughout"]);
        let stuck = table(&|case, row| {
            if (10..16).contains(&case) {
                row[1] = 512.0;
            }
        });
        assert_eq!(stuck, ["6 stuck (S2)"]);
    }

    #[test]
    fn spikes_dropouts_stuck_and_dead_channels_are_told_from_blows() {
        let (mut gauges, mut loads) = sensor(None);
        gauges[3 * 300] += 15.0; // a spike
        let far = |from: usize| (from..).find(|k| gauges[3 * k + 1].abs() > 4.0).unwrap();
        let (first, second) = (far(500), far(900));
        for k in [first, first + 1, second] {
            gauges[3 * k + 1] = 0.0;
        }
        for k in 1300..1400 {
            gauges[3 * k] = gauges[3 * 1300];
        }
        for k in 1500..1502 {
            // A blow: everything shows it.
            loads[2 * k] += 20.0;
            for (gauge, factor) in [1.0, -0.4, 0.7].into_iter().enumerate() {
                gauges[3 * k + gauge] += 20.0 * factor;
            }
        }
        loads[2 * 1700 + 1] = -999.0; // a value that is missing
        let recording = recording(gauges.clone(), loads.clone());
        assert_eq!(words(&recording), ["100 stuck (S1)", "3 dropped out (S2)", "2 spikes (S1 Fz)"]);
        for row in gauges.chunks_exact_mut(3) {
            row[1] = 0.3;
        }
        let dead = crate::scoring::faults::tests::recording(gauges, loads);
        assert_eq!(words(&dead).last().unwrap(), "S2 dead: one value throughout");
    }

    #[test]
    fn a_gauge_that_shows_zero_for_long_has_dropped_out() {
        for (from, to) in [(900, 1100), (0, 300), (1800, N)] {
            let (mut gauges, loads) = sensor(None);
            for (k, row) in gauges.chunks_exact_mut(3).enumerate() {
                row.iter_mut().for_each(|gauge| *gauge += 500.0);
                if (from..to).contains(&k) {
                    row[1] = 0.0;
                }
            }
            let found = words(&recording(gauges, loads));
            assert_eq!(found, [format!("{} dropped out (S2)", to - from)]);
        }
    }

    /// The worse it is, the less the rest of it says what it should show.
    #[test]
    fn a_channel_stuck_for_most_of_a_recording_is_found() {
        for stuck in [200, 600, 1400, 1800] {
            let (mut gauges, mut loads) = sensor(None);
            for k in 100..100 + stuck {
                gauges[3 * k] = gauges[300];
            }
            let found = words(&recording(gauges, loads.clone()));
            assert_eq!(found, [format!("{stuck} stuck (S1)")]);
            let (gauges, _) = sensor(None);
            for k in 100..100 + stuck {
                loads[2 * k] = loads[200];
            }
            let found = words(&recording(gauges, loads));
            assert!(found.iter().any(|own| own.contains("stuck (Fx)")), "{found:?}");
        }
    }

    /// One axis after another, in steps of dead weights, and gauges that show much of the others.
    #[test]
    fn a_reference_that_stands_between_steps_is_not_stuck() {
        let (mut gauges, mut loads) = (Vec::new(), Vec::new());
        let mut random = Random::new(3, &[]);
        let mut play = 0.0_f64;
        for k in 0..N {
            let step = f64::from([0, 1, 2, 3, 2, 1, 0, 0][k / 50 % 8]);
            let (x, y) = if k < N / 2 { (step, 0.0) } else { (0.0, step) };
            play = play.clamp(x + y - 1.0, x + y + 1.0);
            for (a, b) in [(1.0, 0.2), (0.2, 1.0), (0.3, -0.4)] {
                gauges.push(a * x + b * y + 1.5 * play * a + 1e-4 * random.normal());
            }
            loads.extend([x, y]);
        }
        assert_eq!(words(&recording(gauges, loads)), [""; 0]);
    }

    #[test]
    fn a_thermometer_that_drops_out_is_told_from_one_that_warms_switches_or_is_coarse() {
        let (gauges, loads) = sensor(None);
        let told = |channel: &dyn Fn(usize) -> f64| {
            let values = (0..N).map(channel).collect();
            let recording = recording(gauges.clone(), loads.clone());
            let with = recording.with_auxiliary(vec!["T".into()], vec!["°C".into()], values);
            words(&with.unwrap())
        };
        let mut random = Random::new(6, &[]);
        let noise: Vec<f64> = (0..N).map(|_| 0.02 * random.normal()).collect();
        let warms = |k: usize| 20.0 + 0.01 * k as f64 + noise[k];
        let coarse = |k: usize| (10.0 * warms(k)).round() / 10.0;
        let now_and_then = |k: usize| warms(k / 100 * 100);
        let is_out = |k: usize| [500, 1200, 1700].iter().any(|from| (*from..from + 7).contains(&k));
        for channel in [&warms as &dyn Fn(usize) -> f64, &coarse, &now_and_then, &|_| 21.5] {
            assert_eq!(told(channel), [""; 0]);
            for value in [0.0, -40.0] {
                let with_outs = |k: usize| if is_out(k) { value } else { channel(k) };
                // What stands still but for that may be a switch.
                if value == 0.0 || channel(0) != channel(N - 1) {
                    assert_eq!(told(&with_outs), ["21 dropped out (T)"], "{value}");
                }
            }
        }
        let switch = |k: usize| f64::from((k / 30).is_multiple_of(4));
        assert_eq!(told(&switch), [""; 0]);
        let pulses = |k: usize| if is_out(k) { 1.0 } else { 0.0 };
        assert_eq!(told(&pulses), [""; 0]);
    }

    #[test]
    fn load_cases_of_a_table_are_judged_together() {
        let (gauges, loads) = sensor(Some(100.0));
        let cases: Vec<Recording> = (0..60)
            .map(|case| {
                let k = 31 * case;
                let mut gauges = gauges[3 * k..3 * k + 3].to_vec();
                gauges[0] = gauges[0].min(1200.0);
                let axes = vec![Axis::Fx, Axis::Fz];
                let names = ["S1", "S2", "S3"].map(str::to_owned).to_vec();
                let loads = loads[2 * k..2 * k + 2].to_vec();
                let own =
                    Recording::new("c", Source::Simulated, vec![0.0], names, gauges, axes, loads);
                own.unwrap().without_times()
            })
            .collect();
        let all: Vec<&Recording> = cases.iter().collect();
        let found = faults_of(&all, &ValidRange::default());
        let clipped = |at: &usize| cases[*at].gauges()[0] == 1200.0;
        let expected: Vec<usize> = (0..60).filter(clipped).collect();
        assert!(expected.len() > 5, "{expected:?}");
        let actual: Vec<usize> = (0..60).filter(|at| found[*at].n_samples() > 0).collect();
        assert_eq!(actual, expected);
        let left = found[expected[0]].left_out_of(&cases[expected[0]], &ValidRange::default());
        assert!(left.is_empty(), "nothing is left of that case");
    }

    #[test]
    fn next_to_nothing_says_nothing() {
        let one = |values: Vec<f64>| {
            let times = (0..values.len()).map(|k| k as f64).collect();
            let loads = values.iter().map(|value| 2.0 * value).collect();
            let names = vec!["S1".to_owned()];
            let recording =
                Recording::new("r", Source::Simulated, times, names, values, vec![Axis::Fz], loads);
            words(&recording.unwrap())
        };
        assert_eq!(one(vec![1.0]), Vec::<String>::new());
        assert_eq!(one(vec![1.0; 50]), Vec::<String>::new());
        assert_eq!(one(vec![1.0, 2.0, 2.0, 2.0]), Vec::<String>::new());
        let steps = (0..60).map(|k| f64::from(k / 20)).collect();
        assert_eq!(one(steps), Vec::<String>::new());
    }
}
