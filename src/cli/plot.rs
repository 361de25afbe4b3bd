//! `loopscope plot`: writes the figures of a fit as SVG files.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{
    error::{JobError, usage},
    inputs::Files,
    recordings::{FitArgs, FitInputs, MeasuringArgs, keep_limits, note_history},
    run::{Run, Work, examples},
    values::{file_in, named_file},
};
use crate::{
    export::Together,
    questions::{
        loops::{Inks, LoopPlot, LoopView},
        page::{ReportData, ReportRequest, report},
    },
    report::figure::{Figure, STANDS_ALONE, stacked_svg},
};

/// Fit a calibration, and write its figures as SVG files.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope plot day1.csv day2.csv --loops loops.svg", "draws the hysteresis loops of each axis before and after compensation"),
    ("loopscope plot --train day1.csv --test day2.csv --traces errors.svg --thresholds thresholds.svg", "draws the errors over time, and over each threshold"),
]))]
pub struct PlotJob {
    /// Training recordings [default: those of the built-in simulated sensor].
    #[arg(value_name = "FILE", conflicts_with = "train", value_parser = named_file())]
    files: Vec<PathBuf>,
    #[command(flatten)]
    fit: FitArgs,
    #[command(flatten)]
    measuring: MeasuringArgs,
    /// Draw the error of each axis over its load, before and after compensation, to this SVG file. The loops are measured on the
    /// test recordings, or without any on the training recordings. If a time lag explains much of a loop, a second figure shows
    /// the loop without the lag.
    #[arg(long, value_name = "FILE.svg", value_parser = file_in(&["svg"]))]
    loops: Option<PathBuf>,
    /// Draw the errors of each axis over time to this SVG file, for the recording with the largest errors.
    #[arg(long, value_name = "FILE.svg", value_parser = file_in(&["svg"]))]
    traces: Option<PathBuf>,
    /// Draw the errors over each threshold of the look-back to this SVG file. `sweep --svg` draws the map over both.
    #[arg(long, value_name = "FILE.svg", value_parser = file_in(&["svg"]))]
    thresholds: Option<PathBuf>,
    /// Overwrite existing files.
    #[arg(long)]
    force: bool,
}

impl PlotJob {
    fn outputs(&self) -> impl Iterator<Item = &PathBuf> {
        self.loops.iter().chain(&self.traces).chain(&self.thresholds)
    }
}

impl Work for PlotJob {
    fn files(&self) -> Files<'_> {
        self.fit.files().or_these(&self.files).writing(self.outputs(), self.force)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        if self.outputs().next().is_none() {
            return usage("no figure is named; use --loops, --traces or --thresholds FILE.svg");
        }
        let FitInputs { request, sensor, limits } = self.fit.read(run)?;
        note_history(run, &request)?;
        let asked = ReportRequest {
            identity: sensor.identity,
            limits,
            measuring: self.measuring.settings(),
            ..ReportRequest::of(request)
        };
        let data = report(&asked, &run.progress)?;
        let mut written = Together::default();
        let traces = data.errors.as_ref().map(|errors| errors.figures.clone());
        let figures = [
            (&self.loops, loops(&data)),
            (&self.traces, traces.ok_or_else(|| "no recording has a reference load".to_owned())),
            (
                &self.thresholds,
                data.thresholds.as_ref().map(|curves| curves.plots.clone()).map_err(String::clone),
            ),
        ];
        for (path, figures) in figures {
            if let Some(path) = path {
                write_figures(&mut written, path, figures)?;
            }
        }
        written.finish()?;
        self.outputs().try_for_each(|path| run.print_path(path))?;
        keep_limits(&data.limits)
    }
}

/// Figures, or the reason why there are none.
type Found<'a> = Result<Vec<Figure<'a>>, String>;

/// Returns the loops of all axes that have any.
fn loops(data: &ReportData) -> Found<'_> {
    let figure = |plot| LoopView::of_all(plot, ("", "")).figure(&Inks::PRINT, None);
    let plots: Vec<&LoopPlot> = data.loops.iter().flatten().flatten().collect();
    match data.loops.iter().find_map(|found| found.as_ref().err()) {
        Some(reason) if plots.is_empty() => Err(reason.clone()),
        _ => Ok(plots.into_iter().map(figure).collect()),
    }
}

fn write_figures(written: &mut Together, path: &Path, figures: Found<'_>) -> Result<(), JobError> {
    let why = |reason| JobError::NotMet(format!("{}: not written: {reason}", path.display()));
    let figures = match figures {
        Ok(figures) if figures.is_empty() => Err(why("no axis has a figure".to_owned())),
        figures => figures.map_err(why),
    }?;
    let svg = stacked_svg(&figures, STANDS_ALONE);
    Ok(written.write(path, |out| out.write_all(svg.as_bytes()))?)
}
