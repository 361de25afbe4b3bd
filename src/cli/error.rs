//! Errors of a command-line job, with the exit code of each.

use std::error::Error;
use std::fmt;
use std::io;
use std::process::ExitCode;

use crate::{
    export::{TargetError, interrupted_code},
    finding::{Advice, Face},
    import::{ReadError, map::MapFileError},
    recording::RecordingError,
};

#[derive(Debug)]
pub enum JobError {
    /// A command-line argument is wrong.
    Usage(String),
    /// The recordings do not determine the model, a figure of the calibration exceeds its limit, or a search for the best model
    /// is unfinished.
    NotMet(String),
    /// The user stopped the job. The results up to then have been printed.
    Interrupted,
    /// The source of live rows (standard input or a growing file) can no longer be read.
    SourceEnded(String),
    /// Standard output cannot be written.
    Output(io::Error),
    Other(Box<dyn Error>),
}

pub fn usage<T>(message: impl Into<String>) -> Result<T, JobError> {
    Err(JobError::Usage(message.into()))
}

/// Returns an error whose cause is not a wrong argument.
pub fn failed<T>(message: impl Into<String>) -> Result<T, JobError> {
    Err(JobError::other(message.into()))
}

impl JobError {
    pub fn other(message: String) -> Self {
        Self::Other(message.into())
    }

    pub fn code(&self) -> ExitCode {
        match self {
            Self::Usage(_) => ExitCode::from(2), // clap's own code
            Self::NotMet(_) => ExitCode::from(3),
            Self::SourceEnded(_) => ExitCode::from(4),
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

/// Returns the message of an error. It names the command-line options that help.
fn in_words(error: &(dyn Error + 'static)) -> String {
    fn of<E: Advice + Error + 'static>(error: &(dyn Error + 'static)) -> Option<String> {
        Some(error.downcast_ref::<E>()?.text(Face::CommandLine))
    }
    let known = [of::<ReadError>, of::<RecordingError>, of::<MapFileError>, of::<TargetError>];
    known.iter().find_map(|of| of(error)).unwrap_or_else(|| error.to_string())
}

/// Converts the error of another module. An I/O error that names no file comes from writing to standard output.
impl<E: Error + 'static> From<E> for JobError {
    fn from(error: E) -> Self {
        match (Box::new(error) as Box<dyn Error>).downcast() {
            Ok(of_output) => Self::Output(*of_output),
            Err(other) => Self::Other(other),
        }
    }
}
