//! First lines of a file, and the names in a header.

use std::borrow::Cow;

use encoding_rs::{
    BIG5, EUC_KR, Encoding, GBK, SHIFT_JIS, WINDOWS_1250, WINDOWS_1251, WINDOWS_1252, WINDOWS_1253,
};

use crate::formats::{
    column_name::has_foreign_word,
    csv::unguarded,
    text::{
        cells::{Cells, is_skipped},
        written::Delimiter,
    },
};

/// Minimum number of first bytes of a file in which the header of its table is searched.
pub(in crate::formats::text) const HEAD_BYTES: usize = 1 << 16;
/// Number of first lines of a file that are inspected to find its table, not counting comments.
const INSPECTED_LINES: usize = 200;

#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    pub number: u64,
    /// Position in the file where the line after this one starts (bytes).
    pub end: usize,
    pub text: &'a [u8],
}

/// Returns the first lines of a file up to the last one that is inspected. The first `n_skipped` lines are returned too, but
/// do not count towards the limit.
pub fn first_lines(head: &[u8], n_skipped: usize) -> Vec<Line<'_>> {
    let mut lines = Vec::new();
    let mut start = 0;
    let mut n_significant = 0;
    while start < head.len() && n_significant < INSPECTED_LINES {
        let end = memchr::memchr(b'\n', &head[start..]).map_or(head.len(), |at| start + at);
        let text = head[start..end].trim_ascii_end();
        start = head.len().min(end + 1);
        n_significant += usize::from(lines.len() >= n_skipped && !is_skipped(text));
        lines.push(Line { number: lines.len() as u64 + 1, end: start, text });
    }
    lines
}

/// Returns the cells of a header, without empty cells at the end. If blanks separate the cells, a unit in brackets stays
/// with its name.
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

/// Decodes a line as UTF-8, or else as Windows-1252, which contains Latin-1. Another code page is used only if it is proven by
/// a word for a quantity that the line then contains.
fn decoded(text: &[u8]) -> Cow<'_, str> {
    const PAGES: [&Encoding; 8] =
        [WINDOWS_1252, WINDOWS_1250, WINDOWS_1251, WINDOWS_1253, GBK, SHIFT_JIS, EUC_KR, BIG5];
    if let Ok(text) = std::str::from_utf8(text) {
        return Cow::Borrowed(text);
    }
    let mut in_pages = PAGES
        .iter()
        .filter_map(|page| page.decode_without_bom_handling_and_without_replacement(text));
    in_pages
        .find(|line| has_foreign_word(line))
        .unwrap_or_else(|| WINDOWS_1252.decode_without_bom_handling(text).0)
}

pub fn unbracketed(cell: &str) -> &str {
    let inside = |open, close| cell.strip_prefix(open)?.strip_suffix(close);
    inside('[', ']').or_else(|| inside('(', ')')).unwrap_or(cell).trim()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_page_is_used_if_a_known_word_proves_it() {
        for (page, written) in [
            (WINDOWS_1251, "Время, с;Сила [Н]"),
            (WINDOWS_1250, "Czas [s];Siła [N]"),
            (WINDOWS_1253, "Χρόνος;Δύναμη"),
            (GBK, "时间;力矩"),
            (SHIFT_JIS, "時間;荷重"),
            (WINDOWS_1252, "Prüfzeit [s];Kraft [µN]"),
            (WINDOWS_1252, "Temp [°C];Größe \u{2013} Weg"),
            (WINDOWS_1252, "Naïveté;Ångström"),
        ] {
            let (bytes, _, _) = page.encode(written);
            assert!(std::str::from_utf8(&bytes).is_err());
            assert_eq!(decoded(&bytes), written);
        }
    }
}
