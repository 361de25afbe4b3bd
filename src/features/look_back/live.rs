//! Look-back (search for the past sample) of a running sensor, which processes one sample at a time.
//!
//! Guarantees: the past sample is the one that [`LoadPath`](super::LoadPath) finds in the whole recording. Memory holds at
//! most twice the samples within the longest time threshold t_th. The computing time per sample grows with the logarithm of
//! this number, unless load differences stay near the force threshold F_th.

use super::thresholds::{Thresholds, measured};
use crate::features::kept::Kept;

/// Number of samples in the smallest bounding box of loads, and number of these boxes in the next larger box.
const FAN_OUT: usize = 16;
/// Number of samples in the largest bounding box of loads. Old samples are dropped in whole boxes, so that the boxes of the
/// kept samples stay valid.
const LARGEST: usize = FAN_OUT * FAN_OUT;

/// Recent samples of a running sensor, among which the look-back searches the past sample.
#[derive(Clone, Debug)]
pub struct LiveLookBack {
    /// Index and weight of each load axis whose weight in the load difference is not zero.
    used: Vec<(usize, f64)>,
    longest_secs: f64,
    n_gauges: usize,
    times: Vec<f64>,
    gauges: Vec<f64>,
    /// Conventional loads, each axis in `used` multiplied by its weight: one row for each sample.
    points: Vec<f64>,
    /// Bounding boxes of the loads of each `FAN_OUT` and of each `LARGEST` samples: minimum and maximum of each axis.
    boxes: [Vec<f64>; 2],
    kept: Kept,
}

impl LiveLookBack {
    /// Creates the memory before the first sample. `weights` holds the weight of each axis in the load difference. Later
    /// searches must have a time threshold t_th ≤ `longest_secs`. Of samples closer together in time than `step_secs`, only
    /// the first is kept.
    pub fn new(weights: &[f64], longest_secs: f64, n_gauges: usize, step_secs: f64) -> Self {
        Self {
            used: measured(weights),
            longest_secs,
            n_gauges,
            times: Vec::new(),
            gauges: Vec::new(),
            points: Vec::new(),
            boxes: [Vec::new(), Vec::new()],
            kept: Kept::new(step_secs),
        }
    }

    pub fn push(&mut self, time: f64, gauges: &[f64], load: &[f64]) {
        let width = self.used.len();
        if self.kept.newest {
            self.forget(time);
        } else {
            // The bounding boxes still include the dropped sample, so they may be slightly too large, which changes no
            // result.
            self.times.pop();
            self.gauges.truncate(self.gauges.len() - self.n_gauges);
            self.points.truncate(self.points.len() - width);
        }
        self.kept.take(time);
        let at = self.times.len();
        self.times.push(time);
        self.gauges.extend(gauges);
        for (axis, weight) in &self.used {
            self.points.push(load[*axis] * weight);
        }
        let point = &self.points[at * width..];
        for (boxes, size) in self.boxes.iter_mut().zip([FAN_OUT, LARGEST]) {
            if boxes.len() == at / size * 2 * width {
                boxes.extend(point.iter().flat_map(|value| [*value, *value]));
            } else {
                let last = boxes.len() - 2 * width;
                for (bounds, value) in boxes[last..].chunks_exact_mut(2).zip(point) {
                    bounds[0] = bounds[0].min(*value);
                    bounds[1] = bounds[1].max(*value);
                }
            }
        }
    }

    /// Returns the gauges of the past sample that belongs to the newest sample, or the newest gauges if there is no past
    /// sample. Panics before the first sample.
    pub fn past_gauges(&self, thresholds: Thresholds) -> &[f64] {
        let newest = self.times.len() - 1;
        let found = self.find(newest, thresholds).unwrap_or(newest);
        &self.gauges[found * self.n_gauges..][..self.n_gauges]
    }

