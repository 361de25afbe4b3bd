//! What can be wrong with a network, its samples and its settings.

use std::fmt;

use crate::calibration::length::WrongLength;
use crate::features::OutOfRange;
use crate::progress::Cancelled;

/// A column of the samples, counted from zero; it shows itself counted from one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// A feature.
    Input(usize),
    /// A load axis.
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

/// Why there is no network, or why it cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NetworkError {
    #[error(transparent)]
    Setting(#[from] OutOfRange),
    #[error("a network needs at least one input and one target column")]
    NoColumns,
    #[error("there are no {which} samples; load a recording for them or change a role")]
    NoSamples { which: &'static str },
    #[error(
        "the held-out samples have {actual} {what} columns where the training samples have {expected}; describe both alike"
    )]
    HeldOutColumns { what: &'static str, expected: usize, actual: usize },
    #[error(
        "{column} is {value} at sample {}; leave that sample out or correct it", .sample + 1
    )]
    NotFinite { column: Column, sample: usize, value: f64 },
    #[error(
        "{column} is {value} at sample {}, too far from the others for a network; leave that sample out, or take a larger unit", .sample + 1
    )]
    TooLarge { column: Column, sample: usize, value: f64 },
    #[error(
        "the {which} loss was no finite number in epoch {epoch}; choose a learning rate below {learning_rate}, or leave out samples that are far from the others"
    )]
    Diverged { which: &'static str, epoch: usize, learning_rate: f64 },
    #[error("the training was cancelled before its first epoch was done")]
    Cancelled,
    #[error("the network's {0}; train it anew or restore the file")]
    Length(#[from] WrongLength),
    #[error(
        "the network's {field} holds a number that is not finite, or is negative where it must not be; train it anew or restore the file"
    )]
    Number { field: String },
}

impl From<Cancelled> for NetworkError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}
