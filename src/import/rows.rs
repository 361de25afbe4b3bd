//! Rows of numbers from blocks of lines. Blocks know nothing of each other, so they can be parsed at the same time.
//!
//! Guarantees: every number kept is finite; a row is kept whole or not at all; joining the rows of two blocks gives
//! what one block with the lines of both would have given.

mod of_arrays;

use super::plan::{Plan, PosePlan, Use};
use super::warning::{Finding, Findings};
use crate::formats::text::ati;
use crate::formats::text::cells::{Cells, decimal_comma_number, is_skipped, number};
use crate::recording::Axis;

/// The rows of a stretch of lines, in SI but for the times, which stay in the unit of the file.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub(super) times: Vec<f64>,
    /// Row-major.
    pub(super) gauges: Vec<f64>,
    /// Row-major, in axis order.
    pub(super) loads: Vec<f64>,
    /// Row-major, as the plan's pose says; empty once the loads are computed.
    pub(super) poses: Vec<f64>,
    pub(super) findings: Findings,
    pub(super) n_bytes: usize,
    pub(super) n_lines: u64,
    pub(super) n_skipped: u64,
    /// Per column, in how many skipped rows it holds no finite number.
    pub(super) bad_cells: Vec<u64>,
    /// Lines that are rows, usable or not.
    n_table_rows: u64,
    /// Whether the times are such counts.
    counts_rows: bool,
    lines: Vec<LineRun>,
}

/// From row `row` on, rows stand on successive lines, the first on `line`.
#[derive(Clone, Copy, Debug)]
struct LineRun {
    row: usize,
    line: u64,
}

/// A row cannot be kept.
struct Unusable;

impl Rows {
    /// No rows yet, below so many lines.
    pub(super) fn starting_after(n_lines: u64) -> Self {
        Self {
            n_lines,
            ..Self::default()
        }
    }

    /// The rows among the lines of `block`, line 1 being its first.
    pub(super) fn parse(block: &[u8], plan: &Plan) -> Self {
        let mut rows = Self {
            n_bytes: block.len(),
            bad_cells: vec![0; plan.uses.len()],
            counts_rows: plan.time_column.is_none(),
            ..Self::default()
        };
        let mut rest = block;
        while !rest.is_empty() {
            let end = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
            let line = &rest[..end];
            if rows.n_lines == 0 {
                // As many rows as if all lines were like the first, but never more than fit with one digit a cell.
                let line_bytes = line.len().max(2 * plan.uses.len());
                rows.reserve(block.len() / line_bytes + 1, plan);
            }
            rest = rest.get(end + 1..).unwrap_or_default();
            rows.n_lines += 1;
            if is_skipped(line) {
                continue;
            }
            rows.line(line.strip_suffix(b"\r").unwrap_or(line), plan);
            rows.n_table_rows += 1;
        }
        rows
    }

    /// Makes room for about `n_rows` rows more.
    pub(super) fn reserve(&mut self, n_rows: usize, plan: &Plan) {
        self.times.reserve_exact(n_rows);
        self.gauges.reserve_exact(n_rows * plan.gauge_names.len());
        self.loads.reserve_exact(n_rows * plan.axes.len());
        self.poses.reserve_exact(n_rows * plan.pose_width());
    }

    /// Appends the rows of the block that follows.
    pub(super) fn append(&mut self, next: Self) {
        let (n_rows, n_lines) = (self.times.len(), self.n_lines);
        if next.counts_rows {
            let n_before = self.n_table_rows as f64;
            self.times
                .extend(next.times.iter().map(|count| n_before + count));
        } else {
            self.times.extend_from_slice(&next.times);
        }
        self.gauges.extend_from_slice(&next.gauges);
        self.loads.extend_from_slice(&next.loads);
        self.poses.extend_from_slice(&next.poses);
        self.findings.append(next.findings, n_lines);
        self.n_bytes += next.n_bytes;
        self.n_lines += next.n_lines;
        self.n_table_rows += next.n_table_rows;
        self.n_skipped += next.n_skipped;
        self.bad_cells.resize(next.bad_cells.len(), 0);
        for (sum, more) in self.bad_cells.iter_mut().zip(next.bad_cells) {
            *sum += more;
        }
        for run in next.lines {
            self.place_row(n_rows + run.row, n_lines + run.line);
        }
    }

