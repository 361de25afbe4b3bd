//! What a package puts beside the program: completions for a shell, manual pages.

use std::io::{self, Write as _};
use std::path::PathBuf;

use clap::{Args, CommandFactory as _};
use clap_complete::Shell;

use super::{Cli, JobError, make_directory};

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// For which shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, Args)]
pub struct ManArgs {
    /// Where to; made if it is not there.
    dir: PathBuf,
}

/// Prints what the shell completes words by.
pub fn completions(args: &CompletionsArgs) -> Result<(), JobError> {
    let mut command = Cli::command();
    // In memory first: what is written to a pipe that closes must be no panic.
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, "loopscope", &mut text);
    io::stdout().write_all(&text)?;
    Ok(())
}

/// Writes a page for the program and one for each job.
pub fn manual(args: &ManArgs) -> Result<(), JobError> {
    make_directory(&args.dir)?;
    let written = clap_mangen::generate_to(Cli::command(), &args.dir);
    written.map_err(|source| JobError::Manual { path: args.dir.clone(), source })
}
