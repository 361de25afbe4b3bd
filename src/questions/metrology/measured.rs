//! Numbers behind the metrology figures, one column per axis and recording.

use crate::min_max::MinMax;
use std::ops::Range;
use std::sync::OnceLock;

use rayon::prelude::*;

use crate::progress::Progress;
use crate::questions::metrology::figures::{Place, Run};
use crate::questions::metrology::reason::Reason;
use crate::questions::metrology::settings::{
    MetrologyError, MetrologySettings, Rules, check_per_axis,
};
use crate::recording::Axis;
use crate::scoring::holds::{Hold, holds};
use crate::scoring::lag::{Lag, LagRun, NoLag, lags};

/// Uncompensated and compensated, in this order.
pub(crate) const OUTPUTS: usize = 2;

/// Lags of every axis, for each output.
pub(crate) type Lags = [Vec<Result<Lag, NoLag>>; OUTPUTS];

/// Largest valid load; the squares of larger ones could overflow.
const LARGEST: f64 = 1e100;

#[derive(Debug)]
pub(crate) struct Columns<'a> {
    pub(crate) name: &'a str,
    pub(crate) is_static: bool,
    pub(crate) times: &'a [f64],
    /// Reference of each axis of the table; `None` if the run has no reference for it.
    pub(crate) loads: Vec<Option<Vec<f64>>>,
    /// Reference row-major, if all axes of the table have one and samples have times.
    reference: Option<&'a [f64]>,
    gauges: &'a [f64],
    /// Loads of each output, row-major. An axis is copied to a column only while it is measured, to save memory.
    outputs: [&'a [f64]; OUTPUTS],
}

impl<'a> Columns<'a> {
    fn of(run: &Run<'a>, axes: &[Axis]) -> Result<Self, MetrologyError> {
        let n = run.times.len();
        for (what, width, values) in [
            ("reference", run.reference_axes.len(), run.reference),
            ("conventional load", axes.len(), run.conventional),
            ("compensated load", axes.len(), run.compensated),
        ] {
            if values.len() != n * width {
                return Err(MetrologyError::Shape {
                    recording: run.name.to_owned(),
                    what,
                    expected: n * width,
                    actual: values.len(),
                });
            }
        }
        let position = |axis: &Axis| run.reference_axes.iter().position(|own| own == axis);
        Ok(Self {
            name: run.name,
            is_static: run.is_static,
            times: run.times,
            loads: axes
                .iter()
                .map(|axis| Some(column(run.reference, run.reference_axes.len(), position(axis)?)))
                .collect(),
            reference: (run.reference_axes == axes && !run.is_static).then_some(run.reference),
            gauges: run.gauges,
            outputs: [run.conventional, run.compensated],
        })
    }

    /// Returns the reference of every axis of the table; `None` if one is missing.
    pub(crate) fn all_loads(&self) -> Option<Vec<&[f64]>> {
        self.loads.iter().map(Option::as_deref).collect()
    }

    /// Returns the run for the measurement of an output's lag; `None` without times or without a reference for every axis.
    pub(crate) fn lag_run(&self, output: usize) -> Option<LagRun<'a>> {
        let (loads, outputs) = (self.reference?, self.outputs[output]);
        Some(LagRun { times: self.times, gauges: self.gauges, loads, outputs })
    }

    pub(crate) fn output(&self, output: usize, axis: usize, sample: usize) -> f64 {
        self.outputs[output][sample * self.loads.len() + axis]
    }

    pub(crate) fn place(&self, recording: usize, samples: Range<usize>) -> Place {
        Place {
            recording,
            name: self.name.to_owned(),
            from_secs: self.times[samples.start],
            to_secs: self.times[samples.end - 1],
            samples,
        }
    }
}

fn column(values: &[f64], width: usize, at: usize) -> Vec<f64> {
    values.iter().skip(at).step_by(width.max(1)).copied().collect()
}

#[derive(Debug)]
pub(crate) struct Measured<'a> {
    pub(crate) axes: &'a [Axis],
    pub(crate) full_scale: &'a [f64],
    pub(crate) settings: &'a MetrologySettings,
    pub(crate) runs: Vec<Columns<'a>>,
    pub(crate) reversal_thresholds: Vec<f64>,
    /// Dwells of each run, of all axes that have a reference.
    pub(crate) holds: Vec<Vec<Hold>>,
    lags: OnceLock<Lags>,
}

