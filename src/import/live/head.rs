//! First lines of a live source, in which its columns are found.

use std::collections::VecDeque;
use std::ops::Range;
use std::time::Instant;

use super::{
    super::device_rows::{
        cells, delimiter, numbers, pairs_as_json, table_of_numbers, times_of_numbers, without_stamp,
    },
    LiveSource, LiveTable, RowForm,
};
use crate::{
    formats::{
        column_name::ColumnName,
        text::{
            Delimiter, NUMBER, TextLayout, cells::Cells, delimiter_of_header, is_header,
            is_units_row, numbers_in, words,
        },
    },
    import::error::{ReadError, TableError, at},
    recording::units::TimeUnit,
};

/// Maximum number of lines at the start of a live source in which its columns must be found.
const MAX_HEAD_LINES: usize = 2000;
/// Number of rows, at the start of a live source, from whose median time step the unit of time is derived.
const ROWS_FOR_A_STEP: usize = 5;
/// Number of rows from which their form is guessed, and number of rows after which an unclear form is an error.
const ROWS_FOR_A_FORM: usize = 10;
const ROWS_FOR_AN_ERROR: usize = 40;
/// Maximum length (bytes) of a line that is kept although it is no row, to report it later.
const KEPT_BYTES: usize = 1000;

/// Line of a live source, with the time (s) from the start of the source to its arrival.
#[derive(Clone, Debug)]
pub struct Arrived {
    pub line: String,
    pub secs: f64,
    /// True for a line that is kept at its place, but is not part of the table.
    is_command: bool,
}

/// First lines of a source, until its columns are known.
///
/// A line that holds every gauge name of the calibration is the header of a table, wherever it stands, and the lines above it
/// are dropped. Without such a line, the form of the rows is guessed from the first lines that have the form of a row. After
/// the columns are known, all lines below the header, or all lines of rows without a header, are read again by the table.
#[derive(Debug)]
pub struct LiveHead {
    start: Instant,
    kept: VecDeque<Arrived>,
    n_lines: usize,
    header: Option<TableHeader>,
    /// Lines that may be rows, with their form.
    rows: Vec<(RowForm, Arrived)>,
    /// The newest successive lines with the same text between their numbers, and this text. Each line is that of its numbers.
    alike: (Vec<(RowForm, Arrived)>, String),
}

/// Header of a table, and the line with the units below it.
#[derive(Debug)]
pub struct TableHeader {
    line: String,
    pub names: Vec<String>,
    units: Option<String>,
    pub has_gauges: bool,
}

impl TableHeader {
    /// Returns the header in a line; `None` for any other line.
    pub fn of(row: &str, source: LiveSource<'_>) -> Option<Self> {
        let line = row.trim_start_matches(['#', ' ']);
        let names = words(line.as_bytes()).filter(|_| !line.starts_with('{'))?;
        let is_there = |gauge: &String| names.iter().any(|name| is_named(name, gauge));
        let has_gauges = !source.gauges.is_empty() && source.gauges.iter().all(is_there);
        let line = line.to_owned();
        (has_gauges || is_header(&names)).then_some(Self { line, names, units: None, has_gauges })
    }

    /// Returns true if a column may turn out to be the time, from its values.
    fn may_have_clock(&self) -> bool {
        let is_it = |name: &ColumnName| {
            let unit = name.unit.as_deref().and_then(TimeUnit::from_name);
            name.kind.is_none() && (unit.is_some() || name.has_clock_word())
        };
        self.names.iter().any(|name| is_it(&ColumnName::parse(name)))
    }

    fn delimiter(&self) -> Delimiter {
        delimiter_of_header(self.line.as_bytes())
    }

    /// Returns the delimiter of a row below this header; `None` if a line is no such row.
    fn delimiter_of_row(&self, row: &str) -> Option<Delimiter> {
        let is_row = |own: &Delimiter| {
            let layout = TextLayout { delimiter: *own, ..TextLayout::default() };
            Cells::new(row.as_bytes(), *own).count() >= self.names.len()
                && cells(row, *own).any(|cell| layout.number(cell).is_some())
        };
        [Some(self.delimiter()), delimiter(row)].into_iter().flatten().find(is_row)
    }

