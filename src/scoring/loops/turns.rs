//! Finds the reversals of a load, and the branches between them.
//!
//! Guarantees: the samples are read once. Every sample lies in a branch, and neighbouring branches share the sample of the
//! reversal. At a reversal, the load turns back by more than the reversal threshold.
//!
//! Noise and range of the load on each axis, over several recordings.
//!
//! Rainflow counting: finds the cycles of a load, also those that contain smaller cycles.
//!
//! Guarantees: the counts are those of ASTM E1049 5.4.4, including the half cycles that remain (residue). A large cycle does
//! not depend on the small cycles within it. Each sample is read about twice.

use std::ops::Range;

use crate::{
    min_max::MinMax,
    recording::{Axis, Recording, RecordingSet, Role},
    scoring::quantile::quantile,
};

/// Default reversal threshold, as a multiple of the noise's standard deviation. White noise of 250,000 samples spans only 9.2
/// standard deviations.
pub const NOISE_FACTOR: f64 = 10.0;
/// Minimum of the default reversal threshold, as a share of the load's range.
pub const MIN_SHARE: f64 = 0.05;
/// Maximum number of fourth differences from which the noise of a recording's load is computed. This number determines the
/// noise to about 5 %.
const MAX_DIFFERENCES: usize = 1024;
/// Median magnitude of normally distributed numbers, in standard deviations.
const MEDIAN_OF_NORMAL: f64 = 0.674_489_750_196_081_7;

/// Interval of a recording in which the load rises or falls, between two reversals.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Samples from one reversal to the next, both included.
    pub samples: Range<usize>,
    pub rising: bool,
    pub loads: MinMax,
    /// Samples of smaller cycles within this branch, in the order of time.
    pub nested: Vec<Range<usize>>,
}

impl Branch {
    /// Returns the samples of this branch without those of smaller cycles within it.
    pub fn kept(&self) -> impl Iterator<Item = usize> {
        let starts =
            std::iter::once(self.samples.start).chain(self.nested.iter().map(|inner| inner.end));
        let ends = (self.nested.iter().map(|inner| inner.start)).chain([self.samples.end]);
        starts.zip(ends).flat_map(|(start, end)| start..end)
    }

    pub fn span(&self) -> f64 {
        self.loads.span()
    }
}

/// Splits the load of one recording at its reversals. `reversal_threshold` is in the unit of the load.
///
/// The branches cover the whole recording. A load that spans no more than the threshold has no branch.
pub fn branches(loads: &[f64], reversal_threshold: f64) -> Vec<Branch> {
    let (turns, first_rises) = turns(loads, reversal_threshold);
    let Some(mut rising) = first_rises else {
        return Vec::new();
    };
    let ends: Vec<usize> = std::iter::once(0).chain(turns).chain([loads.len() - 1]).collect();
    ends.windows(2)
        .map(|ends| {
            let samples = ends[0]..ends[1] + 1;
            let loads = loads[samples.clone()].iter().collect();
            let branch = Branch { samples, rising, loads, nested: Vec::new() };
            rising = !rising;
            branch
        })
        .collect()
}

/// Returns the samples of the reversals, and true if the load rises before the first reversal. `None` means that the load spans
/// no more than the reversal threshold.
fn turns(loads: &[f64], reversal_threshold: f64) -> (Vec<usize>, Option<bool>) {
    let mut turns = Vec::new();
    let (mut first_rises, mut rises) = (None, None);
    let (mut lowest, mut highest) = (0, 0);
    for (k, &load) in loads.iter().enumerate() {
        if load < loads[lowest] {
            lowest = k;
        }
        if load > loads[highest] {
            highest = k;
        }
        match rises {
            None if loads[highest] - loads[lowest] > reversal_threshold => {
                rises = Some(highest > lowest);
                first_rises = rises;
            }
            Some(true) if loads[highest] - load > reversal_threshold => {
                turns.push(highest);
                rises = Some(false);
                lowest = k;
            }
            Some(false) if load - loads[lowest] > reversal_threshold => {
                turns.push(lowest);
                rises = Some(true);
                highest = k;
            }
            _ => {}
        }
    }
    (turns, first_rises)
}

