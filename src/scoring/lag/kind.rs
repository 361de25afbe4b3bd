//! Delays a signal by a fixed time, or filters it by a first-order low-pass; removes the lag of an output behind the reference
//! load, and measures the hysteresis loop that remains.
//!
//! Guarantees: the result is finite for finite samples whose times do not decrease. A signal that is a straight line stays a
//! straight line, except shortly after its start.
//!
//! The reference is delayed or filtered until it is as late as the output. The output is not corrected instead, because an
//! inverse low-pass would amplify the noise of the gauges. Then the outputs of all axes and a constant are fitted to the
//! delayed reference by least squares. This corrects wrong gains and crosstalk of a calibration that was fitted to recordings
//! with the lag.

use faer::Mat;
use serde::Serialize;

use crate::{
    column::column,
    dot::dot,
    recording::gap::steps_of_a_pause,
    scoring::{
        lag::{
            Lag, LagRun,
            solve::{saved_share, solved},
        },
        loops::{Loop, Loops},
    },
};

/// Kind of the lag of a signal behind the reference load.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LagKind {
    /// Delay of the whole signal, such as a clock offset, a late time stamp or a transport delay.
    Delay,
    /// First-order low-pass, such as an amplifier or a filter.
    FirstOrder,
}

impl LagKind {
    /// Returns the name of this kind of lag, as reports show it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Delay => "delay",
            Self::FirstOrder => "first-order time constant",
        }
    }

    /// Returns the signal after a delay of `seconds`, or after a low-pass with this time constant. A delay may be negative.
    ///
    /// A delayed signal is interpolated by cubic polynomials through four samples. The low-pass treats the signal as a
    /// straight line between two samples. Before its first sample, a signal counts as constant.
    pub fn late(self, times: &[f64], values: &[f64], seconds: f64) -> Vec<f64> {
        match self {
            _ if seconds == 0.0 => values.to_vec(),
            Self::Delay => {
                delay(times, seconds).map(|weights| interpolated(&weights, values)).collect()
            }
            Self::FirstOrder => {
                let weights = low_pass(times[0], times, seconds);
                filtered(&mut (values[0], values[0]), weights, values)
            }
        }
    }
}

/// Appends rows of several signals, late by `seconds`, to `late`. `rows` is row-major with one row for each time. Only the
/// first `n` signals, and only the rows with `used`, are appended.
pub fn add_late_rows(
    kind: LagKind,
    seconds: f64,
    (times, used): (&[f64], &[bool]),
    (rows, n): (&[f64], usize),
    late: &mut Vec<f64>,
) {
    let width = rows.len() / times.len();
    let row = |k: usize| &rows[k * width..k * width + n];
    let used = || used.iter().copied();
    if seconds == 0.0 {
        let all = used().enumerate().filter(|(_, used)| *used);
        return all.for_each(|(k, _)| late.extend_from_slice(row(k)));
    }
    match kind {
        LagKind::Delay => {
            for ((first, weights), used) in delay(times, seconds).zip(used()) {
                if used && first + 4 <= times.len() {
                    let near = &rows[first * width..(first + 4) * width];
                    let [a, b, c, d] = [0, 1, 2, 3].map(|at| &near[at * width..at * width + n]);
                    let signals = a.iter().zip(b).zip(c).zip(d);
                    late.extend(signals.map(|(((a, b), c), d)| {
                        weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d
                    }));
                } else if used {
                    let near = || weights.iter().zip(first..times.len());
                    late.extend(
                        (0..n).map(|at| -> f64 {
                            near().map(|(weight, k)| weight * row(k)[at]).sum()
                        }),
                    );
                }
            }
        }
        LagKind::FirstOrder => {
            let (mut states, mut before) = (row(0).to_vec(), row(0));
            let weights = low_pass(times[0], times, seconds);
            for ((k, [kept, start, end]), used) in weights.enumerate().zip(used()) {
                let values = row(k);
                for ((state, before), value) in states.iter_mut().zip(before).zip(values) {
                    *state = kept * *state + start * before + end * value;
                }
                before = values;
                if used {
                    late.extend_from_slice(&states);
                }
            }
        }
    }
}

fn interpolated((first, weights): &(usize, [f64; 4]), values: &[f64]) -> f64 {
    match values.get(*first..first + 4) {
        Some([a, b, c, d]) => weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d,
        _ => dot(weights, &values[*first..]),
    }
}

/// Filters values by a low-pass with these weights: of the filter's previous result, of the previous value and of the present
/// value. The state is the previous result and the previous value.
pub fn filtered(
    (state, before): &mut (f64, f64),
    weights: impl Iterator<Item = [f64; 3]>,
    values: &[f64],
) -> Vec<f64> {
    let step = |([kept, start, end], value): ([f64; 3], &f64)| {
        *state = kept * *state + start * *before + end * value;
        *before = *value;
        *state
    };
    weights.zip(values).map(step).collect()
}

