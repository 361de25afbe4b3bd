//! Metrology figures: their definitions, their inputs (recordings with loads, and settings), the computed figures, and the
//! reasons that take the place of a missing figure.

use std::borrow::Cow;
use std::mem::discriminant;
use std::ops::Range;

use serde::{Deserialize, Serialize, Serializer};

use crate::{
    calibration::AppliedLoads,
    finding::Finding,
    recording::{AuxiliaryTable, Axis, Recording},
    scoring::{
        holds::NoTimeConstant,
        lag::{LagRun, NoLag},
        loops::{FEWEST_CYCLES, FULL_SHARE, LoadExtent, MOST, NOISE_FACTOR},
        numbers::significant,
    },
    shown::counted,
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
    /// True if the samples have no times.
    pub is_static: bool,
    /// True if the samples are load cases without an order, so that they have no branches.
    pub is_load_case: bool,
    /// True if the samples are readings of a table without times.
    pub is_table: bool,
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
            is_load_case: recording.is_load_case(),
            is_table: recording.is_table(),
        }
    }
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
    /// Value in % of full scale; `None` for times and sensitivities, and for an axis without a full scale.
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
    /// Returns the rows that tables show: those with a figure of at least one axis, or with one below its noise. If no row has a
    /// figure, all rows are returned, so that the tables show the reasons. Files contain all rows, with the reasons.
    pub(crate) fn shown_rows(&self) -> impl Iterator<Item = &Row> {
        let has_figure = |row: &Row| {
            row.cells.iter().any(|cell| {
                [&cell.conventional, &cell.compensated].into_iter().any(|figure| {
                    matches!(
                        figure,
                        Ok(_) | Err(Reason::BelowNoise { .. } | Reason::NoLagFound { .. })
                    )
                })
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

/// Settings of the metrology table.
///
/// | field | default | range | meaning |
/// |---|---|---|---|
/// | `reversal_thresholds` | none | ≥ 0 | reversal threshold per axis, in its unit; `None` computes it from noise and range |
/// | `hold_secs` | 5 s | > 0 | shortest dwell |
/// | `still_share` | 0.01 | 0 to 1 | in a dwell each axis stays within this share of its full scale, or ten times its noise |
/// | `zero_share` | 0.01 | 0 to 1 | at zero each axis is within this share of its full scale from zero |
/// | `loaded_share` | 0.5 | 0 to 1 | an axis counts as loaded from this share of its full scale |
/// | `alone_share` | 0.02 | 0 to 1 | an axis is loaded alone if all other axes are within this share of their full scales |
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MetrologySettings {
    /// Reversal threshold per axis, in axis order: the smallest change of load that counts as a reversal. Missing entries and
    /// `None` are computed from noise and range of the load ([`LoadExtent`]).
    #[serde(alias = "dead_bands")]
    pub reversal_thresholds: Vec<Option<f64>>,
    /// Shortest dwell (s).
    pub hold_secs: f64,
    /// Largest movement of a load that still counts as a dwell, as a share of full scale.
    pub still_share: f64,
    /// Largest load of an axis that counts as zero, as a share of full scale.
    pub zero_share: f64,
    /// Smallest load at which an axis counts as loaded, as a share of full scale.
    pub loaded_share: f64,
    /// Largest load of an axis that counts as unloaded while another axis is loaded alone, as a share of full scale.
    pub alone_share: f64,
}

impl Default for MetrologySettings {
    fn default() -> Self {
        Self {
            reversal_thresholds: Vec::new(),
            hold_secs: 5.0,
            still_share: 0.01,
            zero_share: 0.01,
            loaded_share: 0.5,
            alone_share: 0.02,
        }
    }
}

/// Rules that define loops, dwells and figures.
///
/// **Shapes** one full scale and one extent (noise and range of the load) per axis.
///
/// **Units** full scales in N and N·m; 0 if there is none.
#[derive(Clone, Copy, Debug)]
pub struct Rules<'a> {
    /// Axes of the calibration.
    pub axes: &'a [Axis],
    /// Full scale of each axis of the calibration.
    pub full_scale: &'a [f64],
    /// Metrology settings that the user chose.
    pub settings: &'a MetrologySettings,
    /// Noise and range of each load, for reversal thresholds that the user did not set; see
    /// [`extents_of_set`](crate::scoring::loops::extents_of_set).
    pub extents: &'a [LoadExtent],
}

impl Rules<'_> {
    /// Returns the reversal threshold of the axis at this position, in its unit.
    pub fn reversal_threshold(&self, at: usize) -> f64 {
        let chosen = self.settings.reversal_thresholds.get(at).copied().flatten();
        chosen.unwrap_or_else(|| self.extents.get(at).map_or(0.0, LoadExtent::reversal_threshold))
    }

    /// Returns the largest movement of the load within a dwell, for the axis at this position, in its unit.
    pub(crate) fn still(&self, at: usize) -> f64 {
        let noise = self.extents.get(at).map_or(0.0, |extent| extent.noise);
        (self.settings.still_share * self.full_scale[at]).max(NOISE_FACTOR * noise)
    }
}

#[derive(Debug, PartialEq, thiserror::Error)]
pub enum MetrologyError {
    #[error("{given} {what}s are given for {axes} axes; give one for each axis, in axis order")]
    Count { what: &'static str, given: usize, axes: usize },
    #[error("the {what} of axis {position} is {value}; enter a number of zero or above")]
    PerAxis { what: &'static str, position: usize, value: f64 },
    #[error("the shortest dwell is {value} s; enter a number above zero")]
    HoldSecs { value: f64 },
    #[error("{what} is {value}; enter a share of full scale, between 0 and 1")]
    Share { what: &'static str, value: f64 },
    #[error("{recording}: the {what} has {actual} numbers, but {expected} are needed")]
    Shape { recording: String, what: &'static str, expected: usize, actual: usize },
}

impl MetrologySettings {
    /// Checks that every setting is in its range.
    ///
    /// # Errors
    /// [`MetrologyError`] for the first setting that is out of range.
    pub fn validate(&self, n_axes: usize) -> Result<(), MetrologyError> {
        if !self.reversal_thresholds.is_empty() {
            let chosen: Vec<f64> =
                self.reversal_thresholds.iter().map(|band| band.unwrap_or(0.0)).collect();
            check_per_axis("reversal threshold", &chosen, n_axes)?;
        }
        if !(self.hold_secs > 0.0 && self.hold_secs.is_finite()) {
            return Err(MetrologyError::HoldSecs { value: self.hold_secs });
        }
        for (what, value) in [
            ("the stability tolerance of a dwell", self.still_share),
            ("the largest load that counts as zero", self.zero_share),
            ("the smallest load at which an axis counts as loaded", self.loaded_share),
            ("the largest load at which an axis counts as unloaded", self.alone_share),
        ] {
            if !(0.0..=1.0).contains(&value) {
                return Err(MetrologyError::Share { what, value });
            }
        }
        Ok(())
    }
}

/// Checks that `values` has one number for each axis, and that no number is below zero.
pub fn check_per_axis(
    what: &'static str,
    values: &[f64],
    n_axes: usize,
) -> Result<(), MetrologyError> {
    if values.len() != n_axes {
        return Err(MetrologyError::Count { what, given: values.len(), axes: n_axes });
    }
    match values.iter().position(|value| !(*value >= 0.0 && value.is_finite())) {
        None => Ok(()),
        Some(at) => Err(MetrologyError::PerAxis { what, position: at + 1, value: values[at] }),
    }
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Reason {
    #[error(
        "no recording has a reference load for {axis}; record this load in a column named {axis}"
    )]
    NoReference { axis: Axis },
    #[error(
        "{axis} stays between {} and {} {}, within the reversal threshold of {} {}; apply a larger load, or choose a smaller threshold", short(*.low), short(*.high), .axis.unit(), short(*.reversal_threshold), .axis.unit()
    )]
    ConstantLoad { axis: Axis, low: f64, high: f64, reversal_threshold: f64 },
    #[error(
        "the recordings have no times, so this figure of {axis} is not known; record a motion, with its times in a column t"
    )]
    NoTimes { axis: Axis },
    #[error("no load case of {axis} was measured twice, so the repeatability is unknown")]
    NoRepeats { axis: Axis },
    #[error("{axis} only {} in every recording, so there is no second branch; record a rising and a falling load", if *.rises { "rises" } else { "falls" })]
    OneBranch { axis: Axis, rises: bool },
    #[error(
        "{axis} has no cycle within a recording; record a rising and a falling load in one run"
    )]
    NoCycle { axis: Axis },
    #[error("this figure needs a rising load, but {axis} only falls; record a rising load")]
    NoRisingBranch { axis: Axis },
    #[error("the branch of {axis} has samples at only {found} loads; load the axis more slowly")]
    TooFewLoads { axis: Axis, found: usize },
    #[error(
        "{axis} has {} (at least {} % of the largest cycle's range), with {} % of the load range in common; a mean loop needs {} cycles with more than {} %", counted(*count, "full cycle"), short(100.0 * FULL_SHARE), short(100.0 * .share), FEWEST_CYCLES,
        short(100.0 * MOST)
    )]
    FewCycles { axis: Axis, count: usize, share: f64 },
    #[error(
        "no recording has two large branches of {axis} in one direction; repeat the cycle in one run"
    )]
    TooFewCycles { axis: Axis },
    #[error(
        "no cycle of {axis} turns at the same loads as the one before; repeat the cycle in one run"
    )]
    NotRepeated { axis: Axis },
    #[error(
        "in the cycles of {axis}, the load on {other} differs at equal {axis}; repeat the cycle with one axis loaded"
    )]
    OthersDiffer { axis: Axis, other: Axis },
    #[error(
        "this figure of {axis} is below the noise, which alone could give {} {}; repeat the cycle, or record more slowly", significant(*.limit, 2), .axis.unit()
    )]
    BelowNoise { axis: Axis, limit: f64, percent: Option<f64> },
    #[error("no recording with a reference for {axis} has a channel in °C that changes by {} °C", short(*.least))]
    NoTemperature { axis: Axis, least: f64 },
    #[error("{axis} has no full scale, because the axis is never loaded; enter a full scale")]
    NoFullScale { axis: Axis },
    #[error(
        "no recording holds the load constant for {} s while {axis} is at {} % of full scale or above",
        short(*.secs), short(100.0 * .share)
    )]
    NoHold { axis: Axis, share: f64, secs: f64 },
    #[error(
        "no recording dwells at zero for {} s (every axis within {} % of full scale)",
        short(*.secs), short(100.0 * .share)
    )]
    NoZero { share: f64, secs: f64 },
    #[error(
        "no recording dwells at zero both before and after {axis} is at {} % of full scale or above", short(100.0 * .share)
    )]
    NoReturn { axis: Axis, share: f64 },
    #[error(
        "no recording dwells at zero after {axis} is at {} % of full scale or above", short(100.0 * .share)
    )]
    NoRecovery { axis: Axis, share: f64 },
    #[error("{axis} has one of several gauges or axes, so it has no single sensitivity")]
    ManyGauges { axis: Axis },
    #[error("the time lag of {axis} is zero within its uncertainty of ± {} s", significant(*.uncertainty_secs, 2))]
    NoLagFound { axis: Axis, uncertainty_secs: f64 },
    #[error("the time lag of {axis} is unknown: {reason}")]
    NoLag { axis: Axis, reason: NoLag },
    #[error("the time lag explains only {:.0} % of the mean loop width of {axis}", 100.0 * .share)]
    LagExplainsLittle { axis: Axis, share: f64 },
    #[error(
        "the lag is uncertain, and so the hysteresis of {axis} without it by ± {} {}; load the axis more slowly", significant(*.uncertainty, 2), .axis.unit()
    )]
    LagTooUncertain { axis: Axis, uncertainty: f64 },
    #[error(transparent)]
    NoTimeConstant(#[from] NoTimeConstant),
    #[error("{axis} is the loaded axis")]
    LoadedAxis { axis: Axis },
    #[error("{axis} is the only axis, so there is no crosstalk")]
    OnlyAxis { axis: Axis },
    #[error(
        "no recording loads {axis} alone (to {} % of full scale or above, other axes within {} %)", short(100.0 * .loaded_share), short(100.0 * .alone_share)
    )]
    NeverAlone { axis: Axis, loaded_share: f64, alone_share: f64 },
    #[error(
        "while {axis} alone is loaded, its load hardly changes; record {axis} loaded and unloaded in one run"
    )]
    NotLinear { axis: Axis },
    #[error(
        "{recording}: the load or the output of {axis} is not a finite number in sample {sample}"
    )]
    NotFinite { axis: Axis, recording: String, sample: usize },
    #[error("the loads or errors of {axis} are too large to compute with")]
    Overflow { axis: Axis },
}

