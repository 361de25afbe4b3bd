//! Compares one channel with its expected values from other channels, and finds where it is saturated, stuck, dropped out, or
//! jumps.

use std::ops::Range;

use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};

use crate::{
    min_max::MinMax,
    recording::{Channel, GaugeRange, Recording, median},
    scoring::{
        faults::fault::{Fault, FaultKind},
        quantile::quantile,
        straight_lines,
    },
};

/// Maximum number of samples for the fit of the expected value. They are spread evenly over the recording.
const LOOKED_AT: usize = 4096;
/// Smallest movement of the expected value for which a channel that repeats one value counts as stuck: as a share of the
/// channel's range, and in standard deviations of the fit.
const MOVES: (f64, f64) = (0.1, 6.0);
/// Minimum number of equal values in a row for which a channel can count as stuck.
const STUCK_SAMPLES: usize = 10;
/// Minimum number of equal values in a row for which a channel can count as stuck in a table of static load cases, whose
/// loads all differ.
const STUCK_CASES: usize = 4;
/// Minimum number of samples exactly at the extreme for a channel to count as saturated, if its noise exceeds three steps of
/// the converter. Without saturation, each further sample repeats the extreme with a chance of about a tenth, so six are one
/// in a hundred thousand.
const REPEATS: usize = 6;
/// Maximum deviation from the expected value for a sample that still belongs to the fit, as a share of the channel's range.
const NEAR: f64 = 0.1;
/// Ridge of the fit, as a share of the length of each scaled column.
const RIDGE: f64 = 1e-4;
/// Number of fits of the expected value. Each fit leaves out the outliers of the fit before.
const FITS: usize = 3;
/// Smallest jump that counts as a spike or dropout: as a multiple of the channel's usual step between samples, and as a share
/// of its range.
const JUMP: (f64, f64) = (30.0, 0.05);
/// Share of a jump that the expected value must show too, so that the jump counts as a real movement.
const SHOWN_BY_OTHERS: f64 = 0.3;
/// Smallest deviation of a dropout from the expected value, as a share of the channel's range and in standard deviations of
/// the fit.
const ELSEWHERE: (f64, f64) = (0.5, 20.0);
/// Maximum difference between the values before and after a spike, as a share of the spike's height.
const BACK_AGAIN: f64 = 0.25;
/// Maximum length of a spike (samples).
const SPIKE_SAMPLES: usize = 3;
/// Maximum length of a dropout (samples) with jumps at both ends. A longer one counts as stuck.
const DROPOUT_SAMPLES: usize = 50;
/// Minimum ratio of the number of samples exactly at the extreme of a saturated channel to the number at each of the values
/// next to it.
const PILES_UP: usize = 3;
/// A value to which the channel returns in one of this number of samples, or more often, does not count for its usual step.
const OFTEN: usize = 20;

/// Properties of a channel that follow from its own values alone.
#[derive(Debug)]
pub struct Own {
    pub channel: Channel,
    pub low: f64,
    pub high: f64,
    /// Value that 2 % of the samples lie below.
    usual_low: f64,
    /// Range of the channel's values without the lowest and highest 2 %.
    pub span: f64,
    /// Median magnitude of the step from sample to sample.
    pub step: f64,
    /// Median deviation of three successive samples from a straight line, a measure of the noise.
    noise: f64,
    /// Smallest step between two samples that is not zero, which is taken as the step of the converter.
    pub resolution: f64,
    /// Minimum or maximum of the channel, if it is much more frequent than the values next to it. The range of the logger may
    /// end there.
    piles_up: Vec<f64>,
    /// Ranges of samples in which the channel repeats one value.
    flat: Vec<Range<usize>>,
    /// Median number of samples for which the channel keeps a value. It exceeds 1 if a logger repeats the values of a slower
    /// instrument.
    pub held: usize,
}

