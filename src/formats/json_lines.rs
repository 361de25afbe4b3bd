//! JSON lines (`.jsonl`, `.ndjson`): one object per sample. Its numbers become columns named by their paths.
//!
//! Guarantees: rows keep their line numbers. A JSON document, such as a file of this program, is not read as JSON lines.
//! Memory use is limited by the size of the file, even if every line has new keys.

use std::collections::HashMap;
use std::fmt::{self, Write as _};
use std::io::{BufRead, BufReader, Read};

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use super::arrays::{self, Array};
use super::columns::{Column, Columns};
use super::error::FileError;
use super::format::{Budget, COLUMN_LIMIT, Format, Source};
use super::text::times::{DateOrder, TimeForm};

pub(super) const FORMAT: Format = Format {
    name: "file of JSON lines",
    endings: &["jsonl", "ndjson"],
    signatures: &[b"{", b"\xef\xbb\xbf{"],
    read: columns,
};

const LINE_LIMIT_BYTES: usize = 1 << 20;
/// Maximum length of the path of a number (bytes).
const NAME_LIMIT_BYTES: usize = 1 << 10;
const VALUE_BYTES: u64 = size_of::<f64>() as u64;
/// Number of first non-blank lines that are checked. Two of three must be objects; a document over several lines has one.
const CHECKED_LINES: usize = 3;
/// Forms of a time in text that can be read in only one way.
const TIMES: [TimeForm; 2] = [TimeForm::Date(DateOrder::YearMonthDay), TimeForm::TimeOfDay];

/// Reads the objects of a file as a table; returns `None` if the first lines are not objects.
fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    let mut n_objects = 0;
    let mut first = Lines::open(source)?;
    for _ in 0..CHECKED_LINES {
        match first.next() {
            Ok(Some(line)) => n_objects += usize::from(row(line).is_some()),
            Ok(None) | Err(FileError::LineTooLong { .. }) => break,
            Err(error) => return Err(error),
        }
    }
    if n_objects < 2 {
        return Ok(None);
    }
    let mut table = Table::of_bytes(source.n_bytes);
    let (mut n_damaged, mut ends_early) = (0, false);
    let mut lines = Lines::open(source)?;
    while let Some(line) = lines.next()? {
        source.progress.check()?;
        let row = row(line);
        if row.is_none() && !line.ends_with(b"\n") {
            ends_early = true;
            break;
        }
        n_damaged += usize::from(row.is_none());
        // A damaged line becomes a row without numbers, so that line numbers stay right.
        table.add(row.unwrap_or_default())?;
    }
    let (mut columns, _) = table.columns()?;
    if n_damaged > 0 {
        let what = format!("lines that are no JSON objects ({n_damaged})");
        columns.left_out.push(what);
    }
    Ok(Some(Columns { ends_early, ..columns }))
}

/// Keys of the values in each line, one for each column of a table.
#[derive(Debug)]
pub(crate) struct LineKeys(Vec<Key>);

impl LineKeys {
    /// Reads the first lines of a stream as a table, with column names as in a file; `None` if no line is an object.
    pub(super) fn of_first(lines: &[String]) -> Option<(Columns, Self)> {
        let mut rows: Vec<Row> = lines.iter().filter_map(|own| row(own.as_bytes())).collect();
        let n_rows = rows.len();
        // With a single row, a list would be taken for a column: it is as long as the table.
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

    /// Reads a line as a table with one row; returns `None` if it is not an object.
    pub fn row(&self, line: &str) -> Option<Columns> {
        let row = row(line.as_bytes())?;
        let column = |key: &Key| {
            let value = row.iter().find(|(own, _)| own == key);
            Column {
                values: vec![value.map_or(f64::NAN, |(_, value)| value.number())],
                ..Column::default()
            }
        };
        Some(Columns { columns: self.0.iter().map(column).collect(), ..Columns::default() })
    }

    pub fn have_list(&self) -> bool {
        self.0.iter().any(|(_, index)| index.is_some())
    }
}

struct Lines {
    file: BufReader<std::fs::File>,
    line: Vec<u8>,
}

impl Lines {
    fn open(source: &Source<'_>) -> Result<Self, FileError> {
        let mut file = BufReader::new(source.open()?);
        if !source.head.starts_with(b"{") {
            // Skips the byte order mark.
            file.read_exact(&mut [0; 3])?;
        }
        let line = Vec::new();
        Ok(Self { file, line })
    }

    fn next(&mut self) -> Result<Option<&[u8]>, FileError> {
        loop {
            self.line.clear();
            let mut file = self.file.by_ref().take(LINE_LIMIT_BYTES as u64 + 1);
            let n_bytes = file.read_until(b'\n', &mut self.line)?;
            if n_bytes > LINE_LIMIT_BYTES {
                let limit_bytes = LINE_LIMIT_BYTES;
                return Err(FileError::LineTooLong { limit_bytes });
            }
            if n_bytes == 0 || !self.line.trim_ascii().is_empty() {
                return Ok((n_bytes > 0).then_some(&self.line));
            }
        }
    }
}

/// Path of a value, and its index if it stands in a list.
type Key = (String, Option<usize>);

/// Neither an object nor a list.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Value {
    Number(f64),
    /// Date (s since 1970).
    Time(f64),
    Text,
    Nothing,
}

