//! What a format is, and what is known of a file before its format reads it.

use std::fs::File;
use std::io;
use std::path::Path;

use super::columns::Columns;
use super::error::FileError;
use crate::progress::Progress;

/// More columns are no table of a sensor.
pub(super) const COLUMN_LIMIT: usize = 4096;
/// Number of bytes that any file may unpack to.
const UNPACKED_BYTES: u64 = 1 << 30;
/// Beyond [`UNPACKED_BYTES`], the maximum ratio of unpacked to packed bytes: measured numbers pack far less.
const UNPACKED_RATIO: u64 = 100;

/// One kind of file.
#[derive(Debug)]
pub struct Format {
    /// What people call such a file.
    pub name: &'static str,
    /// What the names of such files end with, without the point.
    pub endings: &'static [&'static str],
    /// What such files start with; what starts like none of them is text.
    pub(super) signatures: &'static [&'static [u8]],
    /// What such a file holds; `None` if it is something else after all.
    pub(super) read: fn(&Source<'_>) -> Result<Option<Columns>, FileError>,
}

/// A file whose format is known, before it is read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub path: &'a Path,
    /// How it starts.
    pub head: &'a [u8],
    pub n_bytes: u64,
    /// Which of several parts of it make the table; none where nobody said.
    pub parts: &'a [String],
    pub progress: &'a Progress,
}

impl Source<'_> {
    pub fn open(&self) -> io::Result<File> {
        File::open(self.path)
    }
}

/// Memory that may still be taken for what a file holds.
#[derive(Debug)]
pub(super) struct Budget {
    left_bytes: u64,
    limit_bytes: u64,
}

impl Budget {
    /// Returns the budget of a whole file with this length.
    pub fn of_file(n_bytes: u64) -> Self {
        let limit_bytes = unpacked_limit(n_bytes);
        Self { left_bytes: limit_bytes, limit_bytes }
    }

    /// Takes the memory of a number of values of `what`, to be asked before the memory is allocated.
    ///
    /// # Errors
    /// [`FileError::UnpacksTooLarge`] if less is left.
    pub fn take(&mut self, what: &str, n_values: u64, bytes_each: u64) -> Result<(), FileError> {
        let left_bytes = n_values
            .checked_mul(bytes_each)
            .and_then(|n_bytes| self.left_bytes.checked_sub(n_bytes));
        let too_large = || FileError::unpacks_too_large(what, self.limit_bytes);
        self.left_bytes = left_bytes.ok_or_else(too_large)?;
        Ok(())
    }
}

/// Returns the maximum number of bytes that packed ones of this number may unpack to.
pub(super) fn unpacked_limit(packed_bytes: u64) -> u64 {
    packed_bytes.saturating_mul(UNPACKED_RATIO).max(UNPACKED_BYTES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_for_all_that_a_file_holds() {
        let mut budget = Budget::of_file(0);
        let half = UNPACKED_BYTES / 16;
        budget.take("a", half, 8).unwrap();
        assert!(budget.take("b", half + 1, 8).is_err());
        assert!(budget.take("b", u64::MAX, 8).is_err());
        budget.take("b", half, 8).unwrap();
        assert!(budget.take("c", 1, 1).is_err());
    }
}
