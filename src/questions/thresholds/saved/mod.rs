//! Files in which a threshold map can be saved. [`MAP_FORMATS`] is the only list of their formats.

mod csv;
mod svg;

use std::path::{Path, PathBuf};

pub use self::csv::write_threshold_csv;
pub use self::svg::{ShownFTh, threshold_curve, threshold_heat_map, write_threshold_svg};
use crate::{
    export::{FileFormat, Together, WriteError},
    questions::thresholds::{Measure, ThresholdMap},
};

/// Writer of a threshold map in one format.
pub struct MapWriter {
    /// Function that returns the paths of all files that `write` creates if it is called with this path.
    pub files: fn(&Path) -> Vec<PathBuf>,
    pub write: fn(&ThresholdMap, Measure, &Path, &mut Together) -> Result<(), WriteError>,
}

pub static MAP_FORMATS: &[FileFormat<MapWriter>] = &[csv::FORMAT, svg::FORMAT];

/// Returns the file format that belongs to the ending of this path, or the first format for an unknown ending.
pub fn map_format(path: &Path) -> &'static FileFormat<MapWriter> {
    FileFormat::for_path(MAP_FORMATS, path).unwrap_or(&MAP_FORMATS[0])
}
