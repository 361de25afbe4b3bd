//! What is measured, and the figures that come of it.

use std::ops::Range;

use serde::{Serialize, Serializer};

use crate::calibration::AppliedLoads;
use crate::questions::metrology::quantity::{Definition, Quantity};
use crate::questions::metrology::reason::Reason;
use crate::recording::{Axis, Recording};
use crate::scoring::numbers::significant;

/// One recording with what a calibration makes of it.
///
/// **Shapes** reference `n × reference_axes` row-major, conventional and compensated `n × n_axes` row-major, with the axes
/// of the table.
///
/// **Units** times (s), loads (N) and (N·m).
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// The recording's name.
    pub name: &'a str,
    /// Sample times.
    pub times: &'a [f64],
    /// The gauge channels, row-major; they say what has hysteresis. May be empty.
    pub gauges: &'a [f64],
    /// The axes whose reference load is known; empty without a reference.
    pub reference_axes: &'a [Axis],
    /// The load that was really applied.
    pub reference: &'a [f64],
    /// Conv.
    pub conventional: &'a [f64],
    /// Comp.
    pub compensated: &'a [f64],
    /// Whether the samples have no times, being rows of load cases.
    pub is_static: bool,
}

impl<'a> Run<'a> {
    /// A recording with the loads that a calibration gave for it.
    pub fn new(recording: &'a Recording, applied: &'a AppliedLoads) -> Self {
        Self {
            name: recording.name(),
            times: recording.times(),
            gauges: recording.gauges(),
            reference_axes: recording.axes(),
            reference: recording.loads(),
            conventional: &applied.conventional,
            compensated: &applied.compensated,
            is_static: recording.is_static(),
        }
    }
}

/// An interval of a recording that a figure comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Which of the runs it is in.
    pub recording: usize,
    /// Its name.
    pub name: String,
    /// Time of the first sample.
    pub from_secs: f64,
    /// Time of the last sample.
    pub to_secs: f64,
    /// The samples.
    #[serde(skip)]
    pub samples: Range<usize>,
}

/// A figure; always finite.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Value {
    /// In the unit of its cell.
    pub value: f64,
    /// In % of full scale; `None` for times, and for an axis without a full scale.
    pub percent_fs: Option<f64>,
    /// Where it comes from; `None` for what all samples give.
    pub place: Option<Place>,
    /// What it rests on, where it comes from loops.
    pub basis: Option<Basis>,
}

/// How many cycles a figure of loops rests on, and how far it depends on what counts as a reversal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Basis {
    /// How many cycles.
    pub n_cycles: usize,
    /// The loads that they have in common, as a share of all loads of the axis.
    pub range_share: f64,
    /// The figure with half the dead band; `None` where there is none then.
    pub dead_band_halved: Option<f64>,
    /// The figure with twice the dead band.
    pub dead_band_doubled: Option<f64>,
}

impl Basis {
    /// Before it is known what other dead bands would give.
    pub(crate) fn new(n_cycles: usize, range_share: f64) -> Self {
        Self { n_cycles, range_share, dead_band_halved: None, dead_band_doubled: None }
    }
}

/// A figure, or why there is none.
pub type Figure = std::result::Result<Value, Reason>;

/// The figures of one row and axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// The axis.
    pub axis: Axis,
    /// The unit of `value`.
    pub unit: &'static str,
    /// Conv.
    #[serde(serialize_with = "figure")]
    pub conventional: Figure,
    /// Comp.
    #[serde(serialize_with = "figure")]
    pub compensated: Figure,
}

/// One row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Which.
    #[serde(skip)]
    pub quantity: Quantity,
    /// What it means.
    #[serde(flatten)]
    pub definition: Definition,
    /// One per axis, in axis order.
    pub cells: Vec<Cell>,
}

