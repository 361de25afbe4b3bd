//! Loads the recordings of a file: reads gauges and reference load, checks both, assigns a reference to each gauge sample,
//! and divides the samples into recordings.

use std::path::Path;

use super::error::{at, of_file};
use super::plan::{Plan, Side};
use super::proposal::{Mapped, mapped};
use super::question::{Question, answer};
use super::rows::Rows;
use super::two_clocks::{self, Table};
use super::warning::Cause;
use crate::{
    finding::Finding,
    formats::{self, FilePart, Opened},
    import::{
        assemble,
        error::ReadError,
        map::{ColumnMap, Stamps, TableMap, WeightMap},
        timeline, weigh,
    },
    progress::Progress,
    recording::Recording,
    shown::listed,
};

/// Number of bytes of a file that are parsed at a time: few enough for the cache of a processor core, and enough to make the
/// overhead of each block small.
pub const BLOCK_BYTES: usize = 1 << 18;

/// Share of skipped rows above which a file is refused, because the layout of its text was probably not understood.
const SKIPPED_SHARE: f64 = 0.1;
/// Minimum number of skipped rows for [`SKIPPED_SHARE`] to apply.
const SKIPPED_ROWS: u64 = 10;

/// Recordings that were loaded from a file, with warnings about the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loaded {
    /// Recordings in the order of the file. There is at least one.
    pub recordings: Vec<Recording>,
    /// Warnings about the file, one for each kind of fault, in the order of their first lines.
    pub warnings: Vec<Finding>,
    /// Shortest pause in the rows (s) that starts a new recording, if it was derived from rows in bursts because the map sets
    /// none.
    pub assumed_gap_secs: Option<f64>,
    /// Column map by which the file was read. `None` if the columns had their proposed roles.
    pub map: Option<Box<ColumnMap>>,
    /// Roles of the columns.
    pub mapped: Mapped,
}

impl Loaded {
    /// Returns what a calibration still has to know, with the text for `--columns` that answers it
    /// if a column can. `None` if it knows all.
    pub fn asked(&self) -> Option<(String, Option<String>)> {
        let Mapped { questions, columns, .. } = &self.mapped;
        let mut asked = questions.clone();
        let missing = self.recordings.iter().find_map(Recording::missing);
        asked.extend(Question::about_missing(missing, questions, columns));
        asked.retain(Question::is_about_load);
        let texts: Vec<String> = asked.iter().map(|question| question.text(columns)).collect();
        (!texts.is_empty()).then(|| (texts.join(" "), answer(&asked, columns)))
    }

    /// Returns the open questions about the load.
    pub fn load_questions(&self) -> impl Iterator<Item = String> {
        let Mapped { questions, columns, .. } = &self.mapped;
        let about = questions.iter().filter(|question| question.is_about_load());
        about.map(|question| question.text(columns))
    }
}

/// Returns the note that these loads have no unit; `None` if there are none.
pub fn unit_note(without_unit: &[String]) -> Option<String> {
    let names = listed(without_unit);
    (!without_unit.is_empty()).then(|| {
        format!("no unit in the file, so forces are read in N and moments in N·m: {names}")
    })
}

#[derive(Clone, Copy, Debug)]
pub struct Reading<'a> {
    pub progress: &'a Progress,
    pub block_bytes: usize,
    /// Maximum number of bytes that are read from the start of each file. `None` to read whole files.
    pub limit_bytes: Option<u64>,
}

#[derive(Debug)]
pub struct Sides {
    pub gauges: Table,
    /// Table of the reference load. `None` if gauges and reference have the same clock, so that both are in the table
    /// `gauges`.
    pub reference: Option<Table>,
    mapped: Mapped,
}

impl<'a> Reading<'a> {
    pub fn whole(progress: &'a Progress) -> Self {
        Self { progress, block_bytes: BLOCK_BYTES, limit_bytes: None }
    }

    pub fn start(progress: &'a Progress, limit_bytes: u64) -> Self {
        Self { limit_bytes: Some(limit_bytes), ..Self::whole(progress) }
    }

    /// Opens a file. If the file holds several tables, `parts` lists the names of the tables to read. If `parts` is empty,
    /// the program chooses one table.
    pub fn open(&self, path: &Path, parts: &[String]) -> Result<Opened, ReadError> {
        let (block_bytes, limit_bytes) = (self.block_bytes, self.limit_bytes);
        let opened = formats::open(path, block_bytes, limit_bytes, parts, self.progress);
        opened.map_err(of_file(path))
    }

    /// Loads the recordings of a file as a column map describes. Without a map, the columns have their proposed roles.
    pub fn load(&self, path: &Path, map: Option<&ColumnMap>) -> Result<Loaded, ReadError> {
        let sides = self.sides(path, map)?;
        if map.is_none() {
            sides.check_skipped()?;
        }
        Ok(Loaded { map: map.map(|map| Box::new(map.clone())), ..sides.joined()? })
    }

    pub fn sides(&self, path: &Path, map: Option<&ColumnMap>) -> Result<Sides, ReadError> {
        let parts = map.map_or(&[][..], |map| &map.table.text.parts);
        let opened = self.open(path, parts)?;
        let mut mapped = mapped(path, &opened, map, None)?;
        let map = &mapped.map;
        map.check()?;
        if let Some(weight) = &map.weight {
            weight.check_complete(map.reference_table())?;
        }
        let side = Side::of_gauges(map);
        let about = about(&opened);
        let weight = map.weight.as_ref();
        let mut gauges = self.table(path, opened, &map.table, side, weight)?;
        weigh::weigh(&mut gauges, weight)?;
        for note in about.into_iter().chain(std::mem::take(&mut mapped.notes)) {
            gauges.rows.findings.note(gauges.plan.line, note);
        }
        let mut reference = self.reference(path, map)?;
        if let Some(own) = &mut reference {
            own.rows.count_from(gauges.rows.zero_secs);
        }
        Ok(Sides { gauges, reference, mapped })
    }

