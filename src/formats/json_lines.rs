//! Reads JSON lines (`.jsonl`, `.ndjson`): each line is the object of one sample. Its numbers become columns, which are named
//! by the paths of keys to these numbers.
//!
//! Guarantees: a row keeps the number of its line in the file. A JSON document, such as a file of this program, is not read
//! as JSON lines. Memory use is limited by the size of the file, even if every line has new keys.

use std::collections::HashMap;
use std::fmt::{self, Write as _};

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use super::arrays::{self, Array};
use super::columns::{Column, Columns};
use super::error::FileError;
use super::format::{Budget, COLUMN_LIMIT, Format, Source};
use super::text::times::{DateOrder, TimeForm};
use super::text::{Blocks, lines};

pub const FORMAT: Format = Format {
    name: "file of JSON lines",
    endings: &["jsonl", "ndjson"],
    signatures: &[b"{", b"\xef\xbb\xbf{"],
    read: columns,
};

const BLOCK_BYTES: usize = 1 << 18;
/// Maximum length of the path of keys to a value (bytes). A value with a longer path is skipped.
const NAME_LIMIT_BYTES: usize = 1 << 10;
const VALUE_BYTES: u64 = size_of::<f64>() as u64;
/// Number of first non-blank lines that decide whether a file holds JSON lines. At least two of these lines must be objects.
/// In a single JSON document over several lines, at most one line is an object.
const CHECKED_LINES: usize = 3;
/// Forms of a time that are recognised in texts, since they can be read in only one way.
const TIMES: [TimeForm; 2] = [TimeForm::Date(DateOrder::YearMonthDay), TimeForm::TimeOfDay];

/// Reads the objects of a file as a table, one row per object; returns `None` if the first lines are not objects.
fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    let mut blocks = Blocks::open(source.path, BLOCK_BYTES, None)?;
    let mut table = Table::of_bytes(source.n_bytes);
    let (mut n_lines, mut n_damaged, mut ends_early) = (0, 0, false);
    while let Some(block) = blocks.next()? {
        let mut lines = lines(&block).peekable();
        while let Some(line) = lines.next() {
            if line.trim_ascii().is_empty() {
                continue;
            }
            source.progress.check()?;
            let row = row(line);
            if row.is_none() && lines.peek().is_none() && !block.ends_with(b"\n") {
                ends_early = true;
                break;
            }
            n_lines += 1;
            n_damaged += usize::from(row.is_none());
            if n_lines == CHECKED_LINES && n_damaged > 1 {
                return Ok(None);
            }
            // A damaged line becomes a row without numbers, so that later rows keep their line numbers.
            table.add(row.unwrap_or_default())?;
        }
    }
    if n_lines - n_damaged < 2 {
        return Ok(None);
    }
    let (mut columns, _) = table.columns()?;
    if n_damaged > 0 {
        columns.left_out.push(format!("lines that are no JSON objects ({n_damaged})"));
    }
    Ok(Some(Columns { ends_early, ..columns }))
}

/// Key of each column of a table, by which the values of later lines find their column.
#[derive(Debug)]
pub struct LineKeys(Vec<Key>);

impl LineKeys {
    /// Reads the first lines of a stream as a table, with the column names that a file would have; `None` if no line is an
    /// object.
    pub fn of_first(lines: &[String]) -> Option<(Columns, Self)> {
        let mut rows: Vec<Row> = lines.iter().filter_map(|line| row(line.as_bytes())).collect();
        let n_rows = rows.len();
        // A single row is added twice: in a table of one row, a list of numbers would be taken for a column.
        rows.extend(rows.first().filter(|_| n_rows == 1).cloned());
        let mut table = Table::of_bytes(lines.iter().map(|line| line.len() as u64).sum());
        for row in rows {
            table.add(row).ok()?;
        }
        let (mut columns, keys) = table.columns().ok()?;
        for column in &mut columns.columns {
            column.values.truncate(n_rows);
        }
        (n_rows > 0).then_some((columns, Self(keys)))
    }

