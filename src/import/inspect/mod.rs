//! Inspection: describes a file before it is loaded, so that the user can make a column map in the window or by hand.
//!
//! Guarantees: only the start of a large file is read. The preview uses the same code as loading, so it shows only what can
//! be loaded. A file that can be opened as text is always described.

use std::fmt;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::column_report::value_of;
pub use super::column_report::{ColumnReport, Content, Reason};
pub use super::question::Question;

use super::abandonable::abandonable;
use super::column_report::reports;
use super::load::Reading;
use super::proposal::{Mapped, mapped};
use super::question::answer;
use super::two_clocks::{self, Table};
use crate::{
    finding::Finding,
    formats::{
        Cell, FileError, FilePart, Opened, Part, Sample,
        text::{Encoding, Head, TextLayout, lines},
    },
    import::{
        clock_offset::{self, ClockOffset},
        error::{ReadError, of_file},
        join::Series,
        map::{ColumnMap, TableMap},
        warning::Cause,
    },
    min_max::MinMax,
    progress::Progress,
    recording::{Axis, Missing, Recording},
};

/// Number of bytes of a file that are read for the preview. They hold thousands of rows, and reading them takes no noticeable
/// time.
const SAMPLE_BYTES: u64 = 8 << 20;
const PREVIEW_ROWS: usize = 12;

/// Information about the inspected file that the user has already given.
#[derive(Clone, Debug, PartialEq)]
pub enum Known {
    /// No information: the layout of the text and the roles of the columns are detected.
    Nothing,
    /// Layout of the text, such as the delimiter. The roles of the columns are detected.
    Layout(TextLayout),
    /// Column map that is tried out on the file. It is not saved.
    Map(Box<ColumnMap>),
}

/// Description of a file, a column map for the file, and the result of reading the file with this map.
#[derive(Debug, Serialize)]
pub struct Inspection {
    /// Description of the file.
    pub table: TableReport,
    /// Description of the separate file with the reference. `None` if the map names no such file, or it cannot be opened.
    pub reference: Option<TableReport>,
    /// Column map that the user gave, or that the inspection proposes.
    pub map: ColumnMap,
    /// Questions that the names and values of the columns leave open.
    pub questions: Vec<Question>,
    /// Text for `--columns` that answers the questions about the load, if there are such questions.
    pub answer: Option<String>,
    /// Result of reading the file with this map.
    pub check: Check,
}

/// Description of one file.
#[derive(Debug, Serialize)]
pub struct TableReport {
    /// Path of the file.
    pub path: PathBuf,
    /// Length of the file (bytes).
    pub file_bytes: u64,
    /// Character encoding.
    pub encoding: Encoding,
    /// Name of the file format, such as a binary format; `None` for text.
    pub kind: Option<&'static str>,
    /// Division of the text into cells.
    pub text: TextLayout,
    /// Number of the line with the header, or with the first row of a table without header. `None` if the file has neither.
    pub line: Option<u64>,
    /// Estimated number of rows of the table.
    pub about_rows: u64,
    /// Names of the tables in the file. Empty if there is only one table.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<FilePart>,
    /// Columns of the table.
    pub columns: Vec<ColumnReport>,
    /// Cells of the first rows.
    pub preview: Vec<Vec<String>>,
}

impl fmt::Display for TableReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (n_bytes, n_rows) = (self.file_bytes, self.about_rows);
        match self.kind {
            Some(kind) => write!(f, "{n_bytes} bytes, a {kind}, {n_rows} rows"),
            None => {
                let encoding = self.encoding.name();
                write!(f, "{n_bytes} bytes of {encoding} text, about {n_rows} rows")
            }
        }
    }
}

/// Result of reading a file, or the start of a large file, with a column map.
#[derive(Debug, Default, Serialize)]
pub struct Check {
    /// True if only the start of the file was read.
    pub is_sample: bool,
    /// Message of the error that prevents loading, if there is one.
    pub error: Option<String>,
    /// Warnings that loading would give.
    #[serde(rename = "findings")]
    pub warnings: Vec<Finding>,
    /// Recordings that would be loaded.
    pub recordings: Vec<RecordingReport>,
    /// Names of the gauges that would be loaded.
    pub gauges: Vec<String>,
    /// Axes of the reference load that would be loaded.
    pub axes: Vec<Axis>,
    /// What a calibration still lacks.
    #[serde(skip)]
    pub missing: Option<Missing>,
    /// Shortest pause in the rows (s) that starts a new recording, if it was derived from rows in bursts because the map sets
    /// none.
    pub assumed_gap_secs: Option<f64>,
    /// Estimated offset between the clocks of gauges and reference. It is used for reading only if the user puts it into the
    /// map.
    pub clock_offset: Option<ClockOffset>,
}

