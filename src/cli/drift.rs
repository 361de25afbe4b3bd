//! `loopscope drift`: what moved since the calibration was made, and how much of it has to be fitted again.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::choices::{ModelArgs, one_of};
use super::fit::warn_of;
use super::{JobError, ReadArgs, check_distinct, named_file, print_notes, print_path, read_all};
use crate::analysis::drift;
use crate::evaluation::sessions::{Drift, Refit};
use crate::export::{
    Together, add_calibration, check_targets, name_gauges, names_gauges, read_with_notes,
    target_for, with_sources,
};
use crate::progress::Progress;
use crate::recording::{Entry, GroupPattern, RecordingSet, Role};
use crate::report::drift_tables;
use crate::shown::printable;

/// Arguments of `drift`.
#[derive(Debug, Args)]
pub struct DriftArgs {
    #[command(flatten)]
    read: ReadArgs,
    /// Recordings of one or more sessions, with their reference load.
    #[arg(value_name = "FILE", required = true, value_parser = named_file())]
    pub(super) files: Vec<PathBuf>,
    /// The calibration that there is; without it, that which the first session gives.
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    calibration: Option<PathBuf>,
    /// What a session is: a name with {file}, {folder}, {recording}, or a {word} for the number or letter after it in the names, as
    /// in {day} [default: groups found from names, then the days of the clocks, then each recording].
    #[arg(long, value_name = "PATTERN")]
    group: Option<GroupPattern>,
    #[command(flatten)]
    model: ModelArgs,
    /// What is fitted again for --out.
    #[arg(long, requires = "out", value_parser = one_of(Refit::ALL.map(|own| (own, own.key(), own.explanation()))))]
    refit: Option<Refit>,
    /// Write the refitted calibration; the ending says how.
    #[arg(long, value_name = "FILE", requires = "refit", value_parser = named_file())]
    out: Option<PathBuf>,
    /// Write over a file that is there already.
    #[arg(long)]
    force: bool,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    json: bool,
}

/// What `drift --json` prints.
#[derive(Serialize)]
struct Report<'a> {
    simulated: bool,
    #[serde(flatten)]
    found: &'a Drift,
}

pub(super) fn run(args: &DriftArgs) -> Result<(), JobError> {
    if let Some(path) = args.out.as_ref().filter(|path| target_for(path).is_none()) {
        return Err(JobError::Ending { path: path.clone() });
    }
    let outputs: Vec<PathBuf> = args.out.iter().cloned().collect();
    let inputs = args
        .files
        .iter()
        .chain(&args.calibration)
        .chain(&args.read.columns);
    check_targets(inputs, &outputs, args.force)?;
    check_distinct(args.files.iter())?;
    let mut set = RecordingSet::default();
    for (path, recordings) in args.files.iter().zip(read_all(&args.files, &args.read)?) {
        for recording in recordings {
            if !recording.has_reference() {
                return Err(JobError::NoReference { path: path.clone() });
            }
            let group = match &args.group {
                None => None,
                Some(pattern) => {
                    Some(
                        pattern
                            .group_of(&recording)
                            .ok_or_else(|| JobError::NoGroup {
                                recording: recording.name().to_owned(),
                                pattern: pattern.clone().into(),
                            })?,
                    )
                }
            };
            set.push(Entry {
                group,
                ..Entry::new(recording, Role::Train)
            })?;
        }
    }
    let old = match &args.calibration {
        None => None,
        Some(path) => {
            let (mut calibration, notes) = read_with_notes(path)?;
            print_notes(&notes);
            if !names_gauges(path) {
                name_gauges(&mut calibration, &set.layout().gauge_names);
            }
            Some(calibration)
        }
    };
    let settings = args.model.settings(&set);
    let drifted = drift(&set, old.as_ref(), &settings, &Progress::default())?;
    if let (Some(path), Some(refit)) = (&args.out, args.refit) {
        let calibration = drifted.calibrations.iter().find(|(own, _)| *own == refit);
        let Some((_, calibration)) = calibration else {
            let refused = drifted.found.refits.iter().find(|own| own.refit == refit);
            let reason = refused.and_then(|own| own.problem.clone());
            let reason =
                reason.unwrap_or_else(|| "there is one session only, so nothing is new".to_owned());
            return Err(JobError::NoRefit {
                refit: refit.key(),
                reason,
            });
        };
        warn_of(calibration, &outputs);
        let mut files = Together::default();
        add_calibration(
            &mut files,
            &with_sources(calibration, &drifted.fitted_to),
            path,
        )?;
        files.finish()?;
    }
    let mut out = io::stdout().lock();
    if args.json {
        let report = Report {
            simulated: set.is_simulated(),
            found: &drifted.found,
        };
        serde_json::to_writer_pretty(&mut out, &report).map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        for line in text(&drifted.found).lines() {
            writeln!(out, "{}", printable(line))?;
        }
    }
    drop(out);
    if let (Some(path), false) = (&args.out, args.json) {
        print_path(path)?;
    }
    Ok(())
}

/// For people: what follows, then the figures.
fn text(found: &Drift) -> String {
    let mut lines: Vec<String> = found
        .sentences
        .iter()
        .map(|sentence| format!("* {sentence}"))
        .collect();
    lines.extend(
        drift_tables(found)
            .iter()
            .map(|table| format!("\n{}", table.text().trim_end())),
    );
    lines.join("\n")
}
