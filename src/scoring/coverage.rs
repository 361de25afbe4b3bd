//! Loads that the recordings cover: range of each axis, test loads outside the training range, and number of different loads.

use std::collections::HashMap;

use crate::{
    column::column,
    features::{Column, MAX_COLUMNS},
    min_max::MinMax,
    recording::{Axis, Entry, Recording, Role, SAME_LOAD_SHARE, load_ranges},
    scoring::loops::extents_of,
};

/// Minimum difference of two loads on an axis at which they count as different, as a share of the axis' training range.
const OTHER_LOAD: f64 = 0.02;
/// The same minimum difference, in standard deviations of the load's noise. The larger of the two limits is used.
const NOISE_OF_LOAD: f64 = 4.0;
/// Upper bound of the limit by [`NOISE_OF_LOAD`], as a share of the axis' training range. It is needed because loads that
/// change in jumps look like large noise.
const OTHER_LOAD_AT_MOST: f64 = 0.05;
/// Distance from the training range at which a test load counts as outside, as a share of the largest training range of all
/// axes with the same unit.
const OUTSIDE: f64 = 0.02;
/// Share of test samples outside the training range above which a finding is reported.
pub const OUTSIDE_SHARE: f64 = 0.05;

/// Number of different loads at which the count stops. A model has at most [`MAX_COLUMNS`] coefficients per axis, and twice
/// this number of loads determines it, so a larger count would change no finding.
const MAX_CASES: usize = 2 * MAX_COLUMNS;

/// Loads that the training and test recordings cover.
#[derive(Debug)]
pub struct Coverage {
    pub trained: Vec<MinMax>,
    pub outside: Vec<Option<Outside>>,
    /// Number of changes to a different load in the training recordings; each recording's first load counts as a change.
    pub n_moves: usize,
    pub cases: LoadCases,
}

/// Test loads of one axis outside the range of its training loads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outside {
    /// Share of the test samples whose load is outside.
    pub share: f64,
    /// Largest distance of a test load from the training range, in the unit of the axis.
    pub farthest: f64,
}

impl Coverage {
    pub fn of(entries: &[Entry], axes: &[Axis]) -> Self {
        let recordings = |role: Role| {
            let entries = entries.iter().filter(move |entry| entry.role == role);
            entries.map(|entry| &*entry.recording)
        };
        let trained = load_ranges(recordings(Role::Train), axes.len());
        let tested = load_ranges(recordings(Role::Test), axes.len());
        let spans: Vec<f64> =
            (trained.iter().zip(&tested)).map(|(a, b)| a.joined(*b).span()).collect();
        let outside = (0..axes.len()).map(|axis| {
            let slack = OUTSIDE * largest(axes, &spans, axes[axis]);
            outside(recordings(Role::Test), axis, trained[axis], slack)
        });
        let training: Vec<&Recording> = recordings(Role::Train).collect();
        let (n_moves, cases) = LoadCases::of(&training, axes, &trained);
        Self { outside: outside.collect(), trained, n_moves, cases }
    }

    /// Returns the number of independent load points that determine the coefficients of these columns. If a column holds
    /// earlier gauge readings, every change of the load counts, otherwise every different load. The second value is true if
    /// the count stopped, so that there may be more.
    pub fn n_cases(&self, columns: &[Column]) -> (usize, bool) {
        let is_past = |column: &Column| matches!(column, Column::Past { .. });
        if columns.iter().any(is_past) {
            (self.n_moves, false)
        } else {
            (self.cases.len(), self.cases.is_full())
        }
    }

    pub fn span(&self, axis: usize) -> f64 {
        self.trained[axis].span()
    }
}

/// Returns the largest of the spans whose axes have the same unit as axis `of`.
pub fn largest(axes: &[Axis], spans: &[f64], of: Axis) -> f64 {
    let all = axes.iter().zip(spans);
    let of_unit = all.filter(|(axis, _)| axis.is_force() == of.is_force());
    of_unit.map(|(_, span)| *span).fold(0.0, f64::max)
}

fn outside<'a>(
    recordings: impl Iterator<Item = &'a Recording>,
    axis: usize,
    range: MinMax,
    slack: f64,
) -> Option<Outside> {
    let (mut n, mut n_outside, mut farthest) = (0_u64, 0_u64, 0.0_f64);
    for recording in recordings {
        for value in column(recording.loads(), recording.axes().len(), axis) {
            let beyond = (value - range.max).max(range.min - value);
            n += 1;
            n_outside += u64::from(beyond > slack);
            farthest = farthest.max(beyond);
        }
    }
    (n_outside > 0).then(|| Outside { share: n_outside as f64 / n as f64, farthest })
}

/// The first [`MAX_CASES`] different loads of recordings. Two loads differ if they differ by more than the tolerance on any
/// axis.
#[derive(Debug, Default)]
pub struct LoadCases {
    /// Difference of loads that is tolerated on each axis, in its unit; infinite for an axis whose load never changes.
    tolerances: Vec<f64>,
    /// Loads that differ from each other, `n × n_axes` row-major.
    loads: Vec<f64>,
    /// Indices of the loads in each cell of a grid, for a fast search. The cell is the load divided by the tolerance, on the
    /// first two axes that move.
    cells: HashMap<[i64; 2], Vec<u32>>,
}

