//! Runs a command of the command line: checks its input and output files before the work, then prints the result.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;

use super::{
    error::{JobError, failed},
    inputs::{Files, Inputs},
    messages::Messages,
};
use crate::{
    export::{Together, check_targets},
    formats::csv::write_csv,
    progress::Progress,
    recording::Recording,
    shown::printable,
};

pub trait Work {
    /// Returns the input and output files that the arguments of the command name.
    fn files(&self) -> Files<'_> {
        Files::default()
    }

    /// Does the work of the command. Before, the caller has found the input files and checked that the output files can be
    /// written.
    fn run(&self, run: &Run) -> Result<(), JobError>;
}

pub struct Run {
    pub inputs: Inputs,
    pub say: Messages,
    pub progress: Progress,
    pub command: fn() -> clap::Command,
}

/// Runs a command, and prints its errors on standard error, one line each.
pub fn run(work: &dyn Work, command: fn() -> clap::Command) -> ExitCode {
    let mut run = Run {
        inputs: Inputs::default(),
        say: Messages::default(),
        progress: Progress::default(),
        command,
    };
    match run.done(work) {
        Ok(()) => ExitCode::SUCCESS,
        // A reader of the output pipe, such as `head`, may close the pipe early; this is no error.
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
        match self.say.files_left_out().len() {
            0 => Ok(()),
            count => {
                let why = "files skipped because they could not be read";
                failed(format!("{why}: {count}"))
            }
        }
    }

    /// Checks that each output file can be written, and is not an input file.
    pub fn check_outputs(&self, outputs: &[PathBuf], force: bool) -> Result<(), JobError> {
        Ok(check_targets(self.inputs.paths(), outputs, force)?)
    }

    pub fn print(
        &self,
        json: bool,
        report: &impl Serialize,
        text: impl FnOnce(&mut Vec<u8>) -> io::Result<()>,
    ) -> Result<(), JobError> {
        if json { self.print_json(report) } else { self.print_text(text) }
    }

    pub fn print_json(&self, report: &impl Serialize) -> Result<(), JobError> {
        self.say.end_line();
        let mut out = io::stdout().lock();
        serde_json::to_writer_pretty(&mut out, report).map_err(io::Error::from)?;
        Ok(writeln!(out)?)
    }

    /// Prints the result of a command as text, in which control characters are replaced by their codes.
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

    /// Writes each recording to a CSV file with its name, and a text to another file, all in one folder.
    pub fn write_recordings(
        &self,
        folder: &Path,
        recordings: &[Recording],
        text: Option<(&str, &str)>,
        force: bool,
    ) -> Result<(), JobError> {
        make_directory(folder)?;
        let name = |one: &Recording| format!("{}.csv", one.name().replace(['/', '\\', ':'], "_"));
        let names = recordings.iter().map(name);
        let names = names.chain(text.map(|(name, _)| name.to_owned()));
        let paths: Vec<PathBuf> = names.map(|name| folder.join(name)).collect();
        self.check_outputs(&paths, force)?;
        let mut written = Together::default();
        for (recording, path) in recordings.iter().zip(&paths) {
            written.write(path, |mut out| write_csv(recording, &mut out))?;
        }
        if let (Some((_, text)), Some(path)) = (text, paths.last()) {
            written.write(path, |out| out.write_all(text.as_bytes()))?;
        }
        Ok(written.finish()?)
    }

    pub fn print_path(&self, path: &Path) -> Result<(), JobError> {
        self.print_text(|out| writeln!(out, "{}", path.display()))
    }
}

/// Returns the examples at the end of a command's help text. Each pair is a command line and its effect.
pub fn examples(examples: &[(&str, &str)]) -> String {
    let lines = examples.iter().map(|(line, effect)| format!("\n  {line}\n      {effect}"));
    "Examples:".to_owned() + &lines.collect::<String>()
}

pub fn make_directory(path: &Path) -> Result<(), JobError> {
    std::fs::create_dir_all(path).map_err(|error| {
        JobError::other(format!("cannot make the directory {}: {error}", path.display()))
    })
}
