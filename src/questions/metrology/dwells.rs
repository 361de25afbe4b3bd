//! Dwells of the recordings, under load or at zero, whose drift curves are drawn.

use crate::questions::metrology::figures::{Place, Run};
use crate::questions::metrology::measured::{Columns, Measured};
use crate::questions::metrology::settings::{MetrologyError, Rules};

/// A dwell of the load. [`Drift::of`](crate::scoring::holds::Drift::of) fits the drift of an output in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Dwell {
    pub place: Place,
    /// Mean load of each axis of the table; `None` if the recording has no reference for it.
    pub level: Vec<Option<f64>>,
    /// True if every known axis is near zero.
    pub at_zero: bool,
}

/// Returns all dwells of these runs, in the order of runs and time. The rows on zero and creep choose among these dwells.
///
/// # Errors
/// See [`table_by`](crate::questions::metrology::table_by).
pub fn dwells(runs: &[Run<'_>], rules: &Rules<'_>) -> Result<Vec<Dwell>, MetrologyError> {
    let measured = Measured::of(runs, rules)?;
    let of_runs = measured.holds.iter().enumerate().flat_map(|(index, holds)| {
        let (measured, Columns { run, loads }) = (&measured, &measured.runs[index]);
        holds.iter().map(move |hold| {
            let mut levels = hold.level.iter().copied();
            Dwell {
                place: run.place(index, hold.samples.clone()),
                level: (loads.iter())
                    .map(|loads| loads.as_ref().and_then(|_| levels.next()))
                    .collect(),
                at_zero: measured.is_at_zero(index, hold),
            }
        })
    });
    Ok(of_runs.collect())
}
