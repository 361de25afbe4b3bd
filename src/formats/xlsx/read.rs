//! Each sheet as a table: its header is what stands above the first row of numbers; dates are times.

use std::io::BufReader;

use calamine::{Data, Range, Reader as _, Xlsx, XlsxError};

use super::super::column_name::is_known_unit;
use super::super::columns::{Column, Columns};
use super::super::error::FileError;
use super::super::format::{COLUMN_LIMIT, Source};
use super::super::parts::{self, Part};
use super::super::text::times::TimeForm;
use crate::recording::Day;

const FILE: &str = "the workbook";
/// The first row of numbers stands among so many.
const HEADER_LIMIT: usize = 100;
/// The day from which a workbook counts, before the first of 1970 (days).
const DAYS_BEFORE_1970: f64 = 25_569.0;
const DAY_SECS: f64 = 86_400.0;

/// The sheets of a workbook as a table.
pub(super) fn columns(source: &Source<'_>) -> Result<Columns, FileError> {
    let file = BufReader::new(source.open()?);
    let mut workbook = Xlsx::new(file).map_err(damaged)?;
    let (mut parts, mut left_out) = (Vec::new(), Vec::new());
    for name in workbook.sheet_names() {
        source.progress.check()?;
        let sheet = workbook.worksheet_range(&name).map_err(damaged)?;
        match table(&sheet) {
            Some(columns) => parts.push(Part { name, columns }),
            None => left_out.push(format!("{name} (no numbers in rows)")),
        }
    }
    let mut columns = parts::choose(parts, source.parts)?;
    columns.left_out.extend(left_out);
    Ok(columns)
}

fn damaged(error: XlsxError) -> FileError {
    FileError::Damaged {
        what: FILE.to_owned(),
        why: error.to_string(),
    }
}

fn is_text(cell: &Data) -> bool {
    matches!(cell, Data::String(text) if !text.trim().is_empty())
}

/// Whether a row holds samples: more values than texts.
fn is_row(row: &[Data]) -> bool {
    let n_texts = row
        .iter()
        .filter(|cell| is_text(cell) && time(cell).is_none())
        .count();
    let n_values = row
        .iter()
        .filter(|cell| number(cell).or_else(|| time(cell)).is_some())
        .count();
    n_values > n_texts
}

/// The number in a cell.
fn number(cell: &Data) -> Option<f64> {
    match cell {
        Data::Int(value) => Some(*value as f64),
        Data::Float(value) => Some(*value),
        Data::Bool(value) => Some(f64::from(u8::from(*value))),
        Data::String(text) => text.trim().parse().ok(),
        _ => None,
    }
}

/// The time in a cell (s).
fn time(cell: &Data) -> Option<f64> {
    match cell {
        Data::DateTime(when) => {
            let days = when.as_f64();
            // A time of day, or a duration, has no day.
            let is_day = days >= 366.0 && !when.is_duration();
            let days = if is_day {
                days - DAYS_BEFORE_1970
            } else {
                days
            };
            // What is stored has no more digits than this.
            Some((days * DAY_SECS * 1e4).round() / 1e4)
        }
        Data::DateTimeIso(text) | Data::String(text) => {
            let text = text.trim().as_bytes();
            TimeForm::of_all([text].into_iter())?.secs(text)
        }
        _ => None,
    }
}

fn text(cell: &Data) -> String {
    match cell {
        Data::String(text) => text.trim().to_owned(),
        Data::Empty => String::new(),
        other => other.to_string(),
    }
}

fn is_blank(row: &[Data]) -> bool {
    row.iter().all(|cell| text(cell).is_empty())
}

/// The day that a row above the table says: what it is called in one cell, itself in the next.
fn day(row: &[Data]) -> Option<Day> {
    let written = |cell: &Data| match cell {
        Data::DateTime(when) if when.as_f64() >= 366.0 && !when.is_duration() => {
            Day::of_clock(time(cell)?).map(|day| day.to_string())
        }
        other => Some(text(other)).filter(|text| !text.is_empty()),
    };
    let cells: Vec<String> = row.iter().filter_map(written).collect();
    Day::in_header(&cells.join(": "))
}

/// What a sheet holds; `None` if there is no row of numbers.
fn table(sheet: &Range<Data>) -> Option<Columns> {
    let rows: Vec<&[Data]> = sheet.rows().collect();
    let is_first = |at: &usize| {
        let following = rows[*at..].iter().take(3);
        following
            .filter(|row| !is_blank(row))
            .all(|row| is_row(row))
            && is_row(rows[*at])
    };
    let first = (0..rows.len().min(HEADER_LIMIT)).find(is_first)?;
    let mut above = rows[..first].iter().rev().filter(|row| !is_blank(row));
    let is_header = |row: &&&[Data]| row.iter().any(is_text);
    let nearest = above.next().filter(is_header);
    let is_units = |row: &&[Data]| {
        let mut units = row.iter().map(text).filter(|unit| !unit.is_empty());
        units.any(|unit| is_known_unit(unit.trim_matches(['[', ']', '(', ')'])))
    };
    let (header, units) = match (nearest, above.next()) {
        (Some(units), Some(header))
            if is_units(units) && header.iter().filter(|c| is_text(c)).count() > 1 =>
        {
            (Some(header), Some(units))
        }
        (header, _) => (header, None),
    };
    let samples: Vec<&[Data]> = rows[first..]
        .iter()
        .copied()
        .filter(|row| !is_blank(row))
        .collect();
    let mut table = Columns {
        is_named: header.is_some(),
        day: rows[..first].iter().find_map(|row| day(row)),
        ..Columns::default()
    };
    for index in 0..sheet.width() {
        let cells = || samples.iter().filter_map(|row| row.get(index));
        let name = header
            .and_then(|row| row.get(index))
            .map(text)
            .unwrap_or_default();
        let n_filled = cells().filter(|cell| !text(cell).is_empty()).count();
        if n_filled == 0 {
            if !name.is_empty() {
                table.left_out.push(format!("{name} (nothing)"));
            }
            continue;
        }
        let count =
            |of: fn(&Data) -> Option<f64>| cells().filter(|cell| of(cell).is_some()).count();
        let (n_numbers, n_times) = (count(number), count(time));
        let is_time = n_times > n_numbers && n_times * 2 > n_filled;
        if (!is_time && n_numbers * 2 <= n_filled) || table.columns.len() == COLUMN_LIMIT {
            table.left_out.push(format!("{name} (text)"));
            continue;
        }
        let of = if is_time { time } else { number };
        let unit = units
            .and_then(|row| row.get(index))
            .map(text)
            .unwrap_or_default();
        let unit = unit.trim_matches(['[', ']', '(', ')']).to_owned();
        table.columns.push(Column {
            name: match (table.is_named, name.is_empty()) {
                (true, true) => format!("column {}", index + 1),
                _ => name,
            },
            unit: if is_time { "s".to_owned() } else { unit },
            values: cells().map(|cell| of(cell).unwrap_or(f64::NAN)).collect(),
        });
    }
    (!table.columns.is_empty()).then_some(table)
}
