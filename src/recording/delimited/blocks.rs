//! A file in blocks that end at line ends, so that each can be parsed on its own.
//!
//! Guarantees: the blocks joined are the file without its byte order mark; no block splits a line.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::ReadError;

/// How much of a file is looked at to tell whether it is text.
const HEAD_BYTES: usize = 8 << 10;
/// A longer line is no row of a table; without a limit one would fill the memory.
const LINE_LIMIT_BYTES: usize = 4 << 20;
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Reads a file block by block.
#[derive(Debug)]
pub(super) struct Blocks {
    path: PathBuf,
    file: File,
    file_bytes: u64,
    block_bytes: usize,
    /// The start of a line whose end is not read yet.
    carry: Vec<u8>,
    is_at_end: bool,
}

impl Blocks {
    /// Opens a file and makes sure that it is text.
    pub(super) fn open(path: &Path, block_bytes: usize) -> Result<Self, ReadError> {
        let io_error = |source| ReadError::Io {
            path: path.to_owned(),
            source,
        };
        // Asked before opening: opening a named pipe would wait for its other end.
        let metadata = std::fs::metadata(path).map_err(io_error)?;
        if !metadata.is_file() {
            return Err(ReadError::NotAFile {
                path: path.to_owned(),
            });
        }
        let mut file = File::open(path).map_err(io_error)?;
        let mut head = Vec::with_capacity(HEAD_BYTES);
        (&mut file)
            .take(HEAD_BYTES as u64)
            .read_to_end(&mut head)
            .map_err(io_error)?;
        if head.is_empty() {
            return Err(ReadError::Empty {
                path: path.to_owned(),
            });
        }
        if let Some(what) = not_text(&head) {
            return Err(ReadError::NotText {
                path: path.to_owned(),
                what,
            });
        }
        let text_starts_at = if head.starts_with(BYTE_ORDER_MARK) {
            BYTE_ORDER_MARK.len() as u64
        } else {
            0
        };
        file.seek(SeekFrom::Start(text_starts_at))
            .map_err(io_error)?;
        Ok(Self {
            path: path.to_owned(),
            file,
            file_bytes: metadata.len(),
            block_bytes,
            carry: Vec::new(),
            is_at_end: false,
        })
    }

    /// How long the file was when it was opened.
    pub(super) fn file_bytes(&self) -> u64 {
        self.file_bytes
    }

    /// The next block: whole lines, of which only the file's last may lack its end. `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<Vec<u8>>, ReadError> {
        let mut block = Vec::with_capacity(self.carry.len() + self.block_bytes);
        block.append(&mut self.carry);
        while !self.is_at_end {
            let before = block.len();
            self.read_into(&mut block).map_err(|source| ReadError::Io {
                path: self.path.clone(),
                source,
            })?;
            if let Some(end) = memchr::memrchr(b'\n', &block[before..]) {
                self.carry = block.split_off(before + end + 1);
                break;
            }
            if block.len() > LINE_LIMIT_BYTES {
                return Err(ReadError::LineTooLong {
                    path: self.path.clone(),
                    limit_bytes: LINE_LIMIT_BYTES,
                });
            }
        }
        Ok((!block.is_empty()).then_some(block))
    }

    fn read_into(&mut self, block: &mut Vec<u8>) -> io::Result<()> {
        let wanted = self.block_bytes as u64;
        let got = (&mut self.file).take(wanted).read_to_end(block)?;
        self.is_at_end = (got as u64) < wanted;
        Ok(())
    }
}

/// What a file that starts so is, if it is not UTF-8 text.
fn not_text(head: &[u8]) -> Option<&'static str> {
    const SIGNATURES: [(&[u8], &str); 7] = [
        (b"\xff\xfe", "UTF-16 text"),
        (b"\xfe\xff", "UTF-16 text"),
        (b"\x1f\x8b", "a gzip archive"),
        (b"PK\x03\x04", "a zip archive or a spreadsheet"),
        (b"PAR1", "a Parquet file"),
        (b"\x89HDF", "an HDF5 file"),
        (b"\xd0\xcf\x11\xe0", "a spreadsheet of an old kind"),
    ];
    SIGNATURES
        .iter()
        .find(|(start, _)| head.starts_with(start))
        .map(|&(_, what)| what)
        .or_else(|| head.contains(&0).then_some("binary data"))
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
            let mut blocks = Blocks::open(file.path(), block_bytes).unwrap();
            let mut joined: Vec<u8> = Vec::new();
            while let Some(block) = blocks.next().unwrap() {
                joined.extend(&block);
                assert!(block.ends_with(b"\n") || joined.len() == text.len() - 3);
            }
            assert_eq!(joined, text[3..], "{block_bytes} bytes");
        }
    }

    #[test]
    fn what_is_not_text_is_named() {
        for (content, what) in [
            (&b"\xff\xfet\0,\0"[..], "UTF-16 text"),
            (b"\x1f\x8b\x08rest", "a gzip archive"),
            (b"PK\x03\x04rest", "a zip archive or a spreadsheet"),
            (b"PAR1rest", "a Parquet file"),
            (b"t,S1\n0,\0", "binary data"),
        ] {
            let error = Blocks::open(file(content).path(), 100).unwrap_err();
            assert!(matches!(error, ReadError::NotText { what: told, .. } if told == what));
        }
    }

    #[test]
    fn an_endless_line_is_refused() {
        let file = file(&vec![b'x'; LINE_LIMIT_BYTES + 2]);
        let mut blocks = Blocks::open(file.path(), 1 << 20).unwrap();
        assert!(matches!(blocks.next(), Err(ReadError::LineTooLong { .. })));
    }
}
