//! Reads rows of numbers from blocks of a file. The blocks are independent, so they can be parsed in parallel.
//!
//! Guarantees: every number that is kept is finite. A row is kept completely or not at all. The result does not depend on how
//! the file is divided into blocks.

mod held;
mod values;

use std::ops::Range;

pub(super) use values::is_overload;
use values::{next_value, value_of};

use super::{
    map::ColumnRole,
    plan::{Plan, PlannedColumn},
    warning::{Cause, Findings},
};
use crate::{
    formats::{
        Cell, FileError, Opened, Part, Row,
        text::{Head, ati, lines},
    },
    progress::Progress,
    recording::{
        Axis,
        gap::{gap_by_steps, median_step, steps_of_a_pause},
    },
};

/// Numbers of the rows of a file, in SI units. Only the times stay in the unit of the file.
#[derive(Debug, Default)]
pub struct Rows {
    pub times: Vec<f64>,
    pub gauges: Vec<f64>,
    /// Values of the auxiliary channels. A missing value is NaN until [`Rows::hold_auxiliary`] replaces it.
    pub auxiliary: Vec<f64>,
    pub loads: Vec<f64>,
    /// Values of the channels that are only shown; NaN where a cell has no number.
    pub channels: Vec<f64>,
    /// Numbers of the sensor's orientation in each row. Empty after the loads were computed from them.
    pub poses: Vec<f64>,
    pub findings: Findings,
    pub n_lines: u64,
    pub n_skipped: u64,
    /// For each column, the number of skipped rows in which this column has no finite number.
    pub bad_cells: Vec<u64>,
    /// Number of rows of the table, whether they can be used or not.
    n_table_rows: u64,
    /// True if the times are row numbers, because no column gives the time.
    counts_rows: bool,
    /// Number of seconds that was subtracted from the times.
    pub zero_secs: f64,
    lines: Vec<LineRun>,
    /// Rows in which the last value of an auxiliary channel is older than the longest allowed pause, sorted by channel and
    /// row.
    pub held: Vec<HeldRows>,
}

/// Successive rows in which the last value of an auxiliary channel is older than the longest allowed pause.
#[derive(Debug)]
pub struct HeldRows {
    pub channel: usize,
    pub rows: Range<usize>,
}

/// First of several rows that belong to one group and are on successive lines. Row number `row` of the table is on line
/// `line` of the file.
#[derive(Debug)]
struct LineRun {
    row: usize,
    line: u64,
    group: Box<str>,
}

/// Maximum number of numbers of an orientation, which are those of a rotation matrix.
const WIDEST_POSE: usize = 9;

struct Unusable;

impl Rows {
    pub fn read(
        opened: Opened,
        head: &Head,
        plan: &Plan,
        progress: &Progress,
    ) -> Result<Self, FileError> {
        let mut rows = Self { n_lines: head.n_lines, ..Self::default() };
        let parse = |part: Part<'_>| Self::parse(part, plan);
        opened.read(head, progress, parse, |parts, share| rows.append_all(parts, share, plan))?;
        Ok(rows)
    }