    /// Reads a line as a table with one row; returns `None` if the line is not a JSON object.
    pub fn row(&self, line: &str) -> Option<Columns> {
        let row = row(line.as_bytes())?;
        let column = |key: &Key| {
            let value = row.iter().find(|(known, _)| known == key);
            Column {
                values: vec![value.map_or(f64::NAN, |(_, value)| value.number)],
                ..Column::default()
            }
        };
        Some(Columns { columns: self.0.iter().map(column).collect(), ..Columns::default() })
    }

    pub fn have_list(&self) -> bool {
        self.0.iter().any(|(_, index)| index.is_some())
    }
}

/// Path of keys to a value in a JSON object, and the index of the value if it is an element of a list.
type Key = (String, Option<usize>);

/// Value in a JSON object: a number or a time (s); NaN for other text or a missing value.
#[derive(Clone, Copy)]
struct Value {
    number: f64,
    /// True if the value was written as a date (s since 1970) or as a time of day (s).
    is_time: bool,
}

type Row = Vec<(Key, Value)>;

/// Returns the numbers and times of a line with their keys; `None` if the line is not a JSON object.
fn row(line: &[u8]) -> Option<Row> {
    if !line.trim_ascii_start().starts_with(b"{") {
        return None;
    }
    let read = |line: &[u8]| {
        let mut row = Vec::new();
        let mut json = serde_json::Deserializer::from_slice(line);
        let values = Values { path: &mut String::new(), index: None, row: &mut row };
        values.deserialize(&mut json).ok()?;
        json.end().ok()?;
        Some(row)
    };
    read(line).or_else(|| {
        // Python writes `NaN`, `Infinity` and `-Infinity`, which JSON does not allow.
        let line = std::str::from_utf8(line).ok()?;
        let line = line.replace("-Infinity", "null").replace("Infinity", "null");
        read(line.replace("NaN", "null").as_bytes())
    })
}

struct Values<'a> {
    path: &'a mut String,
    index: Option<usize>,
    row: &'a mut Row,
}

impl Values<'_> {
    fn take<E>(self, number: f64) -> Result<(), E> {
        self.take_value(Value { number, is_time: false })
    }

    fn take_value<E>(self, value: Value) -> Result<(), E> {
        if self.path.len() <= NAME_LIMIT_BYTES && self.row.len() < COLUMN_LIMIT {
            self.row.push(((self.path.clone(), self.index), value));
        }
        Ok(())
    }

    /// Appends the index of the present list element to the path, and returns the previous length of the path (bytes).
    fn enter(&mut self) -> usize {
        let n_bytes = self.path.len();
        if let Some(index) = self.index {
            // Writing to a string cannot fail, so the result is not checked.
            let _ = write!(self.path, "[{index}]");
        }
        n_bytes
    }
}

