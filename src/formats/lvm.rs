//! LabVIEW's measurement files (`.lvm`): a header for the file, then one for each segment of samples, and text below it.
//!
//! **Source** Specification for the LabVIEW Measurement File (.lvm), National Instruments. The header names the delimiter and
//! the decimal sign; `X_Columns` says whether the time stands in a column (`One`), in one for each channel (`Multi`), or
//! follows from `X0` and `Delta_X` (`No`).

use std::io::Read as _;

use super::columns::{Column, Columns};
use super::error::FileError;
use super::format::{COLUMN_LIMIT, Format, Source};
use super::text::times::TimeForm;
use crate::recording::Day;

pub(super) const FORMAT: Format = Format {
    name: "LabVIEW measurement",
    endings: &["lvm"],
    signatures: &[b"LabVIEW Measurement", b"\xef\xbb\xbfLabVIEW Measurement"],
    read: columns,
};

const END_OF_HEADER: &str = "***End_of_Header***";
const TIME: &str = "time";

/// Where the times of a file stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Times {
    Counted,
    OneColumn,
    ColumnEach,
}

/// What the header of a segment says of its channels, and of its start.
#[derive(Clone, Debug, Default)]
struct Segment {
    day: Option<Day>,
    start_secs: Option<f64>,
    x0: f64,
    delta_x: f64,
    units: Vec<String>,
}

/// All segments of a file as one table; where the next one starts earlier, time goes back there.
fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    let mut bytes = Vec::new();
    source.open()?.read_to_end(&mut bytes)?;
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => error.into_bytes().iter().map(|&byte| char::from(byte)).collect(),
    };
    let mut lines = text.lines().map(|line| line.trim_end_matches('\r'));
    let mut header = Header::default();
    let ends = lines.by_ref().any(|line| {
        header.take(line);
        line.starts_with(END_OF_HEADER)
    });
    if !ends {
        return Err(FileError::cut_short("the header"));
    }
    let mut table = Table::new(&header);
    let mut is_special = false;
    for (number, line) in lines.enumerate() {
        if number % 4096 == 0 {
            source.progress.check()?;
        }
        match line.trim() {
            "***Start_Special***" => is_special = true,
            "***End_Special***" => is_special = false,
            _ if !is_special => table.line(line),
            _ => {}
        }
    }
    Ok(Some(table.columns()))
}

/// What the header of the file says about all of it.
#[derive(Clone, Debug)]
struct Header {
    day: Option<Day>,
    separator: char,
    decimal: char,
    times: Times,
}

impl Default for Header {
    fn default() -> Self {
        Self { day: None, separator: '\t', decimal: '.', times: Times::OneColumn }
    }
}

impl Header {
    fn take(&mut self, line: &str) {
        let Some((key, value)) = line.split_once(['\t', ',', ';']) else {
            return;
        };
        // A comma may be the value.
        match (key.trim(), value.trim()) {
            ("Date", value) => self.day = Day::in_text(value),
            ("Separator", value) if value.starts_with("Comma") => self.separator = ',',
            ("Separator", value) if value.starts_with("Semicolon") => self.separator = ';',
            ("Decimal_Separator", value) => {
                self.decimal = if value.starts_with(',') { ',' } else { '.' };
            }
            ("X_Columns", value) if value.starts_with("No") => self.times = Times::Counted,
            ("X_Columns", value) if value.starts_with("Multi") => self.times = Times::ColumnEach,
            _ => {}
        }
    }

    fn number(&self, cell: &str) -> Option<f64> {
        let cell = cell.trim();
        match self.decimal {
            ',' => cell.replace(',', ".").parse().ok(),
            _ => cell.parse().ok(),
        }
    }
}

/// The samples so far.
struct Table<'a> {
    header: &'a Header,
    segment: Segment,
    first_start_secs: Option<f64>,
    /// The day on which the first segment starts.
    first_day: Option<Day>,
    /// Whether rows of samples are expected, below a line of names.
    in_rows: bool,
    /// Where each channel stands, and where its time does.
    places: Vec<(usize, Option<usize>)>,
    channels: Vec<Column>,
    times: Vec<f64>,
    n_in_segment: usize,
    has_other_clocks: bool,
    has_comments: bool,
    comment_at: Option<usize>,
}

impl<'a> Table<'a> {
    fn new(header: &'a Header) -> Self {
        Self {
            header,
            segment: Segment::default(),
            first_start_secs: None,
            first_day: None,
            in_rows: false,
            places: Vec::new(),
            channels: Vec::new(),
            times: Vec::new(),
            n_in_segment: 0,
            has_other_clocks: false,
            has_comments: false,
            comment_at: None,
        }
    }

