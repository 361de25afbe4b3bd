//! Warnings about faults in a file that can still be read. There is one warning for each kind of fault, with a count.

use std::path::Path;

use super::named_column::NamedColumn;
use crate::{
    finding::{Finding, Id, Place, Verdict},
    recording::{SAME_LOAD_SHARE, units::TimeUnit},
    shown::{counted, listed, shown},
};

/// Cause of a warning: a fault of a file, or an assumption that was made in reading it. Columns are counted from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Cause {
    #[error("{column} {}. Row skipped", trouble.message(&shown(value)))]
    Cell { column: NamedColumn, value: String, trouble: Trouble },
    #[error("the row has {actual} cells, but the table has {expected} columns. Row skipped")]
    TooFewCells { expected: usize, actual: usize },
    #[error(
        "the row has {actual} cells, but the table has {expected} columns. Extra cells ignored"
    )]
    TooManyCells { expected: usize, actual: usize },
    #[error("{column} contains {}. Its comma is read as a decimal point", shown(value))]
    DecimalComma { column: NamedColumn, value: String },
    /// The detected layout has decimal commas, so that they are no fault.
    #[error("numbers have decimal commas")]
    ExpectedComma,
    #[error("{column} is {value} in every row. Is the gauge connected?")]
    ConstantGauge { column: NamedColumn, value: f64 },
    #[error(
        "auxiliary channel {} has no value in {}{}. The previous value of the channel is used there",
        shown(name),
        counted(*n_rows, "row"),
        longest_secs.map_or_else(String::new, |secs| format!(", for at most {secs:.3} s"))
    )]
    HeldAuxiliary { name: String, n_rows: usize, longest_secs: Option<f64> },
    #[error("time jumps from {from_secs} s to {to_secs} s, so a new recording starts")]
    NewRecording { from_secs: f64, to_secs: f64 },
    #[error(
        "time goes back from {from_secs} s to {to_secs} s like a 32-bit counter that wraps around. The later times are increased to continue the earlier ones"
    )]
    WrappedClock { from_secs: f64, to_secs: f64 },
    #[error(
        "rows come in bursts, with pauses of about {pause_secs:.2} s that end no recording. Only a pause longer than {gap_secs} s does; \"gap_secs\" in a column map changes this"
    )]
    Bursts { pause_secs: f64, gap_secs: f64 },
    #[error("the newest row comes first in the file, so the order of the rows is reversed")]
    NewestFirst,
    #[error("the row has the same time as the row before, {time_secs} s")]
    RepeatedTime { time_secs: f64 },
    #[error(
        "{count} rows have a slightly earlier time than the row before, so each starts a new recording. \"stamps\": \"sorted\" in a column map sorts rows by time"
    )]
    LateRows { count: usize },
    #[error(
        "most rows repeat the time of the row before. \"stamps\": \"spread\" in a column map spreads them evenly up to the next time"
    )]
    CoarseStamps,
    #[error(
        "the time in {column} has no unit and is read in {unit}, which its values suggest. Give the unit, e.g. t_{unit} in the header",
        unit = unit.symbol()
    )]
    AssumedTimeUnit { column: NamedColumn, unit: TimeUnit },
    #[error(
        "the dates of {column} are read as {order}, but could also be {other}. If {other} is right, set \"unit\": \"{other}\" in a column map"
    )]
    AssumedDateOrder { column: NamedColumn, order: &'static str, other: &'static str },
    #[error(
        "several columns could be the time of the samples. Used: {}. Ignored: {}",
        shown(used),
        listed(others)
    )]
    SeveralTimes { used: String, others: Vec<String> },
    #[error(
        "{n_tables} tables stand side by side, each with its clock. Only columns {first} to {last} are read; to read another table, give one of its columns a role by its number, e.g. --columns \"{}=Fz N\"", last + 2
    )]
    SideBySide { n_tables: usize, first: usize, last: usize },
    #[error(
        "several columns could be the reference load. Used: {}. Ignored: {}. To use others, choose them in a column map",
        listed(used),
        listed(others)
    )]
    SeveralReferences { used: Vec<String>, others: Vec<String> },
    #[error("ignored columns: {}", listed(names))]
    IgnoredColumns { names: Vec<String> },
    #[error(
        "numbers far outside the other values of a column are read as missing values: {}. If they are values, use a column map without \"dropouts\"",
        listed(columns)
    )]
    MissingMarks { columns: Vec<String> },
    #[error(
        "each row holds either gauges or the reference. The reference is interpolated at the times of the gauges"
    )]
    TurnByTurn,
    #[error("no reference load near the time {time_secs} s of a gauge sample. Sample skipped")]
    NoReferenceThen { time_secs: f64 },
    #[error("the orientation in the pose is not a rotation. Row skipped")]
    NotARotation,
    #[error(
        "these data of the file are ignored, because they are not part of its table: {}",
        listed(names)
    )]
    LeftOut { names: Vec<String> },
    #[error(
        "no column is a time, so the {n_rows} rows are read as {n_cases} load cases (loads within {} % of the largest load are one case). If this is a recording, name its time t or time, or set \"sample_rate_hz\" in a column map",
        100.0 * SAME_LOAD_SHARE
    )]
    LoadCases { n_rows: usize, n_cases: usize },
    #[error(
        "no column is a time, so the order of the {n_rows} rows is their order in time. For times, name the time t or time, or set \"sample_rate_hz\""
    )]
    RowOrder { n_rows: usize },
    #[error("{n} rows of {n} numbers: this may be a calibration matrix, and no recording")]
    Square { n: usize },
    #[error(
        "the file holds several tables. Read: {}. Not read: {}. To choose others, list them as \"parts\" in a column map",
        listed(used),
        listed(others)
    )]
    SeveralParts { used: Vec<String>, others: Vec<String> },
    #[error("{how}")]
    Reshaped { how: &'static str },
    #[error("the file ends in the middle of the data. All complete rows are read")]
    EndsEarly,
}

