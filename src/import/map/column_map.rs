use serde::de::IgnoredAny;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::{
    import::map::{
        role::ColumnRole,
        table::{TableMap, is_default},
        weight::WeightMap,
    },
    recording::{GroupPattern, Tare},
};

/// Description of how recordings are read from a file, or from two files, one with the gauges and one with the reference
/// load.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColumnMap {
    /// Name of the format of map files, which is the same in every map file.
    #[serde(serialize_with = "format", deserialize_with = "skip")]
    pub format: (),
    /// Version of the format of map files. This program writes the same version into every map file.
    #[serde(serialize_with = "version", deserialize_with = "skip")]
    pub version: (),
    /// Columns of the file with the gauges. The reference load may be in the same file.
    pub table: TableMap,
    /// File with the reference load, if it is a separate file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceFile>,
    /// Method of computing the reference load at the times of the gauges. It has an effect only if gauges and reference have
    /// different clocks.
    #[serde(default, skip_serializing_if = "is_default")]
    pub join: Join,
    /// Known weight that hangs from the sensor. The reference load is computed from this weight and the pose of the sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<WeightMap>,
    /// Interval in which the sensor is unloaded. The mean gauge values of this interval are subtracted (tare). Possible
    /// values: `"auto"`, or `{ "interval": [from, to] }` in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tare: Option<Tare>,
    /// Time step (s) between two rows above which a recording ends. The default is 20 median steps, but at least 0.2 s. If
    /// rows come in bursts, the default is 2 s, and the user gets a warning.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_secs: Option<f64>,
    /// Group to which the recordings belong, such as a press, a condition or a day. By default, the group is derived from a
    /// group column, or from the names of recordings, folders and files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<GroupPattern>,
}

/// File with the reference load for the gauges of another file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceFile {
    /// Path of the file, relative to the folder of the file with the gauges. `{stem}` stands for the name of the gauge file
    /// without its extension.
    pub file: String,
    /// Columns of the file with the reference. One column must have the role `time`, and at least one must be an axis of the
    /// load.
    pub table: TableMap,
}

/// Method of computing the reference load at the times of the gauges, if gauges and reference have different clocks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Join {
    /// Choice of the value at a time between two reference samples.
    pub method: JoinMethod,
    /// Time (s) above which a gauge sample gets no reference. For `interpolate` it is the time step between two reference
    /// samples, for `nearest` the distance in time, and for `hold` the age of the value. The default is 20 median time steps
    /// of the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_secs: Option<f64>,
    /// Clock offset (s) that is added to the times of the reference. The default is 0.
    #[serde(skip_serializing_if = "is_default")]
    pub clock_offset_secs: f64,
}

/// Choice of the reference value at a time between two reference samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JoinMethod {
    /// Linear interpolation between the two samples.
    #[default]
    Interpolate,
    /// Value of whichever of the two samples is nearer in time.
    Nearest,
    /// Value of the earlier sample, which is held until the next one.
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

pub const FORMAT: &str = "loopscope column map";
pub const VERSION: u32 = 2;
/// Version in which columns that a map does not list are ignored. Later versions propose their roles.
pub const FIRST_VERSION: u32 = 1;

fn format<T, S: Serializer>(_: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(FORMAT)
}

fn version<T, S: Serializer>(_: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u32(VERSION)
}

/// Ignores the value of `format` or `version`, because [`ColumnMap::from_json`] has already checked it.
fn skip<'de, D: Deserializer<'de>>(from: D) -> Result<(), D::Error> {
    IgnoredAny::deserialize(from).map(|_| ())
}