impl Reason {
    /// Returns the reason in one or two words, for a narrow table cell. A limit is in % of full scale, or in the unit of the
    /// axis.
    pub fn word(&self, in_percent: bool) -> Cow<'static, str> {
        Cow::Borrowed(match self {
            Self::BelowNoise { axis, limit, percent } => {
                let (limit, unit) = match percent.filter(|_| in_percent) {
                    Some(percent) => (percent, "% FS"),
                    None => (*limit, axis.unit()),
                };
                return format!("below noise ({} {unit})", significant(limit, 2)).into();
            }
            Self::ManyGauges { .. } => "many gauges",
            Self::NoLagFound { .. } => "none",
            Self::NoTemperature { .. } => "no °C",
            Self::NoReference { .. } => "no ref.",
            Self::ConstantLoad { .. } => "constant",
            Self::NoTimes { .. } => "no times",
            Self::NoRepeats { .. } => "no repeats",
            Self::OneBranch { .. } => "1 branch",
            Self::NoCycle { .. } => "no cycle",
            Self::NoRisingBranch { .. } => "no rise",
            Self::TooFewLoads { .. } => "few loads",
            Self::FewCycles { .. } => "few cycles",
            Self::TooFewCycles { .. } => "1 cycle",
            Self::NotRepeated { .. } | Self::OthersDiffer { .. } => "no repeats",
            Self::NotLinear { .. } => "1 load",
            Self::NoFullScale { .. } => "no FS",
            Self::NoHold { .. } => "no dwell",
            Self::NoZero { .. } => "no zero",
            Self::NoReturn { .. } => "no return",
            Self::NoRecovery { .. } => "no zero",
            Self::NoTimeConstant(_) => "no τ",
            Self::NoLag { .. } | Self::LagTooUncertain { .. } => "not known",
            Self::LagExplainsLittle { .. } => "no lag",
            Self::LoadedAxis { .. } => "·",
            Self::OnlyAxis { .. } => "only axis",
            Self::NeverAlone { .. } => "not alone",
            Self::NotFinite { .. } => "not finite",
            Self::Overflow { .. } => "too large",
        })
    }
}

