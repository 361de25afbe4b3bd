//! Trace that can be drawn fast at any zoom, because minima and maxima over runs of consecutive samples are stored.
//!
//! Guarantees: the plot is divided into columns, and each is drawn from its own samples, at least by their minimum and
//! maximum. So no drawn point is farther than a column's width from the measured trace, and no sample is farther than this
//! from the drawing. A peak of one sample is always visible. The time of drawing depends on the number of columns, not on
//! the number of samples.

use crate::{
    min_max::MinMax,
    outward::{rounded_down, rounded_up},
    progress::Progress,
};
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

/// Number of consecutive samples in a run of the first, finest level.
const FINEST: usize = 32;
/// Number of runs of one level that together form a run of the next, coarser level.
const FAN_OUT: usize = 4;
/// Maximum number of samples in a column of which all samples are drawn.
const FEW: usize = 4;
/// Minimum number of samples in a column that begins and ends at borders of runs. Such a column is drawn by its minimum and
/// maximum alone.
const MANY: usize = 4 * FINEST;
/// Maximum shift of a column's end in time to a border of runs, as a share of the column's width.
const MOVED: f64 = 0.25;
/// Number of samples whose minima and maxima are computed in one step.
const CHUNK: usize = 256 * FINEST;

/// Values of a trace, which are stored in memory or computed when they are read.
pub trait Values: fmt::Debug + Send + Sync {
    fn n_samples(&self) -> usize;

    fn read(&self, samples: Range<usize>, out: &mut [f64]);
}

impl Values for Arc<[f64]> {
    fn n_samples(&self) -> usize {
        self.len()
    }

    fn read(&self, samples: Range<usize>, out: &mut [f64]) {
        out.copy_from_slice(&self[samples]);
    }
}

/// Difference of two traces, computed when its values are read.
#[derive(Debug)]
struct Difference(Arc<dyn Values>, Arc<dyn Values>);

impl Values for Difference {
    fn n_samples(&self) -> usize {
        self.0.n_samples()
    }

    fn read(&self, samples: Range<usize>, out: &mut [f64]) {
        self.0.read(samples.clone(), out);
        let mut taken = [0.0; FINEST];
        for (start, out) in samples.clone().step_by(FINEST).zip(out.chunks_mut(FINEST)) {
            let taken = &mut taken[..out.len()];
            self.1.read(start..start + taken.len(), taken);
            for (value, taken) in out.iter_mut().zip(taken) {
                *value -= *taken;
            }
        }
    }
}

#[derive(Debug)]
pub struct Series {
    pub values: Arc<dyn Values>,
    /// Number of consecutive samples in a run of the first, finest level.
    finest: usize,
    /// True if all samples of a run of the first level have the same value.
    is_held: bool,
    /// Minima and maxima of runs: `levels[l]` holds those of runs of `finest · FAN_OUT^l` samples. The last run may be shorter.
    levels: Vec<Vec<Extremes>>,
}

/// Minimum and maximum of a run in single precision, rounded outward.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    low: f32,
    high: f32,
}

impl Extremes {
    const NONE: Self = Self { low: f32::INFINITY, high: f32::NEG_INFINITY };

    fn of(all: MinMax) -> Self {
        Self { low: rounded_down(all.min), high: rounded_up(all.max) }
    }

    fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

impl From<Extremes> for MinMax {
    fn from(Extremes { low, high }: Extremes) -> Self {
        Self { min: low.into(), max: high.into() }
    }
}

impl Series {
    pub fn new(values: Arc<[f64]>) -> Self {
        Self::of(Arc::new(values))
    }

    pub fn of(values: Arc<dyn Values>) -> Self {
        let mut one = Self::all_of(vec![values], &Progress::default());
        one.pop().expect("there is one trace for each list of values")
    }

    /// Returns the values `a − b`, computed when they are read. Panics if the lengths differ.
    pub fn difference(a: Arc<dyn Values>, b: Arc<dyn Values>) -> Arc<dyn Values> {
        assert_eq!(a.n_samples(), b.n_samples(), "both traces are of the same recording");
        Arc::new(Difference(a, b))
    }

