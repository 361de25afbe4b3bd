//! `loopscope demo`: the recordings of the built-in simulated sensor as files.

use std::io::Write as _;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::error::JobError;
use super::examples::examples;
use super::run::{Run, Work, make_directory};
use crate::export::Together;
use crate::formats::csv::write_csv;
use crate::recording::simulated;

const README: &str = "\
These recordings are simulated: the program's built-in sensor made them, no real one.
train_*.csv are for fitting, test_*.csv for scoring. Times in s, gauges in mV/V, forces in N, moments in N·m.
";

/// How much of the built-in recordings is written.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Pattern {
    /// All samples, 20 Hz.
    A = 1,
    /// Every tenth sample, 2 Hz.
    B = 10,
}

/// Write the built-in simulated sensor's recordings as CSV: `train_*.csv` and `test_*.csv`.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope demo recordings", "simulated recordings to try the rest on"),
]))]
pub struct DemoJob {
    /// Where to; made if it is not there.
    dir: PathBuf,
    /// The paper's amount of data: a is all of it, b every tenth sample.
    #[arg(long, value_enum, default_value = "a")]
    pattern: Pattern,
    /// Another seed makes another sensor of the same kind on other paths.
    #[arg(long, default_value_t = simulated::DEFAULT_SEED)]
    seed: u64,
    /// Write over files that are there already.
    #[arg(long)]
    force: bool,
}

impl Work for DemoJob {
    fn run(&self, run: &Run) -> Result<(), JobError> {
        make_directory(&self.dir)?;
        let set = simulated::recordings(self.seed);
        let n = set.entries().len();
        let names = set.entries().iter().map(|entry| format!("{}.csv", entry.recording.name()));
        let names = names.chain(["README.txt".to_owned()]);
        let files: Vec<PathBuf> = names.map(|name| self.dir.join(name)).collect();
        run.check_outputs(&files, self.force)?;
        let mut written = Together::default();
        for (entry, path) in set.entries().iter().zip(&files) {
            let recording = entry.recording.decimated(self.pattern as usize);
            written.write(path, |mut out| write_csv(&recording, &mut out))?;
        }
        written.write(&files[n], |out| out.write_all(README.as_bytes()))?;
        written.finish()?;
        run.print_text(|out| writeln!(out, "{n} simulated recordings in {}", self.dir.display()))
    }
}
