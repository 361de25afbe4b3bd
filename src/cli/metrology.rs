//! `metrology`: the figures that a calibration certificate asks for, conventional beside compensated.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use super::{JobError, ReadArgs, check_distinct, named_file, read_all};
use crate::analysis::{Request, analyse};
use crate::calibration::{AppliedLoads, Calibration, FitSettings};
use crate::evaluation::metrics::percent_change;
use crate::evaluation::metrology::{
    Cell, Figure, Metrology, MetrologySettings, Reason, Row, Run, table,
};
use crate::evaluation::numbers::significant;
use crate::export::{check_targets, read_calibration, write_atomically, write_metrology_csv};
use crate::features::{Distance, FeatureSettings, Thresholds};
use crate::progress::Progress;
use crate::recording::{Entry, Recording, RecordingSet, Role, simulated};
use crate::shown::printable;

/// Arguments of `metrology`.
#[derive(Debug, Args)]
pub struct MetrologyArgs {
    #[command(flatten)]
    read: ReadArgs,
    /// Recordings to measure, with their reference load; without any, the built-in simulated sensor is fitted to its
    /// training recordings and measured on its test recordings.
    #[arg(value_name = "FILE", value_parser = named_file())]
    files: Vec<PathBuf>,
    /// The calibration (JSON) to measure; without it, one is fitted to the same files.
    #[arg(long, value_name = "FILE", requires = "files", value_parser = named_file())]
    calibration: Option<PathBuf>,
    /// Full scale of each axis in N and N·m, in axis order; by default the calibration's.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "FS,…",
        allow_negative_numbers = true
    )]
    full_scale: Vec<f64>,
    /// How far the load of each axis must come back for a reversal, in N and N·m, in axis order; by default ten times the
    /// noise, and at least 2 % of the range.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "BAND,…",
        allow_negative_numbers = true
    )]
    dead_band: Vec<f64>,
    /// For how long a load must stand still to show creep or a zero.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 5.0,
        allow_negative_numbers = true
    )]
    hold: f64,
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

