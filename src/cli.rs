//! The command line. It opens the window, or runs one job without a window, for scripts and machines without a display.

mod apply;
mod best;
mod check;
mod choices;
mod demo;
mod error;
mod exports;
mod fit;
mod inputs;
mod inspect;
mod installed;
mod live;
mod messages;
mod metrology;
mod plot;
mod reading;
mod recordings;
mod report;
mod run;
mod sensor;
mod sweep;
mod traces;
mod values;

use std::error::Error as _;
use std::ffi::OsString;
use std::num::{ParseFloatError, ParseIntError};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory as _, Parser, Subcommand};

use run::examples;

use crate::{about, shown::printable};

pub use messages::print_message;

/// Calibrate force/torque sensors, and compensate their hysteresis.
#[derive(Debug, Parser)]
#[command(
    version,
    long_version = about::long_version(),
    after_help = examples(&[
        ("loopscope", "opens the window with the built-in simulated sensor"),
        ("loopscope press_*.csv test.csv", "opens the window with these recordings"),
        ("loopscope work.json", "opens a session or a calibration in the window"),
    ]),
    args_conflicts_with_subcommands = true
)]
pub struct Cli {
    /// The job to run. Without a job, the window opens.
    #[command(subcommand)]
    pub job: Option<Job>,
    /// Recordings, a session or a calibration to open in the window. `inspect --help` lists the file formats of recordings.
    pub files: Vec<PathBuf>,
}

impl Cli {
    /// Parses the words of the command line, of which the first is the program's name.
    ///
    /// # Errors
    /// An error with a tip, if a word is unknown, a value is wrong, or a file does not exist.
    pub fn understood(words: &[OsString]) -> Result<Self, clap::Error> {
        let mut cli = Self::try_parse_from(words)
            .map_err(|error| misspelt(words).unwrap_or_else(|| with_way_out(error, words)))?;
        cli.files = inputs::expanded(&cli.files).collect();
        match cli.files.iter().find(|path| !path.exists()) {
            Some(gone) => Err(misspelt(words).unwrap_or_else(|| {
                let gone = printable(&gone.to_string_lossy()).into_owned();
                let message = format!("{gone}: there is no such file, and no such command");
                Self::command().error(ErrorKind::ValueValidation, message)
            })),
            None => Ok(cli),
        }
    }
}

/// Returns the error for a misspelt command: a first word that resembles a command and is no file.
fn misspelt(words: &[OsString]) -> Option<clap::Error> {
    let [program, word, ..] = words else {
        return None;
    };
    let is_word = |text: &str| !text.starts_with('-') && !text.contains(['.', '/', '\\']);
    if !word.to_str().is_some_and(is_word) || Path::new(word).exists() {
        return None;
    }
    let command = Cli::command();
    // Only the jobs are searched for a similar word. The FILE argument that opens the window would accept any word.
    let jobs = clap::Command::new("loopscope").subcommands(command.get_subcommands().cloned());
    let error = jobs.try_get_matches_from([program, word]).err()?;
    let is_like_one = error.get(ContextKind::SuggestedSubcommand).is_some();
    is_like_one.then_some(error)
}

/// Adds a tip to two errors of clap: for a number that is given with a unit, and for recordings that are named without
/// `--train`.
fn with_way_out(mut error: clap::Error, words: &[OsString]) -> clap::Error {
    let is_not = match error.source() {
        Some(why) if why.is::<ParseFloatError>() => {
            Some("this is not a number; write it without a unit, as in 0.5 or 15")
        }
        Some(why) if why.is::<ParseIntError>() => {
            Some("this is not a whole number; write it with digits alone, as in 10")
        }
        _ => None,
    };
    if let (Some(is_not), Some(value), Some(name)) =
        (is_not, error.get(ContextKind::InvalidValue), error.get(ContextKind::InvalidArg))
    {
        let message = format!("invalid value '{value}' for '{name}': {is_not}\n");
        return clap::Error::raw(error.kind(), message);
    }
    let command = Cli::command();
    let job = words.get(1).and_then(|word| command.find_subcommand(word));
    let takes_train = |job: &clap::Command| job.get_arguments().any(|arg| arg.get_id() == "train");
    if error.kind() == ErrorKind::UnknownArgument
        && let Some(job) = job.filter(|job| takes_train(job))
        && let Some(ContextValue::String(bare)) = error.get(ContextKind::InvalidArg)
        && !bare.starts_with('-')
    {
        let tip = format!("write --train before the recordings: {} --train {bare}", job.get_name());
        let tips = ContextValue::StyledStrs(vec![tip.into()]);
        error.insert(ContextKind::Suggested, tips);
    }
    error
}

