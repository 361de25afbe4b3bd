//! `metrology`: hysteresis, nonlinearity, repeatability and more, conventional beside compensated.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use super::{JobError, Rated, ReadArgs, check_distinct, named_file, print_notes, read_all};
use crate::calibration::{AppliedLoads, Calibration, FitSettings};
use crate::export::{check_targets, read_with_notes, write_atomically};
use crate::features::{Distance, FeatureSettings, Thresholds};
use crate::progress::Progress;
use crate::questions::errors::Shown;
use crate::questions::loops::TableOf;
use crate::questions::metrology::{
    Metrology, MetrologySettings, Rules, Run, extents_of, extents_of_set, table_by,
};
use crate::questions::metrology::{axis_figures, crosstalk, figure_records};
use crate::questions::{Request, analyse};
use crate::recording::{Entry, Recording, RecordingSet, Role, simulated};
use crate::scoring::loops::LoadExtent;
use crate::shown::printable;

/// Arguments of `metrology`.
#[derive(Debug, Args)]
pub struct MetrologyArgs {
    #[command(flatten)]
    read: ReadArgs,
    /// Recordings to measure, with their reference load; without any, the built-in simulated sensor is fitted to its
    /// training recordings and measured on its test and bench recordings.
    #[arg(value_name = "FILE", value_parser = named_file())]
    pub(super) files: Vec<PathBuf>,
    /// Files of a folder that are not fitted to, and measured instead of those that are.
    #[arg(skip)]
    pub(super) test: Vec<PathBuf>,
    /// The calibration (JSON) to measure; without it, one is fitted to the same files.
    #[arg(long, value_name = "FILE", requires = "files", value_parser = named_file())]
    pub(super) calibration: Option<PathBuf>,
    /// Full scale of each axis in N and N·m, in axis order; by default the calibration's.
    #[arg(long, value_delimiter = ',', value_name = "FS,…", allow_negative_numbers = true)]
    full_scale: Vec<f64>,
    #[command(flatten)]
    measuring: MeasuringArgs,
    /// Write the table, with definitions and sources, as CSV.
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    csv: Option<PathBuf>,
    /// Write over files that are there already.
    #[arg(long)]
    force: bool,
    /// Print below the table how each figure is computed, and whose definition it follows.
    #[arg(long)]
    definitions: bool,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// How loops and figures are measured.
#[derive(Debug, Args)]
pub struct MeasuringArgs {
    /// How far the load of each axis must come back for a reversal, in N and N·m, in axis order; by default ten times the
    /// noise, and at least 5 % of the range.
    #[arg(long, value_delimiter = ',', value_name = "BAND,…", allow_negative_numbers = true)]
    dead_band: Vec<f64>,
    /// For how long a load must stand still to show creep or a zero.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = MetrologySettings::default().hold_secs,
        allow_negative_numbers = true
    )]
    hold: f64,
}

impl MeasuringArgs {
    /// The choices that these arguments mean.
    pub(super) fn settings(&self) -> MetrologySettings {
        MetrologySettings {
            dead_bands: self.dead_band.iter().copied().map(Some).collect(),
            hold_secs: self.hold,
            ..MetrologySettings::default()
        }
    }
}

/// A calibration and the recordings it is measured on.
struct Subject {
    calibration: Arc<Calibration>,
    recordings: Vec<Arc<Recording>>,
    /// What the loads do, of those that it is measured on and those that it was fitted to.
    extents: Vec<LoadExtent>,
    /// Where the calibration comes from, for people.
    origin: String,
}

/// What `metrology --json` prints.
#[derive(Serialize)]
struct Report<'a> {
    simulated: bool,
    calibration: &'a str,
    #[serde(flatten)]
    table: &'a Metrology,
}

pub(super) fn run(args: &MetrologyArgs) -> Result<(), JobError> {
    let outputs: Vec<PathBuf> = args.csv.iter().cloned().collect();
    let recordings = || args.files.iter().chain(&args.test);
    let inputs = recordings().chain(&args.calibration);
    let inputs = inputs.chain(&args.read.columns);
    check_targets(inputs, &outputs, args.force)?;
    check_distinct(recordings())?;
    let subject = subject(args)?;
    let table = measure(args, &subject)?;
    if let Some(path) = &args.csv {
        write_atomically(path, |out| figure_records(&table).write_csv(out))?;
    }
    let mut out = io::stdout().lock();
    if args.json {
        let report = Report {
            simulated: subject.calibration.simulated,
            calibration: &subject.origin,
            table: &table,
        };
        serde_json::to_writer_pretty(&mut out, &report).map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        for line in text(&subject, &table, args.definitions).lines() {
            writeln!(out, "{}", printable(line))?;
        }
    }
    Ok(())
}

