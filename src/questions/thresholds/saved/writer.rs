//! The interface of writers of maps.

use std::path::{Path, PathBuf};

use crate::export::{Together, WriteError};
use crate::questions::thresholds::{Measure, ThresholdMap};

/// Writer of a map.
pub struct MapWriter {
    /// Returns all files that are written for this path.
    pub files: fn(&Path) -> Vec<PathBuf>,
    /// Writes the files.
    pub write: fn(&ThresholdMap, Measure, &Path, &mut Together) -> Result<(), WriteError>,
}
