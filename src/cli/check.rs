//! `loopscope check`: reports faults of the test rig, and whether the recordings determine the model.

use std::io::{self, Write as _};
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use super::choices::ModelArgs;
use super::error::JobError;
use super::inputs::Files;
use super::recordings::RecordingArgs;
use super::run::{Run, Work, examples};
use super::values::named_file;
use crate::{
    finding::{Face, Verdict},
    questions::{
        Request,
        check::{
            independent_loads::Sufficiency,
            query::{CheckData, sufficiency},
            sufficiency_tables,
        },
    },
};

/// Check the recordings: faults of the test rig, the range of the loads, and whether the recordings determine the model.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope check day1.csv day2.csv", "checks the recordings; exit code 3 if the recordings are not enough"),
]))]
pub struct CheckJob {
    /// Training recordings to check [default: those of the built-in simulated sensor].
    #[arg(value_name = "FILE", conflicts_with = "train", value_parser = named_file())]
    files: Vec<PathBuf>,
    #[command(flatten)]
    recordings: RecordingArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    json: bool,
}

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
        if self.files.is_empty() { named } else { Files { recordings: &self.files, ..named } }
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        // An unusable file is reported, but does not prevent the check of the other files.
        let mut recordings = self.recordings.clone();
        recordings.read.keep_going = true;
        let set = recordings.read(run, &self.model.rated())?;
        let settings = self.model.settings(&run.say, &set);
        let features = settings.features.describe();
        let simulated = set.is_simulated();
        let request = Request::fit(Arc::new(set), settings);
        let range = recordings.read.range(request.settings.full_scale.clone());
        let asked =
            CheckData { unusable: run.say.files_left_out(), ..CheckData::of(&request, range) };
        let found = sufficiency(&asked, &run.progress)?;
        let report = Report { simulated, features, found: &found };
        run.print(self.json, &report, |out| print(&report, out))?;
        match found.verdict {
            Verdict::Enough | Verdict::Doubtful => Ok(()),
            Verdict::Insufficient => {
                Err(JobError::NotMet("the recordings do not give a usable model".to_owned()))
            }
        }
    }
}

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
