//! What a file holds, before it is loaded: for whoever makes a map, on a screen or by hand.
//!
//! Guarantees: only the start of a large file is read; what would be loaded and what is wrong come from the same code
//! that loads, so that nothing is promised here that fails there; a file that can be opened as text is always described.

mod by_values;
pub(super) mod columns;
mod question;

use std::fmt;
use std::path::{Path, PathBuf};

use serde::Serialize;

pub(crate) use columns::ColumnReport;
pub use question::Question;

use super::load::{Loaded, Reading};
use super::two_clocks::{self, Table};
use crate::formats::text::Encoding;
use crate::formats::text::TextLayout;
use crate::formats::{Cell, FilePart, Opened, Sample};
use crate::import::clock_offset;
use crate::import::clock_offset::ClockOffset;
use crate::import::error::ReadError;
use crate::import::join::Series;
use crate::import::map::{ColumnMap, TableMap};
use crate::import::names;
use crate::import::warning::Cause;
use crate::progress::Progress;
use crate::recording::{Axis, Recording};

/// Maximum length of a file that is read to see what would be loaded (bytes): thousands of rows, read at once.
const SAMPLE_BYTES: u64 = 8 << 20;
/// How many rows are shown.
const PREVIEW_ROWS: usize = 12;

/// What is known already when a file is looked at.
#[derive(Clone, Copy, Debug)]
pub enum Known<'a> {
    /// Nothing: everything is found by looking.
    Nothing,
    /// How the text is cut; what the columns are is found by looking.
    Layout(&'a TextLayout),
    /// Everything: the map is only tried out.
    Map(&'a ColumnMap),
}

/// What a file holds, a map for it, and what reading it by that map would give.
#[derive(Clone, Debug, Serialize)]
pub struct Inspection {
    /// The file.
    pub table: TableReport,
    /// The file of the reference, if the map names one that can be opened.
    pub reference: Option<TableReport>,
    /// The map that was given, or a proposal.
    pub map: ColumnMap,
    /// What a person should decide about a proposal.
    pub questions: Vec<Question>,
    /// What would be loaded.
    pub check: Check,
}

/// One file as it was found.
#[derive(Clone, Debug, Serialize)]
pub struct TableReport {
    /// Where it is.
    pub path: PathBuf,
    /// How long it is.
    pub file_bytes: u64,
    /// How it writes its characters.
    pub encoding: Encoding,
    /// What it is called if it is a file of arrays.
    pub kind: Option<&'static str>,
    /// How its text is cut.
    pub text: TextLayout,
    /// The line of its header, or of its first row; `None` if the layout finds neither.
    pub line: Option<u64>,
    /// How many rows there are, by the length of the first ones.
    pub about_rows: u64,
    /// Where it holds several tables, all of them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<FilePart>,
    /// Its columns.
    pub columns: Vec<ColumnReport>,
    /// The cells of its first rows.
    pub preview: Vec<Vec<String>>,
}

/// How long the file is, what it is, and how many rows it has.
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

/// What reading a file, or the start of a large one, gives.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Check {
    /// Whether only the start was read.
    pub is_sample: bool,
    /// Why nothing would be loaded.
    pub error: Option<String>,
    /// What would be said besides.
    pub warnings: Vec<String>,
    /// What would be loaded.
    pub recordings: Vec<RecordingReport>,
    /// The gauges' names.
    pub gauges: Vec<String>,
    /// The axes of the reference.
    pub axes: Vec<Axis>,
    /// Where rows come in bursts and the map says nothing about it, how long a pause must be to end a recording.
    pub assumed_gap_secs: Option<f64>,
    /// Of two clocks, how far they seem to be apart. Nothing is done about it unless the map says so.
    pub clock_offset: Option<ClockOffset>,
}

/// One recording that would be loaded.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "the names are the documentation")]
pub struct RecordingReport {
    pub name: String,
    pub n_samples: usize,
    pub duration_secs: f64,
    pub rate_hz: Option<f64>,
    /// Its auxiliary channels with their ranges.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub auxiliary: Vec<String>,
}

