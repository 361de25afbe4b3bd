//! Why a file gives no recording, in one sentence each.

use std::io;
use std::path::PathBuf;

use super::warning::LoadWarning;
use crate::formats::ArraysError;
use crate::import::map::{ColumnKey, ColumnRole, MapError};
use crate::progress::Cancelled;
use crate::recording::{Axis, TareError};
use crate::shown::{listed, shown};

/// The way out where names settle too little.
const HOW_TO_MAP: &str = "`loopscope inspect FILE --write-map MAP.json`, then `--columns MAP.json`";
/// The way out where a map does not fit.
const OTHER_MAP: &str = "take another map, or none; `loopscope inspect` shows what the file holds";
/// Why a file gives no recording. Columns and lines are counted from 1.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ReadError {
    #[error("{}: a folder and not a file; name the recordings in it ({}), or many by a pattern such as {}", path.display(), listed(files), path.join("*.csv").display())]
    Folder { path: PathBuf, files: Vec<String> },
    #[error("{}: not a file but a pipe or a device; save what comes of it, and choose that file", path.display())]
    NotAFile { path: PathBuf },
    #[error("{}: cannot be read: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("{}: the file is empty; choose another, or record it again", path.display())]
    Empty { path: PathBuf },
    #[error("{}: not text but {what}; unpack it, or export the recording as CSV", path.display())]
    NotText { path: PathBuf, what: &'static str },
    #[error("{}: {source}", path.display())]
    Arrays { path: PathBuf, source: ArraysError },
    #[error("{}: an array of {columns} columns without names; say what they are in a column map ({HOW_TO_MAP})", path.display())]
    NoNames { path: PathBuf, columns: usize },
    #[error("{}: a line is longer than {limit_bytes} bytes, so this is no table with one row per line; choose a text file with one row per sample", path.display())]
    LineTooLong { path: PathBuf, limit_bytes: usize },
    #[error("{}: no header: all lines are blank or comments (#); name the columns, e.g. t,S1,S2,Fx", path.display())]
    NoHeader { path: PathBuf },
    #[error("{}:{line}: no header: the first line holds only numbers; name the columns, e.g. t,S1,S2,Fx, in a line without #, or say what they are in a column map ({HOW_TO_MAP})", path.display())]
    HeaderIsNumbers { path: PathBuf, line: u64 },
    #[error("{}:{line}: no time column among {}; name one t or time, with its unit, e.g. t_ms, or say in a column map which it is ({HOW_TO_MAP})", path.display(), listed(names))]
    NoTime {
        path: PathBuf,
        line: u64,
        names: Vec<String>,
    },
    #[error("{}:{line}: no gauge column among {}; name them S1, S2 and so on (also ch1, ai0, SG1, raw_1), or say in a column map which they are ({HOW_TO_MAP})", path.display(), listed(names))]
    NoGauges {
        path: PathBuf,
        line: u64,
        names: Vec<String>,
    },
    #[error("{}:{line}: {count} gauge columns where at most {limit} are supported: {}", path.display(), listed(names))]
    TooManyGauges {
        path: PathBuf,
        line: u64,
        count: usize,
        limit: usize,
        names: Vec<String>,
    },
    #[error("{}:{line}: columns {first} and {second} are both gauge {}; give each its own name", path.display(), shown(name))]
    DuplicateGauge {
        path: PathBuf,
        line: u64,
        name: String,
        first: usize,
        second: usize,
    },
    #[error("{}:{line}: columns {first} and {second} are both {}; rename the one that is not the reference", path.display(), axis.symbol())]
    DuplicateAxis {
        path: PathBuf,
        line: u64,
        axis: Axis,
        first: usize,
        second: usize,
    },
    #[error("{}:{line}: column {column} ({}) has the unknown unit {}; understood here: {known}", path.display(), shown(name), shown(unit))]
    UnknownUnit {
        path: PathBuf,
        line: u64,
        column: usize,
        name: String,
        unit: String,
        known: &'static str,
    },
    #[error("{}:{line}: no reference load among {}; name its columns Fx, Fy and so on, or say in a column map which they are ({HOW_TO_MAP})", path.display(), listed(names))]
    NoLoads {
        path: PathBuf,
        line: u64,
        names: Vec<String>,
    },
    #[error("{}:{line}: a log of ATI's Net F/T: it holds the reference load, but no gauges; name it as \"reference\" in the column map of the file with the gauges", path.display())]
    ReferenceAlone { path: PathBuf, line: u64 },
    #[error("{}:{line}: column {column} ({}) counts samples, but nothing says how many make a second; add \"sample_rate_hz\" to the column map", path.display(), shown(name))]
    NoSampleRate {
        path: PathBuf,
        line: u64,
        column: usize,
        name: String,
    },
    #[error("{}:{line}: columns {first} and {second} are both \"{role}\" in the column map; only one can be", path.display())]
    RoleTwice {
        path: PathBuf,
        line: u64,
        role: ColumnRole,
        first: usize,
        second: usize,
    },
    #[error(transparent)]
    Tare(#[from] TareError),
    #[error("the column map: {0}")]
    Map(#[from] MapError),
    #[error("{}: the column map is for another kind of file: it speaks of {what}, and the start of this file does not have them; {OTHER_MAP}", path.display())]
    TooShortForMap { path: PathBuf, what: &'static str },
    #[error("{}:{line}: the column map is for files with {expected} columns, this one has {actual}; {OTHER_MAP}", path.display())]
    MapShape {
        path: PathBuf,
        line: u64,
        expected: usize,
        actual: usize,
    },
    #[error("{}:{line}: the column map is for another kind of file: column {column} is {} where {} is expected; {OTHER_MAP}", path.display(), shown(actual), shown(expected))]
    MapOtherName {
        path: PathBuf,
        line: u64,
        column: usize,
        expected: String,
        actual: String,
    },
    #[error("{}:{line}: the column map needs a column {}, here are {}; {OTHER_MAP}", path.display(), shown(expected), listed(names))]
    MapNoColumn {
        path: PathBuf,
        line: u64,
        expected: String,
        names: Vec<String>,
    },
    #[error("{}:{line}: columns {first} and {second} are both called {}; list them in the column map by their numbers", path.display(), shown(name))]
    MapSameNames {
        path: PathBuf,
        line: u64,
        name: String,
        first: usize,
        second: usize,
    },
    #[error("{}:{line}: the column map speaks of column {column} twice, as {} and as {}; say once what it is", path.display(), quoted(first), quoted(second))]
    MapTwice {
        path: PathBuf,
        line: u64,
        column: usize,
        first: ColumnKey,
        second: ColumnKey,
    },
    #[error("{}:{line}: the reference's time goes back from {from_secs} s to {to_secs} s; two clocks can be joined only where both go on, so cut the files there", path.display())]
    ReferenceGoesBack {
        path: PathBuf,
        line: u64,
        from_secs: f64,
        to_secs: f64,
    },
    #[error("{}: the name of the file holds none of the mounts {}, or two of them; name it after one, or make a column \"mount\"", path.display(), listed(mounts))]
    NoMount { path: PathBuf, mounts: Vec<String> },
    #[error("{}: a weight is found by the forces on it: map a pose, and the columns Fx, Fy and Fz (Mx, My and Mz for its centre)", path.display())]
    NothingToWeigh { path: PathBuf },
    #[error("{}: gravity keeps its direction in the sensor's frame, so a weight cannot be told from an offset; turn the sensor", path.display())]
    NeverTurned { path: PathBuf },
    #[error("{}: no sample has a reference: the gauges run from {} s to {} s, the reference in {} from {} s to {} s; if their clocks differ, set \"clock_offset_secs\" under \"join\" in the column map (`loopscope inspect` estimates it)", path.display(), gauges.0, gauges.1, reference_path.display(), reference.0, reference.1)]
    ClocksApart {
        path: PathBuf,
        reference_path: PathBuf,
        gauges: (f64, f64),
        reference: (f64, f64),
    },
    #[error("{}:{line}: no rows follow the header", path.display())]
    NoRows { path: PathBuf, line: u64 },
    #[error("{}:{line}: {what} {} (column {column}) has no number in any row; mend or delete the column", path.display(), shown(name))]
    NoNumberInColumn {
        path: PathBuf,
        line: u64,
        what: &'static str,
        column: usize,
        name: String,
    },
    #[error("{first} - and no other row is usable either")]
    NoUsableRow { first: Box<LoadWarning> },
    #[error("{}:{line}: time jumps or goes back at {count} places, the first here; is column {column} ({}) the time?", path.display(), shown(name))]
    TooManyRecordings {
        path: PathBuf,
        line: u64,
        count: usize,
        column: usize,
        name: String,
    },
    #[error("cancelled")]
    Cancelled,
}

impl ReadError {
    /// Whether somebody who says what the columns are would get past it.
    #[must_use]
    pub const fn wants_a_map(&self) -> bool {
        matches!(
            self,
            Self::HeaderIsNumbers { .. }
                | Self::NoTime { .. }
                | Self::NoGauges { .. }
                | Self::TooManyGauges { .. }
                | Self::DuplicateGauge { .. }
                | Self::DuplicateAxis { .. }
                | Self::UnknownUnit { .. }
                | Self::NoSampleRate { .. }
        )
    }
}

impl From<Cancelled> for ReadError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// What a map calls a column.
fn quoted(key: &ColumnKey) -> String {
    match key {
        ColumnKey::Number(number) => number.to_string(),
        ColumnKey::Name(name) => format!("\"{}\"", shown(name)),
    }
}
