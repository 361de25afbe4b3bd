//! Finds clipped and stuck channels with noise: a saturated amplifier, or a broken cable.
//!
//! No value is repeated exactly, so the expected value from the other channels decides alone.

use std::ops::Range;

use crate::recording::median;
use crate::scoring::faults::fault::{Channel, Fault, FaultKind};
use crate::scoring::faults::watched::{Expected, PILES_UP, Watched, joined, looked_at};
use crate::scoring::quantile::quantile;

/// Deviation from the expected value, in standard deviations, beyond which a sample deviates.
const OFF: f64 = 6.0;
/// Largest share of the expected movement that a stuck channel shows.
const FOLLOWS: f64 = 0.2;
/// Smallest expected movement, as a share of the span and in standard deviations. Noise alone stays well below it.
const MOVES: (f64, f64) = (0.2, 15.0);
/// Share of the span within which clipped values accumulate, and beyond which their expected values lie.
const BEYOND: f64 = 0.05;
/// Minimum number of clipped samples.
const FEWEST: usize = 20;
/// Minimum share of other samples as expected, and minimum share of clipped samples among those expected beyond the limit.
const MOST: f64 = 0.95;
/// Lengths of the intervals in which a channel may be stuck, in samples.
const WINDOWS: [usize; 3] = [64, 256, 1024];

impl Watched<'_> {
    /// Finds the limit of a clipped gauge; `inward` is the sign of the direction away from the limit.
    pub fn noisy_limit(&self, inward: f64) -> Option<f64> {
        // Values are turned so that the limit is a maximum.
        let outward = |value: f64| -inward * value;
        let mut values: Vec<f64> = looked_at(self.n()).map(|k| outward(self.value(k))).collect();
        let end = quantile(&mut values, 0.998)?;
        let band = BEYOND * self.own.span;
        let within = |from: f64, to: f64| {
            let within = values.iter().filter(|value| **value > from && **value <= to);
            within.count()
        };
        let at_end = within(end - band, f64::INFINITY);
        if at_end < FEWEST || at_end < PILES_UP * within(end - 2.0 * band, end - band) {
            return None;
        }
        // Samples that may be clipped would distort the line.
        let by = self.expected?.by.iter().map(|(channel, ..)| *channel);
        let is_odd = |value: f64| outward(value) > end - band;
        let expected = Expected::of(self.recording, self.own, by.collect(), is_odd)?;
        let sigma = expected.sigma.max(self.own.resolution);
        let pairs = looked_at(self.n()).map(|k| {
            let expected = expected.at(self.recording, k);
            (outward(self.value(k)), outward(expected))
        });
        let pairs: Vec<(f64, f64)> = pairs.collect();
        let is_behind = |value: f64, expected: f64| expected - value > OFF * sigma;
        let behind = pairs.iter().filter(|(value, expected)| is_behind(*value, *expected));
        let (mut at, mut should_be): (Vec<f64>, Vec<f64>) = behind.copied().unzip();
        if at.len() < FEWEST {
            return None;
        }
        let limit = median(at.iter().copied())?;
        let (width, should_be) = (spread(&mut at), spread(&mut should_be));
        if should_be < band.max(OFF * sigma) || width > FOLLOWS * should_be {
            return None;
        }
        let reach = limit + (3.0 * width).max(OFF * self.own.resolution);
        let share = |is: &dyn Fn(f64, f64) -> bool, of: &dyn Fn(f64, f64) -> bool| {
            let of = pairs.iter().filter(|(value, expected)| of(*value, *expected));
            let are: Vec<bool> = of.map(|(value, expected)| is(*value, *expected)).collect();
            let some = are.iter().filter(|own| **own).count();
            some as f64 / are.len().max(1) as f64
        };
        let is_near = |value: f64, expected: f64| (expected - value).abs() <= OFF * sigma;
        let goes_no_farther = share(&|value, _| value <= reach, &|_, _| true) > 0.999;
        let others_follow = share(&is_near, &|_, expected| expected < limit - OFF * sigma) >= MOST;
        let all_stop = share(&is_behind, &|_, expected| expected > reach + OFF * sigma) >= MOST;
        (goes_no_farther && others_follow && all_stop).then_some(outward(limit - 1.5 * width))
    }

    /// Finds intervals in which a gauge shows only noise although it should move, outside the faults `found`.
    /// For a resting load, gauges may seem to move, because they also respond to the other axes.
    pub fn stuck_in_noise(&self, found: &[Fault]) -> Vec<Fault> {
        let (Some(expected), Channel::Gauge(_)) = (self.expected, self.own.channel) else {
            return Vec::new();
        };
        let at: Vec<usize> = looked_at(self.n()).collect();
        let values: Vec<f64> = at.iter().map(|k| self.value(*k)).collect();
        let expected_values = at.iter().map(|k| expected.at(self.recording, *k));
        let expected_values: Vec<f64> = expected_values.collect();
        let least = (MOVES.0 * self.own.span).max(MOVES.1 * expected.sigma);
        let mut stuck: Vec<Range<usize>> = Vec::new();
        for window in WINDOWS {
            for start in (0..at.len().saturating_sub(window - 1)).step_by(window / 4) {
                let own = start..start + window;
                // A late reference may still move in the outer quarters.
                let inner = start + window / 4..start + window - window / 4;
                let should = spread(&mut expected_values[inner].to_vec());
                if should > least && spread(&mut values[own.clone()].to_vec()) < FOLLOWS * should {
                    stuck.push(at[own.start]..at[own.end - 1] + 1);
                }
            }
        }
        stuck.sort_by_key(|run| run.start);
        let runs = joined(stuck).into_iter().map(|run| self.widened(run));
        let is_new = |run: &Range<usize>| {
            let overlaps =
                |fault: &Fault| fault.samples.start < run.end && run.start < fault.samples.end;
            !found.iter().any(overlaps)
        };
        let faults = runs.filter(is_new).map(|run| self.fault(FaultKind::Stuck, run));
        faults.collect()
    }

    /// Extends the interval while the channel stays within the same values.
    fn widened(&self, run: Range<usize>) -> Range<usize> {
        let every = run.len().div_ceil(256).max(1);
        let mut values: Vec<f64> = run.clone().step_by(every).map(|k| self.value(k)).collect();
        let width = 1.5 * spread(&mut values);
        let same = median(values.iter().copied()).unwrap_or(0.0);
        let is_same = |k: &usize| (self.value(*k) - same).abs() <= width;
        let start = (0..run.start).rev().take_while(is_same).last();
        let end = (run.end..self.n()).take_while(is_same).last();
        start.unwrap_or(run.start)..end.map_or(run.end, |last| last + 1)
    }
}

