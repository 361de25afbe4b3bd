//! Inputs of the metrology figures (recordings with their loads), and the computed figures.

use std::ops::Range;

use serde::{Serialize, Serializer};

use crate::{
    calibration::AppliedLoads,
    finding::Finding,
    questions::metrology::{
        quantity::{Definition, Quantity},
        reason::Reason,
    },
    recording::{AuxiliaryTable, Axis, Recording},
    scoring::lag::LagRun,
};

/// One recording, with the loads that a calibration computes from it.
///
/// **Shapes** reference `n × reference_axes` row-major, conventional and compensated `n × n_axes` row-major, where the
/// `n_axes` axes are those of the metrology table.
///
/// **Units** times in s, forces in N, moments in N·m.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// Name of the recording.
    pub name: &'a str,
    /// Times of the samples (s).
    pub times: &'a [f64],
    /// Gauge channels, row-major; may be empty. From them, the measurement of the time lag finds which gauges have
    /// hysteresis.
    pub gauges: &'a [f64],
    /// Axes whose reference load is known; empty without reference loads.
    pub reference_axes: &'a [Axis],
    /// Reference load of each sample (N or N·m).
    pub reference: &'a [f64],
    /// Uncompensated load of each sample (N or N·m).
    pub conventional: &'a [f64],
    /// Compensated load of each sample (N or N·m).
    pub compensated: &'a [f64],
    /// Auxiliary channels, such as a temperature.
    pub auxiliary: Option<&'a AuxiliaryTable>,
    /// True if the samples are load cases without times.
    pub is_static: bool,
}

impl<'a> Run<'a> {
    /// Returns a recording with the loads that a calibration computes from it.
    pub fn new(recording: &'a Recording, applied: &'a AppliedLoads) -> Self {
        Self {
            name: recording.name(),
            times: recording.times(),
            gauges: recording.gauges(),
            reference_axes: recording.axes(),
            reference: recording.loads(),
            conventional: &applied.conventional,
            compensated: &applied.compensated,
            auxiliary: Some(recording.auxiliary()),
            is_static: recording.is_static(),
        }
    }
}

impl<'a> Run<'a> {
    /// Returns the uncompensated and the compensated loads, row-major.
    pub(crate) fn outputs(&self) -> [&'a [f64]; OUTPUTS] {
        [self.conventional, self.compensated]
    }

    /// Returns the samples in which the time lag of an output is measured; `None` without times, or unless the recording has a
    /// reference for exactly these axes.
    pub(crate) fn lag_run(&self, axes: &[Axis], output: usize) -> Option<LagRun<'a>> {
        let is_usable = !self.is_static && *self.reference_axes == *axes;
        is_usable.then_some(LagRun {
            times: self.times,
            gauges: self.gauges,
            loads: self.reference,
            outputs: self.outputs()[output],
        })
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

/// Number of outputs of the sensor that are compared: the uncompensated, then the compensated load.
pub const OUTPUTS: usize = 2;

/// Interval of a recording from which a figure is computed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Index of the recording in the list of runs.
    pub recording: usize,
    /// Name of the recording.
    pub name: String,
    /// Time of the first sample in the interval (s).
    pub from_secs: f64,
    /// Time of the last sample in the interval (s).
    pub to_secs: f64,
    /// Samples of the recording in the interval.
    #[serde(skip)]
    pub samples: Range<usize>,
}

/// Metrology figure, whose value is a finite number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Value {
    /// Value of the figure, in the unit of its table cell.
    pub value: f64,
    /// Value in % of full scale; `None` for times, and for an axis without a full scale.
    pub percent_fs: Option<f64>,
    /// Interval of a recording that the figure comes from; `None` for a figure of all samples.
    pub place: Option<Place>,
    /// Standard uncertainty of the value by noise, in its unit; `None` if it was not measured.
    pub uncertainty: Option<f64>,
    /// Load cycles from which the figure is computed; `None` for a figure that does not come from loops.
    pub basis: Option<Basis>,
}

