//! Finds the reversals of a load, and the branches between them.
//!
//! Guarantees: the samples are read once. Every sample lies in a branch, and neighbouring branches share the sample of the
//! reversal. At a reversal, the load turns back by more than the reversal threshold.

use std::ops::Range;

use crate::{min_max::MinMax, scoring::quantile::quantile};

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
