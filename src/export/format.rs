//! File formats of all files except calibrations.

use std::path::Path;

use crate::shown::joined;

/// File format that the file name ending selects. `W` is the type of the function that writes it.
pub struct FileFormat<W> {
    pub name: &'static str,
    /// File name ending, in lower case and without the dot.
    pub ending: &'static str,
    pub holds: &'static str,
    pub write: W,
}

impl<W> FileFormat<W> {
    pub fn for_path<'a>(all: &'a [Self], path: &Path) -> Option<&'a Self> {
        let ending = path.extension()?.to_str()?;
        all.iter().find(|format| format.ending.eq_ignore_ascii_case(ending))
    }

    /// Returns the file name endings of these formats with their dots, for messages.
    pub fn listed(all: &[Self]) -> String {
        joined(" or ", all.iter().map(|format| format!(".{}", format.ending)))
    }
}
