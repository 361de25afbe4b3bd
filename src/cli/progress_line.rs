//! How far a long job is: one line on standard error, where that is a terminal.

use std::io::{self, IsTerminal as _, Write as _};

use crate::progress::Progress;

/// The line; it replaces itself.
#[derive(Default)]
pub(super) struct ProgressLine {
    shown: Option<String>,
}

impl ProgressLine {
    /// Shows the done share.
    pub fn show(&mut self, progress: &Progress) {
        if let Some(fraction) = progress.fraction() {
            self.say(&format!("{:.0} %", 100.0 * fraction));
        }
    }

    /// Shows a text in place of the last one.
    pub fn say(&mut self, text: &str) {
        let mut out = io::stderr();
        if out.is_terminal() && self.shown.as_deref() != Some(text) {
            // Nobody misses a line that cannot be written.
            let _ = write!(out, "\r\x1b[K{text}");
            self.shown = Some(text.to_owned());
        }
    }

    /// Takes the line away.
    pub fn end(&mut self) {
        if self.shown.take().is_some() {
            let _ = write!(io::stderr(), "\r\x1b[K");
        }
    }
}
