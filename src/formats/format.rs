//! Description of a file format, and of a file before its format reads it.

use std::fs::File;
use std::io;
use std::path::Path;

use super::columns::Columns;
use super::error::FileError;
use crate::progress::Progress;

/// Maximum number of columns of a table; a sensor has far fewer.
pub(super) const COLUMN_LIMIT: usize = 4096;
/// Unpacked size that any file may have (bytes).
const UNPACKED_BYTES: u64 = 1 << 30;
/// Maximum ratio of unpacked to packed bytes above [`UNPACKED_BYTES`]. Measured numbers pack far less.
const UNPACKED_RATIO: u64 = 100;

/// File format that can be read.
#[derive(Debug)]
pub struct Format {
    pub name: &'static str,
    /// Extensions of file names, without the point.
    pub endings: &'static [&'static str],
    /// First bytes of a file of this format. A file that matches no format is text.
    pub(super) signatures: &'static [&'static [u8]],
    /// Reads a file; returns `None` if it is of another format after all.
    pub(super) read: fn(&Source<'_>) -> Result<Option<Columns>, FileError>,
}

/// File whose format is known and that is not read yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub path: &'a Path,
    pub head: &'a [u8],
    pub n_bytes: u64,
    /// Names of the tables that the user chose; empty for an automatic choice.
    pub parts: &'a [String],
    pub progress: &'a Progress,
}

impl Source<'_> {
    pub fn open(&self) -> io::Result<File> {
        File::open(self.path)
    }
}

/// Memory limit for the contents of a file.
#[derive(Debug)]
pub(super) struct Budget {
    left_bytes: u64,
    limit_bytes: u64,
}

impl Budget {
    pub fn of_file(n_bytes: u64) -> Self {
        let limit_bytes = unpacked_limit(n_bytes);
        Self { left_bytes: limit_bytes, limit_bytes }
    }

    /// Takes memory for `n_values` values of `what` from the budget before it is allocated. The error is
    /// [`FileError::UnpacksTooLarge`].
    pub fn take(&mut self, what: &str, n_values: u64, bytes_each: u64) -> Result<(), FileError> {
        let left_bytes = n_values
            .checked_mul(bytes_each)
            .and_then(|n_bytes| self.left_bytes.checked_sub(n_bytes));
        let too_large = || FileError::unpacks_too_large(what, self.limit_bytes);
        self.left_bytes = left_bytes.ok_or_else(too_large)?;
        Ok(())
    }
}

pub(super) fn unpacked_limit(packed_bytes: u64) -> u64 {
    packed_bytes.saturating_mul(UNPACKED_RATIO).max(UNPACKED_BYTES)
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
