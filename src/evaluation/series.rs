//! A trace that can be drawn at any zoom: samples with minima and maxima over ever longer runs of them.
//!
//! Guarantees: nothing drawn is further than a column's width from what was measured, and nothing measured is further than
//! that from what is drawn, however uneven the times; a spike of one sample never vanishes; the work of drawing depends on
//! the width of the picture, not on the number of samples.

use std::ops::Range;
use std::sync::Arc;

/// Samples in a run of the finest level.
const FINEST: usize = 16;
/// Runs of one level in a run of the next.
const FAN_OUT: usize = 4;
/// So many samples of a column are drawn one by one.
const FEW: usize = 4;

/// One trace.
#[derive(Clone, Debug)]
pub struct Series {
    values: Values,
    /// `levels[l]` holds the extremes of runs of `FINEST · FAN_OUT^l` samples; the last run may be short.
    levels: Vec<Vec<Extremes>>,
}

#[derive(Clone, Debug)]
enum Values {
    Stored(Arc<[f64]>),
    /// First minus second.
    Difference(Arc<[f64]>, Arc<[f64]>),
}

#[derive(Clone, Copy, Debug)]
struct Extremes {
    low: f64,
    high: f64,
}

impl Extremes {
    const NONE: Self = Self {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    fn with(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }
}

impl Series {
    /// A trace of stored values.
    pub fn new(values: Arc<[f64]>) -> Self {
        Self::of(Values::Stored(values))
    }

    /// The trace `a − b`, which is not stored.
    ///
    /// # Panics
    /// If the two differ in length.
    pub fn difference(a: Arc<[f64]>, b: Arc<[f64]>) -> Self {
        assert_eq!(a.len(), b.len(), "traces of one recording");
        Self::of(Values::Difference(a, b))
    }

    fn of(values: Values) -> Self {
        let finest = |run: Range<usize>| match &values {
            Values::Stored(values) => extremes(values[run].iter().copied()),
            Values::Difference(a, b) => {
                extremes(a[run.clone()].iter().zip(&b[run]).map(|(a, b)| a - b))
            }
        };
        let n = values.len();
        let mut levels = Vec::new();
        let mut level: Vec<Extremes> = (0..n)
            .step_by(FINEST)
            .map(|start| finest(start..(start + FINEST).min(n)))
            .collect();
        while level.len() > 1 {
            let next = level
                .chunks(FAN_OUT)
                .map(|runs| runs.iter().copied().fold(Extremes::NONE, Extremes::with))
                .collect();
            levels.push(std::mem::replace(&mut level, next));
        }
        Self { values, levels }
    }

    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sample `k`.
    ///
    /// # Panics
    /// If there is no sample `k`.
    pub fn value(&self, k: usize) -> f64 {
        self.values.at(k)
    }

    /// Draws these samples in columns of a width in time: hands `(time, value)` to `point`, times rising. Of a column with
    /// more than a few samples it gives the first, the extremes in the column's middle, and the last; what is not finite is
    /// left out.
    ///
    /// # Panics
    /// If there are not as many times as samples.
    pub fn draw(
        &self,
        times: &[f64],
        samples: Range<usize>,
        column_secs: f64,
        mut point: impl FnMut(f64, f64),
    ) {
        assert_eq!(times.len(), self.len(), "one time for each sample");
        let end = samples.end.min(self.len());
        let mut start = samples.start;
        let mut finite = |at: f64, value: f64| {
            if value.is_finite() {
                point(at, value);
            }
        };
        while start < end {
            // Columns stand at multiples of their width, so that they stay the same while the view moves.
            let edge = ((times[start] / column_secs).floor() + 1.0) * column_secs;
            let n = times[start..end].partition_point(|time| *time < edge);
            // Without a width, or with one that times cannot tell, each sample is a column.
            let next = start + n.max(1);
            if next - start <= FEW {
                for (time, k) in times[start..next].iter().zip(start..) {
                    finite(*time, self.value(k));
                }
            } else {
                let (first, last) = (self.value(start), self.value(next - 1));
                let run = self.run(start..next);
                let middle = 0.5 * (times[start] + times[next - 1]);
                let inner = if first <= last {
                    [run.low, run.high]
                } else {
                    [run.high, run.low]
                };
                finite(times[start], first);
                for value in inner
                    .into_iter()
                    .filter(|value| ![first, last].contains(value))
                {
                    finite(middle, value);
                }
                finite(times[next - 1], last);
            }
            start = next;
        }
    }

