//! Hysteresis loops: reversals of a load, the branches between them, and the distance of two branches at equal load.
//!
//! A loop shows an output over the reference load of one axis. The output is a raw gauge, the conventional or the compensated
//! load, or the error of one of these loads. Reversals depend on the reference load alone, so all outputs are compared on the
//! same cycles.
//!
//! * A **reversal** is an extreme from which the load turns back by more than the reversal threshold
//!   ([`default_reversal_threshold`] unless the user sets one). The intervals between reversals are **branches**, rising and
//!   falling in turn. Each branch lies within one recording.
//! * **Cycles** are counted by rainflow (ASTM E1049). A small cycle within a large one counts separately, and is removed from
//!   the large one. So the reversal threshold sets the size of the smallest cycle, and hardly changes large cycles. A half
//!   cycle that counting leaves over forms a cycle with at most one neighbouring half cycle.
//! * The **largest cycle** is the one whose two branches share the widest range of loads.
//! * **Full cycles** cover at least [`FULL_SHARE`] of the largest cycle's range. The **mean loop** is the mean of their loops,
//!   over the loads that all of them cover. The mean loop exists if at least [`FEWEST_CYCLES`] cycles are full and share more
//!   than [`MOST`] of the range of all loads.
//! * Branches are compared at 101 loads over their common range. Each branch is averaged over hundredths of its load range
//!   ([`Curve`]).

mod cycle;
mod outline;
mod turns;

use crate::{min_max::MinMax, scoring::loops::turns::Counted};

pub use cycle::Loop;
pub(crate) use cycle::{Curve, Cycle, quiet};
pub use outline::{Density, Frame, Outline, outline};
pub(crate) use outline::{Stroke, inside};
pub(crate) use turns::{Branch, NOISE_FACTOR};
pub use turns::{LoadExtent, branches, default_reversal_threshold, extents_of, extents_of_set};

/// Minimum share of the largest cycle's range that a full cycle covers.
pub const FULL_SHARE: f64 = 0.8;
/// Minimum number of full cycles for a mean loop.
pub const FEWEST_CYCLES: usize = 3;
/// Share of the range of all loads, of which the full cycles must have more than this in common for a mean loop.
pub const MOST: f64 = 0.5;

/// Branches and cycles of the load on one axis in several recordings.
#[derive(Debug)]
pub struct Loops {
    branches: Vec<Vec<Branch>>,
    /// Cycles sorted by recording and time. Each half cycle belongs to at most one cycle.
    cycles: Vec<Cycle>,
    /// Half cycles that rainflow counting leaves over, for each recording in the order of time.
    residue: Vec<Vec<Branch>>,
}

/// Reason why there is no mean loop: too few full cycles, or too small a load range that they have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooFew {
    /// Number of full cycles.
    pub count: usize,
    /// Range of loads that is covered by every full cycle, as a share of the range of all loads.
    pub share: f64,
}

impl Loops {
    /// Splits the load of each recording at its reversals, and counts the cycles of the load.
    pub fn of<'a>(
        recordings: impl IntoIterator<Item = &'a [f64]>,
        reversal_threshold: f64,
    ) -> Self {
        let mut loops = Self { branches: Vec::new(), cycles: Vec::new(), residue: Vec::new() };
        for (recording, loads) in recordings.into_iter().enumerate() {
            let branches = branches(loads, reversal_threshold);
            let Counted { closed, residue } = turns::count(branches.clone(), loads);
            let cycle = |first: &Branch, second: &Branch| Cycle {
                recording,
                first: first.clone(),
                second: second.clone(),
            };
            let closed = closed.iter().map(|[first, second]| cycle(first, second));
            let pairs = turns::pairs(&residue).into_iter();
            let pairs = pairs.map(|at| cycle(&residue[at], &residue[at + 1]));
            let mut cycles: Vec<Cycle> = closed.chain(pairs).collect();
            cycles.sort_by_key(|cycle| cycle.first.samples.start);
            loops.cycles.extend(cycles);
            loops.branches.push(branches);
            loops.residue.push(residue);
        }
        loops
    }

    /// Returns the branches of each recording between neighbouring reversals, in the order of time.
    pub fn branches(&self) -> &[Vec<Branch>] {
        &self.branches
    }

    /// Returns all cycles, sorted by recording and by their first sample.
    pub fn cycles(&self) -> &[Cycle] {
        &self.cycles
    }

    /// Returns the cycle whose branches share the widest range of loads. Of several equal cycles, it is the first.
    pub fn largest(&self) -> Option<Cycle> {
        self.largest_cycles().into_iter().next()
    }

    /// Returns the cycles whose branches share the widest range of loads and which begin in the direction of the first of them,
    /// in the order of recordings and time. So in a table of weights, a falling branch belongs to the rising branch before it.
    pub fn largest_cycles(&self) -> Vec<Cycle> {
        let halves = self.residue.iter().enumerate();
        let neighbours = halves.flat_map(|(recording, residue)| {
            residue.windows(2).map(move |pair| Cycle {
                recording,
                first: pair[0].clone(),
                second: pair[1].clone(),
            })
        });
        let mut all: Vec<Cycle> = self.cycles.iter().cloned().chain(neighbours).collect();
        let widest = all.iter().map(Cycle::span).fold(0.0, f64::max);
        all.retain(|cycle| cycle.span() == widest);
        all.sort_by_key(|cycle| (cycle.recording, cycle.first.samples.start));
        all.dedup();
        let begins_rising = all.first().is_some_and(|first| first.first.rising);
        all.retain(|cycle| cycle.first.rising == begins_rising);
        all
    }

    /// Returns the cycles that cover at least [`FULL_SHARE`] of the largest cycle's range.
    pub fn full_cycles(&self) -> Vec<Cycle> {
        let Some(largest) = self.largest() else {
            return Vec::new();
        };
        let full = self.cycles.iter();
        full.filter(|cycle| covers(cycle.loads(), largest.loads())).cloned().collect()
    }

    /// Returns the full cycles if they are enough for a mean loop. `range` is the minimum and maximum of all loads. The error
    /// is [`TooFew`] if fewer than [`FEWEST_CYCLES`] cycles are full, or if they share no more than [`MOST`] of `range`.
    pub fn mean_cycles(&self, range: MinMax) -> Result<Vec<Cycle>, TooFew> {
        let full = self.full_cycles();
        let count = full.len();
        let share = if count == 0 { 0.0 } else { common_loads(&full).share_of(range) };
        if count >= FEWEST_CYCLES && share > MOST { Ok(full) } else { Err(TooFew { count, share }) }
    }

    /// Returns the rising half cycle with the widest range of loads, and the index of its recording.
    pub fn widest_rising(&self) -> Option<(usize, &Branch)> {
        let halves = self.residue.iter().enumerate();
        let rising = halves.flat_map(|(recording, halves)| {
            halves.iter().filter(|half| half.rising).map(move |half| (recording, half))
        });
        rising.reduce(|widest, other| if other.1.span() > widest.1.span() { other } else { widest })
    }
}