impl<'de> DeserializeSeed<'de> for Values<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, json: D) -> Result<(), D::Error> {
        json.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Values<'_> {
    type Value = ();

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("JSON")
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<(), E> {
        self.take(f64::from(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<(), E> {
        self.take(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<(), E> {
        self.take(value as f64)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<(), E> {
        self.take(value)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<(), E> {
        let secs = TIMES.iter().find_map(|form| form.secs(text.as_bytes()));
        let number = secs.or_else(|| text.trim().parse().ok()).unwrap_or(f64::NAN);
        self.take_value(Value { number, is_time: secs.is_some() })
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.take(f64::NAN)
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut list: A) -> Result<(), A::Error> {
        let n_bytes = self.enter();
        for index in 0.. {
            let element = Values { path: self.path, index: Some(index), row: self.row };
            if list.next_element_seed(element)?.is_none() {
                break;
            }
        }
        self.path.truncate(n_bytes);
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut object: A) -> Result<(), A::Error> {
        let n_bytes = self.enter();
        while let Some(key) = object.next_key::<String>()? {
            let n_before = self.path.len();
            if n_before > 0 {
                self.path.push('.');
            }
            self.path.push_str(&key);
            object.next_value_seed(Values { path: self.path, index: None, row: self.row })?;
            self.path.truncate(n_before);
        }
        self.path.truncate(n_bytes);
        Ok(())
    }
}

struct Table {
    budget: Budget,
    channels: Vec<Channel>,
    places: HashMap<Key, usize>,
    n_rows: usize,
    has_more: bool,
}

#[derive(Default)]
struct Channel {
    key: Key,
    /// Values of the column, up to the last row that has its key.
    values: Vec<f64>,
    has_times: bool,
}

impl Table {
    fn of_bytes(n_bytes: u64) -> Self {
        let budget = Budget::of_file(n_bytes);
        Self { budget, channels: Vec::new(), places: HashMap::new(), n_rows: 0, has_more: false }
    }

    fn add(&mut self, row: Row) -> Result<(), FileError> {
        for (key, value) in row {
            let next = self.channels.len();
            let at = match self.places.get(&key) {
                Some(at) => *at,
                None if next == COLUMN_LIMIT => {
                    self.has_more = true;
                    continue;
                }
                None => {
                    self.places.insert(key.clone(), next);
                    self.channels.push(Channel { key, ..Channel::default() });
                    next
                }
            };
            let channel = &mut self.channels[at];
            let n_more = (self.n_rows + 1).saturating_sub(channel.values.len()) as u64;
            self.budget.take(&channel.key.0, n_more, VALUE_BYTES)?;
            channel.values.resize(self.n_rows + 1, f64::NAN);
            channel.values[self.n_rows] = value.number;
            channel.has_times |= value.is_time;
        }
        self.n_rows += 1;
        Ok(())
    }

    /// Returns the columns of the table with their keys. A list of numbers becomes several columns, which are named as those
    /// of an array in other formats.
    fn columns(mut self) -> Result<(Columns, Vec<Key>), FileError> {
        let missing = |channel: &Channel| (self.n_rows - channel.values.len()) as u64;
        let n_missing = self.channels.iter().map(missing).sum();
        self.budget.take("the table", n_missing, VALUE_BYTES)?;
        // Each array collects the values of one key. If a key holds lists, its array has one column per element.
        let mut lists: Vec<(Array, Vec<Key>)> = Vec::new();
        for mut channel in self.channels {
            channel.values.resize(self.n_rows, f64::NAN);
            let (name, index) = &channel.key;
            let is_own = |(list, _): &&mut (Array, Vec<Key>)| {
                list.shape.len() == 2 && index.is_some() && list.name == *name
            };
            if let Some((list, keys)) = lists.iter_mut().find(is_own) {
                list.shape[1] += 1;
                list.values.append(&mut channel.values);
                keys.push(channel.key);
                continue;
            }
            let array = Array {
                name: name.clone(),
                unit: if channel.has_times { "s" } else { "" },
                shape: match index {
                    Some(_) => vec![self.n_rows, 1],
                    None => vec![self.n_rows],
                },
                is_by_column: true,
                values: channel.values,
                ..Array::default()
            };
            lists.push((array, vec![channel.key]));
        }
        let (with, without): (Vec<_>, Vec<_>) = lists
            .into_iter()
            .partition(|(channel, _)| channel.values.iter().any(|number| !number.is_nan()));
        let mut left_out: Vec<String> = without
            .into_iter()
            .map(|(channel, _)| format!("{} (no numbers)", channel.name))
            .collect();
        if self.has_more {
            left_out.push(format!("keys after the first {COLUMN_LIMIT} keys"));
        }
        let (arrays, keys): (Vec<_>, Vec<_>) = with.into_iter().unzip();
        Ok((arrays::columns(arrays, left_out), keys.concat()))
    }
}
