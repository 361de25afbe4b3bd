//! Columns of numbers, and rows of cells as they are looked at one after the other.

use crate::recording::Day;

/// One of several parts of a file that could be the table.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct FilePart {
    /// What it is called in the file; a map names it so.
    pub name: String,
    /// What is in it.
    pub what: String,
    /// Whether it is read.
    pub is_used: bool,
}

/// Columns of numbers, as a file that is no text holds them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Columns {
    pub columns: Vec<Column>,
    /// Whether the columns have names.
    pub is_named: bool,
    /// Which column is the clock of the reference, where that is another than the gauges'.
    pub reference_time: Option<usize>,
    /// The day of the recording, where the file itself says it.
    pub day: Option<Day>,
    /// What else the file holds, and what it is.
    pub left_out: Vec<String>,
    /// Whether the file ends before it should.
    pub ends_early: bool,
    /// Where the file holds several tables, all of them.
    pub parts: Vec<FilePart>,
    /// Whether nobody said which of them it is.
    pub is_guessed_part: bool,
}

/// One column; another clock's columns may have another length.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Column {
    /// As a header of text would have it; empty without names.
    pub name: String,
    /// Where the file itself says it; empty otherwise.
    pub unit: String,
    /// Added to each of the values: large whole numbers keep their digits so.
    pub since: i64,
    pub values: Vec<f64>,
}

/// Up to here a number of 64 bits has every whole number.
const EXACT: u64 = 1 << f64::MANTISSA_DIGITS;

/// What whole numbers are counted from ([`Column::since`]): zero, or the first one where numbers are too large to keep their digits.
#[derive(Clone, Debug, Default)]
pub(super) struct Since(std::cell::Cell<Option<i64>>);

impl Since {
    pub fn zero() -> Self {
        Self(std::cell::Cell::new(Some(0)))
    }

    pub fn number(&self, value: i64) -> f64 {
        let of_first = if value.unsigned_abs() > EXACT { value } else { 0 };
        let since = self.0.get().unwrap_or(of_first);
        self.0.set(Some(since));
        value.saturating_sub(since) as f64
    }

    pub fn get(&self) -> i64 {
        self.0.get().unwrap_or(0)
    }
}

impl Columns {
    /// How long the longest column is.
    pub fn n_rows(&self) -> usize {
        let lengths = self.columns.iter().map(|column| column.values.len());
        lengths.max().unwrap_or(0)
    }

    /// The names of the parts that are read, where there are several.
    pub(super) fn used_parts(&self) -> Vec<String> {
        let used = self.parts.iter().filter(|part| part.is_used);
        used.map(|part| part.name.clone()).collect()
    }

    pub fn row(&self, row: usize) -> NumberRow<'_> {
        NumberRow { columns: self.columns.iter(), row }
    }
}

/// Rows of a file from its start to its end: its first ones, and some at places all over the rest.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sample<'a> {
    pub rows: Vec<Vec<Cell<'a>>>,
    /// With which row each place starts.
    starts: Vec<usize>,
}

impl<'a> Sample<'a> {
    /// Appends rows that follow one another.
    pub(super) fn add_place(&mut self, rows: impl Iterator<Item = Vec<Cell<'a>>>) {
        self.starts.push(self.rows.len());
        self.rows.extend(rows);
    }

    /// The rows of each place, which follow one another there.
    pub fn places(&self) -> impl Iterator<Item = &[Vec<Cell<'a>>]> {
        let ends = self.starts.iter().copied().skip(1).chain([self.rows.len()]);
        let starts = self.starts.iter();
        starts.zip(ends).map(|(&start, end)| &self.rows[start..end])
    }
}

/// At how many places besides its start a file is looked at.
pub(super) const PLACES: usize = 64;
/// How many rows are looked at there.
pub(super) const ROWS_AT_A_PLACE: usize = 8;

/// What stands in one column of one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cell<'a> {
    /// As it is written, without quotes; nothing where there is nothing.
    Text(&'a [u8]),
    Number(f64),
    /// The sum of the two; for times that are counted from long ago.
    Since(i64, f64),
}

impl<'a> Cell<'a> {
    pub fn is_empty(self) -> bool {
        self == Self::Text(b"")
    }

    /// Whether no value stands there: nothing, or NaN.
    pub fn is_blank(self) -> bool {
        match self {
            Self::Text(text) => text.is_empty() || text.eq_ignore_ascii_case(b"nan"),
            Self::Number(number) | Self::Since(_, number) => number.is_nan(),
        }
    }

    /// As it is written; nothing of a number.
    pub fn written(self) -> Option<&'a [u8]> {
        match self {
            Self::Text(text) => Some(text),
            Self::Number(_) | Self::Since(..) => None,
        }
    }

    /// For people.
    pub fn text(self) -> String {
        match self {
            Self::Text(text) => String::from_utf8_lossy(text).into_owned(),
            Self::Number(number) => number.to_string(),
            Self::Since(since, number) => (since as f64 + number).to_string(),
        }
    }

    /// The start of [`Cell::text`], long enough for any message.
    pub fn shown(self) -> String {
        const LONG_ENOUGH_BYTES: usize = 200;
        match self {
            Self::Text(text) => Self::Text(&text[..text.len().min(LONG_ENOUGH_BYTES)]).text(),
            Self::Number(_) | Self::Since(..) => self.text(),
        }
    }
}

/// The cells of one row, from left to right.
pub(crate) trait Row<'a>: Iterator<Item = Cell<'a>> + Clone {
    /// The next cell if it is a plain number; otherwise `None`, and the cell is still the next one.
    fn next_number(&mut self) -> Option<f64>;
}

/// A row of columns of numbers; nothing stands below the end of a shorter column.
#[derive(Clone, Debug)]
pub(crate) struct NumberRow<'a> {
    columns: std::slice::Iter<'a, Column>,
    row: usize,
}

impl<'a> Iterator for NumberRow<'a> {
    type Item = Cell<'a>;

    fn next(&mut self) -> Option<Cell<'a>> {
        let column = self.columns.next()?;
        Some(match (column.values.get(self.row), column.since) {
            (None, _) => Cell::Text(b""),
            (Some(value), 0) => Cell::Number(*value),
            (Some(value), since) => Cell::Since(since, *value),
        })
    }
}

impl<'a> Row<'a> for NumberRow<'a> {
    fn next_number(&mut self) -> Option<f64> {
        let column = self.columns.as_slice().first().filter(|own| own.since == 0)?;
        let value = *column.values.get(self.row)?;
        self.columns.next();
        Some(value)
    }
}
