//! From a path to recordings: what to read, in which order, and what is done to it before it is cut.

use std::path::Path;

use super::blocks::Blocks;
use super::cells::is_skipped;
use super::layout::{self, Start};
use super::plan::{Plan, Side};
use super::two_clocks::{self, Table};
use super::warning::{Finding, LoadWarning};
use super::{BLOCK_BYTES, Loaded, ReadError, assemble, names, stream};
use crate::progress::Progress;
use crate::recording::columns::{ColumnMap, Decimal, TableMap};

/// So much of a file is there when its table is looked for.
pub(super) const HEAD_BYTES: usize = 1 << 16;

/// How files are read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading<'a> {
    pub(super) progress: &'a Progress,
    pub(super) block_bytes: usize,
    /// Read only so much of each file.
    pub(super) limit_bytes: Option<u64>,
}

/// A file that was opened, and its start.
#[derive(Debug)]
pub(super) struct Opened {
    blocks: Blocks,
    pub(super) head: Vec<u8>,
}

/// Gauges and reference before they are joined, and notes on the map that was made for them.
#[derive(Debug)]
pub(super) struct Sides {
    pub(super) gauges: Table,
    /// `None` if there is only one clock.
    pub(super) reference: Option<Table>,
    map: ColumnMap,
}

impl<'a> Reading<'a> {
    /// Whole files.
    pub(super) fn whole(progress: &'a Progress) -> Self {
        Self {
            progress,
            block_bytes: BLOCK_BYTES,
            limit_bytes: None,
        }
    }

    pub(super) fn open(&self, path: &Path) -> Result<Opened, ReadError> {
        let mut blocks = Blocks::open(path, self.block_bytes, self.limit_bytes)?;
        let head = blocks.head(HEAD_BYTES)?;
        Ok(Opened { blocks, head })
    }

    /// Reads a file by a map; without one, by its names.
    pub(super) fn load(&self, path: &Path, map: Option<&ColumnMap>) -> Result<Loaded, ReadError> {
        self.sides(path, map)?.joined()
    }

    /// Reads gauges and reference.
    pub(super) fn sides(&self, path: &Path, map: Option<&ColumnMap>) -> Result<Sides, ReadError> {
        let opened = self.open(path)?;
        let (map, notes) = match map {
            Some(map) => {
                map.check()?;
                (map.clone(), Vec::new())
            }
            None => by_names(path, &opened)?,
        };
        let side = if map.has_two_clocks() {
            Side::Gauges
        } else {
            Side::Both
        };
        let mut gauges = self.table(path, opened, &map.table, side)?;
        for note in notes {
            gauges.rows.findings.note(gauges.plan.line, note);
        }
        if let Some(within_secs) = map.average_bursts_secs {
            assemble::average_bursts(&gauges.plan, &mut gauges.rows, within_secs);
        }
        let reference = self.reference(path, &map)?;
        if reference.is_none() {
            assemble::note_held_reference(&gauges.plan, &mut gauges.rows);
        }
        Ok(Sides {
            gauges,
            reference,
            map,
        })
    }

    fn reference(&self, path: &Path, map: &ColumnMap) -> Result<Option<Table>, ReadError> {
        let (path, table, side) = match &map.reference {
            Some(file) => {
                let path = two_clocks::reference_path(path, file);
                (path, &file.table, Side::ReferenceFile)
            }
            None if map.has_two_clocks() => (path.to_owned(), &map.table, Side::SecondClock),
            None => return Ok(None),
        };
        let opened = self.open(&path)?;
        self.progress.add_total(opened.blocks.file_bytes());
        let mut reference = self.table(&path, opened, table, side)?;
        two_clocks::check_reference(&reference)?;
        assemble::note_held_reference(&reference.plan, &mut reference.rows);
        Ok(Some(reference))
    }

    fn table(
        &self,
        path: &Path,
        mut opened: Opened,
        table: &TableMap,
        side: Side,
    ) -> Result<Table, ReadError> {
        let start = opened.start(path, table)?;
        let plan = Plan::new(path, table, &start, side)?;
        let Opened { blocks, head } = &mut opened;
        let head = std::mem::take(head);
        let mut rows = stream::read_rows(&plan, &start, head, blocks, self.progress)?;
        assemble::settle_times(&plan, &mut rows);
        if rows.times.is_empty() {
            return Err(assemble::why_nothing_is_usable(path, &plan, rows));
        }
        Ok(Table {
            path: path.to_owned(),
            plan,
            rows,
        })
    }
}

impl Opened {
    /// Where the table is that a map describes.
    pub(super) fn start(&self, path: &Path, table: &TableMap) -> Result<Start, ReadError> {
        layout::locate(&self.head, &table.text).ok_or_else(|| ReadError::TooShortForMap {
            path: path.to_owned(),
            what: if table.text.header {
                "lines to skip and a header"
            } else {
                "lines to skip and rows"
            },
        })
    }

    /// How many rows the file has if all are like those of its head.
    pub(super) fn about_rows(&self, start: &Start) -> u64 {
        let rows = &self.head[start.n_bytes.min(self.head.len())..];
        let lines = rows.split(|byte| *byte == b'\n');
        let n_rows = lines.filter(|line| !is_skipped(line)).count() as f64;
        let text_bytes = self.file_bytes() / self.encoding().bytes_per_character();
        let share =
            text_bytes.saturating_sub(start.n_bytes as u64) as f64 / rows.len().max(1) as f64;
        // A file that is here as a whole differs by its byte order mark at most.
        let share = if share < 1.001 { 1.0 } else { share };
        (n_rows * share).round() as u64
    }

    pub(super) fn encoding(&self) -> super::Encoding {
        self.blocks.encoding()
    }

    /// How long the file is.
    pub(super) fn file_bytes(&self) -> u64 {
        self.blocks.whole_file_bytes()
    }
}

/// The map that the names of a file make, and what is to be said about it.
fn by_names(path: &Path, opened: &Opened) -> Result<(ColumnMap, Vec<Finding>), ReadError> {
    let no_header = || ReadError::NoHeader {
        path: path.to_owned(),
    };
    let detected = layout::detect(&opened.head).ok_or_else(no_header)?;
    let start = layout::locate(&opened.head, &detected.text).ok_or_else(no_header)?;
    names::check_named(path, &detected, &start)?;
    let rows = layout::first_rows(&opened.head, &detected.text, &start);
    let mut named = names::by_names(&detected, &start, &rows);
    // Nobody has said that commas are decimal points: then each is told.
    named.table.text.decimal = Decimal::Point;
    Ok((ColumnMap::of_table(named.table), named.notes))
}

impl Sides {
    /// Brings the reference to the gauges' times, and cuts the result into recordings.
    pub(super) fn joined(self) -> Result<Loaded, ReadError> {
        let Self {
            mut gauges,
            reference,
            map,
        } = self;
        let mut warnings: Vec<LoadWarning> = Vec::new();
        if let Some(mut reference) = reference {
            two_clocks::join(&mut gauges, &mut reference, &map.join)?;
            warnings = reference.rows.findings.into_warnings(&reference.path);
        }
        let mut loaded = assemble::recordings(gauges)?;
        loaded.warnings.append(&mut warnings);
        Ok(loaded)
    }
}
