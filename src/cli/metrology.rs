//! `loopscope metrology`: measures hysteresis, nonlinearity, repeatability and more, before and after compensation.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use super::{
    error::JobError,
    exports::stored,
    inputs::Files,
    reading::{Needs, Rated, ReadArgs},
    recordings::{MeasuringArgs, note_history},
    run::{Run, Work, examples},
    values::{named_file, number_in},
};
use crate::{
    calibration::{AppliedLoads, Calibration, FitSettings},
    export::write_atomically,
    features::{Distance, FeatureSettings, Range, Thresholds},
    finding::Face,
    progress::Progress,
    questions::{
        Request,
        loops::TableOf,
        metrology::{
            Metrology, Rules, Run as MeasuredRun, axis_figures, crosstalk, figure_records, lags_of,
            table_by,
        },
        train,
    },
    recording::{Recording, Role, simulated},
    report::Shown,
    scoring::loops::{LoadExtent, extents_of, extents_of_set},
    shown::counted,
};

/// Measure hysteresis, nonlinearity, repeatability, creep, crosstalk and errors, before and after compensation.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope metrology press.csv --full-scale 200,200,400 --csv figures.csv", "measures hysteresis, repeatability and more, in % of these full scales"),
]))]
pub struct MetrologyJob {
    #[command(flatten)]
    read: ReadArgs,
    /// Recordings with reference loads, on which the figures are measured. Without files, the built-in simulated sensor is
    /// fitted to its training recordings and measured on its other recordings.
    #[arg(value_name = "FILE", value_parser = named_file())]
    files: Vec<PathBuf>,
    /// Calibration whose figures are measured (JSON) [default: one that is fitted to the files].
    #[arg(long, value_name = "FILE", requires = "files", value_parser = named_file())]
    calibration: Option<PathBuf>,
    /// Full scale of each axis in N and N·m, in axis order [default: that of the calibration].
    #[arg(long, value_delimiter = ',', value_name = "FS,…", value_parser = number_in(Range::Positive), allow_negative_numbers = true)]
    full_scale: Vec<f64>,
    #[command(flatten)]
    measuring: MeasuringArgs,
    /// Write the table, with definitions and their sources, to this CSV file.
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    csv: Option<PathBuf>,
    /// Overwrite existing files.
    #[arg(long)]
    force: bool,
    /// Also print how each figure is computed, and the source of its definition.
    #[arg(long)]
    definitions: bool,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

struct Subject {
    calibration: Arc<Calibration>,
    recordings: Vec<Arc<Recording>>,
    /// Range of the reference loads on each axis in the recordings.
    extents: Vec<LoadExtent>,
    origin: String,
}

#[derive(Serialize)]
struct Report<'a> {
    simulated: bool,
    calibration: &'a str,
    #[serde(flatten)]
    table: &'a Metrology,
}

impl Work for MetrologyJob {
    fn files(&self) -> Files<'_> {
        Files {
            recordings: &self.files,
            // If no calibration is given, one is fitted here. It is measured on the test files of a folder, if there are any,
            // and not on its training files.
            test: self.calibration.is_none().then_some(&[]),
            ..Files::default()
        }
        .reading(self.calibration.iter().chain(self.read.columns_file()))
        .writing(&self.csv, self.force)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        let subject = match &self.calibration {
            Some(path) => self.measured(run, path)?,
            None => self.fitted(run)?,
        };
        let table = self.measure(&subject, &run.progress)?;
        if let Some(path) = &self.csv {
            write_atomically(path, |out| figure_records(&table).write_csv(out))?;
        }
        let report = Report {
            simulated: subject.calibration.simulated,
            calibration: &subject.origin,
            table: &table,
        };
        run.print(self.json, &report, |out| print(&report, self.definitions, out))
    }
}

