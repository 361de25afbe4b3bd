//! What a table of traces is to whoever fills it.

use std::io;

/// A table of traces that is being written.
pub trait TraceTable {
    /// Writes a row: the recording, and the numbers that are there.
    ///
    /// # Errors
    /// Whatever the file fails with.
    fn row(&mut self, recording: &str, row: &[Option<f64>]) -> io::Result<()>;

    /// Writes what is still to be written.
    ///
    /// # Errors
    /// Whatever the file fails with.
    fn finish(self: Box<Self>) -> io::Result<()>;
}

/// Begins a table whose first column is of recordings, and whose others are of numbers with these heads.
pub type BeginTraces =
    for<'o> fn(&[String], &'o mut dyn io::Write) -> io::Result<Box<dyn TraceTable + 'o>>;
