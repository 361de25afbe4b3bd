//! Lines that terminals for serial ports save, with the time of day and an arrow in front: `12:03:04.123 -> 801,799`.

use super::{
    cells::{Cells, delimiter_of_header, lines, number},
    times::TimeForm,
};

/// Returns a text whose lines begin with a time and an arrow as a table in which the delimiter of the rows replaces the arrows.
/// If the first line is a header, the name `time` replaces its time. `None` if the first line has no arrow.
pub fn table(text: &[u8]) -> Option<Vec<u8>> {
    let first = lines(text).find(|line| !line.trim_ascii().is_empty())?;
    let names = &first[stamped(first)?.1..];
    let delimiter = delimiter_of_header(names);
    let is_word = |cell: &[u8]| !cell.is_empty() && number(cell).is_none();
    let is_header = Cells::new(names.trim_ascii(), delimiter).any(is_word);
    let with_column = |line: &[u8]| match stamped(line) {
        Some((_, row)) if is_header && line == first => {
            [&b"time"[..], &line[row..]].join(&delimiter.byte())
        }
        Some((time, row)) => [&line[..time], &line[row..]].join(&delimiter.byte()),
        None => line.to_vec(),
    };
    Some(lines(text).map(with_column).collect::<Vec<_>>().join(&b'\n'))
}

/// Returns the positions in a line where the time in front ends and where the row behind the arrow starts; `None` without an
/// arrow.
pub fn stamped(line: &[u8]) -> Option<(usize, usize)> {
    const ARROW: &[u8] = b" -> ";
    const LONGEST_TIME: usize = 32;
    let start = &line[..line.len().min(LONGEST_TIME)];
    let at = memchr::memmem::find(start, ARROW)?;
    TimeForm::of_all([&line[..at]].into_iter()).map(|_| (at, at + ARROW.len()))
}