    /// Parses the rows of a block of a file. Lines are counted from the start of the block. Rows of arrays count as lines.
    pub fn parse(part: Part<'_>, plan: &Plan) -> Self {
        let mut rows = Self {
            bad_cells: vec![0; plan.columns.len()],
            counts_rows: plan.time_column.is_none(),
            ..Self::default()
        };
        match part {
            Part::Lines(block) => {
                let mut lines = lines(block).peekable();
                // The number of rows is estimated from the length of the first line. A cell with its delimiter has at least
                // two bytes.
                let first_bytes = lines.peek().map_or(0, |line| line.len());
                let line_bytes = first_bytes.max(2 * plan.columns.len());
                rows.reserve(block.len() / line_bytes + 1, plan);
                let mut rest = block;
                // If an ignored column holds texts in quotes, these may contain line breaks.
                let has_texts = plan.with_role(ColumnRole::Ignore).next().is_some();
                while let Some(line) = lines.next() {
                    let mut text = line;
                    let mut n_lines = 1;
                    if has_texts
                        && memchr::memchr(b'"', line).is_some()
                        && let Some((whole, n_whole)) = whole_row(rest, line.len())
                        && plan.text.row(whole).is_some_and(|row| row.count() == plan.columns.len())
                    {
                        lines.by_ref().take(n_whole - 1).for_each(drop);
                        (text, n_lines) = (whole, n_whole);
                    }
                    rest = rest.get(text.len() + 1..).unwrap_or_default();
                    rows.n_lines += 1;
                    if let Some(row) = plan.text.row(text) {
                        rows.row(row, plan);
                    }
                    rows.n_lines += n_lines as u64 - 1;
                }
            }
            Part::Rows(columns, range) => {
                rows.reserve(range.len(), plan);
                for row in range {
                    rows.n_lines += 1;
                    rows.row(columns.row(row), plan);
                }
            }
        }
        rows
    }

    /// Returns the time of the first row of a block, in the unit of the file, even if the row cannot be used. Returns `count`
    /// if the row number gives the time, and `None` if the row has no time.
    pub fn time_of_first(part: Part<'_>, plan: &Plan, count: f64) -> Option<f64> {
        let time = match part {
            Part::Lines(line) => Self::time_of(plan.text.row(line)?, plan),
            Part::Rows(columns, rows) => Self::time_of(columns.row(rows.start), plan),
        };
        plan.time_column.map_or(Some(count), |_| time)
    }

