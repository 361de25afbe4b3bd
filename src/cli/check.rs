//! `loopscope check`: whether the recordings carry the model, before anybody trusts the matrix.

use std::io::{self, Write as _};
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use super::choices::ModelArgs;
use super::error::{JobError, not_met};
use super::examples::examples;
use super::inputs::Files;
use super::recordings::RecordingArgs;
use super::run::{Run, Work};
use super::values::{named_file, number_in};
use crate::features::Range;
use crate::finding::{Face, Verdict};
use crate::questions::check::independent_loads::Sufficiency;
use crate::questions::check::query::{CheckData, sufficiency};
use crate::questions::check::sufficiency_tables;
use crate::questions::{HangingMass, Request};

/// Say whether the recordings carry the model: what they reach, load cases for coefficients, and which to record next.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope check day1.csv day2.csv --mass 1,2,5", "is it enough, and which masses to hang next; exit code 3 if not"),
]))]
pub struct CheckJob {
    /// Recordings to fit, as after --train; without any, those of the built-in simulated sensor.
    #[arg(value_name = "FILE", conflicts_with = "train", value_parser = named_file())]
    files: Vec<PathBuf>,
    #[command(flatten)]
    recordings: RecordingArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Propose only loads that a hanging mass makes, the sensor turned any way: the masses that there are, in kg.
    #[arg(long, value_name = "KG,…", value_delimiter = ',', value_parser = number_in(Range::Positive))]
    mass: Vec<f64>,
    /// How far from the sensor's origin these masses can hang, in m, along its axes; 0 is right at it, where they hang in any case.
    #[arg(long, value_name = "M,…", value_delimiter = ',', value_parser = number_in(Range::NotNegative), requires = "mass")]
    arm: Vec<f64>,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    json: bool,
}

/// What `check --json` prints.
#[derive(Serialize)]
struct Report<'a> {
    simulated: bool,
    features: String,
    #[serde(flatten)]
    found: &'a Sufficiency,
}

impl Work for CheckJob {
    fn files(&self) -> Files<'_> {
        let named = self.recordings.files();
        match self.files.is_empty() {
            true => named,
            false => Files { recordings: &self.files, ..named },
        }
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        let set = self.recordings.read(run, &self.model.rated())?;
        let settings = self.model.settings(&run.say, &set);
        let features = settings.features.describe();
        let simulated = set.is_simulated();
        let hanging = HangingMass { masses: self.mass.clone(), arms: self.arm.clone() };
        let hanging = Some(hanging).filter(|own| !own.masses.is_empty());
        let request = Request::fit(Arc::new(set), settings);
        let range = self.recordings.read.gauge_range.clone();
        let found = sufficiency(&CheckData::of(&request, range, hanging), &run.progress)?;
        let report = Report { simulated, features, found: &found };
        run.print(self.json, &report, |out| print(&report, out))?;
        match found.verdict {
            Verdict::Enough | Verdict::Doubtful => Ok(()),
            Verdict::Insufficient => not_met("the recordings do not carry the model"),
        }
    }
}

/// For people: the verdict, its reasons, then the figures.
fn print(report: &Report<'_>, out: &mut Vec<u8>) -> io::Result<()> {
    let found = report.found;
    if report.simulated {
        writeln!(out, "The built-in simulated sensor")?;
    }
    writeln!(out, "{}.", found.verdict.words())?;
    for sentence in found.sentences(Face::CommandLine) {
        writeln!(out, "* {sentence}")?;
    }
    writeln!(out, "\n{}", found.holds_for)?;
    writeln!(out, "{}", found.rank_in_words())?;
    for table in sufficiency_tables(found) {
        writeln!(out, "\n{}", table.text().trim_end())?;
    }
    Ok(())
}
