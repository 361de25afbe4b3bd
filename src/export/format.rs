//! File formats of everything but calibrations.

use std::path::Path;

use crate::shown::joined;

/// File format that the ending of a file's name selects. `W` is the type of its writing function.
pub struct FileFormat<W> {
    pub name: &'static str,
    /// Ending of its files, in lower case and without the dot.
    pub ending: &'static str,
    pub holds: &'static str,
    pub write: W,
}

impl<W> FileFormat<W> {
    pub fn for_path<'a>(all: &'a [Self], path: &Path) -> Option<&'a Self> {
        let ending = path.extension()?.to_str()?;
        all.iter().find(|own| own.ending.eq_ignore_ascii_case(ending))
    }

    /// Returns the endings of these formats with their dots, for messages.
    pub fn listed(all: &[Self]) -> String {
        joined(" or ", all.iter().map(|own| format!(".{}", own.ending)))
    }
}