    fn line(&mut self, line: &str) {
        let cells: Vec<&str> = line.split(self.header.separator).collect();
        let key = cells[0].trim();
        if key == "X_Value" || (cells.len() > 1 && cells[1].trim() == "X_Value") {
            self.names(&cells);
        } else if key == "Channels" || key == END_OF_HEADER {
            if key == "Channels" {
                self.segment = Segment::default();
            }
            self.in_rows = false;
        } else if self.in_rows {
            self.row(&cells);
        } else {
            self.segment_header(key, &cells[1..]);
        }
    }

    fn segment_header(&mut self, key: &str, values: &[&str]) {
        let first = || values.first().map_or("", |value| value.trim());
        let number = |default: f64| self.header.number(first()).unwrap_or(default);
        match key {
            "X0" => self.segment.x0 = number(0.0),
            "Delta_X" => self.segment.delta_x = number(1.0),
            "Y_Unit_Label" => {
                let units = values.iter().map(|unit| unit.trim().to_owned());
                self.segment.units = units.collect();
            }
            "Date" => {
                self.segment.start_secs = secs(first());
                self.segment.day = Day::in_text(first());
            }
            "Time" => {
                let time = first().replace(',', ".");
                let secs = secs(&time).zip(self.segment.start_secs);
                self.segment.start_secs = secs.map(|(time, day)| day + time);
            }
            _ => {}
        }
    }

    /// The line of names, below which the rows stand.
    fn names(&mut self, cells: &[&str]) {
        self.in_rows = true;
        self.n_in_segment = 0;
        self.first_start_secs = self.first_start_secs.or(self.segment.start_secs);
        self.first_day = self.first_day.or(self.segment.day);
        self.places.clear();
        self.comment_at = None;
        let mut time_at = None;
        let mut names = Vec::new();
        for (at, cell) in cells.iter().enumerate() {
            match cell.trim() {
                "X_Value" => time_at = Some(at),
                "Comment" => self.comment_at = Some(at),
                "" if at + 1 == cells.len() => {}
                name if self.places.len() < COLUMN_LIMIT => {
                    self.places.push((at, time_at));
                    names.push(name.to_owned());
                }
                _ => {}
            }
        }
        let n_rows = self.times.len();
        for (at, name) in names.into_iter().enumerate() {
            if at == self.channels.len() {
                self.channels.push(Column {
                    name,
                    unit: self.segment.units.get(at).cloned().unwrap_or_default(),
                    values: vec![f64::NAN; n_rows],
                    ..Column::default()
                });
            }
        }
    }

    fn row(&mut self, cells: &[&str]) {
        let number = |at: usize| cells.get(at).and_then(|cell| self.header.number(cell));
        let is_empty = |at: &usize| cells.get(*at).is_none_or(|cell| cell.trim().is_empty());
        if self.places.iter().all(|(at, _)| is_empty(at)) {
            // A blank line ends the segment.
            return;
        }
        self.has_comments |= self.comment_at.is_some_and(|at| !is_empty(&at));
        let in_column = self.places.first().and_then(|(_, at)| number((*at)?));
        let counted = self.segment.x0 + self.n_in_segment as f64 * self.segment.delta_x;
        let time = match self.header.times {
            Times::Counted => counted,
            Times::OneColumn | Times::ColumnEach => in_column.unwrap_or(f64::NAN),
        };
        if self.header.times == Times::ColumnEach {
            let others = self.places.iter().filter_map(|(_, at)| number((*at)?));
            self.has_other_clocks |= others.into_iter().any(|other| other != time);
        }
        let since_first = self.segment.start_secs.zip(self.first_start_secs);
        self.times.push(time + since_first.map_or(0.0, |(start, first)| start - first));
        for (at, channel) in self.channels.iter_mut().enumerate() {
            let value = self.places.get(at).and_then(|(at, _)| number(*at));
            channel.values.push(value.unwrap_or(f64::NAN));
        }
        self.n_in_segment += 1;
    }

    fn columns(self) -> Columns {
        let time = Column {
            name: TIME.to_owned(),
            unit: "s".to_owned(),
            values: self.times,
            ..Column::default()
        };
        let mut left_out = Vec::new();
        if self.has_comments {
            left_out.push("Comment (text)".to_owned());
        }
        if self.has_other_clocks {
            left_out
                .push("X_Value of the other channels (taken to be that of the first)".to_owned());
        }
        Columns {
            columns: [time].into_iter().chain(self.channels).collect(),
            is_named: true,
            day: self.first_day.or(self.header.day),
            left_out,
            ..Columns::default()
        }
    }
}

/// A date or a time of day in seconds.
fn secs(text: &str) -> Option<f64> {
    let form = TimeForm::of_all([text.as_bytes()].into_iter())?;
    form.secs(text.as_bytes())
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
    fn the_header_says_where_the_times_are() {
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
    fn a_segment_starts_when_its_header_says() {
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
