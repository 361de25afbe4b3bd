//! Measures the lag of an output behind the reference load, separately from hysteresis.
//!
//! Both lag and hysteresis make a loop when the output is plotted over the load. The loop due to lag grows with the rate of the
//! load; the loop due to hysteresis does not. So both are fitted together. An output `u` is described by `u(t) = Σ aⱼ xⱼ` with
//! fitted coefficients `aⱼ`. Each `xⱼ` is late by the lag τ. The `xⱼ` are
//! * the reference loads of all axes, and a constant;
//! * play operators of several radii, squares and cubes, driven by these loads or by the strain of each gauge, whichever
//!   explains more;
//! * slow creep of the loads.
//!
//! All `xⱼ` are computed from the reference loads. So wrong gains of a calibration that was fitted to recordings with lag do
//! no harm. τ minimises the squared residual (Gauss-Newton), once as a delay and once as the time constant of a low-pass.
//!
//! **Assumptions** All loads on which an output depends have the same lag. Hysteresis does not depend on the rate and is a
//! mixture of play operators. The time constant of creep is at least three times the time scale on which the load changes.
//! If faster creep without a lag leaves a smaller residual, the lag is unknown.
//!
//! **Uncertainty** The standard error follows from the differences between contiguous blocks of the recordings, and from the
//! change of τ if hysteresis is described by fewer radii. If this error is too large, the lag is unknown ([`NoLag`]).

mod grid;
mod kind;
mod solve;

pub use kind::{InTime, LagKind, WORTH_REMOVING, Widths, widths};

use rayon::prelude::*;
use serde::Serialize;

use self::grid::Grids;
use self::solve::{Fit, Fitted, Model};
use crate::{
    progress::{Cancelled, Progress},
    recording::Recording,
};

/// Minimum share of the output's squared rate of change that terms without a lag leave unexplained. With a smaller share, lag
/// and hysteresis look alike. Two equally long intervals, one at twice the rate of the other, leave (1 − 2)² / 2 (1² + 2²) =
/// 10 %, or 3 % if play and curvature explain a part. A single rate leaves at most 0.2 % on simulated sensors.
const LEAST_SHARE: f64 = 0.02;
/// Maximum uncertainty of a reported lag (two standard errors), in samples. A lag is reported if its uncertainty is within this
/// limit or within [`MOST_SHARE`].
///
/// Measured on 100 simulated sensors with lags up to five samples, play up to 10 % and noise up to 1 %: 225 lags are within a
/// limit, and 8 of them are wrong by more than a tenth of a sample and by more than 3 %. 25 lags are beyond both limits, and
/// 24 of them are wrong by more than this.
const MOST_SAMPLES: f64 = 0.25;
/// Lag (samples) up to which it is significant only if the load moves steadily. It is twice the uncertainty of a lag, which
/// is a tenth of a sample.
pub const UNRESOLVED: f64 = 0.2;
/// Minimum ratio of the time scale of a load that moves steadily to the time between two samples. A load that is different
/// at every sample has a time scale of about three samples, because it is smoothed.
const STEADY: f64 = 4.0;
/// Maximum uncertainty of a reported lag (two standard errors), as a share of the lag.
const MOST_SHARE: f64 = 0.07;

/// Samples of one recording in which a lag is measured. `gauges`, `loads` and `outputs` are row-major, with one row for each
/// time.
#[derive(Clone, Copy, Debug)]
pub struct LagRun<'a> {
    /// Sample times (s).
    pub times: &'a [f64],
    /// Values of the gauges. Each gauge measures a mixture of loads, possibly with hysteresis.
    pub gauges: &'a [f64],
    /// Reference loads of all axes.
    pub loads: &'a [f64],
    /// Signals whose lag is measured, such as the loads of a calibration or the gauges.
    pub outputs: &'a [f64],
}

impl<'a> LagRun<'a> {
    /// Returns the samples of a recording with these outputs.
    pub(crate) fn of(recording: &'a Recording, outputs: &'a [f64]) -> Self {
        Self {
            times: recording.times(),
            gauges: recording.gauges(),
            loads: recording.loads(),
            outputs,
        }
    }