/// Recording that would be loaded.
#[derive(Debug, Serialize)]
#[expect(missing_docs, reason = "the names are the documentation")]
pub struct RecordingReport {
    pub name: String,
    pub n_samples: usize,
    pub duration_secs: f64,
    pub rate_hz: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub auxiliary: Vec<String>,
}

/// Inspects a file. Returns [`ReadError`] if the file cannot be opened, is not text, or `progress` is cancelled. Any other
/// error is in [`Check::error`].
pub fn inspect(path: &Path, known: Known, progress: &Progress) -> Result<Inspection, ReadError> {
    let at = path.to_owned();
    abandonable(path, progress, move |progress| inspected(&at, known, progress))
}

fn inspected(path: &Path, known: Known, progress: &Progress) -> Result<Inspection, ReadError> {
    let reading = Reading::start(progress, SAMPLE_BYTES);
    let (given, layout) = match &known {
        Known::Map(map) => (Some(&**map), None),
        Known::Layout(text) => (None, Some(text)),
        Known::Nothing => (None, None),
    };
    let text = given.map(|map| &map.table.text).or(layout);
    let opened = reading.open(path, text.map_or(&[][..], |text| &text.parts))?;
    // With a given map or layout, the user accepts that rows are skipped.
    let may_skip_rows = known != Known::Nothing;
    let found = mapped(path, &opened, given, layout);
    let (Mapped { mut map, columns, mut questions, notes, .. }, error) = match found {
        Ok(found) => (found, None),
        Err(ReadError::Cancelled) => return Err(ReadError::Cancelled),
        Err(error) => {
            (Mapped { map: given.cloned().unwrap_or_default(), ..Mapped::default() }, Some(error))
        }
    };
    if let (None, Some(text)) = (given, layout.cloned().or_else(|| opened.layout())) {
        map.table.text = text;
    }
    let reference = map.reference.as_ref().and_then(|file| {
        let path = two_clocks::reference_path(path, file);
        let opened = reading.open(&path, &file.table.text.parts).ok()?;
        Some(report(&path, &opened, &file.table, None))
    });
    let mut table = report(path, &opened, &map.table, error.is_none().then_some(columns));
    let is_sample = opened.read_bytes < table.file_bytes;
    if let (false, Some(head)) = (is_sample, opened.head(&map.table.text)) {
        progress.add_total(opened.read_bytes);
        whole_ranges(opened, &head, &map.table.text, &mut table.columns, progress)
            .map_err(of_file(path))?;
    }
    let check = match error {
        Some(error) => Check { is_sample, error: Some(error.to_string()), ..Check::default() },
        None => check(path, &reading, &map, notes, [is_sample, may_skip_rows])?,
    };
    // A signal without a load opens as it is; its jobs say that they need a load.
    let missing = check.missing.filter(|missing| *missing == Missing::Gauges);
    // A log of loads alone opens without a question that none of its columns can answer.
    let asked = Question::about_missing(missing, &questions, &table.columns);
    questions.extend(asked.filter(|asked| !asked.columns.is_empty()));
    let answer = answer(&questions, &table.columns);
    Ok(Inspection { table, reference, map, questions, answer, check })
}

/// Returns the first of several column maps that fits the file.
pub(super) fn map_for<'a>(
    path: &Path,
    maps: &'a [ColumnMap],
    progress: &Progress,
) -> Result<Option<&'a ColumnMap>, ReadError> {
    let reading = Reading::start(progress, SAMPLE_BYTES);
    let opened = reading.open(path, &[])?;
    let is_for_it = |map: &&ColumnMap| match map.table.text.parts.as_slice() {
        [] => is_for(&opened, &map.table),
        parts => reading.open(path, parts).is_ok_and(|opened| is_for(&opened, &map.table)),
    };
    Ok(maps.iter().find(is_for_it))
}

/// Returns true if a column map fits a file. A file with a header must have the same column names as the map. A file without
/// a header must have the same number of columns and the same layout of the text, and its values must fit the roles of the
/// columns.
fn is_for(opened: &Opened, table: &TableMap) -> bool {
    let Some(head) = opened.head(&table.text) else {
        return false;
    };
    let has_shape = head.n_columns == table.shape.columns && head.names == table.shape.names;
    if !has_shape || table.text.header {
        return has_shape;
    }
    let columns = reports(table, &head, &opened.sample(&table.text, &head));
    opened.is_cut_by(&table.text) && columns.iter().all(ColumnReport::cells_fit_role)
}

