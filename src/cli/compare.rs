//! `loopscope compare`: every regressor without and with the past, side by side.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use clap::Args;

use super::choices::{FitChoices, RecordingArgs, regressor};
use super::progress_line::ProgressLine;
use super::{JobError, named_file, tell};
use crate::calibration::Regressor;
use crate::export::{check_targets, write_atomically};
use crate::progress::Progress;
use crate::questions::thresholds::ScoreSet;
use crate::questions::{
    AnalysisError, Candidate, ComparedRow, RowEvent, compare, comparison_table, paper_candidates,
};

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    #[command(flatten)]
    pub(super) recordings: RecordingArgs,
    #[command(flatten)]
    choices: FitChoices,
    /// Only these regressors [default: all].
    #[arg(
        long,
        value_parser = regressor(),
        value_delimiter = ',',
        value_name = "NAME,…",
        help_heading = "Regressor"
    )]
    regressors: Vec<Regressor>,
    /// Only every so many-th sample: 1 is the paper's pattern A, 10 its pattern B [default: both]. Where recordings repeat
    /// several programmes (paths), rows with the first alone stand beside: few trajectories (C).
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    decimate: Option<usize>,
    /// Also write the table as CSV.
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    csv: Option<PathBuf>,
    /// Write over files that are there already.
    #[arg(long)]
    force: bool,
    /// Print a JSON array instead of a table.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &CompareArgs) -> Result<(), JobError> {
    check_targets(args.recordings.inputs(), args.csv.as_slice(), args.force)?;
    let recordings = Arc::new(args.recordings.read(&args.choices.blocks.common.rated())?);
    let regressors = match &args.regressors[..] {
        [] => &Regressor::ALL,
        named => named,
    };
    let settings = args.choices.settings(&recordings, Regressor::Linear, 1);
    let mut candidates = paper_candidates(&recordings, &settings, regressors);
    if let Some(step) = args.decimate {
        for candidate in &mut candidates {
            candidate.decimation = step;
        }
        let mut seen: Vec<Candidate> = Vec::new();
        candidates.retain(|candidate| {
            let is_new = !seen.contains(candidate);
            if is_new {
                seen.push(candidate.clone());
            }
            is_new
        });
    }
    let progress = Progress::default();
    let line = Mutex::new(ProgressLine::default());
    let rows: Mutex<Vec<Option<Result<ComparedRow, AnalysisError>>>> =
        Mutex::new(candidates.iter().map(|_| None).collect());
    compare(&recordings, &settings, &candidates, &progress, &|at, event| {
        let unpoisoned = PoisonError::into_inner;
        line.lock().unwrap_or_else(unpoisoned).show(&progress);
        if let RowEvent::Ended(row) = event {
            rows.lock().unwrap_or_else(PoisonError::into_inner)[at] = Some(row);
        }
    });
    line.into_inner().unwrap_or_else(PoisonError::into_inner).end();
    let ended = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    let mut rows = Vec::new();
    let mut failed = None;
    for (candidate, row) in candidates.iter().zip(ended.into_iter().flatten()) {
        match row {
            Ok(row) => rows.push(row),
            Err(error) => {
                let label = candidate.regressor.label();
                let (history, pattern) = (candidate.history(), candidate.pattern());
                tell(&format_args!("{label}, {history}, pattern {pattern}: {error}"));
                failed = Some(error);
            }
        }
    }
    if let Some(path) = &args.csv {
        write_atomically(path, |out| comparison_table(&rows, &ScoreSet::ALL).write_csv(out))?;
    }
    let mut out = io::stdout().lock();
    if args.json {
        serde_json::to_writer_pretty(&mut out, &rows).map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        for set in ScoreSet::ALL {
            if rows.iter().any(|row| set.rmse(&row.scores).is_some()) {
                writeln!(out, "{}", comparison_table(&rows, &[set]).text())?;
            }
        }
    }
    match failed {
        Some(error) => Err(error.into()),
        None => Ok(()),
    }
}
