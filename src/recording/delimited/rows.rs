//! Rows of numbers from blocks of lines. Blocks know nothing of each other, so they can be parsed at the same time.
//!
//! Guarantees: every number kept is finite; a row is kept whole or not at all; joining the rows of two blocks gives
//! what one block with the lines of both would have given.

use super::cells::{Cells, Delimiter, decimal_comma_number, is_skipped, number};
use super::header::{Header, Use};
use super::warning::Finding;
use super::warning::Findings;
use crate::recording::Axis;

/// The rows of a stretch of lines, in SI but for the times, which stay in the unit of the file.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub(super) times: Vec<f64>,
    /// Row-major.
    pub(super) gauges: Vec<f64>,
    /// Row-major, in axis order.
    pub(super) loads: Vec<f64>,
    pub(super) findings: Findings,
    pub(super) n_bytes: usize,
    pub(super) n_lines: u64,
    pub(super) n_skipped: u64,
    /// Per column, in how many skipped rows it holds no finite number.
    pub(super) bad_cells: Vec<u64>,
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
    /// The rows among the lines of `block`, line 1 being its first.
    pub(super) fn parse(block: &[u8], header: &Header) -> Self {
        let mut rows = Self {
            n_bytes: block.len(),
            bad_cells: vec![0; header.uses.len()],
            ..Self::default()
        };
        let mut rest = block;
        while !rest.is_empty() {
            let end = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
            let line = &rest[..end];
            if rows.n_lines == 0 {
                // As many rows as if all lines were like the first, but never more than fit with one digit a cell.
                let line_bytes = line.len().max(2 * header.uses.len());
                rows.reserve(block.len() / line_bytes + 1, header);
            }
            rest = rest.get(end + 1..).unwrap_or_default();
            rows.n_lines += 1;
            if is_skipped(line) {
                continue;
            }
            rows.line(line.strip_suffix(b"\r").unwrap_or(line), header);
        }
        rows
    }

    /// Makes room for about `n_rows` rows more.
    pub(super) fn reserve(&mut self, n_rows: usize, header: &Header) {
        self.times.reserve_exact(n_rows);
        self.gauges.reserve_exact(n_rows * header.gauge_names.len());
        self.loads.reserve_exact(n_rows * header.axes.len());
    }

    /// Appends the rows of the block that follows.
    pub(super) fn append(&mut self, next: Self) {
        let (n_rows, n_lines) = (self.times.len(), self.n_lines);
        self.times.extend_from_slice(&next.times);
        self.gauges.extend_from_slice(&next.gauges);
        self.loads.extend_from_slice(&next.loads);
        self.findings.append(next.findings, n_lines);
        self.n_bytes += next.n_bytes;
        self.n_lines += next.n_lines;
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

    fn line(&mut self, line: &[u8], header: &Header) {
        let (n_rows, n_gauges, n_loads) = (self.times.len(), self.gauges.len(), self.loads.len());
        match self.keep(line, header) {
            Ok(()) => self.place_row(n_rows, self.n_lines),
            Err(Unusable) => {
                self.times.truncate(n_rows);
                self.gauges.truncate(n_gauges);
                self.loads.truncate(n_loads);
                self.explain(line, header);
            }
        }
    }

    fn keep(&mut self, line: &[u8], header: &Header) -> Result<(), Unusable> {
        let mut cells = Cells::new(line, header.delimiter);
        let mut loads = [0.0; Axis::ALL.len()];
        let mut comma = None;
        for (index, usage) in header.uses.iter().enumerate() {
            if *usage == Use::Ignored {
                cells.next().ok_or(Unusable)?;
                continue;
            }
            let value = match cells.next_plain_number() {
                Some(value) => value,
                None => {
                    let cell = cells.next().ok_or(Unusable)?;
                    match number(cell) {
                        Some(value) => value,
                        None => {
                            comma = comma.or(Some((index, cell)));
                            comma_number(cell, header.delimiter).ok_or(Unusable)?
                        }
                    }
                }
            };
            let value = in_si(value, *usage).ok_or(Unusable)?;
            match *usage {
                Use::Ignored => {}
                Use::Time => self.times.push(value),
                Use::Gauge => self.gauges.push(value),
                Use::Load { slot, .. } => loads[slot] = value,
            }
        }
        self.loads.extend_from_slice(&loads[..header.axes.len()]);
        if let Some((index, cell)) = comma {
            let finding = Finding::DecimalComma {
                column: index + 1,
                name: header.names[index].clone(),
                value: text(cell),
            };
            self.findings.note(self.n_lines, finding);
        }
        let n_extra = cells.count();
        if n_extra > 0 {
            let expected = header.uses.len();
            let actual = expected + n_extra;
            let finding = Finding::TooManyCells { expected, actual };
            self.findings.note(self.n_lines, finding);
        }
        Ok(())
    }

    /// Notes why a row cannot be kept: the first reason as a finding, all bad cells as counts.
    fn explain(&mut self, line: &[u8], header: &Header) {
        self.n_skipped += 1;
        let cells = Cells::new(line, header.delimiter);
        let (expected, actual) = (header.uses.len(), cells.clone().count());
        if actual < expected {
            let finding = Finding::TooFewCells { expected, actual };
            self.findings.note(self.n_lines, finding);
            return;
        }
        let mut first = None;
        for (index, (cell, usage)) in cells.zip(&header.uses).enumerate() {
            if *usage == Use::Ignored {
                continue;
            }
            let value = number(cell).or_else(|| comma_number(cell, header.delimiter));
            if value.is_some_and(|value| in_si(value, *usage).is_some()) {
                continue;
            }
            self.bad_cells[index] += 1;
            let (column, name) = (index + 1, &header.names[index]);
            first.get_or_insert_with(|| match value {
                _ if cell.is_empty() => Finding::EmptyCell {
                    column,
                    name: name.clone(),
                },
                None => Finding::NotANumber {
                    column,
                    name: name.clone(),
                    value: text(cell),
                },
                Some(_) => Finding::NotFinite {
                    column,
                    name: name.clone(),
                    value: text(cell),
                },
            });
        }
        if let Some(finding) = first {
            self.findings.note(self.n_lines, finding);
        }
    }
}