    /// Returns one trace for each of `all`, whose values are read together. All must have the same samples. After
    /// cancellation, the traces are incomplete.
    pub fn all_of(all: Vec<Arc<dyn Values>>, progress: &Progress) -> Vec<Self> {
        let n = all.iter().map(|values| values.n_samples()).max();
        let chunks = (0..n.unwrap_or(0)).into_par_iter().step_by(CHUNK);
        let chunks: Vec<Vec<Extremes>> = chunks
            .map_init(
                || vec![0.0; CHUNK],
                |room, start| {
                    let mut found = Vec::with_capacity(all.len() * (CHUNK / FINEST));
                    for values in &all {
                        let end = (start + CHUNK).min(values.n_samples()).max(start);
                        let room = &mut room[..end - start];
                        if !progress.is_cancelled() {
                            values.read(start..end, room);
                        }
                        found.extend(room.chunks(FINEST).map(|run| Extremes::of(extremes(run))));
                    }
                    found
                },
            )
            .collect();
        let mut begun = vec![0; chunks.len()];
        let series = all.into_iter().map(|values| {
            let mut level = Vec::with_capacity(values.n_samples().div_ceil(FINEST));
            for (at, (chunk, begun)) in chunks.iter().zip(&mut begun).enumerate() {
                let left = values.n_samples().saturating_sub(at * CHUNK);
                let end = *begun + left.min(CHUNK).div_ceil(FINEST);
                level.extend(&chunk[*begun..end]);
                *begun = end;
            }
            Self::with_level(values, FINEST, level)
        });
        series.collect()
    }

    /// Returns the trace of `n` samples whose value changes every `each` samples. Panics unless there is one value per change.
    pub fn held(values: Arc<[f64]>, each: usize, n: usize) -> Self {
        assert_eq!(
            values.len(),
            n.div_ceil(each),
            "one value is needed for every `each` samples of the trace"
        );
        let level = values.iter().map(|value| Extremes::of(extremes(&[*value])));
        let level = level.collect();
        Self { is_held: true, ..Self::with_level(Arc::new(Held { values, each, n }), each, level) }
    }

    fn with_level(values: Arc<dyn Values>, finest: usize, mut level: Vec<Extremes>) -> Self {
        let mut levels = Vec::new();
        while level.len() > 1 {
            let next = level
                .chunks(FAN_OUT)
                .map(|runs| runs.iter().copied().fold(Extremes::NONE, Extremes::with))
                .collect();
            levels.push(std::mem::replace(&mut level, next));
        }
        Self { values, finest, is_held: false, levels }
    }

    pub fn len(&self) -> usize {
        self.values.n_samples()
    }

    /// Returns the value of sample `k`. Panics if the sample does not exist.
    pub fn value(&self, k: usize) -> f64 {
        let mut one = [0.0];
        self.values.read(k..k + 1, &mut one);
        one[0]
    }

    /// Passes the value of each of these samples to `take`, in order. Panics if a sample does not exist.
    pub fn each(&self, samples: Range<usize>, mut take: impl FnMut(f64)) {
        let mut room = [0.0; FINEST];
        for start in samples.clone().step_by(FINEST) {
            let room = &mut room[..(samples.end - start).min(FINEST)];
            self.values.read(start..start + room.len(), room);
            room.iter().copied().for_each(&mut take);
        }
    }

    /// Draws these samples in columns of equal width in time. Passes the points `(time, value)` to `point`, with rising times.
    ///
    /// A column with a few samples yields all of them. A column with more samples yields its first sample, its minimum and
    /// maximum at the middle, and its last sample. A column with many samples yields only minimum and maximum. Values that are
    /// not finite are left out. Panics if the lengths differ.
    pub fn draw(
        &self,
        times: &[f64],
        samples: Range<usize>,
        column_secs: f64,
        mut point: impl FnMut(f64, f64),
    ) {
        assert_eq!(times.len(), self.len(), "there is one time for each sample");
        self.draw_in(&Columns::of(times, samples, column_secs), times, &mut point);
    }

    /// Draws like [`Self::draw`], in columns that several traces can share. Panics if a sample of a column does not exist.
    pub fn draw_in(&self, columns: &Columns, times: &[f64], mut point: impl FnMut(f64, f64)) {
        // `before` is the value of the point drawn last. `open` is the time, minimum and maximum of the pixel column drawn
        // last, if that column holds more than one sample.
        let mut before = f64::NAN;
        let mut open: Option<(f64, MinMax)> = None;
        let mut finite = |at: f64, value: f64| {
            if value.is_finite() {
                point(at, value);
            }
        };
        for column in &columns.0 {
            let Range { start, end } = column.samples;
            let n = end - start;
            let first = (!column.is_joined[0]).then(|| self.value(start));
            let range = if n > FEW { self.run(start..end) } else { MinMax::NONE };
            if let Some((at, range_before)) = open.take() {
                // The line leaves the previous column at the value that is nearest to the first value of this column.
                before = range_before.min.max(first.unwrap_or(range.min)).min(range_before.max);
                finite(at, before);
            }
            if n <= FEW {
                let mut at = times[start..end].iter();
                self.each(start..end, |value| {
                    at.next().into_iter().for_each(|time| finite(*time, value));
                    before = value;
                });
                continue;
            }
            let MinMax { min: low, max: high } = range;
            let [from_secs, to_secs] = column.secs;
            let middle = 0.5 * (from_secs + to_secs);
            let last = (!column.is_joined[1]).then(|| self.value(end - 1));
            let (at, from) = match first {
                Some(first) => (from_secs, first),
                None => (middle, before.max(low).min(high)),
            };
            let rises = match last {
                Some(last) => from <= last,
                None => from - low <= high - from,
            };
            finite(at, from);
            let inner = if rises { [low, high] } else { [high, low] };
            for value in inner {
                if value != from && last != Some(value) {
                    finite(middle, value);
                }
            }
            match last {
                Some(last) => finite(to_secs, last),
                None => open = Some((middle, range)),
            }
            before = last.unwrap_or(inner[1]);
        }
    }

