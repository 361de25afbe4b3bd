//! Errors in the samples, the settings or the training of a network, or in a network from a file.

use std::fmt;

use crate::calibration::entries::WrongEntries;
use crate::features::OutOfRange;
use crate::progress::Cancelled;

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
pub enum NetworkError {
    #[error(transparent)]
    Setting(#[from] OutOfRange),
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
    #[error("the training was cancelled before the end of the first epoch")]
    Cancelled,
    #[error("the network's {0}")]
    Entries(#[from] WrongEntries),
}

impl From<Cancelled> for NetworkError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}
