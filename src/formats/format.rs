//! Description of a file format, and of a file whose format is known but that is not yet read.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use super::{columns::Columns, error::FileError};
use crate::progress::Progress;

/// Maximum number of columns of a table, so that a damaged file cannot fill the memory. A sensor has far fewer columns.
pub const COLUMN_LIMIT: usize = 4096;
/// Unpacked size that is always allowed, however small the packed file is (bytes).
const UNPACKED_BYTES: u64 = 1 << 30;
/// Maximum ratio of unpacked to packed size of a file that unpacks to more than [`UNPACKED_BYTES`]. Files of measured numbers
/// have a far smaller ratio.
const UNPACKED_RATIO: u64 = 100;

/// File format that the program can read.
#[derive(Debug)]
pub struct Format {
    pub name: &'static str,
    /// Extensions of files in this format, without the point.
    pub endings: &'static [&'static str],
    /// Byte strings, with one of which a file of this format begins. A file that matches no format is text.
    pub signatures: &'static [&'static [u8]],
    /// Reads a file; returns `None` if the file has another format although its first bytes match.
    pub read: fn(&Source<'_>) -> Result<Option<Columns>, FileError>,
}

/// File whose format is known, before it is read.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    pub path: &'a Path,
    pub head: &'a [u8],
    pub n_bytes: u64,
    /// Names of the tables of the file that the user chose; empty if the program chooses.
    pub parts: &'a [String],
    pub progress: &'a Progress,
}

impl Source<'_> {
    pub fn open(&self) -> io::Result<SourceFile> {
        let progress = self.progress.clone();
        Ok(SourceFile { file: File::open(self.path)?, progress, n_empty_reads: 0 })
    }
}

/// File from which the reader of a format reads. Each read fails after the work was cancelled. At the end of the file, reads
/// fail after [`EMPTY_READS`] reads without a byte, because a reader of a damaged file may otherwise read there for ever.
#[derive(Debug)]
pub struct SourceFile {
    file: File,
    progress: Progress,
    n_empty_reads: u32,
}

/// Number of reads without a byte at the end of a file that are no error. A reader of a sound file needs few of them.
const EMPTY_READS: u32 = 1000;

#[cfg(feature = "parquet")]
impl SourceFile {
    pub fn n_bytes(&self) -> io::Result<u64> {
        Ok(self.file.metadata()?.len())
    }

    /// Opens the file again for reading from byte `start` on. Both share their position in the file.
    pub fn at(&self, start: u64) -> io::Result<Self> {
        let (file, progress) = (self.file.try_clone()?, self.progress.clone());
        let mut file = Self { file, progress, n_empty_reads: 0 };
        file.seek(SeekFrom::Start(start))?;
        Ok(file)
    }
}

impl Read for SourceFile {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.progress.check().map_err(io::Error::other)?;
        let n_read = self.file.read(bytes)?;
        self.n_empty_reads = if n_read > 0 { 0 } else { self.n_empty_reads + 1 };
        if self.n_empty_reads > EMPTY_READS {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(n_read)
    }
}

impl Seek for SourceFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Limit of the memory that the contents of one file may take, and what is left of it (bytes).
#[derive(Debug)]
pub struct Budget {
    left_bytes: u64,
    pub limit_bytes: u64,
}

impl Budget {
    pub fn of_file(n_bytes: u64) -> Self {
        let limit_bytes = n_bytes.saturating_mul(UNPACKED_RATIO).max(UNPACKED_BYTES);
        Self { left_bytes: limit_bytes, limit_bytes }
    }

    /// Takes the memory for `n_values` values out of the budget, before the memory is allocated. `what` names the part of the
    /// file for the error [`FileError::UnpacksTooLarge`].
    pub fn take(&mut self, what: &str, n_values: u64, bytes_each: u64) -> Result<(), FileError> {
        let n_bytes = n_values.saturating_mul(bytes_each);
        self.left_bytes = self.left_bytes.checked_sub(n_bytes).ok_or_else(|| {
            FileError::UnpacksTooLarge { what: what.to_owned(), limit_bytes: self.limit_bytes }
        })?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_parts_of_a_file_share_one_budget() {
        let mut budget = Budget::of_file(0);
        let half = UNPACKED_BYTES / 16;
        budget.take("a", half, 8).unwrap();
        assert!(budget.take("b", half + 1, 8).is_err());
        assert!(budget.take("b", u64::MAX, 8).is_err());
        budget.take("b", half, 8).unwrap();
        assert!(budget.take("c", 1, 1).is_err());
    }
}