impl Value {
    fn number(self) -> f64 {
        match self {
            Self::Number(number) | Self::Time(number) => number,
            Self::Text | Self::Nothing => f64::NAN,
        }
    }
}

type Row = Vec<(Key, Value)>;

/// Returns the values of a line; `None` if it is not an object.
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
        // Python writes these words for missing and infinite numbers.
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
    fn take<E>(self, value: Value) -> Result<(), E> {
        if self.path.len() <= NAME_LIMIT_BYTES && self.row.len() < COLUMN_LIMIT {
            self.row.push(((self.path.clone(), self.index), value));
        }
        Ok(())
    }

    /// Appends the index to the path, and returns the previous length of the path (bytes).
    fn enter(&mut self) -> usize {
        let n_bytes = self.path.len();
        if let Some(index) = self.index {
            // Writing to a string cannot fail.
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
        self.take(Value::Number(f64::from(value)))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<(), E> {
        self.take(Value::Number(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<(), E> {
        self.take(Value::Number(value as f64))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<(), E> {
        self.take(Value::Number(value))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<(), E> {
        let secs = TIMES.iter().find_map(|form| form.secs(text.as_bytes()));
        let number = || text.trim().parse().ok().map(Value::Number);
        self.take(secs.map(Value::Time).or_else(number).unwrap_or(Value::Text))
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.take(Value::Nothing)
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

struct Channel {
    key: Key,
    /// Values up to the last row with this key.
    values: Vec<f64>,
    has_numbers: bool,
    has_times: bool,
}

impl Table {
    /// Creates an empty table for lines of this total length (bytes).
    fn of_bytes(n_bytes: u64) -> Self {
        Self {
            budget: Budget::of_file(n_bytes),
            channels: Vec::new(),
            places: HashMap::new(),
            n_rows: 0,
            has_more: false,
        }
    }

    fn add(&mut self, row: Row) -> Result<(), FileError> {
        for (at, (key, value)) in row.into_iter().enumerate() {
            // Most objects have the same keys in the same order.
            let is_next = self.channels.get(at).is_some_and(|own| own.key == key);
            let known = is_next.then_some(at).or_else(|| self.places.get(&key).copied());
            let at = match known {
                Some(at) => at,
                None if self.channels.len() == COLUMN_LIMIT => {
                    self.has_more = true;
                    continue;
                }
                None => {
                    self.places.insert(key.clone(), self.channels.len());
                    self.channels.push(Channel {
                        key,
                        values: Vec::new(),
                        has_numbers: false,
                        has_times: false,
                    });
                    self.channels.len() - 1
                }
            };
            let channel = &mut self.channels[at];
            let n_more = (self.n_rows + 1).saturating_sub(channel.values.len()) as u64;
            self.budget.take(&channel.key.0, n_more, VALUE_BYTES)?;
            channel.values.resize(self.n_rows + 1, f64::NAN);
            channel.values[self.n_rows] = value.number();
            channel.has_numbers |= matches!(value, Value::Number(_) | Value::Time(_));
            channel.has_times |= matches!(value, Value::Time(_));
        }
        self.n_rows += 1;
        Ok(())
    }

    /// Returns the columns with their keys. Lists of numbers become arrays, with the column names that other formats have.
    fn columns(mut self) -> Result<(Columns, Vec<Key>), FileError> {
        let missing = |channel: &Channel| (self.n_rows - channel.values.len()) as u64;
        let n_missing = self.channels.iter().map(missing).sum();
        self.budget.take("the table", n_missing, VALUE_BYTES)?;
        let mut lists: Vec<List> = Vec::new();
        for mut channel in self.channels {
            channel.values.resize(self.n_rows, f64::NAN);
            let (name, index) = &channel.key;
            let is_own = |own: &&mut List| {
                own.array.shape.len() == 2 && index.is_some() && own.array.name == *name
            };
            if let Some(own) = lists.iter_mut().find(is_own) {
                own.array.shape[1] += 1;
                own.array.values.append(&mut channel.values);
                own.keys.push(channel.key);
                own.has_numbers |= channel.has_numbers;
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
            lists.push(List { array, keys: vec![channel.key], has_numbers: channel.has_numbers });
        }
        let (with, without): (Vec<_>, Vec<_>) = lists.into_iter().partition(|own| own.has_numbers);
        let without = without.into_iter();
        let mut left_out: Vec<String> =
            without.map(|own| format!("{} (no numbers)", own.array.name)).collect();
        if self.has_more {
            left_out.push(format!("more than {COLUMN_LIMIT} keys"));
        }
        let (arrays, keys): (Vec<_>, Vec<_>) =
            with.into_iter().map(|own| (own.array, own.keys)).unzip();
        Ok((arrays::columns(arrays, left_out), keys.concat()))
    }
}

/// Values of one key, or of a list under one key.
struct List {
    array: Array,
    keys: Vec<Key>,
    has_numbers: bool,
}
