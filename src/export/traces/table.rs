//! Interface for writers of tables of loads and errors over time.

use std::io;

pub trait TraceTable {
    /// Writes the row of one sample; `None` for a missing number.
    fn row(&mut self, recording: &str, row: &[Option<f64>]) -> io::Result<()>;

    fn finish(self: Box<Self>) -> io::Result<()>;
}

/// Function that begins a table. The first column holds the names of the recordings. The columns with the given headers hold
/// numbers.
pub type BeginTraces =
    for<'o> fn(&[String], &'o mut (dyn io::Write + Send)) -> io::Result<Box<dyn TraceTable + 'o>>;
