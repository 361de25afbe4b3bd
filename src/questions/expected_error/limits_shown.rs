//! The outcome of limits as a table.

use crate::questions::expected_error::limits::Checked;
use crate::report::table::{Cell, Column, Table};

pub fn limits_table(checked: &[Checked]) -> Table {
    Table::of(checked)
        .words("Figure", |own| own.figure.name())
        .words("Axis", |own| own.axis.symbol())
        .column(Column::numbers("Value"), |own| {
            let value = own.value.map(|value| Cell::digits(Some(value), 4));
            Cell::known(value, own.reason.clone().unwrap_or_default())
        })
        .digits("Maximum", 4, |own| Some(own.limit))
        .words("Unit", |own| own.unit)
        .words("Outcome", |own| if own.pass { "pass" } else { "FAIL" })
        .table("Limits", "")
}
