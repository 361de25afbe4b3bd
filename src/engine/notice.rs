//! Notices of the window: errors, warnings and information, kept until the user dismisses them.

use crate::shown::message;

/// Severity of a notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// The action succeeded.
    Info,
    /// The action succeeded, but something needs the user's attention.
    Warning,
    /// The action failed.
    Error,
}

/// Message to the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Severity.
    pub level: Level,
    /// Text of one or two sentences.
    pub text: String,
    /// Number of the notice since the start of the program, from 1; 0 until it is shown.
    pub number: u64,
}

impl Notice {
    /// Creates a notice. Control characters in the text are replaced by their codes.
    pub fn new(level: Level, text: impl Into<String>) -> Self {
        let text = message(&text.into());
        Self { level, text, number: 0 }
    }
}
