//! Reasons why there are no loops, cross-plots or dwells to plot.

use crate::calibration::CalibrationError;
use crate::progress::Cancelled;
use crate::questions::metrology::{MetrologyError, Reason};
use crate::questions::question::Unanswered;

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the error text of each variant says what its fields are")]
pub enum LookError {
    #[error("no samples to plot; choose a recording, or show a longer interval in Traces")]
    NoSamples,
    #[error(
        "no recording has the chosen role; assign this role to a recording, or choose all recordings"
    )]
    NoRecordings,
    #[error("the chosen recordings do not have this channel; choose another channel")]
    NoChannel,
    #[error(
        "no recording has a dwell of {secs} s or longer, in which every axis stays within its stability tolerance; record a dwell, or choose a shorter dwell"
    )]
    NoDwell { secs: f64 },
    #[error(transparent)]
    Reason(#[from] Reason),
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    #[error(transparent)]
    Metrology(#[from] MetrologyError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<LookError> for Unanswered {
    fn from(error: LookError) -> Self {
        match error {
            LookError::Cancelled(_) => Self::Cancelled,
            error => Self::Because(error.to_string()),
        }
    }
}
