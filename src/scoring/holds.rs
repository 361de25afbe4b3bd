//! Dwells: intervals in which the load is constant, and the drift of the output in them.
//!
//! In a dwell, the load of every axis stays within a narrow band for some seconds. If the output still changes, it creeps.
//! [`Drift`] describes this change by a first-order exponential.
//!
//! Guarantees: dwells are sorted and do not overlap. In a dwell, no axis spans more than its band. They are found in one pass
//! over the samples. The exponential is the least-squares optimum within the resolution of the tried time constants, and
//! finite for finite samples.

use std::collections::VecDeque;
use std::ops::Range;

/// Number of intervals of equal length over which the samples are averaged before the fit. It limits the computing time for
/// long dwells.
const CELLS: usize = 400;
/// Ratio of the dwell's length to the shortest tried time constant.
const FASTEST: f64 = 200.0;
/// Ratio of the longest tried time constant to the dwell's length. A slower drift looks like a straight line.
const SLOWEST: f64 = 20.0;
/// Number of time constants that the coarse search tries, evenly spaced on a logarithmic scale.
const COARSE_STEPS: usize = 60;
/// Number of golden-section steps after the coarse search. Each step reduces the interval to 0.618 of its length.
const FINE_STEPS: usize = 30;
/// Minimum size of a drift that counts as significant, in standard errors.
const SIGNIFICANT: f64 = 3.0;

/// Drift of an output in a dwell (interval of constant load): `y(t) = start + amplitude · (1 − exp(−t / τ))`, with t (s)
/// counted from the first sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Drift {
    pub start: f64,
    pub amplitude: f64,
    /// Time constant τ of the fit (s), even if the data do not determine it.
    pub fitted_tau_secs: f64,
    pub duration_secs: f64,
    /// Change of the fitted output from the first to the last sample.
    pub size: f64,
    /// Root mean square of the differences between output and fit.
    pub noise: f64,
    pub n_samples: usize,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoTimeConstant {
    #[error("the output does not drift by more than its noise in {duration_secs:.3} s")]
    BelowNoise { duration_secs: f64 },
    #[error(
        "the output still drifts after the {duration_secs:.3} s of the dwell; hold the load longer"
    )]
    LongerThanHold { duration_secs: f64 },
    #[error(
        "the drift ends within {shortest_secs:.3} s, too fast for a dwell of {duration_secs:.3} s; the load may still be settling"
    )]
    TooFast { shortest_secs: f64, duration_secs: f64 },
}

impl Drift {
    /// Fits the drift of `outputs`. `None` with fewer than four samples or without elapsed time. Panics if the lengths
    /// differ.
    ///
    /// For each time constant, start and amplitude follow by linear least squares. The time constant is searched in 60 steps,
    /// from 1/200 to 20 times the dwell's length, then by golden section around the best step.
    pub fn of(times: &[f64], outputs: &[f64]) -> Option<Self> {
        assert_eq!(times.len(), outputs.len(), "one output for each time");
        let (first, last) = (*times.first()?, *times.last()?);
        let duration = last - first;
        if times.len() < 4 || duration <= 0.0 {
            return None;
        }
        let averages = averages(times, outputs, duration);
        let tau = search(duration, |tau| averages.fit(tau).left_over);
        let Line { start, amplitude, .. } = averages.fit(tau);
        let squares: f64 = times
            .iter()
            .zip(outputs)
            .map(|(time, output)| (output - start - amplitude * risen(time - first, tau)).powi(2))
            .sum();
        Some(Self {
            start,
            amplitude,
            fitted_tau_secs: tau,
            duration_secs: duration,
            size: amplitude * risen(duration, tau),
            noise: (squares / times.len() as f64).sqrt(),
            n_samples: times.len(),
        })
    }

    /// Returns the fitted output at this time after the first sample (s).
    pub fn at(&self, secs: f64) -> f64 {
        self.start + self.amplitude * risen(secs, self.fitted_tau_secs)
    }

    /// Returns true if the drift exceeds three standard errors. This is the standard error of the difference of two means,
    /// each over a tenth of the samples.
    pub fn is_significant(&self) -> bool {
        let error = self.noise * (20.0 / self.n_samples as f64).sqrt();
        self.size.abs() > SIGNIFICANT * error
    }

