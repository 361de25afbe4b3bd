//! `loopscope apply`: computes the loads of recordings with a calibration.

use std::path::{Path, PathBuf};
use std::slice;

use clap::Args;

use super::error::{JobError, usage};
use super::exports::stored;
use super::inputs::Files;
use super::live;
use super::reading::{Needs, Rated, ReadArgs};
use super::run::{Run, Work, examples, make_directory};
use super::traces::TraceArgs;
use super::values::{named_file, number_in};
use crate::{
    calibration::Calibration,
    export::{Together, name_gauges, names_gauges, write_atomically, write_loads_csv},
    features::Range,
    import::live::RowForm,
    recording::{Recording, Tare, units::TimeUnit},
    shown::joined,
};

/// Compute the loads of recordings with a calibration: the uncompensated and the compensated load of each sample, as CSV.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope apply sensor.json run.csv --out loads", "writes loads/run_loads.csv"),
    ("loopscope apply sensor.json log.csv --follow", "computes the load of each row of a log file, also of rows that are appended later"),
]))]
pub struct ApplyJob {
    #[command(flatten)]
    read: ReadArgs,
    /// Calibration (.json, or .cal in ATI's format). The gauges in a .cal have no names, so they are taken in the order of
    /// the recording.
    #[arg(value_parser = named_file())]
    calibration: PathBuf,
    /// Recordings with the gauges of the calibration, or - for rows on standard input. The load of each row is written to
    /// standard output at once. Before and between the rows, the lines "tare" and "tare SECONDS" tare the sensor, and "reset"
    /// makes the program forget the earlier rows.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Folder for the files `<name>_loads.csv`. A missing folder is created.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Add a last column with the status of each sample, which live rows always have: ok, filling (the history is still too short), after a gap (the
    /// sample follows a pause), restarted (the clock was reset), beyond (the load is outside the tested range of the sensor),
    /// auxiliary held (the value of an auxiliary channel is too old), rejected. Several statuses are joined by +.
    #[arg(long)]
    status: bool,
    /// Write the loads of one file to standard output, and then the load of each row that a logger appends to the file.
    #[arg(long, conflicts_with_all = ["out", "traces"])]
    follow: bool,
    #[arg(long, value_name = "FORM", value_parser = rows, help = rows_help())]
    rows: Option<Rows>,
    /// Unit of the times of live rows (- or --follow) without a unit: s, ms, us or ns [default: the unit with which the rows have
    /// nearly the sample rate of the calibration].
    #[arg(long, value_name = "UNIT", value_parser = time_unit)]
    time_unit: Option<TimeUnit>,
    /// Sample rate in Hz of live rows (- or --follow) without a time [default: the time is that of this computer's clock].
    #[arg(long, value_name = "HZ", value_parser = number_in(Range::Positive))]
    rate: Option<f64>,
    /// Print the loads of live rows (- or --follow) as JSON, one object on each line.
    #[arg(long, conflicts_with_all = ["out", "traces"])]
    json: bool,
    #[command(flatten)]
    traces: TraceArgs,
    /// Overwrite existing files.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Debug)]
enum Rows {
    Form(RowForm),
    /// Names of the columns of a table, whose rows come without a header.
    Columns(String),
}

/// Returns the form of live rows, or the names of their columns.
fn rows(text: &str) -> Result<Rows, String> {
    if text.contains(',') {
        return Ok(Rows::Columns(text.to_owned()));
    }
    let known = RowForm::ALL.into_iter().find(|(_, name, _)| *name == text);
    known.map(|(form, ..)| Rows::Form(form)).ok_or_else(|| {
        let names = joined(", ", RowForm::ALL.map(|(_, name, _)| name));
        format!("use one of {names}, or the names of all columns, separated by commas")
    })
}

fn rows_help() -> String {
    let forms = RowForm::ALL.map(|(_, name, words)| format!("{name} ({words})"));
    format!(
        "Format of live rows (- or --follow): {}; or the names of their columns, separated by commas: \"time [ms],S1,S2\". A column that is not needed may have any other name. A line that does not have this format is rejected [default: detected from a line with the names of all gauges, or from the first ten rows]",
        joined(", ", forms)
    )
}

fn time_unit(text: &str) -> Result<TimeUnit, String> {
    TimeUnit::from_name(text)
        .ok_or_else(|| "this is no unit of time; use s, ms, us or ns".to_owned())
}

impl Work for ApplyJob {
    fn files(&self) -> Files<'_> {
        Files { recordings: &self.files, ..Files::default() }
            .reading([&self.calibration])
            .reading(self.read.columns_file())
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        let calibration = stored(run, &self.calibration)?;
        let is_live = self.follow || self.files.iter().any(|path| path.as_os_str() == "-");
        if is_live { self.answer_rows(run, calibration) } else { self.apply(run, calibration) }
    }
}