    /// Returns the minimum and maximum in `samples`, rounded outward to single precision; `None` without a finite value.
    pub fn min_max(&self, samples: Range<usize>) -> Option<(f64, f64)> {
        self.run(samples.start..samples.end.min(self.len())).ends()
    }

    /// Returns the minimum and maximum of the finite values in `samples`.
    fn run(&self, samples: Range<usize>) -> MinMax {
        let one_by_one = |all: MinMax, samples: Range<usize>| {
            let mut all = all;
            self.each(samples, |value| all = with(all, value));
            all
        };
        let finest = self.finest;
        if self.is_held && !self.levels.is_empty() && !samples.is_empty() {
            // All samples of a run have the same value, so the minima and maxima of whole runs are enough.
            return self.runs(samples.start / finest..samples.end.div_ceil(finest));
        }
        // Otherwise the samples consist of whole runs of the first level, and of single samples before and after these runs.
        let (first, end) = (samples.start.div_ceil(finest), samples.end / finest);
        if self.levels.is_empty() || first >= end {
            return one_by_one(MinMax::NONE, samples);
        }
        let beside = one_by_one(MinMax::NONE, samples.start..first * finest);
        let beside = one_by_one(beside, end * finest..samples.end);
        self.runs(first..end).joined(beside)
    }

    /// Returns the minimum and maximum of these runs of the first level.
    fn runs(&self, Range { mut start, mut end }: Range<usize>) -> MinMax {
        let mut all = Extremes::NONE;
        for (at, level) in self.levels.iter().enumerate() {
            let add = |all: Extremes, runs: Range<usize>| {
                level[runs].iter().copied().fold(all, Extremes::with)
            };
            let (inner, inner_end) = (start.div_ceil(FAN_OUT), end / FAN_OUT);
            if at + 1 == self.levels.len() || inner >= inner_end {
                return add(all, start..end).into();
            }
            all = add(all, start..inner * FAN_OUT);
            all = add(all, inner_end * FAN_OUT..end);
            (start, end) = (inner, inner_end);
        }
        all.into()
    }
}

/// Values that change only every `each` samples.
#[derive(Debug)]
struct Held {
    values: Arc<[f64]>,
    each: usize,
    n: usize,
}

impl Values for Held {
    fn n_samples(&self) -> usize {
        self.n
    }

