//! `loopscope compare`: every regressor without and with the past, side by side.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use clap::Args;

use super::choices::{FitChoices, RecordingArgs, RegressorArg};
use super::progress_line::ProgressLine;
use super::{JobError, named_file, tell};
use crate::analysis::{AnalysisError, Candidate, ComparedRow, RowEvent, compare, paper_candidates};
use crate::calibration::Regressor;
use crate::export::{check_targets, write_atomically, write_comparison_csv};
use crate::progress::Progress;

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    #[command(flatten)]
    recordings: RecordingArgs,
    #[command(flatten)]
    choices: FitChoices,
    /// Only these regressors [default: all].
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        value_name = "NAME,…",
        help_heading = "Regressor"
    )]
    regressors: Vec<RegressorArg>,
    /// Only this amount of data: 1 is the paper's pattern A, 10 its pattern B [default: both].
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
    let recordings = Arc::new(args.recordings.read()?);
    let regressors: Vec<Regressor> = match &args.regressors[..] {
        [] => Regressor::ALL.to_vec(),
        named => named.iter().copied().map(Regressor::from).collect(),
    };
    let settings = args.choices.settings(&recordings, Regressor::Linear, 1);
    let mut candidates = paper_candidates(&settings, &regressors);
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
    compare(
        &recordings,
        &settings,
        &candidates,
        &progress,
        &|at, event| {
            let unpoisoned = PoisonError::into_inner;
            line.lock().unwrap_or_else(unpoisoned).show(&progress);
            if let RowEvent::Ended(row) = event {
                rows.lock().unwrap_or_else(PoisonError::into_inner)[at] = Some(row);
            }
        },
    );
    line.into_inner()
        .unwrap_or_else(PoisonError::into_inner)
        .end();
    let ended = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    let mut rows = Vec::new();
    let mut failed = None;
    for (candidate, row) in candidates.iter().zip(ended.into_iter().flatten()) {
        match row {
            Ok(row) => rows.push(row),
            Err(error) => {
                let label = candidate.regressor.label();
                let (history, pattern) = (candidate.history(), candidate.pattern());
                tell(&format_args!(
                    "{label}, {history}, pattern {pattern}: {error}"
                ));
                failed = Some(error);
            }
        }
    }
    if let Some(path) = &args.csv {
        write_atomically(path, |out| write_comparison_csv(&rows, out))?;
    }
    let mut out = io::stdout().lock();
    if args.json {
        serde_json::to_writer_pretty(&mut out, &rows).map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        print_rows(&rows, &mut out)?;
    }
    match failed {
        Some(error) => Err(error.into()),
        None => Ok(()),
    }
}

fn print_rows(rows: &[ComparedRow], out: &mut impl Write) -> io::Result<()> {
    let Some(first) = rows.first() else {
        return Ok(());
    };
    let history_width = rows
        .iter()
        .map(|row| row.candidate.history().chars().count())
        .max();
    let width = history_width.unwrap_or(0).max("history".len());
    for (name, pick) in SETS {
        if rows.iter().all(|row| pick(row).is_none()) {
            continue;
        }
        writeln!(out, "RMSE, {name}")?;
        write!(out, "  {:<17} {:<width$} data", "regressor", "history")?;
        for axis in &first.axes {
            write!(
                out,
                " {:>10}",
                format!("{} [{}]", axis.symbol(), axis.unit())
            )?;
        }
        writeln!(out, "     time")?;
        for row in rows {
            let candidate = &row.candidate;
            write!(
                out,
                "  {:<17} {:<width$} {:<4}",
                candidate.regressor.label(),
                candidate.history(),
                candidate.pattern()
            )?;
            for at in 0..row.axes.len() {
                match pick(row) {
                    Some(rmse) => write!(out, " {:>10.5}", rmse[at])?,
                    None => write!(out, " {:>10}", "-")?,
                }
            }
            writeln!(out, " {:>6.2} s", row.elapsed.as_secs_f64())?;
        }
        writeln!(out)?;
    }
    Ok(())
}

type Pick = fn(&ComparedRow) -> Option<&Vec<f64>>;

const SETS: [(&str, Pick); 3] = [
    ("train", |row| row.scores.train_rmse.as_ref()),
    ("test", |row| row.scores.test_rmse.as_ref()),
    ("leave-one-recording-out", |row| row.scores.cv_rmse.as_ref()),
];
