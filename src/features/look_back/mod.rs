//! Look-back, the rule of Koike et al. (2019), Eq. 9-12: finds the last sample whose load differs from the present load by at
//! least the force threshold F_th. This sample is called the past sample; its gauge values are features of the present one.
//!
//! The past sample of sample k is the last sample j ≤ k with the load difference `d(k, j) ≥ F_th` and the age `t_k − t_j ≤
//! t_th` (time threshold). Without such a sample, it is k itself.
//!
//! Guarantees: the result equals that of a search sample by sample. The computing time per sample grows with the logarithm of
//! the number of samples within t_th, unless load differences stay near F_th.
//!
//! In that paper, the time t_past of the past sample is t_interval before the present (Eq. 9). The present load is a function
//! of the past and the present gauges (Eq. 10). It is a function of the present gauges alone if the force never differed by
//! F_th (Eq. 11), or differed only longer ago than t_th (Eq. 12).
//!
//! Method: samples are stored in groups of eight, whose distances from the present load are computed together. Each group has
//! a bounding box of its loads, and each four boxes have a larger box. A box whose farthest corner is nearer to the present
//! load than F_th cannot contain the past sample and is skipped.

mod live;
mod thresholds;

use std::fmt;
use std::sync::Arc;

use rayon::prelude::*;

use crate::{
    features::kept::Kept,
    outward::{rounded_down, rounded_up},
    progress::Progress,
    vectorised::vectorised,
};

pub(crate) use live::LiveLookBack;
pub(crate) use thresholds::measured;
pub use thresholds::{Distance, F_TH, HISTORY_RATE, T_TH, Thresholds};

/// Number of samples whose load distances are computed together by vector instructions.
const LANES: usize = 8;
/// Number of samples for which one thread searches the past samples at a time, a multiple of [`LANES`].
const RUN: usize = 1 << 15;
/// Number of bounding boxes that are joined to the next larger box.
const FAN_OUT: usize = 4;

/// One load component of eight successive samples.
type Lanes = [f64; LANES];

/// Conventional load of one recording, prepared for the search of past samples.
#[derive(Clone, Debug)]
pub struct LoadPath(Arc<dyn Search>);

/// Search for past samples in a [`Path`] with any number of load components, which is a constant of its type.
trait Search: fmt::Debug + Send + Sync {
    fn past_samples(&self, times: &[f64], thresholds: Thresholds, progress: &Progress) -> Vec<u32>;
}

impl LoadPath {
    /// Prepares the search for past samples in `loads`, which holds one row of `weights.len()` axes for each sample. Axes
    /// with weight zero are ignored. Panics if more than six weights are not zero, or if the last row of `loads` is
    /// incomplete.
    pub fn new(loads: &[f64], weights: &[f64]) -> Self {
        let width = weights.len().max(1);
        assert_eq!(
            loads.len() % width,
            0,
            "the loads must be whole rows, with one number per axis"
        );
        let load = |k: usize, axis: usize| loads[k * width + axis];
        Self::thinned(loads.len() / width, &load, weights, None)
    }

    /// Prepares the search for past samples among samples with these times (s) and the loads `load(k, axis)`. Of samples
    /// closer together than `step_secs`, only the first can be a past sample. Panics if more than six weights are not zero.
    pub fn with_history_step(
        times: &[f64],
        load: &(dyn Fn(usize, usize) -> f64 + Sync),
        weights: &[f64],
        step_secs: f64,
    ) -> Self {
        let kept = kept_samples(times, step_secs);
        Self::thinned(times.len(), load, weights, kept)
    }

    fn thinned(
        n: usize,
        load: &(dyn Fn(usize, usize) -> f64 + Sync),
        weights: &[f64],
        kept: Option<Vec<u32>>,
    ) -> Self {
        let used = measured(weights);
        let row = |k: usize, dimension: usize| {
            let (axis, weight) = used[dimension];
            load(k, axis) * weight
        };
        Self(match used.len() {
            0 => Arc::new(Path::<0>::new(n, row, kept)),
            1 => Arc::new(Path::<1>::new(n, row, kept)),
            2 => Arc::new(Path::<2>::new(n, row, kept)),
            3 => Arc::new(Path::<3>::new(n, row, kept)),
            4 => Arc::new(Path::<4>::new(n, row, kept)),
            5 => Arc::new(Path::<5>::new(n, row, kept)),
            6 => Arc::new(Path::<6>::new(n, row, kept)),
            more => panic!("a load has at most six axes, not {more}"),
        })
    }

