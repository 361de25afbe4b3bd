//! Errors that occur when a recording is read from a file. Each message names the place in the file and a remedy.

use std::path::{Path, PathBuf};

use super::named_column::NamedColumn;
use crate::{
    finding::{Advice, Finding, Way},
    formats::FileError,
    import::map::{KeyError, MapError},
    progress::Cancelled,
    recording::RecordingError,
    shown::{listed, shown},
};

/// Fault of a table because of which it cannot be read, at one line of the file. Columns are counted from 1.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    #[error("no table of numbers: there is no column of numbers among {}", listed(names))]
    NoNumbers { names: Vec<String> },
    #[error("no {what} among {}. {advice}, or choose it in a column map", listed(names))]
    Lacks { what: &'static str, advice: &'static str, names: Vec<String> },
    #[error("{count} {what}, but at most {limit} are supported: {}", listed(names))]
    TooMany { what: &'static str, count: usize, limit: usize, names: Vec<String> },
    #[error(
        "columns {first} and {second} are both read as {}. Rename one of the columns, or give it another role in a column map",
        shown(what)
    )]
    Twice { what: String, first: usize, second: usize },
    #[error("{column} has the unknown unit {}. Known units: {known}", shown(unit))]
    UnknownUnit { column: NamedColumn, unit: String, known: &'static str },
    #[error(
        "{column} counts samples instead of giving times, and the sample rate is unknown. Set \"sample_rate_hz\" in the column map"
    )]
    NoSampleRate { column: NamedColumn },
    #[error(
        "the time in {column} has no unit, and no unit fits its time steps of {step}: the calibration expects a sample every {trained_secs} s, and {nearest}, the best unit, is off by a factor of {off:.0}. Give the unit in the header, e.g. {} [ms]",
        shown(&column.name)
    )]
    NoTimeUnit {
        column: NamedColumn,
        step: f64,
        trained_secs: f64,
        nearest: &'static str,
        off: f64,
    },
    #[error(
        "the column map is for files with {expected} columns, but this file has {actual} columns. Use another column map, or none"
    )]
    MapShape { expected: usize, actual: usize },
    #[error(
        "the column map is for another kind of file: the name of column {column} is {} in this file, but {} in the map. Use another column map, or none",
        shown(actual),
        shown(expected)
    )]
    MapOtherName { column: usize, expected: String, actual: String },
    #[error(transparent)]
    MapKey(#[from] KeyError),
    #[error(
        "the time of the reference load goes back from {from_secs} s to {to_secs} s. Split the gauge file and the reference file at this time"
    )]
    ReferenceGoesBack { from_secs: f64, to_secs: f64 },
    #[error("the table has a header, but no rows after it")]
    NoRows,
    #[error(
        "it is not clear which columns of the rows are the gauges: {found}. The calibration needs the columns {}",
        listed(needed)
    )]
    UnclearRows { found: String, needed: Vec<String> },
    #[error("{column} has no number in any row. Correct or delete the column")]
    NoNumberInColumn { column: NamedColumn },
    #[error(
        "{column} jumps, goes back or changes in {count} rows, each of which would start a new recording. This is the first. Give the column another role if its role is wrong"
    )]
    TooManyRecordings { count: usize, column: NamedColumn },
}

impl TableError {
    pub fn no_time(names: Vec<String>) -> Self {
        let advice = "Name one t or time, with its unit, e.g. t_ms";
        Self::Lacks { what: "time column", advice, names }
    }

    pub fn no_gauges(names: Vec<String>) -> Self {
        let advice =
            "Name the gauges S1, S2 and so on (ch1, ai0, SG1 and raw_1 are also recognised)";
        Self::Lacks { what: "gauge column", advice, names }
    }
}

/// Reason why no recording can be read from a file. Lines are counted from 1.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages describe the fields")]
pub enum ReadError {
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: FileError },
    #[error("{}, line {line}: {source}", path.display())]
    Table { path: PathBuf, line: u64, source: TableError },
    #[error("{}: no header with the names of the columns: all lines are blank or comments (#). Add a header, e.g. t,S1,S2,Fx", path.display())]
    NoHeader { path: PathBuf },
    #[error(transparent)]
    Tare(#[from] RecordingError),
    #[error("the column map cannot be used: {0}")]
    Map(#[from] MapError),
    #[error("{}: the column map is for another kind of file: it expects {what} at the start of the file, but this file has none. Use another column map, or none", path.display())]
    TooShortForMap { path: PathBuf, what: &'static str },
    #[error("{}: estimating a weight needs the pose of the sensor and measured forces Fx, Fy and Fz, and for its centre also Mx, My and Mz. Choose their columns in a column map", path.display())]
    NothingToWeigh { path: PathBuf },
    #[error("{}: the sensor never turned, so the weight cannot be separated from the offset of the reference", path.display())]
    NeverTurned { path: PathBuf },
    #[error("{}: the forces do not change with the pose as those of a weight. Use a recording in which the sensor carries only the weight", path.display())]
    NoWeight { path: PathBuf },
    #[error("{}: no gauge sample has a reference load. The times of the gauges are {} s to {} s, those of the reference in {} are {} s to {} s. If the clocks differ, enter the clock offset", path.display(), gauges.0, gauges.1, reference_path.display(), reference.0, reference.1)]
    ClocksApart {
        path: PathBuf,
        reference_path: PathBuf,
        gauges: (f64, f64),
        reference: (f64, f64),
    },
    #[error("{first}. No other row of the table is usable either")]
    NoUsableRow { first: Box<Finding> },
    #[error(
        "{}: {skipped} of {rows} rows would be skipped, mostly because: {first}. Describe the layout of the table in a column map, or correct the file",
        path.display()
    )]
    ManySkipped { path: PathBuf, skipped: u64, rows: u64, first: Box<Finding> },
    #[error("{}: the reading was cancelled, but did not stop, and may use a processor core until the program ends. The file is probably damaged, or its drive does not answer", path.display())]
    Abandoned { path: PathBuf },
    #[error("cancelled")]
    Cancelled,
}

impl Advice for ReadError {
    fn ways(&self) -> &'static [Way] {
        use TableError as Of;
        match self {
            Self::TooShortForMap { .. }
            | Self::ManySkipped { .. }
            | Self::Table {
                source:
                    Of::Lacks { .. }
                    | Of::TooMany { .. }
                    | Of::Twice { .. }
                    | Of::UnknownUnit { .. }
                    | Of::NoSampleRate { .. }
                    | Of::NoTimeUnit { .. }
                    | Of::MapShape { .. }
                    | Of::MapOtherName { .. }
                    | Of::MapKey(KeyError::Missing { .. }),
                ..
            } => &[Way::Columns],
            Self::ClocksApart { .. } => &[Way::ClockOffset],
            Self::Tare(why) => why.ways(),
            Self::Map(why) => why.ways(),
            _ => &[],
        }
    }
}

impl ReadError {
    /// Returns true if the table could be read with a column map that gives the roles of its columns.
    pub fn wants_a_map(&self) -> bool {
        self.ways() == [Way::Columns]
    }
}

pub fn at(path: &Path, line: u64) -> impl Fn(TableError) -> ReadError {
    move |source| ReadError::Table { path: path.to_owned(), line, source }
}

pub fn of_file(path: &Path) -> impl Fn(FileError) -> ReadError {
    move |error| match error {
        FileError::Cancelled => ReadError::Cancelled,
        source => ReadError::File { path: path.to_owned(), source },
    }
}

impl From<Cancelled> for ReadError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}
