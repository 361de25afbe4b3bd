//! What a job says beside its results: lines on standard error, and how far it is where that is a terminal.

use std::fmt::Display;
use std::io::{self, IsTerminal as _, Write as _};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::progress::Progress;
use crate::shown;

/// Writes one line to standard error, made harmless; where nobody can hear it, the exit code still says how it went.
pub fn tell(message: &dyn Display) {
    let message = shown::message(message);
    let _ = writeln!(io::stderr(), "loopscope: {message}");
}

/// What a job says.
#[derive(Debug, Default)]
pub struct Messages(Mutex<Said>);

#[derive(Debug, Default)]
struct Said {
    /// The line that says how far the job is; it replaces itself.
    line: Option<String>,
    warnings: Vec<String>,
    n_left_out: usize,
}

impl Messages {
    fn said(&self) -> MutexGuard<'_, Said> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says why the job is not done.
    pub fn error(&self, error: &dyn Display) {
        self.end_line();
        tell(error);
    }

    /// Says what is good to know.
    pub fn note(&self, note: impl Display) {
        self.error(&format_args!("note: {note}"));
    }

    /// Warns.
    pub fn warning(&self, warning: impl Display) {
        self.error(&format_args!("warning: {warning}"));
        self.said().warnings.push(warning.to_string());
    }

    /// Returns all warnings.
    pub fn warnings(&self) -> Vec<String> {
        self.said().warnings.clone()
    }

    /// Says that a file is left out, and counts it.
    pub fn left_out(&self, error: &dyn Display) {
        self.error(&format_args!("left out: {error}"));
        self.said().n_left_out += 1;
    }

    /// Returns the number of files that were left out.
    pub fn n_left_out(&self) -> usize {
        self.said().n_left_out
    }

    /// Shows how far the work is.
    pub fn show(&self, progress: &Progress) {
        if let Some(fraction) = progress.fraction() {
            self.line(&format!("{:.0} %", 100.0 * fraction));
        }
    }

    /// Shows a text in place of the last one.
    pub fn line(&self, text: &str) {
        let mut out = io::stderr();
        let mut said = self.said();
        if out.is_terminal() && said.line.as_deref() != Some(text) {
            // Nobody misses a line that cannot be written.
            let _ = write!(out, "\r\x1b[K{text}");
            said.line = Some(text.to_owned());
        }
    }

    /// Takes the line away.
    pub fn end_line(&self) {
        if self.said().line.take().is_some() {
            let _ = write!(io::stderr(), "\r\x1b[K");
        }
    }
}