impl LoadCases {
    /// Returns the number of changes to a different load, where each recording's first load counts, and the different loads.
    fn of(recordings: &[&Recording], axes: &[Axis], ranges: &[MinMax]) -> (usize, Self) {
        let extents = extents_of(recordings.iter().copied(), axes);
        let are_tables = recordings.iter().all(|recording| recording.is_table());
        let least = if are_tables { SAME_LOAD_SHARE } else { OTHER_LOAD };
        let tolerances = ranges.iter().zip(&extents).map(|(range, extent)| {
            let span = range.span();
            let by_noise = (NOISE_OF_LOAD * extent.noise).min(OTHER_LOAD_AT_MOST * span);
            if span > 0.0 { by_noise.max(least * span) } else { f64::INFINITY }
        });
        let mut cases = Self { tolerances: tolerances.collect(), ..Self::default() };
        let mut n_moves = 0;
        for recording in recordings {
            let mut last: Option<&[f64]> = None;
            for load in recording.loads().chunks_exact(axes.len().max(1)) {
                if last.is_none_or(|last| cases.distance(load, last) > 1.0) {
                    last = Some(load);
                    n_moves += 1;
                    cases.take(load);
                }
            }
        }
        (n_moves, cases)
    }

    pub fn len(&self) -> usize {
        self.loads.len() / self.tolerances.len().max(1)
    }

    fn is_full(&self) -> bool {
        self.len() >= MAX_CASES
    }

    /// Returns the largest difference of two loads on any axis, divided by the tolerance of the axis.
    fn distance(&self, one: &[f64], other: &[f64]) -> f64 {
        let axes = one.iter().zip(other).zip(&self.tolerances);
        let shares = axes.map(|((one, other), tolerance)| (one - other).abs() / tolerance);
        shares.fold(0.0, f64::max)
    }

    fn cell(&self, load: &[f64]) -> [i64; 2] {
        let mut axes = load.iter().zip(&self.tolerances);
        let mut moving = || axes.by_ref().find(|(_, tolerance)| tolerance.is_finite());
        [(); 2].map(|()| moving().map_or(0, |(load, tolerance)| (load / tolerance).floor() as i64))
    }

    /// Adds a load to the different loads if it differs from all of them and the list is not full.
    fn take(&mut self, load: &[f64]) {
        if self.is_full() {
            return;
        }
        let [a, b] = self.cell(load);
        let case = |at: u32| {
            let n_axes = load.len();
            &self.loads[at as usize * n_axes..][..n_axes]
        };
        let around = [-1, 0, 1].map(|step| a.saturating_add(step)).into_iter();
        let around = around.flat_map(|a| [-1, 0, 1].map(|step| [a, b.saturating_add(step)]));
        let mut near = around.filter_map(|cell| self.cells.get(&cell)).flatten();
        if !near.any(|at| self.distance(load, case(*at)) <= 1.0) {
            let at = self.len() as u32;
            self.loads.extend_from_slice(load);
            self.cells.entry([a, b]).or_default().push(at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Source;

    /// Twenty poses, repeated three times with noise, and two more: one differs from the first by 1.5 % of the range, the
    /// other by a fifth. Poses that jump from row to row look like noise, so the tolerance is 5 %.
    #[test]
    fn poses_that_repeat_within_the_noise_are_one_load_case() {
        let pose = |k: usize| [10.0 * (k as f64).sin(), 7.0 * (1.7 * k as f64).cos()];
        let mut loads: Vec<[f64; 2]> = (0..60)
            .map(|k| {
                let [a, b] = pose(k % 20);
                let noise = 0.02 * ((k * 37 % 11) as f64 / 5.0 - 1.0);
                [a + noise, b - noise]
            })
            .collect();
        let [a, b] = pose(0);
        loads.extend([[a + 0.3, b], [a - 3.0, b - 3.0]]);
        let cases = of(loads.concat(), vec![0.0; 2]).cases;
        assert_eq!(cases.len(), 20, "the two last differ from a pose by less than the tolerance");
    }

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

    /// Each load differs from all others, in two axes that sweep a grid of 50 × 50 cells row by row.
    #[test]
    fn the_count_of_different_loads_stops() {
        let loads = (0..2500).flat_map(|k| [f64::from(k % 50), f64::from(k / 50)]);
        let found = of(loads.collect(), vec![0.0; 2]);
        assert_eq!((found.cases.len(), found.n_moves), (MAX_CASES, 2500));
        assert_eq!(found.n_cases(&[]), (MAX_CASES, true));
        assert_eq!(of(vec![0.0, 0.0, 1.0, 1.0], vec![0.0; 2]).n_cases(&[]), (2, false));
    }

    #[test]
    fn test_loads_outside_count_and_noise_at_the_edge_does_not() {
        let found = of(vec![0.0, 0.0, 0.1, 10.0], vec![0.15, 10.1, 0.0, 14.0, 0.0, 1.0, 0.0, -2.0]);
        assert_eq!(found.trained.iter().map(|range| range.max).collect::<Vec<_>>(), [0.1, 10.0]);
        let fz = Outside { share: 0.5, farthest: 4.0 };
        assert_eq!(found.outside, [None, Some(fz)]);
    }

    #[test]
    fn an_axis_that_stood_still_in_training_is_outside_where_the_test_moves_it() {
        let found = of(vec![5.0, 0.0, 5.0, 10.0], vec![8.0, 0.0]);
        assert_eq!(
            (found.span(0), found.outside[0]),
            (0.0, Some(Outside { share: 1.0, farthest: 3.0 }))
        );
    }

    /// Four dwells at three loads (the first load comes twice), each of four samples with noise of 1 % of the range.
    #[test]
    fn a_dwell_is_one_case_and_a_repeated_load_is_one_more_change() {
        let held = [0.0, 4.0, 9.9, 0.0].into_iter();
        let noisy = held.flat_map(|load| [0.0, 0.1, 0.0, 0.05].map(|noise| [1.0, load + noise]));
        let found = of(noisy.flatten().collect(), vec![1.0, 1.0]);
        assert_eq!((found.n_moves, found.cases.len()), (4, 3));
    }
}
