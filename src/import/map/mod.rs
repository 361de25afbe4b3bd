//! What the columns of a table are: the choice that a person makes once for a kind of file, and keeps.
//!
//! Guarantees: a [`ColumnMap`] says everything that reading needs and nothing about one single file, so that one map
//! serves every file of the same [`Shape`]. Header rules and people's choices both end here: there is one way from a
//! map to recordings.

mod error;
mod file;
mod header;
mod line_per_item;
mod role;
mod weight;

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::formats::text::TextLayout;
use crate::recording::{GroupPattern, Tare};
pub(crate) use error::{MapError, MapFileError};
pub(crate) use header::{Header, KeyError};
pub use role::ColumnRole;
pub(crate) use role::PosePart;
pub(crate) use weight::{Angles, Attitude, Mount, WeightMap};

/// How a file, or a pair of files, becomes recordings.
///
/// | part | meaning |
/// |---|---|
/// | `table` | the file with the gauges |
/// | `reference` | where the reference load stands, if it has a file of its own |
/// | `join` | how a reference on its own clock is brought to the times of the gauges |
/// | `weight` | the load is computed from the pose of a sensor that carries a known weight |
/// | `tare` | the gauges' mean over an interval is taken off: `"auto"`, or `{ "interval": [from, to] }` in seconds |
/// | `average_bursts_secs` | successive gauge samples no further apart than this become one, their mean; `None` leaves them |
/// | `gap_secs` | a pause longer than this ends a recording; `None` goes by the median step |
/// | `group` | what the recordings' group is called, as [`GroupPattern`] says; `None` goes by names, folders and files |
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(into = "file::MapFile", try_from = "file::MapFile")]
pub struct ColumnMap {
    /// The file with the gauges.
    pub table: TableMap,
    /// The file with the reference load, if that is another one.
    pub reference: Option<ReferenceFile>,
    /// How two clocks become one; without a second clock it does nothing.
    pub join: Join,
    /// The weight whose load is computed from the pose.
    pub weight: Option<WeightMap>,
    /// How the gauges are tared.
    pub tare: Option<Tare>,
    /// Successive gauge samples no further apart than this (s) become one.
    pub average_bursts_secs: Option<f64>,
    /// A longer step in time (s) ends a recording; by default one of 20 median steps, and no less than 0.2 s. Where rows
    /// come in bursts, it is 2 s, and that is told.
    pub gap_secs: Option<f64>,
    /// What the recordings' group is called; by default that is found when they are loaded.
    pub group: Option<GroupPattern>,
}

/// One file as a table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableMap {
    /// Which files this is for.
    pub shape: Shape,
    /// How the text is cut into cells.
    #[serde(default)]
    pub text: TextLayout,
    /// Samples a second (Hz): times come from it where no column is the time, or where the time counts samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_rate_hz: Option<f64>,
    /// What is done about stamps that are out of order, or shared by several rows.
    #[serde(default, skip_serializing_if = "Stamps::is_as_written")]
    pub stamps: Stamps,
    /// What the columns are; those that are not listed are ignored.
    pub columns: Vec<ColumnRule>,
}

/// What is done about stamps that are out of order, or shared by several rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stamps {
    /// Nothing.
    #[default]
    AsWritten,
    /// Rows are sorted by their time.
    Sorted,
    /// Rows with one stamp are spread evenly until the next.
    Spread,
}

impl Stamps {
    /// Each with its name for people, and what it does.
    pub const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::AsWritten, "as written", "Where time goes back, a new recording starts"),
        (Self::Sorted, "sort rows by time", "For loggers that write some rows late"),
        (
            Self::Spread,
            "spread rows of one stamp evenly",
            "For stamps of whole seconds, or of a clock that is coarser than the samples",
        ),
    ];

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
    fn is_as_written(&self) -> bool {
        *self == Self::AsWritten
    }
}

/// What files must have in common to be read by one map.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shape {
    /// How many columns there are.
    pub columns: usize,
    /// The header's cells as written; none without a header.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
}

/// What one column is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColumnRule {
    /// Which column.
    pub column: ColumnKey,
    /// What it is.
    pub is: ColumnRole,
    /// What a gauge or an auxiliary channel is called; by default as in the header, or `S1`, `S2` and so on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its unit: of a load one that is understood; of a gauge a label; of an auxiliary channel `degC`, `K`, `degF`, `V`, `mV`, `%` or
    /// any label; of a time `s`, `ms`, `us`, `ns`, `samples`,
    /// `iso8601`, `d.m.y`, `m/d/y`, `d/m/y` or `h:m:s`. By default what the header says, then what the values look
    /// like (times) or SI (loads, positions); of an angle `rad` or `deg`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Values are multiplied with this; -1 turns the sign.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub scale: f64,
    /// Values are divided by this before they have their unit.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub counts_per_unit: f64,
    /// Values (as written) that mean that there is none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dropouts: Vec<f64>,
}

impl ColumnRule {
    /// A column that is this and has no unit, no other scale and no dropouts.
    pub fn new(column: ColumnKey, is: ColumnRole) -> Self {
        Self {
            column,
            is,
            name: None,
            unit: None,
            scale: 1.0,
            counts_per_unit: 1.0,
            dropouts: Vec::new(),
        }
    }
}

fn one() -> f64 {
    1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_one(value: &f64) -> bool {
    *value == 1.0
}

/// Which column of a file: its number from 1 on, or its name as the header writes it. In a file it becomes an index, by
/// [`Header`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "the names are the documentation")]
pub enum ColumnKey {
    Number(usize),
    Name(String),
}

impl fmt::Display for ColumnKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Name(name) => write!(f, "\"{name}\""),
        }
    }
}

/// The file that holds the reference load of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceFile {
    /// Where it is, seen from the folder of the file with the gauges; `{stem}` stands for that file's name without its
    /// ending.
    pub file: String,
    /// What its columns are: one `time`, one axis or more.
    pub table: TableMap,
}

/// How a reference with its own clock is brought to the times of the gauges.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Join {
    /// How a value between two reference samples is found.
    pub method: JoinMethod,
    /// Interpolating: the longest step between two reference samples that is bridged (s). Nearest, hold: how far away,
    /// how old a reference sample may be. By default 20 median steps of the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_secs: Option<f64>,
    /// Added to the reference's times (s). Nothing is added unless somebody writes it here.
    #[serde(skip_serializing_if = "is_zero")]
    pub clock_offset_secs: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// How a reference value is found for a time between two reference samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JoinMethod {
    /// On the straight line between the two.
    #[default]
    Interpolate,
    /// That of the nearer one.
    Nearest,
    /// That of the one before.
    Hold,
}

impl ColumnMap {
    /// A map for files with one clock.
    pub fn of_table(table: TableMap) -> Self {
        Self { table, ..Self::default() }
    }

    /// The table with the reference.
    pub fn reference_table(&self) -> &TableMap {
        self.reference.as_ref().map_or(&self.table, |file| &file.table)
    }

    /// Whether the reference has its own times, in its own file or in its own column.
    pub fn has_two_clocks(&self) -> bool {
        self.reference.is_some() || self.table.has_role(ColumnRole::TimeReference)
    }
}

impl TableMap {
    /// Whether a column is this.
    pub fn has_role(&self, role: ColumnRole) -> bool {
        self.columns.iter().any(|rule| rule.is == role)
    }
}