    /// Returns for each sample the index of its past sample (Eq. 9-12 of the paper). A sample without past sample gets its
    /// own index. With F_th = 0, every sample is its own past sample.
    ///
    /// `times` (s) must not decrease. Panics unless there is one time for each sample.
    pub fn past_samples(&self, times: &[f64], thresholds: Thresholds) -> Vec<u32> {
        self.past_samples_until(times, thresholds, &Progress::default())
    }

    /// Returns the same as [`past_samples`](Self::past_samples). After a cancellation, the samples not yet searched get their
    /// own index.
    pub fn past_samples_until(
        &self,
        times: &[f64],
        thresholds: Thresholds,
        progress: &Progress,
    ) -> Vec<u32> {
        self.0.past_samples(times, thresholds, progress)
    }
}

/// Returns the indices of the samples that may become past samples: the first, and each at least `step_secs` after the last
/// kept one. `None` means all samples.
fn kept_samples(times: &[f64], step_secs: f64) -> Option<Vec<u32>> {
    let mut kept = Kept::new(step_secs);
    let dropped = times.iter().position(|time| !kept.take(*time))?;
    let later = (dropped + 1..times.len()).filter(|k| kept.take(times[*k]));
    Some((0..dropped).chain(later).map(|k| k as u32).collect())
}

/// Loads of one recording with `D` components, each multiplied by its weight, and the bounding boxes of these loads.
#[derive(Clone, Debug)]
struct Path<const D: usize> {
    n: usize,
    /// Indices of the kept samples, and the weighted loads of all samples. `None` if all samples are kept.
    thinned: Option<(Vec<u32>, Vec<[f64; D]>)>,
    /// Weighted loads of the kept samples, as `groups[g][dimension][lane]`; `lane` is the place of a sample in its group of
    /// eight. The last group is filled up with the last sample.
    groups: Vec<[Lanes; D]>,
    /// Bounding boxes of loads: `levels[0]` holds one box per group, and each next level one box for `FAN_OUT` boxes of the
    /// level below.
    levels: Vec<Vec<Bounds<D>>>,
}

#[derive(Clone, Copy, Debug)]
struct Bounds<const D: usize> {
    low: [f32; D],
    high: [f32; D],
}

impl<const D: usize> Search for Path<D> {
    fn past_samples(&self, times: &[f64], thresholds: Thresholds, progress: &Progress) -> Vec<u32> {
        assert_eq!(times.len(), self.n, "each sample must have one time");
        let mut past: Vec<u32> = (0..self.n as u32).collect();
        if thresholds.f_th <= 0.0 || D == 0 {
            return past; // every sample is its own past sample
        }
        let runs = past.par_chunks_mut(RUN).enumerate();
        let wanted = runs.filter(|_| !progress.is_cancelled());
        wanted.for_each(|(run, past)| {
            vectorised(
                #[inline(always)]
                move || self.search(times, thresholds, run * RUN, past),
            );
        });
        past
    }
}

impl<const D: usize> Path<D> {
    fn new(n: usize, value: impl Fn(usize, usize) -> f64 + Sync, kept: Option<Vec<u32>>) -> Self {
        let n_kept = kept.as_ref().map_or(n, Vec::len);
        let sample = |at: usize| kept.as_ref().map_or(at, |kept| kept[at] as usize);
        let groups: Vec<[Lanes; D]> = (0..n_kept.div_ceil(LANES))
            .into_par_iter()
            .with_min_len(RUN / LANES)
            .map(|group| {
                std::array::from_fn(|dimension| {
                    std::array::from_fn(|lane| {
                        value(sample((group * LANES + lane).min(n_kept - 1)), dimension)
                    })
                })
            })
            .collect();
        let thinned = kept.map(|kept| {
            let point = |k| std::array::from_fn(|dimension| value(k, dimension));
            (kept, (0..n).map(point).collect())
        });
        let boxes = groups.par_iter().with_min_len(RUN / LANES);
        let mut levels = vec![boxes.map(Bounds::of_group).collect::<Vec<_>>()];
        while let Some(below) = levels.last()
            && below.len() >= FAN_OUT
        {
            levels.push(below.chunks_exact(FAN_OUT).map(Bounds::of_boxes).collect());
        }
        Self { n, thinned, groups, levels }
    }