impl ApplyJob {
    fn apply(&self, run: &Run, mut calibration: Calibration) -> Result<(), JobError> {
        if self.out.is_none() && self.traces.traces.is_none() {
            return usage("no output is given; use --out DIR, or --traces FILE");
        }
        if self.status && self.out.is_none() {
            return usage("--status is a column of the loads; use --out DIR");
        }
        let outputs = self.load_files(run)?;
        let written: Vec<PathBuf> = outputs.iter().chain(&self.traces.traces).cloned().collect();
        if let Some(out) = &self.out {
            make_directory(out)?;
        }
        run.check_outputs(&written, self.force)?;
        let names_gauges = names_gauges(&self.calibration);
        let rated = Rated {
            by_axis: calibration.rated_loads(),
            frame: calibration.frame,
            ..Rated::default()
        };
        let mut all = Vec::new();
        for (at, input) in run.inputs.recordings.iter().enumerate() {
            let recordings = self.read.read(run, slice::from_ref(input), &rated, Needs::Nothing)?;
            let Some(first) = recordings.first() else { continue };
            if !names_gauges {
                name_gauges(&mut calibration, first.gauge_names());
            }
            let path = input.path.display();
            if first.tare().is_none() {
                if let Some(tare) = calibration.tare {
                    run.say.note(format_args!(
                        "{path}: the recording is not tared, but the calibration was fitted to gauges minus their mean over {tare}; add --tare"
                    ));
                }
                if !names_gauges {
                    run.say.note(format_args!(
                        "{path}: the recording is not tared, but a .cal calibration has no offset; add --tare"
                    ));
                }
            }
            for beyond in
                recordings.iter().flat_map(|recording| calibration.auxiliary_beyond(recording))
            {
                run.say.warning(beyond);
            }
            if let Some(output) = outputs.get(at) {
                let written = self.write_loads(&calibration, &input.path, &recordings, output);
                self.read.or_left_out(run, written.and_then(|()| run.print_path(output)))?;
            }
            if self.traces.traces.is_some() {
                all.extend(recordings);
            }
        }
        let mut traces = Together::default();
        self.traces.write(&mut traces, &calibration, all.iter(), 1)?;
        traces.finish()?;
        self.traces.traces.iter().try_for_each(|path| run.print_path(path))
    }

    fn answer_rows(&self, run: &Run, calibration: Calibration) -> Result<(), JobError> {
        let writes = self.out.is_some() || self.traces.traces.is_some();
        let ([path], false) = (&self.files[..], writes) else {
            return usage(
                "live rows (- or --follow) need a single input and no output file, because their loads go to standard output",
            );
        };
        if self.read.tare == Some(Tare::Auto) {
            return usage(
                "live rows can be tared only over an interval: --tare FROM:TO, in seconds from the first row",
            );
        }
        if let Some(tare) = calibration.tare.filter(|_| self.read.tare.is_none()) {
            run.say.note(format_args!(
                "the calibration was fitted to gauges minus their mean over {tare}; tare the live rows too"
            ));
        }
        let tap = live::Tap {
            say: &run.say,
            calibration,
            names_gauges: names_gauges(&self.calibration),
            map: self.read.map()?,
            tare: self.read.tare,
            form: self.rows.as_ref().map(|rows| match rows {
                Rows::Form(form) => *form,
                Rows::Columns(_) => RowForm::Table,
            }),
            header: self.rows.as_ref().and_then(|rows| match rows {
                Rows::Form(_) => None,
                Rows::Columns(names) => Some(names.clone()),
            }),
            time_unit: self.time_unit,
            rate_hz: self.rate,
            json: self.json,
        };
        if path.as_os_str() == "-" { live::standard_input(tap) } else { live::follow(tap, path) }
    }

    /// Returns the output file for the loads of each input file; empty without an output folder.
    fn load_files(&self, run: &Run) -> Result<Vec<PathBuf>, JobError> {
        let Some(out) = &self.out else {
            return Ok(Vec::new());
        };
        let mut outputs: Vec<PathBuf> = Vec::new();
        for input in &run.inputs.recordings {
            let mut name = input.path.file_stem().unwrap_or_default().to_owned();
            name.push("_loads.csv");
            let output = out.join(name);
            if let Some(earlier) = outputs.iter().position(|other| *other == output) {
                return usage(format!(
                    "{} and {} would both be written to {}; apply them one by one",
                    run.inputs.recordings[earlier].path.display(),
                    input.path.display(),
                    output.display()
                ));
            }
            outputs.push(output);
        }
        Ok(outputs)
    }

    fn write_loads(
        &self,
        calibration: &Calibration,
        path: &Path,
        recordings: &[Recording],
        output: &Path,
    ) -> Result<(), JobError> {
        for recording in recordings {
            calibration
                .prepared(recording)
                .map_err(|error| JobError::other(format!("{}: {error}", path.display())))?;
        }
        Ok(write_atomically(output, |out| {
            write_loads_csv(calibration, recordings, self.status, out)
        })?)
    }
}
