//! Reads the numbers in the cells of a row, and converts them to SI units.

use super::*;
use crate::import::{plan::PlannedColumn, warning::Trouble};

/// Returns the number in the next cell of the row, in SI units. If a comma in the cell was read as a decimal point, stores
/// the cell in `comma`.
#[inline(always)] // one call per cell of the file: as a call it costs a tenth of all reading
pub fn next_value<'a>(
    row: &mut impl Row<'a>,
    index: usize,
    plan: &Plan,
    comma: &mut Option<(usize, Cell<'a>)>,
) -> Result<f64, Unusable> {
    let column = &plan.columns[index];
    let plain =
        if column.is_number() && !plan.is_since_off(index) { row.next_number() } else { None };
    match plain {
        Some(number) => in_si(number, column).map_err(|_| Unusable),
        None => {
            let cell = row.next().ok_or(Unusable)?;
            other_value(cell, index, plan, comma)
        }
    }
}

/// Does the work of [`next_value`] for a cell that is not a plain number.
#[inline(never)]
fn other_value<'a>(
    cell: Cell<'a>,
    index: usize,
    plan: &Plan,
    comma: &mut Option<(usize, Cell<'a>)>,
) -> Result<f64, Unusable> {
    let (value, has_comma) = value_of(cell, index, plan).map_err(|_| Unusable)?;
    if has_comma {
        comma.get_or_insert((index, cell));
    }
    Ok(value)
}

/// Returns the number in a cell, and true if a comma was read as a decimal point. Otherwise returns the reason why there is
/// no number.
pub fn value_of(cell: Cell<'_>, index: usize, plan: &Plan) -> Result<(f64, bool), Trouble> {
    let column = &plan.columns[index];
    match (column.is, column.form) {
        (ColumnRole::Ignore, _) => Ok((0.0, false)),
        _ if cell.is_empty() => Err(Trouble::Empty),
        (_, Some(form)) => {
            let since = plan.since_of(index);
            let secs = cell.written().and_then(|text| form.secs_since(since, text));
            Ok((secs.ok_or(Trouble::NotATime)?, false))
        }
        (ColumnRole::Status, _) => match ati::reports_error(cell) {
            Some(false) => Ok((0.0, false)),
            Some(true) => Err(Trouble::StatusError),
            None => Err(Trouble::NotANumber),
        },
        (ColumnRole::Group, _) if cell.is_blank() => Err(Trouble::Empty),
        (ColumnRole::Group, _) => Ok((0.0, false)),
        _ => {
            let since = plan.since_of(index);
            let number = match cell {
                Cell::Number(number) => Some((number - since as f64, false)),
                Cell::Since(own, number) => Some(((own - since) as f64 + number, false)),
                Cell::Text(text) if since == 0 => plan.text.number(text),
                Cell::Text(text) => plan.text.number_since(since, text),
            };
            let (number, has_comma) = number.ok_or(Trouble::NotANumber)?;
            Ok((in_si(number, column)?, has_comma))
        }
    }
}

/// Returns true for the numbers by which meters mark an overload (9.9E+37) or a missing value (9.91E+37).
pub fn is_overload(number: f64) -> bool {
    (9.9e37..=1e38).contains(&number.abs())
}

/// Converts a number from a cell to SI units. Times are not converted.
#[inline(always)]
fn in_si(number: f64, column: &PlannedColumn) -> Result<f64, Trouble> {
    if column.dropouts.contains(&number) {
        return Err(Trouble::Dropout);
    }
    if is_overload(number) && !column.is_time() {
        return Err(Trouble::Overload);
    }
    let value = number * column.factor + column.shift;
    if value.is_finite() { Ok(value) } else { Err(Trouble::NotFinite) }
}
