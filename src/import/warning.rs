//! What did not stop the reading, collected: one warning per kind and file, however often it happened.

use std::fmt;
use std::path::{Path, PathBuf};

use super::named_column::NamedColumn;
use crate::finding::{Advice, Way};
use crate::recording::units::TimeUnit;
use crate::recording::{Axis, SAME_LOAD_SHARE};
use crate::shown::{listed, shown};

/// Something a person should know about a file that was read all the same. Lines are counted from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadWarning {
    /// The file.
    pub path: PathBuf,
    /// The line where it happened first.
    pub first_line: u64,
    /// The line where it happened last.
    pub last_line: u64,
    /// How often it happened.
    pub count: u64,
    /// What happened first.
    pub cause: Cause,
}

/// What happened. Columns are counted from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Cause {
    /// A row is skipped or left out for one of its cells.
    #[error("{column} {}", trouble.told(&shown(value)))]
    Cell { column: NamedColumn, value: String, trouble: Trouble },
    /// A row is skipped: it is shorter than the header.
    #[error("{actual} cells where the table has {expected} columns; row skipped")]
    TooFewCells { expected: usize, actual: usize },
    /// A row is longer than the header; what is too much is left out.
    #[error("{actual} cells where the table has {expected} columns; the extra ones are ignored")]
    TooManyCells { expected: usize, actual: usize },
    /// A number with a comma where others write a point.
    #[error("{column} holds {}; its comma is read as a decimal point", shown(value))]
    DecimalComma { column: NamedColumn, value: String },
    /// A gauge that never changes.
    #[error("column {column} (gauge {}) is {value} in every row; is it connected?", shown(name))]
    ConstantGauge { column: usize, name: String, value: f64 },
    /// An auxiliary channel without numbers.
    #[error(
        "{}(auxiliary {}) has no number in {}{}; the one before is held there",
        column.map_or_else(String::new, |column| format!("column {column} ")),
        shown(name),
        if *n_rows == 1 { "a row".to_owned() } else { format!("{n_rows} rows") },
        longest_secs.map_or_else(String::new, |secs| format!(", for {secs:.3} s at the longest"))
    )]
    HeldAuxiliary { column: Option<usize>, name: String, n_rows: usize, longest_secs: Option<f64> },
    /// Time jumps or goes back, so that a new recording starts.
    #[error("time goes from {from_secs} s to {to_secs} s, so a new recording starts")]
    NewRecording { from_secs: f64, to_secs: f64 },
    /// A counter of the time begins anew.
    #[error(
        "time goes from {from_secs} s back to {to_secs} s as a counter of 32 bits does, and is taken to go on"
    )]
    WrappedClock { from_secs: f64, to_secs: f64 },
    /// Pauses that are taken for a logger's own, so that no new recording starts.
    #[error(
        "rows come in bursts, as some loggers write them, with pauses of about {pause_secs:.2} s that end no recording; only a pause longer than {gap_secs} s does; if that is wrong, say after what pause a new recording starts, as \"gap_secs\" in a column map"
    )]
    Bursts { pause_secs: f64, gap_secs: f64 },
    /// Two samples of one time.
    #[error("time {time_secs} s is that of the row before")]
    RepeatedTime { time_secs: f64 },
    /// Rows that a logger wrote late.
    #[error(
        "{count} rows stand after later ones, each less than a gap late; sorting by time puts them where they belong: \"stamps\": \"sorted\" under \"table\" in a column map"
    )]
    LateRows { count: usize },
    /// A clock that is coarser than the samples.
    #[error(
        "most rows have the time of the row before; \"stamps\": \"spread\" under \"table\" in a column map spreads them evenly until the next time"
    )]
    CoarseStamps,
    /// The header names no time unit, and the values do not look like seconds.
    #[error(
        "{column} names no unit; by its values it is read as {unit}: name the unit, e.g. t_{unit} in the header or \"unit\": \"{unit}\" in a column map",
        unit = unit.symbol()
    )]
    AssumedTimeUnit { column: NamedColumn, unit: TimeUnit },
    /// Day and month could stand the other way round.
    #[error(
        "the dates of {column} are read as {order}, and would be dates as {other} too; if they are, say \"unit\": \"{other}\" in a column map"
    )]
    AssumedDateOrder { column: NamedColumn, order: &'static str, other: &'static str },
    /// More than one column could be the time.
    #[error(
        "several columns could be the time: {} is used, ignored: {}",
        shown(used),
        listed(others)
    )]
    SeveralTimes { used: String, others: Vec<String> },
    /// More than one topic or struct could be the reference.
    #[error(
        "several columns could be the reference: {} are used, ignored: {}; if those are it, say so in a column map (\"is\": \"Fx\" and so on)",
        listed(used),
        listed(others)
    )]
    SeveralReferences { used: Vec<String>, others: Vec<String> },
    /// Columns that are neither time nor gauge nor reference.
    #[error("ignored columns: {}", listed(names))]
    IgnoredColumns { names: Vec<String> },
    /// Columns that look like loads and say no axis.
    #[error(
        "{} looks like a load and does not say which axis: it is not used as the reference; name it Fx, Fy, Fz, Mx, My or Mz, or say which it \
         is in a column map",
        listed(names)
    )]
    UnnamedLoads { names: Vec<String> },
    /// Lines above the header are no part of the table.
    #[error("{n_lines} lines above the table are skipped")]
    SkippedPreamble { n_lines: usize },
    /// A table whose rows hold either gauges or a reference.
    #[error(
        "rows hold either gauges or the reference, each at its own time: the reference is interpolated at the times of the gauges"
    )]
    TurnByTurn,
    /// A reference that is held between fewer measurements.
    #[error(
        "the reference changes only every {samples_each} samples and is held between (sample-and-hold): it lags behind the gauges by up to {samples_each} samples"
    )]
    HeldReference { samples_each: usize },
    /// A gauge sample at whose time there is no reference.
    #[error("no reference at {time_secs} s on the gauges' clock; sample left out")]
    NoReferenceThen { time_secs: f64 },
    /// A row is left out: its pose is no way to be turned.
    #[error(
        "the pose is no rotation (a quaternion of no length, or a matrix that is not orthogonal); row left out"
    )]
    NotARotation,
    /// A weight's own acceleration is more than can be left out.
    #[error(
        "the weight's own acceleration {} {percent:.1} % of the full scale of {}{}",
        if *is_counted { "makes up to" } else { "adds up to" },
        axis.symbol(),
        if *is_counted {
            "; it is only as good as the pose is smooth"
        } else {
            " and is left out; move more slowly, or set \"inertia\" under \"weight\""
        }
    )]
    Inertia { axis: Axis, percent: f64, is_counted: bool },
    /// What a file of arrays holds besides the table.
    #[error("not columns of the table, so left out: {}", listed(names))]
    LeftOut { names: Vec<String> },
    /// There is no time, so rows are load cases.
    #[error(
        "no column is a time, so the {n_rows} rows are taken for {n_cases} load cases (loads within {} % are the same): nothing of the past can be fitted, and whole load cases are left out in turn; if this is a recording, call its time t or time, or give \"sample_rate_hz\" in a column map",
        100.0 * SAME_LOAD_SHARE
    )]
    LoadCases { n_rows: usize, n_cases: usize },
    /// More than one topic, sheet, group or struct could be the table.
    #[error(
        "several tables in one file: {} is read, not read: {}; choose under \"parts\" in the \"text\" of a column map",
        listed(used),
        listed(others)
    )]
    SeveralParts { used: Vec<String>, others: Vec<String> },
    /// A recording whose end is missing.
    #[error("the file ends early, as if its recorder was stopped; what it holds is read")]
    EndsEarly,
    /// Samples in bursts became their means.
    #[error("{n_before} samples in bursts became {n_after} means")]
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
    /// Whether two of them are told as one, which only counts.
    fn is_of_kind(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Cell { trouble, .. }, Self::Cell { trouble: other, .. }) => trouble == other,
            // They differ in their columns: each is worth its own warning.
            (Self::ConstantGauge { .. } | Self::HeldAuxiliary { .. }, _) => false,
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }

    /// Whether a row is not used for it.
    pub(super) const fn skips_row(&self) -> bool {
        matches!(self, Self::Cell { .. } | Self::TooFewCells { .. } | Self::NotARotation)
    }
}

