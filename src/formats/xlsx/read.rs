//! Reads each sheet of a workbook as a table. The header of a table is the row above the first row of numbers. Dates become
//! times.
//!
//! Guarantees: memory is allocated only for filled cells, not for the rectangle that they span, and within the limit for the
//! file. A text shared by several cells is stored once.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::{BufReader, Read, Seek};

use calamine::{Data, Ods, Range, Reader, Xls, Xlsx, XlsxCellReader, XlsxError};
use zip::ZipArchive;

use super::super::columns::{Column, Columns};
use super::super::error::FileError;
use super::super::format::{Budget, COLUMN_LIMIT, Source, SourceFile};
use super::super::parts::{self, Part};
use super::super::text::{Delimiter, TextLayout, detect, lines, locate, times::TimeForm};
use super::Kind;

const FILE: &str = "the workbook";
/// Maximum length of a cell's text that is kept (bytes), which limits memory. Names and values are shorter.
const TEXT_LIMIT_BYTES: usize = 1 << 10;
/// Days from 1899-12-30, the origin of dates in workbooks, to 1970-01-01.
const DAYS_BEFORE_1970: f64 = 25_569.0;
const DAY_SECS: f64 = 86_400.0;

struct Cell {
    row: u32,
    column: u32,
    value: Data,
}

/// Checks the sizes that the archive of a workbook declares, before the crate calamine allocates memory by them.
pub fn check_sizes(archive: &mut ZipArchive<BufReader<SourceFile>>) -> Result<(), FileError> {
    const STRINGS: &str = "xl/sharedStrings.xml";
    for index in 0..archive.len() {
        let Ok(member) = archive.by_index_raw(index) else {
            continue;
        };
        Budget::of_file(member.compressed_size()).take(FILE, member.size(), 1)?;
    }
    let Ok(strings) = archive.by_name(STRINGS) else {
        return Ok(());
    };
    let (n_bytes, mut start) = (strings.size(), Vec::new());
    // If this file of the archive cannot be unpacked, calamine reports that later.
    let _ = strings.take(1 << 10).read_to_end(&mut start);
    let start = String::from_utf8_lossy(&start);
    let count = start.split_once("uniqueCount=\"");
    let count: Option<u64> = count.and_then(|(_, rest)| rest.split('"').next()?.parse().ok());
    match count {
        Some(count) if count > n_bytes => {
            Err(FileError::damaged(STRINGS, format!("{count} texts in {n_bytes} bytes")))
        }
        _ => Ok(()),
    }
}

pub fn columns(
    source: &Source<'_>,
    file: BufReader<SourceFile>,
    kind: Kind,
) -> Result<Columns, FileError> {
    let mut budget = Budget::of_file(source.n_bytes);
    let (mut parts, mut left_out) = (Vec::new(), Vec::new());
    let mut take = |name: String, cells: &[Cell], budget: &mut Budget| {
        source.progress.check()?;
        match table(cells, &name, budget)? {
            Some(columns) => parts.push(Part { name, columns }),
            None => left_out.push(format!("{name} (no table of numbers)")),
        }
        Ok::<(), FileError>(())
    };
    match kind {
        Kind::Xml => {
            let mut workbook = Xlsx::new(file).map_err(damaged)?;
            for name in workbook.sheet_names() {
                let cells = match workbook.worksheet_cells_reader(&name) {
                    Ok(reader) => cells(reader, &name, &mut budget)?,
                    Err(XlsxError::NotAWorksheet(_)) => Vec::new(),
                    Err(error) => return Err(damaged(error)),
                };
                take(name, &cells, &mut budget)?;
            }
        }
        Kind::Old => sheets::<Xls<_>>(file, &mut budget, take)?,
        Kind::OpenDocument => sheets::<Ods<_>>(file, &mut budget, take)?,
    }
    let mut columns = parts::choose(parts, source.parts)?;
    columns.left_out.extend(left_out);
    Ok(columns)
}

/// Reads the sheets of a workbook whose crate reads all of them at once.
fn sheets<R>(
    file: BufReader<SourceFile>,
    budget: &mut Budget,
    mut take: impl FnMut(String, &[Cell], &mut Budget) -> Result<(), FileError>,
) -> Result<(), FileError>
where
    R: Reader<BufReader<SourceFile>, Error: Display>,
{
    let mut workbook = R::new(file).map_err(damaged)?;
    for name in workbook.sheet_names() {
        let range = workbook.worksheet_range(&name).map_err(damaged)?;
        let cells = cells_of_range(&range, &name, budget)?;
        take(name, &cells, budget)?;
    }
    Ok(())
}

fn cells_of_range(
    range: &Range<Data>,
    sheet: &str,
    budget: &mut Budget,
) -> Result<Vec<Cell>, FileError> {
    let n_used = range.used_cells().count() as u64;
    budget.take(sheet, n_used, size_of::<Cell>() as u64)?;
    let cell = |(row, column, value): (usize, usize, &Data)| {
        Some(Cell { row: row as u32, column: column as u32, value: kept(value.clone())? })
    };
    Ok(range.used_cells().filter_map(cell).collect())
}

/// Returns the filled cells of a sheet, row by row from left to right.
fn cells<R: Read + Seek>(
    mut reader: XlsxCellReader<'_, R>,
    sheet: &str,
    budget: &mut Budget,
) -> Result<Vec<Cell>, FileError> {
    let mut cells = Vec::new();
    while let Some(cell) = reader.next_cell().map_err(damaged)? {
        let (row, column) = cell.get_position();
        if let Some(value) = kept(cell.get_value().clone().into()) {
            let text_bytes = if let Data::String(text) = &value { text.len() } else { 0 };
            budget.take(sheet, 1, (size_of::<Cell>() + text_bytes) as u64)?;
            cells.push(Cell { row, column, value });
        }
    }
    cells.reverse();
    cells.sort_by_key(|cell| (cell.row, cell.column));
    cells.dedup_by_key(|cell| (cell.row, cell.column));
    Ok(cells)
}