    /// The least and greatest value in `samples`; `None` without a finite one.
    pub fn min_max(&self, samples: Range<usize>) -> Option<(f64, f64)> {
        let all = self.run(samples.start..samples.end.min(self.len()));
        (all.low <= all.high).then_some((all.low, all.high))
    }

    /// The extremes of what is finite in `samples`.
    fn run(&self, samples: Range<usize>) -> Extremes {
        let one_by_one = |range: Range<usize>| extremes(range.map(|k| self.value(k)));
        if samples.is_empty() {
            return Extremes::NONE;
        }
        // Whole runs of the finest level, and what lies beside them.
        let (mut first, mut end) = (samples.start.div_ceil(FINEST), samples.end / FINEST);
        if self.levels.is_empty() || first >= end {
            return one_by_one(samples);
        }
        let mut all =
            one_by_one(samples.start..first * FINEST).with(one_by_one(end * FINEST..samples.end));
        for (at, level) in self.levels.iter().enumerate() {
            let add = |all: Extremes, runs: Range<usize>| {
                level[runs].iter().copied().fold(all, Extremes::with)
            };
            if at + 1 == self.levels.len() {
                return add(all, first..end);
            }
            let (inner, inner_end) = (first.div_ceil(FAN_OUT), end / FAN_OUT);
            if inner >= inner_end {
                return add(all, first..end);
            }
            all = add(all, first..inner * FAN_OUT);
            all = add(all, inner_end * FAN_OUT..end);
            (first, end) = (inner, inner_end);
        }
        all
    }
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Self::Stored(values) | Self::Difference(values, _) => values.len(),
        }
    }

    fn at(&self, k: usize) -> f64 {
        match self {
            Self::Stored(values) => values[k],
            Self::Difference(a, b) => a[k] - b[k],
        }
    }
}