fn comma_number(cell: &[u8], delimiter: Delimiter) -> Option<f64> {
    delimiter
        .allows_decimal_comma()
        .then(|| decimal_comma_number(cell))
        .flatten()
}

/// The value in SI (times as they are); `None` unless finite.
fn in_si(value: f64, usage: Use) -> Option<f64> {
    let value = match usage {
        Use::Load { factor, .. } => value * factor,
        _ => value,
    };
    value.is_finite().then_some(value)
}

/// The start of a cell, long enough for any message.
fn text(cell: &[u8]) -> String {
    const LONG_ENOUGH_BYTES: usize = 200;
    String::from_utf8_lossy(&cell[..cell.len().min(LONG_ENOUGH_BYTES)]).into_owned()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn header(text: &str) -> Header {
        Header::parse(Path::new("a.csv"), 1, text.as_bytes())
            .unwrap()
            .0
    }

    #[test]
    fn rows_know_their_lines_across_blocks() {
        let header = header("t,S1");
        let mut rows = Rows::parse(b"0,0\n\n1,1\n", &header);
        rows.append(Rows::parse(b"2,2\nx,0\n3,3\n4,4", &header));
        assert_eq!(rows.times, [0.0, 1.0, 2.0, 3.0, 4.0]);
        let lines: Vec<_> = (0..5).map(|row| rows.line_of(row)).collect();
        assert_eq!(lines, [1, 3, 4, 6, 7]);
        assert_eq!((rows.n_lines, rows.n_skipped), (7, 1));
        assert_eq!(rows.lines.len(), 3);
    }

    #[test]
    fn an_unusable_row_leaves_nothing_behind() {
        let header = header("t,S1,S2,Fz,Fx [kN]");
        let rows = Rows::parse(b"0,1,2,3,4\n1,1,nan,3,4\n2,1,2,3,1e306\n3,1,2,3\n", &header);
        assert_eq!(rows.times, [0.0]);
        assert_eq!(rows.gauges, [1.0, 2.0]);
        assert_eq!(rows.loads, [4000.0, 3.0]);
        assert_eq!(rows.bad_cells, [0, 0, 1, 0, 1]);
        assert_eq!(rows.findings.short_rows(), 1);
    }
}