    /// Returns the time constant (s), or the reason why the data do not determine it.
    pub fn tau_secs(&self) -> Result<f64, NoTimeConstant> {
        let duration_secs = self.duration_secs;
        let sample_secs = duration_secs / (self.n_samples - 1) as f64;
        let shortest_secs = (duration_secs / FASTEST * 1.1).max(sample_secs);
        if !self.is_significant() {
            Err(NoTimeConstant::BelowNoise { duration_secs })
        } else if self.fitted_tau_secs > duration_secs {
            Err(NoTimeConstant::LongerThanHold { duration_secs })
        } else if self.fitted_tau_secs < shortest_secs {
            Err(NoTimeConstant::TooFast { shortest_secs, duration_secs })
        } else {
            Ok(self.fitted_tau_secs)
        }
    }
}

fn risen(secs: f64, tau: f64) -> f64 {
    -(-secs / tau).exp_m1()
}

/// Averages of the output over intervals of equal length in a dwell.
struct Averages {
    /// Number of samples, mean time since the first sample (s) and mean output of each interval.
    cells: Vec<(f64, f64, f64)>,
    /// Mean output of the dwell, which was subtracted so that a large offset costs no digits.
    mean: f64,
}

/// Least-squares fit of start and amplitude for one time constant.
struct Line {
    start: f64,
    amplitude: f64,
    left_over: f64,
}

fn averages(times: &[f64], outputs: &[f64], duration: f64) -> Averages {
    let mut sums = vec![(0.0, 0.0, 0.0); CELLS];
    let mean = outputs.iter().sum::<f64>() / outputs.len() as f64;
    for (time, output) in times.iter().zip(outputs) {
        let secs = time - times[0];
        let at = ((secs / duration * CELLS as f64) as usize).min(CELLS - 1);
        let (count, sum_of_secs, sum_of_outputs) = &mut sums[at];
        *count += 1.0;
        *sum_of_secs += secs;
        *sum_of_outputs += output - mean;
    }
    let filled = sums.into_iter().filter(|(count, ..)| *count > 0.0);
    Averages {
        cells: filled.map(|(count, secs, output)| (count, secs / count, output / count)).collect(),
        mean,
    }
}

impl Averages {
    fn fit(&self, tau: f64) -> Line {
        let (mut n, mut sum_g, mut sum_y) = (0.0, 0.0, 0.0);
        for (count, secs, y) in &self.cells {
            n += count;
            sum_g += count * risen(*secs, tau);
            sum_y += count * y;
        }
        let (mean_g, mean_y) = (sum_g / n, sum_y / n);
        let (mut gg, mut gy, mut yy) = (0.0, 0.0, 0.0);
        for (count, secs, y) in &self.cells {
            let (g, y) = (risen(*secs, tau) - mean_g, y - mean_y);
            gg += count * g * g;
            gy += count * g * y;
            yy += count * y * y;
        }
        let amplitude = if gg > 0.0 { gy / gg } else { 0.0 };
        Line {
            start: self.mean + mean_y - amplitude * mean_g,
            amplitude,
            left_over: yy - amplitude * gy,
        }
    }
}

/// Returns the time constant (s) with the smallest `left_over`, the sum of squared residuals of the fit.
fn search(duration: f64, left_over: impl Fn(f64) -> f64) -> f64 {
    let (fastest, slowest) = ((duration / FASTEST).ln(), (duration * SLOWEST).ln());
    let at = |step: usize| fastest + (slowest - fastest) * step as f64 / COARSE_STEPS as f64;
    let best = (0..=COARSE_STEPS)
        .map(|step| (left_over(at(step).exp()), step))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(0, |(_, step)| step);
    let mut low = at(best.saturating_sub(1));
    let mut high = at((best + 1).min(COARSE_STEPS));
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    for _ in 0..FINE_STEPS {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if left_over(a.exp()) <= left_over(b.exp()) {
            high = b;
        } else {
            low = a;
        }
    }
    ((low + high) / 2.0).exp()
}

pub const FEWEST_SAMPLES: usize = 8;

/// Dwell: an interval in which the load is constant.
#[derive(Debug)]
pub struct Hold {
    pub samples: Range<usize>,
    pub level: Vec<f64>,
}

