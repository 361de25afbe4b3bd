use std::fmt;

use crate::shown::shown;

/// Number and name of a column of a file. In messages they are shown as `column 3 (S1)`.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedColumn {
    /// Number of the column, counted from 1.
    pub number: usize,
    pub name: String,
}

impl NamedColumn {
    pub fn new(index: usize, name: impl Into<String>) -> Self {
        Self { number: index + 1, name: name.into() }
    }
}

impl fmt::Display for NamedColumn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "column {} ({})", self.number, shown(&self.name))
    }
}