/// Returns a number as text with three significant digits, without trailing zeros.
fn short(value: f64) -> String {
    let digits = significant(value, 3);
    if digits.contains('.') && !digits.contains('e') {
        digits.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        digits
    }
}

/// Quantity that a row of the metrology table shows, defined in [`QUANTITIES`]. A crosstalk quantity contains the loaded
/// axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    Hysteresis,
    MeanLoopHysteresis,
    LoopArea,
    TerminalNonlinearity,
    BestFitNonlinearity,
    CombinedError,
    Repeatability,
    Sensitivity,
    ZeroReturn,
    TimeLag,
    HysteresisWithoutLag,
    Creep,
    CreepTime,
    CreepRecovery,
    Noise,
    NoisePeakToPeak,
    TemperatureZero,
    TemperatureSpan,
    Crosstalk(Axis),
    Rmse,
    LargestError,
    Error95,
}

#[derive(Clone, Debug, Serialize)]
pub struct Definition {
    /// Short, constant id of the quantity, for programs that read the table.
    pub id: String,
    pub name: String,
    pub definition: &'static str,
    /// Standard or book from which the definition is taken.
    pub source: &'static str,
    /// Conditions that the source of the definition requires and a free-running recording does not meet; may be empty.
    pub free_running: &'static str,
}