fn extremes(values: impl Iterator<Item = f64>) -> Extremes {
    let finite = values.filter(|value| value.is_finite());
    finite.fold(Extremes::NONE, |all, value| {
        all.with(Extremes {
            low: value,
            high: value,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::pixels;

    fn wave(n: usize) -> Arc<[f64]> {
        (0..n)
            .map(|k| (k as f64 * 0.01).sin() + ((k * 37) % 101) as f64 * 1e-3)
            .collect()
    }

    fn even(n: usize) -> Vec<f64> {
        (0..n).map(|k| k as f64).collect()
    }

    fn points(series: &Series, times: &[f64], samples: Range<usize>, column: f64) -> Vec<[f64; 2]> {
        let mut points = Vec::new();
        series.draw(times, samples, column, |at, value| points.push([at, value]));
        points
    }

    #[test]
    fn a_spike_of_one_sample_never_vanishes() {
        for n in [17, 1_000, 70_001] {
            for at in [0, n / 3, n - 1] {
                let mut values = vec![0.0; n];
                values[at] = 9.0;
                let series = Series::new(values.into());
                for columns in [1, 7, 100, 1_000] {
                    let column = n as f64 / f64::from(columns);
                    let points = points(&series, &even(n), 0..n, column);
                    let peak = points
                        .iter()
                        .fold(0.0_f64, |peak, point| peak.max(point[1]));
                    assert_eq!(peak, 9.0, "{n} samples, spike at {at}, {columns} columns");
                    assert!(points.len() <= FEW * (columns as usize + 1));
                }
            }
        }
    }

    /// Even times; bursts with long pauses; a fast start and a slow end; one interval in which time stands still.
    fn clocks(n: usize) -> [Vec<f64>; 4] {
        let of = |at: &dyn Fn(usize) -> f64| (0..n).map(at).collect();
        [
            of(&|k| 1e6 + 0.05 * k as f64),
            of(&|k| (k / 15) as f64 * 0.2 + (k % 15) as f64 * 4e-4),
            of(&|k| if k < n / 2 { 1e-3 * k as f64 } else { k as f64 }),
            of(&|k| if k < n / 3 { k as f64 } else { (n / 3) as f64 }),
        ]
    }

    /// In pixels of a picture 300 wide and 200 high, of all samples and of a part.
    #[test]
    fn nothing_drawn_or_measured_is_further_than_a_pixel_from_the_other() {
        let n = 6000;
        let spikes = (0..n).map(|k| {
            if k % 701 == 0 {
                5.0
            } else {
                0.1 * (k as f64 * 0.7).sin()
            }
        });
        let gaps = (0..n).map(|k| {
            if k % 97 < 9 {
                f64::NAN
            } else {
                (k as f64 * 0.002).sin()
            }
        });
        let kinds: [Arc<[f64]>; 4] = [
            wave(n),
            spikes.collect(),
            gaps.collect(),
            vec![3.0; n].into(),
        ];
        for (kind, values) in kinds.iter().enumerate() {
            for (clock, times) in clocks(n).iter().enumerate() {
                for samples in [0..n, 1777..2100] {
                    let series = Series::new(Arc::clone(values));
                    let all: Vec<[f64; 2]> =
                        samples.clone().map(|k| [times[k], values[k]]).collect();
                    let all: Vec<_> = all
                        .into_iter()
                        .filter(|point| point[1].is_finite())
                        .collect();
                    let (low, high) = series.min_max(samples.clone()).unwrap();
                    let (from, to) = (times[samples.start], times[samples.end - 1]);
                    let column = (to - from) / 300.0;
                    let place = |[time, value]: &[f64; 2]| {
                        [
                            (time - from) / (to - from).max(1e-9) * 300.0,
                            (value - low) / (high - low).max(1e-9) * 200.0,
                        ]
                    };
                    let measured: Vec<_> = all.iter().map(place).collect();
                    let drawn = points(&series, times, samples, column);
                    assert!(
                        drawn.len() <= FEW * 302 || clock == 3,
                        "{} points",
                        drawn.len()
                    );
                    let drawn: Vec<_> = drawn.iter().map(place).collect();
                    let beside = pixels::farthest(&drawn, &measured);
                    let missed = pixels::farthest(&measured, &drawn);
                    assert!(
                        beside <= 1.0,
                        "kind {kind}, clock {clock}: {beside} pixels beside"
                    );
                    assert!(
                        missed <= 1.0,
                        "kind {kind}, clock {clock}: {missed} pixels missed"
                    );
                }
            }
        }
    }

    #[test]
    fn few_samples_are_handed_over_one_by_one() {
        let series = Series::new(wave(100));
        let points = points(&series, &even(100), 10..20, 1.0);
        assert_eq!(points.len(), 10);
        assert_eq!(points[0], [10.0, series.value(10)]);
    }

    #[test]
    fn a_difference_is_the_difference_at_every_zoom() {
        let (a, b) = (wave(5_000), wave(5_001)[1..].to_vec());
        let stored: Arc<[f64]> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        let difference = Series::difference(a, b.into());
        let stored = Series::new(stored);
        for column in [1000.0, 50.0, 1.0] {
            let of = |series| points(series, &even(5_000), 0..5_000, column);
            assert_eq!(of(&difference), of(&stored));
        }
    }

    #[test]
    fn extremes_are_those_of_a_plain_search() {
        let values = wave(9_000);
        let series = Series::new(Arc::clone(&values));
        for samples in [0..9_000, 3..7, 15..17, 16..32, 777..8_191, 8_999..9_000] {
            let own = values[samples.clone()].iter();
            let expected = own.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(*value), high.max(*value))
            });
            assert_eq!(series.min_max(samples), Some(expected));
        }
    }

    #[test]
    fn values_that_are_not_finite_are_left_out() {
        let series = Series::new(vec![1.0, f64::NAN, f64::INFINITY, 2.0].into());
        assert_eq!(
            points(&series, &even(4), 0..4, 0.1),
            [[0.0, 1.0], [3.0, 2.0]]
        );
        assert_eq!(Series::new(vec![].into()).min_max(0..0), None);
        assert_eq!(series.min_max(0..4), Some((1.0, 2.0)));
    }
}
