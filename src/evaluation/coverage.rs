//! What loads the recordings hold: how far each axis moves, what the test asks beyond it, how many load cases there are.

use std::collections::HashSet;

use crate::recording::{Axis, Entry, Recording, Role};

/// A load is another one where an axis has moved by this share of its range: noise moves it by less, mostly.
const OTHER_LOAD: f64 = 0.02;
/// Loads that differ by less than this share of each axis' range are one load that comes again.
const SAME_LOAD: f64 = 0.01;
/// Test loads are outside where they lie further out than this share of what the axes of one unit span.
const OUTSIDE: f64 = 0.02;

/// What the loads of recordings span.
///
/// **Shapes** one entry per axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// The least and the greatest training load.
    pub trained: Vec<(f64, f64)>,
    /// What the test recordings ask beyond it; `None` where they do not, or there are none.
    pub outside: Vec<Option<Outside>>,
    /// How often the load becomes another one in the training recordings, the first of each counted.
    pub n_moves: usize,
    /// How many different loads there are among them.
    pub n_different: usize,
}

/// Test loads on one axis that no training recording holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outside {
    /// The share of the test samples.
    pub share: f64,
    /// How far the farthest lies beyond the range.
    pub farthest: f64,
}

impl Coverage {
    /// Of recordings with these axes.
    pub fn of(entries: &[Entry], axes: &[Axis]) -> Self {
        let recordings = |role: Role| {
            let entries = entries.iter().filter(move |entry| entry.role == role);
            entries.map(|entry| &*entry.recording)
        };
        let trained = ranges(recordings(Role::Train), axes.len());
        let tested = ranges(recordings(Role::Test), axes.len());
        let spans: Vec<f64> = (trained.iter().zip(&tested))
            .map(|(a, b)| a.1.max(b.1) - a.0.min(b.0))
            .collect();
        let outside = (0..axes.len()).map(|axis| {
            let slack = OUTSIDE * largest(axes, &spans, axes[axis]);
            outside(recordings(Role::Test), axis, trained[axis], slack)
        });
        let (n_moves, n_different) = load_cases(recordings(Role::Train), &trained);
        Self {
            outside: outside.collect(),
            trained,
            n_moves,
            n_different,
        }
    }

    /// How far an axis moves in the training recordings.
    pub fn span(&self, axis: usize) -> f64 {
        let (low, high) = self.trained[axis];
        (high - low).max(0.0)
    }
}

/// The most that an axis of this one's unit spans.
pub fn largest(axes: &[Axis], spans: &[f64], of: Axis) -> f64 {
    let all = axes.iter().zip(spans);
    let of_unit = all.filter(|(axis, _)| axis.is_force() == of.is_force());
    of_unit.map(|(_, span)| *span).fold(0.0, f64::max)
}

fn ranges<'a>(recordings: impl Iterator<Item = &'a Recording>, n_axes: usize) -> Vec<(f64, f64)> {
    let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); n_axes];
    for recording in recordings {
        for load in recording.loads().chunks_exact(n_axes.max(1)) {
            for (range, value) in ranges.iter_mut().zip(load) {
                *range = (range.0.min(*value), range.1.max(*value));
            }
        }
    }
    ranges
}

fn outside<'a>(
    recordings: impl Iterator<Item = &'a Recording>,
    axis: usize,
    (low, high): (f64, f64),
    slack: f64,
) -> Option<Outside> {
    let (mut n, mut n_outside, mut farthest) = (0_u64, 0_u64, 0.0_f64);
    for recording in recordings {
        let n_axes = recording.axes().len().max(1);
        for value in recording.loads().iter().skip(axis).step_by(n_axes) {
            let beyond = (value - high).max(low - value);
            n += 1;
            n_outside += u64::from(beyond > slack);
            farthest = farthest.max(beyond);
        }
    }
    (n_outside > 0).then(|| Outside {
        share: n_outside as f64 / n as f64,
        farthest,
    })
}

/// How often the load becomes another one, and how many different ones there are.
fn load_cases<'a>(
    recordings: impl Iterator<Item = &'a Recording>,
    ranges: &[(f64, f64)],
) -> (usize, usize) {
    let spans: Vec<f64> = ranges.iter().map(|(low, high)| high - low).collect();
    let moving: Vec<usize> = (0..spans.len()).filter(|&axis| spans[axis] > 0.0).collect();
    let (mut n_moves, mut different) = (0, HashSet::new());
    for recording in recordings {
        let mut last: Option<&[f64]> = None;
        for load in recording.loads().chunks_exact(spans.len().max(1)) {
            let is_other = last.is_none_or(|last| {
                let far =
                    |&axis: &usize| (load[axis] - last[axis]).abs() > OTHER_LOAD * spans[axis];
                moving.iter().any(far)
            });
            if is_other {
                last = Some(load);
                n_moves += 1;
                let cell = |&axis: &usize| {
                    ((load[axis] - ranges[axis].0) / (SAME_LOAD * spans[axis])).round() as u8
                };
                different.insert(moving.iter().map(cell).collect::<Vec<u8>>());
            }
        }
    }
    (n_moves, different.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Source;

    fn entry(role: Role, loads: Vec<f64>) -> Entry {
        let n = loads.len() / 2;
        let recording = Recording::new(
            "r",
            Source::Simulated,
            (0..n).map(|k| k as f64).collect(),
            vec!["S1".to_owned()],
            vec![0.0; n],
            vec![Axis::Fx, Axis::Fz],
            loads,
        );
        Entry::new(recording.unwrap(), role)
    }

    fn of(train: Vec<f64>, test: Vec<f64>) -> Coverage {
        let entries = [entry(Role::Train, train), entry(Role::Test, test)];
        Coverage::of(&entries, &[Axis::Fx, Axis::Fz])
    }

    #[test]
    fn test_loads_outside_count_and_noise_at_the_edge_does_not() {
        let found = of(
            vec![0.0, 0.0, 0.1, 10.0],
            vec![0.15, 10.1, 0.0, 14.0, 0.0, 1.0, 0.0, -2.0],
        );
        assert_eq!(found.trained, [(0.0, 0.1), (0.0, 10.0)]);
        let fz = Outside {
            share: 0.5,
            farthest: 4.0,
        };
        assert_eq!(found.outside, [None, Some(fz)]);
    }

    #[test]
    fn an_axis_that_stood_still_in_training_is_outside_where_the_test_moves_it() {
        let found = of(vec![5.0, 0.0, 5.0, 10.0], vec![8.0, 0.0]);
        assert_eq!(
            (found.span(0), found.outside[0]),
            (
                0.0,
                Some(Outside {
                    share: 1.0,
                    farthest: 3.0
                })
            )
        );
    }

    /// Three loads, the first twice, each held for four samples with noise of a hundredth of the range.
    #[test]
    fn held_loads_are_counted_once_and_again_when_they_come_back() {
        let held = [0.0, 4.0, 9.9, 0.0].into_iter();
        let noisy = held.flat_map(|load| [0.0, 0.1, 0.0, 0.05].map(|noise| [1.0, load + noise]));
        let found = of(noisy.flatten().collect(), vec![1.0, 1.0]);
        assert_eq!((found.n_moves, found.n_different), (4, 3));
    }
}
