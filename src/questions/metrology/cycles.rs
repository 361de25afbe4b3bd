//! Load cycles of one axis, or the reasons why there are none.

use crate::min_max::MinMax;
use crate::questions::metrology::figures::Result;
use crate::questions::metrology::reason::Reason;
use crate::recording::Axis;
use crate::scoring::loops::{Cycle, Loops, TooFew};

#[derive(Debug)]
pub(crate) struct Cycles {
    /// Minimum and maximum load of the axis in all recordings.
    pub range: MinMax,
    pub loops: Loops,
    pub largest: Result<Cycle>,
    /// Cycles that are averaged to the mean loop.
    pub mean: Result<Vec<Cycle>>,
}

impl Cycles {
    pub fn of<'a>(
        axis: Axis,
        recordings: impl Iterator<Item = &'a [f64]> + Clone,
        reversal_threshold: f64,
    ) -> Self {
        let range: MinMax = recordings.clone().flatten().collect();
        let loops = Loops::of(recordings, reversal_threshold);
        let largest =
            loops.largest().ok_or_else(|| no_cycle(axis, &loops, range, reversal_threshold));
        let mean = loops.mean_cycles(range).map_err(|TooFew { count, share }| Reason::FewCycles {
            axis,
            count,
            share,
        });
        Self { mean: largest.clone().and(mean), largest, range, loops }
    }
}

fn no_cycle(axis: Axis, loops: &Loops, range: MinMax, reversal_threshold: f64) -> Reason {
    let mut ways = loops.branches().iter().flatten().map(|branch| branch.rising);
    match ways.next() {
        None => {
            let (low, high) = range.ends().unwrap_or_default();
            Reason::ConstantLoad { axis, low, high, reversal_threshold }
        }
        Some(rises) if ways.all(|other| other == rises) => Reason::OneBranch { axis, rises },
        Some(_) => Reason::NoCycle { axis },
    }
}