    fn reference(&self, path: &Path, map: &ColumnMap) -> Result<Option<Table>, ReadError> {
        let Some((path, side)) = two_clocks::reference_of(path, map) else {
            return Ok(None);
        };
        let table = map.reference_table();
        let opened = self.open(&path, &table.text.parts)?;
        self.progress.add_total(opened.read_bytes);
        let weight = map.weight.as_ref();
        let mut reference = self.table(&path, opened, table, side, weight)?;
        weigh::weigh(&mut reference, weight)?;
        two_clocks::check_reference(&reference)?;
        Ok(Some(reference))
    }

    pub fn table(
        &self,
        path: &Path,
        opened: Opened,
        table: &TableMap,
        side: Side,
        weight: Option<&WeightMap>,
    ) -> Result<Table, ReadError> {
        let head = opened.head(&table.text).ok_or_else(|| {
            let what = match (opened.kind, table.text.header) {
                (Some(_), _) => "named columns",
                (None, true) => "lines to skip and a header",
                (None, false) => "lines to skip and rows",
            };
            let path = path.to_owned();
            ReadError::TooShortForMap { path, what }
        })?;
        let mut plan = Plan::new(table, &head, side, weight).map_err(at(path, head.line))?;
        let sample = opened.sample(&table.text, &head);
        if let (Some(first), Some(_)) = (sample.rows.first(), plan.time_column) {
            Rows::plan_zero(&mut plan, first.iter().copied());
        }
        drop(sample);
        let read = Rows::read(opened, &head, &plan, self.progress);
        let mut rows = read.map_err(of_file(path))?;
        if head.end_bytes.is_some() {
            let names = vec!["the lines below the table".to_owned()];
            rows.findings.note(rows.n_lines, Cause::LeftOut { names });
        }
        assemble::settle_times(&plan, &mut rows);
        match table.stamps {
            Stamps::AsWritten => {}
            Stamps::Sorted => timeline::sort(&mut rows),
            Stamps::Spread => timeline::spread(&mut rows.times),
        }
        if rows.times.is_empty() {
            return Err(assemble::no_usable_row(path, &plan, rows));
        }
        Ok(Table { path: path.to_owned(), plan, rows })
    }
}

/// Returns warnings about parts of the file that are missing or are not read.
fn about(opened: &Opened) -> Vec<Cause> {
    let mut findings = Vec::from_iter(opened.reshaped().map(|how| Cause::Reshaped { how }));
    let Some(columns) = opened.columns() else {
        return findings;
    };
    if !columns.left_out.is_empty() {
        let names = columns.left_out.clone();
        findings.push(Cause::LeftOut { names });
    }
    if columns.ends_early {
        findings.push(Cause::EndsEarly);
    }
    if columns.is_guessed_part {
        let (used, others) = columns.parts.iter().partition(|part| part.is_used);
        let names = |parts: Vec<&FilePart>| parts.iter().map(|part| part.name.clone()).collect();
        findings.push(Cause::SeveralParts { used: names(used), others: names(others) });
    }
    findings
}

impl Sides {
    /// Returns an error if too many rows are skipped. Rows with NaN do not count as skipped here, because NaN marks a missing
    /// value.
    pub fn check_skipped(&self) -> Result<(), ReadError> {
        let rows = &self.gauges.rows;
        let (skipped, used) = (rows.findings.not_understood(), rows.times.len() as u64);
        if skipped < SKIPPED_ROWS || skipped as f64 <= SKIPPED_SHARE * (skipped + used) as f64 {
            return Ok(());
        }
        let (cause, place) = rows.findings.most_skipped().expect("a skipped row has a reason");
        Err(ReadError::ManySkipped {
            path: self.gauges.path.clone(),
            skipped,
            rows: skipped + used,
            first: Box::new(cause.finding(place, &self.gauges.path)),
        })
    }

    /// Assigns a reference load to each gauge sample, and divides the samples into recordings.
    pub fn joined(self) -> Result<Loaded, ReadError> {
        let Self { mut gauges, reference, mapped } = self;
        let map = &mapped.map;
        let is_static = gauges.plan.is_static;
        let path = gauges.path.clone();
        let mut of_reference = Vec::new();
        if let Some(mut reference) = reference.filter(|_| !is_static) {
            two_clocks::join(&mut gauges, &mut reference, &map.join)?;
            of_reference = reference.rows.findings.into_findings(&reference.path);
        }
        gauges.rows.hold_auxiliary(&mut gauges.plan, map.gap_secs);
        let (recordings, findings) = if is_static {
            assemble::without_times(gauges)?
        } else {
            assemble::recordings(gauges, map.gap_secs)?
        };
        let assumed_gap_secs = findings.assumed_gap_secs();
        let mut warnings = findings.into_findings(&path);
        warnings.append(&mut of_reference);
        let tool = map.weight.as_ref().and_then(WeightMap::weight);
        let finished = |recording: Recording| {
            let recording = recording.with_tool(tool);
            match map.tare {
                // The tare interval is given in seconds, so taring samples without times is an error.
                Some(tare) => Ok(recording.tared(tare)?.0),
                None => Ok(recording),
            }
        };
        let recordings = recordings.into_iter().map(finished);
        let recordings = recordings.collect::<Result<_, ReadError>>()?;
        Ok(Loaded { recordings, warnings, assumed_gap_secs, map: None, mapped })
    }
}
