//! `loopscope report`: fits a calibration and writes a report as an HTML page.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::error::{JobError, usage};
use super::inputs::Files;
use super::recordings::{FitArgs, FitInputs, MeasuringArgs, keep_limits};
use super::run::{Run, Work, examples};
use super::values::named_file;
use crate::{
    questions::{
        Request,
        page::{ReportRequest, report, write_report},
        read_factory,
    },
    recording::simulated,
};

/// Fit a calibration and write a report with tables and figures as one HTML file.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope report --train day1.csv day2.csv --test day3.csv --out report.html", "writes one page to print or to send"),
    ("loopscope report --train recordings --sensor sensor.toml --limits limits.toml --out report.html", "adds the sensor's identity; exit code 3 if a limit is exceeded"),
]))]
pub struct ReportJob {
    #[command(flatten)]
    fit: FitArgs,
    /// HTML file to write. The figures are embedded in it.
    #[arg(long, value_name = "FILE.html", value_parser = named_file())]
    out: PathBuf,
    /// Also report the errors of the manufacturer's calibration (.cal or .json); see `fit --factory`.
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    factory: Option<PathBuf>,
    #[command(flatten)]
    measuring: MeasuringArgs,
    /// Text under the head "Notes", in which \n begins a new paragraph.
    #[arg(long, value_name = "TEXT", default_value = "")]
    notes: String,
    /// Overwrite an existing file.
    #[arg(long)]
    force: bool,
}

impl Work for ReportJob {
    fn files(&self) -> Files<'_> {
        self.fit.files().reading(&self.factory).writing([&self.out], self.force)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        let ending = self.out.extension().unwrap_or_default().to_ascii_lowercase();
        if ending != "html" && ending != "htm" {
            return usage(format!(
                "{}: reports are HTML files; choose a name that ends in .html",
                self.out.display()
            ));
        }
        let FitInputs { mut recordings, settings, sensor, limits } = self.fit.read(run)?;
        let warnings = run.say.findings();
        if recordings.is_simulated() {
            for entry in simulated::bench(simulated::DEFAULT_SEED) {
                recordings.push(entry)?;
            }
        }
        let names = &recordings.layout().gauge_names;
        let range = self.fit.recordings.read.range(settings.full_scale.clone());
        let factory = self.factory.as_deref().map(|path| read_factory(path, names)).transpose()?;
        let factory = factory.map(Arc::new);
        let asked = ReportRequest {
            request: Request { factory, ..Request::fit(Arc::new(recordings), settings) },
            identity: sensor.identity,
            notes: self.notes.replace("\\n", "\n"),
            limits,
            measuring: self.measuring.settings(),
            range,
        };
        let mut data = report(&asked, &run.progress)?;
        data.warnings.extend(warnings);
        write_report(&self.out, &data)?;
        run.print_path(&self.out)?;
        keep_limits(&data.limits)
    }
}