/// Returns the intervals of at least `shortest_secs` in which no axis spans more than its band (in the unit of the axis).
///
/// An interval grows until an axis spans more than its band. If the interval is then long enough, it is a dwell, and the
/// next interval begins at its end. Otherwise its first samples are dropped until the rest lies within the band. Panics if
/// an axis and `times` differ in length.
pub fn holds(times: &[f64], axes: &[&[f64]], bands: &[f64], shortest_secs: f64) -> Vec<Hold> {
    assert_eq!(axes.len(), bands.len(), "one band for each axis");
    assert!(axes.iter().all(|axis| axis.len() == times.len()), "one load for each time");
    let mut extents: Vec<Extent> = axes.iter().map(|_| Extent::default()).collect();
    let mut found = Vec::new();
    let mut start = 0;
    let mut finish = |samples: Range<usize>| -> bool {
        let long = samples.len() >= FEWEST_SAMPLES
            && times[samples.end - 1] - times[samples.start] >= shortest_secs;
        if long {
            let n = samples.len() as f64;
            let mean = |axis: &&[f64]| axis[samples.clone()].iter().sum::<f64>() / n;
            found.push(Hold { level: axes.iter().map(mean).collect(), samples });
        }
        long
    };
    for k in 0..times.len() {
        for (extent, axis) in extents.iter_mut().zip(axes) {
            extent.push(k, axis);
        }
        let still = |extents: &[Extent]| {
            let mut all = extents.iter().zip(axes).zip(bands);
            all.all(|((extent, axis), band)| extent.width(axis) <= *band)
        };
        if still(&extents) {
            continue;
        }
        if finish(start..k) {
            start = k;
        }
        while start < k && !still(&extents) {
            start += 1;
            extents.iter_mut().for_each(|extent| extent.start_at(start));
        }
        extents.iter_mut().for_each(|extent| extent.start_at(start));
    }
    finish(start..times.len());
    found
}

/// Maximum and minimum of the load in an interval that grows at its end and loses its first samples.
#[derive(Debug, Default)]
struct Extent {
    /// Indices of the samples that are or may become the maximum. Their values fall from first to last.
    highest: VecDeque<usize>,
    /// Indices of the samples that are or may become the minimum. Their values rise from first to last.
    lowest: VecDeque<usize>,
}

impl Extent {
    fn push(&mut self, k: usize, values: &[f64]) {
        while self.highest.back().is_some_and(|&last| values[last] <= values[k]) {
            self.highest.pop_back();
        }
        while self.lowest.back().is_some_and(|&last| values[last] >= values[k]) {
            self.lowest.pop_back();
        }
        self.highest.push_back(k);
        self.lowest.push_back(k);
    }

    fn start_at(&mut self, start: usize) {
        for queue in [&mut self.highest, &mut self.lowest] {
            while queue.front().is_some_and(|&first| first < start) {
                queue.pop_front();
            }
        }
    }

