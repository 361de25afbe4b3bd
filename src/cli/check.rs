//! `loopscope check`: reports faults of the test rig, and whether the recordings determine the model.

use std::io::Write as _;
use std::path::PathBuf;

use clap::{Args, builder::TypedValueParser};
use serde::Serialize;

use super::{
    choices::{ModelArgs, fit_arguments},
    error::JobError,
    inputs::Files,
    recordings::{RecordingArgs, request_of},
    run::{Run, Work, examples},
    values::{named_file, one_of},
};
use crate::{
    calibration::{FitSettings, Regressor},
    finding::{Face, Verdict},
    questions::{
        Request,
        budget::{Action, Remedy, budget_table},
        check::{
            independent_loads::Sufficiency,
            query::{CheckData, sufficiency},
            rig_and_axes,
        },
    },
    recording::Item,
    report::Table,
    shown::counted,
};

/// Maximum number of lines, and of characters in a line, that are printed without `--all`.
const LINES: usize = 30;
const WIDTH: usize = 120;
/// Maximum number of remedies without `--all`.
const REMEDIES: usize = 3;
/// Maximum number of lines of one finding without `--all`.
const LINES_OF_FINDING: usize = 2;

/// Check the recordings: where the error comes from and what lowers it, faults of the test rig, and whether the recordings
/// determine the model.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope check day1.csv day2.csv", "checks the recordings; exit code 3 if the recordings are not enough"),
    ("loopscope check day*.csv --fail-on doubtful --all", "prints all findings and tables; exit code 3 also if a finding limits the calibration"),
]))]
pub struct CheckJob {
    /// Training recordings to check [default: those of the built-in simulated sensor].
    #[arg(value_name = "FILE", conflicts_with = "train", value_parser = named_file())]
    files: Vec<PathBuf>,
    #[command(flatten)]
    recordings: RecordingArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Verdict from which the exit code is 3.
    #[arg(long, value_name = "VERDICT", value_parser = verdict(), default_value = "insufficient")]
    fail_on: Verdict,
    /// Print all findings and tables, also if they take more than a screen.
    #[arg(long)]
    all: bool,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    json: bool,
}

fn verdict() -> impl TypedValueParser<Value = Verdict> {
    one_of([
        (
            Verdict::Doubtful,
            "doubtful",
            "a finding limits where the model holds, or how accurate it is",
        ),
        (Verdict::Insufficient, "insufficient", "the recordings do not give a usable model"),
    ])
}

#[derive(Serialize)]
struct Report<'a> {
    simulated: bool,
    #[serde(skip_serializing_if = "str::is_empty")]
    serial: &'a str,
    features: String,
    #[serde(flatten)]
    found: &'a Sufficiency,
    /// Options that each remedy stands for.
    remedy_options: Vec<String>,
}

impl Work for CheckJob {
    fn files(&self) -> Files<'_> {
        self.recordings.files().or_these(&self.files)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        // An unusable file is reported, but does not prevent the check of the other files.
        let mut recordings = self.recordings.clone();
        recordings.read.keep_going = true;
        let (request, sensor) = request_of(run, &recordings, &self.model)?;
        let range = recordings.read.range(request.settings.full_scale.clone());
        let asked =
            CheckData { unusable: run.say.files_left_out(), ..CheckData::of(&request, range) };
        let found = sufficiency(&asked, &run.progress)?;
        let report = Report {
            simulated: request.recordings.is_simulated(),
            serial: sensor.identity.get(Item::Serial),
            features: request.settings.features.describe(),
            remedy_options: found.remedies.iter().map(|own| option(own, &request)).collect(),
            found: &found,
        };
        run.print(self.json, &report, |out| {
            let lines = if self.all { report.all() } else { report.screen() };
            lines.iter().try_for_each(|line| writeln!(out, "{line}"))
        })?;
        if found.verdict < self.fail_on {
            return Ok(());
        }
        let reason = match found.verdict {
            Verdict::Insufficient => "the recordings do not give a usable model",
            _ => "findings limit where the model holds, or how accurate it is",
        };
        Err(JobError::NotMet(reason.to_owned()))
    }
}

