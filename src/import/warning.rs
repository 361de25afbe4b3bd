//! Warnings about files that are read in spite of faults: one warning per kind and file, with a count.

use std::fmt;
use std::path::{Path, PathBuf};

use super::named_column::NamedColumn;
use crate::finding::{Advice, Way};
use crate::recording::units::TimeUnit;
use crate::recording::{Axis, SAME_LOAD_SHARE};
use crate::shown::{listed, shown};

/// Warning about a file that was read. Lines are counted from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadWarning {
    /// Path of the file.
    pub path: PathBuf,
    /// First line concerned.
    pub first_line: u64,
    /// Last line concerned.
    pub last_line: u64,
    /// Number of occurrences.
    pub count: u64,
    /// Cause at the first line.
    pub cause: Cause,
}

/// Cause of a warning. Columns are counted from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Cause {
    #[error("{column} {}", trouble.message(&shown(value)))]
    Cell { column: NamedColumn, value: String, trouble: Trouble },
    #[error("{actual} cells, but the table has {expected} columns. Row skipped")]
    TooFewCells { expected: usize, actual: usize },
    #[error("{actual} cells, but the table has {expected} columns. Extra cells ignored")]
    TooManyCells { expected: usize, actual: usize },
    #[error("{column} contains {}. Its comma is read as a decimal point", shown(value))]
    DecimalComma { column: NamedColumn, value: String },
    #[error("column {column} (gauge {}) is {value} in every row. Is it connected?", shown(name))]
    ConstantGauge { column: usize, name: String, value: f64 },
    #[error(
        "{}auxiliary {}) has no value in {}{}. The previous value is used there",
        column.map_or_else(|| "a channel (".to_owned(), |column| format!("column {column} (")),
        shown(name),
        if *n_rows == 1 { "a row".to_owned() } else { format!("{n_rows} rows") },
        longest_secs.map_or_else(String::new, |secs| format!(", for at most {secs:.3} s"))
    )]
    HeldAuxiliary { column: Option<usize>, name: String, n_rows: usize, longest_secs: Option<f64> },
    #[error("time goes from {from_secs} s to {to_secs} s. A new recording starts")]
    NewRecording { from_secs: f64, to_secs: f64 },
    #[error(
        "time goes back from {from_secs} s to {to_secs} s like a 32-bit counter that wraps around. Times are continued"
    )]
    WrappedClock { from_secs: f64, to_secs: f64 },
    #[error(
        "rows come in bursts, with pauses of about {pause_secs:.2} s that end no recording. Only a pause longer than {gap_secs} s ends one. If this is wrong, set \"gap_secs\" in a column map"
    )]
    Bursts { pause_secs: f64, gap_secs: f64 },
    #[error("time {time_secs} s repeats the time of the row before")]
    RepeatedTime { time_secs: f64 },
    #[error(
        "{count} rows stand after rows with later times, each less than a gap late. To sort rows by time, set \"stamps\": \"sorted\" under \"table\" in a column map"
    )]
    LateRows { count: usize },
    #[error(
        "most rows repeat the time of the row before. To spread them evenly up to the next time, set \"stamps\": \"spread\" under \"table\" in a column map"
    )]
    CoarseStamps,
    #[error(
        "{column} has no unit and is read in {unit}, judged by its values. Give the unit, e.g. t_{unit} in the header or \"unit\": \"{unit}\" in a column map",
        unit = unit.symbol()
    )]
    AssumedTimeUnit { column: NamedColumn, unit: TimeUnit },
    #[error(
        "the dates of {column} are read as {order}, but could also be {other}. If they are, set \"unit\": \"{other}\" in a column map"
    )]
    AssumedDateOrder { column: NamedColumn, order: &'static str, other: &'static str },
    #[error(
        "several columns could be the time. Used: {}. Ignored: {}",
        shown(used),
        listed(others)
    )]
    SeveralTimes { used: String, others: Vec<String> },
    #[error(
        "several columns could be the reference. Used: {}. Ignored: {}. To use others, choose them in a column map (\"is\": \"Fx\" and so on)",
        listed(used),
        listed(others)
    )]
    SeveralReferences { used: Vec<String>, others: Vec<String> },
    #[error("ignored columns: {}", listed(names))]
    IgnoredColumns { names: Vec<String> },
    #[error(
        "{} looks like a load without an axis, so it is not used as the reference. Name it Fx, Fy, Fz, Mx, My or Mz, or choose its axis in a column map",
        listed(names)
    )]
    UnnamedLoads { names: Vec<String> },
    #[error("{n_lines} lines above the table are skipped")]
    SkippedPreamble { n_lines: usize },
    #[error(
        "each row holds either gauges or the reference, at its own time. The reference is interpolated at the times of the gauges"
    )]
    TurnByTurn,
    #[error(
        "the reference changes only every {samples_each} samples (sample-and-hold). It lags behind the gauges by up to {samples_each} samples"
    )]
    HeldReference { samples_each: usize },
    #[error("no reference at {time_secs} s on the gauges' clock. Sample skipped")]
    NoReferenceThen { time_secs: f64 },
    #[error(
        "the pose is not a rotation but a quaternion of length zero or a matrix that is not orthogonal. Row skipped"
    )]
    NotARotation,
    #[error(
        "the weight's own acceleration adds up to {percent:.1} % of the full scale of {}{}",
        axis.symbol(),
        if *is_counted {
            ". This part is only as accurate as the pose"
        } else {
            " and is left out. Move more slowly, or set \"inertia\" under \"weight\" in the column map"
        }
    )]
    Inertia { axis: Axis, percent: f64, is_counted: bool },
    #[error("not part of the table, so left out: {}", listed(names))]
    LeftOut { names: Vec<String> },
    #[error(
        "no column is a time, so the {n_rows} rows are read as {n_cases} load cases (loads within {} % are the same). Features of the past cannot be fitted, and cross-validation leaves out whole load cases. If this is a recording, name its time t or time, or set \"sample_rate_hz\" in a column map",
        100.0 * SAME_LOAD_SHARE
    )]
    LoadCases { n_rows: usize, n_cases: usize },
    #[error(
        "the file holds several tables. Read: {}. Not read: {}. To choose others, list them as \"parts\" under \"text\" in a column map",
        listed(used),
        listed(others)
    )]
    SeveralParts { used: Vec<String>, others: Vec<String> },
    #[error("the file ends early, as if its recorder was stopped. The existing part is read")]
    EndsEarly,
    #[error("{n_before} samples in bursts are averaged to {n_after}")]
    AveragedBursts { n_before: usize, n_after: usize },
}