/// Returns the value of a cell without blanks around it, and a text up to a length that a name or a number can have; `None` if
/// nothing is left.
fn kept(value: Data) -> Option<Data> {
    let Data::String(text) = value else {
        return Some(value).filter(|value| *value != Data::Empty);
    };
    let text = text.trim();
    let text = &text[..text.floor_char_boundary(TEXT_LIMIT_BYTES)];
    (!text.is_empty()).then(|| Data::String(text.to_owned()))
}

fn damaged(error: impl Display) -> FileError {
    FileError::damaged(FILE, error.to_string())
}

/// Returns the text of a cell as in a file of cells that tabs divide, and true if the cell is a date or a time of day. These
/// become seconds. Numbers keep their value.
fn written(value: &Data) -> (String, bool) {
    match value {
        Data::DateTime(when) => {
            // Whole days since 1899 make a date. Smaller numbers are times of day or durations.
            let days = when.as_f64();
            let is_day = days >= 366.0 && !when.is_duration();
            let days = if is_day { days - DAYS_BEFORE_1970 } else { days };
            // A double holds such a date to 0.1 ms only.
            (((days * DAY_SECS * 1e4).round() / 1e4).to_string(), true)
        }
        Data::Int(number) => (number.to_string(), false),
        Data::Float(number) => (number.to_string(), false),
        Data::Bool(value) => (u8::from(*value).to_string(), false),
        other => {
            let text = other.to_string().replace(['\n', '\r'], " ").replace('"', "\"\"");
            (format!("\"{}\"", text.trim()), false)
        }
    }
}

fn cell<'a>(row: &[&'a [u8]], column: usize) -> &'a [u8] {
    row.get(column).copied().unwrap_or_default()
}

/// Returns the table of a sheet, whose header and rows are found as in a text; `None` if it has no table of numbers.
fn table(cells: &[Cell], sheet: &str, budget: &mut Budget) -> Result<Option<Columns>, FileError> {
    let first_column = cells.iter().map(|cell| cell.column).min().unwrap_or(0);
    let rows = || cells.chunk_by(|a, b| a.row == b.row);
    let width = |row: &[Cell]| u64::from(row[row.len() - 1].column - first_column) + 1;
    budget.take(sheet, rows().map(width).sum(), 1)?;
    // Number of dates in each column that has cells.
    let mut n_dates = BTreeMap::<usize, usize>::new();
    let mut text = String::new();
    for row in rows() {
        let mut n_before = 0;
        for cell in row {
            let column = (cell.column - first_column) as usize;
            text.extend(std::iter::repeat_n('\t', column - n_before));
            let (own, is_date) = written(&cell.value);
            text.push_str(&own);
            *n_dates.entry(column).or_default() += usize::from(is_date);
            n_before = column;
        }
        text.push('\n');
    }
    let Some(layout) = detect(text.as_bytes()) else {
        return Ok(None);
    };
    let layout = TextLayout { delimiter: Delimiter::Tab, ..layout };
    let Some(head) = locate(text.as_bytes(), &layout) else {
        return Ok(None);
    };
    let rows = lines(&text.as_bytes()[head.n_bytes..]).filter_map(|line| layout.row(line));
    let rows: Vec<Vec<&[u8]>> =
        rows.map(|row| row.map(|cell| cell.written().unwrap_or_default()).collect()).collect();
    let n_values = rows.len() * n_dates.len().min(COLUMN_LIMIT);
    budget.take(sheet, n_values as u64, size_of::<f64>() as u64)?;
    let number = |cell: &[u8]| layout.number(cell).map(|(number, _)| number);
    let time = |cell: &[u8]| TimeForm::of_all([cell].into_iter())?.secs(cell);
    let mut table = Columns { is_named: layout.header, ..Columns::default() };
    for (column, n_dates) in n_dates {
        let filled = || rows.iter().map(|row| cell(row, column)).filter(|cell| !cell.is_empty());
        let n_numbers = filled().filter_map(number).count();
        let n_numbers = n_numbers.saturating_sub(n_dates);
        let n_times = filled().filter_map(time).count() + n_dates;
        let n_filled = filled().count();
        let is_time = n_times > n_numbers && n_times * 2 > n_filled;
        let name = match head.names.get(column).filter(|name| !name.is_empty()) {
            None if layout.header => format!("column {}", column + 1),
            name => name.cloned().unwrap_or_default(),
        };
        if n_filled == 0 {
            table.left_out.push(format!("{name} (nothing)"));
            continue;
        }
        if !is_time && n_numbers * 2 <= n_filled || table.columns.len() == COLUMN_LIMIT {
            table.left_out.push(format!("{name} (text)"));
            continue;
        }
        let unit =
            head.units.get(column).map_or("", |unit| unit.trim_matches(['[', ']', '(', ')']));
        let value = |row: &Vec<&[u8]>| {
            let cell = cell(row, column);
            time(cell).filter(|_| is_time).or_else(|| number(cell)).unwrap_or(f64::NAN)
        };
        table.columns.push(Column {
            name,
            unit: if is_time { "s" } else { unit }.to_owned(),
            values: rows.iter().map(value).collect(),
            ..Column::default()
        });
    }
    Ok((!table.columns.is_empty()).then_some(table))
}
