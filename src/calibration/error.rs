//! Reasons why a calibration cannot be fitted, trained, read or used.

use std::fmt;

use crate::{features::FeatureError, progress::Cancelled, recording::Axis};

/// Value of the field `format` of a calibration file.
pub const FORMAT: &str = "loopscope calibration";
/// Version of the file that this program writes and reads.
pub const VERSION: u32 = 2;

/// Largest magnitude of a gauge value, a load, or a number of a calibration that is accepted. Products and sums of squares of
/// larger numbers could overflow.
pub const LARGEST: f64 = 1e100;

/// Column of the samples that an error is about. Its index counts from zero, but the text of the error counts from one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// Column of an input feature, with its index.
    Input(usize),
    /// Column of a target (load axis), with its index.
    Target(usize),
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(column) => write!(f, "input column {}", column + 1),
            Self::Target(column) => write!(f, "target column {}", column + 1),
        }
    }
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    #[error("not a calibration file: {reason}")]
    Json { reason: String },
    #[error("this is not a calibration: its \"format\" is not \"{FORMAT}\"")]
    Format,
    #[error("the calibration has version {version}; this program reads version {VERSION}")]
    Version { version: u32 },
    #[error("the calibration has no {what}")]
    Nothing { what: &'static str },
    #[error("the axes must be distinct and in the order Fx Fy Fz Mx My Mz")]
    AxisOrder,
    #[error(
        "{field} has {actual} entries, but it must have {expected}; restore the file or fit again"
    )]
    Length { field: String, expected: usize, actual: usize },
    #[error(
        "{field} holds {value:?}, which is not a number from {least:?} to {LARGEST:?}; restore the file, or fit in other units"
    )]
    Number { field: String, value: f64, least: f64 },
    #[error("the unit of {axis} is {actual:?} where {expected:?} is needed")]
    Unit { axis: &'static str, expected: &'static str, actual: String },
    #[error(
        "the sensor frame adds a part of {missing} to {axis}, but the calibration has no {missing}"
    )]
    Frame { axis: Axis, missing: Axis },
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
    #[error(transparent)]
    Features(#[from] FeatureError),
    #[error("the full scale of axis {position} is {value}; it must be a number above zero")]
    FullScale { position: usize, value: f64 },
    #[error("the reference value of {name} is {value}; it must be a finite number")]
    AuxiliaryReference { name: String, value: f64 },
    #[error("a network needs at least one input and one target column")]
    NoColumns,
    #[error(
        "there are no {which} samples; load a recording for them, or change the role of a recording"
    )]
    NoSamples { which: &'static str },
    #[error(
        "the held-out samples have {actual} {what} columns, but the training samples have {expected}; use the same features for both"
    )]
    HeldOutColumns { what: &'static str, expected: usize, actual: usize },
    #[error(
        "{column} is {value} at sample {}; correct this sample or leave it out", .sample + 1
    )]
    NotFinite { column: Column, sample: usize, value: f64 },
    #[error(
        "{column} is {value} at sample {}, too far from the others for a network; leave this sample out, or use a larger unit", .sample + 1
    )]
    TooLarge { column: Column, sample: usize, value: f64 },
    #[error(
        "the training diverged: the {which} loss is not finite in epoch {epoch}; choose a learning rate below {learning_rate}, or leave out samples far from the others"
    )]
    Diverged { which: &'static str, epoch: usize, learning_rate: f64 },
    #[error(
        "{landmarks} landmarks are more than the {samples} training samples; choose fewer landmarks"
    )]
    FewSamples { landmarks: usize, samples: usize },
    #[error(
        "the kernel matrix of the landmarks is singular for every length scale; choose fewer landmarks or a smaller length scale"
    )]
    Singular,
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("{recording} has the gauges {} where the calibration was made for {}", .actual.join(" "), .expected.join(" "))]
    Gauges { recording: String, expected: Vec<String>, actual: Vec<String> },
}