    /// Returns true if the line below the header holds units.
    fn takes_units(&mut self, row: &str) -> bool {
        let n_cells = Cells::new(row.as_bytes(), self.delimiter()).count();
        let is_wide = n_cells == self.names.len();
        let holds_units =
            self.units.is_none() && is_wide && is_units_row(row.as_bytes(), self.delimiter());
        if holds_units {
            self.units = Some(row.to_owned());
        }
        holds_units
    }

    /// Returns the lines of the header above rows with this delimiter.
    fn lines(&self, delimiter: Delimiter) -> Vec<String> {
        let between = char::from(delimiter.byte()).to_string();
        let is_same = self.delimiter() == delimiter;
        let names = if is_same { self.line.clone() } else { self.names.join(&between) };
        [names].into_iter().chain(self.units.clone()).collect()
    }
}

/// Returns true if the cell of a header names this channel, with or without a unit.
pub fn is_named(cell: &str, channel: &str) -> bool {
    cell == channel || cell.contains(channel) && ColumnName::parse(cell).name == channel
}

impl Default for LiveHead {
    fn default() -> Self {
        Self {
            start: Instant::now(),
            kept: VecDeque::new(),
            n_lines: 0,
            header: None,
            rows: Vec::new(),
            alike: (Vec::new(), String::new()),
        }
    }
}

impl LiveHead {
    pub fn is_empty(&self) -> bool {
        self.n_lines == 0
    }

    pub fn n_lines(&self) -> usize {
        self.n_lines
    }

    /// Returns the lines that the table has to read, and those of [`keep`](Self::keep).
    pub fn into_kept(self) -> impl Iterator<Item = Arrived> {
        self.kept.into_iter()
    }

    fn arrived(&self, line: String, is_command: bool) -> Arrived {
        Arrived { line, secs: self.start.elapsed().as_secs_f64(), is_command }
    }

    /// Keeps a line that is not part of the table, such as a command, at its place among the lines.
    pub fn keep(&mut self, line: String) {
        self.kept.push_back(self.arrived(line, true));
    }

    /// Adds the next line, and returns the table once its columns are known. After an error, no further lines may be added.
    pub fn push(
        &mut self,
        line: String,
        source: LiveSource<'_>,
    ) -> Result<Option<LiveTable>, ReadError> {
        self.n_lines += 1;
        let (_, row) = without_stamp(&line);
        if let (None, Some(names)) = (&self.header, source.header) {
            let (line, names) = (names.to_owned(), names.split(',').map(str::trim));
            let names = names.map(str::to_owned).collect();
            self.header = Some(TableHeader { line, names, units: None, has_gauges: true });
        } else if source.may_have_header()
            && let Some(header) = TableHeader::of(row, source)
        {
            self.header = Some(header);
            self.rows.clear();
            self.kept.retain(|arrived| arrived.is_command);
            return Ok(None);
        }
        if self.header.as_mut().is_some_and(|header| header.takes_units(row)) {
            return Ok(None);
        }
        let form = self.form_of(row, source);
        let has_header = self.header.as_ref().is_some_and(|header| header.has_gauges);
        let is_text = form.is_none() && (source.form.is_some() || !has_header);
        let row = is_text.then(|| row_of_text(&line, source)).flatten();
        let mut arrived = self.arrived(line, false);
        let row = row.map(|(line, text)| (Arrived { line, ..arrived.clone() }, text));
        match form {
            Some(form) => self.rows.push((form, arrived.clone())),
            None if row.is_some() => {}
            None => arrived.line.truncate(arrived.line.floor_char_boundary(KEPT_BYTES)),
        }
        self.kept.push_back(arrived);
        let table = match form {
            Some(form) => self.table(form, source, false),
            None => self.table_of_text(row, source),
        }?;
        let is_full = self.n_lines >= MAX_HEAD_LINES;
        let is_unclear = is_full || self.n_messages() >= ROWS_FOR_A_FORM;
        if table.is_none() && source.form.is_none() && is_unclear {
            return self.end(source).map(Some);
        }
        if table.is_some() || !is_full {
            return Ok(table);
        }
        let oldest = self.kept.iter().position(|arrived| !arrived.is_command);
        oldest.map(|at| self.kept.remove(at));
        Ok(None)
    }