    fn read(&self, samples: Range<usize>, out: &mut [f64]) {
        for (k, out) in samples.zip(out) {
            *out = self.values[k / self.each];
        }
    }
}

/// Division of samples into columns of equal width in time.
#[derive(Clone, Debug, Default)]
pub struct Columns(Vec<ColumnOf>);

#[derive(Clone, Debug)]
struct ColumnOf {
    samples: Range<usize>,
    /// Times of the column's first and last sample (s).
    secs: [f64; 2],
    /// For the start and the end of a column: true if the column has many samples and the line continues there without a
    /// pause.
    is_joined: [bool; 2],
}

impl Columns {
    /// Divides these samples into columns of equal width in time. The ends of a column with many samples are shifted
    /// slightly, to borders of runs.
    pub fn of(times: &[f64], samples: Range<usize>, column_secs: f64) -> Self {
        let (mut start, end) = (samples.start, samples.end.min(times.len()));
        let mut columns = Vec::new();
        while start < end {
            // Columns begin at multiples of their width, so that they do not change while the visible interval moves.
            let edge = ((times[start] / column_secs).floor() + 1.0) * column_secs;
            let n = before_edge(&times[start..end], edge);
            // If the width is zero or below the resolution of the times, each sample is a column.
            let exact = start + n.max(1);
            let rounded = exact.next_multiple_of(FINEST);
            let is_moved = exact - start >= MANY
                && rounded < end
                && times[rounded - 1] - edge <= MOVED * column_secs;
            let next = if is_moved { rounded } else { exact };
            // At a pause in the recording, the line ends at a sample and begins again at a sample.
            let goes_on = |k: usize| {
                let is_inside = samples.start < k && k < end;
                next - start >= MANY && is_inside && times[k] - times[k - 1] < column_secs
            };
            columns.push(ColumnOf {
                samples: start..next,
                secs: [times[start], times[next - 1]],
                is_joined: [start, next].map(goes_on),
            });
            start = next;
        }
        Self(columns)
    }
}

/// Returns the number of the ascending `times` that lie before `edge`. The search starts at the first time and reads only a
/// few times.
fn before_edge(times: &[f64], edge: f64) -> usize {
    let mut reach = 1;
    while reach < times.len() && times[reach] < edge {
        reach *= 2;
    }
    let near = &times[..times.len().min(reach + 1)];
    near.partition_point(|time| *time < edge)
}

fn with(all: MinMax, value: f64) -> MinMax {
    all.with(if value.is_finite() { value } else { f64::NAN })
}

fn extremes(values: &[f64]) -> MinMax {
    // Eight minima and maxima are computed side by side, so that the processor need not wait for each comparison.
    const LANES: usize = 8;
    let mut all = [MinMax::NONE; LANES];
    for values in values.chunks(LANES) {
        for (all, value) in all.iter_mut().zip(values) {
            *all = with(*all, *value);
        }
    }
    all.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoring::pixels;

    fn wave(n: usize) -> Arc<[f64]> {
        (0..n).map(|k| (k as f64 * 0.01).sin() + ((k * 37) % 101) as f64 * 1e-3).collect()
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
                    let peak = points.iter().fold(0.0_f64, |peak, point| peak.max(point[1]));
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

    /// Checks all samples and a part of them, in pixels of a plot 300 wide and 200 high.
    #[test]
    fn nothing_drawn_or_measured_is_further_than_a_pixel_from_the_other() {
        assert_within_a_pixel(6_000, [0..6_000, 1_777..2_100]);
        assert_within_a_pixel(42_000, [0..42_000, 7_000..41_000]);
    }

    fn assert_within_a_pixel(n: usize, on_screen: [Range<usize>; 2]) {
        let spikes = (0..n).map(|k| if k % 701 == 0 { 5.0 } else { 0.1 * (k as f64 * 0.7).sin() });
        let gaps = (0..n).map(|k| if k % 97 < 9 { f64::NAN } else { (k as f64 * 0.002).sin() });
        let kinds: [Arc<[f64]>; 4] =
            [wave(n), spikes.collect(), gaps.collect(), vec![3.0; n].into()];
        for (kind, values) in kinds.iter().enumerate() {
            for (clock, times) in clocks(n).iter().enumerate() {
                for samples in on_screen.clone() {
                    let series = Series::new(Arc::clone(values));
                    let all: Vec<[f64; 2]> =
                        samples.clone().map(|k| [times[k], values[k]]).collect();
                    let all: Vec<_> =
                        all.into_iter().filter(|point| point[1].is_finite()).collect();
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
                    assert!(drawn.len() <= FEW * 302 || clock == 3, "{} points", drawn.len());
                    let drawn: Vec<_> = drawn.iter().map(place).collect();
                    let beside = pixels::farthest(&drawn, &measured);
                    let missed = pixels::farthest(&measured, &drawn);
                    assert!(
                        beside <= 1.0,
                        "{n} samples, kind {kind}, clock {clock}: {beside} pixels beside"
                    );
                    assert!(
                        missed <= 1.0,
                        "{n} samples, kind {kind}, clock {clock}: {missed} pixels missed"
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
        let b: Arc<[f64]> = b.into();
        let difference = Series::of(Series::difference(Arc::new(a), Arc::new(b)));
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
            let shown = values[samples.clone()].iter();
            let expected = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(*value), high.max(*value))
            });
            let (low, high) = series.min_max(samples).unwrap();
            assert!(low <= expected.0 && expected.1 <= high, "no sample is cut off");
            assert!(expected.0 - low <= 1e-7 && high - expected.1 <= 1e-7);
        }
    }

    #[test]
    fn values_that_are_not_finite_are_left_out() {
        let series = Series::new(vec![1.0, f64::NAN, f64::INFINITY, 2.0].into());
        assert_eq!(points(&series, &even(4), 0..4, 0.1), [[0.0, 1.0], [3.0, 2.0]]);
        assert_eq!(Series::new(vec![].into()).min_max(0..0), None);
        assert_eq!(series.min_max(0..4), Some((1.0, 2.0)));
    }
}
