//! Inputs of the metrology rows: checked loads, dwells and time lags.

use std::ops::Range;

use rayon::prelude::*;

use crate::{
    calibration::LARGEST,
    column::column,
    progress::{Cancelled, Progress},
    questions::metrology::figures::{
        Figure, MetrologyError, MetrologySettings, OUTPUTS, Place, Reason, Rules, Run, Value,
        check_per_axis,
    },
    recording::Axis,
    scoring::{
        holds::{Hold, holds},
        lag::{Lag, LagEquations, LagRun, NoLag},
    },
};

/// Size of a figure from which it counts as more than noise, in standard deviations of the noise.
const SIGNIFICANT: f64 = 3.0;
/// Smallest noise that can hide a figure, as a share of full scale. Less is rounding.
const LEAST_NOISE: f64 = 1e-6;

/// Time lag of each axis behind its reference load, for each output.
pub type Lags = [Vec<Result<Lag, NoLag>>; OUTPUTS];

/// A recording with its loads, and its reference load as one column for each axis.
#[derive(Debug)]
pub struct Columns<'a> {
    pub run: Run<'a>,
    /// Reference load of each axis of the table; `None` if the recording has no reference for the axis.
    pub loads: Vec<Option<Vec<f64>>>,
}

impl<'a> Columns<'a> {
    fn of(run: Run<'a>, axes: &[Axis]) -> Result<Self, MetrologyError> {
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
        let load = |axis: &Axis| {
            let at = run.reference_axes.iter().position(|known| known == axis)?;
            Some(column(run.reference, run.reference_axes.len(), at).collect())
        };
        Ok(Self { loads: axes.iter().map(load).collect(), run })
    }
}

/// Measures the time lags of the uncompensated and the compensated load in recordings with these axes. They are measured
/// together, because they share the slow part of the model: the states of hysteresis and creep that follow from the reference.
///
/// # Errors
/// [`Cancelled`] if `progress` is cancelled.
pub fn lags_of(runs: &[Run<'_>], axes: &[Axis], progress: &Progress) -> Result<Lags, Cancelled> {
    let of_outputs: [Vec<_>; OUTPUTS] = std::array::from_fn(|output| {
        runs.iter().filter_map(|run| run.lag_run(axes, output)).collect()
    });
    let equations = match LagEquations::of(&of_outputs[0]) {
        Ok(equations) => equations,
        Err(reason) => return Ok(std::array::from_fn(|_| vec![Err(reason); axes.len()])),
    };
    let [conventional, compensated] = of_outputs.map(|runs| equations.lags(&runs, progress));
    Ok([conventional?, compensated?])
}

#[derive(Debug)]
pub struct Measured<'a> {
    pub axes: &'a [Axis],
    pub full_scale: &'a [f64],
    pub settings: &'a MetrologySettings,
    pub runs: Vec<Columns<'a>>,
    pub reversal_thresholds: Vec<f64>,
    /// Dwells of each recording, in which the loads of all axes with a reference are still. In a table without times, each
    /// reading is a dwell.
    pub holds: Vec<Vec<Hold>>,
    /// Dwells of any duration of each recording, such as the steps of a staircase.
    pub steps: Vec<Vec<Hold>>,
    /// Largest movement of each axis in a dwell, in its unit.
    pub still: Vec<f64>,
}

impl<'a> Measured<'a> {
    pub fn of(runs: &[Run<'a>], rules: &Rules<'a>) -> Result<Self, MetrologyError> {
        let Rules { axes, full_scale, settings, .. } = *rules;
        settings.validate(axes.len())?;
        check_per_axis("full scale", full_scale, axes.len())?;
        let columns = runs.par_iter().map(|run| Columns::of(*run, axes));
        let runs = columns.collect::<Result<Vec<_>, _>>()?;
        let all = 0..axes.len();
        let reversal_thresholds = all.clone().map(|at| rules.reversal_threshold(at)).collect();
        let still: Vec<f64> = all.map(|at| rules.still(at)).collect();
        let dwells = |shortest_secs: f64| {
            let of_run = |Columns { run, loads }: &Columns<'_>| {
                let known = loads.iter().zip(&still);
                let (loads, bands): (Vec<&[f64]>, Vec<f64>) =
                    known.filter_map(|(loads, band)| Some((loads.as_deref()?, *band))).unzip();
                if run.is_table && !loads.is_empty() {
                    let level = |row| loads.iter().map(|loads| loads[row]).collect();
                    let reading = |row| Hold { samples: row..row + 1, level: level(row) };
                    return (0..run.times.len()).map(reading).collect();
                }
                if loads.is_empty() || run.is_static {
                    return Vec::new();
                }
                holds(run.times, &loads, &bands, shortest_secs)
            };
            runs.par_iter().map(of_run).collect()
        };
        let (holds, steps) = (dwells(settings.hold_secs), dwells(0.0));
        Ok(Self { axes, full_scale, settings, runs, reversal_thresholds, holds, steps, still })
    }

