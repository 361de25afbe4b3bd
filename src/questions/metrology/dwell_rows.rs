//! Metrology rows from dwells: zero return, creep, time constant of creep, creep recovery.

use std::ops::Range;

use crate::{
    questions::metrology::{
        figures::{Figure, Found, Place, Run, Value},
        measured::{AxisRun, AxisView, Columns, Measured},
        quantity::Quantity,
        reason::Reason,
        settings::{MetrologyError, Rules},
    },
    scoring::holds::{Drift, Hold},
};

type Dwelling<'a> = (&'a AxisRun<'a>, &'a Hold);

pub fn dwell_figures(view: &AxisView<'_>, output: usize) -> Vec<(Quantity, Figure)> {
    let drift = |(run, hold): Dwelling<'_>| {
        let errors: Vec<f64> = run.errors(output, hold.samples.clone()).collect();
        let drift = Drift::of(&run.times()[hold.samples.clone()], &errors);
        let place = run.place(hold.samples.clone());
        (drift.expect("a dwell has samples and a duration"), Some(place))
    };
    let creep = loaded_hold(view).map(drift);
    let size = |(drift, place): (Drift, _)| Value::at(drift.size, place);
    let time_constant = creep.clone().and_then(|(drift, place)| {
        let tau_secs = drift.tau_secs()?;
        Ok(Value::at(tau_secs, place))
    });
    vec![
        (Quantity::ZeroReturn, zero_return(view, output)),
        (Quantity::CreepTime, time_constant),
        (Quantity::Creep, creep.map(size)),
        (Quantity::CreepRecovery, recovery(view).map(drift).map(size)),
    ]
}

/// Returns the zero return: the largest change of an output between two neighbouring dwells at zero load, if the axis was
/// loaded between them.
fn zero_return(view: &AxisView<'_>, output: usize) -> Figure {
    let least = view.loaded_from()?;
    check_zero(view)?;
    let secs = view.measured.settings.hold_secs;
    let pairs = view.runs.iter().flat_map(|run| {
        let dwells = dwells_at_zero(view, run);
        let pairs = dwells.windows(2).map(|pair| (run, pair[0], pair[1]));
        pairs.collect::<Vec<_>>()
    });
    let loaded = pairs
        .filter(|(run, before, after)| run.reaches(least, before.samples.end..after.samples.start));
    let returned = loaded.map(|(run, before, after)| {
        let size = mean_error(run, output, beginning(run, after, secs))
            - mean_error(run, output, end(run, before, secs));
        Value::at(size, Some(run.place(before.samples.start..after.samples.end)))
    });
    let largest =
        returned.reduce(
            |largest, other| {
                if other.value.abs() > largest.value.abs() { other } else { largest }
            },
        );
    largest.ok_or(Reason::NoReturn { axis: view.axis, share: view.measured.settings.loaded_share })
}

/// Returns the longest dwell during which the axis is loaded.
fn loaded_hold<'a>(view: &'a AxisView<'a>) -> Found<Dwelling<'a>> {
    let least = view.loaded_from()?;
    let holds = view.runs.iter().flat_map(|run| {
        let holds = view.measured.holds[run.index].iter();
        holds.filter(move |hold| mean_load(run, hold).abs() >= least).map(move |hold| (run, hold))
    });
    let settings = view.measured.settings;
    longest(holds).ok_or(Reason::NoHold {
        axis: view.axis,
        share: settings.loaded_share,
        secs: settings.hold_secs,
    })
}

/// Returns the longest dwell at zero load that follows a load on the axis.
fn recovery<'a>(view: &'a AxisView<'a>) -> Found<Dwelling<'a>> {
    let least = view.loaded_from()?;
    check_zero(view)?;
    let after_a_load = view.runs.iter().flat_map(|run| {
        let mut since = 0;
        dwells_at_zero(view, run).into_iter().filter_map(move |rest| {
            let loaded = run.reaches(least, since..rest.samples.start);
            since = rest.samples.end;
            loaded.then_some((run, rest))
        })
    });
    longest(after_a_load)
        .ok_or(Reason::NoRecovery { axis: view.axis, share: view.measured.settings.loaded_share })
}

/// Returns the dwells in which the loads of all axes of the recording are near zero.
fn dwells_at_zero<'a>(view: &AxisView<'a>, run: &AxisRun<'_>) -> Vec<&'a Hold> {
    let measured = view.measured;
    let holds = measured.holds[run.index].iter();
    holds.filter(|hold| measured.is_at_zero(run.index, hold)).collect()
}

fn check_zero(view: &AxisView<'_>) -> Found<()> {
    let settings = view.measured.settings;
    if view.runs.iter().all(|run| dwells_at_zero(view, run).is_empty()) {
        return Err(Reason::NoZero { share: settings.zero_share, secs: settings.hold_secs });
    }
    Ok(())
}

/// Returns the longest dwell. If several dwells are equally long, the first dwell is returned.
fn longest<'a>(holds: impl Iterator<Item = Dwelling<'a>>) -> Option<Dwelling<'a>> {
    let secs = |(run, hold): &Dwelling<'_>| {
        run.times()[hold.samples.end - 1] - run.times()[hold.samples.start]
    };
    holds.reduce(|longest, other| if secs(&other) > secs(&longest) { other } else { longest })
}

fn mean_load(run: &AxisRun<'_>, hold: &Hold) -> f64 {
    run.loads[hold.samples.clone()].iter().sum::<f64>() / hold.samples.len() as f64
}

fn mean_error(run: &AxisRun<'_>, output: usize, samples: Range<usize>) -> f64 {
    let n = samples.len();
    run.errors(output, samples).sum::<f64>() / n as f64
}

fn beginning(run: &AxisRun<'_>, hold: &Hold, secs: f64) -> Range<usize> {
    let samples = hold.samples.clone();
    let times = &run.times()[samples.clone()];
    let n = times.partition_point(|time| *time <= times[0] + secs);
    samples.start..samples.start + n
}

fn end(run: &AxisRun<'_>, hold: &Hold, secs: f64) -> Range<usize> {
    let samples = hold.samples.clone();
    let times = &run.times()[samples.clone()];
    let before = times.partition_point(|time| *time < times[times.len() - 1] - secs);
    samples.start + before..samples.end
}

/// A dwell of the load. [`Drift::of`](crate::scoring::holds::Drift::of) fits the drift of an output in a dwell.
#[derive(Debug)]
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
pub fn dwells(
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
