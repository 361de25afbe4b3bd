//! Estimates the offset between the clocks of gauges and reference from the measured values. The user accepts or rejects the
//! estimate.
//!
//! The gauges follow the load, so at the right offset they explain most of the reference. The measure is R²: the share of the
//! reference's variance that a linear combination of the gauges explains. [`scoring::lag`](crate::scoring::lag) measures lags
//! of a fraction of a load cycle, and separates them from hysteresis. Here the clocks may be hours apart, and gauges and
//! reference have different sample times.

use serde::Serialize;

use super::join::Series;
use crate::{dot::dot, min_max::MinMax, recording::gap::median_step};

/// Minimum number of samples of the gauges, and of the reference.
const FEWEST_SAMPLES: usize = 16;
/// Maximum number of evenly spaced points, in the time that gauges and reference have in common, for the first (coarse)
/// search.
const COARSE_POINTS: f64 = 1024.0;
/// Maximum number of evenly spaced points, in the time that gauges and reference have in common, for the second (fine)
/// search.
const FINE_POINTS: f64 = 16_384.0;
/// Maximum clock offset that is tried, as a share of the time that gauges and reference have in common.
const LARGEST_SHARE: f64 = 0.2;
/// Difference in R² up to which two clock offsets count as equally good; half of the unexplained share, if that is larger.
/// Repeated loads fit nearly as well at many offsets, so the smallest of the equally good offsets is returned.
const EXPLAINED_TOLERANCE: f64 = 0.01;
/// Minimum share of a gauge's variance that the other gauges do not explain. A gauge with a smaller share is left out.
const SMALLEST_SHARE: f64 = 1e-9;

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClockOffset {
    /// Offset to be added to the reference's times (s).
    pub offset_secs: f64,
    /// Mean over the load axes of R², the share of variance that the gauges explain, with this offset; 0 to 1.
    pub explained: f64,
    /// Mean over the load axes of R², the share of variance that the gauges explain, without an offset; 0 to 1.
    pub explained_without: f64,
}

/// Estimates the offset to be added to the reference's times. Returns `None` if a time goes back, or if gauges or reference
/// have too few samples or are constant.
///
/// If gauges and reference overlap by less than half of the shorter one, their starts are aligned first. Then offsets up to a
/// fifth of the common time are tried. A gauge that lags behind its load has the same effect as an offset, so the result is
/// no proof of an offset.
pub fn estimate(gauges: Series, reference: Series) -> Option<ClockOffset> {
    let (of_gauges, of_reference) = (span(gauges.times)?, span(reference.times)?);
    let common = |later: f64| {
        let MinMax { min, max } = of_reference;
        MinMax::common([of_gauges, MinMax { min: min + later, max: max + later }].into_iter())
    };
    let shorter = of_gauges.span().min(of_reference.span());
    let is_apart = common(0.0).span() < 0.5 * shorter;
    let base = if is_apart { of_gauges.min - of_reference.min } else { 0.0 };
    let common = common(base);
    let step = median_step(gauges.times)?.max(median_step(reference.times)?);
    let coarse_step = step.max(common.span() / COARSE_POINTS);
    let reach = (LARGEST_SHARE * common.span() / coarse_step) as usize;
    let coarse = Grids::new(gauges, reference, base, common, coarse_step, reach)?;
    let best = coarse.nearest_good_lag();

    let fine_step = step.max(common.span() / FINE_POINTS);
    let ratio = coarse_step / fine_step;
    let centre = (best as f64 * ratio).round() as isize;
    let around = (2.0 * ratio).ceil() as isize;
    let reach = centre.unsigned_abs() + around as usize + 1;
    let fine = Grids::new(gauges, reference, base, common, fine_step, reach)?;
    let lags = centre - around..=centre + around;
    let best = lags.max_by(|a, b| fine.explained(*a).total_cmp(&fine.explained(*b)))?;
    Some(ClockOffset {
        offset_secs: base + (best as f64 + fine.peak_beside(best)) * fine_step,
        explained: fine.explained(best),
        explained_without: if is_apart { 0.0 } else { fine.explained(0) },
    })
}

/// Returns the first and the last of these times (s); `None` if there are too few times, or a time goes back.
fn span(times: &[f64]) -> Option<MinMax> {
    let (min, max) = (*times.first()?, *times.last()?);
    let is_usable = times.len() >= FEWEST_SAMPLES && times.is_sorted() && max > min;
    is_usable.then_some(MinMax { min, max })
}

/// Gauges and reference, resampled at the same evenly spaced times.
struct Grids {
    /// Orthogonalised gauges, each with mean 0 and sum of squares 1, over the middle of the time in common.
    gauges: Vec<Vec<f64>>,
    /// Reference load of each axis over the whole time in common, with `reach` more points than `gauges` on either side.
    axes: Vec<Vec<f64>>,
    reach: usize,
}

