//! `loopscope report`: one fit, told in full as a page to read, print and keep.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::choices::{ModelArgs, RecordingArgs, SensorArgs};
use super::metrology::MeasuringArgs;
use super::{JobError, named_file, print_path};
use crate::analysis::{Request, Told, read_factory, report_of};
use crate::evaluation::limits::Limits;
use crate::export::{Together, check_targets, dcc_of, html_of, with_sources};
use crate::progress::Progress;
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
    /// Write a certificate: on the first page what a laboratory hands over, then what that rests on; without thresholds where
    /// there is no look-back.
    #[arg(long)]
    certificate: bool,
    /// Also write the certificate for machines: a Digital Calibration Certificate (XML of PTB, schema 3.1.2).
    #[arg(long, value_name = "FILE.xml", requires = "certificate", value_parser = named_file())]
    dcc: Option<PathBuf>,
    /// What the calibration must keep to pass: a TOML file like `U = 1.0` (percent of full scale), `condition = 1e4`.
    #[arg(long, value_name = "LIMITS.toml", requires = "certificate", value_parser = named_file())]
    limits: Option<PathBuf>,
    /// What the report says under "Notes"; \n begins a new paragraph.
    #[arg(long, value_name = "TEXT", default_value = "")]
    notes: String,
    /// Write over a file that is there already.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &ReportArgs) -> Result<(), JobError> {
    let outputs: Vec<PathBuf> = std::iter::once(&args.out)
        .chain(&args.dcc)
        .cloned()
        .collect();
    let inputs = args
        .recordings
        .inputs()
        .chain(&args.factory)
        .chain(&args.limits);
    check_targets(inputs.chain(args.sensor.input()), &outputs, args.force)?;
    let sensor = args.sensor.read()?;
    let limits = args.limits.as_deref().map(Limits::read).transpose()?;
    let told = match args.certificate {
        true => Told::Certificate,
        false => Told::Notebook,
    };
    let mut heard = Vec::new();
    let rated = args.model.rated().and(&sensor);
    let mut recordings = args
        .recordings
        .read_hearing(&rated, &mut |warning| heard.push(warning.to_string()))?;
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
    let request = Request {
        factory,
        gauge_range: args.recordings.read.gauge_range.clone(),
        measuring: args.measuring.settings(),
        ..Request::fit(Arc::new(recordings), settings)
    };
    let set = Arc::clone(&request.recordings);
    let mut data = report_of(
        &request,
        &sensor.identity,
        &limits.unwrap_or_default(),
        told,
        &Progress::default(),
    )?;
    data.calibration = Arc::new(with_sources(&data.calibration, &set));
    data.notes = args.notes.replace("\\n", "\n");
    data.warnings.extend(heard);
    let mut files = Together::default();
    let html = html_of(&data);
    files.write(&args.out, |out| out.write_all(html.as_bytes()))?;
    if let Some(path) = &args.dcc {
        let xml = dcc_of(&data)?;
        files.write(path, |out| out.write_all(xml.as_bytes()))?;
    }
    files.finish()?;
    for path in &outputs {
        print_path(path)?;
    }
    Ok(())
}
