//! `loopscope report`: one fit, told in full as a page to read, print and keep.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::choices::{LimitsArgs, ModelArgs, RecordingArgs, SensorArgs};
use super::metrology::MeasuringArgs;
use super::{JobError, keep_limits, named_file, print_path};
use crate::export::{check_targets, write_report};
use crate::progress::Progress;
use crate::questions::page::{ReportRequest, report};
use crate::questions::{Request, read_factory};
use crate::recording::simulated;

/// Arguments of `report`.
#[derive(Debug, Args)]
pub struct ReportArgs {
    #[command(flatten)]
    pub(super) recordings: RecordingArgs,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    sensor: SensorArgs,
    /// Where the report goes: one HTML file that needs nothing beside it.
    #[arg(long, value_name = "FILE.html", value_parser = named_file())]
    out: PathBuf,
    /// Also score the calibration that the sensor came with (.cal or .json), as `fit --factory` does.
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    factory: Option<PathBuf>,
    #[command(flatten)]
    measuring: MeasuringArgs,
    #[command(flatten)]
    limits: LimitsArgs,
    /// What the report says under "Notes"; \n begins a new paragraph.
    #[arg(long, value_name = "TEXT", default_value = "")]
    notes: String,
    /// Write over a file that is there already.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &ReportArgs) -> Result<(), JobError> {
    let inputs = args.recordings.inputs().chain(&args.factory);
    let inputs = inputs.chain(args.limits.input()).chain(args.sensor.input());
    check_targets(inputs, std::slice::from_ref(&args.out), args.force)?;
    let ending = args.out.extension().unwrap_or_default().to_ascii_lowercase();
    if ending != "html" && ending != "htm" {
        return Err(JobError::ReportEnding { path: args.out.clone() });
    }
    let sensor = args.sensor.read()?;
    let limits = args.limits.read()?;
    let mut heard = Vec::new();
    let rated = args.model.rated().and(&sensor);
    let mut recordings =
        args.recordings.read_hearing(&rated, &mut |warning| heard.push(warning.to_string()))?;
    if recordings.is_simulated() {
        for entry in simulated::bench(simulated::DEFAULT_SEED) {
            recordings.push(entry)?;
        }
    }
    let mut settings = args.model.settings(&recordings);
    sensor.rate(&recordings.layout().axes, &mut settings.full_scale);
    let factory = match &args.factory {
        Some(path) => {
            let names = &recordings.layout().gauge_names;
            Some(Arc::new(read_factory(path, names)?))
        }
        None => None,
    };
    let asked = ReportRequest {
        request: Request { factory, ..Request::fit(Arc::new(recordings), settings) },
        identity: sensor.identity,
        notes: args.notes.replace("\\n", "\n"),
        limits,
        measuring: args.measuring.settings(),
        gauge_range: args.recordings.read.gauge_range.clone(),
    };
    let mut data = report(&asked, &Progress::default())?;
    data.warnings.extend(heard);
    write_report(&args.out, &data)?;
    print_path(&args.out)?;
    keep_limits(&data.limits)
}
