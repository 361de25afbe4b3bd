//! Writer of a threshold map in one format.

use std::path::{Path, PathBuf};

use crate::export::{Together, WriteError};
use crate::questions::thresholds::{Measure, ThresholdMap};

pub struct MapWriter {
    /// Function that returns the paths of all files that `write` creates if it is called with this path.
    pub files: fn(&Path) -> Vec<PathBuf>,
    pub write: fn(&ThresholdMap, Measure, &Path, &mut Together) -> Result<(), WriteError>,
}
