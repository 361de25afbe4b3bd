/// List with a wrong number of entries, in any part of a calibration.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field} has {actual} entries, but it must have {expected}")]
pub struct WrongLength {
    pub field: String,
    pub expected: usize,
    pub actual: usize,
}

pub(super) fn check_length(field: &str, expected: usize, actual: usize) -> Result<(), WrongLength> {
    if actual == expected {
        Ok(())
    } else {
        Err(WrongLength { field: field.to_owned(), expected, actual })
    }
}
