//! Maps of the errors over both thresholds as files, one file a format; everything that lists them reads [`MAP_FORMATS`].

mod csv;
mod svg;

use std::path::{Path, PathBuf};

pub use self::csv::write_threshold_csv;
pub use self::svg::{ShownFTh, threshold_curve, threshold_heat_map, write_threshold_svg};
use super::format::FileFormat;
use crate::export::atomic::{Together, WriteError};
use crate::questions::thresholds::{Measure, ThresholdMap};

/// What writes a map.
pub struct MapWriter {
    /// The files that are written with one of this name.
    pub files: fn(&Path) -> Vec<PathBuf>,
    /// Writes them.
    pub write: fn(&ThresholdMap, Measure, &Path, &mut Together) -> Result<(), WriteError>,
}

/// All formats of maps.
pub static MAP_FORMATS: &[FileFormat<MapWriter>] = &[csv::FORMAT, svg::FORMAT];

/// The format that a file's ending asks for; without a known one the first.
pub fn map_format(path: &Path) -> &'static FileFormat<MapWriter> {
    FileFormat::for_path(MAP_FORMATS, path).unwrap_or(&MAP_FORMATS[0])
}
