//! `loopscope demo`: writes the recordings of the built-in simulated sensor to files.

use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use clap::builder::TypedValueParser;

use super::{
    error::JobError,
    run::{Run, Work, examples},
    values::one_of,
};
use crate::recording::{
    Recording,
    simulated::{self, Late},
};

const README: &str = "\
These recordings are simulated by the program's built-in sensor; they are not measured.
train_*.csv are for fitting, test_*.csv for scoring. lag_*.csv have a low-pass of 30 ms, hysteresis_*.csv play of 0.5 N, and
both_*.csv have both. Times in s, gauges in mV/V, forces in N, moments in N·m.
";

fn pattern() -> impl TypedValueParser<Value = usize> {
    one_of([(1, "a", "All samples, 20 Hz"), (10, "b", "Every tenth sample, 2 Hz")])
}

fn late() -> impl TypedValueParser<Value = Late> {
    one_of([
        (Late::Lag, "lag", "A time lag of 30 ms, and no hysteresis"),
        (Late::Hysteresis, "hysteresis", "Hysteresis of 10 % of full scale, and no lag"),
        (Late::Both, "both", "A time lag of 30 ms, and hysteresis of 10 % of full scale"),
    ])
}

/// Write the recordings of the built-in simulated sensor as CSV: `train_*.csv` and `test_*.csv`.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope demo recordings", "writes simulated recordings to try the other jobs on"),
    ("loopscope demo both --show both", "writes a sensor with a time lag and hysteresis; metrology both/*.csv distinguishes them"),
]))]
pub struct DemoJob {
    /// Folder to write to. A missing folder is created.
    dir: PathBuf,
    /// Amount of data, with the names of the paper of Koike et al. (2019): a for all samples, b for every tenth.
    #[arg(long, value_parser = pattern(), default_value = "a")]
    pattern: usize,
    /// Seed of the simulation. Another seed gives another sensor of the same kind and other loads.
    #[arg(long, default_value_t = simulated::DEFAULT_SEED)]
    seed: u64,
    /// Instead of these recordings, write three of one force and two gauges that show a time lag, hysteresis, or both.
    #[arg(long, value_parser = late(), value_name = "WHAT", conflicts_with = "pattern")]
    show: Option<Late>,
    /// Overwrite existing files.
    #[arg(long)]
    force: bool,
}

impl Work for DemoJob {
    fn run(&self, run: &Run) -> Result<(), JobError> {
        let recordings: Vec<Recording> = match self.show {
            None => {
                let set = simulated::recordings(self.seed);
                let entries = set.entries().iter();
                entries.map(|entry| entry.recording.decimated(self.pattern)).collect()
            }
            Some(late) => simulated::late(self.seed, late),
        };
        let n = recordings.len();
        let readme = Some(("README.txt", README));
        run.write_recordings(&self.dir, &recordings, readme, self.force)?;
        run.print_text(|out| writeln!(out, "{n} simulated recordings in {}", self.dir.display()))
    }
}