    fn width(&self, values: &[f64]) -> f64 {
        match (self.highest.front(), self.lowest.front()) {
            (Some(&highest), Some(&lowest)) => values[highest] - values[lowest],
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::scoring::holds::*;

    fn times(n: usize, secs: f64) -> Vec<f64> {
        (0..n).map(|k| 100.0 + secs * k as f64 / (n - 1) as f64).collect()
    }

    fn creep(times: &[f64], amplitude: f64, tau: f64) -> Vec<f64> {
        let risen = |time: &f64| 1e4 + amplitude * (1.0 - (-(time - times[0]) / tau).exp());
        times.iter().map(risen).collect()
    }

    /// Without noise, the fit returns the parameters that made the drift.
    #[test]
    fn a_first_order_creep_element_has_its_known_time_constant_and_size() {
        for (n, secs, tau) in [(2000, 60.0, 6.0), (61, 30.0, 25.0), (5000, 100.0, 1.0)] {
            let times = times(n, secs);
            let drift = Drift::of(&times, &creep(&times, -0.3, tau)).unwrap();
            let found = drift.tau_secs().unwrap();
            assert!((found / tau - 1.0).abs() < 0.01, "{found} is not {tau}");
            assert!((drift.amplitude / -0.3 - 1.0).abs() < 0.01);
            let size = -0.3 * (1.0 - (-secs / tau).exp());
            assert!((drift.size / size - 1.0).abs() < 0.01);
            assert!((drift.at(secs) - drift.start - drift.size).abs() < 1e-12);
        }
    }

    #[test]
    fn a_drift_slower_than_the_hold_has_a_size_but_no_time_constant() {
        let times = times(500, 10.0);
        let drift = Drift::of(&times, &creep(&times, 5.0, 80.0)).unwrap();
        let duration_secs = 10.0;
        assert_eq!(drift.tau_secs(), Err(NoTimeConstant::LongerThanHold { duration_secs }));
        assert!((drift.size / (5.0 * (1.0 - (-0.125_f64).exp())) - 1.0).abs() < 0.01);
    }

    #[test]
    fn noise_alone_has_no_time_constant() {
        let times = times(1000, 20.0);
        let hum: Vec<f64> = (0..1000).map(|k| (k as f64 * 2.1).sin()).collect();
        for outputs in [hum, vec![7.0; 1000]] {
            let drift = Drift::of(&times, &outputs).unwrap();
            assert!(matches!(drift.tau_secs(), Err(NoTimeConstant::BelowNoise { .. })));
            assert!(drift.size.abs() < 0.2);
        }
    }

    #[test]
    fn a_step_at_the_beginning_is_too_fast() {
        let times = times(1000, 20.0);
        let mut outputs = vec![1.0; 1000];
        outputs[0] = -50.0;
        let drift = Drift::of(&times, &outputs).unwrap();
        assert!(matches!(drift.tau_secs(), Err(NoTimeConstant::TooFast { .. })));
    }

    #[test]
    fn too_little_is_no_drift() {
        assert_eq!(Drift::of(&[], &[]), None);
        assert_eq!(Drift::of(&[0.0, 1.0, 2.0], &[1.0, 2.0, 3.0]), None);
        assert_eq!(Drift::of(&[1.0; 9], &[2.0; 9]), None);
    }
}

#[cfg(test)]
mod stillness_tests {
    use crate::scoring::holds::*;

    fn seconds(n: usize) -> Vec<f64> {
        (0..n).map(|k| k as f64).collect()
    }

    fn spans(holds: &[Hold]) -> Vec<Range<usize>> {
        holds.iter().map(|hold| hold.samples.clone()).collect()
    }

    #[test]
    fn a_plateau_between_ramps_is_a_hold() {
        let mut load: Vec<f64> = (0..20).map(f64::from).collect();
        load.extend([19.0; 15]);
        load.extend((0..19).rev().map(f64::from));
        let found = holds(&seconds(load.len()), &[&load], &[0.5], 10.0);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].samples, 19..35);
        assert_eq!(found[0].level, [19.0]);
        assert!(holds(&seconds(load.len()), &[&load], &[0.5], 20.0).is_empty());
    }

    #[test]
    fn a_dwell_needs_every_axis_to_stand_still() {
        let still = [3.0; 40];
        let stepping: Vec<f64> = (0..40).map(|k| f64::from(k / 20)).collect();
        let found = holds(&seconds(40), &[&still, &stepping], &[0.1; 2], 9.0);
        assert_eq!(spans(&found), [0..20, 20..40]);
        assert_eq!(found[1].level, [3.0, 1.0]);
    }

    /// A comparison of all pairs of samples gives the same start and end, for any steps and wiggles.
    #[test]
    fn holds_are_those_of_a_plain_search() {
        let load: Vec<f64> = (0..400)
            .map(|k| (k as f64 / 37.0).sin().powi(3) + 0.05 * (k as f64 * 1.7).sin())
            .collect();
        let (band, shortest) = (0.12, 11);
        let mut expected = Vec::new();
        let mut start = 0;
        while start < load.len() {
            let stays = |end: usize| {
                let loads = &load[start..end];
                loads.iter().all(|a| loads.iter().all(|b| a - b <= band))
            };
            let end = (start + 1..=load.len()).rev().find(|end| stays(*end)).unwrap();
            if end - start > shortest {
                expected.push(start..end);
                start = end;
            } else {
                start += 1;
            }
        }
        assert!(expected.len() > 2);
        let found = holds(&seconds(400), &[&load], &[band], shortest as f64);
        assert_eq!(spans(&found), expected);
    }

    #[test]
    fn without_samples_or_axes_nothing_breaks() {
        assert!(holds(&[], &[&[]], &[1.0], 0.0).is_empty());
        assert_eq!(holds(&seconds(9), &[], &[], 5.0).len(), 1);
    }
}