impl Cause {
    fn id(&self) -> Id {
        match self {
            Self::Cell { .. } | Self::TooFewCells { .. } | Self::NotARotation => Id::RowsSkipped,
            Self::TooManyCells { .. }
            | Self::IgnoredColumns { .. }
            | Self::LeftOut { .. }
            | Self::EndsEarly
            | Self::NoReferenceThen { .. } => Id::PartsIgnored,
            Self::ExpectedComma | Self::ConstantGauge { .. } | Self::HeldAuxiliary { .. } => {
                Id::Values
            }
            Self::NewRecording { .. }
            | Self::NewestFirst
            | Self::WrappedClock { .. }
            | Self::RepeatedTime { .. }
            | Self::TurnByTurn => Id::Stamps,
            _ => Id::Assumed,
        }
    }

    pub(crate) fn finding(&self, place: &Place, path: &Path) -> Finding {
        let place = Place { path: path.to_owned(), ..place.clone() };
        let found = Finding::new(self.id(), Verdict::Doubtful, self.to_string());
        Finding { place: Some(place), ..found }
    }

    /// Returns true if both causes are reported in one warning.
    fn is_of_kind(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Cell { trouble, .. }, Self::Cell { trouble: other, .. }) => trouble == other,
            // These causes are reported for each column separately.
            (Self::ConstantGauge { .. } | Self::HeldAuxiliary { .. }, _) => false,
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }
}

/// Reason why a row is skipped because of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
    Empty,
    NotANumber,
    NotFinite,
    NotATime,
    StatusError,
    Dropout,
    Overload,
}

impl Trouble {
    /// Returns true if the column map asks for rows with this cell to be skipped, so that the cell is not a fault of the
    /// file.
    pub const fn is_wanted(self) -> bool {
        matches!(self, Self::StatusError | Self::Dropout)
    }

    fn message(self, value: &str) -> String {
        match self {
            Self::Empty => "is empty".to_owned(),
            Self::NotANumber => format!("contains \"{value}\", not a number"),
            Self::NotFinite => format!("contains {value}, not a finite number"),
            Self::Overload => {
                format!("contains {value}, by which a meter reports that its range is exceeded")
            }
            Self::NotATime => format!(
                "contains \"{value}\", which is not a time in the notation of the other rows"
            ),
            Self::StatusError => {
                format!("is {value}, a status by which the device reports an error")
            }
            Self::Dropout => format!("contains {value}, which marks a missing value"),
        }
    }
}

/// Warnings about a block of a file, one for each kind of cause, with line numbers but without the path of the file.
#[derive(Debug, Default)]
pub struct Findings(Vec<(Cause, Place)>);