impl Grids {
    /// Resamples gauges and reference. Returns `None` if the middle of their common time is too short, or all gauges or all
    /// axes are constant.
    fn new(
        gauges: Series,
        reference: Series,
        base: f64,
        common: MinMax,
        step: f64,
        reach: usize,
    ) -> Option<Self> {
        let n = (common.span() / step).floor() as usize + 1;
        let n_middle = n.checked_sub(2 * reach).filter(|n| *n >= FEWEST_SAMPLES)?;
        let mut orthogonal: Vec<Vec<f64>> = Vec::new();
        for column in 0..gauges.width {
            let start = common.min + reach as f64 * step;
            let mut values = on_grid(gauges, column, start, step, n_middle);
            let before = centre(&mut values);
            for known in &orthogonal {
                let share = dot(known, &values);
                for (value, other) in values.iter_mut().zip(known) {
                    *value -= share * other;
                }
            }
            let own = dot(&values, &values);
            if own > SMALLEST_SHARE * before {
                values.iter_mut().for_each(|value| *value /= own.sqrt());
                orthogonal.push(values);
            }
        }
        let is_live = |values: &Vec<f64>| values.iter().any(|value| *value != values[0]);
        let axes: Vec<Vec<f64>> = (0..reference.width)
            .map(|axis| on_grid(reference, axis, common.min - base, step, n))
            .filter(is_live)
            .collect();
        (!orthogonal.is_empty() && !axes.is_empty()).then_some(Self {
            gauges: orthogonal,
            axes,
            reach,
        })
    }

    /// Returns the mean over the load axes of R² (explained variance) if the reference is shifted by `lag` steps to later
    /// times.
    fn explained(&self, lag: isize) -> f64 {
        let start = self.reach.saturating_add_signed(-lag);
        let of_axis = |axis: &Vec<f64>| -> f64 {
            let mut signal = axis[start..start + self.gauges[0].len()].to_vec();
            let energy = centre(&mut signal);
            let by_gauge = |gauge: &Vec<f64>| dot(gauge, &signal).powi(2);
            let explained: f64 = self.gauges.iter().map(by_gauge).sum();
            if energy > 0.0 { (explained / energy).min(1.0) } else { 0.0 }
        };
        self.axes.iter().map(of_axis).sum::<f64>() / self.axes.len() as f64
    }

    /// Returns the smallest shift of the reference (steps) whose R² is nearly the best, moved to the nearest maximum of R².
    fn nearest_good_lag(&self) -> isize {
        let reach = self.reach as isize;
        let explained: Vec<f64> = (-reach..=reach).map(|lag| self.explained(lag)).collect();
        let at = |lag: isize| explained.get((reach + lag) as usize).copied().unwrap_or(0.0);
        let best = explained.iter().copied().fold(0.0, f64::max);
        let is_good = |lag: &isize| best - at(*lag) <= EXPLAINED_TOLERANCE.max(0.5 * (1.0 - best));
        let mut lag = (0..=reach).flat_map(|lag| [lag, -lag]).find(is_good).unwrap_or(0);
        while let Some(next) = [lag - 1, lag + 1].into_iter().find(|next| at(*next) > at(lag)) {
            lag = next;
        }
        lag
    }

    /// Returns the place of the maximum of a parabola through R² at the best shift and its neighbours, in steps from the best
    /// shift.
    fn peak_beside(&self, best: isize) -> f64 {
        let [left, top, right] = [best - 1, best, best + 1].map(|lag| self.explained(lag));
        let curvature = left - 2.0 * top + right;
        if curvature < 0.0 { (0.5 * (left - right) / curvature).clamp(-0.5, 0.5) } else { 0.0 }
    }
}

