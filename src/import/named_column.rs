//! What a message calls a column of a file.

use std::fmt;

use crate::shown::shown;

/// A column with its name, as `column 3 (S1)`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedColumn {
    /// Counted from 1.
    pub number: usize,
    /// As the header writes it, or what the column is.
    pub name: String,
}

impl NamedColumn {
    /// The column `index`, from 0 on.
    pub(super) fn new(index: usize, name: impl Into<String>) -> Self {
        Self { number: index + 1, name: name.into() }
    }
}

impl fmt::Display for NamedColumn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "column {} ({})", self.number, shown(&self.name))
    }
}
