//! Columns of numbers from files that are not text, and rows of cells that are read in order from any file.

use crate::shown;
/// One of the tables of a file with several tables, such as a sheet of a workbook.
#[derive(Clone, Debug, serde::Serialize)]
pub struct FilePart {
    /// Name by which a column map selects the table.
    pub name: String,
    pub what: String,
    pub is_used: bool,
}

/// Columns of numbers that were read from a file that is not text.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    pub columns: Vec<Column>,
    pub is_named: bool,
    pub reference_time: Option<usize>,
    /// Number of lines above the rows, of a sheet of a workbook.
    pub n_lines: u64,
    /// Name and kind of each part of the file that is not read.
    pub left_out: Vec<String>,
    pub ends_early: bool,
    /// All tables of the file; empty if there is only one.
    pub parts: Vec<FilePart>,
    /// True if the file holds several tables and the program chose one, because the user did not.
    pub is_guessed_part: bool,
}

/// Column of numbers, whose name is written as in the header of a text file. Columns on another clock may have another
/// length.
#[derive(Clone, Debug, Default)]
pub struct Column {
    pub name: String,
    pub unit: String,
    /// Number that was subtracted from each stored value, and must be added again. Large whole numbers, such as nanoseconds
    /// since 1970, keep all digits this way.
    pub since: i64,
    pub values: Vec<f64>,
    /// Rows whose cell holds a text instead of a number, with this text. `Some` only for the sheet of a workbook, whose other
    /// cells without a number are empty.
    pub texts: Option<Vec<(usize, String)>>,
}

/// Limit below which a 64-bit float represents every whole number exactly.
const EXACT: u64 = 1 << f64::MANTISSA_DIGITS;

/// Returns a whole number minus the origin of its column ([`Column::since`]). The first number of the column sets the origin:
/// to this number if it exceeds [`EXACT`], else to zero.
pub fn from_origin(number: i64, origin: &mut Option<i64>) -> f64 {
    let of_first = if number.unsigned_abs() > EXACT { number } else { 0 };
    number.saturating_sub(*origin.get_or_insert(of_first)) as f64
}

impl Columns {
    pub fn n_rows(&self) -> usize {
        self.columns.iter().map(|column| column.values.len()).max().unwrap_or(0)
    }

    pub fn row(&self, row: usize) -> NumberRow<'_> {
        NumberRow { columns: self.columns.iter(), row }
    }
}

/// Sample of the rows of a file: its first rows, and a few rows from each of many places of the file.
#[derive(Debug, Default)]
pub struct Sample<'a> {
    pub rows: Vec<Vec<Cell<'a>>>,
    /// Index in `rows` of the first row from each place of the file.
    starts: Vec<usize>,
}

impl<'a> Sample<'a> {
    pub fn add_place(&mut self, rows: impl Iterator<Item = Vec<Cell<'a>>>) {
        self.starts.push(self.rows.len());
        self.rows.extend(rows);
    }

    pub fn places(&self) -> impl Iterator<Item = &[Vec<Cell<'a>>]> {
        let ends = self.starts.iter().copied().skip(1).chain([self.rows.len()]);
        self.starts.iter().zip(ends).map(|(&start, end)| &self.rows[start..end])
    }
}

/// Number of places of a file, besides its start, from which rows are sampled.
pub const PLACES: usize = 64;
pub const ROWS_AT_A_PLACE: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell<'a> {
    /// Text of the cell as written, without quotes; may be empty.
    Text(&'a [u8]),
    Number(f64),
    /// Whole number and remainder, whose sum is the value. Times that are counted from long ago, such as 1970, keep all
    /// digits in this form.
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
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    pub fn text(self) -> String {
        match self {
            Self::Text(text) => String::from_utf8_lossy(text).into_owned(),
            Self::Number(number) => shown::number(number),
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

pub trait Row<'a>: Iterator<Item = Cell<'a>> + Clone {
    /// Returns the next cell if it is a plain number. Otherwise returns `None` and stays before this cell.
    fn next_number(&mut self) -> Option<f64> {
        match self.clone().next()? {
            Cell::Number(number) => {
                self.next();
                Some(number)
            }
            Cell::Text(_) | Cell::Since(..) => None,
        }
    }
}

/// Row of cells from columns of numbers. A column that has already ended gives an empty cell.
#[derive(Clone, Debug)]
pub struct NumberRow<'a> {
    columns: std::slice::Iter<'a, Column>,
    row: usize,
}

impl<'a> Iterator for NumberRow<'a> {
    type Item = Cell<'a>;

    fn next(&mut self) -> Option<Cell<'a>> {
        let column = self.columns.next()?;
        if let Some(texts) = &column.texts
            && column.values.get(self.row).is_some_and(|value| value.is_nan())
        {
            let found = texts.binary_search_by_key(&self.row, |(row, _)| *row);
            return Some(Cell::Text(found.map_or(b"", |at| texts[at].1.as_bytes())));
        }
        Some(match (column.values.get(self.row), column.since) {
            (None, _) => Cell::Text(b""),
            (Some(value), 0) => Cell::Number(*value),
            (Some(value), since) => Cell::Since(since, *value),
        })
    }
}

impl<'a> Row<'a> for NumberRow<'a> {}