impl Own {
    pub fn of(channel: Channel, values: &[f64], is_static: bool) -> Self {
        let n = values.len();
        let MinMax { min: low, max: high } = values.iter().collect();
        let mut resolution = f64::INFINITY;
        let least = if is_static { STUCK_CASES } else { STUCK_SAMPLES };
        let (mut flat, mut repeats) = (Vec::new(), Vec::new());
        let (mut n_single, mut start) = (0, 0);
        for k in 1..=n {
            let step = if k < n { (values[k] - values[k - 1]).abs() } else { f64::INFINITY };
            if step == 0.0 {
                continue;
            }
            resolution = resolution.min(step);
            if k - start == 1 {
                n_single += 1;
            } else {
                repeats.push(k - start);
            }
            if k - start >= least {
                flat.push(start..k);
            }
            start = k;
        }
        let held = if n_single > (n_single + repeats.len()) / 2 {
            1
        } else {
            let lengths = std::iter::repeat_n(1, n_single).chain(repeats);
            median(lengths.map(|length| length as f64)).unwrap_or(1.0) as usize
        };
        // A load that is set by hand keeps its value for longer.
        let held = if held <= DROPOUT_SAMPLES { held } else { 1 };
        let looked_at = looked_at(n);
        let mut shown: Vec<f64> = looked_at.clone().map(|k| values[k]).collect();
        let [low_share, high_share] =
            [0.02, 0.98].map(|share| quantile(&mut shown, share).unwrap_or(0.0));
        let bends = looked_at.clone().filter(|k| k + 2 < n);
        let noise =
            median(bends.map(|k| straight_lines::bend([values[k], values[k + 1], values[k + 2]])));
        // A value to which the channel returns often may stand for a missing value. Steps to this value do not count as
        // usual steps.
        let returns = looked_at.clone().filter(|k| *k > 0 && values[*k] != values[k - 1]);
        let mut returns: Vec<u64> = returns.map(|k| values[k].to_bits()).collect();
        returns.sort_unstable();
        let often = returns.chunk_by(|a, b| a == b).max_by_key(|same| same.len());
        let often = often.filter(|same| OFTEN * same.len() > looked_at.len()).map(|same| same[0]);
        let is_usual = |k: usize| often.is_none_or(|bits| values[k].to_bits() != bits);
        // The step from one value to the next, even if the logger repeats each value.
        let steps = looked_at.filter(|k| *k >= held && is_usual(*k) && is_usual(k - held));
        let steps = median(steps.map(|k| (values[k] - values[k - held]).abs()));
        let piles_up = |extreme: f64, inward: f64| {
            let mut counts = [0_usize; 4];
            for value in values {
                let off = inward * (value - extreme);
                if off <= 4.0 * resolution {
                    let steps = off / resolution;
                    if steps < 3.25 && (steps - steps.round()).abs() < 0.25 {
                        counts[steps.round() as usize] += 1;
                    }
                }
            }
            let [at, beside @ ..] = counts;
            let most_beside = beside.into_iter().max().unwrap_or(0);
            low < high && at >= PILES_UP.max(PILES_UP * most_beside)
        };
        let ends = [(low, 1.0), (high, -1.0)].into_iter();
        let piles_up = ends.filter(|(extreme, inward)| piles_up(*extreme, *inward));
        Self {
            channel,
            low,
            high,
            piles_up: piles_up.map(|(extreme, _)| extreme).collect(),
            flat,
            held,
            usual_low: low_share,
            span: high_share - low_share,
            step: steps.unwrap_or(0.0),
            noise: noise.unwrap_or(0.0),
            resolution,
        }
    }
}

fn looked_at(n: usize) -> std::iter::StepBy<Range<usize>> {
    (0..n).step_by(n.div_ceil(LOOKED_AT).max(1))
}

/// Expected value of a channel: a linear function of the other channels.
#[derive(Debug)]
pub struct Expected {
    /// The other channels, each with its factor.
    by: Vec<(Channel, f64)>,
    constant: f64,
    /// Standard deviation of the channel from its expected value, robust against outliers.
    sigma: f64,
}

