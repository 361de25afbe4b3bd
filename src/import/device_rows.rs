//! Converts the rows that a measuring device prints into lines of a table with a time. The known forms of rows are plain
//! numbers, `name:value` pairs, Teleplot, and JSON without a time.
//!
//! Guarantees: each complete row of a device becomes one line of the table, in the order of arrival. Times that are computed
//! from the sample rate or taken from this computer's clock always increase. The text of a cell is not changed.

use std::path::Path;

use super::error::TableError;
use super::map::{ColumnKey, ColumnMap, ColumnRole, ColumnRule, Shape, TableMap};
use crate::formats::text::cells::Cells;
use crate::formats::text::times::TimeForm;
use crate::formats::text::{Delimiter, TextLayout, stamped};

/// Number of lines at the start of a live source from which the form of the rows is guessed.
pub(super) const GUESSED_BY: usize = 10;
/// Minimum number of rows with increasing numbers in the first column, for this column to be taken for the time.
const ROWS_FOR_A_CLOCK: usize = 5;
/// Minimum time step (s) between two rows. It is used for rows that arrive at the same clock reading.
const LEAST_STEP_SECS: f64 = 1e-6;

/// Header of the time column that is added to rows without a time.
const SECONDS: &str = "time [s]";

/// Source of live rows, with the gauges and auxiliary channels that it must supply: those of the calibration, in the
/// calibration's order.
#[derive(Clone, Copy, Debug)]
pub struct LiveSource<'a> {
    /// Name by which messages call the source: the path of a file, or a name for the pipe.
    pub path: &'a Path,
    pub map: Option<&'a ColumnMap>,
    /// Sample interval of the recordings from which the calibration was made (s).
    pub step_secs: Option<f64>,
    pub gauges: &'a [String],
    pub auxiliary: &'a [String],
    /// Form of the rows. `None` to guess the form from the first ten lines.
    pub form: Option<RowForm>,
    /// Sample rate (Hz) from which the times of rows without a time are computed. `None` to take these times from the clock
    /// of this computer.
    pub rate_hz: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowForm {
    Table,
    Numbers,
    TimedNumbers,
    Pairs,
    Teleplot,
    Json,
}

impl RowForm {
    /// All forms of rows, each with its name as a value on the command line and its description. Pairs are what Arduino's
    /// serial plotter reads.
    pub const ALL: [(Self, &'static str, &'static str); 6] = [
        (Self::Table, "table", "a table with a header, or JSON lines, both with a time"),
        (
            Self::Numbers,
            "numbers",
            "numbers without a header: the gauges, then the auxiliary channels",
        ),
        (
            Self::TimedNumbers,
            "timed-numbers",
            "numbers without a header: the time, the gauges, then the auxiliary channels",
        ),
        (Self::Pairs, "pairs", "name:value pairs"),
        (Self::Teleplot, "teleplot", "Teleplot lines, >name:time:value"),
        (Self::Json, "json", "JSON lines without a time"),
    ];

    pub fn words(self) -> &'static str {
        let own = Self::ALL.iter().find(|(form, ..)| *form == self);
        own.map_or("", |(_, _, words)| words)
    }

    fn is_numbers(self) -> bool {
        matches!(self, Self::Numbers | Self::TimedNumbers)
    }

    /// Returns the form of rows that most of these lines have. `None` if most lines have no known form.
    pub(super) fn guess(lines: &[String], n_needed: usize) -> Option<Self> {
        let lines: Vec<&str> = lines.iter().map(|line| without_stamp(line).1).collect();
        let lines: Vec<&str> = lines.into_iter().filter(|line| !line.trim().is_empty()).collect();
        let count = |is: &dyn Fn(&&&str) -> bool| lines.iter().filter(is).count();
        let is_numbers = |line: &&&str| numbers(line).is_some();
        let forms = [
            (Self::Teleplot, count(&|line| teleplot(line).is_some())),
            (Self::Json, count(&|line| line.trim_start().starts_with('{'))),
            (Self::Pairs, count(&|line| pairs(line).is_some())),
            (Self::Numbers, count(&is_numbers)),
        ];
        let (form, n) = forms.into_iter().max_by_key(|(_, n)| *n)?;
        let form = (2 * n > lines.len()).then_some(form)?;
        let rows = lines.iter().filter_map(|line| numbers(line));
        let first: Vec<f64> =
            rows.filter(|row| row.len() == n_needed + 1).map(|row| row[0]).collect();
        let is_clock = first.len() >= ROWS_FOR_A_CLOCK
            && 2 * first.len() > lines.len()
            && first.windows(2).all(|two| two[0] < two[1]);
        Some(if form == Self::Numbers && is_clock { Self::TimedNumbers } else { form })
    }
}

