//! How a file, or a pair of files, becomes recordings.

use serde::{Deserialize, Serialize};

use crate::import::map::file::MapFile;
use crate::import::map::role::ColumnRole;
use crate::import::map::table::TableMap;
use crate::import::map::weight::WeightMap;
use crate::recording::{GroupPattern, Tare};

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
#[serde(into = "MapFile", try_from = "MapFile")]
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
    /// Added to the reference's times (s). Nothing is added without an entry here.
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