/// Subtracts the mean from the values, and returns the sum of squares of the differences.
fn centre(values: &mut [f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    for value in values.iter_mut() {
        *value -= mean;
    }
    dot(values, values)
}

/// Returns one column of a series at `n` evenly spaced times: the mean of the samples around each time, or an interpolated
/// value if these samples are few.
fn on_grid(series: Series, column: usize, start: f64, step: f64, n: usize) -> Vec<f64> {
    const FEWEST_FOR_MEAN: usize = 4;
    let value = |k: usize| series.values[k * series.width + column];
    let last = series.times.len() - 1;
    let mut next = 0;
    let at_time = |k| {
        let time = start + k as f64 * step;
        while next < last && series.times[next] <= time {
            next += 1;
        }
        let from = series.times[..next].partition_point(|other| *other < time - 0.5 * step);
        let around = from..next + series.times[next..].partition_point(|t| *t < time + 0.5 * step);
        if around.len() >= FEWEST_FOR_MEAN {
            let n_around = around.len() as f64;
            return around.map(value).sum::<f64>() / n_around;
        }
        let before = next.saturating_sub(1);
        let gap = series.times[next] - series.times[before];
        if gap > 0.0 {
            let share = ((time - series.times[before]) / gap).clamp(0.0, 1.0);
            value(before) + (value(next) - value(before)) * share
        } else {
            value(next)
        }
    };
    (0..n).map(at_time).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns two loads that never repeat within the run.
    fn loads(t: f64) -> [f64; 2] {
        let first = (0.9 * t).sin() + (0.41 * t + 1.0).sin() + 0.3 * (2.3 * t).cos();
        [first, (0.7 * t).cos() - (0.23 * t).sin()]
    }

    /// Returns three gauges that mix two loads, sampled every `step` s with jitter. The clock of the loads is `late` s
    /// behind.
    fn run(step: f64, late: f64) -> [(Vec<f64>, Vec<f64>); 2] {
        let times = |step: f64, phase: f64| -> Vec<f64> {
            let jitter = |k: f64| 0.2 * step * (7.0 * k).sin();
            (0..(120.0 / step) as usize)
                .map(|k| 5.0 + phase + k as f64 * step + jitter(k as f64))
                .collect()
        };
        let gauge_times = times(step, 0.0);
        let mix = |&t: &f64| {
            let [a, b] = loads(t);
            [a + 0.5 * b, 2.0 * b - a, 0.1 * a + 100.0]
        };
        let gauges = gauge_times.iter().flat_map(mix).collect();
        let reference_times = times(0.7 * step, 0.31 * step);
        let reference = reference_times.iter().flat_map(|&t| loads(t)).collect();
        let on_their_clock = reference_times.iter().map(|t| t - late).collect();
        [(gauge_times, gauges), (on_their_clock, reference)]
    }

    fn estimated(step: f64, late: f64) -> ClockOffset {
        let [(gauge_times, gauges), (times, reference)] = run(step, late);
        let series = |times, values, width| Series { times, values, width };
        estimate(series(&gauge_times, &gauges, 3), series(&times, &reference, 2)).unwrap()
    }

    #[test]
    fn a_known_shift_is_found_within_a_tenth_of_a_sample() {
        for step in [0.01, 0.1, 0.3] {
            for late in [-9.0, -0.37, 0.0, 0.049, 3.1] {
                let found = estimated(step, late);
                let error = (found.offset_secs - late).abs();
                assert!(error < 0.1 * step, "{step} s, {late} s: {found:?}");
                assert!(found.explained > 0.98, "{found:?}");
            }
        }
    }

    #[test]
    fn clocks_of_different_epochs_are_aligned_at_their_starts_first() {
        let found = estimated(0.1, 1.7e9);
        assert!((found.offset_secs - 1.7e9).abs() < 0.01, "{found:?}");
        assert_eq!(found.explained_without, 0.0);
    }

    #[test]
    fn the_gain_of_the_offset_is_reported() {
        let found = estimated(0.1, 0.4);
        assert!(found.explained_without < found.explained - 0.05, "{found:?}");
        let none = estimated(0.1, 0.0);
        assert!((none.explained_without - none.explained).abs() < 1e-3, "{none:?}");
    }

    /// A load with a period of 10 s fits as well if it is shifted by 10 s. The offset near 0 is the right one.
    #[test]
    fn of_several_offsets_that_fit_the_smallest_is_returned() {
        let times: Vec<f64> = (0..2000).map(|k| 0.1 * f64::from(k)).collect();
        let load = |t: f64| (0.2 * std::f64::consts::PI * t).sin();
        let gauges: Vec<f64> = times.iter().map(|t| load(*t) + 0.01 * (0.3 * t).sin()).collect();
        let reference: Vec<f64> = times.iter().map(|t| load(t + 0.5)).collect();
        let series = |values| Series { times: &times, values, width: 1 };
        let found = estimate(series(&gauges), series(&reference)).unwrap();
        assert!((found.offset_secs - 0.5).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn without_enough_data_there_is_no_estimate() {
        let times: Vec<f64> = (0..50).map(f64::from).collect();
        let flat = vec![1.0; 50];
        let series = |times, values| Series { times, values, width: 1 };
        let live = times.clone();
        assert_eq!(estimate(series(&times, &flat), series(&times, &live)), None);
        assert_eq!(estimate(series(&times, &live), series(&times, &flat)), None);
        assert_eq!(estimate(series(&times[..9], &live[..9]), series(&times, &live)), None);
        let back: Vec<f64> = times.iter().rev().copied().collect();
        assert_eq!(estimate(series(&back, &live), series(&times, &live)), None);
        assert_eq!(estimate(series(&[], &[]), series(&[], &[])), None);
    }
}