impl<'a> Measured<'a> {
    pub(crate) fn of(runs: &[Run<'a>], rules: &Rules<'a>) -> Result<Self, MetrologyError> {
        let Rules { axes, full_scale, settings, .. } = *rules;
        settings.validate(axes.len())?;
        check_per_axis("full scale", "full scales", full_scale, axes.len())?;
        let runs =
            (runs.par_iter()).map(|run| Columns::of(run, axes)).collect::<Result<Vec<_>, _>>()?;
        let all = 0..axes.len();
        let reversal_thresholds = all.clone().map(|at| rules.reversal_threshold(at)).collect();
        let still: Vec<f64> = all.map(|at| rules.still(at)).collect();
        let holds = (runs.par_iter())
            .map(|run| {
                let known = run.loads.iter().zip(&still);
                let (loads, bands): (Vec<&[f64]>, Vec<f64>) =
                    known.filter_map(|(loads, band)| Some((loads.as_deref()?, *band))).unzip();
                if loads.is_empty() || run.is_static {
                    return Vec::new();
                }
                holds(run.times, &loads, &bands, settings.hold_secs)
            })
            .collect();
        let lags = OnceLock::new();
        Ok(Self { axes, full_scale, settings, runs, reversal_thresholds, holds, lags })
    }

    /// Returns the time lag of each output, which the first call measures.
    pub(crate) fn lags(&self) -> &Lags {
        let of_output = |output| {
            let runs: Vec<LagRun<'_>> = self.lag_runs(output).collect();
            // This progress is never cancelled.
            let found = lags(&runs, &Progress::default()).unwrap_or_default();
            match found.is_empty() {
                true => vec![Err(NoLag::TooShort); self.axes.len()],
                false => found,
            }
        };
        self.lags.get_or_init(|| std::array::from_fn(of_output))
    }

    pub(crate) fn lag_runs(&self, output: usize) -> impl Iterator<Item = LagRun<'_>> {
        self.runs.iter().filter_map(move |run| run.lag_run(output))
    }

    /// Returns true if every axis of the run that has a reference is near zero in this dwell.
    pub(crate) fn is_at_zero(&self, run: usize, hold: &Hold) -> bool {
        let known = self.runs[run].loads.iter().zip(self.full_scale);
        let full_scales =
            known.filter_map(|(loads, full_scale)| loads.as_ref().map(|_| full_scale));
        let mut levels = hold.level.iter().zip(full_scales);
        levels.all(|(level, full_scale)| level.abs() <= self.settings.zero_share * full_scale)
    }

    /// Returns the samples of one axis, from the runs with a reference for this axis.
    ///
    /// # Errors
    /// [`Reason`] if there is none, or if a number cannot be used.
    pub(crate) fn axis(&self, at: usize) -> Result<AxisView<'_>, Reason> {
        let axis = self.axes[at];
        let runs: Vec<AxisRun<'_>> = (self.runs.iter().enumerate())
            .filter_map(|(index, run)| {
                Some(AxisRun {
                    index,
                    run,
                    loads: run.loads[at].as_deref()?,
                    outputs: run.outputs.map(|rows| column(rows, self.axes.len(), at)),
                })
            })
            .filter(|run| !run.loads.is_empty())
            .collect();
        if runs.is_empty() {
            return Err(Reason::NoReference { axis });
        }
        for run in &runs {
            for values in [run.loads, &run.outputs[0], &run.outputs[1]] {
                check_numbers(axis, run.run.name, values)?;
            }
        }
        Ok(AxisView {
            measured: self,
            axis,
            full_scale: self.full_scale[at],
            reversal_threshold: self.reversal_thresholds[at],
            runs,
        })
    }
}

pub(crate) fn check_numbers(axis: Axis, recording: &str, values: &[f64]) -> Result<(), Reason> {
    let usable = |value: &f64| value.abs() <= LARGEST;
    match values.iter().position(|value| !usable(value)) {
        None => Ok(()),
        Some(sample) if values[sample].is_finite() => Err(Reason::Overflow { axis }),
        Some(sample) => Err(Reason::NotFinite { axis, recording: recording.to_owned(), sample }),
    }
}

/// One axis, with finite numbers in at least one run.
#[derive(Debug)]
pub(crate) struct AxisView<'a> {
    pub(crate) measured: &'a Measured<'a>,
    pub(crate) axis: Axis,
    pub(crate) full_scale: f64,
    pub(crate) reversal_threshold: f64,
    pub(crate) runs: Vec<AxisRun<'a>>,
}

#[derive(Debug)]
pub(crate) struct AxisRun<'a> {
    pub(crate) index: usize,
    pub(crate) run: &'a Columns<'a>,
    pub(crate) loads: &'a [f64],
    pub(crate) outputs: [Vec<f64>; OUTPUTS],
}

impl AxisRun<'_> {
    pub(crate) fn errors(&self, output: usize, samples: Range<usize>) -> impl Iterator<Item = f64> {
        let outputs = &self.outputs[output][samples.clone()];
        outputs.iter().zip(&self.loads[samples]).map(|(output, load)| output - load)
    }

    pub(crate) fn place(&self, samples: Range<usize>) -> Place {
        self.run.place(self.index, samples)
    }

    pub(crate) fn reaches(&self, size: f64, samples: Range<usize>) -> bool {
        self.loads[samples].iter().any(|load| load.abs() >= size)
    }
}

impl AxisView<'_> {
    pub(crate) fn range(&self) -> MinMax {
        self.runs.iter().flat_map(|run| run.loads).collect()
    }

    /// Returns the load from which this axis counts as loaded.
    ///
    /// # Errors
    /// [`Reason`] if the axis has no full scale.
    pub(crate) fn loaded_from(&self) -> Result<f64, Reason> {
        if self.full_scale > 0.0 {
            Ok(self.measured.settings.loaded_share * self.full_scale)
        } else {
            Err(Reason::NoFullScale { axis: self.axis })
        }
    }
}
