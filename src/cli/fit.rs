//! `loopscope fit`: fits a calibration, prints its errors, and exports it.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use super::{
    error::JobError,
    exports::{add, check_determined, check_endings, check_formats, exported_help},
    inputs::Files,
    recordings::{FitArgs, FitInputs, keep_limits, note_history},
    run::{Run, Work, examples},
    traces::TraceArgs,
    values::named_file,
};
use crate::{
    calibration::{Calibration, EpochReport, FactoryScores, Quality, Regressor},
    export::{Outline, Together},
    features::{Distance, FeatureSettings},
    finding::{Face, Finding, Id},
    progress::Progress,
    questions::{
        Request, TrainingStep, analyse, check_limits, cross_validation_cost,
        errors::{errors, factory_note},
        expected_error::{
            expected_error_table, limits::Checked, limits_table, query::expected_error,
        },
        findings, handed_over, read_factory, settings_table, train,
    },
    recording::{Axis, Item},
    report::Shown,
    scoring::{numbers::significant, score_set::ScoreSet},
};

/// Fit a conventional and a compensated calibration, and print the errors of both.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope fit --train day1.csv day2.csv --test day3.csv --export sensor.json", "fits a conventional calibration, and a compensated one with a look-back of 3 N and 15 s"),
    ("loopscope fit --train day*.csv --play --ridge auto --export sensor.h --export sensor.json", "fits play operators with a cross-validated ridge; exports C code"),
]))]
pub struct FitJob {
    #[command(flatten)]
    fit: FitArgs,
    #[arg(long, value_name = "FILE", value_parser = named_file(), help = exported_help())]
    export: Vec<PathBuf>,
    /// Keep the uncertainty band of a kernel in an exported .json, which is about twenty times as large with it.
    #[arg(long, requires = "export")]
    band: bool,
    /// Also print the errors of the manufacturer's calibration, tared on the training recordings (.json, or .cal in ATI's format,
    /// whose gauges are taken in the order of the recordings).
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    factory: Option<PathBuf>,
    #[command(flatten)]
    traces: TraceArgs,
    /// Overwrite existing files, and export even a calibration that is not determined by the recordings.
    #[arg(long)]
    force: bool,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Work for FitJob {
    fn files(&self) -> Files<'_> {
        let files = self.fit.files().reading(&self.factory);
        files.writing(self.export.iter().chain(&self.traces.traces), self.force)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        // The names of the output files are checked before the fit, so that no time is lost if one is wrong.
        check_endings(&self.export)?;
        let FitInputs { request, sensor, limits } = self.fit.read(run)?;
        let layout = request.recordings.layout();
        check_formats(&self.export, &Outline::of_fit(&request.settings, layout))?;
        note_history(run, &request)?;
        let all = || request.recordings.entries().iter().map(|entry| &*entry.recording);
        let step = request.settings.decimation;
        let cost = cross_validation_cost(&request.settings);
        let mut calibration = train(&request, &run.progress, &mut |step| {
            run.say.line(&step_text(&step, cost));
        })?;
        run.say.end_line();
        if !self.export.is_empty() {
            check_determined(&calibration, self.force)?;
        }
        // Severe findings are also printed on standard error, because scripts may read only the numbers on standard output.
        let (grave, others): (Vec<Finding>, Vec<Finding>) =
            (findings(&request, &calibration, &run.progress)?.into_iter()).partition(|found| {
                matches!(found.id, Id::Undetermined | Id::NoCrossValidation | Id::ColdStart)
            });
        grave.iter().for_each(|found| run.say.finding(found.clone()));
        let factory = match &self.factory {
            Some(path) => factory_scores(path, &request, &calibration)?,
            None => None,
        };
        let expected = expected_error(&request, &calibration, true, &run.progress)?;
        calibration.quality.expected_error = expected.as_ref().ok().cloned();
        let calibration = Arc::new(calibration);
        let limits = check_limits(&request, &calibration, &limits, &run.progress)?;
        let mut files = Together::default();
        if !self.export.is_empty() || self.traces.traces.is_some() {
            let mut whole = handed_over(&request, &calibration, &run.progress)?;
            whole = whole.of_sensor(&sensor.identity);
            if self.band {
                whole.learned.clone_from(&calibration.learned);
            }
            add(run, &whole, &self.export, &mut files)?;
            self.traces.write(&mut files, &whole, all(), step)?;
        }
        files.finish()?;
        let first = calibration.features.look_backs.first();
        let report = FitReport {
            simulated: calibration.simulated,
            serial: sensor.identity.get(Item::Serial),
            recordings: request.recordings.entries().len(),
            axes: &calibration.axes,
            units: &calibration.units,
            full_scale: &calibration.full_scale,
            regressor: calibration.regressor,
            f_th: first.map(|thresholds| thresholds.f_th),
            t_th: first.map(|thresholds| thresholds.t_th_secs),
            distance: calibration.features.distance,
            blocks: &calibration.features,
            offset: calibration.offset,
            decimation: calibration.decimation,
            quality: &calibration.quality,
            features: calibration.feature_names(),
            factory,
            no_expected_error: expected.as_ref().err(),
            limits: &limits,
            findings: grave.iter().chain(&others).collect(),
        };
        run.print(self.json, &report, |out| {
            print_fit(&calibration, report.factory.as_ref(), out)?;
            match &expected {
                Ok(found) => write!(out, "\n{}", expected_error_table(found).text())?,
                Err(reason) => writeln!(out, "\nNo expected error: {reason}")?,
            }
            if !limits.is_empty() {
                write!(out, "\n{}", limits_table(&limits).text())?;
            }
            if !others.is_empty() {
                writeln!(out, "\nFindings:")?;
            }
            others.iter().try_for_each(|found| writeln!(out, "* {}", found.text(Face::CommandLine)))
        })?;
        keep_limits(&limits)
    }
}