impl Expected {
    /// Fits the expected value of a channel by least squares [`FITS`] times, to the samples in which it is neither at an extreme
    /// nor stuck, each time without the outliers of the previous fit.
    pub fn of(recording: &Recording, own: &Own, by: &[Channel]) -> Option<Self> {
        let samples: Vec<usize> = looked_at(recording.n_samples()).collect();
        let values = |channel: &Channel| -> Vec<f64> {
            samples.iter().map(|k| channel.at(recording, *k)).collect()
        };
        let (value, others) = (values(&own.channel), by.iter().map(values).collect::<Vec<_>>());
        let is_flat = |k: usize| {
            let at = own.flat.partition_point(|run| run.end <= k);
            own.flat.get(at).is_some_and(|run| run.start <= k)
        };
        // Saturated or stuck samples would distort the fit. For a load they are included, because a load that is set in steps
        // stands still most of the time.
        let is_load = matches!(own.channel, Channel::Load(_));
        let is_inside = |row: &usize| {
            is_load || !(own.piles_up.contains(&value[*row]) || is_flat(samples[*row]))
        };
        let n = by.len();
        let fewest = 2 * (n + 1);
        let mut rows: Vec<usize> = (0..samples.len()).filter(is_inside).collect();
        if rows.len() < fewest {
            rows = (0..samples.len()).collect();
        }
        if n == 0 || rows.len() < fewest {
            return None;
        }
        // Mean and standard deviation of each of the other channels.
        let scales = others.iter().map(|values| {
            let values = || rows.iter().map(|row| values[*row]);
            let mean = values().sum::<f64>() / rows.len() as f64;
            let square = values().map(|value| (value - mean).powi(2)).sum::<f64>();
            let deviation = (square / rows.len() as f64).sqrt();
            (mean, if deviation > 0.0 { deviation } else { f64::INFINITY })
        });
        let scales: Vec<(f64, f64)> = scales.collect();
        let mut found = None;
        for _ in 0..FITS {
            let columns = Mat::from_fn(rows.len(), n + 1, |row, at| match scales.get(at) {
                Some((mean, deviation)) => (others[at][rows[row]] - mean) / deviation,
                None => 1.0,
            });
            let targets = Mat::from_fn(rows.len(), 1, |row, _| value[rows[row]]);
            // A small ridge shrinks the factors, because channels may be collinear.
            let mut products = columns.transpose() * &columns;
            (0..n).for_each(|at| products[(at, at)] += RIDGE * RIDGE * rows.len() as f64);
            let solved = products.llt(Side::Lower).ok()?.solve(columns.transpose() * &targets);
            let offs = targets - columns * &solved;
            let offs: Vec<f64> = offs.col(0).iter().map(|off| off.abs()).collect();
            let sigma = 1.4826 * median(offs.iter().copied())?;
            // If a load mostly stands still, the median error is small. The larger errors from hysteresis while it moves must
            // not count as outliers.
            let farthest = (4.0 * sigma).max(NEAR * own.span);
            let near = rows.iter().zip(&offs).filter(|(_, off)| **off <= farthest);
            let (near, offs): (Vec<usize>, Vec<f64>) = near.unzip();
            let squares: f64 = offs.iter().map(|off| off.powi(2)).sum();
            let sigma = sigma.max((squares / near.len().max(1) as f64).sqrt());
            let factors = scales.iter().enumerate().map(|(at, scale)| solved[(at, 0)] / scale.1);
            let by: Vec<(Channel, f64)> = by.iter().copied().zip(factors).collect();
            let means = by.iter().zip(&scales).map(|((_, factor), (mean, _))| factor * mean);
            let constant = solved[(n, 0)] - means.sum::<f64>();
            found = Some(Self { by, constant, sigma })
                .filter(|own| own.constant.is_finite() && own.sigma.is_finite());
            if near.len() <= n + 1 || near.len() == rows.len() {
                break;
            }
            rows = near;
        }
        found
    }

    pub fn at(&self, recording: &Recording, k: usize) -> f64 {
        let by = self.by.iter().map(|(channel, factor)| channel.at(recording, k) * factor);
        self.constant + by.sum::<f64>()
    }

    /// Returns the range of the expected values of these samples, without the lowest and the highest tenth. At most 256
    /// samples are used.
    fn spread(&self, recording: &Recording, samples: impl ExactSizeIterator<Item = usize>) -> f64 {
        let every = samples.len().div_ceil(256).max(1);
        let values = samples.step_by(every).map(|k| self.at(recording, k));
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let cut = values.len().div_ceil(10);
        if values.len() > 2 * cut { values[values.len() - 1 - cut] - values[cut] } else { 0.0 }
    }
}

/// Channel of a recording, with the properties of its values and the values that other channels predict for it.
pub struct Watched<'a> {
    pub recording: &'a Recording,
    pub own: &'a Own,
    pub values: &'a [f64],
    pub expected: Option<&'a Expected>,
    /// Largest number of samples by which a channel may be late, because its logger repeats the values of a slower instrument.
    pub held: usize,
}

