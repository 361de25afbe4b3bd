//! LabVIEW's measurement files (`.lvm`): text with a header for the file, and a header for each segment of rows.
//!
//! **Source** Specification for the LabVIEW Measurement File (.lvm), National Instruments. The header gives the delimiter and
//! the decimal mark. Its key `X_Columns` is `One` for one time column, `Multi` for a time column per channel, and `No` if the
//! times follow from the start `X0` and the step `Delta_X`.

use super::{
    blocks::Blocks,
    cells::{Cells, decimal_comma_number, lines, number},
    layout::names,
    times::TimeForm,
    written::Delimiter,
};
use crate::formats::{
    columns::{Column, Columns},
    error::FileError,
    format::{COLUMN_LIMIT, Format, Source},
};

pub const FORMAT: Format = Format {
    name: "LabVIEW measurement",
    endings: &["lvm"],
    signatures: &[b"LabVIEW Measurement", b"\xef\xbb\xbfLabVIEW Measurement"],
    read: columns,
};

const BLOCK_BYTES: usize = 1 << 18;

/// Reads all segments of a file as one table. The times of the table go back where a segment starts before the end of the
/// previous segment.
fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    let mut blocks = Blocks::open(source.path, BLOCK_BYTES, None)?;
    let mut table = Table { delimiter: Delimiter::Tab, ..Table::default() };
    while let Some(block) = blocks.next()? {
        source.progress.check()?;
        lines(&block).for_each(|line| table.line(line));
    }
    if table.is_begun { Ok(Some(table.columns())) } else { Err(FileError::cut_short("the header")) }
}

#[derive(Debug, Default)]
struct Segment {
    start_secs: Option<f64>,
    x0: f64,
    delta_x: f64,
    units: Vec<String>,
    n_rows: usize,
}

#[derive(Debug, Default)]
struct Table {
    delimiter: Delimiter,
    has_decimal_comma: bool,
    /// True if the times are not written but follow from the row numbers.
    is_counted: bool,
    is_begun: bool,
    is_special: bool,
    /// True after a line of column names, where rows of samples are expected.
    in_rows: bool,
    segment: Segment,
    /// Start time of the first segment (s).
    start_secs: Option<f64>,
    /// Index of each channel's cell in a row, and of the cell with its time if the channel has a time column.
    places: Vec<(usize, Option<usize>)>,
    comment_at: Option<usize>,
    channels: Vec<Column>,
    times: Vec<f64>,
    has_other_clocks: bool,
    has_comments: bool,
}

impl Table {
    fn line(&mut self, line: &[u8]) {
        // In the first header, the first tab, comma or semicolon in a line is the delimiter. A later one may be a value, such
        // as the decimal comma.
        let delimiter = match line.iter().find(|byte| b"\t,;".contains(byte)) {
            _ if self.is_begun => self.delimiter,
            Some(b',') => Delimiter::Comma,
            Some(b';') => Delimiter::Semicolon,
            _ => Delimiter::Tab,
        };
        let cells: Vec<&[u8]> = Cells::new(line, delimiter).collect();
        match cells[0] {
            b"***Start_Special***" => self.is_special = true,
            b"***End_Special***" => self.is_special = false,
            _ if self.is_special => {}
            b"***End_of_Header***" => {
                if !self.is_begun {
                    self.segment = Segment::default();
                }
                (self.is_begun, self.in_rows) = (true, false);
            }
            b"Channels" => (self.segment, self.in_rows) = (Segment::default(), false),
            _ if cells.iter().take(2).any(|cell| *cell == b"X_Value") => {
                self.names(names(line, delimiter));
            }
            _ if self.in_rows => self.row(&cells),
            b"Y_Unit_Label" => self.segment.units = names(line, delimiter).split_off(1),
            key => self.header(key, cells.get(1).copied().unwrap_or_default()),
        }
    }

    fn header(&mut self, key: &[u8], value: &[u8]) {
        let number = self.number(value);
        match key {
            b"Separator" if value == b"Comma" => self.delimiter = Delimiter::Comma,
            b"Separator" if value == b"Semicolon" => self.delimiter = Delimiter::Semicolon,
            b"Decimal_Separator" => self.has_decimal_comma = value == b",",
            b"X_Columns" => self.is_counted = value == b"No",
            b"X0" => self.segment.x0 = number.unwrap_or(0.0),
            b"Delta_X" => self.segment.delta_x = number.unwrap_or(1.0),
            b"Date" => self.segment.start_secs = secs(value),
            b"Time" => {
                self.segment.start_secs =
                    secs(value).zip(self.segment.start_secs).map(|(time, day)| day + time);
            }
            _ => {}
        }
    }

    fn number(&self, cell: &[u8]) -> Option<f64> {
        let with_comma = self.has_decimal_comma.then(|| decimal_comma_number(cell)).flatten();
        with_comma.or_else(|| number(cell))
    }

