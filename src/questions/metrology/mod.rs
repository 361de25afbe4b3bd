//! Metrology figures per axis, conventional beside compensated.
//!
//! [`table_by`] takes recordings with what a calibration makes of them and gives one row per [`Quantity`], each with its
//! definition and source. Where the data cannot give a figure, a [`Reason`] stands in its place: a sentence, never a
//! number that means nothing, and never NaN.
//!
//! **Source** OIML R 60 and VDI/VDE 2638 (errors over full scale rather than over the reading), and the glossaries of
//! load-cell makers; each row names its own. Full scale is the rated load that the user entered, else what the recordings
//! reach (see [`full_scale_of`](crate::recording::full_scale_of)).
//!
//! **What a free-running recording does not meet** Standards load one axis alone, from nothing to the rated load and back, in
//! steps, after preloading, and read at set times; temperature is kept. A recording of a moving robot loads several axes at
//! once, at no set speed, turns where it likes, and seldom dwells. So hysteresis holds what other axes add at equal load,
//! creep and viscosity add to width, and nonlinearity is that of a branch between two turns. Cycles are counted by rainflow;
//! each figure of loops says on how many it rests, over which share of the loads, and what half and twice the dead band would
//! give ([`Basis`]). The figures compare two calibrations on the same data fairly; they do not replace a
//! calibration in steps on a reference machine. [`Definition::free_running`] says it row by row.

mod case_rows;
mod crosstalk;
mod dwell_rows;
mod dwells;
mod errors;
mod loop_rows;
mod measured;
mod quantity;
mod reason;
mod settings;
pub(crate) mod shown;

use std::ops::Range;

use rayon::prelude::*;
use serde::{Serialize, Serializer};

use crate::calibration::AppliedLoads;
use crate::questions::metrology::crosstalk::{Alone, Response, crosstalk_figure, intervals_alone};
use crate::questions::metrology::dwell_rows::DwellRows;
use crate::questions::metrology::errors::error_figures;
use crate::questions::metrology::loop_rows::LoopRows;
use crate::questions::metrology::measured::{AxisView, Measured, OUTPUTS};
use crate::recording::{Axis, Recording};
use crate::scoring::MANY_SAMPLES;
use crate::scoring::numbers::significant;

pub(crate) use dwells::Dwell;
pub use dwells::dwells;
pub(crate) use measured::{check_numbers, joined};
pub(crate) use quantity::{Definition, Quantity};
pub(crate) use reason::Reason;
pub(crate) use settings::MetrologyError;
pub use settings::{MetrologySettings, Rules, extents_of, extents_of_set};
pub use shown::crosstalk;
pub(crate) use shown::{axis_figures, figure_records, overview};

/// A load this much beyond full scale is worth a note …
const BEYOND: f64 = 1.2;
/// … and so is a largest cycle of less than this share of the range.
const SMALL: f64 = 0.6;

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
            reference_axes: recording.axes(),
            reference: recording.loads(),
            conventional: &applied.conventional,
            compensated: &applied.compensated,
            is_static: recording.is_static(),
        }
    }
}

/// A interval of a recording that a figure comes from.
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
        Self {
            n_cycles,
            range_share,
            dead_band_halved: None,
            dead_band_doubled: None,
        }
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
    BeyondFullScale {
        axis: Axis,
        reaches: f64,
        full_scale: f64,
    },
    #[error("{} has no full scale, so nothing of it is in percent; enter one", .axis.symbol())]
    NoFullScale { axis: Axis },
    #[error(
        "the largest cycle of {} spans {:.0} % of all its loads only; record it from the least to the greatest load and back in one run",
        .axis.symbol(), 100.0 * .share
    )]
    SmallCycle { axis: Axis, share: f64 },
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
            let is_again = row
                .quantity
                .crosstalk_from()
                .is_some_and(|from| Some(from) != first);
            let name = row.quantity.general_name().unwrap_or(&row.definition.name);
            (!is_again).then_some((name, &row.definition))
        })
    }
}

type Result<T> = std::result::Result<T, Reason>;

/// A figure before it knows its full scale.
#[derive(Clone, Debug)]
struct Found {
    size: f64,
    place: Option<Place>,
    basis: Option<Basis>,
}

impl Found {
    /// Of all samples.
    fn everywhere(size: f64) -> Self {
        Self::at(size, None)
    }

    fn at(size: f64, place: Option<Place>) -> Self {
        Self {
            size,
            place,
            basis: None,
        }
    }
}

