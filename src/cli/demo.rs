//! `loopscope demo`: the recordings of the built-in simulated sensor as files.

use std::io::Write as _;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::error::JobError;
use super::examples::examples;
use super::run::{Run, Work, make_directory};
use crate::export::Together;
use crate::formats::csv::write_csv;
use crate::recording::Recording;
use crate::recording::simulated;
use crate::recording::simulated::Late;

const README: &str = "\
These recordings are simulated: the program's built-in sensor made them, no real one.
train_*.csv are for fitting, test_*.csv for scoring; lag_*, hysteresis_* and both_*.csv show a low-pass of 30 ms and play of
0.5 N. Times in s, gauges in mV/V, forces in N, moments in N·m.
";

/// How much of the built-in recordings is written.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Pattern {
    /// All samples, 20 Hz.
    A = 1,
    /// Every tenth sample, 2 Hz.
    B = 10,
}

/// What the gauges of a set for telling lag from hysteresis have.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Shown {
    /// A time lag of 30 ms, and no hysteresis.
    Lag,
    /// Hysteresis of 10 % of full scale, and no lag.
    Hysteresis,
    /// Both.
    Both,
}

/// Write the built-in simulated sensor's recordings as CSV: `train_*.csv` and `test_*.csv`.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope demo recordings", "simulated recordings to try the rest on"),
    ("loopscope demo both --show both", "a sensor with a time lag and hysteresis; metrology both/*.csv tells them apart"),
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
    /// Instead, three recordings of one force on two gauges that show what tells a time lag from hysteresis.
    #[arg(long, value_enum, value_name = "WHAT", conflicts_with = "pattern")]
    show: Option<Shown>,
    /// Write over files that are there already.
    #[arg(long)]
    force: bool,
}

impl Work for DemoJob {
    fn run(&self, run: &Run) -> Result<(), JobError> {
        make_directory(&self.dir)?;
        let recordings: Vec<Recording> = match self.show {
            None => {
                let set = simulated::recordings(self.seed);
                let entries = set.entries().iter();
                entries.map(|entry| entry.recording.decimated(self.pattern as usize)).collect()
            }
            Some(Shown::Lag) => simulated::late(self.seed, Late::Lag),
            Some(Shown::Hysteresis) => simulated::late(self.seed, Late::Hysteresis),
            Some(Shown::Both) => simulated::late(self.seed, Late::Both),
        };
        let n = recordings.len();
        let names = recordings.iter().map(|own| format!("{}.csv", own.name()));
        let names = names.chain(["README.txt".to_owned()]);
        let files: Vec<PathBuf> = names.map(|name| self.dir.join(name)).collect();
        run.check_outputs(&files, self.force)?;
        let mut written = Together::default();
        for (recording, path) in recordings.iter().zip(&files) {
            written.write(path, |mut out| write_csv(recording, &mut out))?;
        }
        written.write(&files[n], |out| out.write_all(README.as_bytes()))?;
        written.finish()?;
        run.print_text(|out| writeln!(out, "{n} simulated recordings in {}", self.dir.display()))
    }
}
