//! `loopscope report`: fits a calibration, or reads a stored one, and writes a report as an HTML page.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::{
    error::{JobError, usage},
    exports::stored,
    inputs::Files,
    recordings::{FitArgs, FitInputs, MeasuringArgs, keep_limits, note_history},
    run::{Run, Work, examples},
    values::{file_in, named_file},
};
use crate::{
    calibration::Calibration,
    progress::Progress,
    questions::{
        Request, analyse,
        page::{ReportRequest, report, write_report},
        read_factory,
    },
    recording::simulated,
};

/// Fit a calibration, or read a stored one, and write a report with tables and figures as one HTML file.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope report --train day1.csv day2.csv --test day3.csv --out report.html", "writes one page to print or to send"),
    ("loopscope report sensor.json --train day1.csv day2.csv --test day3.csv --out report.html", "reports on a stored calibration, which is not fitted again"),
    ("loopscope report --train recordings --sensor sensor.toml --limits limits.toml --out report.html", "adds the sensor's identity; exit code 3 if a limit is exceeded"),
]))]
pub struct ReportJob {
    /// Calibration (.json) to report on, in place of a new fit. A calibration does not contain its recordings, so name them with
    /// --train and --test. With the recordings of its fit, the report has the same figures as that of the fit. The options of
    /// the model are not used.
    #[arg(value_parser = named_file())]
    calibration: Option<PathBuf>,
    #[command(flatten)]
    fit: FitArgs,
    /// HTML file to write. The figures are embedded in it.
    #[arg(long, value_name = "FILE.html", value_parser = file_in(&["html", "htm"]))]
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
        let files = self.fit.files().reading(&self.factory).reading(&self.calibration);
        files.writing([&self.out], self.force)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        let stored = self.calibration.as_deref().map(|path| stored(run, path)).transpose()?;
        if let Some(calibration) = &stored
            && run.inputs.recordings.is_empty()
            && !calibration.simulated
        {
            return usage(
                "a calibration does not contain its recordings; name them with --train and --test",
            );
        }
        let FitInputs { mut request, sensor, limits } = self.fit.read(run)?;
        let warnings = run.say.findings();
        if request.recordings.is_simulated() {
            let recordings = Arc::make_mut(&mut request.recordings);
            for entry in simulated::bench(simulated::DEFAULT_SEED) {
                recordings.push(entry)?;
            }
        }
        if let Some(calibration) = &stored {
            request.recordings = Arc::new(request.recordings.in_frame(calibration.frame)?);
        }
        let names = &request.recordings.layout().gauge_names;
        let range = self.fit.recordings.read.range(request.settings.full_scale.clone());
        let factory = self.factory.as_deref().map(|path| read_factory(path, names)).transpose()?;
        request.factory = factory.map(Arc::new);
        match stored {
            Some(calibration) => apply_stored(&mut request, calibration, &run.progress)?,
            None => note_history(run, &request)?,
        }
        let asked = ReportRequest {
            request,
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

/// Puts a stored calibration with its settings into the request. If the calibration has the same errors on these recordings as
/// in its file, it was fitted to them. Then the cross-validated errors of its file are also shown.
fn apply_stored(
    request: &mut Request,
    calibration: Calibration,
    progress: &Progress,
) -> Result<(), JobError> {
    request.settings = calibration.settings();
    let quality = calibration.quality.clone();
    request.calibration = Some(Arc::new(calibration));
    let found = &analyse(request, progress)?.calibration.quality;
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-6 * b.abs();
    let is_same = |a: &Option<Vec<f64>>, b: &Option<Vec<f64>>| match (a, b) {
        (Some(a), Some(b)) => a.len() == b.len() && a.iter().zip(b).all(is_near),
        (a, b) => a.is_none() && b.is_none(),
    };
    request.trained = (found.n_train, found.n_test) == (quality.n_train, quality.n_test)
        && is_same(&found.compensated.train_rmse, &quality.compensated.train_rmse)
        && is_same(&found.compensated.test_rmse, &quality.compensated.test_rmse);
    Ok(())
}