    /// Begins the rows of a segment. `names` are the column names in the line above the rows.
    fn names(&mut self, names: Vec<String>) {
        self.in_rows = true;
        self.segment.n_rows = 0;
        self.start_secs = self.start_secs.or(self.segment.start_secs);
        self.places.clear();
        self.comment_at = None;
        let mut time_at = None;
        for (at, name) in names.into_iter().enumerate() {
            match &*name {
                "X_Value" => time_at = Some(at),
                "Comment" => self.comment_at = Some(at),
                _ if self.places.len() < COLUMN_LIMIT => {
                    let channel = self.places.len();
                    self.places.push((at, time_at));
                    if channel == self.channels.len() {
                        self.channels.push(Column {
                            name,
                            unit: self.segment.units.get(channel).cloned().unwrap_or_default(),
                            values: vec![f64::NAN; self.times.len()],
                            ..Column::default()
                        });
                    }
                }
                _ => {}
            }
        }
    }

    fn row(&mut self, cells: &[&[u8]]) {
        let cell = |at: usize| cells.get(at).copied().unwrap_or_default();
        if self.places.iter().all(|(at, _)| cell(*at).is_empty()) {
            // A line without values ends the segment.
            return;
        }
        let time_at = self.places[0].1;
        let number = |at: usize| self.number(cell(at));
        let time_of = |at: Option<usize>| at.and_then(number);
        let time = if self.is_counted {
            self.segment.x0 + self.segment.n_rows as f64 * self.segment.delta_x
        } else {
            time_of(time_at).unwrap_or(f64::NAN)
        };
        let is_other =
            |at: Option<usize>| at != time_at && time_of(at).is_some_and(|other| other != time);
        let differs = !self.is_counted && self.places.iter().any(|(_, at)| is_other(*at));
        let values: Vec<f64> =
            self.places.iter().map(|(at, _)| number(*at).unwrap_or(f64::NAN)).collect();
        let since_first = self.segment.start_secs.zip(self.start_secs);
        self.times.push(time + since_first.map_or(0.0, |(start, first)| start - first));
        for (at, channel) in self.channels.iter_mut().enumerate() {
            channel.values.push(values.get(at).copied().unwrap_or(f64::NAN));
        }
        self.has_other_clocks |= differs;
        self.has_comments |= self.comment_at.is_some_and(|at| !cell(at).is_empty());
        self.segment.n_rows += 1;
    }

    fn columns(self) -> Columns {
        let time = Column {
            name: "time".to_owned(),
            unit: "s".to_owned(),
            values: self.times,
            ..Column::default()
        };
        let left_out = [
            (self.has_comments, "Comment (text)"),
            (
                self.has_other_clocks,
                "X_Value of further channels (assumed equal to the first X_Value)",
            ),
        ];
        let left_out = left_out.into_iter().filter(|(is_there, _)| *is_there);
        Columns {
            columns: [time].into_iter().chain(self.channels).collect(),
            is_named: true,
            left_out: left_out.map(|(_, what)| what.to_owned()).collect(),
            ..Columns::default()
        }
    }
}

fn secs(cell: &[u8]) -> Option<f64> {
    TimeForm::of_all([cell].into_iter())?.secs(cell)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Columns {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.lvm");
        std::fs::write(&path, text).unwrap();
        let progress = crate::progress::Progress::default();
        let source = Source {
            path: &path,
            head: text.as_bytes(),
            n_bytes: text.len() as u64,
            parts: &[],
            progress: &progress,
        };
        columns(&source).unwrap().unwrap()
    }

    #[test]
    fn the_header_gives_the_source_of_the_times() {
        let file = |x: &str| {
            format!(
                "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\t{x}\n***End_of_Header***\t\n\t\n"
            )
        };
        let segment = "Channels\t2\nY_Unit_Label\tV\tN\nX0\t1,5E+0\t1,5E+0\nDelta_X\t0,5\t0,5\n***End_of_Header***\t\t\n";
        for (kind, rows) in [
            ("No", "X_Value\tS1\tFx\tComment\n\t0,25\t-1\tstart\n\t0,5\t-2\n"),
            ("One", "X_Value\tS1\tFx\tComment\n1,5\t0,25\t-1\tstart\n2,0\t0,5\t-2\n"),
            (
                "Multi",
                "X_Value\tS1\tX_Value\tFx\tComment\n1,5\t0,25\t1,5\t-1\tx\n2,0\t0,5\t2,0\t-2\n",
            ),
        ] {
            let table = table(&format!("{}{segment}{rows}", file(kind)));
            let found: Vec<_> =
                table.columns.iter().map(|c| (&*c.name, &*c.unit, &c.values[..])).collect();
            let expected: [(&str, &str, &[f64]); 3] =
                [("time", "s", &[1.5, 2.0]), ("S1", "V", &[0.25, 0.5]), ("Fx", "N", &[-1.0, -2.0])];
            assert_eq!(found, expected, "{kind}");
            assert_eq!(table.left_out, ["Comment (text)"]);
        }
    }

    #[test]
    fn a_segment_starts_at_the_time_in_its_header() {
        let segment = |time: &str| {
            format!(
                "Channels\t1\nDate\t2024/03/05\nTime\t{time}\nX0\t0\nDelta_X\t0.5\n***End_of_Header***\nX_Value\tS1\n\t1\n\t2\n\n"
            )
        };
        let text = format!(
            "LabVIEW Measurement\nX_Columns\tNo\n***End_of_Header***\n\n{}{}",
            segment("10:00:00.25"),
            segment("10:00:01.25")
        );
        assert_eq!(table(&text).columns[0].values, [0.0, 0.5, 1.0, 1.5]);
    }
}