    /// Finds the columns in lines with other text between their numbers. Enough successive lines must have the same text.
    fn table_of_text(
        &mut self,
        row: Option<(Arrived, String)>,
        source: LiveSource<'_>,
    ) -> Result<Option<LiveTable>, ReadError> {
        let form = source.form.unwrap_or(RowForm::Numbers);
        let (rows, text) = &mut self.alike;
        let (arrived, of_row) = row.unzip();
        if of_row.as_ref() != Some(text) {
            rows.clear();
            *text = of_row.unwrap_or_default();
        }
        rows.extend(arrived.map(|arrived| (form, arrived)));
        if !(ROWS_FOR_A_FORM..ROWS_FOR_AN_ERROR).contains(&rows.len()) {
            return Ok(None);
        }
        let text = Some(text.clone());
        std::mem::swap(&mut self.rows, &mut self.alike.0);
        let table = self.table(form, source, false);
        std::mem::swap(&mut self.rows, &mut self.alike.0);
        Ok(table?.map(|table| LiveTable { text, ..table }))
    }

    /// Returns the form of a row from which the columns can be found; `None` if a line is no such row.
    fn form_of(&mut self, row: &str, source: LiveSource<'_>) -> Option<RowForm> {
        use RowForm::{Json, Numbers, Table, TimedNumbers};
        let is_table = matches!(source.form, None | Some(Table));
        let header = self.header.as_ref().filter(|_| is_table);
        let is_row = header.is_some_and(|header| header.delimiter_of_row(row).is_some());
        if is_row || source.whole_map().is_some() && source.form.is_none() {
            return Some(Table);
        }
        let form = RowForm::of(row, source.gauges)?;
        let n_numbers = numbers(row).map_or(0, |numbers| numbers.len());
        let n_channels = source.n_channels();
        match source.form {
            None if header.is_some_and(|header| header.has_gauges) => None,
            None => (form == Json || n_channels > 0).then_some(form),
            Some(Table) => (form == Json).then_some(form),
            Some(Numbers) => (n_numbers >= n_channels).then_some(Numbers),
            Some(TimedNumbers) => (n_numbers > n_channels).then_some(TimedNumbers),
            Some(given) => (form == given).then_some(form),
        }
    }

    /// Returns the number of lines that end a message of `ros2 topic echo`.
    fn n_messages(&self) -> usize {
        self.kept.iter().filter(|arrived| arrived.line.trim_end() == "---").count()
    }

    /// Returns the table after the source has ended.
    pub fn end(&mut self, source: LiveSource<'_>) -> Result<LiveTable, ReadError> {
        let count = |form| self.rows.iter().filter(|(own, _)| *own == form).count();
        let form = self.rows.iter().map(|(form, _)| *form).max_by_key(|form| count(*form));
        let table = form.map_or(Ok(None), |form| self.table(form, source, true))?;
        let fault = || match &self.header {
            Some(_)
                if source.header.is_none() && source.form.is_none_or(|form| !form.is_numbers()) =>
            {
                TableError::NoRows
            }
            _ if self.n_messages() > 0 => unclear(
                "messages of ros2 topic echo are rows only with its --csv".to_owned(),
                source,
            ),
            _ => {
                let n = self.n_lines;
                let found = format!(
                    "none of the first {n} lines is a header, or a row with the values of all gauges"
                );
                unclear(found, source)
            }
        };
        table.ok_or_else(|| at(source.path, 1)(fault()))
    }

