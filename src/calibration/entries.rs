//! Checks the lists of numbers in a calibration file, which may have been edited by hand.

use crate::calibration::error::{CalibrationError, LARGEST};

pub(super) fn check_length(
    field: &str,
    expected: usize,
    actual: usize,
) -> Result<(), CalibrationError> {
    if actual == expected {
        Ok(())
    } else {
        Err(CalibrationError::Length { field: field.to_owned(), expected, actual })
    }
}

/// Checks the number of entries, and that each entry is a number from `least` to [`LARGEST`].
pub(super) fn check_numbers(
    field: &str,
    expected: usize,
    numbers: &[f64],
    least: f64,
) -> Result<(), CalibrationError> {
    check_length(field, expected, numbers.len())?;
    match numbers.iter().find(|number| !(least..=LARGEST).contains(*number)) {
        None => Ok(()),
        Some(value) => {
            Err(CalibrationError::Number { field: field.to_owned(), value: *value, least })
        }
    }
}
