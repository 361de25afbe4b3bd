//! The recordings in a folder.

use std::io;
use std::path::{Path, PathBuf};

use crate::formats;

/// What lies beside recordings and is none.
const BESIDE: [&str; 5] = ["readme", "license", "licence", "changelog", "notes"];

/// The files in a folder that a recording's name ends like, in the order of their names; hidden ones and what tells of the others are left
/// out.
///
/// # Errors
/// What reading the folder gives.
pub fn recordings_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .to_lowercase();
        let ending = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_lowercase();
        let stem = name.split('.').next().unwrap_or_default();
        let is_beside = name.starts_with('.') || BESIDE.contains(&stem);
        if path.is_file() && !is_beside && formats::endings().any(|own| own == ending) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_come_in_order_and_what_is_none_stays() {
        let folder = tempfile::tempdir().unwrap();
        for name in [
            "b.csv",
            "a.TXT",
            "README.txt",
            ".hidden.csv",
            "sensor.toml",
            "c.json",
        ] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        std::fs::create_dir(folder.path().join("d.csv")).unwrap();
        let found = recordings_in(folder.path()).unwrap();
        let names: Vec<_> = found
            .iter()
            .map(|path| path.file_name().unwrap().to_str().unwrap())
            .collect();
        assert_eq!(names, ["a.TXT", "b.csv"]);
    }
}
