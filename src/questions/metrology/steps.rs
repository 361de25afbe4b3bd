//! Readings at the ends of the steps of a staircase.

use crate::{
    questions::metrology::{
        loop_rows::FEWEST_LOADS,
        measured::{AxisRun, AxisView},
    },
    scoring::{holds::Hold, loops::Branch},
};

/// Share of a step, at its end, whose samples are averaged to a reading.
const READ: f64 = 1.0 / 3.0;
/// Largest change of the load within a step, as a share of the largest movement in a dwell. A steady ramp changes by two
/// thirds.
const MOVED: f64 = 0.3;
/// Minimum share of a branch's samples that lie in steps, if the branch is a staircase.
const HELD: f64 = 0.5;

/// Returns the readings `(load, output)` at the ends of the steps of a branch, and the noise of one reading; `None` if the branch
/// is no staircase.
pub fn readings(
    view: &AxisView<'_>,
    run: &AxisRun<'_>,
    branch: &Branch,
    outputs: &[f64],
) -> Option<(Vec<(f64, f64)>, f64)> {
    let within = |step: &Hold| {
        let (start, end) = (
            step.samples.start.max(branch.samples.start),
            step.samples.end.min(branch.samples.end),
        );
        let is_nested = branch.nested.iter().any(|inner| inner.start <= start && end <= inner.end);
        if is_nested { 0 } else { end.saturating_sub(start) }
    };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mut held, mut squares) = (0, 0.0);
    let mut readings: Vec<(f64, f64)> = Vec::new();
    let steps = &view.measured.steps[run.index];
    let first = steps.partition_point(|step| step.samples.end <= branch.samples.start);
    let steps = steps[first..].iter().take_while(|step| step.samples.start < branch.samples.end);
    for step in steps.filter(|step| within(step) > 0) {
        let n = (READ * step.samples.len() as f64).ceil() as usize;
        let (begin, end) = (step.samples.start, step.samples.end);
        let load = mean(&run.loads[end - n..end]);
        let moved = load - mean(&run.loads[begin..begin + n]);
        if moved.abs() > MOVED * view.still {
            continue;
        }
        held += within(step);
        let read = &outputs[end - n..end];
        let output = mean(read);
        // A dwell that a disturbance divides is one step, which ends with its last part.
        if readings.last().is_some_and(|(last, _)| (last - load).abs() <= view.still) {
            readings.pop();
        }
        readings.push((load, output));
        let variance = read.iter().map(|value| (value - output).powi(2)).sum::<f64>();
        squares += variance / (n as f64 * (n as f64 - 1.0).max(1.0));
    }
    let is_staircase =
        readings.len() >= FEWEST_LOADS && held as f64 >= HELD * branch.kept().count() as f64;
    let noise = (squares / readings.len().max(1) as f64).sqrt();
    is_staircase.then_some((readings, noise))
}
