//! The first lines of a file, and the names in one of them.

use std::borrow::Cow;

use crate::formats::csv::unguarded;
use crate::formats::text::cells::{Cells, is_skipped};
use crate::formats::text::written::Delimiter;

/// How many lines besides comments are looked at.
const LINES_LOOKED_AT: usize = 200;

/// One line of the start of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<'a> {
    /// Counted from 1.
    pub number: u64,
    /// Where the next line starts.
    pub end: usize,
    /// Without its end.
    pub text: &'a [u8],
}

/// All lines up to the last that is looked at, the first `n_skipped` of which do not count.
pub(super) fn first_lines(head: &[u8], n_skipped: usize) -> Vec<Line<'_>> {
    let mut lines = Vec::new();
    let mut start = 0;
    let mut n_significant = 0;
    while start < head.len() && n_significant < LINES_LOOKED_AT {
        let end = memchr::memchr(b'\n', &head[start..]).map_or(head.len(), |at| start + at);
        let text = head[start..end].trim_ascii_end();
        start = head.len().min(end + 1);
        n_significant += usize::from(lines.len() >= n_skipped && !is_skipped(text));
        lines.push(Line { number: lines.len() as u64 + 1, end: start, text });
    }
    lines
}

/// A header's cells. Where whitespace is the delimiter, a unit in brackets stays with its name; cells without a name at
/// the end are left out.
pub(in crate::formats::text) fn names(text: &[u8], delimiter: Delimiter) -> Vec<String> {
    let text = decoded(text);
    let mut cells: Vec<String> = Vec::new();
    let mut is_open = false;
    for cell in Cells::new(text.as_bytes(), delimiter) {
        let cell = String::from_utf8_lossy(cell).replace("\"\"", "\"");
        let cell = unguarded(&cell).to_owned();
        let last_bracket = cell.rfind(['[', '(', ']', ')']);
        let opens = last_bracket.map(|at| cell[at..].starts_with(['[', '(']));
        match cells.last_mut() {
            Some(last)
                if delimiter == Delimiter::Spaces && (cell.starts_with(['[', '(']) || is_open) =>
            {
                last.push(' ');
                last.push_str(&cell);
                is_open = opens.unwrap_or(is_open);
            }
            _ => {
                is_open = opens.unwrap_or(false);
                cells.push(cell);
            }
        }
    }
    while cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
    cells
}

/// UTF-8, or else Latin-1: then every byte is its own character.
fn decoded(text: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(text) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => text.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// A unit without the brackets that it may stand in.
pub(super) fn unbracketed(cell: &str) -> &str {
    let inside = |open, close| cell.strip_prefix(open)?.strip_suffix(close);
    inside('[', ']').or_else(|| inside('(', ')')).unwrap_or(cell).trim()
}