/// Replaces the ranges of the columns, which are those of a sample, by the ranges over all rows.
fn whole_ranges(
    opened: Opened,
    head: &Head,
    text: &TextLayout,
    columns: &mut [ColumnReport],
    progress: &Progress,
) -> Result<(), FileError> {
    let missing: Vec<Option<f64>> = columns.iter().map(|column| column.missing).collect();
    let parse = |part: Part<'_>| {
        let mut ranges = vec![MinMax::NONE; missing.len()];
        let mut take = |row: &mut dyn Iterator<Item = Cell<'_>>| {
            for ((range, mark), cell) in ranges.iter_mut().zip(&missing).zip(row) {
                if let Some(value) = value_of(cell, text).filter(|value| Some(*value) != *mark) {
                    *range = range.with(value);
                }
            }
        };
        match part {
            Part::Lines(block) => {
                lines(block).filter_map(|line| text.row(line)).for_each(|mut row| take(&mut row))
            }
            Part::Rows(columns, rows) => rows.for_each(|row| take(&mut columns.row(row))),
        }
        ranges
    };
    opened.read(head, progress, parse, |parts, _| {
        for ranges in parts {
            for (column, range) in columns.iter_mut().zip(ranges) {
                if column.min.is_some() && range.min <= range.max {
                    column.min = column.min.map(|min| min.min(range.min));
                    column.max = column.max.map(|max| max.max(range.max));
                }
            }
        }
    })
}

/// Describes a file. Without `columns`, its columns have the roles that `table` gives them.
fn report(
    path: &Path,
    opened: &Opened,
    table: &TableMap,
    columns: Option<Vec<ColumnReport>>,
) -> TableReport {
    let head = opened.head(&table.text);
    let sample = match &head {
        Some(head) => opened.sample(&table.text, head),
        None => Sample::default(),
    };
    TableReport {
        path: path.to_owned(),
        file_bytes: opened.file_bytes,
        encoding: opened.encoding,
        kind: opened.kind,
        text: table.text.clone(),
        line: head.as_ref().map(|head| head.line),
        parts: opened.parts().to_vec(),
        about_rows: head.as_ref().map_or(0, |head| opened.about_rows(head)),
        columns: (columns)
            .or_else(|| Some(reports(table, head.as_ref()?, &sample)))
            .unwrap_or_default(),
        preview: sample
            .rows
            .iter()
            .take(PREVIEW_ROWS)
            .map(|row| row.iter().copied().map(Cell::text).collect())
            .collect(),
    }
}

fn check(
    path: &Path,
    reading: &Reading,
    map: &ColumnMap,
    notes: Vec<Cause>,
    [is_sample, may_skip_rows]: [bool; 2],
) -> Result<Check, ReadError> {
    let mut check = Check { is_sample, ..Check::default() };
    let loaded = reading.sides(path, Some(map)).and_then(|mut sides| {
        for note in notes {
            sides.gauges.rows.findings.note(sides.gauges.plan.line, note);
        }
        if let Some(reference) = &sides.reference {
            check.clock_offset = estimated_offset(&sides.gauges, reference);
        }
        if !may_skip_rows {
            sides.check_skipped()?;
        }
        sides.joined()
    });
    let loaded = match loaded {
        Ok(loaded) => loaded,
        Err(ReadError::Cancelled) => return Err(ReadError::Cancelled),
        Err(error) => return Ok(Check { error: Some(error.to_string()), ..check }),
    };
    let report = |recording: &Recording| RecordingReport {
        name: recording.name().to_owned(),
        n_samples: recording.n_samples(),
        duration_secs: recording.duration_secs(),
        rate_hz: recording.rate_hz(),
        auxiliary: recording.auxiliary().in_words(),
    };
    let first = &loaded.recordings[0];
    Ok(Check {
        gauges: first.gauge_names().to_vec(),
        axes: first.axes().to_vec(),
        missing: loaded.recordings.iter().find_map(Recording::missing),
        recordings: loaded.recordings.iter().map(report).collect(),
        warnings: loaded.warnings,
        assumed_gap_secs: loaded.assumed_gap_secs,
        ..check
    })
}

fn estimated_offset(gauges: &Table, reference: &Table) -> Option<ClockOffset> {
    let series = |times, values, width| Series { times, values, width };
    let (left, right) = (&gauges.rows, &reference.rows);
    clock_offset::estimate(
        series(&left.times, &left.gauges, gauges.plan.gauges.names.len()),
        series(&right.times, &right.loads, reference.plan.axes.len()),
    )
}