fn factory_scores(
    path: &Path,
    request: &Request,
    calibration: &Calibration,
) -> Result<Option<FactoryScores>, JobError> {
    let factory = read_factory(path, &request.recordings.layout().gauge_names)?;
    let request = Request {
        factory: Some(Arc::new(factory)),
        calibration: Some(Arc::new(calibration.clone())),
        trained: true,
        ..request.clone()
    };
    Ok(analyse(&request, &Progress::default())?.factory)
}

/// Returns the progress line of a training. `cost` is the duration of the later cross-validation in units of that of the
/// training; 0 without one.
fn step_text(step: &TrainingStep, cost: f64) -> String {
    let TrainingStep::Epoch(report) = step else {
        let left = step.time_left().as_secs_f64();
        return format!("cross-validation {:.0} %, {left:.0} s left", 100.0 * step.done());
    };
    let held_out =
        report.held_out_loss.map_or_else(String::new, |loss| format!(", held-out loss {loss:.5}"));
    let EpochReport { epoch, epochs, train_loss, .. } = report;
    let left = report.time_left();
    let then = match cost {
        0.0 => String::new(),
        cost => {
            let secs = (report.elapsed + left).as_secs_f64() * cost;
            format!(", then {secs:.0} s of cross-validation")
        }
    };
    let left = left.as_secs_f64();
    format!("epoch {epoch} of {epochs}, loss {train_loss:.5}{held_out}, {left:.0} s left{then}")
}

#[derive(Debug, Serialize)]
struct FitReport<'a> {
    simulated: bool,
    #[serde(skip_serializing_if = "str::is_empty")]
    serial: &'a str,
    recordings: usize,
    axes: &'a [Axis],
    units: &'a [String],
    full_scale: &'a [f64],
    regressor: Regressor,
    f_th: Option<f64>,
    t_th: Option<f64>,
    distance: Distance,
    blocks: &'a FeatureSettings,
    offset: bool,
    decimation: usize,
    #[serde(flatten)]
    quality: &'a Quality,
    features: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    factory: Option<FactoryScores>,
    #[serde(skip_serializing_if = "Option::is_none")]
    no_expected_error: Option<&'a String>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    limits: &'a [Checked],
    findings: Vec<&'a Finding>,
}

fn print_fit(
    calibration: &Calibration,
    factory: Option<&FactoryScores>,
    out: &mut impl Write,
) -> io::Result<()> {
    let quality = &calibration.quality;
    if calibration.simulated {
        writeln!(out, "The built-in simulated sensor")?;
    }
    write!(out, "{}", settings_table(calibration).text())?;
    if let Some(learned) = &calibration.learned {
        writeln!(out, "{}", learned.describe())?;
    }
    if let Some(band) = &quality.band {
        let widths: Vec<String> = (calibration.axes.iter().zip(band))
            .map(|(axis, width)| {
                let width = significant(*width, 4);
                format!("{axis} {width} {}", axis.unit())
            })
            .collect();
        let samples = if quality.n_test > 0 { "test" } else { "training" };
        writeln!(
            out,
            "band of ±2 SD, root mean square over the {samples} samples: ±{}",
            widths.join(", ±")
        )?;
    }
    for set in ScoreSet::ALL {
        if let Ok(table) = errors(calibration, factory, set, Shown::Units) {
            write!(out, "\n{}", table.with_decimals(6).text())?;
        }
    }
    match factory {
        Some(factory) => writeln!(out, "\n{}", factory_note(calibration, factory)),
        None => Ok(()),
    }
}