impl Value {
    /// Returns a figure that was computed from all samples, still without its percentage of full scale.
    pub(crate) fn everywhere(value: f64) -> Self {
        Self::at(value, None)
    }

    /// Returns a figure that was computed from an interval of a recording, still without its percentage of full scale.
    pub(crate) fn at(value: f64, place: Option<Place>) -> Self {
        Self { value, percent_fs: None, place, uncertainty: None, basis: None }
    }
}

/// Cycles from which a loop figure is computed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Basis {
    /// Number of load cycles from which the figure is computed.
    pub n_cycles: usize,
    /// Share of the axis' load range that all these cycles have in common.
    pub range_share: f64,
}

/// A metrology figure, or the reason why there is none.
pub type Figure = Result<Value, Reason>;

/// Table cell with the figures of one quantity and one axis.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    /// Axis of the cell.
    pub axis: Axis,
    /// Unit of the two figures.
    pub unit: &'static str,
    /// Figure of the uncompensated load.
    #[serde(serialize_with = "figure")]
    pub conventional: Figure,
    /// Figure of the compensated load.
    #[serde(serialize_with = "figure")]
    pub compensated: Figure,
}

/// One row of the table of metrology figures.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Quantity that the row shows, such as hysteresis.
    #[serde(skip)]
    pub quantity: Quantity,
    /// Definition of the quantity that the row shows.
    #[serde(flatten)]
    pub definition: Definition,
    /// One table cell per axis, in axis order.
    pub cells: Vec<Cell>,
}

/// Table of metrology figures.
#[derive(Debug, Serialize)]
pub struct Metrology {
    /// Axes in the order of the cells of each row.
    pub axes: Vec<Axis>,
    /// Full scale of each axis (N or N·m); 0 without a full scale.
    pub full_scale: Vec<f64>,
    /// For each axis, the smallest change of the load that counts as a reversal (N or N·m).
    pub reversal_thresholds: Vec<f64>,
    /// Number of recordings that the table covers.
    pub n_recordings: usize,
    /// Number of samples of all recordings.
    pub n_samples: usize,
    /// Findings about the recordings that the table covers.
    pub findings: Vec<Finding>,
    /// Rows of the table, always in the same order.
    pub rows: Vec<Row>,
}

impl Metrology {
    /// Returns the rows that tables show: those with a figure of at least one axis, or with one below noise. If no row has a
    /// figure, all rows are returned, so that the tables show the reasons. Files contain all rows, with the reasons.
    pub(crate) fn shown_rows(&self) -> impl Iterator<Item = &Row> {
        let has_figure = |row: &Row| {
            row.cells.iter().any(|cell| {
                [&cell.conventional, &cell.compensated]
                    .into_iter()
                    .any(|figure| matches!(figure, Ok(_) | Err(Reason::BelowNoise { .. })))
            })
        };
        let is_empty = !self.rows.iter().any(has_figure);
        self.rows.iter().filter(move |row| is_empty || has_figure(row))
    }

    /// Returns the name and the definition of each row. All crosstalk rows share the definition of the first loaded axis.
    pub fn definitions(&self) -> impl Iterator<Item = (String, &Definition)> {
        self.rows.iter().filter_map(|Row { quantity, definition, .. }| {
            match quantity.crosstalk_from() {
                None => Some((definition.name.clone(), definition)),
                Some(from) if from == self.axes[0] => {
                    Some((definition.name.replace(&format!(" from {from}"), ""), definition))
                }
                Some(_) => None,
            }
        })
    }
}

pub type Found<T> = Result<T, Reason>;

/// Serialises `value`, `percent_fs`, `uncertainty`, `place`, `basis` and `reason` of a figure. Missing fields are null.
pub fn figure<S: Serializer>(figure: &Figure, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Written<'a> {
        #[serde(flatten)]
        value: &'a Value,
        reason: Option<String>,
    }
    let none = Value::everywhere(f64::NAN); // JSON has null for a number that is not finite
    Written {
        value: figure.as_ref().unwrap_or(&none),
        reason: figure.as_ref().err().map(Reason::to_string),
    }
    .serialize(serializer)
}