impl Definition {
    pub fn sentences(&self) -> Vec<String> {
        let mut sentences =
            vec![format!("{}.", self.definition), format!("Source: {}.", self.source)];
        if !self.free_running.is_empty() {
            sentences.push(format!("Free-running: {}.", self.free_running));
        }
        sentences
    }
}

impl Quantity {
    pub fn all(axes: &[Axis]) -> Vec<Self> {
        let all = QUANTITIES.iter().flat_map(|(quantity, _)| match quantity {
            Self::Crosstalk(_) => axes.iter().copied().map(Self::Crosstalk).collect(),
            single => vec![*single],
        });
        all.collect()
    }

    /// Returns the loaded axis of a crosstalk row; `None` for any other row.
    pub fn crosstalk_from(self) -> Option<Axis> {
        match self {
            Self::Crosstalk(axis) => Some(axis),
            _ => None,
        }
    }

    /// Returns true if the figures of the quantity are loads, and not times in seconds or sensitivities.
    pub fn is_load(self) -> bool {
        !matches!(self, Self::CreepTime | Self::TimeLag | Self::Sensitivity)
    }

    /// Returns the unit of the figures for this axis.
    pub fn unit(self, axis: Axis) -> &'static str {
        match self {
            Self::LoopArea if axis.is_force() => "N²",
            Self::LoopArea => "(N·m)²",
            Self::Sensitivity if axis.is_force() => "reading/N",
            Self::Sensitivity => "reading/(N·m)",
            _ if self.is_load() => axis.unit(),
            _ => "s",
        }
    }

    pub fn definition(self) -> Definition {
        let is_own = |(of, _): &&(Self, _)| discriminant(of) == discriminant(&self);
        let (_, texts) = QUANTITIES.iter().find(is_own).expect("QUANTITIES defines every quantity");
        let [id, name, definition, source, free_running] = *texts;
        let (id, name) = match self.crosstalk_from() {
            None => (id.to_owned(), name.to_owned()),
            Some(axis) => {
                let symbol = axis.symbol();
                (format!("{id}_{}", symbol.to_lowercase()), name.replace("Fx", symbol))
            }
        };
        Definition { id, name, definition, source, free_running }
    }
}