/// Looks at a file.
///
/// # Errors
/// [`ReadError`] if it cannot be opened or is no text, or if `progress` is cancelled. Whatever is wrong besides stands in
/// [`Check::error`].
pub fn inspect(path: &Path, known: Known, progress: &Progress) -> Result<Inspection, ReadError> {
    let reading = Reading::start(progress, SAMPLE_BYTES);
    let parts = match known {
        Known::Nothing => &[][..],
        Known::Layout(text) => &text.parts,
        Known::Map(map) => &map.table.text.parts,
    };
    let opened = reading.open(path, parts)?;
    let (map, questions) = match known {
        Known::Map(map) => (map.clone(), Vec::new()),
        Known::Layout(text) => propose(path, &opened, text),
        Known::Nothing => match opened.layout() {
            Some(text) => propose(path, &opened, &text),
            None => (ColumnMap::default(), Vec::new()),
        },
    };
    let reference = map.reference.as_ref().and_then(|file| {
        let path = two_clocks::reference_path(path, file);
        let opened = reading.open(&path, &file.table.text.parts).ok()?;
        Some(report(&path, &opened, &file.table))
    });
    let table = report(path, &opened, &map.table);
    let is_sample = opened.read_bytes < table.file_bytes;
    let check = check(path, &reading, &map, is_sample)?;
    Ok(Inspection { table, reference, map, questions, check })
}

/// A map by the names of a table, and where they leave something open by its values.
fn propose(path: &Path, opened: &Opened, text: &TextLayout) -> (ColumnMap, Vec<Question>) {
    let Some(head) = opened.head(text) else {
        let table = TableMap { text: text.clone(), ..TableMap::default() };
        return (ColumnMap::of_table(table), Vec::new());
    };
    let sample = opened.sample(text, &head);
    let mut guess = names::by_names(text, &head, &sample.rows);
    let questions = if text.preamble.is_some() {
        vec![Question::ReferenceAlone]
    } else {
        let reports = columns::reports(&guess.table(text, &head), &head, &sample);
        by_values::fill_in(&mut guess, &head, &sample.rows, &reports)
    };
    (guess.map(text, &head, path, &sample.rows), questions)
}

/// The first of the maps that is for files like this one, if any is.
///
/// # Errors
/// [`ReadError`] if the file cannot be opened, or if `progress` is cancelled.
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

/// Whether a map was made for files like this one: the header is the same, name by name. Without a header there are as
/// many columns, looking finds that they are cut as the map says, and in each stands what the map takes from it.
fn is_for(opened: &Opened, table: &TableMap) -> bool {
    let Some(head) = opened.head(&table.text) else {
        return false;
    };
    let has_shape = head.n_columns == table.shape.columns && head.names == table.shape.names;
    if !has_shape || table.text.header {
        return has_shape;
    }
    let columns = columns::reports(table, &head, &opened.sample(&table.text, &head));
    opened.is_cut_by(&table.text) && columns.iter().all(ColumnReport::can_be_what_it_is)
}

fn report(path: &Path, opened: &Opened, table: &TableMap) -> TableReport {
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
        columns: head.map_or_else(Vec::new, |head| columns::reports(table, &head, &sample)),
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
    is_sample: bool,
) -> Result<Check, ReadError> {
    let mut check = Check { is_sample, ..Check::default() };
    let loaded = reading.sides(path, Some(map)).and_then(|sides| {
        if let Some(reference) = &sides.reference {
            check.clock_offset = estimated_offset(&sides.gauges, reference);
        }
        sides.joined()
    });
    match loaded {
        Ok(loaded) => note(&mut check, &loaded),
        Err(ReadError::Cancelled) => return Err(ReadError::Cancelled),
        Err(error) => check.error = Some(error.to_string()),
    }
    Ok(check)
}

fn note(check: &mut Check, loaded: &Loaded) {
    check.warnings = loaded.warnings.iter().map(ToString::to_string).collect();
    check.assumed_gap_secs = loaded.warnings.iter().find_map(|warning| match warning.cause {
        Cause::Bursts { gap_secs, .. } => Some(gap_secs),
        _ => None,
    });
    if let Some(first) = loaded.recordings.first() {
        check.gauges = first.gauge_names().to_vec();
        check.axes = first.axes().to_vec();
    }
    let report = |recording: &Recording| RecordingReport {
        name: recording.name().to_owned(),
        n_samples: recording.n_samples(),
        duration_secs: recording.duration_secs(),
        rate_hz: recording.rate_hz(),
        auxiliary: recording.auxiliary().in_words(),
    };
    check.recordings = loaded.recordings.iter().map(report).collect();
}

fn estimated_offset(gauges: &Table, reference: &Table) -> Option<ClockOffset> {
    let series = |times, values, width| Series { times, values, width };
    let (left, right) = (&gauges.rows, &reference.rows);
    clock_offset::estimate(
        series(&left.times, &left.gauges, gauges.plan.gauge_names.len()),
        series(&right.times, &right.loads, reference.plan.axes.len()),
    )
}