impl Advice for LoadWarning {
    fn ways(&self) -> &'static [Way] {
        use Cause::{AssumedDateOrder, AssumedTimeUnit, Bursts, CoarseStamps, LateRows};
        use Cause::{LoadCases, SeveralParts, SeveralReferences, UnnamedLoads};
        match self.cause {
            AssumedDateOrder { .. } | AssumedTimeUnit { .. } | Bursts { .. } | CoarseStamps => {
                &[Way::Columns]
            }
            LateRows { .. } | LoadCases { .. } | SeveralParts { .. } => &[Way::Columns],
            SeveralReferences { .. } | UnnamedLoads { .. } => &[Way::Columns],
            _ => &[],
        }
    }
}

impl Cause {
    /// Returns true if both causes are counted in one warning.
    fn is_of_kind(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Cell { trouble, .. }, Self::Cell { trouble: other, .. }) => trouble == other,
            // The columns differ, so each has its own warning.
            (Self::ConstantGauge { .. } | Self::HeldAuxiliary { .. }, _) => false,
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }

    /// Returns true if a row is skipped for this cause.
    pub(super) const fn skips_row(&self) -> bool {
        matches!(self, Self::Cell { .. } | Self::TooFewCells { .. } | Self::NotARotation)
    }
}

/// Reason why a cell makes its row unusable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    Empty,
    NotANumber,
    NotFinite,
    NotATime,
    StatusError,
    Dropout,
    Overload,
    UnknownMount,
}

impl Trouble {
    /// Returns true if the map itself requires that the row is skipped.
    pub(super) const fn is_wanted(self) -> bool {
        matches!(self, Self::StatusError | Self::Dropout)
    }

