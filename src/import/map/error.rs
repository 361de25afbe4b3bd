use std::io;
use std::path::PathBuf;

use crate::{
    finding::{Advice, Way},
    import::map::{
        header::KeyError,
        role::{Attitude, ColumnRole},
    },
};

/// Reason why a column map cannot be used, whatever the file to be read.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    #[error("the file of the column map cannot be read: {0}")]
    Io(#[from] io::Error),
    #[error("this file is not JSON, so it is no column map; `inspect --write-map` writes one")]
    NotAMap,
    #[error("the column map is not valid JSON, or has an unknown entry: {0}")]
    Json(#[from] serde_json::Error),
    #[error(
        "this file is not a column map: its \"format\" is {found} instead of \"{expected}\"; `inspect --write-map` writes a column map"
    )]
    Format { found: String, expected: &'static str },
    #[error(
        "the column map has version {found} of the format, but this program reads version {known}; update the program"
    )]
    Version { found: String, known: u32 },
    #[error(
        "the pose of the sensor needs one whole orientation and no part of another one; give columns of the file the roles {}",
        Attitude::listed()
    )]
    Pose,
    #[error(
        "\"weight\" needs the pose of the sensor; give its columns the roles pose_qw, pose_qx and so on"
    )]
    WeightWithoutPose,
    #[error(
        "\"weight\" computes the reference load from the pose, but a column with the role {role} gives a measured load; remove \"weight\" or that column"
    )]
    WeightAndLoad { role: ColumnRole },
    #[error("\"weight\" needs both mass_kg and centre_m")]
    WeightUnknown,
    #[error(
        "the column map lists column {number}, but its \"shape\" declares only {columns} columns, counted from 1"
    )]
    NoSuchColumn { number: usize, columns: usize },
    #[error(
        "\"shape\" in the column map declares {columns} columns but {names} names; give one name for each column, or no names"
    )]
    ShapeNames { columns: usize, names: usize },
    #[error(transparent)]
    Key(#[from] KeyError),
    #[error(
        "column \"{name}\" is listed by its name, but \"text\" declares that the file has no header; list the column by its number"
    )]
    NameWithoutHeader { name: String },
    #[error("{what} is {value} in the column map, but must be {must}")]
    Number { what: String, value: f64, must: &'static str },
    #[error(
        "the file of the reference load is \"{file}\", which is not a file name; give one relative to the folder of the recording, e.g. \"{{stem}}_ref.csv\""
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

#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct MapFileError {
    pub path: PathBuf,
    pub source: MapError,
}

impl Advice for MapFileError {
    fn ways(&self) -> &'static [Way] {
        self.source.ways()
    }
}

/// Requirement on a number in a column map: its wording for messages, and a function that returns true if a number meets it.
type Rule = (&'static str, fn(f64) -> bool);

pub const FINITE: Rule = ("finite", f64::is_finite);
pub const POSITIVE: Rule = ("greater than 0", |x| x > 0.0 && x.is_finite());
pub const NOT_NEGATIVE: Rule = ("0 or more", |x| x >= 0.0);

/// Returns an error if a number of a column map does not meet a requirement. `what` names the number in the message. `None`
/// meets every requirement.
pub fn must(
    what: impl Into<String>,
    value: impl Into<Option<f64>>,
    (must, holds): Rule,
) -> Result<(), MapError> {
    match value.into() {
        Some(value) if !holds(value) => Err(MapError::Number { what: what.into(), value, must }),
        _ => Ok(()),
    }
}