    /// Returns the recordings with times and a reference for every axis, on which the time lag of an output is measured.
    pub fn lag_runs(&self, output: usize) -> Vec<LagRun<'_>> {
        let runs = self.runs.iter();
        runs.filter_map(|columns| columns.run.lag_run(self.axes, output)).collect()
    }

    /// Returns true if the load of every axis of the recording that has a reference is near zero in this dwell.
    pub fn is_at_zero(&self, run: usize, hold: &Hold) -> bool {
        let known = self.runs[run].loads.iter().zip(self.full_scale);
        let full_scales =
            known.filter_map(|(loads, full_scale)| loads.as_ref().map(|_| full_scale));
        let mut levels = hold.level.iter().zip(full_scales);
        levels.all(|(level, full_scale)| level.abs() <= self.settings.zero_share * full_scale)
    }

    /// Returns the samples of one axis, from all recordings with a reference for this axis.
    ///
    /// # Errors
    /// [`Reason`] if no recording has a reference for the axis, or if a number is not finite or too large.
    pub fn axis(&self, at: usize) -> Result<AxisView<'_>, Reason> {
        let axis = self.axes[at];
        let runs: Vec<AxisRun<'_>> = (self.runs.iter().enumerate())
            .filter_map(|(index, columns)| {
                Some(AxisRun {
                    index,
                    columns,
                    loads: columns.loads[at].as_deref()?,
                    // To save memory, an axis is copied to a column only while it is measured.
                    outputs: columns
                        .run
                        .outputs()
                        .map(|rows| column(rows, self.axes.len(), at).collect()),
                })
            })
            .filter(|run| !run.loads.is_empty())
            .collect();
        if runs.is_empty() {
            return Err(Reason::NoReference { axis });
        }
        for run in &runs {
            for values in [run.loads, &run.outputs[0], &run.outputs[1]] {
                check_numbers(axis, run.columns.run.name, values)?;
            }
        }
        Ok(AxisView {
            measured: self,
            axis,
            full_scale: self.full_scale[at],
            still: self.still[at],
            reversal_threshold: self.reversal_thresholds[at],
            runs,
        })
    }
}

/// Checks that a channel has finite numbers that are small enough to compute with.
pub fn check_numbers(axis: Axis, recording: &str, values: &[f64]) -> Result<(), Reason> {
    let usable = |value: &f64| value.abs() <= LARGEST;
    match values.iter().position(|value| !usable(value)) {
        None => Ok(()),
        Some(sample) if values[sample].is_finite() => Err(Reason::Overflow { axis }),
        Some(sample) => Err(Reason::NotFinite { axis, recording: recording.to_owned(), sample }),
    }
}

/// Samples of one axis, in all recordings with a reference for the axis.
#[derive(Debug)]
pub struct AxisView<'a> {
    pub measured: &'a Measured<'a>,
    pub axis: Axis,
    pub full_scale: f64,
    /// Largest movement of the load in a dwell (N or N·m).
    pub still: f64,
    pub reversal_threshold: f64,
    pub runs: Vec<AxisRun<'a>>,
}

#[derive(Debug)]
pub struct AxisRun<'a> {
    pub index: usize,
    pub columns: &'a Columns<'a>,
    pub loads: &'a [f64],
    pub outputs: [Vec<f64>; OUTPUTS],
}

impl AxisRun<'_> {
    pub fn times(&self) -> &[f64] {
        self.columns.run.times
    }

    pub fn errors(
        &self,
        output: usize,
        samples: Range<usize>,
    ) -> impl Iterator<Item = f64> + Clone {
        let outputs = &self.outputs[output][samples.clone()];
        outputs.iter().zip(&self.loads[samples]).map(|(output, load)| output - load)
    }

    pub fn place(&self, samples: Range<usize>) -> Place {
        self.columns.run.place(self.index, samples)
    }

    pub fn reaches(&self, size: f64, samples: Range<usize>) -> bool {
        self.loads[samples].iter().any(|load| load.abs() >= size)
    }
}

impl AxisView<'_> {
    /// Returns a figure without the part of its size that noise with this standard deviation adds.
    ///
    /// # Errors
    /// [`Reason::BelowNoise`] if the noise alone could give this size.
    pub fn above_noise(&self, size: f64, noise: f64, place: Option<Place>) -> Figure {
        let limit = SIGNIFICANT * noise;
        if size <= limit && limit > LEAST_NOISE * self.full_scale {
            let percent = (self.full_scale > 0.0).then(|| 100.0 * limit / self.full_scale);
            return Err(Reason::BelowNoise { axis: self.axis, limit, percent });
        }
        let value = (size * size - noise * noise).max(0.0).sqrt();
        Ok(Value { uncertainty: Some(noise), ..Value::at(value, place) })
    }

    /// Returns the smallest load (N or N·m) at which this axis counts as loaded.
    pub fn loaded_from(&self) -> Result<f64, Reason> {
        if self.full_scale > 0.0 {
            Ok(self.measured.settings.loaded_share * self.full_scale)
        } else {
            Err(Reason::NoFullScale { axis: self.axis })
        }
    }
}