    fn find(&self, newest: usize, thresholds: Thresholds) -> Option<usize> {
        let least = thresholds.f_th * thresholds.f_th;
        let width = self.used.len();
        let point = &self.points[newest * width..][..width];
        let is_young =
            |sample: usize| self.times[newest] - self.times[sample] <= thresholds.t_th_secs;
        let mut end = newest + 1;
        while end > 0 && is_young(end - 1) {
            let skipped = [(1, LARGEST), (0, FAN_OUT)].into_iter().find(|&(level, size)| {
                end.is_multiple_of(size) && {
                    let bounds = &self.boxes[level][(end / size - 1) * 2 * width..][..2 * width];
                    farthest(bounds, point) < least
                }
            });
            if let Some((_, size)) = skipped {
                end -= size;
                continue;
            }
            end -= 1;
            if distance(&self.points[end * width..][..width], point) >= least {
                return Some(end);
            }
        }
        None
    }

    /// Drops the older half of the samples if all samples of this half are older than the longest time threshold t_th.
    fn forget(&mut self, now: f64) {
        let old = |sample: usize| now - self.times[sample] > self.longest_secs;
        let half = self.times.len() / 2 / LARGEST * LARGEST;
        if half == 0 || !old(half - 1) {
            return;
        }
        let width = self.used.len();
        self.times.drain(..half);
        self.gauges.drain(..half * self.n_gauges);
        self.points.drain(..half * width);
        for (boxes, size) in self.boxes.iter_mut().zip([FAN_OUT, LARGEST]) {
            boxes.drain(..half / size * 2 * width);
        }
    }
}

/// Returns the squared distance between two loads. The sum is rounded in the same order as in the search in whole recordings,
/// so that both find the same sample.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + (a - b) * (a - b))
}

/// Returns the squared distance from a load to the farthest corner of a bounding box. Rounding is monotone, so no sample in
/// the box is farther away.
fn farthest(bounds: &[f64], point: &[f64]) -> f64 {
    bounds.chunks_exact(2).zip(point).fold(0.0, |sum, (bounds, at)| {
        let reach = (at - bounds[0]).max(bounds[1] - at);
        sum + reach * reach
    })
}

#[cfg(test)]
mod tests {
    use super::super::LoadPath;
    use super::super::tests::walk;
    use super::*;

    #[test]
    fn the_live_search_finds_the_same_sample() {
        for dimensions in [1, 3] {
            let (times, rows) = walk(3000, dimensions, 5);
            for (f_th, t_th_secs, step_secs) in [
                (0.0, 15.0, 0.0),
                (0.7, 2.0, 0.0),
                (2.0, 15.0, 0.0),
                (1e9, 1.0, 0.0),
                (1.0, 0.0, 0.0),
                (0.7, 2.0, 0.12),
                (2.0, 15.0, 0.3),
                (0.0, 15.0, 0.3),
            ] {
                let weights = vec![1.0; dimensions];
                let load = |k: usize, axis: usize| rows[k][axis];
                let path = LoadPath::with_history_step(&times, &load, &weights, step_secs);
                let thresholds = Thresholds { f_th, t_th_secs };
                let past = path.past_samples(&times, thresholds);
                let mut live = LiveLookBack::new(&vec![1.0; dimensions], t_th_secs, 1, step_secs);
                for (k, row) in rows.iter().enumerate() {
                    live.push(times[k], &[k as f64], row);
                    let found = live.past_gauges(thresholds)[0] as u32;
                    assert_eq!(found, past[k], "{thresholds:?}, sample {k}");
                }
            }
        }
    }

    /// Two seconds at 100 Hz are 200 samples. At most twice this number is kept, rounded up to whole boxes.
    #[test]
    fn memory_is_bounded_by_the_window() {
        let mut live = LiveLookBack::new(&[1.0], 2.0, 1, 0.0);
        for k in 0..20_000 {
            live.push(f64::from(k) * 0.01, &[0.0], &[0.0]);
            assert!(live.times.len() <= 400 + 2 * LARGEST, "{}", live.times.len());
        }
    }
}
