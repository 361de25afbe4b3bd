//! The rows that tell a time lag from hysteresis.

use crate::min_max::MinMax;
use crate::questions::metrology::figures::{Basis, Found, Result};
use crate::questions::metrology::measured::{AxisView, Measured, OUTPUTS};
use crate::questions::metrology::reason::Reason;
use crate::scoring::lag::{InTime, Lag, LagRun, NoLag, WORTH_REMOVING, lags, widths};
use crate::scoring::loops::{Loop, Loops};

/// The lags of every axis, for each output.
pub(crate) type Lags = [Vec<std::result::Result<Lag, NoLag>>; OUTPUTS];

/// Measures the lags of both outputs over the runs that have a reference for every axis.
pub(crate) fn lags_of(measured: &Measured<'_>) -> Lags {
    std::array::from_fn(|output| {
        let runs: Vec<LagRun<'_>> = runs(measured, output).map(|(_, run)| run).collect();
        let none = vec![Err(NoLag::TooShort); measured.axes.len()];
        // Nothing cancels a progress of its own.
        let found = lags(&runs, &crate::progress::Progress::default()).unwrap_or_default();
        if found.is_empty() { none } else { found }
    })
}

/// The runs with a reference for every axis, and which they are.
fn runs<'a>(
    measured: &'a Measured<'_>,
    output: usize,
) -> impl Iterator<Item = (usize, LagRun<'a>)> {
    let runs = measured.runs.iter().enumerate();
    runs.filter_map(move |(at, run)| Some((at, run.lag_run(output)?)))
}

/// The lag of one output for one axis, and its hysteresis without it; the share of the mean width that the lag explains.
pub(crate) fn figures(
    view: &AxisView<'_>,
    place: usize,
    output: usize,
) -> ([Result<Found>; 2], Option<f64>) {
    let axis = view.axis;
    let lag = match &view.measured.lags()[output][place] {
        Ok(lag) => lag,
        Err(reason) => {
            let none = Err(Reason::NoLag { axis, reason: *reason });
            return ([none.clone(), none], None);
        }
    };
    let found = Ok(Found::everywhere(lag.seconds));
    let (at, own): (Vec<usize>, Vec<LagRun<'_>>) = runs(view.measured, output).unzip();
    let share = match lag.is_significant() {
        true => widths(lag, place, &own, view.dead_band).map(|widths| widths.explained_share()),
        false => Some(0.0),
    };
    let without = match share {
        Some(share) if share > WORTH_REMOVING => without_lag(view, lag, place, &at, &own),
        Some(share) => Err(Reason::LagExplainsLittle { axis, share }),
        None => Err(Reason::NoCycle { axis }),
    };
    ([found, without], share)
}

fn without_lag(
    view: &AxisView<'_>,
    lag: &Lag,
    place: usize,
    at: &[usize],
    runs: &[LagRun<'_>],
) -> Result<Found> {
    let axis = view.axis;
    let in_time = InTime::of(lag, place, runs);
    let own = || view.runs.iter().filter(|run| at.contains(&run.index));
    let loads: Vec<Vec<f64>> =
        own().map(|run| in_time.reference(run.run.times, run.loads)).collect();
    let loops = Loops::of(loads.iter().map(Vec::as_slice), view.dead_band);
    let cycle = loops.largest().ok_or(Reason::NoCycle { axis })?;
    let outputs = in_time.output(runs[cycle.recording].outputs);
    let width = Loop::of(&cycle, &loads[cycle.recording], &outputs).largest_width();
    let run = own().nth(cycle.recording).ok_or(Reason::NoCycle { axis })?;
    let range: MinMax = loads.iter().flatten().collect();
    let samples = cycle.first.samples.start..cycle.second.samples.end;
    let share = (cycle.span() / range.span()).clamp(0.0, 1.0);
    Ok(Found { size: width, place: Some(run.place(samples)), basis: Some(Basis::new(1, share)) })
}