/// Something to know about the whole table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Note {
    #[error(
        "{} reaches {} {}, beyond its full scale of {} {}; enter the rated load",
        .axis.symbol(), significant(*.reaches, 4), .axis.unit(), significant(*.full_scale, 4), .axis.unit()
    )]
    BeyondFullScale { axis: Axis, reaches: f64, full_scale: f64 },
    #[error("{} has no full scale, so nothing of it is in percent; enter one", .axis.symbol())]
    NoFullScale { axis: Axis },
    #[error(
        "the largest cycle of {} spans {:.0} % of all its loads only; record it from the least to the greatest load and back in one run",
        .axis.symbol(), 100.0 * .share
    )]
    SmallCycle { axis: Axis, share: f64 },
    #[error(
        "{} of the conventional calibration comes {} s after the reference; this lag, and not hysteresis, makes {:.0} % of the mean width. If one clock is late, set its offset where the file is read; if the sensor is slow, a fixed lag or a look-back can make up for it, or a faster amplifier",
        .axis.symbol(), significant(*.seconds, 3), 100.0 * .share
    )]
    Lag { axis: Axis, seconds: f64, share: f64 },
    #[error("{count} of {all} recordings have no reference load and take no part")]
    WithoutReference { count: usize, all: usize },
}

impl Serialize for Note {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metrology {
    /// Axes in the order of the cells.
    pub axes: Vec<Axis>,
    /// Full scale per axis, in its unit; 0 where there is none.
    pub full_scale: Vec<f64>,
    /// The dead band that was used per axis, in its unit.
    pub dead_bands: Vec<f64>,
    /// How many recordings there are.
    pub n_recordings: usize,
    /// How many samples they have.
    pub n_samples: usize,
    /// What to know before reading on.
    pub notes: Vec<Note>,
    /// In a fixed order.
    pub rows: Vec<Row>,
}

impl Metrology {
    /// The rows but those of crosstalk, which read better as a table of their own.
    pub fn own_rows(&self) -> impl Iterator<Item = &Row> {
        let rows = self.rows.iter();
        rows.filter(|row| row.quantity.crosstalk_from().is_none())
    }

    /// The rows of crosstalk, with the axis that is loaded.
    pub fn crosstalk_rows(&self) -> impl Iterator<Item = (Axis, &Row)> {
        let rows = self.rows.iter();
        rows.filter_map(|row| Some((row.quantity.crosstalk_from()?, row)))
    }

    /// The definitions of all rows, those of crosstalk once for all axes, with what they define.
    pub fn definitions(&self) -> impl Iterator<Item = (&str, &Definition)> {
        let first = self.crosstalk_rows().next().map(|(axis, _)| axis);
        let rows = self.rows.iter();
        rows.filter_map(move |row| {
            let is_again = row.quantity.crosstalk_from().is_some_and(|from| Some(from) != first);
            let name = row.quantity.general_name().unwrap_or(&row.definition.name);
            (!is_again).then_some((name, &row.definition))
        })
    }
}

pub(crate) type Result<T> = std::result::Result<T, Reason>;

/// A figure before it knows its full scale.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) size: f64,
    pub(crate) place: Option<Place>,
    pub(crate) basis: Option<Basis>,
}

impl Found {
    /// Of all samples.
    pub(crate) fn everywhere(size: f64) -> Self {
        Self::at(size, None)
    }

    pub(crate) fn at(size: f64, place: Option<Place>) -> Self {
        Self { size, place, basis: None }
    }
}

/// `value`, `percent_fs`, `place`, `basis` and `reason`; what is not there is null.
pub(crate) fn figure<S: Serializer>(
    figure: &Figure,
    serializer: S,
) -> std::result::Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Written<'a> {
        value: Option<f64>,
        percent_fs: Option<f64>,
        place: Option<&'a Place>,
        basis: Option<Basis>,
        reason: Option<String>,
    }
    let value = figure.as_ref().ok();
    Written {
        value: value.map(|value| value.value),
        percent_fs: value.and_then(|value| value.percent_fs),
        place: value.and_then(|value| value.place.as_ref()),
        basis: value.and_then(|value| value.basis),
        reason: figure.as_ref().err().map(Reason::to_string),
    }
    .serialize(serializer)
}
