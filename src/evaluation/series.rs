//! A trace that can be drawn at any zoom: samples with minima and maxima over ever longer runs of them.
//!
//! Guarantees: what is drawn of a bucket is its true minimum and maximum, so a spike of one sample never vanishes; the
//! work of drawing depends on the width of the picture, not on the number of samples.

use std::ops::Range;
use std::sync::Arc;

/// Samples in a run of the finest level.
const FINEST: usize = 16;
/// Runs of one level in a run of the next.
const FAN_OUT: usize = 4;

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

    /// Draws the samples in `visible` with about `buckets` pairs of extremes: hands `(sample index, value)` to `point`,
    /// indices rising. Few samples are handed over one by one; what is not finite is left out.
    pub fn reduce(&self, visible: Range<usize>, buckets: usize, mut point: impl FnMut(f64, f64)) {
        let visible = visible.start..visible.end.min(self.len());
        let mut finite = |at: f64, value: f64| {
            if value.is_finite() {
                point(at, value);
            }
        };
        let width = visible.len() / buckets.max(1);
        if width <= 2 {
            for k in visible {
                finite(k as f64, self.value(k));
            }
            return;
        }
        let (width, level) = self.bucket(width);
        // Buckets stand at multiples of their width, so that they stay the same while the view moves.
        for start in (visible.start / width * width..visible.end).step_by(width) {
            let end = (start + width).min(self.len());
            let run = self.run(start..end, level);
            let (first, second) = if self.value(start) <= self.value(end - 1) {
                (run.low, run.high)
            } else {
                (run.high, run.low)
            };
            let quarter = (end - start) as f64 / 4.0;
            finite(start as f64 + quarter, first);
            finite(start as f64 + 3.0 * quarter, second);
        }
    }

    /// The least and greatest value in `samples`; `None` without a finite one.
    pub fn min_max(&self, samples: Range<usize>) -> Option<(f64, f64)> {
        let mut all = Extremes::NONE;
        self.reduce(samples, 64, |_, value| {
            all = all.with(Extremes {
                low: value,
                high: value,
            });
        });
        (all.low <= all.high).then_some((all.low, all.high))
    }

    /// The bucket width near `wanted` that whole runs of a level make up, with that level.
    fn bucket(&self, wanted: usize) -> (usize, Option<usize>) {
        let mut size = FINEST;
        let mut level = None;
        for at in 0..self.levels.len() {
            if size > wanted {
                break;
            }
            level = Some(at);
            size *= FAN_OUT;
        }
        match level {
            None => (wanted, None),
            Some(_) => {
                let run = size / FAN_OUT;
                (wanted.next_multiple_of(run), level)
            }
        }
    }

    fn run(&self, samples: Range<usize>, level: Option<usize>) -> Extremes {
        match level {
            None => extremes(samples.map(|k| self.value(k))),
            Some(level) => {
                let size = FINEST * FAN_OUT.pow(level as u32);
                self.levels[level][samples.start / size..samples.end.div_ceil(size)]
                    .iter()
                    .copied()
                    .fold(Extremes::NONE, Extremes::with)
            }
        }
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
    values.fold(Extremes::NONE, |all, value| {
        all.with(Extremes {
            low: value,
            high: value,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(series: &Series, visible: Range<usize>, buckets: usize) -> Vec<(f64, f64)> {
        let mut points = Vec::new();
        series.reduce(visible, buckets, |at, value| points.push((at, value)));
        points
    }

    fn wave(n: usize) -> Arc<[f64]> {
        (0..n)
            .map(|k| (k as f64 * 0.01).sin() + ((k * 37) % 101) as f64 * 1e-3)
            .collect()
    }

    #[test]
    fn a_spike_of_one_sample_never_vanishes() {
        for n in [17, 1_000, 70_001] {
            for at in [0, n / 3, n - 1] {
                let mut values = vec![0.0; n];
                values[at] = 9.0;
                let series = Series::new(values.into());
                for buckets in [1, 7, 100, 1_000] {
                    let peak = points(&series, 0..n, buckets)
                        .iter()
                        .fold(0.0_f64, |peak, point| peak.max(point.1));
                    assert_eq!(peak, 9.0, "{n} samples, spike at {at}, {buckets} buckets");
                }
            }
        }
    }

    #[test]
    fn buckets_hold_the_true_extremes_in_rising_order() {
        let values = wave(50_000);
        let series = Series::new(values.clone());
        for (visible, buckets) in [(0..50_000, 300), (777..43_210, 50), (9..9_000, 11)] {
            let points = points(&series, visible.clone(), buckets);
            assert!(points.is_sorted_by(|a, b| a.0 < b.0));
            assert!(points.len() <= 2 * buckets + 4, "{} points", points.len());
            let (width, _) = series.bucket(visible.len() / buckets);
            for pair in points.chunks_exact(2) {
                let start = pair[0].0 as usize / width * width;
                let bucket = &values[start..(start + width).min(values.len())];
                let low = bucket.iter().copied().fold(f64::INFINITY, f64::min);
                let high = bucket.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                assert_eq!(pair[0].1.min(pair[1].1), low);
                assert_eq!(pair[0].1.max(pair[1].1), high);
            }
        }
    }

    #[test]
    fn few_samples_are_handed_over_one_by_one() {
        let series = Series::new(wave(100));
        let points = points(&series, 10..20, 100);
        assert_eq!(points.len(), 10);
        assert_eq!(points[0], (10.0, series.value(10)));
    }

    #[test]
    fn a_difference_is_the_difference_at_every_zoom() {
        let (a, b) = (wave(5_000), wave(5_001)[1..].to_vec());
        let stored: Arc<[f64]> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        let difference = Series::difference(a, b.into());
        let stored = Series::new(stored);
        for buckets in [5, 100, 5_000] {
            assert_eq!(
                points(&difference, 0..5_000, buckets),
                points(&stored, 0..5_000, buckets)
            );
        }
    }

    #[test]
    fn values_that_are_not_finite_are_left_out() {
        let series = Series::new(vec![1.0, f64::NAN, f64::INFINITY, 2.0].into());
        assert_eq!(points(&series, 0..4, 10), [(0.0, 1.0), (3.0, 2.0)]);
        assert_eq!(Series::new(vec![].into()).min_max(0..0), None);
        assert_eq!(series.min_max(0..4), Some((1.0, 2.0)));
    }
}
