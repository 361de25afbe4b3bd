//! What the program remembers of a person, whatever is loaded.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::import::map::ColumnMap;

/// Light or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Theme {
    /// As the desktop has it.
    #[default]
    System,
    /// Light.
    Light,
    /// Dark.
    Dark,
}

/// So many recent files are remembered.
const MAX_RECENT: usize = 12;

/// Remembered between runs; what an older or newer version does not know is left at its default.
///
/// | name | default | range |
/// |---|---|---|
/// | `theme` | as the system | |
/// | `text_scale` | 1 | 0.5 to 3, times the display's own |
/// | `recent` | none | 12 files, newest first |
/// | `maps` | none | 40 column maps, newest first |
/// | `layout` | the program's | |
/// | `toured` | no | whether the tour was seen or skipped |
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Light or dark.
    pub theme: Theme,
    /// How large everything is.
    pub text_scale: f32,
    /// Recordings, calibrations and sessions that were opened, newest first.
    pub recent: Vec<PathBuf>,
    /// Column maps that files were read by, newest first.
    pub maps: Vec<ColumnMap>,
    /// Where the panes stand.
    pub layout: Option<serde_json::Value>,
    /// Whether the tour was seen or skipped.
    pub toured: bool,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            theme: Theme::default(),
            text_scale: 1.0,
            recent: Vec::new(),
            maps: Vec::new(),
            layout: None,
            toured: false,
        }
    }
}

impl Preferences {
    /// The range of [`Self::text_scale`].
    pub const TEXT_SCALES: std::ops::RangeInclusive<f32> = 0.5..=3.0;

    /// Reads what was remembered; what cannot be read is as if it had never been.
    pub fn from_json(text: &str) -> Self {
        let mut read: Self = serde_json::from_str(text).unwrap_or_default();
        if !Self::TEXT_SCALES.contains(&read.text_scale) {
            read.text_scale = 1.0;
        }
        read.recent.truncate(MAX_RECENT);
        read
    }

    /// As JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Puts a file before all others.
    pub fn remember(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.recent.retain(|other| *other != path);
        self.recent.insert(0, path);
        self.recent.truncate(MAX_RECENT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_come_back_and_nonsense_is_as_if_never_said() {
        let mut preferences = Preferences {
            theme: Theme::Light,
            text_scale: 1.5,
            toured: true,
            ..Preferences::default()
        };
        preferences.remember(Path::new("/a.csv"));
        assert_eq!(Preferences::from_json(&preferences.to_json()), preferences);
        for nonsense in ["", "{", "[1]", r#"{"text_scale": 1e9}"#, r#"{"theme": 3}"#] {
            assert_eq!(
                Preferences::from_json(nonsense),
                Preferences::default(),
                "{nonsense}"
            );
        }
        let newer = r#"{"toured": true, "what a later version adds": 1}"#;
        assert!(Preferences::from_json(newer).toured);
    }

    #[test]
    fn the_newest_file_is_first_and_stands_once() {
        let mut preferences = Preferences::default();
        for at in 0..20 {
            preferences.remember(Path::new(&format!("/{at}.csv")));
        }
        preferences.remember(Path::new("/15.csv"));
        assert_eq!(preferences.recent.len(), MAX_RECENT);
        assert_eq!(
            preferences.recent[..3],
            ["/15.csv", "/19.csv", "/18.csv"].map(PathBuf::from)
        );
        let of_15 = preferences
            .recent
            .iter()
            .filter(|path| path.ends_with("15.csv"));
        assert_eq!(of_15.count(), 1);
    }
}
