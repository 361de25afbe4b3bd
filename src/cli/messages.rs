//! Messages of a command-line job on standard error, and its progress line if standard error is a terminal.

use std::fmt::Display;
use std::io::{self, IsTerminal as _, Write as _};
use std::sync::{Mutex, MutexGuard};

use crate::{
    finding::{Face, Finding},
    panicked::locked,
    progress::Progress,
    shown,
};

/// Writes a message to standard error. A failed write is ignored, because the exit code also reports an error.
pub fn print_message(message: &dyn Display) {
    let message = shown::message(message);
    let _ = writeln!(io::stderr(), "loopscope: {message}");
}

#[derive(Debug, Default)]
pub struct Messages(Mutex<State>);

#[derive(Debug, Default)]
struct State {
    /// Text of the progress line, which is overwritten by the next text.
    line: Option<String>,
    findings: Vec<Finding>,
    left_out: Vec<String>,
}

impl Messages {
    fn state(&self) -> MutexGuard<'_, State> {
        locked(&self.0)
    }

    pub fn error(&self, error: &dyn Display) {
        self.end_line();
        print_message(error);
    }

    pub fn note(&self, note: impl Display) {
        self.error(&format_args!("note: {note}"));
    }

    pub fn warning(&self, warning: impl Display) {
        self.error(&format_args!("warning: {warning}"));
    }

    /// Prints a finding as a warning, and keeps it for [`Messages::findings`].
    pub fn finding(&self, found: Finding) {
        self.warning(found.text(Face::CommandLine));
        self.state().findings.push(found);
    }

    pub fn findings(&self) -> Vec<Finding> {
        self.state().findings.clone()
    }

    pub fn left_out(&self, error: &dyn Display) {
        self.error(&format_args!("left out: {error}"));
        self.state().left_out.push(error.to_string());
    }

    pub fn files_left_out(&self) -> Vec<String> {
        self.state().left_out.clone()
    }

    pub fn show(&self, progress: &Progress) {
        if let Some(fraction) = progress.fraction() {
            self.line(&format!("{:.0} %", 100.0 * fraction));
        }
    }

    pub fn line(&self, text: &str) {
        let mut out = io::stderr();
        let mut state = self.state();
        if out.is_terminal() && state.line.as_deref() != Some(text) {
            // A failed write is ignored, because the job does not need its progress line.
            let _ = write!(out, "\r\x1b[K{text}");
            state.line = Some(text.to_owned());
        }
    }

    pub fn end_line(&self) {
        if self.state().line.take().is_some() {
            let _ = write!(io::stderr(), "\r\x1b[K");
        }
    }
}
