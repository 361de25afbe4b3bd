//! The outcome of limits as a table.

use crate::questions::expected_error::limits::Checked;
use crate::report::table::{Cell, Column, Table};
use crate::scoring::numbers::significant;

/// Returns a row per limit and axis.
pub fn limits_table(checked: &[Checked]) -> Table {
    let columns = vec![
        Column::words("Figure"),
        Column::words("Axis"),
        Column::numbers("Value"),
        Column::numbers("Maximum"),
        Column::words("Unit"),
        Column::words("Outcome"),
    ];
    let rows = checked.iter().map(|own| {
        let number = |value: f64| Cell::number(value, significant(value, 4));
        vec![
            Cell::words(own.figure.name()),
            Cell::words(own.axis.symbol()),
            match own.value {
                Some(value) => number(value),
                None => Cell::missing("–", own.reason.clone().unwrap_or_default()),
            },
            number(own.limit),
            Cell::words(own.unit),
            Cell::words(if own.pass { "pass" } else { "FAIL" }),
        ]
    });
    Table { title: "Limits".to_owned(), columns, rows: rows.collect(), note: String::new() }
}
