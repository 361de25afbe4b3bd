//! Tables of the expected error and of limits.

use crate::{
    calibration::{AxisExpectedError, ExpectedError, NoCrossValidation},
    questions::expected_error::limits::Checked,
    report::table::{Cell, Column, Table},
    scoring::numbers::significant,
};

/// Returns the table of expected errors, one row per axis. The note below the table describes the held-out samples.
pub fn expected_error_table(of: &ExpectedError) -> Table {
    let load = |error: &AxisExpectedError, value: Option<f64>, reason: &str| {
        let text = |value| format!("{} {}", significant(value, 3), error.unit);
        Cell::known(value.map(|value| Cell::number(value, text(value))), reason)
    };
    Table::of(&of.axes)
        .words("Axis", |error| error.axis.symbol())
        .column(Column::numbers("Expected error"), |error| {
            load(error, error.value, "the load on this axis hardly changes in the recordings, so its expected error is unknown")
        })
        .about("Load error within which 95 % of the errors on further recordings should lie")
        .digits("Expected error [% FS]", 3, |error| error.percent_fs)
        .about("Expected error in percent of full scale")
        .column(Column::numbers("Cross-validation"), |error| {
            load(error, error.cross_validation, &NoCrossValidation::NotDone.to_string())
        })
        .about(
            "95 % error on groups of training recordings, each predicted by a fit to the other groups; widened for few groups",
        )
        .column(Column::numbers("Test"), |error| load(error, error.test, "there is no test recording"))
        .about("95 % error on the test recordings")
        .column(Column::numbers("Loads reached"), |error| {
            let [low, high] = [error.range.0, error.range.1].map(|load| significant(load, 3));
            Cell::words(format!("{low} … {high} {}", error.unit))
        })
        .about("Smallest and largest load on this axis in the recordings")
        .table("Expected error", of.notes().join(" "))
}

pub fn limits_table(checked: &[Checked]) -> Table {
    Table::of(checked)
        .words("Figure", |limit| limit.figure.name())
        .words("Axis", |limit| limit.axis.symbol())
        .column(Column::numbers("Value"), |limit| {
            let value = limit.value.map(|value| Cell::digits(Some(value), 4));
            Cell::known(value, limit.reason.clone().unwrap_or_default())
        })
        .digits("Maximum", 4, |limit| Some(limit.limit))
        .words("Unit", |limit| limit.unit)
        .words("Outcome", |limit| if limit.pass { "pass" } else { "FAIL" })
        .table("Limits", "")
}