/// Splits off the time stamp and the arrow that a serial terminal writes before each row.
fn without_stamp(line: &str) -> (Option<&str>, &str) {
    match stamped(line.as_bytes()) {
        Some((time, row)) => (line.get(..time), line.get(row..).unwrap_or_default()),
        None => (None, line),
    }
}

/// Returns the delimiter of the numbers in a line; `None` if the line is not a row of numbers.
fn delimiter(line: &str) -> Option<Delimiter> {
    use Delimiter::{Comma, Semicolon, Spaces, Tab};
    [Semicolon, Tab, Comma, Spaces].into_iter().find(|own| {
        let layout = TextLayout { delimiter: *own, ..TextLayout::default() };
        // A line with a single number counts as delimited by commas. With any other delimiter, a comma in the number would be
        // read as a decimal point.
        let is_cut = *own == Comma || cells(line, *own).nth(1).is_some();
        is_cut && cells(line, *own).all(|cell| layout.number(cell).is_some())
    })
}

/// Returns the cells of a line. A delimiter at the end of the line is ignored.
fn cells(line: &str, delimiter: Delimiter) -> impl Iterator<Item = &[u8]> {
    let line = line.trim_end().trim_end_matches(char::from(delimiter.byte()));
    Cells::new(line.as_bytes(), delimiter)
}

/// Returns the numbers of a line. `None` if a cell of the line is not a number.
fn numbers(line: &str) -> Option<Vec<f64>> {
    let layout = TextLayout { delimiter: delimiter(line)?, ..TextLayout::default() };
    cells(line, layout.delimiter).map(|cell| Some(layout.number(cell)?.0)).collect()
}

fn pairs(line: &str) -> Option<Vec<(&str, &str)>> {
    if line.starts_with(['>', '{']) {
        return None;
    }
    let cells = line.split([',', ';', '\t', ' ']).filter(|cell| !cell.is_empty());
    // Some devices write a blank between the colon and the value of a pair.
    let mut joined: Vec<(&str, &str)> = Vec::new();
    for cell in cells {
        match (cell.split_once(':'), joined.last_mut()) {
            (Some((name, value)), _) if !name.is_empty() => joined.push((name, value)),
            (None, Some((_, value))) if value.is_empty() => *value = cell,
            _ => return None,
        }
    }
    (!joined.is_empty()).then_some(joined)
}

/// Returns the name, the time (ms) and the value of a Teleplot line.
fn teleplot(line: &str) -> Option<(&str, Option<&str>, &str)> {
    let (name, rest) = line.trim().strip_prefix('>')?.split_once(':')?;
    // After the value, a Teleplot line may have a unit (after `§`) and flags (after `|`).
    let rest = rest.split(['§', '|']).next()?;
    Some(match rest.split_once(':') {
        Some((time, value)) => (name, Some(time), value),
        None => (name, None, rest),
    })
}

