//! Tables of loads and errors over time as delimited text.

use std::io;

use super::table::{BeginTraces, TraceTable};
use crate::{export::format::FileFormat, formats::csv::CsvWriter};

pub(super) const FORMAT: FileFormat<BeginTraces> = FileFormat {
    name: "Delimited text",
    ending: "csv",
    holds: "every number",
    write: |head, out| {
        let mut csv = CsvWriter::new(out);
        csv.cell("recording")?;
        csv.row(head)?;
        Ok(Box::new(csv))
    },
};

impl<W: io::Write> TraceTable for CsvWriter<W> {
    fn row(&mut self, recording: &str, row: &[Option<f64>]) -> io::Result<()> {
        self.cell(recording)?;
        write_cells(self, row)?;
        self.end_row()
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.flush()
    }
}

pub(super) fn write_cells<W: io::Write>(
    csv: &mut CsvWriter<W>,
    row: &[Option<f64>],
) -> io::Result<()> {
    row.iter()
        .map(|number| number.map_or_else(String::new, |x| x.to_string()))
        .try_for_each(|cell| csv.cell(cell))
}