    /// Searches past samples among the kept samples, for one sample at a time.
    #[inline(always)]
    fn search_kept(
        &self,
        (kept, points): &(Vec<u32>, Vec<[f64; D]>),
        times: &[f64],
        thresholds: Thresholds,
        from: usize,
        past: &mut [u32],
    ) {
        let least = thresholds.f_th * thresholds.f_th;
        let Some(now) = times.get(from) else {
            return;
        };
        let mut end = kept.partition_point(|k| (*k as usize) < from);
        let is_old = |k: &u32| now - times[*k as usize] > thresholds.t_th_secs;
        let mut oldest = kept[..end].partition_point(is_old);
        for (k, (point, past)) in (from..).zip(points[from..].iter().zip(past)) {
            while end < kept.len() && kept[end] as usize <= k {
                end += 1;
            }
            while oldest < end && times[k] - times[kept[oldest] as usize] > thresholds.t_th_secs {
                oldest += 1;
            }
            let (whole, rest) = (end / LANES, end % LANES);
            let begun = match rest {
                0 => 0,
                _ => far_lanes(&self.groups[whole], point, least) & ((1 << rest) - 1),
            };
            let found = match begun {
                _ if least <= 0.0 => None, // F_th = 0: the sample itself
                0 => self.find(point, whole, oldest / LANES, least),
                lanes => Some(whole * LANES + lanes.ilog2() as usize),
            };
            let found = found.filter(|at| *at >= oldest);
            *past = found.map_or(k as u32, |at| kept[at]);
        }
    }

    #[inline(always)]
    fn search(&self, times: &[f64], thresholds: Thresholds, from: usize, past: &mut [u32]) {
        if let Some(thinned) = &self.thinned {
            return self.search_kept(thinned, times, thresholds, from, past);
        }
        let least = thresholds.f_th * thresholds.f_th;
        // Times never decrease, so all samples older than the time threshold t_th come before the other samples.
        let is_old = |time: &f64| times[from] - time > thresholds.t_th_secs;
        let mut oldest = times[..from].partition_point(is_old);
        // The rule compares the rounded difference t_k − t_j with t_th. A limit t_k − t_th must not be computed instead,
        // because it would be rounded differently.
        let advance = |oldest: &mut usize, k: usize| {
            while *oldest < k && times[k] - times[*oldest] > thresholds.t_th_secs {
                *oldest += 1;
            }
        };
        for (group, past) in (from / LANES..).zip(past.chunks_mut(LANES)) {
            let first = group * LANES;
            // The eight samples of a group have similar loads, so most bounding boxes can be skipped for all eight samples at
            // once.
            let around = self.levels[0][group];
            let own_is_near = around.farthest_of(&around) < least;
            let mut end = group;
            advance(&mut oldest, first);
            while own_is_near
                && end > oldest / LANES
                && let Some(skipped) = self.skip(end, 1, least, |b| b.farthest_of(&around))
            {
                end -= skipped;
            }
            for (lane, past) in past.iter_mut().enumerate() {
                let k = first + lane;
                advance(&mut oldest, k);
                let point = self.point(k);
                let far = if own_is_near {
                    0
                } else {
                    far_lanes(&self.groups[group], &point, least) & ((2 << lane) - 1)
                };
                let found = if far != 0 {
                    Some(first + far.ilog2() as usize)
                } else {
                    self.find(&point, end, oldest / LANES, least)
                };
                *past = found.filter(|j| *j >= oldest).unwrap_or(k) as u32;
            }
        }
    }

    #[inline(always)]
    fn point(&self, k: usize) -> [f64; D] {
        let group = &self.groups[k / LANES];
        std::array::from_fn(|dimension| group[dimension][k % LANES])
    }

    /// Returns the index of the last sample in the groups `first..end` whose load has at least the squared distance `least`
    /// from `point`; `None` if there is none.
    #[inline(always)]
    fn find(&self, point: &[f64; D], mut end: usize, first: usize, least: f64) -> Option<usize> {
        while end > first {
            if let Some(skipped) = self.skip(end, FAN_OUT, least, |b| b.farthest(point)) {
                end -= skipped;
                continue;
            }
            end -= 1;
            let hits = far_lanes(&self.groups[end], point, least);
            if hits != 0 {
                return Some(end * LANES + hits.ilog2() as usize);
            }
        }
        None
    }

    /// Returns the number of groups that the search can skip: those in the largest bounding box that ends before group `end`
    /// and cannot contain the past sample. Boxes of fewer than `size` groups are not tried. `None` if no box can be skipped.
    #[inline(always)]
    fn skip(
        &self,
        end: usize,
        mut size: usize,
        least: f64,
        farthest: impl Fn(&Bounds<D>) -> f64,
    ) -> Option<usize> {
        let mut skipped = None;
        for level in &self.levels[size.ilog(FAN_OUT) as usize..] {
            if !end.is_multiple_of(size) || farthest(&level[end / size - 1]) >= least {
                break;
            }
            skipped = Some(size);
            size *= FAN_OUT;
        }
        skipped
    }
}

