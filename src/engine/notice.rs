//! Notices: errors, warnings and information, kept until they are dismissed.

use crate::shown::message;

/// Severity of a notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// An action succeeded.
    Info,
    /// Input was interpreted differently from how it was written.
    Warning,
    /// An action failed.
    Error,
}

/// One notice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Severity.
    pub level: Level,
    /// Text of one or two sentences.
    pub text: String,
    /// Number of the notice, counted from one; zero before it is shown.
    pub number: u64,
}

impl Notice {
    /// Creates a notice. Control characters in the text are shown by their codes.
    pub fn new(level: Level, text: impl Into<String>) -> Self {
        let text = message(&text.into());
        Self { level, text, number: 0 }
    }
}