/// Defines the enum of jobs. A new job needs one file, a `mod` line above and one line in this list. The help text of a job
/// is the doc comment of its struct.
macro_rules! jobs {
    ($($name:ident($job:ty)),* $(,)?) => {
        /// Jobs that run without a window.
        #[derive(Debug, Subcommand)]
        #[expect(missing_docs, reason = "a doc comment here would replace the job's own help text")]
        pub enum Job {
            $($name(Box<$job>)),*
        }

        impl Job {
            fn work(&self) -> &dyn run::Work {
                match self {
                    $(Self::$name(job) => &**job),*
                }
            }
        }
    };
}

jobs! {
    Inspect(inspect::InspectJob),
    Demo(demo::DemoJob),
    Fit(fit::FitJob),
    Check(check::CheckJob),
    Sensor(sensor::SensorJob),
    Report(report::ReportJob),
    Best(best::BestJob),
    Sweep(sweep::SweepJob),
    Export(exports::ExportJob),
    Apply(apply::ApplyJob),
    Metrology(metrology::MetrologyJob),
    Plot(plot::PlotJob),
    Completions(installed::CompletionsJob),
    Man(installed::ManJob),
}

/// Runs a job, and prints its errors on standard error, one line each.
pub fn run(job: &Job) -> ExitCode {
    run::run(job.work(), Cli::command)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_example_is_understood_and_every_job_has_one() {
        let command = Cli::command();
        for job in command.get_subcommands().chain([&command]).filter(|job| !job.is_hide_set()) {
            let help = job.get_after_help().map(ToString::to_string).unwrap_or_default();
            let lines = help.lines().filter_map(|line| line.strip_prefix("  loopscope"));
            let n_understood = lines.map(|line| {
                let words = line.split(" > ").next().unwrap().split(' ');
                let cli = Cli::try_parse_from(words).unwrap_or_else(|error| panic!("{error}"));
                let is_program = job.get_name() == command.get_name();
                assert_eq!(cli.job.is_none(), is_program, "{line}");
                assert!(is_program || line.contains(job.get_name()), "{line}");
            });
            assert!(n_understood.count() > 0, "{} has no example", job.get_name());
        }
    }

    /// Help texts of the command line must not mention controls of the window.
    #[test]
    fn no_help_text_mentions_clicks_panes_or_buttons() {
        let command = Cli::command();
        for mut job in command.get_subcommands().cloned() {
            let help = job.render_long_help().to_string().to_lowercase();
            for word in ["click", "press ", "pane", "button", "menu", "hover", "window", "stopped"]
            {
                let line = help.lines().find(|line| line.contains(word));
                assert_eq!(line, None, "{}: {word}", job.get_name());
            }
        }
    }

    #[test]
    fn files_alone_mean_the_window() {
        let cli = Cli::parse_from(["loopscope", "a.csv", "b.csv"]);
        assert!(cli.job.is_none());
        assert_eq!(cli.files.len(), 2);
    }

    #[test]
    fn a_split_and_test_files_exclude_each_other() {
        let both = ["loopscope", "fit", "--split", "0.5", "--test", "a.csv"];
        assert!(Cli::try_parse_from(both).is_err());
    }
}