/// Noise and range of one axis' load in several recordings.
#[derive(Clone, Copy, Debug)]
pub struct LoadExtent {
    /// Standard deviation of the noise in the noisiest recording, in the unit of the load.
    pub noise: f64,
    /// Minimum and maximum load of all recordings.
    pub loads: MinMax,
}

impl Default for LoadExtent {
    fn default() -> Self {
        Self { noise: 0.0, loads: MinMax::NONE }
    }
}

impl LoadExtent {
    /// Returns the noise and range of the load in these recordings. A recording's noise is the median magnitude of the load's
    /// fourth differences, divided by `√70 · 0.674`. Fourth differences of white noise have `1 + 16 + 36 + 16 + 1 = 70` times
    /// its variance. A fast load affects them less than second differences, and the median ignores a few reversals and steps.
    pub fn of<'a>(recordings: impl IntoIterator<Item = &'a [f64]>) -> Self {
        let recordings = recordings.into_iter();
        let each =
            recordings.map(|loads| Self { noise: noise_of(loads), loads: loads.iter().collect() });
        each.fold(Self::default(), Self::with)
    }

    /// Returns the noise and range of the load in these recordings and the other recordings together.
    pub fn with(self, other: Self) -> Self {
        Self { noise: self.noise.max(other.noise), loads: self.loads.joined(other.loads) }
    }

    /// Returns the default reversal threshold, in the unit of the load: ten times the noise, but at least 5 % of the range.
    pub fn reversal_threshold(&self) -> f64 {
        (NOISE_FACTOR * self.noise).max(MIN_SHARE * self.loads.span())
    }
}

/// Returns the default reversal threshold, in the unit of the load; see [`LoadExtent::reversal_threshold`].
pub fn default_reversal_threshold<'a>(recordings: impl IntoIterator<Item = &'a [f64]>) -> f64 {
    LoadExtent::of(recordings).reversal_threshold()
}

/// Returns the standard deviation of the white noise in a load that is smooth otherwise.
fn noise_of(loads: &[f64]) -> f64 {
    let step = loads.len().div_ceil(MAX_DIFFERENCES).max(1);
    let mut sizes: Vec<f64> = loads
        .windows(5)
        .step_by(step)
        .map(|x| (x[0] + x[4] - 4.0 * (x[1] + x[3]) + 6.0 * x[2]).abs())
        .collect();
    quantile(&mut sizes, 0.5).unwrap_or(0.0) / (70.0_f64.sqrt() * MEDIAN_OF_NORMAL)
}

/// Returns the noise and range of each axis' load in these recordings. A recording without an axis is skipped for this axis.
pub fn extents_of<'a>(
    recordings: impl IntoIterator<Item = &'a Recording>,
    axes: &[Axis],
) -> Vec<LoadExtent> {
    let mut extents = vec![LoadExtent::default(); axes.len()];
    for recording in recordings {
        for (extent, axis) in extents.iter_mut().zip(axes) {
            if let Some(loads) = recording.load(*axis) {
                let loads: Vec<f64> = loads.collect();
                let mut found = LoadExtent::of([&loads[..]]);
                if recording.is_table() {
                    found.noise = 0.0; // the steps between readings are no noise
                }
                *extent = extent.with(found);
            }
        }
    }
    extents
}

/// Returns the noise and range of each axis' load in the training and test recordings. Without such recordings, it uses all
/// recordings.
pub fn extents_of_set(set: &RecordingSet, axes: &[Axis]) -> Vec<LoadExtent> {
    let entries = set.entries().iter();
    let used = entries.clone().filter(|entry| entry.role != Role::Off);
    if used.clone().next().is_some() {
        extents_of(used.map(|entry| &*entry.recording), axes)
    } else {
        extents_of(entries.map(|entry| &*entry.recording), axes)
    }
}

