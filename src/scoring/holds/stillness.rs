//! Finds the dwells, the intervals in which the load is constant.
//!
//! Guarantees: dwells are sorted and do not overlap. In a dwell, no axis spans more than its band. They are found in one pass
//! over the samples.

use std::collections::VecDeque;
use std::ops::Range;

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
    use super::*;

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