/// Why a cell makes its row unusable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// Nothing stands where a number is needed.
    Empty,
    /// Something other than a number stands where one is needed.
    NotANumber,
    /// NaN or infinity.
    NotFinite,
    /// Something other than a date or a time of day stands where one is needed.
    NotATime,
    /// The status word reports an error.
    StatusError,
    /// The value says that there is none.
    Dropout,
    /// The value with which meters say that they are out of range.
    Overload,
    /// The mount is none that the map knows.
    UnknownMount,
}

impl Trouble {
    /// Whether the map itself says that such rows are left out.
    pub(super) const fn is_wanted(self) -> bool {
        matches!(self, Self::StatusError | Self::Dropout)
    }

    fn told(self, value: &str) -> String {
        match self {
            Self::Empty => "is empty; row skipped".to_owned(),
            Self::NotANumber => format!("holds \"{value}\", which is not a number; row skipped"),
            Self::NotFinite => format!("holds {value}, which is not a finite number; row skipped"),
            Self::Overload => {
                format!(
                    "holds {value}, with which a meter says that it is out of range; row skipped"
                )
            }
            Self::NotATime => {
                format!("holds \"{value}\", which is not a time as in the other rows; row skipped")
            }
            Self::StatusError => format!("is {value}, which reports an error; row left out"),
            Self::Dropout => format!("holds {value}, which marks a dropout; row left out"),
            Self::UnknownMount => {
                format!("holds \"{value}\", which is no mount of the column map; row skipped")
            }
        }
    }
}

impl fmt::Display for LoadWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.path.display(), self.first_line, self.cause)?;
        if self.count > 1 {
            write!(f, " ({} times, last on line {})", self.count, self.last_line)?;
        }
        Ok(())
    }
}

/// Findings of one interval of a file, one per kind; of which file is said at the end.
#[derive(Debug, Default)]
pub(super) struct Findings(Vec<LoadWarning>);

impl Findings {
    /// Notes a cause; its kind's first one is kept, later ones only count.
    pub fn note(&mut self, line: u64, cause: Cause) {
        self.note_many(line, line, 1, cause);
    }

    /// Notes `count` findings of one kind at once.
    pub fn note_many(&mut self, first: u64, last: u64, count: u64, cause: Cause) {
        self.add(LoadWarning {
            path: PathBuf::new(),
            first_line: first,
            last_line: last,
            count,
            cause,
        });
    }

    /// Appends what was found in a later interval whose line 1 is line `lines_before + 1` here.
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

    /// Returns the number of rows that are skipped for a cell which is no number, or for missing cells.
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

    /// How many rows are skipped for having too few cells.
    pub fn short_rows(&self) -> u64 {
        let is_short = |c: &&LoadWarning| matches!(c.cause, Cause::TooFewCells { .. });
        self.0.iter().find(is_short).map_or(0, |c| c.count)
    }

    /// The warnings about the file at `path`, in the order of their first lines.
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
        assert!(message.starts_with("a.csv:3: column 2 (S1) is empty"));
        assert!(message.ends_with("(3 times, last on line 106)"));
    }
}
