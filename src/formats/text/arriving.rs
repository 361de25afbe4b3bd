//! Splits text that arrives in pieces into whole lines. The encoding is detected from the first line, as for whole files. A
//! line without an end is cut at a limit and does not fill the memory.

use super::{
    blocks::LINE_LIMIT_BYTES,
    encoding::{Encoding, decoded, encoding_of},
};

/// Text that replaces a line longer than [`LINE_LIMIT_BYTES`].
const TOO_LONG: &str = "(a line of more than 1 MiB)";
/// Number of bytes that suffice to detect the encoding of a text whose first line has not ended yet.
const ENCODING_BYTES: usize = 1 << 10;

#[derive(Debug, Default)]
pub struct ArrivingLines {
    encoding: Option<Encoding>,
    /// Bytes that are still to be decoded to text.
    raw: Vec<u8>,
    text: Vec<u8>,
    /// Position in `text` where the next line starts.
    start: usize,
    /// Position in `text` up to which the search for the next end of a line found none.
    searched: usize,
    is_too_long: bool,
    /// True if the last line ended with `\r`, which `\n` may follow.
    is_after_return: bool,
}

impl ArrivingLines {
    pub fn push(&mut self, bytes: &[u8]) {
        self.raw.extend_from_slice(bytes);
        if self.encoding.is_some() || self.raw.contains(&b'\n') || self.raw.len() >= ENCODING_BYTES
        {
            self.decode();
        }
    }

    fn decode(&mut self) {
        let encoding = *self.encoding.get_or_insert_with(|| {
            // Bytes that are not text are decoded as UTF-8. The file is refused later, because such lines are no rows of a
            // table.
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

    /// Returns the next complete line, without its line end: `\n`, `\r\n` or `\r`.
    pub fn next_line(&mut self) -> Option<String> {
        // The line end `\r` of the last line was returned before it was known that `\n` follows.
        if self.is_after_return && self.start < self.text.len() {
            self.is_after_return = false;
            self.start += usize::from(self.text[self.start] == b'\n');
            self.searched = self.searched.max(self.start);
        }
        let Some(at) = memchr::memchr2(b'\n', b'\r', &self.text[self.searched..]) else {
            if self.text.len() - self.start > LINE_LIMIT_BYTES {
                self.is_too_long = true;
                self.text.clear();
                self.start = 0;
            }
            self.searched = self.text.len();
            return None;
        };
        let end = self.searched + at;
        self.is_after_return = self.text[end] == b'\r';
        Some(self.line(end, end + 1))
    }

    pub fn last_line(&mut self) -> Option<String> {
        self.decode();
        if let Some(line) = self.next_line() {
            return Some(line);
        }
        let end = self.text.len();
        (end > self.start).then(|| self.line(end, end))
    }

    fn line(&mut self, end: usize, next: usize) -> String {
        let start = std::mem::replace(&mut self.start, next);
        self.searched = next;
        if std::mem::take(&mut self.is_too_long) {
            return TOO_LONG.to_owned();
        }
        String::from_utf8_lossy(&self.text[start..end]).into_owned()
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
    fn lines_do_not_depend_on_the_encoding_or_the_pieces() {
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
    fn lines_may_end_with_a_carriage_return_alone() {
        for step in [1, 2, 3, 100] {
            assert_eq!(lines(b"t,S1\r0,1\r\r\n5,3\r", step), ["t,S1", "0,1", "", "5,3"], "{step}");
        }
    }

    #[test]
    fn a_line_without_an_end_is_one_line_and_takes_little_memory() {
        let long = [b"a,b\n".to_vec(), vec![b'1'; 5 << 20], b"\n2,3\n".to_vec()].concat();
        assert_eq!(lines(&long, 1 << 16), ["a,b", TOO_LONG, "2,3"]);
        let mut arriving = ArrivingLines::default();
        for _ in 0..64 {
            arriving.push(&vec![b'1'; 1 << 16]);
            assert_eq!(arriving.next_line(), None);
            assert!(arriving.text.len() < 2 * LINE_LIMIT_BYTES);
        }
    }
}
