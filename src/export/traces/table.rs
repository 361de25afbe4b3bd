//! Interface of a table of traces.

use std::io;

pub trait TraceTable {
    /// Writes a row; `None` for a missing number.
    fn row(&mut self, recording: &str, row: &[Option<f64>]) -> io::Result<()>;

    fn finish(self: Box<Self>) -> io::Result<()>;
}

/// Function that begins a table. The first column holds names of recordings; the columns with these headers hold numbers.
pub type BeginTraces =
    for<'o> fn(&[String], &'o mut (dyn io::Write + Send)) -> io::Result<Box<dyn TraceTable + 'o>>;
