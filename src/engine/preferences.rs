//! Preferences of the user, which do not depend on the loaded recordings.
//!
//! Guarantees: the preferences file is always complete. If several windows are open, each keeps the changes of the others. If
//! several windows change the same preference, the window that writes last decides it.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};

use crate::{
    engine::project::absolute,
    export::{WriteError, write_atomically},
    import::map::ColumnMap,
    small_file::read_small,
};

/// Colour theme of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Theme {
    /// Use the theme of the desktop.
    #[default]
    System,
    /// Light.
    Light,
    /// Dark.
    Dark,
}

const MAX_RECENT: usize = 12;
const MAX_MAPS: usize = 40;
/// Maximum size of a preferences file that is read (bytes). A larger file must be something else.
const BYTES_LIMIT: u64 = 16 << 20;

/// Reads one preference from JSON. If it cannot be read, it gets its default, and the other preferences are still read.
fn one_by_one<'de, D: Deserializer<'de>, T: DeserializeOwned + Default>(
    from: D,
) -> Result<T, D::Error> {
    let value = serde_json::Value::deserialize(from)?;
    Ok(serde_json::from_value(value).unwrap_or_default())
}

/// Reads a list of preferences, and skips entries that cannot be read.
fn each<'de, D: Deserializer<'de>, T: DeserializeOwned>(from: D) -> Result<Vec<T>, D::Error> {
    let values: Vec<serde_json::Value> = one_by_one(from)?;
    let values = values.into_iter();
    Ok(values.filter_map(|value| serde_json::from_value(value).ok()).collect())
}

/// Preferences kept between runs of the program. A missing entry has its default.
///
/// | name | default | range |
/// |---|---|---|
/// | `theme` | as the system | |
/// | `text_scale` | 1 | 0.5 to 3, times the display's own |
/// | `recent` | none | 12 files, newest first |
/// | `maps` | none | 40 column maps, newest first |
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Theme.
    #[serde(deserialize_with = "one_by_one")]
    pub theme: Theme,
    /// Scale of all texts and widgets, relative to the scale of the display.
    #[serde(deserialize_with = "one_by_one")]
    pub text_scale: f32,
    /// Recently opened recordings, calibrations and sessions, newest first.
    #[serde(deserialize_with = "each")]
    pub recent: Vec<PathBuf>,
    /// Column maps that were used to read files, newest first.
    #[serde(deserialize_with = "each")]
    pub maps: Vec<ColumnMap>,
}

impl Default for Preferences {
    fn default() -> Self {
        Self { theme: Theme::default(), text_scale: 1.0, recent: Vec::new(), maps: Vec::new() }
    }
}

impl Preferences {
    /// Permitted range of [`Self::text_scale`].
    pub const TEXT_SCALES: std::ops::RangeInclusive<f32> = 0.5..=3.0;

    /// Reads preferences from JSON. Entries that cannot be read get their defaults.
    fn understood(text: &[u8]) -> Option<Self> {
        let mut read: Self = serde_json::from_slice(text).ok()?;
        if !Self::TEXT_SCALES.contains(&read.text_scale) {
            read.text_scale = 1.0;
        }
        read.recent.truncate(MAX_RECENT);
        Some(read)
    }

    /// Returns the preferences as JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Puts a file at the front of the list of recent files.
    pub fn remember(&mut self, path: &Path) {
        let path = absolute(path);
        self.recent.retain(|other| *other != path);
        self.recent.insert(0, path);
        self.recent.truncate(MAX_RECENT);
    }

    /// Puts a column map at the front of the list, and removes older maps for files with the same columns.
    pub fn remember_map(&mut self, map: &ColumnMap) {
        let is_other = |other: &ColumnMap| {
            let (other, this) = (&other.table, &map.table);
            // Files without a header row have no column names, so their text layout must differ, too.
            let is_cut_so = !this.shape.names.is_empty() || other.text == this.text;
            other.shape != this.shape || !is_cut_so
        };
        self.maps.retain(is_other);
        self.maps.insert(0, map.clone());
        self.maps.truncate(MAX_MAPS);
    }

