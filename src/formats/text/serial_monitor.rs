//! Lines that terminals for serial ports save, with the time of day and an arrow in front: `12:03:04.123 -> 801,799`.

use super::{
    cells::{delimiter_of_header, number},
    times::TimeForm,
};

const ARROW: &[u8] = b" -> ";

/// Bytes that replace each arrow. They are as many as the arrow has, so that positions in the file stay valid.
#[derive(Clone, Copy, Debug)]
pub struct Arrows {
    replacement: [u8; ARROW.len()],
}

impl Arrows {
    /// Returns the replacement of the arrows; `None` unless the first line of the text starts with a time and an arrow.
    pub fn of(text: &[u8]) -> Option<Self> {
        let line = text.split(|byte| *byte == b'\n').find(|line| !line.trim_ascii().is_empty())?;
        let at = arrow_position(line)?;
        let delimiter = delimiter_of_header(&line[at + ARROW.len()..]);
        let replacement = [delimiter.byte(), b' ', b' ', b' '];
        Some(Self { replacement })
    }

    /// Turns the times in front of whole lines into a column. If the first line of the file is a header, the name `time`
    /// replaces its time.
    pub fn mend(self, lines: &mut [u8], mut is_first: bool) {
        for line in lines.split_mut(|byte| *byte == b'\n') {
            let Some(at) = arrow_position(line) else {
                continue;
            };
            line[at..at + ARROW.len()].copy_from_slice(&self.replacement);
            let is_row = line[at..]
                .split(|byte| [b',', b';', b'\t', b' '].contains(byte))
                .filter(|cell| !cell.trim_ascii().is_empty())
                .all(|cell| number(cell.trim_ascii()).is_some());
            if std::mem::take(&mut is_first) && !is_row {
                line[..at].fill(b' ');
                line[..4].copy_from_slice(b"time");
            }
        }
    }
}

/// Returns the positions in a line where the time in front ends and where the row behind the arrow starts; `None` without an
/// arrow.
pub fn stamped(line: &[u8]) -> Option<(usize, usize)> {
    arrow_position(line).map(|at| (at, at + ARROW.len()))
}

/// Returns the position of the arrow behind the time in front of a line; `None` without an arrow.
fn arrow_position(line: &[u8]) -> Option<usize> {
    const LONGEST_TIME: usize = 32;
    let start = &line[..line.len().min(LONGEST_TIME)];
    let at = memchr::memmem::find(start, ARROW)?;
    TimeForm::of_all([&line[..at]].into_iter()).map(|_| at)
}
