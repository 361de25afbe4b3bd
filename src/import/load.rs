//! From a path to recordings: what to read, in which order, and what is done to it before it is cut.

use std::path::Path;

use super::opened::Opened;
use super::plan::{Plan, Side};
use super::two_clocks::{self, Table};
use super::warning::{Finding, LoadWarning};
use super::{BLOCK_BYTES, Loaded, ReadError, assemble, names, weigh};
use crate::formats::text::Decimal;
use crate::import::map::{ColumnMap, TableMap, WeightMap};
use crate::progress::Progress;

/// How files are read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading<'a> {
    pub(super) progress: &'a Progress,
    pub(super) block_bytes: usize,
    /// Read only so much of each file.
    pub(super) limit_bytes: Option<u64>,
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
        Opened::open(path, self.block_bytes, self.limit_bytes, self.progress)
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
                if let Some(weight) = &map.weight {
                    weight.check_complete(map.reference_table())?;
                }
                (map.clone(), Vec::new())
            }
            None => by_names(path, &opened)?,
        };
        let side = if map.has_two_clocks() {
            Side::Gauges
        } else {
            Side::Both
        };
        let notes = opened.notes().into_iter().chain(notes).collect::<Vec<_>>();
        let weight = map.weight.as_ref();
        let mut gauges = self.table(path, opened, &map.table, side, weight)?;
        if let Some(weight) = weight {
            weigh::weigh(&mut gauges, weight)?;
        }
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
        self.progress.add_total(opened.read_bytes());
        let weight = map.weight.as_ref();
        let mut reference = self.table(&path, opened, table, side, weight)?;
        if let Some(weight) = weight {
            weigh::weigh(&mut reference, weight)?;
        }
        two_clocks::check_reference(&reference)?;
        assemble::note_held_reference(&reference.plan, &mut reference.rows);
        Ok(Some(reference))
    }

    pub(super) fn table(
        &self,
        path: &Path,
        opened: Opened,
        table: &TableMap,
        side: Side,
        weight: Option<&WeightMap>,
    ) -> Result<Table, ReadError> {
        let table = opened.fitting(table);
        let start = opened.start(path, &table)?;
        let plan = Plan::new(path, &table, &start, side, weight)?;
        let mut rows = opened.rows(&plan, &start, self.progress)?;
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

/// The map that the names of a file make, and what is to be said about it.
fn by_names(path: &Path, opened: &Opened) -> Result<(ColumnMap, Vec<Finding>), ReadError> {
    let no_header = || ReadError::NoHeader {
        path: path.to_owned(),
    };
    let detected = opened.detected().ok_or_else(no_header)?;
    let start = opened.located(&detected.text).ok_or_else(no_header)?;
    if opened.kind().is_some() && !detected.text.header {
        return Err(ReadError::NoNames {
            path: path.to_owned(),
            columns: start.n_columns,
        });
    }
    names::check_named(path, &detected, &start)?;
    let rows = opened.first_rows(&detected.text, &start);
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
        let mut loaded = assemble::recordings(gauges, map.gap_secs)?;
        if let Some(tare) = map.tare {
            let recordings = loaded.recordings.into_iter();
            let tared = recordings.map(|recording| Ok(recording.tared(tare)?.0));
            loaded.recordings = tared.collect::<Result<_, ReadError>>()?;
        }
        loaded.warnings.append(&mut warnings);
        Ok(loaded)
    }
}
