//! Errors of jobs, and their exit codes.

use std::error::Error;
use std::fmt;
use std::io;
use std::process::ExitCode;

use crate::export::{TargetError, interrupted_code};
use crate::finding::{Advice, Face};
use crate::import::ReadError;
use crate::import::map::MapFileError;
use crate::recording::TareError;

/// Exit code for wrong arguments, the same as clap's.
const USAGE: u8 = 2;
/// Exit code for recordings that do not determine the model, and for calibrations that exceed their limits.
const NOT_MET: u8 = 3;

/// Exit code for live rows whose source broke off.
const SOURCE_ENDED: u8 = 4;

#[derive(Debug)]
pub enum JobError {
    Usage(String),
    /// The recordings do not determine the model, or the calibration exceeds its limits.
    NotMet(String),
    /// The user stopped the job. The results found so far are written.
    Interrupted,
    /// The source of live rows broke off.
    SourceEnded(String),
    /// Standard output cannot be written to.
    Output(io::Error),
    Other(Box<dyn Error>),
}

pub fn usage<T>(message: impl Into<String>) -> Result<T, JobError> {
    Err(JobError::Usage(message.into()))
}

pub fn not_met<T>(message: impl Into<String>) -> Result<T, JobError> {
    Err(JobError::NotMet(message.into()))
}

/// Returns an error that no argument caused.
pub fn failed<T>(message: impl Into<String>) -> Result<T, JobError> {
    Err(JobError::other(message.into()))
}

impl JobError {
    /// Returns an error with this message that no argument caused.
    pub fn other(message: String) -> Self {
        Self::Other(message.into())
    }

    pub fn code(&self) -> ExitCode {
        match self {
            Self::Usage(_) => ExitCode::from(USAGE),
            Self::NotMet(_) => ExitCode::from(NOT_MET),
            Self::SourceEnded(_) => ExitCode::from(SOURCE_ENDED),
            Self::Interrupted => ExitCode::from(interrupted_code()),
            Self::Output(_) | Self::Other(_) => ExitCode::FAILURE,
        }
    }
}

impl fmt::Display for JobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(message) | Self::NotMet(message) | Self::SourceEnded(message) => {
                f.write_str(message)
            }
            Self::Interrupted => f.write_str("interrupted before all models were tried"),
            Self::Output(error) => write!(f, "cannot write to standard output: {error}"),
            Self::Other(error) => f.write_str(&in_words(&**error)),
        }
    }
}

/// Converts an error, and words it for the command line.
fn in_words(error: &(dyn Error + 'static)) -> String {
    fn of<E: Advice + Error + 'static>(error: &(dyn Error + 'static)) -> Option<String> {
        Some(error.downcast_ref::<E>()?.text(Face::CommandLine))
    }
    let known = [of::<ReadError>, of::<TareError>, of::<MapFileError>, of::<TargetError>];
    known.iter().find_map(|of| of(error)).unwrap_or_else(|| error.to_string())
}

/// Treats an I/O error without a file name as an error of standard output, because errors of files name their file.
impl<E: Error + 'static> From<E> for JobError {
    fn from(error: E) -> Self {
        match (Box::new(error) as Box<dyn Error>).downcast() {
            Ok(of_output) => Self::Output(*of_output),
            Err(other) => Self::Other(other),
        }
    }
}