    /// Finds the columns in the rows of this form. Returns `None` if more lines are needed.
    fn table(
        &mut self,
        form: RowForm,
        source: LiveSource<'_>,
        is_all: bool,
    ) -> Result<Option<LiveTable>, ReadError> {
        let rows = self.rows.iter().filter(|(own, _)| *own == form);
        let lines: Vec<&str> = rows.map(|(_, arrived)| &*arrived.line).collect();
        let stamped: Vec<(Option<&str>, &str)> =
            lines.iter().map(|line| without_stamp(line)).collect();
        let has_stamp = stamped.iter().any(|(stamp, _)| stamp.is_some());
        let rows: Vec<&str> = stamped.iter().map(|(_, row)| *row).collect();
        let owned = |rows: &[&str]| rows.iter().map(|row| (*row).to_owned()).collect();
        let is_early = !is_all && rows.len() < ROWS_FOR_A_FORM;
        let n_needed = if is_all { 0 } else { ROWS_FOR_A_STEP };
        let (lines, times): (Vec<String>, Range<usize>) = match (form, &self.header) {
            (RowForm::Table, Some(header)) => {
                let last = rows[rows.len() - 1];
                let delimiter = header.delimiter_of_row(last).unwrap_or_default();
                ([header.lines(delimiter), owned(&rows)].concat(), 0..0)
            }
            (RowForm::Table, None) => (owned(&lines), 0..0),
            (RowForm::Json, _) => (owned(&rows), 0..0),
            _ if source.form.is_none() && is_early => return Ok(None),
            (RowForm::Pairs, _) => (rows.iter().map(|row| pairs_as_json(row)).collect(), 0..0),
            _ => match numbers_of(rows, form, source, is_all)? {
                Some(found) => found,
                None => return Ok(None),
            },
        };
        let may_lack_time = match (form, &self.header) {
            (RowForm::Table, Some(header)) => !(is_early && header.may_have_clock()),
            (RowForm::Table, None) => false,
            (RowForm::Json, _) => source.form.map_or(!is_early, |given| given == form),
            _ => true,
        };
        let form = if times.is_empty() { form } else { RowForm::TimedNumbers };
        // A column map describes a table, and no other form of rows.
        let map = source.map.filter(|_| source.form.is_none_or(|given| given == RowForm::Table));
        let of_rows = LiveSource { map, ..source };
        let table = match LiveTable::begin(&lines, form, of_rows, n_needed) {
            Ok(Some(table)) if table.plan.is_static && !may_lack_time => {
                let names = table.plan.columns.into_iter().map(|column| column.name);
                Err(at(source.path, table.plan.line)(TableError::no_time(names.collect())))
            }
            table => table,
        };
        match table {
            Err(ReadError::Table { source: TableError::NoTimeUnit { .. }, .. }) => table,
            Err(_) if is_early => Ok(None),
            Ok(Some(mut table)) => {
                table.start = self.start;
                table.times_from = match (table.plan.is_static, source.rate_hz) {
                    (false, _) => (!times.is_empty())
                        .then(|| format!("column {} of the rows", times.start + 1)),
                    _ if has_stamp => Some("the device".to_owned()),
                    (true, Some(_)) => Some("the given rate".to_owned()),
                    (true, None) => Some("the clock of this computer".to_owned()),
                };
                table.header = self.header.take().map(|header| header.names);
                let mut n_above = if source.whole_map().is_some() { table.n_above } else { 0 };
                self.kept.retain(|arrived| {
                    let is_above = n_above > 0 && !arrived.is_command;
                    n_above -= usize::from(is_above);
                    !is_above
                });
                Ok(Some(table))
            }
            table => table,
        }
    }
}

