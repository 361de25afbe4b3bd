//! Reads each sheet of a workbook as a table. The header of a table is the row above the first row of numbers. Dates become
//! times.
//!
//! Guarantees: memory is allocated only for filled cells, not for the rectangle that they span, and within the limit for the
//! file. A text shared by several cells is stored once.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::{BufReader, Read, Seek};

use calamine::{Data, Ods, Range, Reader, Xls, Xlsx, XlsxCellReader, XlsxError};
use zip::ZipArchive;

use super::super::column_name::is_known_unit;
use super::super::columns::{Column, Columns};
use super::super::error::FileError;
use super::super::format::{Budget, COLUMN_LIMIT, Source, SourceFile};
use super::super::parts::{self, Part};
use super::super::text::times::TimeForm;
use super::Kind;

const FILE: &str = "the workbook";
/// Number of first rows of a sheet in which the first row of numbers is searched.
const HEADER_LIMIT: u32 = 100;
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

fn is_text(cell: &Cell) -> bool {
    matches!(cell.value, Data::String(_))
}

/// Returns true if a row holds samples, that is more values than texts. `has_numbers` is true if the sheet holds numbers.
fn is_row(row: &[Cell], has_numbers: bool) -> bool {
    // In some columns, numbers are stored as texts. In a sheet with numbers, a row of such texts alone may be a header.
    let are_texts = has_numbers && row.iter().all(is_text);
    let is_word = |cell: &&Cell| {
        is_text(cell) && time(&cell.value).is_none() && (are_texts || number(&cell.value).is_none())
    };
    let n_texts = row.iter().filter(is_word).count();
    let n_values = row
        .iter()
        .filter(|cell| number(&cell.value).or_else(|| time(&cell.value)).is_some())
        .count();
    n_values > n_texts
}

fn number(value: &Data) -> Option<f64> {
    match value {
        Data::Int(value) => Some(*value as f64),
        Data::Float(value) => Some(*value),
        Data::Bool(value) => Some(f64::from(*value)),
        Data::String(_) => text(value).parse().ok(),
        _ => None,
    }
}

/// Returns the time in a cell (s): since 1970 for a date, else a time of day or a duration; `None` for another cell.
fn time(value: &Data) -> Option<f64> {
    match value {
        Data::DateTime(when) => {
            let days = when.as_f64();
            // A value below a year is a time of day or a duration and has no date.
            let is_day = days >= 366.0 && !when.is_duration();
            let days = if is_day { days - DAYS_BEFORE_1970 } else { days };
            // Dates in workbooks are accurate to 0.1 ms, so other digits are rounded.
            Some((days * DAY_SECS * 1e4).round() / 1e4)
        }
        Data::DateTimeIso(_) | Data::String(_) => {
            let text = text(value);
            TimeForm::of_all([text.as_bytes()].into_iter())?.secs(text.as_bytes())
        }
        _ => None,
    }
}

fn text(value: &Data) -> Cow<'_, str> {
    match value {
        Data::String(text) | Data::DateTimeIso(text) | Data::DurationIso(text) => {
            text.trim().into()
        }
        Data::Empty => "".into(),
        other => other.to_string().into(),
    }
}

/// Returns the row with column names and the row with units above a table, if there are any.
fn header_and_units<'a>(above: &[&'a [Cell]]) -> (Option<&'a [Cell]>, Option<&'a [Cell]>) {
    let mut above = above.iter().copied().rev();
    let nearest = above.next().filter(|row| row.iter().any(is_text));
    let is_units = |row: &[Cell]| {
        row.iter()
            .map(|cell| text(&cell.value))
            .any(|unit| is_known_unit(unit.trim_matches(['[', ']', '(', ')'])))
    };
    let is_named = |row: &[Cell]| row.iter().filter(|cell| is_text(cell)).count() > 1;
    match (nearest, above.next()) {
        (Some(units), Some(header)) if is_units(units) && is_named(header) => {
            (Some(header), Some(units))
        }
        (header, _) => (header, None),
    }
}

fn table(cells: &[Cell], sheet: &str, budget: &mut Budget) -> Result<Option<Columns>, FileError> {
    let rows: Vec<&[Cell]> = cells.chunk_by(|a, b| a.row == b.row).collect();
    let row_number = |at: usize| rows[at][0].row;
    let has_numbers = cells.iter().any(|cell| !is_text(cell));
    let is_first = |&at: &usize| {
        let following = (at..rows.len()).take_while(|&next| row_number(next) - row_number(at) < 3);
        following.into_iter().all(|next| is_row(rows[next], has_numbers))
    };
    let mut starts =
        (0..rows.len()).take_while(|&at| row_number(at) - row_number(0) < HEADER_LIMIT);
    let Some(first) = starts.find(is_first) else {
        return Ok(None);
    };
    let (header, units) = header_and_units(&rows[..first]);
    let cell_text = |row: Option<&[Cell]>, column: u32| {
        let row = row.unwrap_or_default();
        let at = row.binary_search_by_key(&column, |cell| cell.column);
        at.map_or(String::new(), |at| text(&row[at].value).into_owned())
    };
    let samples = &rows[first..];
    // Filled cells of each column below the header, with the index of their row.
    let mut cells_of: BTreeMap<u32, Vec<(usize, &Data)>> = BTreeMap::new();
    for cell in header.into_iter().flatten() {
        cells_of.insert(cell.column, Vec::new());
    }
    for (at, row) in samples.iter().enumerate() {
        for cell in *row {
            cells_of.entry(cell.column).or_default().push((at, &cell.value));
        }
    }
    let n_values = samples.len() as u64 * cells_of.len().min(COLUMN_LIMIT) as u64;
    budget.take(sheet, n_values, size_of::<f64>() as u64)?;
    // Lines have the numbers of the sheet's rows.
    let n_lines = u64::from(row_number(first));
    let mut table = Columns { is_named: header.is_some(), n_lines, ..Columns::default() };
    let first_column = cells.iter().map(|cell| cell.column).min().unwrap_or(0);
    for (column, cells) in cells_of {
        let name = match (table.is_named, cell_text(header, column)) {
            (true, name) if name.is_empty() => format!("column {}", column - first_column + 1),
            (_, name) => name,
        };
        let count = |of: fn(&Data) -> Option<f64>| {
            cells.iter().filter(|(_, value)| of(value).is_some()).count()
        };
        let (n_numbers, n_times) = (count(number), count(time));
        let is_time = n_times > n_numbers && n_times * 2 > cells.len();
        if cells.is_empty() {
            table.left_out.push(format!("{name} (nothing)"));
        } else if (!is_time && n_numbers * 2 <= cells.len()) || table.columns.len() == COLUMN_LIMIT
        {
            table.left_out.push(format!("{name} (text)"));
        } else {
            let unit = cell_text(units, column);
            let unit = unit.trim_matches(['[', ']', '(', ')']);
            let mut values = vec![f64::NAN; samples.len()];
            let mut texts = Vec::new();
            for (at, value) in cells {
                match if is_time { time(value) } else { number(value) } {
                    Some(number) => values[at] = number,
                    None => texts.push((at, text(value).into_owned())),
                }
            }
            let unit = if is_time { "s" } else { unit }.to_owned();
            let texts = Some(texts);
            table.columns.push(Column { name, unit, values, texts, ..Column::default() });
        }
    }
    Ok((!table.columns.is_empty()).then_some(table))
}
