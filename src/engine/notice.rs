//! Messages to the user (errors, warnings and information), which the window shows until the user dismisses them.

use crate::shown::message;

/// Severity of a message to the user.
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
    /// Text of the message, in one or two sentences.
    pub text: String,
    /// Number of the message since the start of the program, from 1; 0 before it is shown.
    pub number: u64,
}

impl Notice {
    /// Creates a message to the user. Control characters in the text are replaced by their codes.
    pub fn new(level: Level, text: impl Into<String>) -> Self {
        let text = message(&text.into());
        Self { level, text, number: 0 }
    }
}