/// A calibration and the recordings it is measured on.
struct Subject {
    calibration: Arc<Calibration>,
    recordings: Vec<Arc<Recording>>,
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
    let inputs = args.files.iter().chain(&args.calibration);
    let inputs = inputs.chain(&args.read.columns);
    check_targets(inputs, &outputs, args.force)?;
    check_distinct(args.files.iter())?;
    let subject = subject(args)?;
    let table = measure(args, &subject)?;
    if let Some(path) = &args.csv {
        write_atomically(path, |out| write_metrology_csv(&table, out))?;
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
    Ok(Subject {
        calibration: Arc::new(read_calibration(path)?),
        recordings: read_all(&args.files, &args.read)?
            .into_iter()
            .flatten()
            .map(Arc::new)
            .collect(),
        origin: format!("read from {}", path.display()),
    })
}

/// Fits with the settings that `fit` has by default.
fn fitted(args: &MetrologyArgs) -> Result<Subject, JobError> {
    let (set, measured, on) = if args.files.is_empty() {
        let set = simulated::recordings(simulated::DEFAULT_SEED);
        (
            set,
            Role::Test,
            "its training recordings, measured on the others",
        )
    } else {
        (
            training_set(&args.files, &args.read)?,
            Role::Train,
            "the recordings it is measured on",
        )
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
    let recordings = (set.entries().iter())
        .filter(|entry| entry.role == measured)
        .map(|entry| Arc::clone(&entry.recording))
        .collect();
    let request = Request::fit(Arc::new(set), settings);
    let calibration = analyse(&request, &Progress::default())?.calibration;
    let rule = calibration.describe();
    Ok(Subject {
        calibration,
        recordings,
        origin: format!("fitted to {on} ({rule})"),
    })
}

fn training_set(files: &[PathBuf], read: &ReadArgs) -> Result<RecordingSet, JobError> {
    let mut set = RecordingSet::default();
    for (path, recordings) in files.iter().zip(read_all(files, read)?) {
        for recording in recordings {
            if !recording.has_reference() {
                return Err(JobError::NoReference { path: path.clone() });
            }
            set.push(Entry::new(recording, Role::Train))?;
        }
    }
    Ok(set)
}

fn measure(args: &MetrologyArgs, subject: &Subject) -> Result<Metrology, JobError> {
    let calibration = &subject.calibration;
    let applied: Vec<AppliedLoads> = (subject.recordings.iter())
        .map(|recording| calibration.apply(recording))
        .collect::<Result<_, _>>()
        .map_err(crate::analysis::AnalysisError::from)?;
    let runs: Vec<Run<'_>> = (subject.recordings.iter().zip(&applied))
        .map(|(recording, applied)| Run::new(recording, applied))
        .collect();
    let full_scale = if args.full_scale.is_empty() {
        &calibration.full_scale
    } else {
        &args.full_scale
    };
    let settings = MetrologySettings {
        dead_bands: args.dead_band.iter().copied().map(Some).collect(),
        hold_secs: args.hold,
        ..MetrologySettings::default()
    };
    Ok(table(&runs, &calibration.axes, full_scale, &settings)?)
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
    for at in 0..table.axes.len() {
        axis_block(&mut text, table, at);
    }
    if table.axes.len() > 1 {
        crosstalk_block(&mut text, table);
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

fn axis_block(text: &mut String, table: &Metrology, at: usize) {
    let axis = table.axes[at];
    let head = format!(
        "{} [{}], full scale {}, dead band {}",
        axis.symbol(),
        axis.unit(),
        significant(table.full_scale[at], 4),
        significant(table.dead_bands[at], 3),
    );
    line(
        text,
        format_args!(
            "\n{head:<47}{:>12}{:>9}{:>12}{:>9}{:>11}",
            "Conv.", "% FS", "Comp.", "% FS", "change"
        ),
    );
    for row in table.own_rows() {
        figure_line(text, row, &row.cells[at]);
    }
}

fn figure_line(text: &mut String, row: &Row, cell: &Cell) {
    let mut name = row.definition.name.clone();
    if row.quantity.is_time() {
        write!(name, " [{}]", cell.unit).expect("a String takes all");
    }
    let (conventional, compensated) = (&cell.conventional, &cell.compensated);
    if let (Err(first), Err(second)) = (conventional, compensated)
        && first == second
    {
        line(text, format_args!("  {name:<45}  {first}"));
        return;
    }
    let [value, percent] = shown(conventional);
    let [value_after, percent_after] = shown(compensated);
    let change = match (conventional, compensated) {
        (Ok(before), Ok(after)) if !row.quantity.is_time() => {
            percent_change(before.value.abs(), after.value.abs())
        }
        _ => None,
    };
    let change = change.map_or_else(String::new, |change| format!("{change:+.1} %"));
    let figures = format!("{value:>12}{percent:>9}{value_after:>12}{percent_after:>9}{change:>11}");
    line(text, format_args!("  {name:<45}{}", figures.trim_end()));
    for (kind, figure) in OUTPUTS {
        if let Err(reason) = figure(cell) {
            line(text, format_args!("    {kind}: {reason}"));
        }
    }
}

/// Value and percent of full scale; a dash and nothing where there is no figure.
fn shown(figure: &Figure) -> [String; 2] {
    match figure {
        Ok(value) => [
            significant(value.value, 4),
            value
                .percent_fs
                .map_or_else(String::new, |percent| significant(percent, 3)),
        ],
        Err(_) => ["–".to_owned(), String::new()],
    }
}

/// Two rows per loaded axis, one column per axis that reads it; or one with the reason why there is nothing to read.
fn crosstalk_block(text: &mut String, table: &Metrology) {
    let columns: String = table
        .axes
        .iter()
        .map(|axis| format!("{:>9}", axis.symbol()))
        .collect();
    line(text, format_args!("\n{:<27}{columns}", "Crosstalk [% FS]"));
    for (from, row) in table.crosstalk_rows() {
        let from = format!("from {}", from.symbol());
        if let Some(reason) = shared_reason(row) {
            line(text, format_args!("  {from:<27}{reason}"));
            continue;
        }
        for (kind, figure) in OUTPUTS {
            let figures: String = row.cells.iter().map(figure).map(percent_cell).collect();
            line(
                text,
                format_args!("  {:<25}{figures}", format!("{from}, {kind}")),
            );
        }
    }
}

/// Picks one of a cell's figures.
type Pick = fn(&Cell) -> &Figure;

const OUTPUTS: [(&str, Pick); 2] = [
    ("Conv.", |cell| &cell.conventional),
    ("Comp.", |cell| &cell.compensated),
];

/// Why no axis but the loaded one has a figure, if it is the same for all.
fn shared_reason(row: &Row) -> Option<&Reason> {
    let figures = OUTPUTS
        .iter()
        .flat_map(|(_, figure)| row.cells.iter().map(figure));
    let mut others = figures.filter(|figure| !matches!(figure, Err(Reason::LoadedAxis { .. })));
    let reason = others.next()?.as_ref().err()?;
    others
        .all(|other| other.as_ref().err() == Some(reason))
        .then_some(reason)
}

fn percent_cell(figure: &Figure) -> String {
    let percent = figure.as_ref().ok().and_then(|value| value.percent_fs);
    let shown = percent.map_or_else(|| "–".to_owned(), |percent| significant(percent, 3));
    format!("{shown:>9}")
}

fn definition_block(text: &mut String, table: &Metrology) {
    for (name, about) in table.definitions() {
        line(
            text,
            format_args!(
                "\n{name}: {}.\n  Source: {}.",
                about.definition, about.source
            ),
        );
        if !about.free_running.is_empty() {
            line(
                text,
                format_args!("  Free-running: {}.", about.free_running),
            );
        }
    }
}