#[derive(Debug)]
pub(super) struct DeviceRows {
    pub form: RowForm,
    pub clock: &'static str,
    rate_hz: Option<f64>,
    delimiter: Delimiter,
    /// Number of cells that a row of plain numbers must have for all channels of the calibration, and for its time if it has
    /// one.
    n_cells: usize,
    n_rows: f64,
    last_secs: f64,
    /// Channel names of the calibration. A Teleplot value with the first name starts a row.
    cycle: Vec<String>,
    /// Names and values of the Teleplot row that is not complete yet.
    pending: Vec<(String, String)>,
    /// Name of the time column and text of the time of the pending row, if the device sends a time.
    pending_time: Option<(&'static str, String)>,
}

impl DeviceRows {
    /// Creates the converter from the first lines of the source. For plain numbers, also returns the column map of the table,
    /// because the columns have no names. Returns [`TableError::FewNumbers`] if no line has a number for each channel.
    pub fn new(
        form: RowForm,
        lines: &[String],
        source: LiveSource<'_>,
    ) -> Result<(Self, Option<ColumnMap>), TableError> {
        let rows: Vec<(Option<&str>, &str)> =
            lines.iter().map(|line| without_stamp(line)).collect();
        let stamp = rows.iter().find_map(|(stamp, _)| *stamp);
        let has_own_time = match form {
            RowForm::TimedNumbers => true,
            RowForm::Teleplot => {
                rows.iter().any(|(_, row)| matches!(teleplot(row), Some((_, Some(_), _))))
            }
            _ => stamp.is_some(),
        };
        let is_timed = form == RowForm::TimedNumbers;
        let n_cells = source.gauges.len() + source.auxiliary.len() + usize::from(is_timed);
        let count = |row: &str| numbers(row).map_or(0, |own| own.len());
        let whole = rows.iter().map(|(_, row)| *row).find(|row| count(row) >= n_cells);
        if form.is_numbers() && whole.is_none() {
            let found = rows.iter().map(|(_, row)| count(row)).max().unwrap_or(0);
            return Err(TableError::FewNumbers { found, needed: n_cells });
        }
        let own = Self {
            form,
            clock: match (has_own_time, source.rate_hz) {
                (true, _) => "the device",
                (false, Some(_)) => "the given rate",
                (false, None) => "the clock of this computer",
            },
            rate_hz: source.rate_hz,
            delimiter: whole.and_then(delimiter).unwrap_or_default(),
            n_cells,
            n_rows: 0.0,
            last_secs: f64::NEG_INFINITY,
            cycle: source.gauges.iter().chain(source.auxiliary).cloned().collect(),
            pending: Vec::new(),
            pending_time: None,
        };
        let map = form.is_numbers().then(|| own.map(stamp, source));
        Ok((own, map))
    }

    /// Returns a message if a line of plain numbers has fewer values than the calibration needs, so that no load can be
    /// computed from it.
    pub fn missing(&self, line: &str) -> Option<String> {
        let (_, row) = without_stamp(line);
        let n = cells(row, self.delimiter).filter(|cell| !cell.is_empty()).count();
        let needed = self.n_cells;
        (self.form.is_numbers() && n < needed)
            .then(|| format!("the line has {n} of the {needed} values that the calibration needs"))
    }

    fn without_further(&self, row: &str) -> String {
        let cells = cells(row, self.delimiter).take(self.n_cells).map(String::from_utf8_lossy);
        cells.collect::<Vec<_>>().join(&char::from(self.delimiter.byte()).to_string())
    }

    fn map(&self, stamp: Option<&str>, source: LiveSource<'_>) -> ColumnMap {
        let text = TextLayout { delimiter: self.delimiter, ..TextLayout::default() };
        let is_timed = self.form == RowForm::TimedNumbers;
        let form = stamp.and_then(|stamp| TimeForm::of_all([stamp.as_bytes()].into_iter()));
        let unit = (!is_timed).then(|| form.map_or("s", TimeForm::name).to_owned());
        let time = ColumnRule { unit, ..ColumnRule::new(ColumnKey::Number(1), ColumnRole::Time) };
        let gauges = source.gauges.iter().map(|name| (name, ColumnRole::Gauge));
        let auxiliary = source.auxiliary.iter().map(|name| (name, ColumnRole::Auxiliary));
        let rules = gauges.chain(auxiliary).zip(2..).map(|((name, is), number)| ColumnRule {
            name: Some(name.clone()),
            ..ColumnRule::new(ColumnKey::Number(number), is)
        });
        let columns = [time].into_iter().chain(rules).collect::<Vec<_>>();
        let n_columns = self.n_cells + usize::from(!is_timed);
        let shape = Shape { columns: n_columns, ..Shape::default() };
        ColumnMap {
            table: TableMap { shape, text, columns, ..TableMap::default() },
            ..ColumnMap::default()
        }
    }

