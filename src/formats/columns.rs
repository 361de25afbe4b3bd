//! Columns of numbers, and rows of cells that are read in order.

use crate::recording::Day;

/// One of several tables of a file.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct FilePart {
    /// As in a column map.
    pub name: String,
    pub what: String,
    pub is_used: bool,
}

/// Columns of numbers of a file that is not text.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Columns {
    pub columns: Vec<Column>,
    pub is_named: bool,
    pub reference_time: Option<usize>,
    pub day: Option<Day>,
    /// Names and kinds of the parts of the file that are not read.
    pub left_out: Vec<String>,
    /// True if the file is cut short.
    pub ends_early: bool,
    /// All tables of the file; empty if there is only one.
    pub parts: Vec<FilePart>,
    /// True if the program chose among the tables because the user did not.
    pub is_guessed_part: bool,
}

/// One column, named as a text header would name it. Columns of another clock may have another length.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Column {
    pub name: String,
    pub unit: String,
    /// Offset to be added to each value. The offset keeps all digits of large whole numbers.
    pub since: i64,
    pub values: Vec<f64>,
}

/// Limit below which a 64-bit float represents every whole number exactly.
const EXACT: u64 = 1 << f64::MANTISSA_DIGITS;

/// Origin of the whole numbers of a column ([`Column::since`]): zero, or the first number if it exceeds [`EXACT`].
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
    pub fn n_rows(&self) -> usize {
        let lengths = self.columns.iter().map(|column| column.values.len());
        lengths.max().unwrap_or(0)
    }

    /// Returns the names of the tables that are read, if the file holds several.
    pub(super) fn used_parts(&self) -> Vec<String> {
        let used = self.parts.iter().filter(|part| part.is_used);
        used.map(|part| part.name.clone()).collect()
    }

    pub fn row(&self, row: usize) -> NumberRow<'_> {
        NumberRow { columns: self.columns.iter(), row }
    }
}

/// Rows from the start of a file and from places all over the rest.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sample<'a> {
    pub rows: Vec<Vec<Cell<'a>>>,
    /// Index of the first row of each place.
    starts: Vec<usize>,
}

impl<'a> Sample<'a> {
    /// Appends successive rows from one place.
    pub(super) fn add_place(&mut self, rows: impl Iterator<Item = Vec<Cell<'a>>>) {
        self.starts.push(self.rows.len());
        self.rows.extend(rows);
    }

    pub fn places(&self) -> impl Iterator<Item = &[Vec<Cell<'a>>]> {
        let ends = self.starts.iter().copied().skip(1).chain([self.rows.len()]);
        let starts = self.starts.iter();
        starts.zip(ends).map(|(&start, end)| &self.rows[start..end])
    }
}

/// Number of places, besides the start of the file, from which rows are sampled.
pub(super) const PLACES: usize = 64;
/// Number of rows sampled at each place.
pub(super) const ROWS_AT_A_PLACE: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cell<'a> {
    /// Text as written, without quotes; may be empty.
    Text(&'a [u8]),
    Number(f64),
    /// Sum of the two, for times that are counted from long ago.
    Since(i64, f64),
}

impl<'a> Cell<'a> {
    pub fn is_empty(self) -> bool {
        self == Self::Text(b"")
    }

    /// Returns true if the cell holds no value: it is empty or NaN.
    pub fn is_blank(self) -> bool {
        match self {
            Self::Text(text) => text.is_empty() || text.eq_ignore_ascii_case(b"nan"),
            Self::Number(number) | Self::Since(_, number) => number.is_nan(),
        }
    }

    pub fn written(self) -> Option<&'a [u8]> {
        match self {
            Self::Text(text) => Some(text),
            Self::Number(_) | Self::Since(..) => None,
        }
    }

    /// Returns the contents as readable text.
    pub fn text(self) -> String {
        match self {
            Self::Text(text) => String::from_utf8_lossy(text).into_owned(),
            Self::Number(number) => number.to_string(),
            Self::Since(since, number) => (since as f64 + number).to_string(),
        }
    }

    /// Returns the start of [`Cell::text`], long enough for a message.
    pub fn shown(self) -> String {
        const LONG_ENOUGH_BYTES: usize = 200;
        match self {
            Self::Text(text) => Self::Text(&text[..text.len().min(LONG_ENOUGH_BYTES)]).text(),
            Self::Number(_) | Self::Since(..) => self.text(),
        }
    }
}

/// Cells of one row, from left to right.
pub(crate) trait Row<'a>: Iterator<Item = Cell<'a>> + Clone {
    /// Returns the next cell if it is a plain number. Otherwise returns `None` and does not advance.
    fn next_number(&mut self) -> Option<f64>;
}

/// Row of columns of numbers. Below the end of a shorter column the cell is empty.
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