    /// Returns the time of a row, in the unit of the file. `None` if its cells give no time.
    pub fn time_of<'a>(cells: impl Iterator<Item = Cell<'a>>, plan: &Plan) -> Option<f64> {
        let cells = cells.zip(&plan.columns).enumerate();
        let times = cells.filter(|(_, (_, column))| column.is_time());
        let mut times = times.map(|(at, (cell, _))| Some(value_of(cell, at, plan).ok()?.0));
        let first = times.next()??;
        Some(first + times.sum::<Option<f64>>()?)
    }

    /// Returns the lists of times, gauges, auxiliary values, loads, channels and poses, each with its number of values per row.
    pub fn lists(&mut self) -> [(usize, &mut Vec<f64>); 6] {
        let n_rows = self.times.len();
        let lists = [
            &mut self.times,
            &mut self.gauges,
            &mut self.auxiliary,
            &mut self.loads,
            &mut self.channels,
            &mut self.poses,
        ];
        lists.map(|values| (values.len().checked_div(n_rows).unwrap_or(0), values))
    }

    /// Keeps only the rows with these indices, in this order.
    pub fn arrange(&mut self, order: &[usize]) {
        let before = Self { lines: std::mem::take(&mut self.lines), ..Self::default() };
        for (new, old) in order.iter().enumerate() {
            self.place_row(new, before.line_of(*old), before.group_of(*old));
        }
        for (width, values) in self.lists() {
            let rows = order.iter().flat_map(|row| &values[row * width..][..width]);
            *values = rows.copied().collect();
        }
    }

    /// Sets [`Plan::since`] from the time of the first row, if the times are counted from 1970.
    pub fn plan_zero<'a>(plan: &mut Plan, first: impl Iterator<Item = Cell<'a>>) {
        /// Time (s) above which a clock is taken to count from 1970, and not from the start of a computer.
        const SET_SECS: f64 = 1e8;
        let Some(first) = Self::time_of(first, plan).filter(|first| *first < i64::MAX as f64)
        else {
            return;
        };
        let per_second = plan.per_second.unwrap_or_else(|| {
            let is_set = |unit: &f64| first / unit >= 10.0 * SET_SECS;
            [1e9, 1e6, 1e3].into_iter().find(is_set).unwrap_or(1.0)
        });
        if first / per_second >= SET_SECS {
            // `since` is a whole number of seconds, so that the difference between gauge and reference clock has no rounding
            // error.
            plan.since = ((first / per_second).floor() * per_second) as i64;
        }
    }

    pub fn count_from(&mut self, zero_secs: f64) {
        let later = self.zero_secs - zero_secs;
        self.times.iter_mut().for_each(|time| *time += later);
        self.zero_secs = zero_secs;
    }

    /// Appends the rows of the next blocks, which are this share of the file. The first call reserves memory for the whole
    /// file, because lists that grow later would be copied.
    fn append_all(&mut self, parts: Vec<Self>, share: f64, plan: &Plan) {
        if self.times.is_empty() {
            let n_rows: usize = parts.iter().map(|rows| rows.times.len()).sum();
            // Slightly more memory is reserved than estimated from the first rows.
            let slack = if share < 1.0 { 1.02 } else { 1.0 };
            self.reserve((slack * n_rows as f64 / share) as usize, plan);
        }
        parts.into_iter().for_each(|next| self.append(next));
    }

    fn reserve(&mut self, n_rows: usize, plan: &Plan) {
        let widths = [
            1,
            plan.gauges.names.len(),
            plan.auxiliary.names.len(),
            plan.axes.len(),
            plan.others.names.len(),
            plan.pose_width(),
        ];
        for ((_, values), width) in self.lists().into_iter().zip(widths) {
            values.reserve_exact(n_rows * width);
        }
    }

    fn append(&mut self, mut next: Self) {
        let (n_rows, n_lines) = (self.times.len(), self.n_lines);
        if next.counts_rows {
            let n_before = self.n_table_rows as f64;
            next.times.iter_mut().for_each(|count| *count += n_before);
        }
        for ((_, own), (_, more)) in self.lists().into_iter().zip(next.lists()) {
            own.extend_from_slice(more);
        }
        self.findings.append(next.findings, n_lines);
        self.n_lines += next.n_lines;
        self.n_table_rows += next.n_table_rows;
        self.n_skipped += next.n_skipped;
        self.bad_cells.resize(next.bad_cells.len(), 0);
        for (sum, more) in self.bad_cells.iter_mut().zip(next.bad_cells) {
            *sum += more;
        }
        for run in next.lines {
            self.place_row(n_rows + run.row, n_lines + run.line, &run.group);
        }
    }

    fn run_of(&self, row: usize) -> &LineRun {
        &self.lines[self.lines.partition_point(|run| run.row <= row) - 1]
    }

    pub fn line_of(&self, row: usize) -> u64 {
        let run = self.run_of(row);
        run.line + (row - run.row) as u64
    }

    pub fn group_of(&self, row: usize) -> &str {
        &self.run_of(row).group
    }

    /// Returns the rows at which the value in the group column changes.
    pub fn group_changes(&self) -> Vec<usize> {
        let changes = self.lines.windows(2).filter(|pair| pair[0].group != pair[1].group);
        changes.map(|pair| pair[1].row).collect()
    }

    fn place_row(&mut self, row: usize, line: u64, group: &str) {
        // Most files have no groups. Even then, comparing two empty texts by a function call would take a quarter of the
        // reading time.
        let is_same = |own: &str| own.len() == group.len() && (group.is_empty() || own == group);
        let follows =
            |last: &LineRun| last.line + (row - last.row) as u64 == line && is_same(&last.group);
        if !self.lines.last().is_some_and(follows) {
            self.lines.push(LineRun { row, line, group: group.into() });
        }
    }

    fn row<'a>(&mut self, row: impl Row<'a>, plan: &Plan) {
        let (n_rows, n_gauges) = (self.times.len(), self.gauges.len());
        let (n_auxiliary, n_channels) = (self.auxiliary.len(), self.channels.len());
        match self.keep(row.clone(), plan) {
            Ok(group) => self.place_row(n_rows, self.n_lines, &group),
            Err(Unusable) => {
                self.gauges.truncate(n_gauges);
                self.auxiliary.truncate(n_auxiliary);
                self.channels.truncate(n_channels);
                self.explain(row, plan);
            }
        }
        self.n_table_rows += 1;
    }

    /// Appends the numbers of a row to the lists. Returns the value in the group column, which is empty without groups.
    fn keep<'a>(&mut self, mut row: impl Row<'a>, plan: &Plan) -> Result<String, Unusable> {
        let mut group = String::new();
        let mut loads = [0.0; Axis::ALL.len()];
        let mut pose = [0.0; WIDEST_POSE];
        let mut time = if self.counts_rows { self.n_table_rows as f64 } else { 0.0 };
        let mut comma = None;
        for (index, column) in plan.columns.iter().enumerate() {
            let mut value = || next_value(&mut row, index, plan, &mut comma);
            match column.is {
                ColumnRole::Ignore => {
                    row.next().ok_or(Unusable)?;
                }
                ColumnRole::Gauge => self.gauges.push(value()?),
                ColumnRole::Auxiliary | ColumnRole::Channel => {
                    // An auxiliary channel that is sampled more slowly than the gauges has values only in some rows. So the
                    // row can be used even if the cell is empty.
                    let cell = row.next().ok_or(Unusable)?;
                    let value = value_of(cell, index, plan);
                    let is_auxiliary = column.is == ColumnRole::Auxiliary;
                    let list = if is_auxiliary { &mut self.auxiliary } else { &mut self.channels };
                    list.push(value.map_or(f64::NAN, |(value, _)| value));
                }
                ColumnRole::Load(_) => loads[column.slot] = value()?,
                ColumnRole::Pose(_) => pose[column.slot] = value()?,
                ColumnRole::Status => {
                    value()?;
                }
                ColumnRole::Group => {
                    let cell = row.next().filter(|cell| !cell.is_blank());
                    group = cell.ok_or(Unusable)?.text();
                }
                _ => time += value()?,
            }
        }
        self.times.push(time);
        self.loads.extend_from_slice(&loads[..plan.axes.len()]);
        self.poses.extend_from_slice(&pose[..plan.pose_width()]);
        if let Some((index, cell)) = comma {
            let cause = Cause::DecimalComma { column: plan.column(index), value: cell.shown() };
            self.findings.note(self.n_lines, cause);
        }
        let n_extra = row.filter(|cell| !cell.is_blank()).count();
        if n_extra > 0 {
            let expected = plan.columns.len();
            let actual = expected + n_extra;
            let cause = Cause::TooManyCells { expected, actual };
            self.findings.note(self.n_lines, cause);
        }
        Ok(group)
    }

    /// Reports why a row cannot be kept. Only the first reason becomes a warning, but every cell without a number is counted.
    fn explain<'a>(&mut self, row: impl Row<'a>, plan: &Plan) {
        let is_used = |(_, column): &(Cell<'_>, &PlannedColumn)| {
            !column.is_time() && !matches!(column.is, ColumnRole::Ignore | ColumnRole::Group)
        };
        let mut used = row.clone().zip(&plan.columns).filter(is_used);
        if plan.may_be_blank && used.all(|(cell, _)| cell.is_blank()) {
            return;
        }
        self.n_skipped += 1;
        let (expected, actual) = (plan.columns.len(), row.clone().count());
        if actual < expected {
            let cause = Cause::TooFewCells { expected, actual };
            return self.findings.note(self.n_lines, cause);
        }
        let mut first = None;
        for (index, (cell, column)) in row.zip(&plan.columns).enumerate() {
            if let Err(trouble) = value_of(cell, index, plan)
                && !column.may_be_missing()
            {
                self.bad_cells[index] += u64::from(!trouble.is_wanted());
                first.get_or_insert_with(|| Cause::Cell {
                    column: plan.column(index),
                    value: cell.shown(),
                    trouble,
                });
            }
        }
        if let Some(cause) = first {
            self.findings.note(self.n_lines, cause);
        }
    }

    pub fn leave_out(&mut self, is_kept: impl Fn(usize) -> bool, cause: Cause) {
        let missing = || (0..self.times.len()).filter(|row| !is_kept(*row));
        if let (Some(first), Some(last)) = (missing().next(), missing().next_back()) {
            let count = missing().count() as u64;
            self.note_rows(first, last, count, cause);
            self.retain(is_kept);
        }
    }

    pub fn note_row(&mut self, row: usize, cause: Cause) {
        self.findings.note(self.line_of(row), cause);
    }

    pub fn note_rows(&mut self, first: usize, last: usize, count: u64, cause: Cause) {
        let (first, last) = (self.line_of(first), self.line_of(last));
        self.findings.note_many(first, last, count, cause);
    }

    pub fn retain(&mut self, is_kept: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.times.len()).filter(|row| is_kept(*row)).collect();
        self.arrange(&kept);
    }
}

