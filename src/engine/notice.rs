//! What the program has to say: errors, warnings and news, kept until they are dismissed.

use crate::shown::message;

/// How much a notice matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Something went as asked.
    Info,
    /// Something was read differently from how it was written.
    Warning,
    /// Something that was asked for could not be done.
    Error,
}

/// One thing to say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// How much it matters.
    pub level: Level,
    /// One or two sentences.
    pub text: String,
    /// Which it is of all that was said, from one; zero before it was said.
    pub number: u64,
}

impl Notice {
    /// A notice of this level; what files would have a reader see other than it is stands there by its codes.
    pub fn new(level: Level, text: impl Into<String>) -> Self {
        let text = message(&text.into());
        Self { level, text, number: 0 }
    }
}
