//! Check of the length of lists, for all parts of a calibration.

/// List with a wrong number of entries.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field} has {actual} entries, but it must have {expected}")]
pub struct WrongLength {
    pub field: String,
    pub expected: usize,
    pub actual: usize,
}

/// Checks the number of entries of a list.
///
/// # Errors
/// [`WrongLength`] if the numbers differ.
pub(super) fn check_length(field: &str, expected: usize, actual: usize) -> Result<(), WrongLength> {
    if actual == expected {
        Ok(())
    } else {
        Err(WrongLength { field: field.to_owned(), expected, actual })
    }
}
