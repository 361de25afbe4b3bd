//! What writes the files of a map.

use std::path::{Path, PathBuf};

use crate::export::atomic::{Together, WriteError};
use crate::questions::thresholds::{Measure, ThresholdMap};

/// What writes a map.
pub struct MapWriter {
    /// The files that are written with one of this name.
    pub files: fn(&Path) -> Vec<PathBuf>,
    /// Writes them.
    pub write: fn(&ThresholdMap, Measure, &Path, &mut Together) -> Result<(), WriteError>,
}
