//! Removes the lag of an output behind the reference load, and measures the hysteresis loop that remains.
//!
//! The reference is delayed by interpolation, or filtered by a low-pass, until it is as late as the output. The output is not
//! corrected instead, because an inverse low-pass would amplify the noise of the gauges. Then the outputs of all axes and a
//! constant are fitted to the delayed reference by least squares. This corrects wrong gains and crosstalk of a calibration
//! that was fitted to recordings with the lag.

use faer::Mat;

use super::{
    Lag, LagRun,
    kind::LagKind,
    solve::{saved_share, solved},
};
use crate::{
    column::column,
    dot::dot,
    recording::gap::steps_of_a_pause,
    scoring::loops::{Loop, Loops},
};

/// Minimum share of a loop's mean width that a lag explains, from which removing the lag is worthwhile.
pub const WORTH_REMOVING: f64 = 0.1;
/// Maximum uncertainty of a loop's largest width after removal of the lag, as a share of this width. It follows from the
/// standard error of the lag.
const MAX_SHARE: f64 = 0.1;
/// Maximum uncertainty of a loop's largest width, as a share of the output's full scale. It replaces the limit by
/// [`MAX_SHARE`] if it is larger.
const MAX_SHARE_FS: f64 = 0.003;
/// Approximate maximum number of samples to which the gains of [`InTime`] are fitted.
const MOST_ROWS: usize = 100_000;

/// Correction that removes the lag of one output.
#[derive(Clone, Debug)]
pub struct InTime {
    kind: LagKind,
    seconds: f64,
    /// Fitted gain of each axis' output, then the fitted constant.
    weights: Vec<f64>,
}

/// Sizes of the hysteresis loop of one output. Each pair holds the size with the lag, then the size after its removal. The
/// gains of the outputs are fitted in both cases.
#[derive(Clone, Copy, Debug)]
pub struct Widths {
    /// Largest width, in the unit of the output.
    pub largest: [f64; 2],
    /// Mean width, in the unit of the output.
    pub mean: [f64; 2],
    /// Area of the loop: mean width times the range of loads.
    pub area: [f64; 2],
    /// Change of the largest width after removal of the lag, if the lag is wrong by two standard errors.
    pub uncertainty: f64,
}

impl Widths {
    /// Returns the share of the mean loop width that the lag explains, from 0 to 1.
    pub fn explained_share(&self) -> f64 {
        saved_share(self.mean)
    }

    /// Returns true if the lag is so uncertain that the width which the loop would have without the lag is unknown.
    pub fn is_uncertain(&self, full_scale: f64) -> bool {
        self.uncertainty > (MAX_SHARE * self.largest[1]).max(MAX_SHARE_FS * full_scale)
    }

    /// Returns the share of the loop area that the lag explains, from 0 to 1.
    pub fn explained_area_share(&self) -> f64 {
        saved_share(self.area)
    }
}

impl InTime {
    /// Fits the correction that removes `lag` from the output of the axis with the index `axis`.
    pub fn of(lag: &Lag, axis: usize, runs: &[LagRun<'_>]) -> Self {
        Self::by(lag.kind, lag.seconds, axis, &axis_loads(axis, runs), runs).0
    }

    /// Fits the correction. Also returns the delayed or filtered reference of the axis in each of `runs`.
    /// `loads` are the references with the lag, see [`axis_loads`].
    fn by(
        kind: LagKind,
        seconds: f64,
        axis: usize,
        loads: &[AxisLoads],
        runs: &[LagRun<'_>],
    ) -> (Self, Vec<Vec<f64>>) {
        let mut made = Self { kind, seconds, weights: Vec::new() };
        let n_outputs = runs.first().map_or(0, |run| run.n_outputs());
        let n: usize = runs.iter().map(|run| run.times.len()).sum();
        let hop = (n / MOST_ROWS).max(1);
        let references = loads.iter().zip(runs);
        let references: Vec<Vec<f64>> = references
            .map(|((loads, pause), run)| made.delayed(run.times, loads, *pause))
            .collect();
        let places: Vec<(usize, usize)> = (runs.iter().enumerate())
            .flat_map(|(at, run)| (0..run.times.len()).step_by(hop).map(move |k| (at, k)))
            .collect();
        let x = Mat::from_fn(places.len(), n_outputs + 1, |row, column| {
            let (run, k) = places[row];
            if column == n_outputs { 1.0 } else { runs[run].outputs[k * n_outputs + column] }
        });
        let y = Mat::from_fn(places.len(), 1, |row, _| references[places[row].0][places[row].1]);
        made.weights = match solved(&x, &y) {
            Some(weights) => (0..=n_outputs).map(|at| weights[(at, 0)]).collect(),
            None => (0..=n_outputs).map(|at| f64::from(u8::from(at == axis))).collect(),
        };
        (made, references)
    }

    /// Returns the reference load, delayed or filtered until it is as late as the output. Intervals between pauses in the
    /// recording are treated separately.
    pub fn reference(&self, times: &[f64], loads: &[f64]) -> Vec<f64> {
        self.delayed(times, loads, steps_of_a_pause(times))
    }

    fn delayed(&self, times: &[f64], loads: &[f64], pause: f64) -> Vec<f64> {
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

    /// Returns the corrected output of the axis at one sample: the fitted constant, plus the outputs of all axes times their
    /// fitted gains. `outputs` is row-major with one output per axis.
    pub fn output(&self, outputs: &[f64], sample: usize) -> f64 {
        let (constant, gains) =
            self.weights.split_last().expect("the weights of the outputs end with a constant");
        constant + dot(gains, &outputs[sample * gains.len()..])
    }
}

/// Reference load of one axis in a recording, and the shortest pause in this recording (s).
type AxisLoads = (Vec<f64>, f64);

fn axis_loads(axis: usize, runs: &[LagRun<'_>]) -> Vec<AxisLoads> {
    let of_run = |run: &LagRun<'_>| {
        let loads = column(run.loads, run.n_axes(), axis);
        (loads.collect(), steps_of_a_pause(run.times))
    };
    runs.iter().map(of_run).collect()
}

/// Returns the sizes of the mean loop of an output, with the lag and after its removal. Without a mean loop, they are the
/// sizes of the largest cycle's loop. `None` if the load has no cycle.
pub fn widths(
    lag: &Lag,
    axis: usize,
    runs: &[LagRun<'_>],
    reversal_threshold: f64,
) -> Option<Widths> {
    let in_time = axis_loads(axis, runs);
    let figures = |seconds: f64| -> Option<[f64; 3]> {
        let (in_time, loads) = InTime::by(lag.kind, seconds, axis, &in_time, runs);
        let loops = Loops::of(loads.iter().map(Vec::as_slice), reversal_threshold);
        let cycles = loops
            .mean_cycles(loads.iter().flatten().collect())
            .ok()
            .or_else(|| Some(vec![loops.largest()?]))?;
        let shape = cycles.iter().map(|cycle| {
            let outputs = runs[cycle.recording].outputs;
            Loop::of(cycle, &loads[cycle.recording], |k| in_time.output(outputs, k))
        });
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
