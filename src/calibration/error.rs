//! Reasons why a calibration cannot be used.

use crate::calibration::entries::WrongEntries;
use crate::calibration::learned::LearnedError;
use crate::features::FeatureError;

/// Value of the field `format` of a calibration file.
pub const FORMAT: &str = "loopscope calibration";
/// Version of the file that this program writes and reads.
pub const VERSION: u32 = 2;

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    #[error("this is not a calibration: its \"format\" is not \"{FORMAT}\"")]
    Format,
    #[error("the calibration has version {version}; this program reads version {VERSION}")]
    Version { version: u32 },
    #[error("the calibration has no {what}")]
    Nothing { what: &'static str },
    #[error("the axes must be distinct and in the order Fx Fy Fz Mx My Mz")]
    AxisOrder,
    #[error(transparent)]
    Entries(#[from] WrongEntries),
    #[error("the unit of {axis} is {actual:?} where {expected:?} is needed")]
    Unit { axis: &'static str, expected: &'static str, actual: String },
    #[error("the decimation is 0; it must be 1 (every sample) or more")]
    Decimation,
    #[error("full_scale is 0 on every axis, so the calibration was made without any load")]
    NoFullScale,
    #[error("{field}: feature {position} is {actual:?} where {expected:?} is needed")]
    Feature { field: &'static str, position: usize, expected: String, actual: String },
    #[error(
        "{recording} has no auxiliary channel {channel}, which the calibration needs (its channels: {}); give the column this name, or make it \
         \"auxiliary\" in a column map", if .found.is_empty() { "none" } else { .found }
    )]
    Auxiliary { recording: String, channel: String, found: String },
    #[error("features: {0}")]
    Features(#[from] FeatureError),
    #[error("learned: {0}")]
    Learned(#[from] LearnedError),
    #[error("{recording} has the gauges {} where the calibration was made for {}", .actual.join(" "), .expected.join(" "))]
    Gauges { recording: String, expected: Vec<String>, actual: Vec<String> },
}