/// Returns the first row of a text and its number of lines, if a cell in quotes contains line breaks. `first` is the length
/// of the first line.
fn whole_row(text: &[u8], first: usize) -> Option<(&[u8], usize)> {
    const LINES: usize = 10;
    let (mut end, mut n_lines) = (first, 1);
    while text[..end].iter().filter(|byte| **byte == b'"').count() % 2 == 1 {
        let more = text.get(end + 1..).filter(|_| n_lines < LINES)?;
        end += 1 + memchr::memchr(b'\n', more).unwrap_or(more.len());
        n_lines += 1;
    }
    (n_lines > 1).then_some((&text[..end], n_lines))
}

#[cfg(test)]
mod tests {
    use super::super::tests::plan_of_names;
    use super::*;

    #[test]
    fn rows_know_their_lines_across_blocks() {
        let plan = plan_of_names("t,S1");
        let mut rows = Rows::parse(Part::Lines(b"0,0\n\n1,1\n"), &plan);
        rows.append(Rows::parse(Part::Lines(b"2,2\nx,0\n3,3\n4,4"), &plan));
        assert_eq!(rows.times, [0.0, 1.0, 2.0, 3.0, 4.0]);
        let lines: Vec<_> = (0..5).map(|row| rows.line_of(row)).collect();
        assert_eq!(lines, [1, 3, 4, 6, 7]);
        assert_eq!((rows.n_lines, rows.n_skipped), (7, 1));
        assert_eq!(rows.lines.len(), 3);
    }

