//! Why a column map is of no use, in one sentence each.

use std::io;
use std::path::PathBuf;

/// Why a column map is of no use, whatever the recording.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum MapError {
    #[error("no JSON of a column map: {0}")]
    Json(#[from] serde_json::Error),
    #[error(
        "not a column map: its \"format\" is {found} where \"{expected}\" is needed; `loopscope inspect FILE --write-map MAP.json` writes one"
    )]
    Format {
        found: String,
        expected: &'static str,
    },
    #[error("a column map of version {found}, this program reads version {known}; get a newer one")]
    Version { found: u64, known: u32 },
    #[error("a column cannot be \"{name}\"; known: {known}")]
    UnknownRole { name: String, known: String },
    #[error("a column cannot be \"{name}\" yet: the name is kept for poses; use \"ignore\"")]
    ReservedRole { name: String },
    #[error("column {number} does not exist: \"shape\" says {columns} columns, counted from 1")]
    NoSuchColumn { number: usize, columns: usize },
    #[error(
        "{columns} columns in \"shape\", but {names} names; give each column its name, or none"
    )]
    ShapeNames { columns: usize, names: usize },
    #[error("column {column} is listed twice; say once what it is")]
    ListedTwice { column: String },
    #[error(
        "column \"{name}\" is listed by its name, but \"text\" says that there is no header; use its number"
    )]
    NameWithoutHeader { name: String },
    #[error("{what} is {value}; it must be {must}")]
    Number {
        what: String,
        value: f64,
        must: &'static str,
    },
    #[error(
        "the reference's file is \"{file}\"; name a file as seen from the recording's folder, e.g. \"states.csv\" or \"{{stem}}_ref.csv\""
    )]
    ReferenceName { file: String },
}

/// Why a file gives no column map.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum MapFileError {
    #[error("{}: cannot be read: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("{}: {source}", path.display())]
    Map { path: PathBuf, source: MapError },
}
