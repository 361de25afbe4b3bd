//! Checks the lists of numbers in a calibration file, which may have been edited by hand.

/// Largest magnitude of a number in a calibration. Products of larger numbers could overflow.
pub(super) const LARGEST: f64 = 1e100;

/// Error of a list that has a wrong number of entries, or an entry out of range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WrongEntries {
    #[error(
        "{field} has {actual} entries, but it must have {expected}; restore the file or fit again"
    )]
    Length { field: String, expected: usize, actual: usize },
    #[error(
        "{field} holds {value:?}, which is not a number from {least:?} to {LARGEST:?}; restore the file, or fit in other units"
    )]
    Number { field: String, value: f64, least: f64 },
}

pub(super) fn check_length(
    field: &str,
    expected: usize,
    actual: usize,
) -> Result<(), WrongEntries> {
    if actual == expected {
        Ok(())
    } else {
        Err(WrongEntries::Length { field: field.to_owned(), expected, actual })
    }
}

/// Checks the number of entries, and that each entry is a number from `least` to [`LARGEST`].
pub(super) fn check_numbers(
    field: &str,
    expected: usize,
    numbers: &[f64],
    least: f64,
) -> Result<(), WrongEntries> {
    check_length(field, expected, numbers.len())?;
    match numbers.iter().find(|number| !(least..=LARGEST).contains(*number)) {
        None => Ok(()),
        Some(value) => Err(WrongEntries::Number { field: field.to_owned(), value: *value, least }),
    }
}
