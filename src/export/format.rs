//! What a format is that something else than a calibration is written in.

use std::path::Path;

/// A format, known by the ending of its files; `W` is what writes it.
pub struct FileFormat<W> {
    /// What people call it.
    pub name: &'static str,
    /// The ending of its files, in small letters and without the dot.
    pub ending: &'static str,
    /// What its files hold.
    pub holds: &'static str,
    /// What writes it.
    pub write: W,
}

impl<W> FileFormat<W> {
    /// The one of these formats that a file's ending asks for.
    pub fn for_path<'a>(all: &'a [Self], path: &Path) -> Option<&'a Self> {
        let ending = path.extension()?.to_str()?;
        all.iter().find(|own| own.ending.eq_ignore_ascii_case(ending))
    }

    /// The endings of these formats with their dots, as messages list them.
    pub fn listed(all: &[Self]) -> String {
        let endings = all.iter().map(|own| format!(".{}", own.ending));
        endings.collect::<Vec<_>>().join(" or ")
    }
}