fn subject(args: &MetrologyArgs) -> Result<Subject, JobError> {
    let Some(path) = &args.calibration else {
        return fitted(args);
    };
    let (calibration, notes) = read_with_notes(path)?;
    print_notes(&notes);
    let rated = Rated::of(&args.full_scale).and_of(Some(&calibration));
    let calibration = Arc::new(calibration);
    let recordings = read_all(&args.files, &args.read, &rated)?.into_iter().flatten();
    let recordings: Vec<Arc<Recording>> = recordings.map(Arc::new).collect();
    Ok(Subject {
        extents: extents_of(recordings.iter().map(|own| &**own), &calibration.axes),
        calibration,
        recordings,
        origin: format!("read from {}", path.display()),
    })
}

/// Fits with the settings that `fit` has by default.
fn fitted(args: &MetrologyArgs) -> Result<Subject, JobError> {
    let set = match args.files.is_empty() {
        true => simulated::demonstration(simulated::DEFAULT_SEED),
        false => recording_set(args)?,
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
    let on = match measured.includes(Role::Test) {
        true => "its training recordings, measured on the others",
        false => "the recordings it is measured on",
    };
    let recordings = (set.entries().iter())
        .filter(|entry| measured.includes(entry.role))
        .map(|entry| Arc::clone(&entry.recording))
        .collect();
    let extents = extents_of_set(&set, &set.layout().axes);
    let request = Request::fit(Arc::new(set), settings);
    let calibration = analyse(&request, &Progress::default())?.calibration;
    let rule = calibration.describe();
    Ok(Subject { calibration, recordings, extents, origin: format!("fitted to {on} ({rule})") })
}

fn recording_set(args: &MetrologyArgs) -> Result<RecordingSet, JobError> {
    let rated = Rated::of(&args.full_scale);
    let mut set = RecordingSet::default();
    for (files, role) in [(&args.files, Role::Train), (&args.test, Role::Test)] {
        for (path, recordings) in files.iter().zip(read_all(files, &args.read, &rated)?) {
            for recording in recordings {
                if !recording.has_reference() {
                    return Err(JobError::NoReference { path: path.clone() });
                }
                set.push(Entry::new(recording, role))?;
            }
        }
    }
    Ok(set)
}

fn measure(args: &MetrologyArgs, subject: &Subject) -> Result<Metrology, JobError> {
    let calibration = &subject.calibration;
    let applied: Vec<AppliedLoads> = (subject.recordings.iter())
        .map(|recording| calibration.apply(recording))
        .collect::<Result<_, _>>()
        .map_err(crate::questions::AnalysisError::from)?;
    let runs: Vec<Run<'_>> = (subject.recordings.iter().zip(&applied))
        .map(|(recording, applied)| Run::new(recording, applied))
        .collect();
    let full_scale =
        if args.full_scale.is_empty() { &calibration.full_scale } else { &args.full_scale };
    let rules = Rules {
        axes: &calibration.axes,
        full_scale,
        settings: &args.measuring.settings(),
        extents: &subject.extents,
    };
    Ok(table_by(&runs, &rules)?)
}

/// The table for people.
fn text(subject: &Subject, table: &Metrology, definitions: bool) -> String {
    let mut text = String::new();
    if subject.calibration.simulated {
        text.push_str("The built-in simulated sensor\n");
    }
    line(
        &mut text,
        format_args!(
            "{} recording{}, {} samples; calibration {}",
            table.n_recordings,
            if table.n_recordings == 1 { "" } else { "s" },
            table.n_samples,
            subject.origin
        ),
    );
    let axes = (0..table.axes.len()).map(|at| axis_figures(table, at, Shown::All));
    for shown in axes.chain(crosstalk(table)) {
        line(&mut text, format_args!("\n{}", shown.text().trim_end()));
    }
    if !table.notes.is_empty() {
        text.push('\n');
    }
    for note in &table.notes {
        line(&mut text, format_args!("Note: {note}"));
    }
    if definitions {
        definition_block(&mut text, table);
    } else {
        text.push_str(
            "\n--definitions says how each figure is computed and whose definition it follows.\n",
        );
    }
    text
}

fn line(text: &mut String, content: std::fmt::Arguments<'_>) {
    writeln!(text, "{content}").expect("a String takes all");
}

fn definition_block(text: &mut String, table: &Metrology) {
    for (name, about) in table.definitions() {
        let sentences = about.sentences().join("\n  ");
        line(text, format_args!("\n{name}: {sentences}"));
    }
}