    fn width(&self, values: &[f64]) -> usize {
        values.len().checked_div(self.times.len()).unwrap_or(0)
    }

    fn n_axes(&self) -> usize {
        self.width(self.loads)
    }

    fn n_gauges(&self) -> usize {
        self.width(self.gauges)
    }

    fn n_outputs(&self) -> usize {
        self.width(self.outputs)
    }
}

/// Lag of one output behind the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lag {
    /// Kind of lag that leaves the smaller residual of the output: delay or low-pass.
    pub kind: LagKind,
    /// True if the recordings distinguish a delay from a low-pass. If not, `kind` is a delay.
    pub kind_is_known: bool,
    /// Delay or time constant (s); positive if the output comes after the reference.
    pub seconds: f64,
    /// Delay or time constant, as a multiple of the median time between two samples.
    pub samples: f64,
    /// Standard error of `seconds` (s).
    pub standard_error_secs: f64,
    /// Share of a conventional (linear) calibration's squared error that disappears if the lag is removed, from 0 to 1.
    pub explained_error_share: f64,
    /// True if the load moves so steadily that even a lag of a small part of a sample changes the error.
    #[serde(skip)]
    is_steady: bool,
}

impl Lag {
    /// Returns true if the lag differs from zero by more than twice its standard error. If the load does not move steadily, a
    /// lag below [`UNRESOLVED`] is never significant.
    pub fn is_significant(&self) -> bool {
        self.seconds.abs() > 2.0 * self.standard_error_secs
            && (self.is_steady || self.samples.abs() > UNRESOLVED)
    }
}

/// Reason why the lag of an output is unknown.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the error messages describe the variants and their fields")]
pub enum NoLag {
    #[error(
        "a lag is measured in recordings with sample times and a reference load for every axis, but none is long enough without a pause"
    )]
    TooShort,
    #[error("the load does not move")]
    ConstantLoad,
    #[error(
        "the load changes only in jumps between two samples; record a load that moves steadily"
    )]
    Jumps,
    #[error(
        "the load always moves at about the same rate, so lag and hysteresis look alike; record the load at two rates, one twice the other"
    )]
    OneRate,
    #[error(
        "the load moves too slowly: the lag would be known to ± {uncertainty_secs:.2e} s only; record the load moving faster"
    )]
    Uncertain { uncertainty_secs: f64 },
    #[error(
        "slow creep of the gauges explains their late response better than a lag does; record the load moving faster"
    )]
    Creep,
    #[error(
        "the fit found no lag that is shorter than a third of a load cycle; record the load moving at two rates, one twice the other"
    )]
    NotFound,
}

/// Equations of the lag in some recordings. They depend on the reference loads and the gauges, but not on the outputs, so all
/// outputs share them.
#[derive(Debug)]
pub struct LagEquations {
    grids: Grids,
    /// Equations for each possible input of the play operators.
    models: Vec<Model>,
}

