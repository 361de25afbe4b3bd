//! The interface of writers of maps.

use std::path::{Path, PathBuf};

use crate::export::{Together, WriteError};
use crate::questions::thresholds::{Measure, ThresholdMap};

pub struct MapWriter {
    /// Returns all files that are written for this path.
    pub files: fn(&Path) -> Vec<PathBuf>,
    pub write: fn(&ThresholdMap, Measure, &Path, &mut Together) -> Result<(), WriteError>,
}