impl<const D: usize> Bounds<D> {
    fn of_group(group: &[Lanes; D]) -> Self {
        let fold = |start: f64, pick: fn(f64, f64) -> f64| {
            group.map(|lanes| lanes.into_iter().fold(start, pick))
        };
        Self {
            low: fold(f64::INFINITY, f64::min).map(rounded_down),
            high: fold(f64::NEG_INFINITY, f64::max).map(rounded_up),
        }
    }

    fn of_boxes(boxes: &[Self]) -> Self {
        boxes[1..].iter().fold(boxes[0], |all, one| Self {
            low: std::array::from_fn(|dimension| all.low[dimension].min(one.low[dimension])),
            high: std::array::from_fn(|dimension| all.high[dimension].max(one.high[dimension])),
        })
    }

    /// Returns the squared distance from the load `point` to the farthest corner of the box, rounded in the same order as in
    /// [`far_lanes`]. Rounding is monotone, so no sample in the box is farther away.
    #[inline(always)]
    fn farthest(&self, point: &[f64; D]) -> f64 {
        let mut sum = 0.0;
        for (dimension, at) in point.iter().enumerate() {
            let below = at - f64::from(self.low[dimension]);
            let above = f64::from(self.high[dimension]) - at;
            let reach = if below > above { below } else { above };
            sum += reach * reach;
        }
        sum
    }

    /// Returns the squared distance between the farthest corners of two boxes. No two samples in these boxes are farther apart.
    #[inline(always)]
    fn farthest_of(&self, other: &Self) -> f64 {
        let mut sum = 0.0;
        for dimension in 0..D {
            let below = f64::from(other.high[dimension]) - f64::from(self.low[dimension]);
            let above = f64::from(self.high[dimension]) - f64::from(other.low[dimension]);
            let reach = if below > above { below } else { above };
            sum += reach * reach;
        }
        sum
    }
}