    /// On which line row `row` stands.
    pub(super) fn line_of(&self, row: usize) -> u64 {
        let run = self.lines[self.lines.partition_point(|run| run.row <= row) - 1];
        run.line + (row - run.row) as u64
    }

    fn place_row(&mut self, row: usize, line: u64) {
        let follows = |last: &LineRun| last.line + (row - last.row) as u64 == line;
        if !self.lines.last().is_some_and(follows) {
            self.lines.push(LineRun { row, line });
        }
    }

    fn line(&mut self, line: &[u8], plan: &Plan) {
        let (n_rows, n_gauges, n_loads) = (self.times.len(), self.gauges.len(), self.loads.len());
        match self.keep(line, plan) {
            Ok(()) => self.place_row(n_rows, self.n_lines),
            Err(Unusable) => {
                self.times.truncate(n_rows);
                self.gauges.truncate(n_gauges);
                self.loads.truncate(n_loads);
                self.explain(line, plan);
            }
        }
    }

    fn keep(&mut self, line: &[u8], plan: &Plan) -> Result<(), Unusable> {
        let mut cells = Cells::new(line, plan.delimiter);
        let mut loads = [0.0; Axis::ALL.len()];
        let mut pose = [0.0; PosePlan::WIDTH_LIMIT];
        let mut time = if self.counts_rows {
            self.n_table_rows as f64
        } else {
            0.0
        };
        let mut comma = None;
        for (index, usage) in plan.uses.iter().enumerate() {
            match *usage {
                Use::Ignored => {
                    cells.next().ok_or(Unusable)?;
                }
                Use::Gauge { factor } => {
                    let value = next_number(&mut cells, index, plan, &mut comma)?;
                    self.gauges.push(finite(value * factor).ok_or(Unusable)?);
                }
                Use::Load { slot, factor } => {
                    let value = next_number(&mut cells, index, plan, &mut comma)?;
                    loads[slot] = finite(value * factor).ok_or(Unusable)?;
                }
                Use::Time => {
                    let value = next_number(&mut cells, index, plan, &mut comma)?;
                    time += finite(value).ok_or(Unusable)?;
                }
                Use::TimeText(form) => {
                    time += form.secs(cells.next().ok_or(Unusable)?).ok_or(Unusable)?;
                }
                Use::Pose { slot, factor } => {
                    let value = next_number(&mut cells, index, plan, &mut comma)?;
                    pose[slot] = finite(value * factor).ok_or(Unusable)?;
                }
                Use::Mount { slot } => {
                    let cell = cells.next().ok_or(Unusable)?;
                    pose[slot] = mount_in(cell, plan).ok_or(Unusable)?;
                }
                Use::Status => match ati::reports_error(cells.next().ok_or(Unusable)?) {
                    Some(false) => {}
                    _ => return Err(Unusable),
                },
            }
        }
        self.times.push(time);
        self.loads.extend_from_slice(&loads[..plan.axes.len()]);
        self.poses.extend_from_slice(&pose[..plan.pose_width()]);
        if let Some((index, cell)) = comma {
            let finding = Finding::DecimalComma {
                column: index + 1,
                name: plan.names[index].clone(),
                value: text(cell),
            };
            self.findings.note(self.n_lines, finding);
        }
        let n_extra = cells.count();
        if n_extra > 0 {
            let expected = plan.uses.len();
            let actual = expected + n_extra;
            let finding = Finding::TooManyCells { expected, actual };
            self.findings.note(self.n_lines, finding);
        }
        Ok(())
    }

