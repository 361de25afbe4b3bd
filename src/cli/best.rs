//! `loopscope best`: sensible models in the order of their cost, and the one to take.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use clap::Args;
use serde::Serialize;

use super::choices::{CommonArgs, RecordingArgs, fit_arguments};
use super::fit::warn_of;
use super::progress_line::ProgressLine;
use super::{JobError, named_file, tell};
use crate::calibration::DECIMATION;
use crate::export::{Together, add_calibration, check_targets, interrupt_stops, target_for};
use crate::progress::Progress;
use crate::questions::thresholds::ScoreSet;
use crate::questions::{AnalysisError, Best, Request, Search, find_best, handed_over, train};

/// Arguments of `best`.
#[derive(Debug, Args)]
pub struct BestArgs {
    #[command(flatten)]
    pub(super) recordings: RecordingArgs,
    /// Begin no further model after so many minutes.
    #[arg(long, value_name = "MIN", default_value_t = 2.0)]
    minutes: f64,
    #[command(flatten)]
    common: CommonArgs,
    #[arg(long = DECIMATION.option, help = DECIMATION.help(), value_name = "N", default_value_t = 1, allow_negative_numbers = true)]
    decimate: usize,
    /// Fit the proposed model and write it, may be given several times; the ending says how, as for `fit`.
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    export: Vec<PathBuf>,
    /// Write over files that are there already.
    #[arg(long)]
    force: bool,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// What scripts read.
#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    best: &'a Best,
    /// The arguments of `fit` for the proposed model.
    fit: Option<String>,
}

pub(super) fn run(args: &BestArgs) -> Result<(), JobError> {
    for path in &args.export {
        if target_for(path).is_none() {
            return Err(JobError::Ending { path: path.clone() });
        }
    }
    check_targets(args.recordings.inputs(), &args.export, args.force)?;
    if !(args.minutes >= 0.0 && args.minutes.is_finite()) {
        return Err(JobError::Minutes(args.minutes));
    }
    let recordings = Arc::new(args.recordings.read(&args.common.rated())?);
    let search = Search {
        settings: args.common.settings(&recordings, args.decimate),
        recordings: Arc::clone(&recordings),
        // Far more than anybody waits, and little enough to be added to a time.
        time_limit: Duration::from_secs_f64((args.minutes * 60.0).min(1e9)),
    };
    let progress = Progress::default();
    let mut line = ProgressLine::default();
    line.say("looking at the recordings");
    let line = Mutex::new(line);
    let so_far: Mutex<Option<Best>> = Mutex::new(None);
    interrupt_stops(&progress);
    let found = find_best(&search, &progress, &|best| {
        if let Ok(mut so_far) = so_far.lock() {
            *so_far = Some(best.clone());
        }
        let newest = best.tried.last().map_or("", |tried| tried.name);
        let text = format!("{} tried, the newest: {newest}", best.tried.len());
        if let Ok(mut line) = line.lock() {
            line.say(&text);
        }
    });
    let is_interrupted = matches!(found, Err(AnalysisError::Cancelled(_)));
    let best = match (found, so_far.into_inner().ok().flatten()) {
        (Err(AnalysisError::Cancelled(_)), Some(so_far)) => so_far,
        (found, _) => found?,
    };
    if let Ok(mut line) = line.lock() {
        line.end();
    }
    for (name, why) in &best.failed {
        tell(&format_args!("{name}: {why}"));
    }
    if best.n_left > 0 {
        tell(&format_args!(
            "note: {} models were not tried within {} min; give more --minutes",
            best.n_left, args.minutes
        ));
    }
    let proposed = best.proposed();
    if let Some(proposed) = proposed.filter(|_| !args.export.is_empty()) {
        let request = Request::fit(Arc::clone(&recordings), proposed.model.settings.clone());
        let calibration = train(&request, &Progress::default(), &mut |_| {})?;
        if let Some(undetermined) = calibration.undetermined()
            && !args.force
        {
            return Err(JobError::Undetermined { undetermined });
        }
        let told = handed_over(&request, &calibration, &Progress::default())?;
        warn_of(&calibration, &args.export);
        let mut files = Together::default();
        for path in &args.export {
            add_calibration(&mut files, &told, path)?;
        }
        files.finish()?;
    }
    let fit = proposed.map(|proposed| fit_arguments(&proposed.model.settings));
    let mut out = io::stdout().lock();
    if args.json {
        let report = Report { best: &best, fit };
        serde_json::to_writer_pretty(&mut out, &report).map_err(io::Error::from)?;
        writeln!(out)?;
        return ended(is_interrupted);
    }
    writeln!(out, "{}", best.table(ScoreSet::LeftOut).text())?;
    if best.tried.iter().any(|tried| tried.model.scores.test_rmse.is_some()) {
        writeln!(out, "{}", best.table(ScoreSet::Test).text())?;
    }
    if let (Some(proposed), Some(fit)) = (proposed, fit) {
        writeln!(out, "Proposed: {}. To fit it: loopscope fit {fit}", proposed.name)?;
    }
    ended(is_interrupted)
}

/// Fails where the search was interrupted, after what it had found was written.
fn ended(is_interrupted: bool) -> Result<(), JobError> {
    match is_interrupted {
        true => Err(JobError::Interrupted),
        false => Ok(()),
    }
}
