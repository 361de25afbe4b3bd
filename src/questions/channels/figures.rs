//! Noise and drift of one channel.
//!
//! Guarantees: values that are not finite are left out. Uncertainties are half widths of 95 % intervals. They hold for noise
//! whose neighbouring samples are alike, as long as distant samples are independent.

use crate::{
    calibration::t_beyond, min_max::MinMax, recording::median::white_noise,
    scoring::straight_lines::Line,
};

/// Probability with which an estimate lies above, and below, its 95 % interval.
const BEYOND: f64 = 0.025;
/// Number of blocks of a long signal whose means are taken as independent.
const BLOCKS: usize = 16;
/// Minimum number of samples in such a block.
const BLOCK_SAMPLES: usize = 4;
/// Share of the samples in the intervals at the start and at the end whose means are compared.
const END_SHARE: f64 = 0.05;
/// Maximum difference of two equal loads, as a share of the load's range.
const EQUAL_SHARE: f64 = 0.02;

/// Number with the half width of its 95 % interval; `None` if the samples are too few for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub value: f64,
    pub uncertainty: Option<f64>,
}

/// Noise and drift of one channel, in the unit of the channel.
#[derive(Debug)]
pub struct ChannelFigures {
    /// Number of samples with a finite value, at least one.
    pub n_samples: usize,
    pub mean: f64,
    pub peak_to_peak: f64,
    /// Root mean square about the straight line through the samples; `None` for fewer than three samples.
    pub deviation: Option<f64>,
    /// Standard deviation of the white noise from sample to sample; `None` for fewer than three samples.
    pub white_noise: Option<f64>,
    /// Slope of the straight line, for each second or row; `None` for fewer than two times.
    pub slope: Option<Estimate>,
    /// Mean of the last samples with the load of the first samples, minus the mean of the first samples; `None` if the load is
    /// not known, or does not return in the second half.
    pub zero_return: Option<Estimate>,
}

/// Values of a channel and their times.
#[derive(Clone, Copy)]
pub struct Signal<'a> {
    pub times: &'a [f64],
    pub values: &'a [f64],
    /// Load of each sample, one column for each axis; empty if the load is not known.
    pub loads: &'a [Vec<f64>],
}

