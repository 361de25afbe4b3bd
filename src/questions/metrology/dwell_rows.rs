//! Metrology rows from dwells: zero return, creep with its time constant, creep recovery.

use std::ops::Range;

use crate::questions::metrology::figures::{Found, Result};
use crate::questions::metrology::measured::{AxisRun, AxisView};
use crate::questions::metrology::quantity::Quantity;
use crate::questions::metrology::reason::Reason;
use crate::scoring::holds::{Drift, Hold};

pub(crate) struct DwellRows<'a> {
    view: &'a AxisView<'a>,
    /// Longest dwell with the axis loaded.
    loaded_hold: Result<(&'a AxisRun<'a>, &'a Hold)>,
    /// Pairs of neighbouring dwells at zero, with the axis loaded between them.
    returns: Result<Vec<(&'a AxisRun<'a>, &'a Hold, &'a Hold)>>,
    /// Longest dwell at zero after the axis was loaded.
    recovery: Result<(&'a AxisRun<'a>, &'a Hold)>,
}

impl<'a> DwellRows<'a> {
    pub(crate) fn of(view: &'a AxisView<'a>) -> Self {
        Self {
            view,
            loaded_hold: loaded_hold(view),
            returns: returns(view),
            recovery: recovery(view),
        }
    }

    pub(crate) fn figures(&self, output: usize) -> Vec<(Quantity, Result<Found>)> {
        let creep = self.drift(&self.loaded_hold, output);
        vec![
            (Quantity::ZeroReturn, self.zero_return(output)),
            (Quantity::CreepTime, creep.clone().and_then(time_constant)),
            (Quantity::Creep, creep.map(size)),
            (Quantity::CreepRecovery, self.drift(&self.recovery, output).map(size)),
        ]
    }

    fn zero_return(&self, output: usize) -> Result<Found> {
        let pairs = self.returns.as_ref().map_err(Clone::clone)?;
        let secs = self.view.measured.settings.hold_secs;
        let returned = |(run, before, after): &(&AxisRun<'_>, &Hold, &Hold)| {
            let size = mean_error(run, output, beginning(run, after, secs))
                - mean_error(run, output, end(run, before, secs));
            Found::at(size, Some(run.place(before.samples.start..after.samples.end)))
        };
        let largest = pairs.iter().map(returned).reduce(|largest, other| {
            if other.size.abs() > largest.size.abs() { other } else { largest }
        });
        Ok(largest.expect("a found list has at least one pair"))
    }

    fn drift(
        &self,
        hold: &Result<(&'a AxisRun<'a>, &'a Hold)>,
        output: usize,
    ) -> Result<(Drift, &'a AxisRun<'a>, &'a Hold)> {
        let (run, hold) = hold.as_ref().map_err(Clone::clone)?;
        let errors: Vec<f64> = run.errors(output, hold.samples.clone()).collect();
        let drift = Drift::of(&run.run.times[hold.samples.clone()], &errors);
        Ok((drift.expect("a dwell has samples and a duration"), run, hold))
    }
}

fn size((drift, run, hold): (Drift, &AxisRun<'_>, &Hold)) -> Found {
    Found::at(drift.size, Some(run.place(hold.samples.clone())))
}

fn time_constant((drift, run, hold): (Drift, &AxisRun<'_>, &Hold)) -> Result<Found> {
    let place = run.place(hold.samples.clone());
    Ok(Found::at(drift.tau_secs()?, Some(place)))
}

fn loaded_hold<'a>(view: &'a AxisView<'a>) -> Result<(&'a AxisRun<'a>, &'a Hold)> {
    let least = view.loaded_from()?;
    let holds = view.runs.iter().flat_map(|run| {
        let own = view.measured.holds[run.index].iter();
        own.filter(move |hold| mean_load(run, hold).abs() >= least).map(move |hold| (run, hold))
    });
    let settings = view.measured.settings;
    longest(holds).ok_or(Reason::NoHold {
        axis: view.axis,
        share: settings.loaded_share,
        secs: settings.hold_secs,
    })
}

fn returns<'a>(view: &'a AxisView<'a>) -> Result<Vec<(&'a AxisRun<'a>, &'a Hold, &'a Hold)>> {
    let least = view.loaded_from()?;
    check_zero(view)?;
    let pairs: Vec<_> = (view.runs.iter())
        .flat_map(|run| {
            let dwells = dwells_at_zero(view, run);
            let pairs = dwells.windows(2).map(|pair| (run, pair[0], pair[1]));
            pairs.collect::<Vec<_>>()
        })
        .filter(|(run, before, after)| run.reaches(least, before.samples.end..after.samples.start))
        .collect();
    if pairs.is_empty() {
        return Err(Reason::NoReturn {
            axis: view.axis,
            share: view.measured.settings.loaded_share,
        });
    }
    Ok(pairs)
}

fn recovery<'a>(view: &'a AxisView<'a>) -> Result<(&'a AxisRun<'a>, &'a Hold)> {
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

/// Returns the dwells in which every axis of the run is near zero.
fn dwells_at_zero<'a>(view: &AxisView<'a>, run: &AxisRun<'_>) -> Vec<&'a Hold> {
    let measured = view.measured;
    let holds = measured.holds[run.index].iter();
    holds.filter(|hold| measured.is_at_zero(run.index, hold)).collect()
}

fn check_zero(view: &AxisView<'_>) -> Result<()> {
    let settings = view.measured.settings;
    if view.runs.iter().all(|run| dwells_at_zero(view, run).is_empty()) {
        return Err(Reason::NoZero { share: settings.zero_share, secs: settings.hold_secs });
    }
    Ok(())
}

fn longest<'a>(
    holds: impl Iterator<Item = (&'a AxisRun<'a>, &'a Hold)>,
) -> Option<(&'a AxisRun<'a>, &'a Hold)> {
    let secs = |(run, hold): &(&AxisRun<'_>, &Hold)| {
        run.run.times[hold.samples.end - 1] - run.run.times[hold.samples.start]
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
    let times = &run.run.times[samples.clone()];
    let n = times.partition_point(|time| *time <= times[0] + secs);
    samples.start..samples.start + n
}

fn end(run: &AxisRun<'_>, hold: &Hold, secs: f64) -> Range<usize> {
    let samples = hold.samples.clone();
    let times = &run.run.times[samples.clone()];
    let before = times.partition_point(|time| *time < times[times.len() - 1] - secs);
    samples.start + before..samples.end
}