    fn message(self, value: &str) -> String {
        match self {
            Self::Empty => "is empty. Row skipped".to_owned(),
            Self::NotANumber => format!("contains \"{value}\", not a number. Row skipped"),
            Self::NotFinite => format!("contains {value}, not a finite number. Row skipped"),
            Self::Overload => {
                format!("contains {value}, the code of a meter for out of range. Row skipped")
            }
            Self::NotATime => {
                format!("contains \"{value}\", not a time as in the other rows. Row skipped")
            }
            Self::StatusError => format!("is {value}, which reports an error. Row skipped"),
            Self::Dropout => format!("contains {value}, the mark of a missing value. Row skipped"),
            Self::UnknownMount => {
                format!("contains \"{value}\", not a mount of the column map. Row skipped")
            }
        }
    }
}

impl fmt::Display for LoadWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, line {}: {}", self.path.display(), self.first_line, self.cause)?;
        if self.count > 1 {
            write!(f, " ({} times, last on line {})", self.count, self.last_line)?;
        }
        Ok(())
    }
}

/// Warnings about one interval of a file, one per kind. The path is set at the end.
#[derive(Debug, Default)]
pub(super) struct Findings(Vec<LoadWarning>);

impl Findings {
    /// Adds a cause. The first one of each kind is kept, later ones are only counted.
    pub fn note(&mut self, line: u64, cause: Cause) {
        self.note_many(line, line, 1, cause);
    }

    /// Adds `count` occurrences of a cause at once.
    pub fn note_many(&mut self, first: u64, last: u64, count: u64, cause: Cause) {
        self.add(LoadWarning {
            path: PathBuf::new(),
            first_line: first,
            last_line: last,
            count,
            cause,
        });
    }

    /// Appends the warnings about the next interval; its line 1 is line `lines_before + 1` here.
    pub fn append(&mut self, later: Self, lines_before: u64) {
        for mut collected in later.0 {
            collected.first_line += lines_before;
            collected.last_line += lines_before;
            self.add(collected);
        }
    }

    fn add(&mut self, new: LoadWarning) {
        let same = |old: &&mut LoadWarning| old.cause.is_of_kind(&new.cause);
        match self.0.iter_mut().find(same) {
            Some(old) => {
                old.count += new.count;
                old.last_line = new.last_line;
            }
            None => self.0.push(new),
        }
    }

    /// Returns the number of rows that are skipped for a cell that is not a number, or for missing cells.
    pub fn not_understood(&self) -> u64 {
        let is_nan = |own: &&LoadWarning| matches!(&own.cause, Cause::Cell { trouble, .. } if *trouble == Trouble::NotFinite);
        let skipped = self.0.iter().filter(|own| own.cause.skips_row() && !is_nan(own));
        skipped.map(|own| own.count).sum()
    }

    /// Returns the most frequent reason for a skipped row.
    pub fn first_skipped(&self, path: &Path) -> Option<LoadWarning> {
        let skipped = self.0.iter().filter(|own| own.cause.skips_row());
        let most = skipped.max_by_key(|own| own.count)?;
        Some(LoadWarning { path: path.to_owned(), ..most.clone() })
    }

    /// Returns the number of rows that are skipped because they have too few cells.
    pub fn short_rows(&self) -> u64 {
        let is_short = |c: &&LoadWarning| matches!(c.cause, Cause::TooFewCells { .. });
        self.0.iter().find(is_short).map_or(0, |c| c.count)
    }

    /// Returns the warnings about the file at `path`, in the order of their first lines.
    pub fn into_warnings(mut self, path: &Path) -> Vec<LoadWarning> {
        self.0.sort_by_key(|collected| collected.first_line);
        for warning in &mut self.0 {
            warning.path = path.to_owned();
        }
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let warnings = findings.into_warnings(Path::new("a.csv"));
        assert_eq!(warnings.len(), 1);
        assert_eq!((warnings[0].count, warnings[0].last_line), (3, 106));
        let message = warnings[0].to_string();
        assert!(message.starts_with("a.csv, line 3: column 2 (S1) is empty"));
        assert!(message.ends_with("(3 times, last on line 106)"));
    }
}
