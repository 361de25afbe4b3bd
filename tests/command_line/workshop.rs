//! A temporary folder with recordings, which is removed when the value is dropped.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

pub const HEADER: &str = "t [s],S1,S2,Fz [N]\n";

pub struct Workshop(tempfile::TempDir);

impl Workshop {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// Creates a folder with three training recordings and one test recording: `a.csv`, `b.csv`, `c.csv`, `test.csv`.
    pub fn with_recordings() -> Self {
        let workshop = Self::new();
        for (seed, name) in ["a.csv", "b.csv", "c.csv", "test.csv"].iter().enumerate() {
            workshop.write(name, recording(seed as f64, 150));
        }
        workshop
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.file(name), content).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.file(name)).unwrap()
    }
}

/// Arguments of `fit` that name all files of [`Workshop::with_recordings`].
pub const ALL_FILES: [&str; 6] = ["--train", "a.csv", "b.csv", "c.csv", "--test", "test.csv"];

/// Returns the text of a recording at 10 Hz: two gauges that lag behind the force.
pub fn recording(seed: f64, n_samples: usize) -> String {
    format!("{HEADER}{}", rows(seed, n_samples, 0.0))
}

/// Returns the rows of this recording without header, beginning at the time `start` (s).
pub fn rows(seed: f64, n_samples: usize, start: f64) -> String {
    let mut text = String::new();
    let mut lagging = 0.0_f64;
    for k in 0..n_samples {
        let t = k as f64 / 10.0;
        let force = 6.0 * (0.9 * t + seed).sin() + 2.0 * (2.3 * t + 1.7 * seed).cos();
        lagging = lagging.clamp(force - 1.5, force + 1.5);
        let (s1, s2) = (40.0 + force + 0.4 * lagging, 0.5 * lagging + 0.01 * force * force);
        writeln!(text, "{},{s1},{s2},{force}", start + t).unwrap();
    }
    text
}