    /// Notes why a row cannot be kept: the first reason as a finding, all bad cells as counts.
    fn explain(&mut self, line: &[u8], plan: &Plan) {
        let cells = || Cells::new(line, plan.delimiter);
        let used = || {
            let is_used = |(_, usage): &(&[u8], &Use)| **usage != Use::Ignored;
            cells().zip(&plan.uses).filter(is_used)
        };
        if plan.may_be_blank && used().all(|(cell, _)| cell.is_empty()) {
            return;
        }
        self.n_skipped += 1;
        let (expected, actual) = (plan.uses.len(), cells().count());
        if actual < expected {
            let finding = Finding::TooFewCells { expected, actual };
            self.findings.note(self.n_lines, finding);
            return;
        }
        let mut first = None;
        for (index, (cell, usage)) in cells().zip(&plan.uses).enumerate() {
            if let Some(finding) = trouble(cell, *usage, index, plan) {
                // What the map says to leave out is no bad cell.
                let is_bad = !matches!(
                    finding,
                    Finding::Dropout { .. } | Finding::StatusError { .. }
                );
                self.bad_cells[index] += u64::from(is_bad);
                first.get_or_insert(finding);
            }
        }
        if let Some(finding) = first {
            self.findings.note(self.n_lines, finding);
        }
    }

    /// Leaves out the rows that are not kept.
    pub(super) fn retain(&mut self, is_kept: impl Fn(usize) -> bool) {
        let n_rows = self.times.len();
        self.keep_lines_of((0..n_rows).filter(|row| is_kept(*row)));
        let lists = [
            &mut self.times,
            &mut self.gauges,
            &mut self.loads,
            &mut self.poses,
        ];
        for values in lists {
            let width = values.len().checked_div(n_rows).unwrap_or(0);
            let mut kept = 0;
            for row in (0..n_rows).filter(|row| is_kept(*row)) {
                values.copy_within(row * width..(row + 1) * width, kept * width);
                kept += 1;
            }
            values.truncate(kept * width);
        }
    }

    /// From now on these rows, in order, are the first, the second and so on; only their lines move.
    pub(super) fn keep_lines_of(&mut self, rows: impl Iterator<Item = usize>) {
        let before = Self {
            lines: std::mem::take(&mut self.lines),
            ..Self::default()
        };
        for (new, old) in rows.enumerate() {
            self.place_row(new, before.line_of(old));
        }
    }
}

/// What is wrong with a cell, if anything is.
fn trouble(cell: &[u8], usage: Use, index: usize, plan: &Plan) -> Option<Finding> {
    let (column, name) = (index + 1, plan.names[index].clone());
    let value = text(cell);
    match usage {
        Use::Ignored => None,
        _ if cell.is_empty() => Some(Finding::EmptyCell { column, name }),
        Use::TimeText(form) => match form.secs(cell) {
            Some(_) => None,
            None => Some(Finding::NotATime {
                column,
                name,
                value,
            }),
        },
        Use::Status => match ati::reports_error(cell) {
            Some(false) => None,
            Some(true) => Some(Finding::StatusError {
                column,
                name,
                value,
            }),
            None => Some(Finding::NotANumber {
                column,
                name,
                value,
            }),
        },
        Use::Mount { .. } => match mount_in(cell, plan) {
            Some(_) => None,
            None => Some(Finding::UnknownMount {
                column,
                name,
                value,
            }),
        },
        Use::Time | Use::Gauge { .. } | Use::Load { .. } | Use::Pose { .. } => {
            match number_in(cell, plan) {
                None => Some(Finding::NotANumber {
                    column,
                    name,
                    value,
                }),
                Some((number, _)) if is_dropout(number, index, plan) => Some(Finding::Dropout {
                    column,
                    name,
                    value,
                }),
                Some((number, _)) => match in_si(number, usage) {
                    Some(_) => None,
                    None => Some(Finding::NotFinite {
                        column,
                        name,
                        value,
                    }),
                },
            }
        }
    }
}

/// The number in the next cell, however it is written; where a comma had to be read as a decimal point, the first such
/// cell is kept.
#[inline(never)]
fn next_other_number<'a>(
    cells: &mut Cells<'a>,
    index: usize,
    plan: &Plan,
    comma: &mut Option<(usize, &'a [u8])>,
) -> Result<f64, Unusable> {
    let cell = cells.next().ok_or(Unusable)?;
    let (value, has_comma) = number_in(cell, plan).ok_or(Unusable)?;
    if has_comma {
        comma.get_or_insert((index, cell));
    }
    Ok(value)
}