/// Returns the range of loads that all of these cycles cover.
pub(crate) fn common_loads(cycles: &[Cycle]) -> MinMax {
    MinMax::common(cycles.iter().map(Cycle::loads))
}

/// Returns true if the range `range` covers at least [`FULL_SHARE`] of the range `whole`.
fn covers(range: MinMax, whole: MinMax) -> bool {
    MinMax::common([range, whole].into_iter()).span() >= FULL_SHARE * whole.span()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: [f64; 4] = [0.0, 2.0, 1.0, 3.0];
    const LARGE: [f64; 5] = [0.0, 9.0, -1.0, 10.0, 1.0];

    #[test]
    fn the_largest_cycle_has_the_widest_common_range() {
        let loops = Loops::of([&SMALL[..], &LARGE], 0.5);
        let largest = loops.largest().unwrap();
        assert_eq!((largest.recording, largest.loads().ends()), (1, Some((-1.0, 9.0))));
        assert!(!largest.first.rising);
        assert_eq!(largest.rising().samples, 2..4);
        assert_eq!(largest.falling().samples, 1..3);
    }

    /// SMALL has one closed cycle, 2 to 1 and back, and a leftover half cycle. LARGE leaves four halves. They pair as 0..9
    /// and 1..10, although the second and the third make the largest cycle: each of the two pairs covers 8 of its 10.
    #[test]
    fn full_cycles_cover_four_fifths_of_the_largest() {
        let loops = Loops::of([&SMALL[..], &LARGE], 0.5);
        let spans: Vec<f64> = loops.cycles().iter().map(Cycle::span).collect();
        assert_eq!(spans, [1.0, 9.0, 9.0]);
        let elsewhere = Loops::of([&LARGE[..], &[20.0, 29.0, 20.0]], 0.5);
        assert_eq!(elsewhere.full_cycles().len(), 2);
        assert_eq!(loops.full_cycles().len(), 2);
        assert_eq!(loops.widest_rising().unwrap().1.span(), 11.0);
    }

    #[test]
    fn a_mean_loop_needs_three_cycles_over_most_of_the_loads() {
        let repeated: Vec<f64> = [0.0, 9.0].repeat(3).into_iter().chain([0.0]).collect();
        let loops = Loops::of([&repeated[..]], 0.5);
        assert_eq!(loops.mean_cycles(MinMax { min: 0.0, max: 9.0 }).unwrap().len(), 3);
        let narrow = loops.mean_cycles(MinMax { min: -9.0, max: 9.0 }).unwrap_err();
        assert_eq!((narrow.count, narrow.share), (3, 0.5));
        let twice = Loops::of([&repeated[..5]], 0.5);
        assert_eq!(twice.mean_cycles(MinMax { min: 0.0, max: 9.0 }).unwrap_err().count, 2);
        let none = Loops::of([&[0.0, 9.0][..]], 0.5);
        let expected = TooFew { count: 0, share: 0.0 };
        assert_eq!(none.mean_cycles(MinMax { min: 0.0, max: 9.0 }), Err(expected));
    }

    /// Five large cycles with noise: any reversal threshold gives the same number and width of large cycles.
    #[test]
    fn the_reversal_threshold_hardly_touches_the_large_cycles() {
        let noise = |k: usize| ((k * 7919) % 104_729) as f64 / 104_729.0 - 0.5;
        let loads: Vec<f64> = (0..10_000)
            .map(|k| {
                -10.0 * (k as f64 * std::f64::consts::TAU / 2000.0).cos()
                    + noise(k * k)
                    + noise(k / 50)
            })
            .collect();
        for reversal_threshold in [0.0, 0.1, 0.5, 1.0, 3.0, 8.0] {
            let loops = Loops::of([&loads[..]], reversal_threshold);
            assert_eq!(loops.full_cycles().len(), 5, "{reversal_threshold}");
            assert!(loops.largest().unwrap().span() > 19.5);
        }
    }

    #[test]
    fn branches_do_not_cross_from_one_recording_into_another() {
        let (up, down) = ([0.0, 5.0], [5.0, 0.0]);
        let loops = Loops::of([&up[..], &down], 0.5);
        assert_eq!(loops.branches().len(), 2);
        assert_eq!(loops.largest(), None);
        assert!(loops.full_cycles().is_empty());
    }
}