const ONE_AXIS_AT_REST: &str = "the standard loads one axis alone, in steps, and reads at set times; here loads on other axes count as loop width";

const STATISTICS: &str = "statistics; no standard defines this figure";

/// All quantities in the order of the metrology table, each with the five texts of its [`Definition`]. Crosstalk is listed
/// for Fx only.
const QUANTITIES: [(Quantity, [&str; 5]); 22] = [
    (
        Quantity::Hysteresis,
        [
            "hysteresis",
            "Hysteresis",
            "largest |falling − rising| of the output at equal load, in the cycle (counted by rainflow) whose branches share the largest range of loads; of cycles of a table with equal ranges, the widest. Branches are averaged over hundredths of the range, without the smaller cycles in them, and compared at 101 loads. The difference is averaged over up to 12 neighbours on each side, until its noise is at most a fiftieth of the largest difference, but not where averaging changes it by more than the noise can. On staircases, the readings at the ends of the steps are compared. A width within three standard deviations of its noise is \"below noise\"",
            "OIML R 60-1, 3.7 (difference at the same load, rising from the minimum and falling from the maximum), in percent of full scale as in VDI/VDE 2638",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::MeanLoopHysteresis,
        [
            "hysteresis_mean_loop",
            "Hysteresis, mean loop",
            "largest |falling − rising| of the mean loop: the mean of at least three cycles, each with at least 80 % of the largest cycle's range, at their common loads, which must cover more than half of the load range",
            "as for Hysteresis; the mean keeps what repeats",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::LoopArea,
        [
            "loop_area",
            "Loop area",
            "integral of |falling − rising| over the load, in the mean loop, or without one in the largest cycle; in percent of the square of full scale",
            "as for Hysteresis; the area divided by the range of the loads is the mean width",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::TerminalNonlinearity,
        [
            "nonlinearity_terminal",
            "Nonlinearity, terminal line",
            "largest deviation of the mean rising branch of the mean loop (without one, of the largest cycle) from the line through its ends. Of a staircase, the last third of each step is averaged; elsewhere, hundredths of the range, and neighbours as for Hysteresis. The noise is subtracted in squares; a deviation below three standard deviations of the noise is \"below noise\"",
            "load-cell makers' glossaries: from no load to rated load, rising only",
            "the branch goes from the minimum to the maximum recorded load, and earlier loads affect its start",
        ],
    ),
    (
        Quantity::BestFitNonlinearity,
        [
            "nonlinearity_best_fit",
            "Nonlinearity, best-fit line",
            "as for Nonlinearity, terminal line, but from the least-squares line, with equal weight for every hundredth or step",
            "sensor makers' data sheets (best-fit straight line), rising only",
            "as for Nonlinearity, terminal line",
        ],
    ),
    (
        Quantity::CombinedError,
        [
            "combined_error",
            "Combined error",
            "largest deviation of both mean branches from the line through the ends of the rising branch; noise as for Nonlinearity, terminal line",
            "load-cell makers' glossaries: nonlinearity and hysteresis in one figure",
            "as for Hysteresis and for Nonlinearity, terminal line",
        ],
    ),
    (
        Quantity::Repeatability,
        [
            "repeatability",
            "Repeatability",
            "largest difference at equal load between branches of the same direction in successive, repeated cycles, without its noise. Repeated cycles turn at the same loads within 5 % of the largest cycle's range, with the loads of other axes equal within 5 % of full scale. In a table without times: largest difference between readings at the same load that was reached in the same direction",
            "load-cell makers' glossaries: same load, same direction, same conditions",
            "the conditions, such as the speed, may differ between the cycles",
        ],
    ),
    (
        Quantity::Sensitivity,
        [
            "sensitivity",
            "Sensitivity",
            "slope of the least-squares line of the gauge's readings over the load, with an offset for each recording, in the unit of the readings; for one gauge and one axis. Its uncertainty is the standard error of the slope, for independent readings",
            "statistics; makers state the slope between no load and rated load",
            "",
        ],
    ),
    (
        Quantity::TimeLag,
        [
            "time_lag",
            "Time lag",
            "delay of the output behind the reference, or time constant of a first-order low-pass, whichever fits better, by least squares on the delayed reference of all axes, its play operators, squares and cubes, and slow creep. A lag within two standard errors is none. Assumptions: one lag for all loads; hysteresis that does not depend on the rate; creep slower than three times the time scale of the load",
            "system identification; no standard defines a time lag of the sensor",
            "the load must move at rates that differ by a factor of about two: at one rate, lag and hysteresis look alike",
        ],
    ),
    (
        Quantity::HysteresisWithoutLag,
        [
            "hysteresis_without_lag",
            "Hysteresis, lag removed",
            "hysteresis of the mean loop (without one, of the largest cycle) over the reference delayed by the lag, to which gains and crosstalk are fitted again. Given if the lag explains more than a tenth of the mean loop width, and if two standard errors of the lag change the figure by at most a tenth, or by 0.3 % of full scale",
            "as for Hysteresis",
            ONE_AXIS_AT_REST,
        ],
    ),
    (
        Quantity::ZeroReturn,
        [
            "zero_return",
            "Zero return",
            "mean of output − load in the first seconds at zero after a load, minus that in the last seconds at zero before it; the largest change, with its sign. Both intervals are as long as the shortest dwell; in a table without times, they are one reading",
            "OIML R 60-1, 2.1.5 (output at minimum load after a load, minus the output before)",
            "the standard applies the load for 30 min",
        ],
    ),
    (
        Quantity::Creep,
        [
            "creep",
            "Creep",
            "change of output − load over the longest dwell with the axis loaded, on a fitted first-order exponential, with its sign",
            "OIML R 60-1, 2.1.5 (change of the output under a constant load)",
            "the standard holds 90 to 100 % of the maximum load for 30 min; here half of full scale is enough, for any time",
        ],
    ),
    (
        Quantity::CreepTime,
        [
            "creep_time_constant",
            "Creep, time constant",
            "τ of output − load = a + b (1 − exp(−t / τ)), fitted to the dwell of the creep figure",
            "a first-order creep element; no standard defines its time constant",
            "",
        ],
    ),
    (
        Quantity::CreepRecovery,
        [
            "creep_recovery",
            "Creep recovery",
            "as for Creep, over the longest dwell at zero after a load on the axis",
            "load-cell makers' glossaries: change of zero after a held load is removed",
            "the load may have been removed without being held",
        ],
    ),
    (
        Quantity::Noise,
        [
            "noise",
            "Noise, RMS",
            "standard deviation of the white noise in the longest dwell: of each value minus the mean of its two neighbours, divided by √1.5. Without a dwell, that of the noisiest recording, from the median",
            STATISTICS,
            "",
        ],
    ),
    (
        Quantity::NoisePeakToPeak,
        [
            "noise_peak_to_peak",
            "Noise, peak to peak",
            "largest minus smallest of the values from which Noise, RMS is computed",
            STATISTICS,
            "a longer dwell has a larger value",
        ],
    ),
    (
        Quantity::TemperatureZero,
        [
            "temperature_zero",
            "Temperature effect on zero",
            "change of output − load at zero load for 10 °C, by least squares on the load, the first channel in °C, and their product; uncertainty from leaving out each tenth of the samples",
            "OIML R 60-1 and VDI/VDE 2638 (temperature effect on the zero signal)",
            "the standards wait until the temperature is equal everywhere; a gradient has other effects",
        ],
    ),
    (
        Quantity::TemperatureSpan,
        [
            "temperature_span",
            "Temperature effect on span",
            "further change of output − load at full scale for 10 °C; from the product in Temperature effect on zero",
            "OIML R 60-1 and VDI/VDE 2638 (temperature effect on the sensitivity)",
            "as for Temperature effect on zero",
        ],
    ),
    (
        Quantity::Crosstalk(Axis::Fx),
        [
            "crosstalk_from",
            "Crosstalk from Fx",
            "output − load of the axis at full load of the named axis alone: slope of a least-squares line with an offset for each recording, times the full scale of the loaded axis. All other axes are within 2 % of full scale, and the loaded axis reaches 50 % (both shares can be set)",
            "common practice for multi-axis sensors",
            "a calibration bench loads one axis at a time; here drift and hysteresis of the axis under the load also count",
        ],
    ),
    (
        Quantity::Rmse,
        ["rmse", "RMSE", "root mean square of output − load over all samples", STATISTICS, ""],
    ),
    (
        Quantity::LargestError,
        [
            "largest_error",
            "Largest error",
            "largest |output − load| over all samples",
            STATISTICS,
            "",
        ],
    ),
    (
        Quantity::Error95,
        [
            "error_95",
            "95 % error",
            "|output − load| that 95 % of all samples do not exceed",
            "statistics; makers of multi-axis sensors state accuracy per axis in percent of full scale",
            "neighbouring samples are correlated, so the 95 % are a share of time, not a confidence level",
        ],
    ),
];

#[cfg(test)]
mod tests {
    use crate::questions::metrology::figures::*;

    #[test]
    fn values_out_of_range_are_named() {
        let with = |change: fn(&mut MetrologySettings)| {
            let mut settings = MetrologySettings::default();
            change(&mut settings);
            settings.validate(2)
        };
        assert_eq!(with(|_| {}), Ok(()));
        assert_eq!(with(|s| s.reversal_thresholds = vec![None, Some(0.0)]), Ok(()));
        assert!(with(|s| s.reversal_thresholds = vec![Some(1.0)]).is_err());
        assert!(with(|s| s.reversal_thresholds = vec![None, Some(-1.0)]).is_err());
        assert!(with(|s| s.reversal_thresholds = vec![None, Some(f64::NAN)]).is_err());
        assert!(with(|s| s.hold_secs = 0.0).is_err());
        assert!(with(|s| s.zero_share = f64::NAN).is_err());
        assert!(with(|s| s.alone_share = 1.1).is_err());
    }
}

#[cfg(test)]
mod quantity_tests {
    use crate::questions::metrology::figures::*;
    use std::collections::HashSet;

    #[test]
    fn every_row_has_its_own_id_and_a_definition() {
        let all = Quantity::all(&Axis::ALL);
        assert_eq!(all.len(), 27);
        let definitions = all.iter().map(|quantity| quantity.definition());
        let ids: HashSet<String> = definitions
            .inspect(|row| assert!(!row.definition.is_empty() && !row.source.is_empty()))
            .map(|row| row.id)
            .collect();
        assert_eq!(ids.len(), all.len());
        assert!(ids.contains("crosstalk_from_fx"));
    }
}