impl MetrologyJob {
    fn measured(&self, run: &Run, path: &Path) -> Result<Subject, JobError> {
        let calibration = stored(run, path)?;
        let rated = Rated {
            full_scale: self.full_scale.clone(),
            by_axis: calibration.rated_loads(),
            frame: calibration.frame,
        };
        let recordings = self.read.read(run, &run.inputs.recordings, &rated, Needs::Nothing)?;
        Ok(Subject {
            extents: extents_of(recordings.iter(), &calibration.axes),
            calibration: Arc::new(calibration),
            recordings: recordings.into_iter().map(Arc::new).collect(),
            origin: format!("read from {}", path.display()),
        })
    }

    fn fitted(&self, run: &Run) -> Result<Subject, JobError> {
        let set = if self.files.is_empty() {
            simulated::demonstration(simulated::DEFAULT_SEED)
        } else {
            let full_scale = self.full_scale.clone();
            self.read.read_set(run, &Rated { full_scale, ..Rated::default() }, Ok)?
        };
        let distance = Distance::default().effective(&set.layout().axes);
        let settings = FitSettings {
            features: FeatureSettings {
                look_backs: vec![Thresholds::default_for(distance)],
                distance,
                ..FeatureSettings::present()
            },
            ..FitSettings::default()
        };
        let measured = TableOf::usual(&set);
        let on = if measured.includes(Role::Test) {
            "fitted to the training recordings and measured on the others"
        } else {
            "fitted to the recordings on which it is measured"
        };
        let recordings = (set.entries().iter())
            .filter(|entry| measured.includes(entry.role))
            .map(|entry| Arc::clone(&entry.recording))
            .collect();
        let extents = extents_of_set(&set, &set.layout().axes);
        let request = Request::fit(Arc::new(set), settings);
        note_history(run, &request)?;
        let calibration = Arc::new(train(&request, &run.progress, &mut |_| {})?);
        let rule = calibration.describe();
        Ok(Subject { calibration, recordings, extents, origin: format!("{on} ({rule})") })
    }

    fn measure(&self, subject: &Subject, progress: &Progress) -> Result<Metrology, JobError> {
        let calibration = &subject.calibration;
        let applied: Vec<AppliedLoads> = (subject.recordings.iter())
            .map(|recording| calibration.apply(recording))
            .collect::<Result<_, _>>()?;
        let runs = subject.recordings.iter().zip(&applied);
        let runs: Vec<_> =
            runs.map(|(recording, applied)| MeasuredRun::new(recording, applied)).collect();
        let full_scale = match &self.full_scale[..] {
            [] => &calibration.full_scale,
            given => given,
        };
        let rules = Rules {
            axes: &calibration.axes,
            full_scale,
            settings: &self.measuring.settings(),
            extents: &subject.extents,
        };
        let lags = lags_of(&runs, &calibration.axes, progress)?;
        Ok(table_by(&runs, &rules, lags)?)
    }
}

fn print(report: &Report<'_>, definitions: bool, out: &mut Vec<u8>) -> io::Result<()> {
    let table = report.table;
    if report.simulated {
        writeln!(out, "The built-in simulated sensor")?;
    }
    let recordings = counted(table.n_recordings, "recording");
    let (samples, calibration) = (table.n_samples, report.calibration);
    writeln!(out, "{recordings}, {samples} samples; calibration {calibration}")?;
    let axes = (0..table.axes.len()).map(|at| axis_figures(table, at, Shown::All));
    for shown in axes.chain(crosstalk(table)) {
        writeln!(out, "\n{}", shown.text().trim_end())?;
    }
    if !table.findings.is_empty() {
        writeln!(out)?;
    }
    for found in &table.findings {
        writeln!(out, "Note: {}", found.text(Face::CommandLine))?;
    }
    if !definitions {
        return writeln!(
            out,
            "\n--definitions prints how each figure is computed, and the source of its definition."
        );
    }
    for (name, about) in table.definitions() {
        writeln!(out, "\n{name}: {}", about.sentences().join("\n  "))?;
    }
    Ok(())
}
