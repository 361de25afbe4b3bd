//! `loopscope drift`: what moved since the calibration was made, and how much of it has to be fitted again.

use std::ffi::OsStr;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use serde::Serialize;

use super::choices::{ModelArgs, one_of};
use super::fit::{step_text, warn_of};
use super::progress_line::ProgressLine;
use super::{JobError, ReadArgs, check_distinct, named_file, print_notes, print_path, read_all};
use crate::analysis::{OnStep, cross_validation_cost, drift};
use crate::evaluation::sessions::{Drift, Refit};
use crate::export::{
    Together, add_calibration, check_targets, name_gauges, names_gauges, read_with_notes,
    target_for, with_sources,
};
use crate::progress::Progress;
use crate::recording::{Day, Entry, GroupPattern, Recording, RecordingSet, Role};
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
    /// in {day} [default: groups found from names, then days (--date, the files' headers, clocks, names), then each recording].
    #[arg(long, value_name = "PATTERN")]
    group: Option<GroupPattern>,
    /// The day on which a file or recording of this name was recorded, as in run1.csv=2024-05-03; again for each.
    #[arg(long, value_name = "NAME=DATE")]
    date: Vec<DayOf>,
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

/// A file or recording, and the day on which it was recorded.
#[derive(Clone, Debug)]
struct DayOf {
    name: String,
    day: Day,
}

impl FromStr for DayOf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.rsplit_once('=').filter(|(name, _)| !name.is_empty());
        let (name, day) = parts.ok_or("what is wanted is NAME=DATE, as in run1.csv=2024-05-03")?;
        let day = day.parse::<Day>().map_err(|error| error.to_string())?;
        let name = name.to_owned();
        Ok(Self { name, day })
    }
}

impl DayOf {
    /// Whether it is about this recording of a file.
    fn is_of(&self, path: &Path, recording: &Recording) -> bool {
        let is_it = |name: Option<&OsStr>| name.is_some_and(|name| name == &*self.name);
        let is_file = is_it(path.file_name()) || is_it(path.file_stem());
        is_file || path == Path::new(&self.name) || recording.name() == self.name
    }
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
    let mut old = match &args.calibration {
        None => None,
        Some(path) => {
            let (calibration, notes) = read_with_notes(path)?;
            print_notes(&notes);
            Some(calibration)
        }
    };
    let rated = args.model.rated().and_of(old.as_ref());
    let mut set = RecordingSet::default();
    let mut dated = vec![false; args.date.len()];
    for (path, recordings) in args
        .files
        .iter()
        .zip(read_all(&args.files, &args.read, &rated)?)
    {
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
            let of = args
                .date
                .iter()
                .rposition(|own| own.is_of(path, &recording));
            let every = dated.iter_mut().zip(&args.date);
            every.for_each(|(is_used, own)| *is_used |= own.is_of(path, &recording));
            let recording = match of {
                Some(at) => recording.with_entered_day(Some(args.date[at].day)),
                None => recording,
            };
            set.push(Entry {
                group,
                ..Entry::new(recording, Role::Train)
            })?;
        }
    }
    if let Some(unused) = dated.iter().position(|is_used| !is_used) {
        return Err(JobError::NoSuchDated {
            name: args.date[unused].name.clone(),
        });
    }
    if let (Some(calibration), Some(path)) = (&mut old, &args.calibration)
        && !names_gauges(path)
    {
        name_gauges(calibration, &set.layout().gauge_names);
    }
    let settings = args.model.settings(&set);
    let mut line = ProgressLine::default();
    let cost = cross_validation_cost(&settings);
    let on_step: OnStep<'_> = &mut |step| line.say(&step_text(&step, cost));
    let drifted = drift(
        &set,
        old.as_ref(),
        &settings,
        Some(on_step),
        &Progress::default(),
    )?;
    line.end();
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
