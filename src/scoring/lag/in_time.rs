//! Removes a lag between reference and output, and measures the remaining loop.
//!
//! The reference is made as late as the output: delayed by interpolation, or filtered by the same low-pass. Undoing a
//! low-pass of the output would multiply the noise of the gauges. The output is then fitted to the late reference by least
//! squares over the outputs of all axes and a constant. This removes gains and crosstalk that a calibration learned from data
//! with the lag.

use faer::Mat;

use super::kind::LagKind;
use super::solve::solved;
use super::{Lag, LagRun};
use crate::recording::gap::{median_step, pause_by_step};
use crate::scoring::loops::{Loop, Loops};

/// Share of a loop's mean width from which a lag that explains it is worth removing.
pub const WORTH_REMOVING: f64 = 0.1;
/// Maximum uncertainty of the largest width that is due to the uncertainty of the lag, as a share of the width.
const MAX_SHARE: f64 = 0.1;
/// The same limit as a share of full scale. The larger of the two counts.
const MAX_SHARE_FS: f64 = 0.003;
/// Approximate maximum number of rows for the fit of the output.
const MOST_ROWS: usize = 100_000;

/// Removal of the lag of one output.
#[derive(Clone, Debug, PartialEq)]
pub struct InTime {
    kind: LagKind,
    seconds: f64,
    /// Gain for the output of each axis, then the constant.
    weights: Vec<f64>,
}

/// Sizes of the loop of one output: with its lag, and without it. Both have gains fitted anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Widths {
    /// Largest width.
    pub largest: [f64; 2],
    /// Mean width.
    pub mean: [f64; 2],
    /// Area.
    pub area: [f64; 2],
    /// Change of the largest width without the lag, if the lag is wrong by two standard errors.
    pub uncertainty: f64,
}

impl Widths {
    /// Returns the share of the mean width that the lag explains, 0 to 1.
    pub fn explained_share(&self) -> f64 {
        share(self.mean)
    }

    /// Returns true if the lag is too uncertain to know the width of the loop without it.
    pub fn is_uncertain(&self, full_scale: f64) -> bool {
        self.uncertainty > (MAX_SHARE * self.largest[1]).max(MAX_SHARE_FS * full_scale)
    }

    /// Returns the share of the area that the lag explains, 0 to 1.
    pub fn explained_area_share(&self) -> f64 {
        share(self.area)
    }
}

fn share([before, after]: [f64; 2]) -> f64 {
    if before > 0.0 { (1.0 - after / before).clamp(0.0, 1.0) } else { 0.0 }
}

impl InTime {
    /// Fits the removal of this lag, for the output of the axis with this index.
    pub fn of(lag: &Lag, axis: usize, runs: &[LagRun<'_>]) -> Self {
        Self::by(lag.kind, lag.seconds, axis, runs)
    }

    fn by(kind: LagKind, seconds: f64, axis: usize, runs: &[LagRun<'_>]) -> Self {
        let mut own = Self { kind, seconds, weights: Vec::new() };
        let n_outputs = runs.first().map_or(0, |run| run.n_outputs());
        let n: usize = runs.iter().map(|run| run.times.len()).sum();
        let hop = (n / MOST_ROWS).max(1);
        let references: Vec<Vec<f64>> = runs.iter().map(|run| own.axis(axis, run)).collect();
        let places: Vec<(usize, usize)> = (runs.iter().enumerate())
            .flat_map(|(at, run)| (0..run.times.len()).step_by(hop).map(move |k| (at, k)))
            .collect();
        let x = Mat::from_fn(places.len(), n_outputs + 1, |row, column| {
            let (run, k) = places[row];
            if column == n_outputs { 1.0 } else { runs[run].outputs[k * n_outputs + column] }
        });
        let y = Mat::from_fn(places.len(), 1, |row, _| references[places[row].0][places[row].1]);
        own.weights = match solved(&x, &y) {
            Some(weights) => (0..=n_outputs).map(|at| weights[(at, 0)]).collect(),
            None => (0..=n_outputs).map(|at| f64::from(u8::from(at == axis))).collect(),
        };
        own
    }

    fn axis(&self, axis: usize, run: &LagRun<'_>) -> Vec<f64> {
        let loads = run.loads.iter().skip(axis).step_by(run.n_axes());
        self.reference(run.times, &loads.copied().collect::<Vec<_>>())
    }

    /// Returns the reference, one load per time, as late as the output. Intervals between pauses are treated separately.
    pub fn reference(&self, times: &[f64], loads: &[f64]) -> Vec<f64> {
        let pause = median_step(times).map_or(f64::INFINITY, pause_by_step);
        let mut late = Vec::with_capacity(loads.len());
        let mut from = 0;
        for to in 1..=times.len() {
            if to == times.len() || times[to] - times[to - 1] > pause {
                late.extend(self.kind.late(&times[from..to], &loads[from..to], self.seconds));
                from = to;
            }
        }
        late
    }

    /// Returns the output with its gains fitted anew; `outputs` is row-major with the columns of the fit.
    pub fn output(&self, outputs: &[f64]) -> Vec<f64> {
        let (constant, gains) = self.weights.split_last().expect("the weights end with a constant");
        let rows = outputs.chunks_exact(gains.len());
        let load =
            |row: &[f64]| -> f64 { row.iter().zip(gains).map(|(own, gain)| own * gain).sum() };
        rows.map(|row| constant + load(row)).collect()
    }
}

/// Returns the sizes of the mean loop, or else of the largest cycle, with and without the lag; `None` without a cycle.
pub fn widths(
    lag: &Lag,
    axis: usize,
    runs: &[LagRun<'_>],
    reversal_threshold: f64,
) -> Option<Widths> {
    let figures = |seconds: f64| -> Option<[f64; 3]> {
        let own = InTime::by(lag.kind, seconds, axis, runs);
        let loads: Vec<Vec<f64>> = runs.iter().map(|run| own.axis(axis, run)).collect();
        let outputs: Vec<Vec<f64>> = runs.iter().map(|run| own.output(run.outputs)).collect();
        let loops = Loops::of(loads.iter().map(Vec::as_slice), reversal_threshold);
        let cycles = loops
            .mean_cycles(loads.iter().flatten().collect())
            .ok()
            .or_else(|| Some(vec![loops.largest()?]))?;
        let shape =
            cycles.iter().map(|own| Loop::of(own, &loads[own.recording], &outputs[own.recording]));
        let one = Loop::mean(&shape.collect::<Vec<_>>())?;
        Some([one.largest_width(), one.mean_width(), one.area()])
    };
    let (before, after) = (figures(0.0)?, figures(lag.seconds)?);
    let off = |errors: f64| {
        let seconds = lag.seconds + errors * lag.standard_error_secs;
        let is_possible = seconds > 0.0 || lag.kind == LagKind::Delay;
        let off = figures(if is_possible { seconds } else { 0.0 })?;
        Some((off[0] - after[0]).abs())
    };
    let uncertainty = off(-2.0)?.max(off(2.0)?);
    let [largest, mean, area] = [0, 1, 2].map(|at| [before[at], after[at]]);
    Some(Widths { largest, mean, area, uncertainty })
}
