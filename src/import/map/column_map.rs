use serde::de::IgnoredAny;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::import::map::role::ColumnRole;
use crate::import::map::table::{TableMap, is_default};
use crate::import::map::weight::WeightMap;
use crate::recording::{GroupPattern, Tare};

/// Description of how a file, or a pair of files, becomes recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColumnMap {
    /// Name of the format, constant in a file.
    #[serde(serialize_with = "format", deserialize_with = "skip")]
    pub format: (),
    /// Version of the format, constant in a file.
    #[serde(serialize_with = "version", deserialize_with = "skip")]
    pub version: (),
    /// File with the gauges.
    pub table: TableMap,
    /// File with the reference load, if it is a separate one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceFile>,
    /// Joining of two clocks; without a second clock it has no effect.
    #[serde(default, skip_serializing_if = "is_default")]
    pub join: Join,
    /// Weight whose load is computed from the pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<WeightMap>,
    /// Taring of the gauges by their mean over an interval: `"auto"`, or `{ "interval": [from, to] }` in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tare: Option<Tare>,
    /// Maximum step between successive gauge samples that are averaged into one (s).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub average_bursts_secs: Option<f64>,
    /// Step above which a recording ends (s): by default 20 median steps, at least 0.2 s, or 2 s (reported) for rows in bursts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_secs: Option<f64>,
    /// Group of the recordings; by default it is derived from a group column, names, folders and files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<GroupPattern>,
}

/// File with the reference load of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceFile {
    /// Path relative to the folder of the file with the gauges, whose name without extension replaces `{stem}`.
    pub file: String,
    /// Columns of the file: one `time` and at least one axis.
    pub table: TableMap,
}

/// Evaluation of a reference with its own clock at the times of the gauges.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Join {
    /// Value between two reference samples.
    pub method: JoinMethod,
    /// Limit (s), by default 20 median steps of the reference: longest step that `interpolate` bridges, largest distance of a
    /// sample for `nearest`, largest age for `hold`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_secs: Option<f64>,
    /// Offset added to the reference's times (s), by default 0.
    #[serde(skip_serializing_if = "is_default")]
    pub clock_offset_secs: f64,
}

/// Choice of the reference value between two reference samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JoinMethod {
    /// Linear interpolation.
    #[default]
    Interpolate,
    /// Value of the nearer sample.
    Nearest,
    /// Value of the sample before.
    Hold,
}

impl ColumnMap {
    /// Creates a map for files with one clock.
    pub fn of_table(table: TableMap) -> Self {
        Self { table, ..Self::default() }
    }

    /// Returns the table with the reference.
    pub fn reference_table(&self) -> &TableMap {
        self.reference.as_ref().map_or(&self.table, |file| &file.table)
    }

    /// Returns true if the reference has its own times, in a separate file or column.
    pub fn has_two_clocks(&self) -> bool {
        self.reference.is_some() || self.table.has_role(ColumnRole::TimeReference)
    }
}

pub(super) const FORMAT: &str = "loopscope column map";
pub(super) const VERSION: u32 = 1;

fn format<T, S: Serializer>(_: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(FORMAT)
}

fn version<T, S: Serializer>(_: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u32(VERSION)
}

/// Skips a value that was checked before.
fn skip<'de, D: Deserializer<'de>>(from: D) -> Result<(), D::Error> {
    IgnoredAny::deserialize(from).map(|_| ())
}
