//! Reads the numbers in the cells of a row, and converts them to SI units.

use super::*;
use crate::import::warning::Trouble;

/// Returns the number in the next cell of the row, in SI units. If a comma in the cell was read as a decimal point, stores
/// the cell in `comma`.
#[inline(always)] // one call per cell of the file: as a call it costs a tenth of all reading
pub fn next_value<'a>(
    row: &mut impl Row<'a>,
    usage: Use,
    index: usize,
    plan: &Plan,
    comma: &mut Option<(usize, Cell<'a>)>,
) -> Result<f64, Unusable> {
    let plain =
        if usage.is_number() && !plan.is_since_off(index) { row.next_number() } else { None };
    match plain {
        Some(number) => in_si(number, usage, index, plan).map_err(|_| Unusable),
        None => {
            let cell = row.next().ok_or(Unusable)?;
            other_value(cell, usage, index, plan, comma)
        }
    }
}

/// Does the work of [`next_value`] for a cell that is not a plain number.
#[inline(never)]
fn other_value<'a>(
    cell: Cell<'a>,
    usage: Use,
    index: usize,
    plan: &Plan,
    comma: &mut Option<(usize, Cell<'a>)>,
) -> Result<f64, Unusable> {
    let (value, has_comma) = value_of(cell, usage, index, plan).map_err(|_| Unusable)?;
    if has_comma {
        comma.get_or_insert((index, cell));
    }
    Ok(value)
}

/// Returns the number in a cell, and true if a comma was read as a decimal point. Otherwise returns the reason why there is
/// no number.
pub fn value_of(
    cell: Cell<'_>,
    usage: Use,
    index: usize,
    plan: &Plan,
) -> Result<(f64, bool), Trouble> {
    match usage {
        Use::Ignored => Ok((0.0, false)),
        _ if cell.is_empty() => Err(Trouble::Empty),
        Use::TimeText(form) => {
            let since = plan.since_of(index);
            let secs = cell.written().and_then(|text| form.secs_since(since, text));
            Ok((secs.ok_or(Trouble::NotATime)?, false))
        }
        Use::Status => match ati::reports_error(cell) {
            Some(false) => Ok((0.0, false)),
            Some(true) => Err(Trouble::StatusError),
            None => Err(Trouble::NotANumber),
        },
        Use::Group if cell.is_blank() => Err(Trouble::Empty),
        Use::Group => Ok((0.0, false)),
        Use::Mount { .. } => Ok((mount(cell, plan).ok_or(Trouble::UnknownMount)?, false)),
        _ => {
            let since = plan.since_of(index);
            let number = match cell {
                Cell::Number(number) => Some((number - since as f64, false)),
                Cell::Since(own, number) => Some(((own - since) as f64 + number, false)),
                Cell::Text(text) if since == 0 => plan.text.number(text),
                Cell::Text(text) => plan.text.number_since(since, text),
            };
            let (number, has_comma) = number.ok_or(Trouble::NotANumber)?;
            Ok((in_si(number, usage, index, plan)?, has_comma))
        }
    }
}

fn mount(cell: Cell<'_>, plan: &Plan) -> Option<f64> {
    let mounts = &plan.pose.as_ref()?.mounts;
    let is_it = |name: &String| match cell {
        Cell::Text(text) => name.as_bytes() == text,
        Cell::Number(_) | Cell::Since(..) => *name == cell.text(),
    };
    Some(mounts.iter().position(is_it)? as f64)
}

/// Returns true for the numbers by which meters mark an overload (9.9E+37) or a missing value (9.91E+37).
pub fn is_overload(number: f64) -> bool {
    (9.9e37..=1e38).contains(&number.abs())
}

/// Converts a number from a cell to SI units. Times are not converted.
#[inline(always)]
fn in_si(number: f64, usage: Use, index: usize, plan: &Plan) -> Result<f64, Trouble> {
    if !plan.dropouts.is_empty() && plan.dropouts[index].contains(&number) {
        return Err(Trouble::Dropout);
    }
    if is_overload(number) && !usage.is_time() {
        return Err(Trouble::Overload);
    }
    let shift = match usage {
        Use::Auxiliary { shift, .. } => shift,
        _ => 0.0,
    };
    let value = number * usage.factor() + shift;
    if value.is_finite() { Ok(value) } else { Err(Trouble::NotFinite) }
}
