//! `loopscope compare`: fits each regressor with and without look-back, as in the table of the paper of Koike et al. (2019).

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use super::choices::{FitChoices, regressor};
use super::error::JobError;
use super::inputs::Files;
use super::recordings::RecordingArgs;
use super::run::{Run, Work, examples};
use super::values::named_file;
use crate::{
    calibration::{FitSettings, Regressor, Scores},
    export::write_atomically,
    questions::{Candidate, Comparison, Model, ModelRow, compare, model_table, paper_candidates},
    recording::Axis,
    report::{Cell, Table},
    scoring::score_set::ScoreSet,
};

const DECIMATE_HELP: &str = "Use every N-th sample: 1 is pattern A of the paper of Koike et al. (2019), 10 its pattern B [default: both]. \
    If the recordings repeat several load programmes, the table has further rows for fits to the first programme alone (pattern C)";

/// Print the table of the paper of Koike et al. (2019): the errors of each regressor with and without look-back, fitted to
/// all samples and to every tenth.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope compare --train day1.csv day2.csv --test day3.csv --regressors linear,kernel --csv table.csv", "compares the linear regressor and the kernel"),
]))]
#[command(mut_arg("decimate", |argument| argument.help(DECIMATE_HELP)))]
pub struct CompareJob {
    #[command(flatten)]
    recordings: RecordingArgs,
    #[command(flatten)]
    choices: FitChoices,
    /// Regressors to compare [default: all].
    #[arg(
        long,
        value_parser = regressor(),
        value_delimiter = ',',
        value_name = "NAME,…",
        help_heading = "Regressor"
    )]
    regressors: Vec<Regressor>,
    /// Also write the table to this CSV file.
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    csv: Option<PathBuf>,
    /// Overwrite existing files.
    #[arg(long)]
    force: bool,
    /// Print a JSON array instead of a table.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Row<'a> {
    #[serde(flatten)]
    candidate: &'a Candidate,
    axes: &'a [Axis],
    n_train: u64,
    scores: &'a Scores,
    ridge: &'a [f64],
    seconds: Option<f64>,
    #[serde(skip)]
    model: &'a Model,
    #[serde(skip)]
    words: [String; 2],
}

impl<'a> Row<'a> {
    fn of(candidate: &'a Candidate, model: &'a Model) -> Self {
        Self {
            candidate,
            axes: &model.axes,
            n_train: model.n_train,
            scores: &model.scores,
            ridge: &model.ridge,
            seconds: model.seconds,
            model,
            words: [candidate.history(), candidate.pattern()],
        }
    }
}

fn table(rows: &[Row<'_>], sets: &[ScoreSet]) -> Table {
    let titles: Vec<String> = sets.iter().map(|set| format!("RMSE, {}", set.label())).collect();
    let axes = rows.first().map_or(&[][..], |row| row.axes);
    let rows = rows.iter().map(|row| ModelRow {
        mark: Cell::words(""),
        name: &row.words[0],
        data: &row.words[1],
        model: row.model,
    });
    Table { title: titles.join("; "), ..model_table(axes, sets, rows) }
}

impl Work for CompareJob {
    fn files(&self) -> Files<'_> {
        self.recordings.files().writing(&self.csv, self.force)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        let common = &self.choices.blocks.common;
        let recordings = self.recordings.read(run, &common.rated())?;
        let recordings = Arc::new(recordings);
        let regressors = match &self.regressors[..] {
            [] => &Regressor::ALL,
            named => named,
        };
        let settings = FitSettings {
            decimation: 1,
            ..self.choices.settings(&run.say, &recordings, Regressor::Linear)
        };
        let mut candidates: Vec<Candidate> = Vec::new();
        for mut candidate in paper_candidates(&recordings, &settings, regressors) {
            candidate.decimation = common.decimate.unwrap_or(candidate.decimation);
            if !candidates.contains(&candidate) {
                candidates.push(candidate);
            }
        }
        let asked = Comparison { recordings, settings, candidates };
        let outcomes = compare(&asked, &run.progress, &|_| run.say.show(&run.progress));
        let (mut rows, mut failed) = (Vec::new(), None);
        for (candidate, outcome) in asked.candidates.iter().zip(&outcomes) {
            match outcome {
                Some(Ok(model)) => rows.push(Row::of(candidate, model)),
                Some(Err(error)) => {
                    let (label, history) = (candidate.regressor.label(), candidate.history());
                    let pattern = candidate.pattern();
                    run.say.error(&format_args!("{label}, {history}, pattern {pattern}: {error}"));
                    failed = Some(error.clone());
                }
                None => {}
            }
        }
        if let Some(path) = &self.csv {
            write_atomically(path, |out| table(&rows, &ScoreSet::ALL).write_csv(out))?;
        }
        run.print(self.json, &rows, |out| {
            let is_scored = |set: &ScoreSet| rows.iter().any(|row| set.rmse(row.scores).is_some());
            for set in ScoreSet::ALL.into_iter().filter(is_scored) {
                writeln!(out, "{}", table(&rows, &[set]).text())?;
            }
            Ok(())
        })?;
        failed.map_or(Ok(()), |error| Err(error.into()))
    }
}