    #[test]
    fn an_unusable_row_leaves_no_values_behind() {
        let plan = plan_of_names("t,S1,S2,Fz,Fx [kN]");
        let rows =
            Rows::parse(Part::Lines(b"0,1,2,3,4\n1,1,nan,3,4\n2,1,2,3,1e306\n3,1,2,3\n"), &plan);
        assert_eq!(rows.times, [0.0]);
        assert_eq!(rows.gauges, [1.0, 2.0]);
        assert_eq!(rows.loads, [4000.0, 3.0]);
        assert_eq!(rows.bad_cells, [0, 0, 1, 0, 1]);
        assert_eq!(rows.findings.short_rows(), 1);
    }

    #[test]
    fn rows_removed_later_take_their_lines_along() {
        let plan = plan_of_names("t,S1,S2,Fz");
        let mut rows = Rows::parse(Part::Lines(b"0,1,2,3\n\n1,4,5,6\n2,7,8,9\n"), &plan);
        rows.retain(|row| row != 0);
        assert_eq!(rows.times, [1.0, 2.0]);
        assert_eq!(rows.gauges, [4.0, 5.0, 7.0, 8.0]);
        assert_eq!(rows.loads, [6.0, 9.0]);
        assert_eq!([rows.line_of(0), rows.line_of(1)], [3, 4]);
    }
}
