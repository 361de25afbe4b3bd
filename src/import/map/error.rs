//! Why a column map is of no use, in one sentence each.

use std::io;
use std::path::PathBuf;

use crate::finding::{Advice, Way};
use crate::import::map::role::ColumnRole;
use crate::import::map::table::ColumnKey;
use crate::import::map::weight::Attitude;

/// Why a column map is of no use, whatever the recording.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    #[error("no JSON of a column map; write one for a recording")]
    NotAMap,
    #[error("no JSON of a column map: {0}")]
    Json(#[from] serde_json::Error),
    #[error(
        "not a column map: its \"format\" is {found} where \"{expected}\" is needed; write one for a recording"
    )]
    Format { found: String, expected: &'static str },
    #[error("a column map of version {found}, this program reads version {known}; get a newer one")]
    Version { found: u64, known: u32 },
    #[error("a column cannot be \"{name}\"; known: {known}")]
    UnknownRole { name: String, known: String },
    #[error(
        "the pose has a position, but not how the sensor is turned; add {}",
        Attitude::listed()
    )]
    NoAttitude,
    #[error("the pose has no column \"{missing}\"; list all of its parts")]
    PoseIncomplete { missing: ColumnRole },
    #[error(
        "\"{first}\" and \"{second}\" both say how the sensor is turned; keep one of the two, and \"ignore\" the other's columns"
    )]
    TwoPoses { first: ColumnRole, second: ColumnRole },
    #[error(
        "\"weight\" needs the pose of the sensor, and no column is a part of it; make columns pose_qw, pose_qx and so on"
    )]
    WeightWithoutPose,
    #[error(
        "with \"weight\" the load is computed from the pose, but a column is {role}, too; take out one of the two"
    )]
    WeightAndLoad { role: ColumnRole },
    #[error(
        "{mount}: mass_kg and centre_m must both be said, for the weight or for each mount, and each mount needs a name of its own"
    )]
    WeightUnknown { mount: String },
    #[error("a column is \"mount\", but \"weight\" has no \"mounts\" to choose from")]
    NoMounts,
    #[error("column {number} does not exist: \"shape\" says {columns} columns, counted from 1")]
    NoSuchColumn { number: usize, columns: usize },
    #[error(
        "{columns} columns in \"shape\", but {names} names; give each column its name, or none"
    )]
    ShapeNames { columns: usize, names: usize },
    #[error("column {number} is listed twice, as {first} and as {second}; say once what it is")]
    ListedTwice { number: usize, first: ColumnKey, second: ColumnKey },
    #[error(
        "column \"{name}\" is listed by its name, but \"text\" says that there is no header; use its number"
    )]
    NameWithoutHeader { name: String },
    #[error("{what} is {value}; it must be {must}")]
    Number { what: String, value: f64, must: &'static str },
    #[error(
        "the reference's file is \"{file}\"; name a file as seen from the recording's folder, e.g. \"states.csv\" or \"{{stem}}_ref.csv\""
    )]
    ReferenceName { file: String },
}

impl Advice for MapError {
    fn ways(&self) -> &'static [Way] {
        match self {
            Self::NotAMap | Self::Format { .. } => &[Way::Columns],
            _ => &[],
        }
    }
}

/// Why a file gives no column map.
#[derive(Debug, thiserror::Error)]
pub enum MapFileError {
    #[error("{}: cannot be read: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("{}: {source}", path.display())]
    Map { path: PathBuf, source: MapError },
}

impl Advice for MapFileError {
    fn ways(&self) -> &'static [Way] {
        match self {
            Self::Map { source, .. } => source.ways(),
            Self::Io { .. } => &[],
        }
    }
}
