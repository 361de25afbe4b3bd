//! Rows of numbers that need no parsing: what is kept, left out and told is the same as of text.

use super::super::opened::cells;
use super::super::plan::{Plan, PosePlan, Use};
use super::{Rows, Unusable, ati, finite, is_dropout, mount_in};
use crate::formats::{Column, Table};
use crate::progress::{Cancelled, Progress};
use crate::recording::Axis;

/// Rows between two looks at whether the work was cancelled.
const ROWS_AT_A_TIME: usize = 1 << 14;

impl Rows {
    /// The rows of a table, row 1 being line 1.
    pub(in super::super) fn of_arrays(
        table: &Table,
        plan: &Plan,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let n_rows = table.n_rows();
        let mut rows = Self {
            bad_cells: vec![0; plan.uses.len()],
            counts_rows: plan.time_column.is_none(),
            ..Self::default()
        };
        rows.reserve(n_rows, plan);
        for row in 0..n_rows {
            if row % ROWS_AT_A_TIME == 0 {
                progress.check()?;
            }
            rows.n_lines += 1;
            let (n_kept, n_gauges) = (rows.times.len(), rows.gauges.len());
            match rows.keep_numbers(table, row, plan) {
                Ok(()) => rows.place_row(n_kept, rows.n_lines),
                Err(Unusable) => {
                    rows.gauges.truncate(n_gauges);
                    rows.explain(cells(table, row).join(",").as_bytes(), plan);
                }
            }
            rows.n_table_rows += 1;
        }
        Ok(rows)
    }

    fn keep_numbers(&mut self, table: &Table, row: usize, plan: &Plan) -> Result<(), Unusable> {
        let mut loads = [0.0; Axis::ALL.len()];
        let mut pose = [0.0; PosePlan::WIDTH_LIMIT];
        let mut time = if self.counts_rows {
            self.n_table_rows as f64
        } else {
            0.0
        };
        for (index, (usage, column)) in plan.uses.iter().zip(&table.columns).enumerate() {
            let value = |column: &Column| {
                let value = column.values.get(row).copied().ok_or(Unusable)?;
                match is_dropout(value, index, plan) {
                    true => Err(Unusable),
                    false => Ok(value),
                }
            };
            match *usage {
                Use::Ignored => {}
                Use::Gauge { factor } => {
                    let value = value(column)? * factor;
                    self.gauges.push(finite(value).ok_or(Unusable)?);
                }
                Use::Load { slot, factor } => {
                    loads[slot] = finite(value(column)? * factor).ok_or(Unusable)?;
                }
                Use::Time => time += finite(value(column)?).ok_or(Unusable)?,
                Use::Pose { slot, factor } => {
                    pose[slot] = finite(value(column)? * factor).ok_or(Unusable)?;
                }
                Use::Mount { slot } => {
                    let name = value(column)?.to_string();
                    pose[slot] = mount_in(name.as_bytes(), plan).ok_or(Unusable)?;
                }
                // A number is no date.
                Use::TimeText(_) => return Err(Unusable),
                Use::Status => {
                    let word = format!("{:x}", value(column)? as u64);
                    if ati::reports_error(word.as_bytes()) != Some(false) {
                        return Err(Unusable);
                    }
                }
            }
        }
        self.times.push(time);
        self.loads.extend_from_slice(&loads[..plan.axes.len()]);
        self.poses.extend_from_slice(&pose[..plan.pose_width()]);
        Ok(())
    }
}