/// Returns a row with nothing but commas between its numbers, and the text that stands between them; `None` if a line cannot be
/// such a row. Without a given form, all numbers must be separated by the same marks, as in `a0=1 a1=2`.
fn row_of_text(line: &str, source: LiveSource<'_>) -> Option<(String, String)> {
    /// Maximum number of words between two numbers: a unit and a label. A line with more is a message for people.
    const MOST_WORDS: usize = 2;
    let (stamp, row) = without_stamp(line);
    let (numbers, text) = numbers_in(row);
    let parts: Vec<&str> = text.split(NUMBER).collect();
    let names: Vec<&str> = match source.header {
        Some(header) => header.split(',').map(str::trim).collect(),
        None => source.channels().map(String::as_str).collect(),
    };
    let n_more = numbers.len().checked_sub(names.len())?;
    let has_count = match source.form {
        None => {
            let marks = |part: &str| part.replace(|c: char| !c.is_ascii_punctuation(), "");
            let between = parts.get(1..parts.len() - 1).unwrap_or_default();
            let is_same = between.windows(2).all(|two| marks(two[0]) == marks(two[1]));
            n_more <= 2 && !names.is_empty() && is_same
        }
        Some(RowForm::TimedNumbers) => n_more == 1,
        Some(RowForm::Numbers) => n_more == 0,
        Some(RowForm::Table) => n_more == 0 && source.header.is_some(),
        Some(RowForm::Pairs | RowForm::Json) => false,
    };
    // Labels that are names of channels must have the order in which the numbers are read.
    let channels = names.iter().filter(|name| source.channels().any(|channel| channel == *name));
    let is_ordered = channels.filter_map(|name| text.find(name)).is_sorted();
    let is_word = |word: &&str| word.contains(char::is_alphabetic);
    let n_words = |part: &&str| part.split([' ', ',', ';']).filter(is_word).count();
    let is_row = has_count && is_ordered && parts.iter().all(|part| n_words(part) <= MOST_WORDS);
    let stamp = stamp.map_or_else(String::new, |stamp| format!("{stamp} -> "));
    let numbers: Vec<&str> = numbers.into_iter().map(|place| &row[place]).collect();
    is_row.then(|| (stamp + &numbers.join(","), text))
}

/// Lines of a table, and the columns of its time.
type LinesAndTimes = (Vec<String>, Range<usize>);

/// Returns rows of plain numbers as a table, and the columns of their time. Without a given form, rows with another number of
/// numbers than most are left out. Returns `None` if more lines are needed.
fn numbers_of(
    mut rows: Vec<&str>,
    form: RowForm,
    source: LiveSource<'_>,
    is_all: bool,
) -> Result<Option<LinesAndTimes>, ReadError> {
    if source.form.is_some() {
        let times = 0..usize::from(form == RowForm::TimedNumbers);
        return Ok(Some((table_of_numbers(&rows, &times, source), times)));
    }
    let of = |row: &&str| numbers(row).unwrap_or_default();
    let n_rows = rows.len();
    let lengths: Vec<usize> = rows.iter().map(|row| of(row).len()).collect();
    let count = |n| lengths.iter().filter(|length| **length == n).count();
    let n = lengths.iter().copied().max_by_key(|n| count(*n)).unwrap_or(0);
    rows.retain(|row| of(row).len() == n);
    let is_most = 2 * rows.len() > n_rows;
    let numbers: Vec<Vec<f64>> = rows.iter().map(of).collect();
    match times_of_numbers(&numbers, source).filter(|_| is_most) {
        Some(times) => Ok(Some((table_of_numbers(&rows, &times, source), times))),
        None if is_all || n_rows >= ROWS_FOR_AN_ERROR => {
            let found = format!(
                "they have {n} numbers, and no column is a clock with the calibration's sample rate"
            );
            Err(at(source.path, 1)(unclear(found, source)))
        }
        None => Ok(None),
    }
}

fn unclear(found: String, source: LiveSource<'_>) -> TableError {
    TableError::UnclearRows { found, needed: source.channels().cloned().collect() }
}
