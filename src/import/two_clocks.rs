//! Joins gauges and reference load with separate clocks to one table. Each gauge sample keeps its time, and is assigned a
//! reference load that is near in time. If there is none, the sample is left out and reported.

use std::path::{Path, PathBuf};

use super::{
    error::at,
    plan::{Plan, Side},
    rows::Rows,
    warning::Cause,
};
use crate::import::{
    error::{ReadError, TableError},
    join::{self, Series},
    map::{ColumnMap, Join, ReferenceFile},
    timeline,
};

/// Gauges, reference load, or both, as read from one file. Times are in seconds.
#[derive(Debug)]
pub struct Table {
    pub path: PathBuf,
    pub plan: Plan,
    pub rows: Rows,
}

pub fn reference_path(path: &Path, reference: &ReferenceFile) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(reference.file.replace("{stem}", &stem))
}

/// Returns the path of the file that holds a reference with its own clock, and the choice of columns that are read from this
/// file. `None` if gauges and reference have the same clock.
pub fn reference_of(path: &Path, map: &ColumnMap) -> Option<(PathBuf, Side)> {
    match &map.reference {
        Some(file) => Some((reference_path(path, file), Side::ReferenceFile)),
        None => map.has_two_clocks().then(|| (path.to_owned(), Side::SecondClock)),
    }
}

pub fn check_reference(reference: &Table) -> Result<(), ReadError> {
    let rows = &reference.rows;
    let mut steps = rows.times.windows(2);
    let Some(before) = steps.position(|pair| pair[1] < pair[0]) else {
        return Ok(());
    };
    let line = rows.line_of(before + 1);
    Err(at(&reference.path, line)(TableError::ReferenceGoesBack {
        from_secs: rows.times[before],
        to_secs: rows.times[before + 1],
    }))
}

/// Computes the reference load at the times of the gauges, and adds it to the table of the gauges.
pub fn join(gauges: &mut Table, reference: &mut Table, join: &Join) -> Result<(), ReadError> {
    for time in &mut reference.rows.times {
        *time += join.clock_offset_secs;
    }
    let limit_secs =
        join.limit_secs.unwrap_or_else(|| timeline::longest_bridge(&reference.rows.times));
    let series = Series {
        times: &reference.rows.times,
        values: &reference.rows.loads,
        width: reference.plan.axes.len(),
    };
    let rows = &mut gauges.rows;
    let (has_reference, loads) = join::at_times(&rows.times, series, join.method, limit_secs);
    if !has_reference.contains(&true) {
        return Err(ReadError::ClocksApart {
            path: gauges.path.clone(),
            reference_path: reference.path.clone(),
            gauges: span(&rows.times),
            reference: span(&reference.rows.times),
        });
    }
    if let Some(first) = has_reference.iter().position(|has_it| !has_it) {
        let time_secs = rows.times[first];
        let cause = Cause::NoReferenceThen { time_secs };
        rows.leave_out(|row| has_reference[row], cause);
    }
    rows.loads = loads;
    gauges.plan.axes = std::mem::take(&mut reference.plan.axes);
    Ok(())
}

fn span(times: &[f64]) -> (f64, f64) {
    (times[0], times[times.len() - 1])
}
