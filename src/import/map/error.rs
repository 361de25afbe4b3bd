use std::io;
use std::path::PathBuf;

use crate::finding::{Advice, Way};
use crate::import::map::header::KeyError;
use crate::import::map::role::{Attitude, ColumnRole, PosePart};

/// Reason why a column map cannot be used for any file.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    #[error(
        "this is not JSON, so not a column map; write one from a recording with `inspect --write-map`"
    )]
    NotAMap,
    #[error("not valid JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error(
        "not a column map: its \"format\" is {found} instead of \"{expected}\"; write one from a recording with `inspect --write-map`"
    )]
    Format { found: String, expected: &'static str },
    #[error(
        "the map has version {found}, but this program reads version {known}; update the program"
    )]
    Version { found: String, known: u32 },
    #[error("the pose has a position but no orientation; add the columns {}", Attitude::listed())]
    NoAttitude,
    #[error("the pose has no {}; choose a column for this part of the pose", missing.words())]
    PoseIncomplete { missing: PosePart },
    #[error(
        "\"{first}\" and \"{second}\" both give the orientation of the sensor; keep one of them, and make the columns of the other \"ignore\""
    )]
    TwoPoses { first: ColumnRole, second: ColumnRole },
    #[error(
        "\"weight\" needs the pose of the sensor, but no column is part of a pose; give columns the roles pose_qw, pose_qx and so on"
    )]
    WeightWithoutPose,
    #[error(
        "with \"weight\" the load is computed from the pose, but a column is {role} as well; remove \"weight\" or that column"
    )]
    WeightAndLoad { role: ColumnRole },
    #[error(
        "{mount}: mass_kg or centre_m is missing, or the name is empty or used twice; give both values, for the weight or for each mount, and a name to each mount"
    )]
    WeightUnknown { mount: String },
    #[error(
        "a column is \"mount\", but \"weight\" has no list \"mounts\"; add the list, or make the column \"ignore\""
    )]
    NoMounts,
    #[error("column {number} does not exist: \"shape\" declares {columns} columns, counted from 1")]
    NoSuchColumn { number: usize, columns: usize },
    #[error(
        "\"shape\" declares {columns} columns but {names} names; give one name per column, or none"
    )]
    ShapeNames { columns: usize, names: usize },
    #[error(transparent)]
    Key(#[from] KeyError),
    #[error(
        "column \"{name}\" is listed by its name, but \"text\" declares that there is no header; use its number"
    )]
    NameWithoutHeader { name: String },
    #[error("{what} is {value}; it must be {must}")]
    Number { what: String, value: f64, must: &'static str },
    #[error(
        "the file of the reference is \"{file}\"; give a file name relative to the folder of the recording, e.g. \"states.csv\" or \"{{stem}}_ref.csv\""
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

/// Requirement on a number: its wording, and the function that tests it.
type Rule = (&'static str, fn(f64) -> bool);

pub(super) const FINITE: Rule = ("finite", f64::is_finite);
pub(super) const POSITIVE: Rule = ("greater than 0", |x| x > 0.0 && x.is_finite());
pub(super) const NOT_NEGATIVE: Rule = ("0 or more", |x| x >= 0.0);

/// Returns an error if a number of a column map does not meet a requirement. A missing number is valid.
pub(super) fn must(
    what: impl Into<String>,
    value: impl Into<Option<f64>>,
    (must, holds): Rule,
) -> Result<(), MapError> {
    match value.into() {
        Some(value) if !holds(value) => Err(MapError::Number { what: what.into(), value, must }),
        _ => Ok(()),
    }
}