/// Returns a bit mask of the samples in a group whose load has at least the squared distance `least` from `point`.
#[inline(always)]
fn far_lanes<const D: usize>(group: &[Lanes; D], point: &[f64; D], least: f64) -> u32 {
    let mut squares = [0.0; LANES];
    for dimension in 0..D {
        for lane in 0..LANES {
            let difference = group[dimension][lane] - point[dimension];
            squares[lane] += difference * difference;
        }
    }
    let mut bits = 0;
    for (lane, square) in squares.iter().enumerate() {
        bits |= u32::from(*square >= least) << lane;
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Axis;

    #[test]
    fn a_cancelled_search_leaves_samples_without_past_sample() {
        let loads: Vec<f64> = (0..100).map(f64::from).collect();
        let progress = Progress::default();
        progress.cancel();
        let thresholds = Thresholds { f_th: 3.0, t_th_secs: 5.0 };
        let past = LoadPath::new(&loads, &[1.0]).past_samples_until(&loads, thresholds, &progress);
        assert_eq!(past, (0..100).collect::<Vec<u32>>());
    }

    /// Applies the rule as written, one sample after another.
    fn plain_scan(times: &[f64], rows: &[Vec<f64>], thresholds: Thresholds) -> Vec<u32> {
        (0..times.len())
            .map(|k| {
                (0..=k)
                    .rev()
                    .take_while(|&j| times[k] - times[j] <= thresholds.t_th_secs)
                    .find(|&j| {
                        let square: f64 =
                            rows[k].iter().zip(&rows[j]).map(|(a, b)| (b - a) * (b - a)).sum();
                        square >= thresholds.f_th * thresholds.f_th
                    })
                    .unwrap_or(k) as u32
            })
            .collect()
    }

    /// Returns a random walk with pauses, jitter, repeated times and jumps.
    pub(super) fn walk(n: usize, dimensions: usize, seed: u64) -> (Vec<f64>, Vec<Vec<f64>>) {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let mut random = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut time = 0.0;
        let mut at = vec![0.0; dimensions];
        let (mut times, mut rows) = (Vec::new(), Vec::new());
        for _ in 0..n {
            time += if random() < 0.1 { 0.0 } else { 0.1 * random() };
            let stride = if random() < 0.02 { 5.0 } else { 0.3 };
            if random() < 0.8 {
                for value in &mut at {
                    *value = 0.99 * *value + stride * (random() - 0.5);
                }
            }
            times.push(time);
            rows.push(at.clone());
        }
        (times, rows)
    }

    fn path(rows: &[Vec<f64>], dimensions: usize) -> LoadPath {
        LoadPath::new(&rows.concat(), &vec![1.0; dimensions])
    }

    #[test]
    fn block_search_equals_the_plain_scan() {
        for dimensions in 1..=6 {
            for n in [0, 1, 7, 8, 9, 33, 700] {
                let (times, rows) = walk(n, dimensions, 7 + n as u64);
                let path = path(&rows, dimensions);
                for f_th in [0.0, 1e-9, 0.2, 1.0, 2.0, 4.0, 1e9] {
                    for t_th_secs in [0.0, 0.05, 1.0, 15.0, f64::INFINITY] {
                        let thresholds = Thresholds { f_th, t_th_secs };
                        assert_eq!(
                            path.past_samples(&times, thresholds),
                            plain_scan(&times, &rows, thresholds),
                            "{dimensions} axes, {n} samples, {thresholds:?}"
                        );
                    }
                }
            }
        }
    }

    /// Compares with the rule as written, applied to the kept samples.
    #[test]
    fn a_thinned_history_is_searched_by_the_same_rule() {
        for dimensions in [1, 3] {
            for n in [1, 8, 9, 700] {
                let (times, rows) = walk(n, dimensions, 3 + n as u64);
                for step_secs in [0.03, 0.2, 5.0] {
                    let kept = kept_samples(&times, step_secs);
                    let kept = kept.unwrap_or_else(|| (0..n as u32).collect());
                    let weights = vec![1.0; dimensions];
                    let load = |k: usize, axis: usize| rows[k][axis];
                    let path = LoadPath::with_history_step(&times, &load, &weights, step_secs);
                    for (f_th, t_th_secs) in [(0.0, 15.0), (0.2, 1.0), (2.0, 15.0), (1.0, 0.0)] {
                        let thresholds = Thresholds { f_th, t_th_secs };
                        let plain = (0..n).map(|k| {
                            let mut known: Vec<usize> = kept.iter().map(|j| *j as usize).collect();
                            known.retain(|j| *j < k);
                            known.push(k);
                            let (times, rows): (Vec<f64>, Vec<Vec<f64>>) =
                                known.iter().map(|j| (times[*j], rows[*j].clone())).unzip();
                            let past = plain_scan(&times, &rows, thresholds);
                            known[past[past.len() - 1] as usize] as u32
                        });
                        assert_eq!(
                            path.past_samples(&times, thresholds),
                            plain.collect::<Vec<_>>(),
                            "{dimensions} axes, {n} samples, {step_secs} s, {thresholds:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn zero_threshold_gives_the_sample_itself() {
        let (times, rows) = walk(100, 3, 1);
        let thresholds = Thresholds { f_th: 0.0, t_th_secs: 15.0 };
        let itself: Vec<u32> = (0..100).collect();
        assert_eq!(path(&rows, 3).past_samples(&times, thresholds), itself);
    }

    /// The load rises by 1 N per second, so the past sample is F_th seconds old once the recording is long enough.
    #[test]
    fn a_ramp_looks_back_by_the_threshold() {
        let times: Vec<f64> = (0..100).map(f64::from).collect();
        let thresholds = Thresholds { f_th: 5.0, t_th_secs: 15.0 };
        let past = LoadPath::new(&times, &[1.0]).past_samples(&times, thresholds);
        assert_eq!(past[4], 4);
        assert!((5..100).all(|k| past[k] == k as u32 - 5));
    }

    #[test]
    fn the_time_threshold_counts_seconds_not_samples() {
        let times = [0.0, 10.0, 10.1, 10.2];
        let loads = [5.0, 0.0, 0.0, 0.0];
        let past = |t_th_secs| {
            let thresholds = Thresholds { f_th: 3.0, t_th_secs };
            LoadPath::new(&loads, &[1.0]).past_samples(&times, thresholds)
        };
        assert_eq!(past(10.1), [0, 0, 0, 3]);
        assert_eq!(past(9.0), [0, 1, 2, 3]);
    }

    #[test]
    fn forces_count_in_newtons_and_moments_only_over_full_scale() {
        let axes = [Axis::Fz, Axis::Mx];
        let scale = [10.0, 0.5];
        assert_eq!(Distance::Force.weights(&axes, &scale), [1.0, 0.0]);
        assert_eq!(Distance::FullScale.weights(&axes, &scale), [0.1, 2.0]);
        assert_eq!(Distance::Force.weights(&axes[1..], &scale[1..]), [2.0]);
    }
}
