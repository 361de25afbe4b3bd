//! Starts the program: opens the window, or runs the one job that the command line gives.

use std::ffi::OsString;
use std::process::ExitCode;

use loopscope::cli;
use loopscope::cli::Cli;

fn main() -> ExitCode {
    loopscope::logged::start();
    loopscope::export::clean_up_when_asked_to_end();
    let words: Vec<OsString> = std::env::args_os().collect();
    let Cli { job, files } = Cli::understood(&words).unwrap_or_else(|error| error.exit());
    match job {
        Some(job) => cli::run(&job),
        None => open_window(files),
    }
}

#[cfg(feature = "gui")]
fn open_window(files: Vec<std::path::PathBuf>) -> ExitCode {
    loopscope::ui::open_window(files)
}

#[cfg(not(feature = "gui"))]
fn open_window(_files: Vec<std::path::PathBuf>) -> ExitCode {
    cli::print_message(
        &"this build has no window; use `loopscope fit`, `apply` or `demo` (see --help)",
    );
    ExitCode::FAILURE
}
