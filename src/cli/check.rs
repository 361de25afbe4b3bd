//! `loopscope check`: whether the recordings carry the model, before anybody trusts the matrix.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use super::choices::{ModelArgs, RecordingArgs};
use super::{JobError, named_file};
use crate::finding::{Face, Verdict};
use crate::progress::Progress;
use crate::questions::check::independent_loads::Sufficiency;
use crate::questions::check::query::{CheckData, sufficiency};
use crate::questions::check::sufficiency_tables;
use crate::questions::{HangingMass, Request};
use crate::shown::printable;

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Recordings to fit, as after --train; without any, those of the built-in simulated sensor.
    #[arg(value_name = "FILE", conflicts_with = "train", value_parser = named_file())]
    files: Vec<PathBuf>,
    #[command(flatten)]
    recordings: RecordingArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Propose only loads that a hanging mass makes, the sensor turned any way: the masses that there are, in kg.
    #[arg(long, value_name = "KG,…", value_delimiter = ',', value_parser = positive)]
    mass: Vec<f64>,
    /// How far from the sensor's origin these masses can hang, in m, along its axes; 0 is right at it, where they hang in any case.
    #[arg(long, value_name = "M,…", value_delimiter = ',', value_parser = not_negative, requires = "mass")]
    arm: Vec<f64>,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    json: bool,
}

impl CheckArgs {
    /// Returns the recordings, with those that are named bare among those to train on.
    pub(super) fn moved(&mut self) -> &mut RecordingArgs {
        self.recordings.train.append(&mut self.files);
        &mut self.recordings
    }
}

fn positive(text: &str) -> Result<f64, String> {
    number(text, |number| number > 0.0).ok_or_else(|| "this is not a number above zero".to_owned())
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |number| number >= 0.0)
        .ok_or_else(|| "this is no length: a number of metres, 0 or more".to_owned())
}

fn number(text: &str, is_good: fn(f64) -> bool) -> Option<f64> {
    let number = text.trim().parse().ok();
    number.filter(|number: &f64| number.is_finite() && is_good(*number))
}

/// What `check --json` prints.
#[derive(Serialize)]
struct Report<'a> {
    simulated: bool,
    features: String,
    #[serde(flatten)]
    found: &'a Sufficiency,
}

pub(super) fn run(args: CheckArgs) -> Result<(), JobError> {
    let CheckArgs { recordings, model, mass, arm, json, .. } = args;
    let set = recordings.read(&model.rated())?;
    let settings = model.settings(&set);
    let features = settings.features.describe();
    let simulated = set.is_simulated();
    let hanging = (!mass.is_empty()).then_some(HangingMass { masses: mass, arms: arm });
    let request = Request::fit(Arc::new(set), settings);
    let asked = CheckData::of(&request, recordings.read.gauge_range.clone(), hanging);
    let found = sufficiency(&asked, &Progress::default())?;
    let mut out = io::stdout().lock();
    if json {
        let report = Report { simulated, features, found: &found };
        serde_json::to_writer_pretty(&mut out, &report).map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        if simulated {
            writeln!(out, "The built-in simulated sensor")?;
        }
        for line in text(&found).lines() {
            writeln!(out, "{}", printable(line))?;
        }
    }
    match found.verdict {
        Verdict::Enough | Verdict::Doubtful => Ok(()),
        Verdict::Insufficient => Err(JobError::Insufficient),
    }
}

/// For people: the verdict, its reasons, then the figures.
fn text(found: &Sufficiency) -> String {
    let mut lines = vec![format!("{}.", found.verdict.words())];
    lines.extend(found.sentences(Face::CommandLine).map(|sentence| format!("* {sentence}")));
    lines.push(format!("\n{}", found.rank_in_words()));
    lines.extend(found.undetermined.iter().map(|one| format!("  {one}")));
    lines.extend(
        sufficiency_tables(found).iter().map(|table| format!("\n{}", table.text().trim_end())),
    );
    lines.join("\n")
}