/// Returns the command-line option of a remedy.
fn option(remedy: &Remedy, request: &Request) -> String {
    match &remedy.action {
        Action::Features(features) => fit_arguments(&FitSettings {
            features: (**features).clone(),
            regressor: Regressor::Linear,
            ..request.settings.clone()
        }),
        Action::Tare => "--tare auto".to_owned(),
        Action::TryModels => "`loopscope best` tries all models".to_owned(),
        action => action.words(),
    }
}

impl Report<'_> {
    /// Returns the lines of the budget: its table, its sentences with at most this number of lines each, and at most this number
    /// of remedies.
    fn budget(&self, most_lines: usize, most_remedies: usize) -> Vec<String> {
        let mut lines = Vec::new();
        lines.extend(self.simulated.then(|| "The built-in simulated sensor".to_owned()));
        let budget = match &self.found.budget {
            Ok(budget) => budget,
            Err(reason) => {
                lines.push(format!("No error budget: {reason}."));
                return lines;
            }
        };
        let table = Table { note: String::new(), ..budget_table(budget) };
        if table.columns.len() > 1 {
            lines.extend(table.text().lines().map(str::to_owned));
        }
        lines.extend(budget.sentences().iter().flat_map(|own| clipped(own, "", most_lines)));
        let remedies = self.found.remedies.iter().zip(&self.remedy_options).take(most_remedies);
        let remedies = remedies.map(|(own, option)| format!("> {}", own.text(option, budget)));
        lines.extend(remedies.flat_map(|own| clipped(&own, "  ", most_lines)));
        lines
    }

    fn findings(&self) -> impl Iterator<Item = String> {
        self.found.sentences(Face::CommandLine).map(|own| format!("* {own}"))
    }

    fn all(&self) -> Vec<String> {
        let mut lines = self.budget(usize::MAX, usize::MAX);
        lines.extend([String::new(), format!("{}.", self.found.verdict.words())]);
        lines.extend(self.findings());
        lines.extend([self.found.holds_for.clone(), self.found.rank_in_words()]);
        for table in rig_and_axes(self.found) {
            lines.push(String::new());
            lines.extend(table.text().lines().map(str::to_owned));
        }
        lines
    }

    /// Returns the lines of one screen. Findings that do not fit are counted.
    fn screen(&self) -> Vec<String> {
        let mut lines = self.budget(2, REMEDIES);
        lines.push(format!("{}.", self.found.verdict.words()));
        let mut last = clipped(&self.found.holds_for, "", 2);
        last.extend(clipped(&self.found.rank_in_words(), "", 1));
        last.push("--all prints all findings and tables, --json all numbers.".to_owned());
        let findings: Vec<Vec<String>> =
            self.findings().map(|own| clipped(&own, "  ", LINES_OF_FINDING)).collect();
        for (n_shown, finding) in findings.iter().enumerate() {
            let n_counted = usize::from(n_shown + 1 < findings.len());
            if lines.len() + finding.len() + last.len() + n_counted > LINES {
                let n = findings.len() - n_shown;
                lines.push(format!("* {} more", counted(n, "finding")));
                break;
            }
            lines.extend_from_slice(finding);
        }
        lines.extend(last);
        lines
    }
}

/// Returns the first lines of a text, each with at most [`WIDTH`] characters. All lines but the first begin with `indent`. An
/// ellipsis stands for the rest.
fn clipped(text: &str, indent: &str, most: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let is_last = lines.len() >= most;
        let line = lines.last_mut().expect("there is a line");
        let length = line.chars().count() + 1 + word.chars().count();
        if length <= WIDTH || line.trim().is_empty() {
            line.extend((!line.is_empty()).then_some(' '));
            line.push_str(word);
        } else if !is_last {
            lines.push(format!("{indent}{word}"));
        } else {
            *line = line.chars().take(WIDTH - 2).collect::<String>() + " …";
            break;
        }
    }
    let end = |line: String| line.chars().take(WIDTH).collect();
    lines.into_iter().map(end).collect()
}
