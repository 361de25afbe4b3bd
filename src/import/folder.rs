//! Finds the files of recordings in a folder, or the files whose names match a pattern.

use std::io;
use std::path::{Path, PathBuf};

use crate::formats;

/// Names (without extension) of text files that are not recordings, though they often lie in the same folder.
const BESIDE: [&str; 5] = ["readme", "license", "licence", "changelog", "notes"];

/// Returns the files in a folder whose names have an extension of a recording format, sorted by name. Hidden files and
/// readmes are left out.
pub fn recordings_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let stem = name.split('.').next().unwrap_or_default();
        let is_beside = name.starts_with('.') || BESIDE.contains(&stem);
        if path.is_file() && !is_beside && formats::endings().any(|own| own == ending) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

pub fn is_pattern(path: &Path) -> bool {
    path.to_string_lossy().contains(['*', '?'])
}

/// Returns the files whose names match a pattern with `*` or `?`, sorted by name. `None` if no file matches, or if there is a
/// file with exactly this name.
pub fn matching(pattern: &Path) -> Option<Vec<PathBuf>> {
    if !is_pattern(pattern) || pattern.exists() {
        return None;
    }
    let options = glob::MatchOptions {
        case_sensitive: !cfg!(windows),
        require_literal_separator: true,
        require_literal_leading_dot: true,
    };
    // Square brackets are not wildcards, because folders often have them in their names.
    let pattern = pattern.to_str()?.replace('[', "[[]");
    let found: Vec<_> = glob::glob_with(&pattern, options).ok()?.flatten().collect();
    (!found.is_empty()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_selects_the_matching_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for day in ["day1", "day2", "day[3]"] {
            std::fs::create_dir(at(day)).unwrap();
        }
        for name in
            ["day2/b.csv", "day1/b.csv", "day1/a.csv", "day1/.c.csv", "day2/x.txt", "day[3]/z.csv"]
        {
            std::fs::write(at(name), "").unwrap();
        }
        let expected = ["day1/a.csv", "day1/b.csv", "day2/b.csv"].map(at);
        assert_eq!(matching(&at("day?/*.csv")), Some(expected.to_vec()));
        assert_eq!(matching(&at("day?/x.txt")), Some(vec![at("day2/x.txt")]));
        assert_eq!(matching(&at("day[3]/?.csv")), Some(vec![at("day[3]/z.csv")]));
        assert_eq!(matching(&at("day*/y*")), None);
        assert_eq!(matching(&at("day1/a.csv")), None);
    }

    #[cfg(unix)]
    #[test]
    fn a_file_whose_name_looks_like_a_pattern_is_that_file() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["*.csv", "a.csv"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        assert_eq!(matching(&folder.path().join("*.csv")), None);
    }

    #[test]
    fn recordings_are_sorted_and_other_files_left_out() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.csv", "a.TXT", "README.txt", ".hidden.csv", "sensor.toml", "c.json"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        std::fs::create_dir(folder.path().join("d.csv")).unwrap();
        let found = recordings_in(folder.path()).unwrap();
        let names: Vec<_> =
            found.iter().map(|path| path.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["a.TXT", "b.csv"]);
    }
}