/// Closed cycles of one recording, and the half cycles that are left over.
#[derive(Debug, Default)]
pub struct Counted {
    /// The two branches of each closed cycle. The second branch ends where the load is back at the start of the first.
    pub closed: Vec<[Branch; 2]>,
    /// Half cycles in the order of time. Their ranges first grow and then shrink.
    pub residue: Vec<Branch>,
}

/// Counts the cycles of a recording from its branches.
///
/// **Source** ASTM E1049-85, 5.4.4, in the form with four reversals: the middle of three ranges is a cycle if neither
/// neighbour is smaller. The half cycles that are left over are the same as in the standard. If three ranges are equal, the
/// middle one is not taken as a cycle. Equal half cycles are later paired in the order of time, so the counts are the same.
pub fn count(branches: Vec<Branch>, loads: &[f64]) -> Counted {
    let mut counted = Counted::default();
    let residue = &mut counted.residue;
    for branch in branches {
        residue.push(branch);
        while let [.., before, middle, after] = &residue[..] {
            let (span, beside) = (middle.span(), [before.span(), after.span()]);
            let closes = beside.iter().all(|other| span <= *other);
            if !closes || beside == [span; 2] {
                break;
            }
            let three = <[Branch; 3]>::try_from(residue.split_off(residue.len() - 3));
            let [before, middle, mut after] = three.expect("three branches were taken");
            let back = closing_sample(&middle, &after, loads);
            let n_within = (after.nested).partition_point(|nested| nested.end <= back);
            let rest = after.nested.split_off(n_within);
            let end = middle.samples.end - 1;
            let mut nested = before.nested;
            nested.push(before.samples.end..back);
            nested.extend(rest);
            residue.push(Branch {
                samples: before.samples.start..after.samples.end,
                rising: before.rising,
                loads: before.loads.joined(after.loads),
                nested,
            });
            let mut second = Branch {
                samples: end..back + 1,
                rising: after.rising,
                nested: after.nested,
                ..middle
            };
            second.loads = second.loads.with(loads[back]);
            counted.closed.push([middle, second]);
        }
    }
    counted
}

/// Returns the first sample of the branch `after` at which the load is back at the start of the branch `first`.
fn closing_sample(first: &Branch, after: &Branch, loads: &[f64]) -> usize {
    let is_back = |k: &usize| {
        if after.rising { loads[*k] >= first.loads.max } else { loads[*k] <= first.loads.min }
    };
    let last = after.samples.end - 1;
    after.kept().find(is_back).unwrap_or(last)
}

