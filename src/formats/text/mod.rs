//! Delimited text, as loggers and spreadsheets write it.
//!
//! Guarantees: a file of any size is read in blocks of whole lines and never held in memory; every number keeps its line.
//!
//! | room | what |
//! |---|---|
//! | `encoding`, `blocks`, `stream` | a file as text, in blocks of whole lines, many parsed at a time |
//! | `cells`, [`times`] | cells, numbers, dates |
//! | `layout` | where the table stands and how it is cut |
//! | [`ati`] | the lines that ATI's program writes above its rows |

pub(crate) mod ati;
mod blocks;
pub(crate) mod cells;
mod encoding;
mod layout;
mod stream;
pub(crate) mod times;

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use encoding::Encoding;
pub(crate) use layout::{Head, detect, locate};

use super::columns::TextRow;
use super::{Cell, FileError, Format};
use blocks::Blocks;
use cells::{Cells, decimal_comma_number, is_skipped, number};

/// What starts like no other format.
pub(super) const FORMAT: Format = Format {
    name: "delimited text",
    endings: &["csv", "txt", "tsv", "dat"],
    signatures: &[],
    read: |_| Ok(None),
};

/// So much of a text is there when its table is looked for.
const HEAD_BYTES: usize = 1 << 16;

/// A text that was opened, and its start.
#[derive(Debug)]
pub(crate) struct TextFile {
    blocks: Blocks,
    head: Vec<u8>,
}

impl TextFile {
    /// Opens a file; with a limit, only so many bytes of it are read.
    pub(super) fn open(
        path: &Path,
        block_bytes: usize,
        limit_bytes: Option<u64>,
    ) -> Result<Self, FileError> {
        let mut blocks = Blocks::open(path, block_bytes, limit_bytes)?;
        let head = blocks.head(HEAD_BYTES)?;
        Ok(Self { blocks, head })
    }

    /// How the table is written, found by looking; `None` if there is none.
    pub(super) fn layout(&self) -> Option<TextLayout> {
        detect(&self.head)
    }

    /// Where the table is by a layout; `None` if it is not there.
    pub(super) fn head(&self, layout: &TextLayout) -> Option<Head> {
        locate(&self.head, layout)
    }

    /// The cells of the first rows.
    pub(super) fn first_rows(&self, layout: &TextLayout, head: &Head) -> Vec<Vec<Cell<'_>>> {
        layout::first_rows(&self.head, layout, head)
    }

    /// How many rows the file has if all are like those of its head.
    pub(super) fn about_rows(&self, head: &Head) -> u64 {
        let rows = &self.head[head.n_bytes.min(self.head.len())..];
        let n_rows = lines(rows).filter(|line| !is_skipped(line)).count() as f64;
        let text_bytes = self.whole_file_bytes() / self.encoding().bytes_per_character();
        let share =
            text_bytes.saturating_sub(head.n_bytes as u64) as f64 / rows.len().max(1) as f64;
        // A file that is here as a whole differs by its byte order mark at most.
        let share = if share < 1.001 { 1.0 } else { share };
        (n_rows * share).round() as u64
    }

    pub(super) fn encoding(&self) -> Encoding {
        self.blocks.encoding()
    }

    /// How many bytes of the file are read in all; its length when it was opened, or less.
    pub(super) fn file_bytes(&self) -> u64 {
        self.blocks.file_bytes()
    }

    /// How long the file was when it was opened.
    pub(super) fn whole_file_bytes(&self) -> u64 {
        self.blocks.whole_file_bytes()
    }
}

/// The lines of a text, without their `\n`.
pub(crate) fn lines(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let end = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
        let line = &rest[..end];
        rest = rest.get(end + 1..).unwrap_or_default();
        Some(line)
    })
}

/// How the text of a table is cut into cells and numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TextLayout {
    /// What stands between two cells.
    pub delimiter: Delimiter,
    /// What stands between the whole part of a number and its decimals.
    pub decimal: Decimal,
    /// How many lines at the start are no part of the table. Blank lines and comments (`#`) need not be counted.
    pub skip_rows: usize,
    /// Whether the next line names the columns.
    pub header: bool,
    /// Whether the line after the header holds units.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub units_row: bool,
    /// A preamble that says more than nothing; `skip_rows` does not matter with one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preamble: Option<Preamble>,
}

impl TextLayout {
    /// The cells of a line; `None` if it is blank or a comment.
    pub(crate) fn row<'a>(&self, line: &'a [u8]) -> Option<TextRow<'a>> {
        (!is_skipped(line)).then(|| TextRow {
            cells: Cells::new(line.strip_suffix(b"\r").unwrap_or(line), self.delimiter),
            point: match self.decimal {
                Decimal::Point => b'.',
                Decimal::Comma => b',',
            },
        })
    }

    /// The number in a cell, and whether its comma had to be read as a decimal point although none is expected.
    pub(crate) fn number(&self, cell: &[u8]) -> Option<(f64, bool)> {
        let with_comma = || decimal_comma_number(cell);
        match self.decimal {
            Decimal::Comma => {
                let is_whole = !cell.contains(&b'.');
                let value = with_comma().or_else(|| is_whole.then(|| number(cell)).flatten())?;
                Some((value, false))
            }
            Decimal::Point => match number(cell) {
                Some(value) => Some((value, false)),
                None if self.delimiter.allows_decimal_comma() => Some((with_comma()?, true)),
                None => None,
            },
        }
    }
}

/// What stands between two cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names are the documentation")]
pub enum Delimiter {
    #[default]
    Comma,
    Semicolon,
    Tab,
    /// Any run of blanks and tabs.
    Spaces,
}

impl Delimiter {
    /// All of them, the ones that say most first.
    pub const ALL: [Self; 4] = [Self::Tab, Self::Semicolon, Self::Comma, Self::Spaces];

    /// As in the file of a map.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Comma => "comma",
            Self::Semicolon => "semicolon",
            Self::Tab => "tab",
            Self::Spaces => "spaces",
        }
    }
}

/// What stands between the whole part of a number and its decimals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Decimal {
    /// A point. Where a comma cannot stand between cells, a single one is read as a decimal point too, and told.
    #[default]
    Point,
    /// A comma only: `1.5` is then no number, since it may mean fifteen hundred.
    Comma,
}

/// A preamble that is understood: units, counts per unit and sample rate are read from it in each file anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preamble {
    /// What the demonstration program of ATI's Net F/T writes.
    AtiNetFt,
}
