//! Lists of another length than is needed: the one check of all parts of a calibration.

/// A list that is too short or too long.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field} has {actual} entries where {expected} are needed")]
pub struct WrongLength {
    pub field: String,
    pub expected: usize,
    pub actual: usize,
}

/// Checks how long a list is.
///
/// # Errors
/// [`WrongLength`] if that is not what is expected.
pub(super) fn check_length(field: &str, expected: usize, actual: usize) -> Result<(), WrongLength> {
    if actual == expected {
        Ok(())
    } else {
        Err(WrongLength { field: field.to_owned(), expected, actual })
    }
}