impl ChannelFigures {
    /// Returns the figures of a signal; `None` if no value is finite.
    pub fn of(signal: Signal<'_>) -> Option<Self> {
        let kept = |k: &usize| signal.values[*k].is_finite() && signal.times[*k].is_finite();
        let kept: Vec<usize> = (0..signal.values.len()).filter(kept).collect();
        let [times, values] = [signal.times, signal.values]
            .map(|all| kept.iter().map(|k| all[*k]).collect::<Vec<f64>>());
        let range: MinMax = values.iter().collect();
        range.ends()?;
        let n_samples = values.len();
        let mean = mean(&values);
        let points: Vec<(f64, f64)> = times.iter().copied().zip(values.iter().copied()).collect();
        let line = Line::best_fit(&points);
        let is_enough = n_samples > 2;
        Some(Self {
            n_samples,
            mean,
            peak_to_peak: range.span(),
            deviation: (line.filter(|_| is_enough))
                .map(|line| (line.squares(&points) / (n_samples - 2) as f64).sqrt()),
            white_noise: is_enough.then(|| white_noise(&values)),
            slope: slope(&times, &values),
            zero_return: zero_return(&values, &kept, signal.loads),
        })
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Returns the slope of the line through the means of successive blocks. The scatter of these means gives the uncertainty,
/// because the noise of neighbouring samples is often alike.
fn slope(times: &[f64], values: &[f64]) -> Option<Estimate> {
    let is_long = values.len() >= BLOCKS * BLOCK_SAMPLES;
    let each = if is_long { values.len().div_ceil(BLOCKS) } else { 1 };
    let means: Vec<(f64, f64)> = (times.chunks(each).zip(values.chunks(each)))
        .map(|(times, values)| (mean(times), mean(values)))
        .collect();
    let line = Line::best_fit(&means)?;
    let squares = line.squares(&means);
    let uncertainty = (means.len() > 2).then(|| {
        let freedom = (means.len() - 2) as f64;
        t_beyond(freedom, BEYOND) * (squares / freedom / line.spread).sqrt()
    });
    Some(Estimate { value: line.slope, uncertainty })
}

/// Returns the mean of the last samples in the second half that have the load of the first samples, minus the mean of the first
/// samples. `kept` are the indices of the values in `loads`.
fn zero_return(values: &[f64], kept: &[usize], loads: &[Vec<f64>]) -> Option<Estimate> {
    let n = values.len();
    let width = ((END_SHARE * n as f64) as usize).max(1);
    let limits: Vec<(f64, f64)> = loads
        .iter()
        .map(|load| {
            let start = kept[..width].iter().map(|k| load[*k]).sum::<f64>() / width as f64;
            (start, EQUAL_SHARE * load.iter().collect::<MinMax>().span())
        })
        .collect();
    let is_equal = |k: &usize| {
        let mut all = loads.iter().zip(&limits);
        all.all(|(load, (start, limit))| (load[kept[*k]] - start).abs() <= *limit)
    };
    let mut last: Vec<f64> =
        (n / 2..n).rev().filter(is_equal).take(width).map(|k| values[k]).collect();
    if n < 2 || loads.is_empty() || last.is_empty() || !(0..width).all(|k| is_equal(&k)) {
        return None;
    }
    last.reverse();
    let [start, end] = [Mean::of(&values[..width]), Mean::of(&last)];
    let freedom = start.freedom.min(end.freedom);
    let uncertainty = (freedom > 0.0)
        .then(|| t_beyond(freedom, BEYOND) * start.standard_error.hypot(end.standard_error));
    Some(Estimate { value: end.mean - start.mean, uncertainty })
}

struct Mean {
    mean: f64,
    standard_error: f64,
    freedom: f64,
}

impl Mean {
    /// Returns the mean of successive values. Its standard error follows from the means of blocks.
    fn of(values: &[f64]) -> Self {
        let n_blocks =
            if values.len() >= BLOCKS * BLOCK_SAMPLES { BLOCKS / 2 } else { values.len() };
        let blocks = values.chunks(values.len().div_ceil(n_blocks));
        let means: Vec<f64> = blocks.map(mean).collect();
        let mean = mean(values);
        let freedom = means.len() as f64 - 1.0;
        let squares: f64 = means.iter().map(|block| (block - mean).powi(2)).sum();
        let standard_error = (squares / freedom / means.len() as f64).sqrt();
        Self { mean, standard_error, freedom }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn figures(values: &[f64], loads: &[Vec<f64>]) -> ChannelFigures {
        let times: Vec<f64> = (0..values.len()).map(|k| k as f64 * 0.5).collect();
        ChannelFigures::of(Signal { times: &times, values, loads }).unwrap()
    }

    #[test]
    fn a_straight_line_has_its_slope_and_no_noise() {
        let values: Vec<f64> = (0..200).map(|k| 7.0 - 0.25 * f64::from(k)).collect();
        let found = figures(&values, &[]);
        let slope = found.slope.unwrap();
        assert!((slope.value + 0.5).abs() < 1e-12 && slope.uncertainty.unwrap() < 1e-9);
        assert!(found.deviation.unwrap() < 1e-9 && found.white_noise.unwrap() < 1e-9);
        assert!((found.peak_to_peak - 49.75).abs() < 1e-12);
        assert_eq!(found.zero_return, None);
    }

    #[test]
    fn few_samples_have_the_figures_that_they_determine() {
        let one = figures(&[3.0], &[]);
        assert_eq!((one.mean, one.peak_to_peak, one.deviation), (3.0, 0.0, None));
        assert_eq!((one.slope, one.zero_return), (None, None));
        let two = figures(&[3.0, 4.0], &[]);
        assert_eq!(two.slope, Some(Estimate { value: 2.0, uncertainty: None }));
        let held = figures(&[3.0, 4.0], &[vec![0.0; 2]]);
        assert_eq!(held.zero_return, Some(Estimate { value: 1.0, uncertainty: None }));
        let gaps = figures(&[f64::NAN, 3.0, f64::INFINITY, 4.0], &[]);
        assert_eq!((gaps.n_samples, gaps.mean), (2, 3.5));
        let none = Signal { times: &[0.0], values: &[f64::NAN], loads: &[] };
        assert!(ChannelFigures::of(none).is_none());
    }

    /// The load rises and falls. The channel follows the load, and has drifted by 3 when the load is zero again.
    #[test]
    fn the_zero_return_is_taken_at_equal_loads() {
        let load: Vec<f64> =
            (0..200).map(|k| f64::from(if k < 20 { 0 } else { k.min(180 - k / 2) })).collect();
        let back: Vec<f64> = load.iter().rev().copied().collect();
        let there_and_back = [load, back].concat();
        let n = there_and_back.len();
        let values: Vec<f64> =
            (0..n).map(|k| 5.0 * there_and_back[k] + if k > n / 2 { 3.0 } else { 0.0 }).collect();
        let found = figures(&values, std::slice::from_ref(&there_and_back)).zero_return.unwrap();
        assert!((found.value - 3.0).abs() < 1e-9, "{found:?}");
        let rising: Vec<f64> = (0..200).map(f64::from).collect();
        assert_eq!(figures(&rising, std::slice::from_ref(&rising)).zero_return, None);
    }

    /// Of the 95 % intervals of signals without drift, 90 % or more contain zero, also where neighbouring samples are alike.
    #[test]
    fn the_intervals_contain_the_truth() {
        for memory in [0.0, 0.9] {
            let (mut slopes, mut changes, n) = (0, 0, 400);
            for run in 0..n {
                let mut random = Random::new(5, &[run]);
                let mut state = 0.0;
                let values: Vec<f64> = (0..8000)
                    .map(|_| {
                        state = memory * state + random.normal();
                        state
                    })
                    .collect();
                let found = figures(&values, &[vec![0.0; 8000]]);
                let holds =
                    |found: Estimate| usize::from(found.value.abs() <= found.uncertainty.unwrap());
                slopes += holds(found.slope.unwrap());
                changes += holds(found.zero_return.unwrap());
            }
            for share in [slopes, changes].map(|count| count as f64 / n as f64) {
                assert!((0.9..0.995).contains(&share), "{memory}: {share}");
            }
        }
    }
}
