use serde::de::IgnoredAny;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::import::map::role::ColumnRole;
use crate::import::map::table::{TableMap, is_default};
use crate::import::map::weight::WeightMap;
use crate::recording::{GroupPattern, Tare};

/// Description of how recordings are read from a file, or from one file with gauges and one with the reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColumnMap {
    /// Name of the format, which is the same in every file.
    #[serde(serialize_with = "format", deserialize_with = "skip")]
    pub format: (),
    /// Version of the format, which is the same in every file.
    #[serde(serialize_with = "version", deserialize_with = "skip")]
    pub version: (),
    /// Columns of the file with the gauges.
    pub table: TableMap,
    /// File with the reference load, if it is a separate file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceFile>,
    /// Way to compute the reference at the times of the gauges. It has an effect only if the two have different clocks.
    #[serde(default, skip_serializing_if = "is_default")]
    pub join: Join,
    /// Weight whose load is computed from the pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<WeightMap>,
    /// Interval in which the sensor is unloaded, for taring the gauges: `"auto"`, or `{ "interval": [from, to] }` in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tare: Option<Tare>,
    /// Maximum time step (s) between gauge samples of one burst. Each burst is averaged to one sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub average_bursts_secs: Option<f64>,
    /// Time step (s) above which a recording ends. The default is 20 median steps, but at least 0.2 s. For rows in bursts it
    /// is 2 s, and the user is told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_secs: Option<f64>,
    /// Group of the recordings. By default, it is derived from a group column, names, folders and files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<GroupPattern>,
}

/// File with the reference load of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceFile {
    /// Path, relative to the folder of the file with the gauges. `{stem}` stands for the name of that file without its
    /// extension.
    pub file: String,
    /// Columns of the file. There must be one `time` and at least one axis.
    pub table: TableMap,
}

/// Way to compute the reference at the times of the gauges, if the two have different clocks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Join {
    /// Choice of the value between two reference samples.
    pub method: JoinMethod,
    /// Limit (s) above which there is no value: for `interpolate` the time step between two reference samples, for `nearest`
    /// the distance in time, for `hold` the age of the value. The default is 20 median time steps of the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_secs: Option<f64>,
    /// Offset (s) that is added to the reference's times. The default is 0.
    #[serde(skip_serializing_if = "is_default")]
    pub clock_offset_secs: f64,
}

/// Method for the value between two reference samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JoinMethod {
    /// Linear interpolation.
    #[default]
    Interpolate,
    /// Value of the sample that is nearer in time.
    Nearest,
    /// Value of the sample before.
    Hold,
}

impl ColumnMap {
    /// Creates a map for files in which gauges and reference have one clock.
    pub fn of_table(table: TableMap) -> Self {
        Self { table, ..Self::default() }
    }

    /// Returns the columns of the file that holds the reference.
    pub fn reference_table(&self) -> &TableMap {
        self.reference.as_ref().map_or(&self.table, |file| &file.table)
    }

    /// Returns true if the reference has its own times, in a separate file or in a separate column.
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

/// Ignores the value, because [`ColumnMap::from_json`] has checked it.
fn skip<'de, D: Deserializer<'de>>(from: D) -> Result<(), D::Error> {
    IgnoredAny::deserialize(from).map(|_| ())
}
