//! What every job does the same: its files are found and checked before the work, and what comes of it is printed.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;

use super::error::{JobError, failed};
use super::inputs::{Files, Inputs};
use super::messages::Messages;
use crate::export::check_targets;
use crate::progress::Progress;
use crate::shown::printable;

/// One job with its arguments.
pub trait Work {
    /// Returns the files that it is told of.
    fn files(&self) -> Files<'_> {
        Files::default()
    }

    /// Does the work, once its files are found and its outputs can be written.
    fn run(&self, run: &Run) -> Result<(), JobError>;
}

/// One run of a job.
pub struct Run {
    pub inputs: Inputs,
    pub say: Messages,
    pub progress: Progress,
    /// The program's command line.
    pub command: fn() -> clap::Command,
}

/// Does a job; errors go to standard error, one line each.
pub fn run(work: &dyn Work, command: fn() -> clap::Command) -> ExitCode {
    let mut run = Run {
        inputs: Inputs::default(),
        say: Messages::default(),
        progress: Progress::default(),
        command,
    };
    match run.done(work) {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever reads our output had enough (`| head`): no error of ours.
        Err(JobError::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            ExitCode::SUCCESS
        }
        Err(error) => {
            run.say.error(&error);
            error.code()
        }
    }
}

impl Run {
    fn done(&mut self, work: &dyn Work) -> Result<(), JobError> {
        let files = work.files();
        self.inputs = files.opened(&self.say)?;
        self.check_outputs(&files.written, files.force)?;
        work.run(self)?;
        match self.say.n_left_out() {
            0 => Ok(()),
            count => {
                let why = "left out because they could not be read";
                failed(format!("{why}: {count}"))
            }
        }
    }

    /// Checks that each file can be written, and is none of those that are read.
    pub fn check_outputs(&self, outputs: &[PathBuf], force: bool) -> Result<(), JobError> {
        Ok(check_targets(self.inputs.paths(), outputs, force)?)
    }

    /// Prints what was found: for scripts, or for people.
    pub fn print(
        &self,
        json: bool,
        report: &impl Serialize,
        text: impl FnOnce(&mut Vec<u8>) -> io::Result<()>,
    ) -> Result<(), JobError> {
        match json {
            true => self.print_json(report),
            false => self.print_text(text),
        }
    }

    /// Prints what was found, for scripts.
    pub fn print_json(&self, report: &impl Serialize) -> Result<(), JobError> {
        self.say.end_line();
        let mut out = io::stdout().lock();
        serde_json::to_writer_pretty(&mut out, report).map_err(io::Error::from)?;
        Ok(writeln!(out)?)
    }

    /// Prints a text for people; what cannot be seen in it is shown by its code.
    pub fn print_text(
        &self,
        text: impl FnOnce(&mut Vec<u8>) -> io::Result<()>,
    ) -> Result<(), JobError> {
        let mut lines = Vec::new();
        text(&mut lines)?;
        self.say.end_line();
        let mut out = io::stdout().lock();
        for line in String::from_utf8_lossy(&lines).lines() {
            writeln!(out, "{}", printable(line))?;
        }
        Ok(())
    }

    /// Prints the name of a file that was written.
    pub fn print_path(&self, path: &Path) -> Result<(), JobError> {
        self.print_text(|out| writeln!(out, "{}", path.display()))
    }
}

/// Makes the folder for files that are to be written.
pub fn make_directory(path: &Path) -> Result<(), JobError> {
    std::fs::create_dir_all(path).map_err(|error| {
        JobError::other(format!("cannot make the directory {}: {error}", path.display()))
    })
}
