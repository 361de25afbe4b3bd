//! Why a job could not be done, and the exit code that says so.

use std::error::Error;
use std::fmt;
use std::io;
use std::process::ExitCode;

use crate::export::{TargetError, interrupted_code};
use crate::finding::{Advice, Face};
use crate::import::ReadError;
use crate::import::map::MapFileError;
use crate::recording::TareError;

/// What scripts know wrong arguments by; clap has the same.
const USAGE: u8 = 2;
/// Exit code for recordings that do not carry their model, and for calibrations that exceed their limits.
const NOT_MET: u8 = 3;

/// Exit code for rows whose source hung up before its end.
const SOURCE_ENDED: u8 = 4;

/// Why a job could not be done.
#[derive(Debug)]
pub enum JobError {
    /// The arguments are wrong.
    Usage(String),
    /// The recordings do not carry their model, or the calibration exceeds its limits.
    NotMet(String),
    /// The user stopped the work; what had been found by then is written.
    Interrupted,
    /// The source of rows cannot be read any more.
    SourceEnded(String),
    /// Nothing more can be written to standard output.
    Output(io::Error),
    /// Anything else.
    Other(Box<dyn Error>),
}

/// Says that an argument is wrong.
pub fn usage<T>(message: impl Into<String>) -> Result<T, JobError> {
    Err(JobError::Usage(message.into()))
}

/// Says what is wanting in the recordings or the calibration.
pub fn not_met<T>(message: impl Into<String>) -> Result<T, JobError> {
    Err(JobError::NotMet(message.into()))
}

/// Says what went wrong, whatever the arguments.
pub fn failed<T>(message: impl Into<String>) -> Result<T, JobError> {
    Err(JobError::other(message.into()))
}

impl JobError {
    /// Returns the error with this message, which is about no argument.
    pub fn other(message: String) -> Self {
        Self::Other(message.into())
    }

    /// Returns the exit code.
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
            Self::Interrupted => f.write_str("interrupted: more models were to be tried"),
            Self::Output(error) => write!(f, "cannot write to standard output: {error}"),
            Self::Other(error) => f.write_str(&in_words(&**error)),
        }
    }
}

/// An error in words of the command line.
fn in_words(error: &(dyn Error + 'static)) -> String {
    fn of<E: Advice + Error + 'static>(error: &(dyn Error + 'static)) -> Option<String> {
        Some(error.downcast_ref::<E>()?.text(Face::CommandLine))
    }
    let known = [of::<ReadError>, of::<TareError>, of::<MapFileError>, of::<TargetError>];
    known.iter().find_map(|of| of(error)).unwrap_or_else(|| error.to_string())
}

/// An error of a stream without a name is one of standard output: errors of files say which file they are of.
impl<E: Error + 'static> From<E> for JobError {
    fn from(error: E) -> Self {
        match (Box::new(error) as Box<dyn Error>).downcast() {
            Ok(of_output) => Self::Output(*of_output),
            Err(other) => Self::Other(other),
        }
    }
}
