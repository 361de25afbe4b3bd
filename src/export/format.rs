//! A file format for anything but calibrations.

use std::path::Path;

/// A format, known by the ending of its files. `W` is its writer.
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
        let endings = all.iter().map(|own| format!(".{}", own.ending));
        endings.collect::<Vec<_>>().join(" or ")
    }
}