    /// Returns the preferences `file` with the changes that this window made: the differences between `known` and `self`.
    fn onto(&self, known: &Self, mut file: Self) -> Self {
        fn take<T: Clone + PartialEq>(now: &T, known: &T, file: &mut T) {
            if now != known {
                file.clone_from(now);
            }
        }
        take(&self.theme, &known.theme, &mut file.theme);
        take(&self.text_scale, &known.text_scale, &mut file.text_scale);
        let recent = newest(&self.recent, &known.recent).iter();
        recent.rev().for_each(|path| file.remember(path));
        let maps = newest(&self.maps, &known.maps).iter();
        maps.rev().for_each(|map| file.remember_map(map));
        file
    }
}

/// Returns the entries at the front of the list `now` that were added since the list was `before`.
fn newest<'a, T: PartialEq>(now: &'a [T], before: &[T]) -> &'a [T] {
    let mut left = before.iter().rev();
    let is_left = |item: &&T| left.any(|other| other == *item);
    let n_old = now.iter().rev().take_while(is_left).count();
    &now[..now.len() - n_old]
}

/// Preferences file, which all windows of a user share.
#[derive(Debug)]
pub struct PreferencesFile {
    path: PathBuf,
    /// Preferences that this window last read or wrote. Differences from them are the changes of this window.
    known: Preferences,
}

impl PreferencesFile {
    fn path_in(folder: &Path) -> PathBuf {
        folder.join("preferences.json")
    }

    fn read_at(path: &Path) -> Option<Preferences> {
        let text = read_small(path, "preferences", BYTES_LIMIT).ok()?;
        Preferences::understood(&text)
    }

    /// Returns the preferences of the file in `folder`; `None` if it cannot be read.
    pub fn read_in(folder: &Path) -> Option<Preferences> {
        Self::read_at(&Self::path_in(folder))
    }

    /// Returns the preferences file in `folder`, for a window that starts with the preferences `known`.
    pub fn new(folder: &Path, known: Preferences) -> Self {
        Self { path: Self::path_in(folder), known }
    }

