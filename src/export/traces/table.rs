//! The interface of tables of traces.

use std::io;

/// A table of traces that is being written.
pub trait TraceTable {
    /// Writes a row: the name of the recording and the numbers, `None` for a missing one.
    ///
    /// # Errors
    /// The I/O errors of the file.
    fn row(&mut self, recording: &str, row: &[Option<f64>]) -> io::Result<()>;

    /// Writes the rest of the table.
    ///
    /// # Errors
    /// The I/O errors of the file.
    fn finish(self: Box<Self>) -> io::Result<()>;
}

/// Begins a table. The first column holds names of recordings, the others hold numbers under these headers.
pub type BeginTraces =
    for<'o> fn(&[String], &'o mut dyn io::Write) -> io::Result<Box<dyn TraceTable + 'o>>;
