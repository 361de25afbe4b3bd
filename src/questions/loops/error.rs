//! Reasons why there is no plot.

use crate::calibration::CalibrationError;
use crate::progress::Cancelled;
use crate::questions::metrology::{MetrologyError, Reason};

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages describe the fields")]
pub enum LookError {
    #[error("no sample is chosen; choose a recording, or show more of the traces")]
    NoSamples,
    #[error("no recording has this role; give one this role, or choose all recordings")]
    NoRecordings,
    #[error("these recordings have no channel of this name; choose another one")]
    NoChannel,
    #[error(
        "no recording has a dwell of {secs} s (every axis within 1 % of full scale, or ten times its noise); record one, or choose a shorter time"
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