impl LagEquations {
    /// Prepares the equations. The outputs of the recordings are not used.
    pub fn of(runs: &[LagRun<'_>]) -> Result<Self, NoLag> {
        let (grids, columns) = Grids::of(runs)?;
        let models = columns.into_par_iter().map(|columns| Model::of(&grids, columns)).collect();
        Ok(Self { grids, models })
    }

    /// Measures the lag of each output of the recordings behind the reference load. The recordings are those of the
    /// equations.
    pub fn lags(
        &self,
        runs: &[LagRun<'_>],
        progress: &Progress,
    ) -> Result<Vec<Result<Lag, NoLag>>, Cancelled> {
        let of_output = |output: usize| {
            progress.check()?;
            Ok(self.lag(runs, output))
        };
        (0..runs.first().map_or(0, LagRun::n_outputs)).into_par_iter().map(of_output).collect()
    }

    fn lag(&self, runs: &[LagRun<'_>], output: usize) -> Result<Lag, NoLag> {
        let grids = &self.grids;
        let output = &grids.output(runs, output);
        let delays = self.models.iter().map(|model| {
            let fit = Fit { grids, model, output };
            let delay = fit.fitted(LagKind::Delay, 0.0);
            (fit, delay)
        });
        let left = |delay: &Option<Fitted>| {
            delay.as_ref().map_or(f64::INFINITY, |delay| delay.block_squares.iter().sum())
        };
        let best = delays.min_by(|a, b| left(&a.1).total_cmp(&left(&b.1)));
        let (fit, delay) = best.expect("the play operators have at least one possible input");
        let start = delay.as_ref().map_or(0.0, |delay| delay.seconds);
        let instead = |reason| if grids.moves_in_jumps() { NoLag::Jumps } else { reason };
        if delay.as_ref().is_some_and(|delay| delay.own_share < LEAST_SHARE) {
            return Err(instead(NoLag::OneRate));
        }
        // A low-pass is tried only if the delay is at least one sample. A shorter delay looks like a low-pass, and a time
        // constant cannot be negative.
        let is_open = delay.as_ref().is_none_or(|delay| delay.seconds >= grids.step_secs);
        let first = is_open.then(|| fit.fitted(LagKind::FirstOrder, start)).flatten();
        let (kind, kind_is_known, found) =
            chosen(delay, first, grids.step_secs).ok_or(instead(NoLag::NotFound))?;
        let uncertainty_secs = 2.0 * found.standard_error_secs;
        if found.is_creep && found.seconds.abs() > uncertainty_secs {
            return Err(instead(NoLag::Creep));
        }
        if found.own_share < LEAST_SHARE {
            return Err(instead(NoLag::OneRate));
        }
        let is_bounded = uncertainty_secs <= MOST_SAMPLES * grids.step_secs
            || uncertainty_secs <= MOST_SHARE * found.seconds.abs();
        if !is_bounded {
            return Err(instead(NoLag::Uncertain { uncertainty_secs }));
        }
        Ok(Lag {
            kind,
            kind_is_known,
            seconds: found.seconds,
            samples: found.seconds / grids.step_secs,
            standard_error_secs: found.standard_error_secs,
            is_steady: grids.slow_secs > STEADY * grids.step_secs,
            explained_error_share: found.explained_error_share,
        })
    }
}

/// Measures the lag of each output behind the reference load. All recordings `runs` must have the same axes, gauges and
/// outputs.
pub fn lags(
    runs: &[LagRun<'_>],
    progress: &Progress,
) -> Result<Vec<Result<Lag, NoLag>>, Cancelled> {
    match LagEquations::of(runs) {
        Ok(equations) => equations.lags(runs, progress),
        Err(reason) => Ok(vec![Err(reason); runs.first().map_or(0, LagRun::n_outputs)]),
    }
}

/// Measures the lag of one output behind the reference load, in each recording of `runs` separately.
pub fn lag_by_run(runs: &[LagRun<'_>], output: usize) -> Vec<Result<Lag, NoLag>> {
    runs.par_iter().map(|run| lag_of(std::slice::from_ref(run), output)).collect()
}

/// Measures the lag of one output behind the reference load, in all recordings together. Returns [`NoLag`] if they do not
/// determine it.
pub fn lag_of(runs: &[LagRun<'_>], output: usize) -> Result<Lag, NoLag> {
    LagEquations::of(runs)?.lag(runs, output)
}

/// Returns the lag of the kind with the smaller residual, and true if the other kind is significantly worse. Without a
/// significant difference, it returns the delay and false.
fn chosen(
    delay: Option<Fitted>,
    first: Option<Fitted>,
    step_secs: f64,
) -> Option<(LagKind, bool, Fitted)> {
    // A low-pass with a time constant of zero is left out, because it is no lag.
    let first = first.filter(|first| first.seconds > 0.0);
    match (delay, first) {
        (Some(delay), Some(first)) => {
            let t = solve::paired_t(&delay.block_squares, &first.block_squares);
            if t > 2.0 {
                Some((LagKind::FirstOrder, true, first))
            } else {
                Some((LagKind::Delay, t < -2.0, delay))
            }
        }
        (Some(delay), None) => Some((LagKind::Delay, delay.seconds < -step_secs, delay)),
        (None, Some(first)) => Some((LagKind::FirstOrder, true, first)),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests;