fn delay(times: &[f64], seconds: f64) -> impl Iterator<Item = (usize, [f64; 4])> {
    let last = times.len() - 1;
    let mut next = 0;
    times.iter().map(move |time| {
        let wanted = time - seconds;
        while next <= last && times[next] <= wanted {
            next += 1;
        }
        match next {
            0 => (0, [1.0, 0.0, 0.0, 0.0]),
            _ if next > last => (last, [1.0, 0.0, 0.0, 0.0]),
            _ => between(times, next, wanted),
        }
    })
}

/// Returns weights that interpolate at the time `wanted` between the samples `next - 1` and `next`, after the index of the
/// first weighted sample. The interpolation is cubic if two samples with different times lie on each side, else linear.
fn between(times: &[f64], next: usize, wanted: f64) -> (usize, [f64; 4]) {
    let around = next.checked_sub(2).filter(|_| next + 1 < times.len());
    if let Some(first) = around
        && let Some([a, b, c, d]) = times.get(first..first + 4)
        && a < b
        && b < c
        && c < d
    {
        // Lagrange's polynomials, each with one division.
        let [wa, wb, wc, wd] = [a, b, c, d].map(|time| wanted - time);
        let above = [wb * wc * wd, wa * wc * wd, wa * wb * wd, wa * wb * wc];
        let below = [
            (a - b) * (a - c) * (a - d),
            (b - a) * (b - c) * (b - d),
            (c - a) * (c - b) * (c - d),
            (d - a) * (d - b) * (d - c),
        ];
        return (first, std::array::from_fn(|at| above[at] / below[at]));
    }
    let (before, after) = (times[next - 1], times[next]);
    let share = if after > before { (wanted - before) / (after - before) } else { 1.0 };
    (next - 1, [1.0 - share, share, 0.0, 0.0])
}

/// Returns the weights of a low-pass at these times; see [`filtered`]. `before` is the time of the previous sample.
pub fn low_pass(mut before: f64, times: &[f64], tau: f64) -> impl Iterator<Item = [f64; 3]> {
    times.iter().map(move |time| {
        let steps = (time - std::mem::replace(&mut before, *time)) / tau;
        if steps > 0.0 {
            let kept = (-steps).exp();
            // The weights of the low-pass are exact for a signal that is a straight line between two samples.
            let start = -(-steps).exp_m1() / steps;
            [kept, start - kept, 1.0 - start]
        } else {
            [1.0, 0.0, 0.0]
        }
    })
}

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

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp of 1 per second is late by the lag, with a delay and with a settled low-pass.
    #[test]
    fn a_ramp_is_late_by_the_lag() {
        let times: Vec<f64> =
            (0..400).map(|k| 0.01 * f64::from(k) + 1e-3 * (f64::from(k)).sin()).collect();
        for kind in [LagKind::Delay, LagKind::FirstOrder] {
            for seconds in [0.003, 0.034, 0.05] {
                let late = kind.late(&times, &times, seconds);
                for k in 200..400 {
                    assert!((times[k] - late[k] - seconds).abs() < 1e-9, "{kind:?} {seconds}");
                }
            }
        }
        let early = LagKind::Delay.late(&times, &times, -0.021);
        assert!((early[100] - times[100] - 0.021).abs() < 1e-12);
    }

    /// For a sine of 1 Hz at 100 Hz, the cubic errs by less than 1e-6, and the low-pass has its known gain and phase.
    #[test]
    fn a_sine_has_its_known_phase() {
        let times: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let omega = std::f64::consts::TAU;
        let sine: Vec<f64> = times.iter().map(|t| (omega * t).sin()).collect();
        let delayed = LagKind::Delay.late(&times, &sine, 0.0234);
        let passed = LagKind::FirstOrder.late(&times, &sine, 0.05);
        let phase = (omega * 0.05_f64).atan();
        for k in 500..999 {
            assert!((delayed[k] - (omega * (times[k] - 0.0234)).sin()).abs() < 1e-6);
            let expected = phase.cos() * (omega * times[k] - phase).sin();
            assert!((passed[k] - expected).abs() < 1e-3);
        }
    }

    #[test]
    fn repeated_times_and_single_samples_stay_finite() {
        for kind in [LagKind::Delay, LagKind::FirstOrder] {
            let late = kind.late(&[0.0, 0.0, 0.1, 0.1], &[1.0, 2.0, 3.0, 4.0], 0.05);
            assert!(late.iter().all(|value| value.is_finite()));
            assert_eq!(kind.late(&[3.0], &[7.0], 0.1), [7.0]);
        }
    }
}