/// Pairs neighbouring half cycles to cycles, and returns the index of the first half cycle of each pair. A half cycle is in
/// at most one pair. The pairs have the largest possible sum of squared common load ranges.
pub fn pairs(residue: &[Branch]) -> Vec<usize> {
    let common =
        |at: usize| MinMax::common(residue[at..at + 2].iter().map(|half| half.loads)).span();
    // Dynamic programming: for the first n half cycles, the largest sum of squares, and true if the last two of them form a
    // pair.
    let mut best = vec![(0.0, false); residue.len() + 1];
    for n in 2..=residue.len() {
        let paired = best[n - 2].0 + common(n - 2) * common(n - 2);
        let alone = best[n - 1].0;
        best[n] = (paired.max(alone), paired > alone);
    }
    let mut pairs = Vec::new();
    let mut n = residue.len();
    while n > 0 {
        let is_pair = best[n].1;
        n -= 1 + usize::from(is_pair);
        if is_pair {
            pairs.push(n);
        }
    }
    pairs.reverse();
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reproducible pseudo-random numbers in ±1.
    fn uniform(k: usize) -> f64 {
        let mixed = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    #[test]
    fn a_turn_counts_once_the_load_is_back_by_more_than_the_reversal_threshold() {
        let loads = [0.0, 3.0, 2.0, 5.0, 1.0, 2.0, 0.0, 4.0];
        let ends = |reversal_threshold| -> Vec<_> {
            (branches(&loads, reversal_threshold).iter())
                .map(|branch| (branch.samples.start, branch.samples.end - 1, branch.rising))
                .collect()
        };
        assert_eq!(ends(1.0), [(0, 3, true), (3, 6, false), (6, 7, true)]);
        assert_eq!(ends(4.5), [(0, 3, true), (3, 7, false)]);
        assert_eq!(ends(0.0).len(), 7);
        assert_eq!(ends(5.0), []);
    }

    #[test]
    fn branches_know_their_range() {
        let found = branches(&[1.0, 0.9, 4.0, -2.0], 0.5);
        let ranges: Vec<_> = found.iter().map(|b| (b.loads.min, b.loads.max, b.span())).collect();
        assert_eq!(ranges, [(0.9, 4.0, 3.1), (-2.0, 4.0, 6.0)]);
    }

    #[test]
    fn a_constant_load_has_no_branch() {
        for loads in [&[][..], &[1.0], &[2.0; 9]] {
            assert_eq!(branches(loads, 0.0), []);
        }
    }

    /// Six sines with noise of ±0.1 have twelve turns, with any noise.
    #[test]
    fn the_default_reversal_threshold_keeps_noise_from_turning() {
        for amplitude in [0.0, 1e-3, 0.1] {
            let loads: Vec<f64> = (0..6000)
                .map(|k| (k as f64 * std::f64::consts::TAU / 1000.0).sin() + amplitude * uniform(k))
                .collect();
            let reversal_threshold = default_reversal_threshold([&loads[..]]);
            assert_eq!(branches(&loads, reversal_threshold).len(), 13, "{amplitude}");
        }
        let still: Vec<f64> = (0..6000).map(|k| 7.0 + 0.1 * uniform(k)).collect();
        assert_eq!(branches(&still, default_reversal_threshold([&still[..]])), []);
    }

    /// Uniform noise in ±1 has a standard deviation of 0.577. The distribution of its fourth differences is nearly normal.
    #[test]
    fn noise_is_measured_on_a_moving_load() {
        let loads: Vec<f64> =
            (0..4000).map(|k| 100.0 * (k as f64 / 50.0).sin() + uniform(k)).collect();
        assert!((LoadExtent::of([&loads[..]]).noise / (1.0_f64 / 3.0).sqrt() - 1.0).abs() < 0.1);
        assert_eq!(LoadExtent::of([&[1.0, 5.0, 2.0][..]]).noise, 0.0);
    }

    #[test]
    fn the_default_reversal_threshold_is_at_least_a_share_of_the_whole_range() {
        let (low, high) = ([0.0; 20], [50.0; 20]);
        assert_eq!(default_reversal_threshold([&low[..], &high[..]]), 2.5);
        assert_eq!(default_reversal_threshold([]), 0.0);
    }
}

#[cfg(test)]
mod rainflow_tests {
    use crate::scoring::loops::turns::branches;
    use crate::scoring::loops::turns::*;

    fn counted(loads: &[f64]) -> Counted {
        count(branches(loads, 0.0), loads)
    }

    /// Returns the count of each range, largest first. A half cycle counts 0.5.
    fn counts(ranges: impl IntoIterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
        let mut ranges: Vec<_> = ranges.into_iter().collect();
        ranges.sort_by(|a, b| b.0.total_cmp(&a.0));
        let same = ranges.chunk_by(|a, b| (a.0 - b.0).abs() < 1e-9);
        same.map(|same| (same[0].0, same.iter().map(|one| one.1).sum())).collect()
    }

    fn counts_of(loads: &[f64]) -> Vec<(f64, f64)> {
        let found = counted(loads);
        let closed = found.closed.iter().map(|pair| (pair[0].span(), 1.0));
        counts(closed.chain(found.residue.iter().map(|half| (half.span(), 0.5))))
    }

    /// Counts step by step by the standard: counts and removes the first range that is at most as large as the next one. A
    /// range with the starting point counts 0.5.
    fn slowly(loads: &[f64]) -> Vec<(f64, f64)> {
        let mut points: Vec<f64> = loads.to_vec();
        points.dedup();
        let is_turn = |w: &[f64]| (w[1] - w[0]) * (w[2] - w[1]) < 0.0;
        let turns = points.windows(3).filter(|w| is_turn(w)).map(|w| w[1]);
        let mut points: Vec<f64> = (points.first().copied().into_iter())
            .chain(turns)
            .chain(points.last().copied())
            .collect();
        points.dedup();
        let mut found = Vec::new();
        'again: loop {
            for at in 2..points.len() {
                let range = |k: usize| (points[k] - points[k - 1]).abs();
                if range(at) >= range(at - 1) {
                    let holds_start = at == 2;
                    found.push((range(at - 1), if holds_start { 0.5 } else { 1.0 }));
                    points.drain(if holds_start { 0..1 } else { at - 2..at });
                    continue 'again;
                }
            }
            break;
        }
        found.extend(points.windows(2).map(|w| ((w[1] - w[0]).abs(), 0.5)));
        counts(found)
    }

    /// ASTM E1049-85, 5.4.4 and figure 6: ranges 3, 4, 6, 8, 9 occur 0.5, 1.5, 0.5, 1.0 and 0.5 times.
    #[test]
    fn the_example_of_the_standard_has_its_counts() {
        let loads = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0];
        let expected = [(9.0, 0.5), (8.0, 1.0), (6.0, 0.5), (4.0, 1.5), (3.0, 0.5)];
        assert_eq!(counts_of(&loads), expected);
        assert_eq!(slowly(&loads), expected);
    }

    #[test]
    fn counts_are_those_of_the_standards_words() {
        let mut state = 1_u64;
        let mut next = move |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((state >> 33) % n) as f64
        };
        for case in 0..300 {
            // With few levels many ranges are equal, with many levels hardly any.
            let levels = [3, 8, 1_000_000][case % 3];
            let loads: Vec<f64> = (0..2 + case).map(|_| next(levels)).collect();
            assert_eq!(counts_of(&loads), slowly(&loads), "{loads:?}");
        }
    }

    /// The load rises to 10, with a dip from 6 to 4 on the way, and falls again.
    #[test]
    fn a_small_cycle_is_left_out_of_the_large_one() {
        let loads = [0.0, 3.0, 6.0, 4.0, 5.0, 7.0, 10.0, 5.0, 0.0];
        let found = counted(&loads);
        let [dip] = &found.closed[..] else { panic!("one small cycle: {found:?}") };
        assert_eq!((dip[0].samples.clone(), dip[1].samples.clone()), (2..4, 3..6));
        let [up, down] = &found.residue[..] else { panic!("up and down: {found:?}") };
        assert_eq!(up.kept().collect::<Vec<_>>(), [0, 1, 2, 5, 6]);
        assert_eq!((up.loads.ends(), up.rising), (Some((0.0, 10.0)), true));
        assert_eq!(down.samples, 6..9);
        assert_eq!(pairs(&found.residue), [0]);
    }

    /// Small cycles lie within a cycle within another one; the outermost rises or falls.
    #[test]
    fn cycles_nest_to_any_depth() {
        let inwards: Vec<f64> =
            (0..40).map(|k| f64::from(40 - k) * if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let loads = [&inwards[..], &[41.0, -41.0]].concat();
        for loads in [loads.clone(), loads.iter().map(|load| -load).collect()] {
            let found = counted(&loads);
            assert_eq!(found.closed.len(), 19);
            for [first, second] in &found.closed {
                let common = MinMax::common([first.loads, second.loads].into_iter());
                assert_eq!(common.span(), first.span());
                assert_eq!(second.samples.start, first.samples.end - 1);
            }
            assert_eq!(counts_of(&loads), slowly(&loads));
        }
    }

    #[test]
    fn equal_half_cycles_pair_in_the_order_of_time_and_the_widest_are_not_torn() {
        let starts = |loads: &[f64]| pairs(&branches(loads, 0.0));
        assert_eq!(starts(&[0.0, 9.0, 0.0, 9.0, 0.0, 9.0]), [0, 2]);
        assert_eq!(starts(&[0.0, 3.0, -7.0, 7.0, 1.0]), [1]);
        assert_eq!(starts(&[0.0, 1.0]), [0_usize; 0]);
    }
}
