//! Dwells of the recordings, under load or at zero, whose drift curves are drawn.

use crate::questions::metrology::figures::{Place, Run};
use crate::questions::metrology::measured::{Columns, Measured};
use crate::questions::metrology::settings::{MetrologyError, Rules};

/// A dwell of the load. [`Drift::of`](crate::scoring::holds::Drift::of) fits the drift of an output in a dwell.
#[derive(Clone, Debug, PartialEq)]
pub struct Dwell {
    pub place: Place,
    /// Mean reference load of the axis in the dwell; `None` if the recording has no reference for the axis.
    pub level: Option<f64>,
    /// True if the load of every axis with a reference is near zero in the dwell.
    pub at_zero: bool,
}

/// Returns all dwells of these recordings, in the order of recordings and time. Zero return and creep are measured in these
/// dwells. `axis` is the position of the axis whose mean load [`Dwell::level`] states.
///
/// # Errors
/// See [`table_by`](crate::questions::metrology::table_by).
pub(crate) fn dwells(
    runs: &[Run<'_>],
    rules: &Rules<'_>,
    axis: usize,
) -> Result<Vec<Dwell>, MetrologyError> {
    let measured = Measured::of(runs, rules)?;
    let of_runs = measured.holds.iter().enumerate().flat_map(|(index, holds)| {
        let (measured, Columns { run, loads }) = (&measured, &measured.runs[index]);
        let before = loads[..axis].iter().flatten().count();
        holds.iter().map(move |hold| Dwell {
            place: run.place(index, hold.samples.clone()),
            level: loads[axis].as_ref().map(|_| hold.level[before]),
            at_zero: measured.is_at_zero(index, hold),
        })
    });
    Ok(of_runs.collect())
}
