//! `loopscope best`: tries many models, and recommends the most accurate one and the smallest one of nearly the same accuracy.

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use serde::Serialize;

use super::{
    choices::{CommonArgs, fit_arguments},
    error::JobError,
    exports::{add, check_determined, check_endings, check_formats},
    inputs::Files,
    recordings::{Inputs, RecordingArgs},
    run::{Run, Work, examples},
    values::{named_file, number_in},
};
use crate::{
    engine::SEARCH_MINUTES,
    export::{Outline, Together, interrupt_stops},
    features::Range,
    progress::Progress,
    questions::{
        Best, Candidates, Request, Search, WITHIN, errors::cold_start::worse_at_start, find_best,
        handed_over, train,
    },
    scoring::score_set::ScoreSet,
    shown::counted,
};

/// Find the best model: fit many models, the fastest first, and compute their errors on recordings that were left out of the fit.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope best --train day1.csv day2.csv day3.csv --minutes 5 --export sensor.json", "tries models for at most five minutes of processor time and exports the recommended one"),
]))]
pub struct BestJob {
    #[command(flatten)]
    recordings: RecordingArgs,
    /// Limit of the processor time in minutes, summed over all threads, after which no further model is started. A search that
    /// ends so is not exported without --force, because a model that was not tried may be better.
    #[arg(long, value_name = "MIN", default_value_t = SEARCH_MINUTES, value_parser = number_in(Range::NotNegative))]
    minutes: f64,
    /// Try only the models of the paper of Koike et al. (2019): each regressor without and with look-back, and squares and
    /// products. Its pattern B is --decimate 10.
    #[arg(long)]
    paper: bool,
    #[command(flatten)]
    common: CommonArgs,
    /// Percent by which the error of the smallest model may exceed the lowest error of all models.
    #[arg(long, value_name = "PERCENT", default_value_t = 100.0 * WITHIN, value_parser = number_in(Range::NotNegative))]
    within: f64,
    /// Export the smallest model within --within percent of the lowest error, instead of the most accurate one.
    #[arg(long)]
    smallest: bool,
    /// Write the recommended model to this file. The file name ending selects the format, as for `fit`. Can be given several times.
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    export: Vec<PathBuf>,
    /// Overwrite existing files, and export after an unfinished search or a fit that the recordings do not determine.
    #[arg(long)]
    force: bool,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    best: &'a Best,
    fit: Option<&'a String>,
}

impl Work for BestJob {
    fn files(&self) -> Files<'_> {
        self.recordings.files().writing(&self.export, self.force)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        check_endings(&self.export)?;
        let minutes = self.minutes;
        let inputs = self.recordings.read(run, self.common.rated())?;
        let settings = inputs.rated(self.common.settings(&inputs.recordings));
        let Inputs { recordings, sensor } = inputs;
        let search = Search {
            settings,
            recordings: Arc::clone(&recordings),
            candidates: if self.paper { Candidates::Paper } else { Candidates::All },
            // Longer limits count as 1e9 s (30 years), so that the sum of the present time and the limit does not overflow.
            limit: Duration::from_secs_f64((minutes * 60.0).min(1e9)),
            within: 0.01 * self.within,
        };
        // The features are not chosen yet, but number of gauges and axes are known.
        let outline = Outline::of_fit(&search.settings, recordings.layout());
        check_formats(&self.export, &outline)?;
        run.say.line("preparing the recordings");
        interrupt_stops(&run.progress);
        let best = find_best(&search, &run.progress, &|best| {
            let newest = best.tried.last().map_or("", |tried| tried.name.as_str());
            run.say.line(&format!("{} models tried, last: {newest}", best.tried.len()));
        })?;
        for remark in best.remarks() {
            run.say.note(format_args!("{remark}"));
        }
        let proposed = if self.smallest { best.smallest() } else { best.proposed() };
        let is_held_back = best.n_left > 0 && !self.force && !self.export.is_empty();
        let exports = !is_held_back && !self.export.is_empty();
        if let Some(proposed) = proposed.filter(|_| exports) {
            let request = Request::fit(recordings, proposed.model.settings.clone());
            // Ctrl-C cancels only the search. The export uses another progress, so it is completed after Ctrl-C, too.
            let progress = Progress::default();
            let calibration = train(&request, &progress, &mut |_| {})?;
            check_determined(&calibration, self.force)?;
            let data = request.datasets.get(&request.key(), &progress)?;
            if let Some(worse) = worse_at_start(&data, &calibration)? {
                run.say.finding(worse);
            }
            let mut files = Together::default();
            let whole = handed_over(&request, &calibration, &progress)?.of_sensor(&sensor.identity);
            add(run, &whole, &self.export, &mut files)?;
            files.finish()?;
        }
        let fit = proposed.map(|proposed| fit_arguments(&proposed.model.settings));
        run.print(self.json, &Report { best: &best, fit: fit.as_ref() }, |out| {
            writeln!(out, "{}", best.table(ScoreSet::LeftOut).text())?;
            if best.tried.iter().any(|tried| tried.model.scores.test_rmse.is_some()) {
                writeln!(out, "{}", best.table(ScoreSet::Test).text())?;
            }
            if let (Some(proposed), Some(fit)) = (proposed, &fit) {
                for sentence in best.why() {
                    writeln!(out, "{sentence}.")?;
                }
                writeln!(out, "To fit {}: loopscope fit {fit}", proposed.name)?;
            }
            Ok(())
        })?;
        let held_back = is_held_back.then(|| {
            let n = counted(best.n_left, "model");
            format!("no file is written: {n} not tried and may be better; set a longer --minutes, or add --force to export the proposal")
        });
        match (run.progress.is_cancelled(), held_back) {
            (true, held_back) => {
                held_back.iter().for_each(|why| run.say.note(format_args!("{why}")));
                Err(JobError::Interrupted)
            }
            (false, Some(why)) => Err(JobError::NotMet(why)),
            (false, None) => Ok(()),
        }
    }
}