impl Watched<'_> {
    pub fn value(&self, k: usize) -> f64 {
        self.values[k]
    }

    pub fn n(&self) -> usize {
        self.recording.n_samples()
    }

    /// Returns true if the expected value moves in an interval in which the channel does not. The first and last samples do
    /// not count, because a reference that is late may move there.
    fn should_move(&self, run: &Range<usize>) -> bool {
        let Own { span, resolution, .. } = self.own;
        let late = if self.held > 1 { self.held } else { 0 };
        let outer = if self.recording.is_static() {
            0
        } else {
            STUCK_SAMPLES.min(run.len() / 4).max(late).min(run.len() / 2)
        };
        let samples = run.start + outer..run.end - outer;
        self.expected.is_some_and(|expected| {
            let least = (MOVES.0 * span).max(MOVES.1 * expected.sigma.max(*resolution));
            expected.spread(self.recording, samples) > least
        })
    }

    /// Finds the saturated samples of a gauge. Returns the lower and upper limit of the logger, as far as they are known.
    pub fn clipped(
        &self,
        entered: Option<&GaugeRange>,
        found: &mut Vec<Fault>,
    ) -> (Option<f64>, Option<f64>) {
        let Channel::Gauge(gauge) = self.own.channel else {
            return (None, None);
        };
        let entered = entered.and_then(|range| range.of(gauge));
        let tared_by = self.recording.tared_by(gauge);
        let limit = |extreme: f64| self.is_clipped(extreme).then_some(extreme);
        let limits = match entered {
            Some((low, high)) => (Some(low - tared_by), Some(high - tared_by)),
            None => (limit(self.own.low), limit(self.own.high)),
        };
        let beyond = |k: usize| {
            let value = self.value(k);
            limits.0.is_some_and(|low| value <= low) || limits.1.is_some_and(|high| value >= high)
        };
        if limits != (None, None) {
            let beyond = (0..self.n()).map(beyond);
            push_runs(beyond, FaultKind::Saturated, self.own.channel, found);
        }
        match entered {
            Some((low, high)) => (Some(low), Some(high)),
            None => [limits.0, limits.1].map(|limit| limit.map(|limit| limit + tared_by)).into(),
        }
    }

    /// Returns true if the logger's range ends at this extreme: the channel repeats the extreme exactly, and its expected
    /// values move and lie mostly beyond it.
    fn is_clipped(&self, extreme: f64) -> bool {
        let Own { resolution, span, noise, .. } = self.own;
        let piles_up = self.own.piles_up.contains(&extreme);
        let Some(expected) = self.expected.filter(|_| piles_up) else {
            return false;
        };
        let at: Vec<usize> = (0..self.n()).filter(|k| self.value(*k) == extreme).collect();
        let inward = if extreme == self.own.high { -1.0 } else { 1.0 };
        let farther = at.iter().map(|k| inward * (extreme - expected.at(self.recording, *k)));
        let least = resolution.max(expected.sigma);
        let is_farther = median(farther).is_some_and(|farther| farther > least);
        let spread = expected.spread(self.recording, at.iter().copied());
        let moves = (3.0 * resolution).max((3.0 * expected.sigma).min(0.03 * span));
        let repeats_in_noise = at.len() >= REPEATS && *noise > 3.0 * resolution;
        is_farther && (spread > moves || repeats_in_noise)
    }

    /// Finds the intervals in which the channel repeats one value although its expected value moves or is far away.
    pub fn stuck(&self, found: &mut Vec<Fault>) {
        for run in &self.own.flat {
            if is_known(found, run) {
                continue;
            }
            if !self.recording.is_static() && self.is_elsewhere(run) {
                found.push(self.fault(FaultKind::Dropout, run.clone()));
            } else if self.should_move(run) {
                found.push(self.fault(FaultKind::Stuck, run.clone()));
            }
        }
    }

    /// Returns true if the channel jumps to a constant value far from its expected value, and back again.
    fn is_elsewhere(&self, run: &Range<usize>) -> bool {
        let Some(expected) = self.expected else {
            return false;
        };
        let value = self.value(run.start);
        let every = run.len().div_ceil(256).max(1);
        let off = run.clone().step_by(every);
        let off = median(off.map(|k| (value - expected.at(self.recording, k)).abs()));
        // A converter that flickers between values a step or two apart has not dropped out.
        let least = (ELSEWHERE.0 * self.own.span)
            .max(ELSEWHERE.1 * expected.sigma)
            .max(4.0 * self.own.resolution.min(self.own.high - self.own.low));
        let inside = [run.start.checked_sub(1), Some(run.end)];
        let mut beside = (inside.into_iter().flatten())
            .filter(|k| *k < self.n())
            .map(|k| (self.value(k) - value).abs())
            .peekable();
        let jumps = beside.peek().is_some();
        off.is_some_and(|off| off > least && jumps && beside.all(|jump| jump > 0.5 * off))
    }

    /// Finds the samples at which this channel jumps away and back, while the other channels do not.
    pub fn jumps(&self, found: &mut Vec<Fault>) {
        let Own { step, span, usual_low, resolution, .. } = self.own;
        let certain = if self.expected.is_some() { 1.0 } else { 2.0 };
        // The usual step is at least that of the expected value. Otherwise, the noise of the other channels would hide that
        // these channels jump, too.
        let expected_step = self.expected.and_then(|expected| {
            let at = |k: usize| expected.at(self.recording, k);
            let steps = looked_at(self.n()).filter(|k| *k > 0);
            median(steps.map(|k| (at(k) - at(k - 1)).abs()))
        });
        let step = step.max(expected_step.unwrap_or(0.0));
        let least = certain * (JUMP.0 * step).max(JUMP.1 * span).max(4.0 * resolution);
        let mut away: Vec<(Range<usize>, bool)> = Vec::new();
        let mut k = 1;
        while k < self.n() {
            let jump = self.value(k) - self.value(k - 1);
            // A channel that otherwise stays at one value may only flicker by a step of the converter. A jump to zero is more.
            let is_lost = *span == 0.0 && *usual_low != 0.0 && jump != 0.0 && self.value(k) == 0.0;
            let end = if jump.abs() >= least || is_lost { self.back_again(k, jump) } else { None };
            let Some(end) = end else {
                k += 1;
                continue;
            };
            let is_one_value = (k + 1..end).all(|at| self.value(at) == self.value(k));
            let is_short = end - k <= SPIKE_SAMPLES;
            let shown = self.expected.map_or(0.0, |expected| {
                let near = k.saturating_sub(self.held)..self.n().min(end + self.held);
                let values: MinMax = near.map(|k| expected.at(self.recording, k)).collect();
                values.span() / jump.abs()
            });
            if (is_one_value || is_short) && shown < SHOWN_BY_OTHERS {
                away.push((k..end, is_one_value));
                k = end;
            }
            k += 1;
        }
        // A value to which the channel jumps repeatedly stands for a missing value. If the channel never changes otherwise,
        // it may be a switch.
        let n_steps = || self.values.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let is_switch = !away.is_empty() && self.expected.is_none() && n_steps() <= 2 * away.len();
        for (at, (samples, is_one_value)) in away.iter().enumerate() {
            let value = self.value(samples.start);
            let again = |(other, (samples, _)): (usize, &(Range<usize>, bool))| {
                other != at && self.value(samples.start) == value
            };
            let recurs = samples.len() > SPIKE_SAMPLES || away.iter().enumerate().any(again);
            let stands_for_none = value == 0.0 || (recurs && !is_switch);
            let kind = if *is_one_value && stands_for_none {
                FaultKind::Dropout
            } else {
                FaultKind::Spike
            };
            if !is_known(found, samples) {
                found.push(self.fault(kind, samples.clone()));
            }
        }
    }

    /// Returns the sample at which a channel that jumped at sample `k` has returned to its value before the jump.
    fn back_again(&self, k: usize, jump: f64) -> Option<usize> {
        let before = self.value(k - 1);
        let is_back = |at: &usize| (self.value(*at) - before).abs() <= BACK_AGAIN * jump.abs();
        (k + 1..self.n().min(k + 1 + DROPOUT_SAMPLES)).find(is_back)
    }

    pub fn fault(&self, kind: FaultKind, samples: Range<usize>) -> Fault {
        Fault { kind, channel: self.own.channel, samples }
    }
}

/// Joins ranges of samples that touch or overlap. They must be sorted by their starts.
pub fn joined(ranges: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let mut joined: Vec<Range<usize>> = Vec::new();
    for range in ranges {
        match joined.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => joined.push(range),
        }
    }
    joined
}

/// Returns true if `found` already contains a fault of this channel over all these samples.
fn is_known(found: &[Fault], samples: &Range<usize>) -> bool {
    let is_all =
        |fault: &Fault| fault.samples.start <= samples.start && samples.end <= fault.samples.end;
    found.iter().any(is_all)
}

/// Adds a fault for each run of samples for which `samples` is true.
pub fn push_runs(
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
