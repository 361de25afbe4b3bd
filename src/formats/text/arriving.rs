//! Text that arrives piece by piece, as whole lines.
//!
//! Guarantees: the encoding is found as in whole files, by the first line; a line without an end does not fill the memory.

use super::encoding::{Encoding, decoded, encoding_of};

/// No line of a table is longer (bytes).
const LONGEST_LINE: usize = 1 << 20;
/// What stands for a longer one.
const TOO_LONG: &str = "(a line of more than 1 MiB)";
/// Length of a line that is enough to tell the encoding (bytes).
const ENOUGH: usize = 1 << 10;

/// The lines of a text that is not there as a whole yet.
#[derive(Debug, Default)]
pub(crate) struct ArrivingLines {
    encoding: Option<Encoding>,
    /// What is not decoded yet.
    raw: Vec<u8>,
    /// What is decoded.
    text: Vec<u8>,
    /// Where what is not handed on yet begins in it.
    start: usize,
    /// Up to here there is no end of the next line.
    searched: usize,
    is_too_long: bool,
}

impl ArrivingLines {
    /// Takes what has come.
    pub fn push(&mut self, bytes: &[u8]) {
        self.raw.extend_from_slice(bytes);
        if self.encoding.is_some() || self.raw.contains(&b'\n') || self.raw.len() >= ENOUGH {
            self.decode();
        }
    }

    fn decode(&mut self) {
        let encoding = *self.encoding.get_or_insert_with(|| {
            // What is no text makes no table, and is refused as that.
            let (encoding, mark_bytes) = encoding_of(&self.raw).unwrap_or((Encoding::Utf8, 0));
            self.raw.drain(..mark_bytes);
            encoding
        });
        let (mut text, rest) = decoded(encoding, std::mem::take(&mut self.raw));
        self.raw = rest;
        self.text.drain(..self.start);
        self.searched -= self.start;
        self.start = 0;
        self.text.append(&mut text);
    }

    /// Returns the next line that is whole, without its end.
    pub fn next_line(&mut self) -> Option<String> {
        let Some(at) = memchr::memchr(b'\n', &self.text[self.searched..]) else {
            if self.text.len() - self.start > LONGEST_LINE {
                self.is_too_long = true;
                self.text.clear();
                self.start = 0;
            }
            self.searched = self.text.len();
            return None;
        };
        let end = self.searched + at;
        let line = self.line(end);
        (self.start, self.searched) = (end + 1, end + 1);
        Some(line)
    }

    /// Returns the line that has begun, where nothing more comes.
    pub fn last_line(&mut self) -> Option<String> {
        self.decode();
        let end = self.text.len();
        (end > self.start).then(|| {
            let line = self.line(end);
            (self.start, self.searched) = (end, end);
            line
        })
    }

    fn line(&mut self, end: usize) -> String {
        if std::mem::take(&mut self.is_too_long) {
            return TOO_LONG.to_owned();
        }
        let line = String::from_utf8_lossy(&self.text[self.start..end]);
        line.trim_end_matches('\r').to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &[u8], step: usize) -> Vec<String> {
        let mut arriving = ArrivingLines::default();
        let mut all = Vec::new();
        for piece in text.chunks(step) {
            arriving.push(piece);
            all.extend(std::iter::from_fn(|| arriving.next_line()));
        }
        all.extend(arriving.last_line());
        all
    }

    #[test]
    fn whatever_the_encoding_and_the_pieces_the_lines_are_the_same() {
        let text = "\u{feff}t [µs],S1\r\n0,1\n\n5,3";
        let utf16 = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            text.encode_utf16().flat_map(bytes).collect()
        };
        for content in [text.as_bytes().to_vec(), utf16(u16::to_le_bytes), utf16(u16::to_be_bytes)]
        {
            for step in [1, 2, 3, 7, 100] {
                assert_eq!(lines(&content, step), ["t [µs],S1", "0,1", "", "5,3"], "{step}");
            }
        }
    }

    #[test]
    fn a_line_without_an_end_is_one_line_and_takes_no_memory() {
        let long = [b"a,b\n".to_vec(), vec![b'1'; 5 << 20], b"\n2,3\n".to_vec()].concat();
        assert_eq!(lines(&long, 1 << 16), ["a,b", TOO_LONG, "2,3"]);
        let mut arriving = ArrivingLines::default();
        for _ in 0..64 {
            arriving.push(&vec![b'1'; 1 << 16]);
            assert_eq!(arriving.next_line(), None);
            assert!(arriving.text.len() < 2 * LONGEST_LINE);
        }
    }
}
