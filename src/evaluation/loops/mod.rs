//! Hysteresis loops: where a load turns, the branches between the turns, and how far apart they lie at equal load.
//!
//! One axis at a time: its reference load goes across, and any output of the sensor up (a raw gauge, the conventional or
//! the compensated load, an error). Reversals depend on the load alone, so all outputs are compared on the same cycles.
//!
//! * A **reversal** is an extreme from which the load comes back by more than a dead band ([`default_dead_band`] where
//!   nobody has chosen one). Between reversals lie **branches**, rising and falling by turns; two neighbouring ones are a
//!   **cycle**. History never crosses from one recording into another, and neither does a branch.
//! * The **largest cycle** is the one whose two branches share the widest range of loads. Figures of "one cycle" are its.
//! * **Full cycles** are those that cover at least [`FULL_SHARE`] of the largest one's range; the **mean loop** is their mean
//!   over the loads that all of them have.
//! * A loop is compared at 101 loads over its common range, on averages over hundredths of each branch ([`Curve`]).

mod curve;
mod cycle;
mod outline;
mod raster;
mod turns;

pub(crate) use curve::Curve;
pub(crate) use cycle::Cycle;
pub use cycle::Loop;
pub(crate) use cycle::even_loads;
pub(crate) use outline::Stroke;
pub use outline::{Frame, outline};
pub(crate) use turns::{Branch, NOISE_FACTOR};
pub use turns::{branches, default_dead_band, noise};
pub(crate) use turns::{dead_band_of, range};

/// A cycle or branch is full if it covers at least this share of the largest one's range.
pub const FULL_SHARE: f64 = 0.8;

/// The branches of one axis in several recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Loops {
    /// One list per recording, in the order of time.
    branches: Vec<Vec<Branch>>,
}

impl Loops {
    /// Splits each recording's load at its reversals.
    pub fn of<'a>(recordings: impl IntoIterator<Item = &'a [f64]>, dead_band: f64) -> Self {
        Self {
            branches: recordings
                .into_iter()
                .map(|loads| branches(loads, dead_band))
                .collect(),
        }
    }

    /// The branches of each recording, in the order of time.
    pub fn branches(&self) -> &[Vec<Branch>] {
        &self.branches
    }

    /// All cycles: every two neighbouring branches, recording by recording.
    pub fn cycles(&self) -> impl Iterator<Item = Cycle> {
        let recordings = self.branches.iter().enumerate();
        recordings.flat_map(|(recording, branches)| {
            branches.windows(2).map(move |pair| Cycle {
                recording,
                first: pair[0].clone(),
                second: pair[1].clone(),
            })
        })
    }

    /// The cycle whose branches share the widest range of loads, the first of them if several do.
    pub fn largest(&self) -> Option<Cycle> {
        self.cycles().reduce(|largest, cycle| {
            if cycle.span() > largest.span() {
                cycle
            } else {
                largest
            }
        })
    }

    /// The cycles that cover at least [`FULL_SHARE`] of the largest one's range, itself among them.
    pub fn full_cycles(&self) -> Vec<Cycle> {
        let Some(largest) = self.largest() else {
            return Vec::new();
        };
        let whole = (largest.low(), largest.high());
        self.cycles()
            .filter(|cycle| covers((cycle.low(), cycle.high()), whole))
            .collect()
    }

    /// The widest branch that goes this way, with its recording.
    pub fn widest_branch(&self, rising: bool) -> Option<(usize, &Branch)> {
        self.all_branches(rising).reduce(|widest, other| {
            if other.1.span() > widest.1.span() {
                other
            } else {
                widest
            }
        })
    }

    /// The branches that go this way and cover at least [`FULL_SHARE`] of the range of the widest of them, which is one of
    /// them, with their recordings.
    pub fn full_branches(&self, rising: bool) -> impl Iterator<Item = (usize, &Branch)> {
        let widest = self.widest_branch(rising);
        let whole = widest.map_or((0.0, 0.0), |(_, branch)| (branch.low, branch.high));
        self.all_branches(rising)
            .filter(move |(_, branch)| covers((branch.low, branch.high), whole))
    }

    fn all_branches(&self, rising: bool) -> impl Iterator<Item = (usize, &Branch)> {
        let recordings = self.branches.iter().enumerate();
        recordings
            .flat_map(|(recording, own)| own.iter().map(move |branch| (recording, branch)))
            .filter(move |(_, branch)| branch.rising == rising)
    }
}

/// Whether one range of loads covers most of another.
fn covers(own: (f64, f64), whole: (f64, f64)) -> bool {
    own.1.min(whole.1) - own.0.max(whole.0) >= FULL_SHARE * (whole.1 - whole.0)
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
        assert_eq!(
            (largest.recording, largest.low(), largest.high()),
            (1, -1.0, 9.0)
        );
        assert!(!largest.first.rising);
        assert_eq!(largest.rising().samples, 2..4);
        assert_eq!(largest.falling().samples, 1..3);
    }

    /// The cycles span 0..2 and 1..2 (small), then 0..9, −1..9 and 1..10, which has 8 of the largest one's 10.
    #[test]
    fn full_cycles_cover_four_fifths_of_the_largest() {
        let loops = Loops::of([&SMALL[..], &LARGE], 0.5);
        let spans: Vec<f64> = loops.cycles().map(|cycle| cycle.span()).collect();
        assert_eq!(spans, [1.0, 1.0, 9.0, 10.0, 9.0]);
        let elsewhere = Loops::of([&LARGE[..], &[20.0, 29.0, 20.0]], 0.5);
        assert_eq!(elsewhere.full_cycles().len(), 3);
        assert_eq!(loops.full_cycles().len(), 3);
        assert_eq!(loops.full_branches(true).count(), 2);
        assert_eq!(loops.widest_branch(true).unwrap().1.span(), 11.0);
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
