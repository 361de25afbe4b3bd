//! Tables of loads and errors over time as Apache Parquet. Cells without a number are null.

use std::io;

use super::table::{BeginTraces, TraceTable};
use crate::{export::format::FileFormat, formats::parquet::ParquetTable};

pub(super) const FORMAT: FileFormat<BeginTraces> = FileFormat {
    name: "Apache Parquet",
    ending: "parquet",
    holds: "every number",
    write: |head, out| Ok(Box::new(ParquetTable::new(head, out)?)),
};

impl TraceTable for ParquetTable<'_> {
    fn row(&mut self, recording: &str, row: &[Option<f64>]) -> io::Result<()> {
        self.push(recording, row)
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        (*self).finish()
    }
}