impl Findings {
    /// Adds a cause of a warning. If a cause of the same kind is already there, it is only counted.
    pub fn note(&mut self, line: u64, cause: Cause) {
        self.note_many(line, line, 1, cause);
    }

    pub fn note_many(&mut self, first_line: u64, last_line: u64, count: u64, cause: Cause) {
        self.add(cause, Place { first_line, last_line, count, ..Place::default() });
    }

    /// Appends the warnings about the next block of the file. `lines_before` is the number of lines before this block.
    pub fn append(&mut self, later: Self, lines_before: u64) {
        for (cause, mut place) in later.0 {
            place.first_line += lines_before;
            place.last_line += lines_before;
            self.add(cause, place);
        }
    }

    fn add(&mut self, cause: Cause, place: Place) {
        match self.0.iter_mut().find(|(old, _)| old.is_of_kind(&cause)) {
            Some((_, old)) => {
                old.count += place.count;
                old.last_line = place.last_line;
            }
            None => self.0.push((cause, place)),
        }
    }

    fn skipped(&self) -> impl Iterator<Item = &(Cause, Place)> {
        self.0.iter().filter(|(cause, _)| cause.id() == Id::RowsSkipped)
    }

    /// Returns the number of skipped rows. Rows that are skipped because a value is missing (an empty cell, NaN, a mark) or
    /// infinite are not counted.
    pub fn not_understood(&self) -> u64 {
        let is_missing = |cause: &Cause| {
            use Trouble::{Dropout, Empty, NotFinite};
            matches!(cause, Cause::Cell { trouble: NotFinite | Empty | Dropout, .. })
        };
        self.skipped().filter(|(cause, _)| !is_missing(cause)).map(|(_, place)| place.count).sum()
    }

    pub fn most_skipped(&self) -> Option<&(Cause, Place)> {
        self.skipped().max_by_key(|(_, place)| place.count)
    }

    /// Returns the number of rows that are skipped because they have too few cells.
    pub fn short_rows(&self) -> u64 {
        let is_short = |(cause, _): &&(Cause, Place)| matches!(cause, Cause::TooFewCells { .. });
        self.0.iter().find(is_short).map_or(0, |(_, place)| place.count)
    }

    /// Returns the shortest pause (s) that starts a new recording, if it was derived from rows in bursts because the map sets
    /// none.
    pub fn assumed_gap_secs(&self) -> Option<f64> {
        self.0.iter().find_map(|(cause, _)| match cause {
            Cause::Bursts { gap_secs, .. } => Some(*gap_secs),
            _ => None,
        })
    }

    /// Returns the warnings about the file at `path` as findings, in the order of their first lines.
    pub fn into_findings(mut self, path: &Path) -> Vec<Finding> {
        self.0.sort_by_key(|(_, place)| place.first_line);
        if self.0.iter().any(|(cause, _)| *cause == Cause::ExpectedComma) {
            let is_of_commas =
                |cause: &Cause| matches!(cause, Cause::ExpectedComma | Cause::DecimalComma { .. });
            self.0.retain(|(cause, _)| !is_of_commas(cause));
        }
        self.0.iter().map(|(cause, place)| cause.finding(place, path)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares a finding with a cause by kind and text.
    impl PartialEq<Cause> for Finding {
        fn eq(&self, cause: &Cause) -> bool {
            self.id == cause.id() && self.seen == cause.to_string()
        }
    }

    #[test]
    fn one_kind_is_one_warning_across_intervals() {
        let empty = |column: usize| Cause::Cell {
            column: NamedColumn::new(column - 1, "S1"),
            value: String::new(),
            trouble: Trouble::Empty,
        };
        let mut findings = Findings::default();
        findings.note(3, empty(2));
        let mut later = Findings::default();
        later.note(4, empty(5));
        later.note(6, empty(2));
        findings.append(later, 100);
        let warnings = findings.into_findings(Path::new("a.csv"));
        assert_eq!(warnings.len(), 1);
        let place = warnings[0].place.as_ref().unwrap();
        assert_eq!((place.count, place.last_line), (3, 106));
        let message = warnings[0].to_string();
        assert!(message.starts_with("a.csv, line 3: column 2 (S1) is empty"));
        assert!(message.ends_with("(3 times, last on line 106)"));
    }
}