/// The number in the next cell; see [`next_other_number`].
#[inline(always)] // one call per cell of the file: as a call it costs a tenth of all reading
fn next_number<'a>(
    cells: &mut Cells<'a>,
    index: usize,
    plan: &Plan,
    comma: &mut Option<(usize, &'a [u8])>,
) -> Result<f64, Unusable> {
    let value = match cells.next_plain_number(plan.point) {
        Some(value) => value,
        None => next_other_number(cells, index, plan, comma)?,
    };
    if is_dropout(value, index, plan) {
        return Err(Unusable);
    }
    Ok(value)
}

/// The number in a cell, and whether its comma had to be read as a decimal point although none is expected.
fn number_in(cell: &[u8], plan: &Plan) -> Option<(f64, bool)> {
    let with_comma = || decimal_comma_number(cell);
    if plan.point == b',' {
        let is_whole = !cell.contains(&b'.');
        let value = with_comma().or_else(|| is_whole.then(|| number(cell)).flatten())?;
        return Some((value, false));
    }
    match number(cell) {
        Some(value) => Some((value, false)),
        None if plan.delimiter.allows_decimal_comma() => Some((with_comma()?, true)),
        None => None,
    }
}

/// Which mount a cell names.
fn mount_in(cell: &[u8], plan: &Plan) -> Option<f64> {
    let mounts = &plan.pose.as_ref()?.mounts;
    let mount = mounts.iter().position(|name| name.as_bytes() == cell)?;
    Some(mount as f64)
}

fn is_dropout(value: f64, index: usize, plan: &Plan) -> bool {
    !plan.dropouts.is_empty() && plan.dropouts[index].contains(&value)
}

/// The value in SI (times as they are); `None` unless finite.
fn in_si(value: f64, usage: Use) -> Option<f64> {
    let value = match usage {
        Use::Gauge { factor } | Use::Load { factor, .. } | Use::Pose { factor, .. } => {
            value * factor
        }
        _ => value,
    };
    finite(value)
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// The start of a cell, long enough for any message.
fn text(cell: &[u8]) -> String {
    const LONG_ENOUGH_BYTES: usize = 200;
    String::from_utf8_lossy(&cell[..cell.len().min(LONG_ENOUGH_BYTES)]).into_owned()
}

#[cfg(test)]
mod tests {
    use super::super::tests::plan_of_names;
    use super::*;

    #[test]
    fn rows_know_their_lines_across_blocks() {
        let plan = plan_of_names("t,S1");
        let mut rows = Rows::parse(b"0,0\n\n1,1\n", &plan);
        rows.append(Rows::parse(b"2,2\nx,0\n3,3\n4,4", &plan));
        assert_eq!(rows.times, [0.0, 1.0, 2.0, 3.0, 4.0]);
        let lines: Vec<_> = (0..5).map(|row| rows.line_of(row)).collect();
        assert_eq!(lines, [1, 3, 4, 6, 7]);
        assert_eq!((rows.n_lines, rows.n_skipped), (7, 1));
        assert_eq!(rows.lines.len(), 3);
    }

    #[test]
    fn an_unusable_row_leaves_nothing_behind() {
        let plan = plan_of_names("t,S1,S2,Fz,Fx [kN]");
        let rows = Rows::parse(b"0,1,2,3,4\n1,1,nan,3,4\n2,1,2,3,1e306\n3,1,2,3\n", &plan);
        assert_eq!(rows.times, [0.0]);
        assert_eq!(rows.gauges, [1.0, 2.0]);
        assert_eq!(rows.loads, [4000.0, 3.0]);
        assert_eq!(rows.bad_cells, [0, 0, 1, 0, 1]);
        assert_eq!(rows.findings.short_rows(), 1);
    }

    #[test]
    fn rows_that_are_left_out_later_take_their_lines_along() {
        let plan = plan_of_names("t,S1,S2,Fz");
        let mut rows = Rows::parse(b"0,1,2,3\n\n1,4,5,6\n2,7,8,9\n", &plan);
        rows.retain(|row| row != 0);
        assert_eq!(rows.times, [1.0, 2.0]);
        assert_eq!(rows.gauges, [4.0, 5.0, 7.0, 8.0]);
        assert_eq!(rows.loads, [6.0, 9.0]);
        assert_eq!([rows.line_of(0), rows.line_of(1)], [3, 4]);
    }
}
