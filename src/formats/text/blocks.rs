//! Reads a file in blocks that end at line ends, so that each block can be parsed on its own. Together the blocks are the
//! text of the file without its byte order mark.

use std::io;
use std::path::Path;

use super::{
    cells::{is_skipped, lines},
    encoding::Text,
};
use crate::formats::error::FileError;

/// Maximum length of a line (bytes). Without a limit, one line could fill the memory.
pub const LINE_LIMIT_BYTES: usize = 1 << 20;

#[derive(Debug)]
pub struct Blocks {
    pub text: Text,
    block_bytes: usize,
    /// Start of a line whose end has not been read yet.
    carry: Vec<u8>,
    is_at_end: bool,
}

impl Blocks {
    /// Opens a file and checks that it is text. At most `limit_bytes` are read.
    pub fn open(
        path: &Path,
        block_bytes: usize,
        limit_bytes: Option<u64>,
    ) -> Result<Self, FileError> {
        Ok(Self::of(Text::open(path, limit_bytes)?, block_bytes))
    }

    pub(crate) fn of(text: Text, block_bytes: usize) -> Self {
        Self { text, block_bytes, carry: Vec::new(), is_at_end: false }
    }

    /// Returns the whole lines among `n_bytes` bytes from byte `at` on. This does not change which block is next.
    pub fn lines_at(&self, path: &Path, at: u64, n_bytes: usize) -> io::Result<Vec<u8>> {
        let mut lines = self.text.part(path, at, n_bytes)?;
        if at + (n_bytes as u64) < self.text.file_bytes {
            lines.truncate(memchr::memrchr(b'\n', &lines).map_or(0, |end| end + 1));
        }
        let start = memchr::memchr(b'\n', &lines).map_or(lines.len(), |end| end + 1);
        lines.drain(..start);
        Ok(lines)
    }

    /// Returns the start of the file: at least `at_least` bytes, and at least one line that is no comment, if the file is
    /// long enough.
    pub fn head(&mut self, at_least: usize) -> Result<Vec<u8>, FileError> {
        let mut head = Vec::new();
        let mut is_comment_only = true;
        while (head.len() < at_least || is_comment_only)
            && let Some(mut block) = self.next()?
        {
            is_comment_only &= lines(&block).all(is_skipped);
            head.append(&mut block);
        }
        Ok(head)
    }

    /// Returns the next block of whole lines, or `None` at the end of the file. Only the last line of the file may lack its
    /// line end.
    pub fn next(&mut self) -> Result<Option<Vec<u8>>, FileError> {
        let mut block = Vec::with_capacity(self.carry.len() + self.block_bytes);
        block.append(&mut self.carry);
        while !self.is_at_end {
            let before = block.len();
            let has_more = self.text.read_into(&mut block, self.block_bytes)?;
            self.is_at_end = !has_more;
            if let Some(end) = memchr::memrchr(b'\n', &block[before..]) {
                self.carry = block.split_off(before + end + 1);
                break;
            }
            if block.len() > LINE_LIMIT_BYTES {
                return Err(FileError::LineTooLong { limit_bytes: LINE_LIMIT_BYTES });
            }
        }
        // If only a part of the file is read, this part may end in the middle of a line, which is dropped.
        if self.is_at_end && self.text.is_sample() {
            self.carry.clear();
            block.truncate(memchr::memrchr(b'\n', &block).map_or(0, |end| end + 1));
        }
        Ok((!block.is_empty()).then_some(block))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(content: &[u8]) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), content).unwrap();
        file
    }

    #[test]
    fn blocks_joined_are_the_file_and_end_at_line_ends() {
        let text = b"\xef\xbb\xbft,S1\n0,1\r\n\n1,2222222222222222222222222\n2,3";
        let file = file(text);
        for block_bytes in 1..=text.len() + 1 {
            let mut blocks = Blocks::open(file.path(), block_bytes, None).unwrap();
            let mut joined: Vec<u8> = Vec::new();
            while let Some(block) = blocks.next().unwrap() {
                joined.extend(&block);
                assert!(block.ends_with(b"\n") || joined.len() == text.len() - 3);
            }
            assert_eq!(joined, text[3..], "{block_bytes} bytes");
        }
    }

    #[test]
    fn a_sample_ends_with_a_whole_line() {
        let file = file(b"t,S1\n0,1\n1,2\n");
        for (limit, expected) in
            [(3, ""), (7, "t,S1\n"), (9, "t,S1\n0,1\n"), (13, "t,S1\n0,1\n1,2\n")]
        {
            for block_bytes in 1..15 {
                let mut blocks = Blocks::open(file.path(), block_bytes, Some(limit)).unwrap();
                let head = blocks.head(usize::MAX).unwrap();
                assert_eq!(String::from_utf8(head).unwrap(), expected, "{block_bytes}");
            }
        }
    }

    #[test]
    fn an_endless_line_is_refused() {
        let file = file(&vec![b'x'; LINE_LIMIT_BYTES + 2]);
        let mut blocks = Blocks::open(file.path(), 1 << 20, None).unwrap();
        assert!(matches!(blocks.next(), Err(FileError::LineTooLong { .. })));
    }
}
