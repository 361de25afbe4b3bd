//! Where the recordings hold a load still or rest at zero: what a drift curve is drawn of.

use crate::questions::metrology::figures::{Place, Run};
use crate::questions::metrology::measured::Measured;
use crate::questions::metrology::settings::{MetrologyError, Rules};

/// An interval in which the load stands still.
///
/// How an output drifts in it is [`Drift::of`](crate::scoring::holds::Drift::of) the times and errors of its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Dwell {
    /// Where it is.
    pub place: Place,
    /// The mean load of each axis of the table; `None` where the recording has no reference for it.
    pub level: Vec<Option<f64>>,
    /// Whether every known axis is near zero.
    pub at_zero: bool,
}

/// All dwells of these runs, in the order of runs and time: the ones that the rows on zero and creep choose from.
///
/// # Errors
/// As [`table_by`](crate::questions::metrology::table_by).
pub fn dwells(runs: &[Run<'_>], rules: &Rules<'_>) -> Result<Vec<Dwell>, MetrologyError> {
    let measured = Measured::of(runs, rules)?;
    let of_runs = measured.holds.iter().enumerate().flat_map(|(index, holds)| {
        let (measured, run) = (&measured, &measured.runs[index]);
        holds.iter().map(move |hold| {
            let mut levels = hold.level.iter().copied();
            Dwell {
                place: run.place(index, hold.samples.clone()),
                level: (run.loads.iter())
                    .map(|loads| loads.as_ref().and_then(|_| levels.next()))
                    .collect(),
                at_zero: measured.is_at_zero(index, hold),
            }
        })
    });
    Ok(of_runs.collect())
}
