//! `loopscope completions` and `loopscope man`: print or write files that a package installs with the program.

use std::io::{self, Write as _};
use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

use super::{
    error::JobError,
    run::{Run, Work, examples, make_directory},
};

/// Print the script that completes the program's arguments in a shell.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope completions bash > ~/.local/share/bash-completion/completions/loopscope", "installs the completions for one user"),
    ("loopscope completions zsh > ~/.zfunc/_loopscope", "installs the completions, if ~/.zfunc is in fpath"),
]))]
pub struct CompletionsJob {
    /// Shell for which the script is.
    #[arg(value_enum)]
    shell: Shell,
}

impl Work for CompletionsJob {
    fn run(&self, run: &Run) -> Result<(), JobError> {
        // The text is made in memory first, because clap panics if the output is closed.
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut (run.command)(), "loopscope", &mut text);
        Ok(io::stdout().write_all(&text)?)
    }
}

/// Write the manual pages.
#[derive(Debug, Args)]
#[command(hide = true)]
pub struct ManJob {
    /// Folder to write to. A missing folder is created.
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
