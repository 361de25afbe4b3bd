//! The expected error as a table.

use crate::calibration::{AxisExpectedError, ExpectedError, NoCrossValidation};
use crate::report::table::{Cell, Column, Table};
use crate::scoring::numbers::significant;

/// Returns one row per axis. The note describes the held-out samples.
pub fn expected_error_table(of: &ExpectedError) -> Table {
    let load = |own: &AxisExpectedError, value: Option<f64>, reason: &str| {
        let value = value.map(|value| (value, format!("{} {}", significant(value, 3), own.unit)));
        Cell::known(value.map(|(value, text)| Cell::number(value, text)), reason)
    };
    Table::of(&of.axes)
        .words("Axis", |own| own.axis.symbol())
        .column(Column::numbers("Expected error"), |own| {
            load(own, own.value, "the axis hardly moves in the recordings")
        })
        .about("95 % of the held-out errors lie within this value")
        .digits("Expected error [% FS]", 3, |own| own.percent_fs)
        .about("in percent of full scale")
        .column(Column::numbers("Cross-validation"), |own| {
            load(own, own.cross_validation, &NoCrossValidation::NotDone.to_string())
        })
        .about("on groups of training recordings, each predicted by a fit to the others")
        .column(Column::numbers("Test"), |own| load(own, own.test, "there is no test recording"))
        .about("on the test recordings")
        .column(Column::numbers("Loads reached"), |own| {
            let [low, high] = [own.range.0, own.range.1].map(|load| significant(load, 3));
            Cell::words(format!("{low} … {high} {}", own.unit))
        })
        .about("smallest to largest load of the recordings")
        .table("Expected error", of.notes().join(" "))
}

/// Returns a table of the expected errors alone, for use beside other errors of the same axes.
pub fn expected_error_column(of: &ExpectedError) -> Table {
    Table::of(&of.axes)
        .words("Axis", |own| own.axis.label())
        .digits("95 %", 3, |own| own.value)
        .table("Expected error", of.notes().join(" "))
}