/// Makes the table of these runs by rules that others go by, too.
///
/// # Errors
/// [`MetrologyError`] where a choice is out of range or numbers do not fit together. What the data cannot give is no error
/// but a [`Reason`] in its cell.
pub fn table_by(
    runs: &[Run<'_>],
    rules: &Rules<'_>,
) -> std::result::Result<Metrology, MetrologyError> {
    let merged = LoadCases::of(runs);
    let measured = match &merged {
        Some(cases) => Measured::of(&[cases.run()], rules)?,
        None => Measured::of(runs, rules)?,
    };
    let (axes, full_scale) = (rules.axes, rules.full_scale);
    let alone = intervals_alone(&measured);
    let n_samples = runs.iter().map(|run| run.times.len()).sum();
    let of_axis = |axis| AxisFigures::of(&measured, &alone, axis);
    // Of many samples the lists of several axes at a time would fill the memory.
    let by_axis: Vec<AxisFigures> = match n_samples > MANY_SAMPLES {
        true => (0..axes.len()).map(of_axis).collect(),
        false => (0..axes.len()).into_par_iter().map(of_axis).collect(),
    };
    let rows = (Quantity::all(axes).into_iter().enumerate())
        .map(|(row, quantity)| {
            let cells = (0..axes.len()).map(|axis| {
                let figures = by_axis[axis].outputs.each_ref();
                let scale = full_scale[axis];
                let [conventional, compensated] =
                    figures.map(|all| finished(all[row].clone(), quantity, axes[axis], scale));
                Cell {
                    axis: axes[axis],
                    unit: if quantity.is_time() {
                        "s"
                    } else {
                        axes[axis].unit()
                    },
                    conventional,
                    compensated,
                }
            });
            Row {
                quantity,
                definition: quantity.definition(),
                cells: cells.collect(),
            }
        })
        .collect();
    Ok(Metrology {
        axes: axes.to_vec(),
        full_scale: full_scale.to_vec(),
        notes: notes(&measured, &by_axis),
        dead_bands: measured.dead_bands,
        n_recordings: runs.len(),
        n_samples,
        rows,
    })
}

/// All figures of one axis.
struct AxisFigures {
    /// In the order of [`Quantity::all`].
    outputs: [Vec<Result<Found>>; OUTPUTS],
    /// What the largest cycle spans, as a share of the range.
    cycle_share: Option<f64>,
}

impl AxisFigures {
    fn of(measured: &Measured<'_>, alone: &[Alone], axis: usize) -> Self {
        let n_axes = measured.axes.len();
        let view = match measured.axis(axis) {
            Ok(view) => view,
            Err(reason) => {
                let n_rows = Quantity::all(measured.axes).len();
                return Self {
                    outputs: std::array::from_fn(|_| vec![Err(reason.clone()); n_rows]),
                    cycle_share: None,
                };
            }
        };
        if measured.runs.iter().any(|run| run.is_static) {
            return Self::of_load_cases(measured, alone, axis, &view);
        }
        let [loops, halved, doubled] =
            [1.0, 0.5, 2.0].map(|factor| LoopRows::of(&view, factor * view.dead_band));
        let dwells = DwellRows::of(&view);
        let figures = |output| {
            let all = [&halved, &doubled].map(|other| other.figures(output));
            let mut of_loops = loops.figures(output);
            for (at, found) in of_loops.iter_mut().enumerate() {
                if let Ok(Found {
                    basis: Some(basis), ..
                }) = found
                {
                    let [halved, doubled] =
                        [0, 1].map(|other| all[other][at].as_ref().ok().map(|found| found.size));
                    (basis.dead_band_halved, basis.dead_band_doubled) = (halved, doubled);
                }
            }
            let crosstalk = [Response::AtFullLoad, Response::Largest].into_iter();
            let crosstalk = crosstalk.flat_map(|response| {
                let axes = (0..n_axes).map(move |loaded| (loaded, axis));
                axes.map(move |axes| crosstalk_figure(measured, alone, axes, response, output))
            });
            (of_loops.into_iter())
                .chain(dwells.figures(output))
                .chain(crosstalk)
                .chain(error_figures(&view, output))
                .collect()
        };
        Self {
            outputs: std::array::from_fn(figures),
            cycle_share: loops.share_of_range(),
        }
    }
}

impl AxisFigures {
    /// Of rows without times: what takes no order of samples, and the reason in place of the others.
    fn of_load_cases(
        measured: &Measured<'_>,
        alone: &[Alone],
        axis: usize,
        view: &AxisView<'_>,
    ) -> Self {
        let crosstalk =
            |axes, response, output| crosstalk_figure(measured, alone, axes, response, output);
        let figures = |output| {
            let rows = Quantity::all(measured.axes).into_iter();
            let mut errors = error_figures(view, output).into_iter();
            let figure = |quantity| match quantity {
                Quantity::BestFitNonlinearity => case_rows::nonlinearity(view, output),
                Quantity::Repeatability => case_rows::repeatability(view, output),
                Quantity::Crosstalk(from) | Quantity::CrosstalkDeviation(from) => {
                    let loaded = measured.axes.iter().position(|own| *own == from);
                    let response = match quantity {
                        Quantity::Crosstalk(_) => Response::AtFullLoad,
                        _ => Response::Largest,
                    };
                    crosstalk((loaded.unwrap_or(0), axis), response, output)
                }
                Quantity::Rmse | Quantity::LargestError | Quantity::Error95 => errors
                    .next()
                    .unwrap_or(Err(Reason::NoTimes { axis: view.axis })),
                _ => Err(Reason::NoTimes { axis: view.axis }),
            };
            rows.map(figure).collect()
        };
        Self {
            outputs: std::array::from_fn(figures),
            cycle_share: None,
        }
    }
}

/// The rows of all load cases as one run, in which the order says nothing.
struct LoadCases<'a> {
    axes: &'a [Axis],
    times: Vec<f64>,
    reference: Vec<f64>,
    conventional: Vec<f64>,
    compensated: Vec<f64>,
}