    /// Writes the changed preferences of this window to the file.
    ///
    /// # Errors
    /// [`WriteError`] if the file cannot be written. The next call tries again.
    pub fn write(&mut self, now: &Preferences) -> Result<(), WriteError> {
        if *now == self.known {
            return Ok(());
        }
        let at = |source: io::Error| WriteError { path: self.path.clone(), source };
        if let Some(folder) = self.path.parent() {
            std::fs::create_dir_all(folder).map_err(at)?;
        }
        let lock = File::options()
            .create(true)
            .append(true)
            .open(self.path.with_extension("writing"))
            .map_err(at)?;
        // The lock makes windows write the file one after another, if the file system supports locks. It ends when `lock` is
        // dropped.
        let _ = lock.lock();
        let kept = Self::read_at(&self.path).unwrap_or_else(|| self.known.clone());
        let merged = now.onto(&self.known, kept);
        write_atomically(&self.path, |out| out.write_all(merged.to_json().as_bytes()))?;
        self.known = now.clone();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::map::{ColumnKey, ColumnRole, ColumnRule};

    #[test]
    fn preferences_are_restored_and_invalid_ones_are_ignored() {
        let mut preferences =
            Preferences { theme: Theme::Light, text_scale: 1.5, ..Preferences::default() };
        preferences.remember(Path::new("/a.csv"));
        assert_eq!(Preferences::understood(preferences.to_json().as_bytes()), Some(preferences));
        for nonsense in ["", "{", "[1]", r#"{"text_scale": 1e9}"#, r#"{"theme": 3}"#] {
            let read = Preferences::understood(nonsense.as_bytes()).unwrap_or_default();
            assert_eq!(read, Preferences::default(), "{nonsense}");
        }
        let newer = r#"{"text_scale": 1.5, "what a later version adds": 1, "theme": "sepia", "recent": 3, "maps": [{"version": 2}]}"#;
        assert_eq!(Preferences::understood(newer.as_bytes()).unwrap().text_scale, 1.5);
    }

    #[test]
    fn the_newest_file_is_first_and_listed_once() {
        let mut preferences = Preferences::default();
        for at in 0..20 {
            preferences.remember(Path::new(&format!("/{at}.csv")));
        }
        preferences.remember(Path::new("/15.csv"));
        assert_eq!(preferences.recent.len(), MAX_RECENT);
        assert_eq!(preferences.recent[..3], ["/15.csv", "/19.csv", "/18.csv"].map(PathBuf::from));
        let of_15 = preferences.recent.iter().filter(|path| path.ends_with("15.csv"));
        assert_eq!(of_15.count(), 1);
    }

    fn window(folder: &Path) -> (PreferencesFile, Preferences) {
        let kept = PreferencesFile::read_in(folder).unwrap_or_default();
        (PreferencesFile::new(folder, kept.clone()), kept)
    }

    #[test]
    fn two_windows_keep_the_changes_of_each_other() {
        let folder = tempfile::tempdir().unwrap();
        let (mut first, mut own) = window(folder.path());
        own.remember(Path::new("/old.csv"));
        first.write(&own).unwrap();
        let (mut a, mut of_a) = window(folder.path());
        let (mut b, mut of_b) = window(folder.path());
        of_a.theme = Theme::Light;
        of_a.remember(Path::new("/a.csv"));
        let map = |n_columns: usize| {
            let mut map = ColumnMap::default();
            map.table.shape.columns = n_columns;
            let gauge = ColumnRule::new(ColumnKey::Number(1), ColumnRole::Gauge);
            map.table.columns = vec![gauge];
            map
        };
        of_a.remember_map(&map(1));
        a.write(&of_a).unwrap();
        of_b.text_scale = 1.5;
        of_b.remember_map(&map(2));
        of_b.remember(Path::new("/b.csv"));
        b.write(&of_b).unwrap();
        // Nothing changed here, so the changes of the other window stay.
        a.write(&of_a).unwrap();
        let kept = PreferencesFile::read_in(folder.path()).unwrap();
        assert_eq!((kept.theme, kept.text_scale), (Theme::Light, 1.5));
        let expected = ["/b.csv", "/a.csv", "/old.csv"].map(PathBuf::from);
        assert_eq!(kept.recent, expected);
        assert_eq!(kept.maps, [map(2), map(1)]);
    }

    #[test]
    fn entries_at_the_front_that_were_not_there_before_are_new() {
        let names = |from: i32, to: i32| (from..to).rev().collect::<Vec<_>>();
        assert_eq!(newest(&[9, 2, 5, 4, 1], &[5, 4, 3, 2, 1]), [9, 2]);
        assert_eq!(newest(&names(3, 15), &names(0, 12)), [14, 13, 12]);
    }

    #[test]
    fn windows_that_write_at_the_same_time_lose_nothing() {
        let folder = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for writer in 0..4 {
                let folder = folder.path();
                scope.spawn(move || {
                    let (mut file, mut own) = window(folder);
                    for at in 0..3 {
                        own.remember(Path::new(&format!("/{writer}-{at}.csv")));
                        own.text_scale = 1.0 + 0.01 * at as f32;
                        file.write(&own).unwrap();
                    }
                });
            }
        });
        let kept = PreferencesFile::read_in(folder.path()).unwrap();
        assert_eq!(kept.recent.len(), 12, "{:?}", kept.recent);
    }

    #[test]
    fn an_unreadable_file_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let mut known = Preferences::default();
        known.remember(Path::new("/a.csv"));
        let mut file = PreferencesFile::new(folder.path(), known.clone());
        std::fs::write(&file.path, "{torn").unwrap();
        known.text_scale = 1.5;
        file.write(&known).unwrap();
        assert_eq!(PreferencesFile::read_in(folder.path()), Some(known));
    }
}
