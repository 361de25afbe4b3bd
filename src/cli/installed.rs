//! What a package puts beside the program: completions for a shell, manual pages.

use std::io::{self, Write as _};
use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

use super::error::JobError;
use super::examples::examples;
use super::run::{Run, Work, make_directory};

/// Print what a shell completes the words of a command by.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope completions bash > ~/.local/share/bash-completion/completions/loopscope", "for one user"),
    ("loopscope completions zsh > ~/.zfunc/_loopscope", "where ~/.zfunc is in fpath"),
]))]
pub struct CompletionsJob {
    /// For which shell.
    #[arg(value_enum)]
    shell: Shell,
}

impl Work for CompletionsJob {
    fn run(&self, run: &Run) -> Result<(), JobError> {
        // In memory first: what is written to a pipe that closes must be no panic.
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut (run.command)(), "loopscope", &mut text);
        Ok(io::stdout().write_all(&text)?)
    }
}

/// Write the manual pages.
#[derive(Debug, Args)]
#[command(hide = true)]
pub struct ManJob {
    /// Where to; made if it is not there.
    dir: PathBuf,
}

impl Work for ManJob {
    fn run(&self, run: &Run) -> Result<(), JobError> {
        make_directory(&self.dir)?;
        clap_mangen::generate_to((run.command)(), &self.dir).map_err(|error| {
            let dir = self.dir.display();
            JobError::other(format!("cannot write the manual pages to {dir}: {error}"))
        })
    }
}