/// Returns the range of the values without a tenth at each end.
fn spread(values: &mut [f64]) -> f64 {
    let [low, high] = [0.1, 0.9].map(|share| quantile(values, share).unwrap_or(0.0));
    high - low
}

#[cfg(test)]
mod tests {
    use crate::random::Random;
    use crate::recording::ValidRange;
    use crate::scoring::faults::faults;
    use crate::scoring::faults::tests::{recording, sensor, words};

    #[test]
    fn a_gauge_that_is_clipped_before_its_noise_is_found() {
        let mut random = Random::new(4, &[]);
        for (limit, inward) in [(12.0, -1.0), (-3.0, 1.0)] {
            let (mut gauges, loads) = sensor(None);
            let mut clipped = 0;
            for row in gauges.chunks_exact_mut(3) {
                if inward * (row[0] - limit) < 0.0 {
                    row[0] = limit;
                    clipped += 1;
                }
                row[0] += 0.03 * random.normal();
            }
            let recording = recording(gauges, loads);
            let found = faults(&recording, &ValidRange::default());
            let told = found.in_words(&recording);
            assert_eq!(told.len(), 1, "{told:?}");
            assert!(told[0].ends_with("saturated (S1)"), "{told:?}");
            let few = found.n_samples() as f64 / f64::from(clipped);
            assert!((0.99..1.1).contains(&few), "{told:?} of {clipped}");
            let (low, high) = found.unclipped[0];
            let end = if inward > 0.0 { low } else { high };
            assert!((end.unwrap() - limit).abs() < 0.2, "{end:?}");
        }
    }

    #[test]
    fn a_gauge_that_shows_noise_alone_for_a_while_is_stuck() {
        let mut random = Random::new(5, &[]);
        let (mut gauges, loads) = sensor(None);
        for k in 700..1100 {
            gauges[3 * k + 1] = gauges[3 * 700 + 1] + 0.02 * random.normal();
        }
        let told = words(&recording(gauges, loads));
        assert_eq!(told.len(), 1, "{told:?}");
        let (number, rest) = told[0].split_once(' ').unwrap();
        assert_eq!(rest, "stuck (S2)");
        assert!((380..=420).contains(&number.parse::<usize>().unwrap()), "{number}");
    }
}
