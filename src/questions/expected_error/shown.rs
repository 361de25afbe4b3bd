//! The expected error as a table.

use crate::calibration::ExpectedError;
use crate::report::table::{Cell, Column, Table};
use crate::scoring::numbers::significant;

/// Returns a row per axis; what was held out stands in the note.
pub fn expected_error_table(of: &ExpectedError) -> Table {
    let about =
        |name: &str, about: &str| Column { about: about.to_owned(), ..Column::numbers(name) };
    let columns = vec![
        Column::words("Axis"),
        about("Expected error", "95 % of the held-out errors lie within this value"),
        about("Expected error [% FS]", "in percent of full scale"),
        about(
            "Cross-validation",
            "on groups of training recordings, each predicted by a fit to the others",
        ),
        about("Test", "on the test recordings"),
        about("Loads reached", "smallest to largest load of the recordings"),
    ];
    let rows = of.axes.iter().map(|own| {
        let load = |value: Option<f64>, reason: &str| match value {
            Some(value) => Cell::number(value, format!("{} {}", significant(value, 3), own.unit)),
            None => Cell::missing("–", reason),
        };
        let (low, high) = own.range;
        vec![
            Cell::words(own.axis.symbol()),
            load(own.value, "the axis hardly moves in the recordings"),
            Cell::digits(own.percent_fs, 3),
            load(own.cross_validation, "nothing was left out"),
            load(own.test, "there is no test recording"),
            Cell::words(format!("{} … {} {}", significant(low, 3), significant(high, 3), own.unit)),
        ]
    });
    Table {
        title: "Expected error".to_owned(),
        columns,
        rows: rows.collect(),
        note: of.notes().join(" "),
    }
}

/// Returns the expected errors alone, to stand beside other errors of the same axes.
pub fn expected_error_column(of: &ExpectedError) -> Table {
    let rows =
        of.axes.iter().map(|own| vec![Cell::words(own.axis.label()), Cell::digits(own.value, 3)]);
    Table {
        title: "Expected error".to_owned(),
        columns: vec![Column::words("Axis"), Column::numbers("95 %")],
        rows: rows.collect(),
        note: of.notes().join(" "),
    }
}