impl<'a> LoadCases<'a> {
    /// `None` where samples have times.
    fn of(runs: &[Run<'a>]) -> Option<Self> {
        let with_reference = || runs.iter().filter(|run| !run.reference_axes.is_empty());
        let is_static = runs.iter().any(|run| run.is_static);
        let axes = with_reference()
            .next()
            .filter(|_| is_static)?
            .reference_axes;
        let joined = |values: fn(&Run<'a>) -> &'a [f64]| -> Vec<f64> {
            let own = with_reference().filter(|run| run.reference_axes == axes);
            own.flat_map(values).copied().collect()
        };
        let n_rows = joined(|run| run.times).len();
        Some(Self {
            axes,
            times: (0..n_rows).map(|row| row as f64).collect(),
            reference: joined(|run| run.reference),
            conventional: joined(|run| run.conventional),
            compensated: joined(|run| run.compensated),
        })
    }

    fn run(&self) -> Run<'_> {
        Run {
            name: "all load cases",
            times: &self.times,
            reference_axes: self.axes,
            reference: &self.reference,
            conventional: &self.conventional,
            compensated: &self.compensated,
            is_static: true,
        }
    }
}

fn finished(found: Result<Found>, quantity: Quantity, axis: Axis, full_scale: f64) -> Figure {
    let Found {
        size,
        place,
        mut basis,
    } = found?;
    let percent_fs = (!quantity.is_time() && full_scale > 0.0).then(|| 100.0 * size / full_scale);
    if !size.is_finite() || percent_fs.is_some_and(|percent| !percent.is_finite()) {
        return Err(Reason::Overflow { axis });
    }
    if let Some(basis) = &mut basis {
        for other in [&mut basis.dead_band_halved, &mut basis.dead_band_doubled] {
            *other = other.filter(|size| size.is_finite());
        }
    }
    Ok(Value {
        value: size,
        percent_fs,
        place,
        basis,
    })
}

fn notes(measured: &Measured<'_>, by_axis: &[AxisFigures]) -> Vec<Note> {
    let bare = |run: &&measured::Columns<'_>| run.loads.iter().all(Option::is_none);
    let count = measured.runs.iter().filter(bare).count();
    let all = measured.runs.len();
    let missing = (count > 0).then_some(Note::WithoutReference { count, all });
    let of_axes = (by_axis.iter().enumerate()).flat_map(|(at, figures)| {
        let small = figures.cycle_share.filter(|share| *share < SMALL);
        let small = small.map(|share| Note::SmallCycle {
            axis: measured.axes[at],
            share,
        });
        full_scale_note(measured, at).into_iter().chain(small)
    });
    missing.into_iter().chain(of_axes).collect()
}

fn full_scale_note(measured: &Measured<'_>, at: usize) -> Option<Note> {
    let (axis, full_scale) = (measured.axes[at], measured.full_scale[at]);
    if full_scale == 0.0 {
        return Some(Note::NoFullScale { axis });
    }
    let loads = measured
        .runs
        .iter()
        .filter_map(|run| run.loads[at].as_ref());
    let reaches = loads
        .flatten()
        .fold(0.0_f64, |reaches, load| reaches.max(load.abs()));
    (reaches > BEYOND * full_scale).then_some(Note::BeyondFullScale {
        axis,
        reaches,
        full_scale,
    })
}

/// `value`, `percent_fs`, `place`, `basis` and `reason`; what is not there is null.
fn figure<S: Serializer>(figure: &Figure, serializer: S) -> std::result::Result<S::Ok, S::Error> {
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

#[cfg(test)]
pub(crate) mod tests;