    /// Converts a line that arrived at this time (s). Returns a line of the table, or `None` if more lines of the device
    /// belong to the same row.
    pub fn line(&mut self, line: &str, arrived_secs: f64) -> Option<String> {
        let (stamp, row) = without_stamp(line);
        match self.form {
            RowForm::Table => Some(row.to_owned()),
            RowForm::TimedNumbers => Some(self.without_further(row)),
            RowForm::Numbers => {
                let time = self.time(stamp, arrived_secs);
                let row = self.without_further(row);
                Some(format!("{time}{}{row}", char::from(self.delimiter.byte())))
            }
            RowForm::Json => {
                let time = self.time(stamp, arrived_secs);
                let Some(rest) = row.trim_start().strip_prefix('{') else {
                    return Some(object((SECONDS, &time), &[]));
                };
                Some(format!("{{\"{SECONDS}\":\"{time}\",{rest}"))
            }
            RowForm::Pairs => {
                let time = self.time(stamp, arrived_secs);
                Some(object((SECONDS, &time), &pairs(row).unwrap_or_default()))
            }
            RowForm::Teleplot => self.teleplot(stamp, row, arrived_secs),
        }
    }

    /// Adds a Teleplot value to the row that is being collected, and returns the row once it is complete. A new row starts
    /// with the first gauge, or with a name that the row already has. A row is complete when it has all channels of the
    /// calibration.
    fn teleplot(&mut self, stamp: Option<&str>, row: &str, arrived_secs: f64) -> Option<String> {
        let (name, time, value) = teleplot(row)?;
        let is_first = self.cycle.first().is_some_and(|first| first == name);
        let begins = self.pending.iter().any(|(own, _)| is_first || own == name);
        let before = begins.then(|| self.whole(arrived_secs));
        if self.pending.is_empty() {
            let time = time.map(|time| ("time [ms]", time.to_owned()));
            self.pending_time = time.or_else(|| Some((SECONDS, stamp?.to_owned())));
        }
        self.pending.push((name.to_owned(), value.to_owned()));
        let is_there = |own: &String| self.pending.iter().any(|(name, _)| name == own);
        let is_whole = self.cycle.iter().all(is_there);
        before.or_else(|| is_whole.then(|| self.whole(arrived_secs)))
    }

    fn whole(&mut self, arrived_secs: f64) -> String {
        let row = std::mem::take(&mut self.pending);
        let values: Vec<(&str, &str)> =
            row.iter().map(|(name, value)| (&**name, &**value)).collect();
        let (name, time) =
            (self.pending_time.take()).unwrap_or_else(|| (SECONDS, self.time(None, arrived_secs)));
        object((name, &time), &values)
    }

    /// Returns the time of the next row: the time stamp of the line if there is one, else the row number divided by the
    /// sample rate, else the time of arrival. Rows that arrived at the same time are 1 µs apart.
    fn time(&mut self, stamp: Option<&str>, arrived_secs: f64) -> String {
        let secs = match self.rate_hz {
            Some(rate_hz) => self.n_rows / rate_hz,
            None => arrived_secs.max(self.last_secs + LEAST_STEP_SECS),
        };
        self.n_rows += 1.0;
        self.last_secs = secs;
        stamp.map_or_else(|| format!("{secs:.6}"), str::to_owned)
    }
}

/// Returns a JSON line with a time and these values. All values are written as texts.
fn object(time: (&str, &str), values: &[(&str, &str)]) -> String {
    let text = |text: &str| serde_json::Value::from(text).to_string();
    let members = [time].into_iter().chain(values.iter().copied());
    let members = members.map(|(name, value)| format!("{}:{}", text(name), text(value)));
    format!("{{{}}}", members.collect::<Vec<_>>().join(","))
}
