//! The command line: the window, or one job for scripts and machines without a display.

mod best;
mod check;
mod choices;
mod compare;
mod examples;
mod fit;
mod inspect;
mod installed;
mod live;
mod metrology;
mod progress_line;
mod report;
mod sweep;
mod traces;

use std::collections::HashMap;
use std::error::Error as _;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, Write};
use std::num::{ParseFloatError, ParseIntError};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory as _, Parser, Subcommand, ValueEnum};

use crate::about;
use crate::calibration::{Calibration, CalibrationError, Undetermined};
use crate::engine::Session;
use crate::export::{
    FileFormat, ReadCalibrationError, TRACE_FORMATS, TargetError, Together, WriteError,
    check_targets, interrupted_code, name_gauges, names_gauges, read_with_notes, target_endings,
    target_for, write_atomically, write_loads_csv,
};
use crate::finding::{Face, with_ways};
use crate::formats::FileError;
use crate::formats::csv::write_csv;
use crate::import;
use crate::import::map::{ColumnMap, MapFileError};
use crate::import::{LoadWarning, ReadError};
use crate::progress::Progress;
use crate::questions::AnalysisError;
use crate::questions::expected_error::limits::{Checked, LimitsError};
use crate::questions::metrology::MetrologyError;
use crate::recording::Item;
use crate::recording::identity::{SensorFile, SensorFileError};
use crate::recording::{
    Axis, GaugeRange, LayoutError, Recording, Role, Tare, TareError, ValidRange, simulated,
};
use crate::scoring::faults::{Faults, faults, faults_of};
use crate::shown;
use crate::shown::{and_more, listed, printable};

pub use compare::CompareArgs;
pub use fit::FitArgs;
pub use inspect::Inspect;
pub use report::ReportArgs;
pub use sweep::SweepArgs;

/// Calibrate force/torque sensors and see what their past does to them.
#[derive(Debug, Parser)]
#[command(
    version,
    long_version = about::long_version(),
    mut_subcommands(examples::shown),
    after_help = examples::of(""),
    args_conflicts_with_subcommands = true
)]
pub struct Cli {
    /// The job; without one the window opens.
    #[command(subcommand)]
    pub job: Option<Job>,
    /// Recordings, a session or a calibration to open in the window; `inspect --help` lists the formats of recordings.
    pub files: Vec<PathBuf>,
}

impl Cli {
    /// Understands these words, the program's name first.
    ///
    /// # Errors
    /// What clap finds, with a way out where it knows none; or a word that is no command and no file.
    pub fn understood(words: &[OsString]) -> Result<Self, clap::Error> {
        let mut cli = Self::try_parse_from(words)
            .map_err(|error| misspelt(words).unwrap_or_else(|| with_way_out(error, words)))?;
        cli.files = expanded(&cli.files);
        match cli.files.iter().find(|path| !path.exists()) {
            Some(gone) => Err(misspelt(words).unwrap_or_else(|| {
                let gone = printable(&gone.to_string_lossy()).into_owned();
                let message = format!("{gone}: there is no such file, and no such command");
                Self::command().error(ErrorKind::ValueValidation, message)
            })),
            None => Ok(cli),
        }
    }
}

/// Puts the files that patterns stand for in the places of the patterns: not every shell does it.
fn expanded(paths: &[PathBuf]) -> Vec<PathBuf> {
    let paths = paths.iter();
    let files = paths.map(|path| import::matching(path).unwrap_or_else(|| vec![path.clone()]));
    files.flatten().collect()
}

/// What clap says of a first word that is like a command and is nothing else.
fn misspelt(words: &[OsString]) -> Option<clap::Error> {
    let [program, word, ..] = words else {
        return None;
    };
    let is_word = |text: &str| !text.starts_with('-') && !text.contains(['.', '/', '\\']);
    if !word.to_str().is_some_and(is_word) || Path::new(word).exists() {
        return None;
    }
    let command = Cli::command();
    // Without the files, which any word could be.
    let jobs = clap::Command::new("loopscope").subcommands(command.get_subcommands().cloned());
    let error = jobs.try_get_matches_from([program, word]).err()?;
    let is_like_one = error.get(ContextKind::SuggestedSubcommand).is_some();
    is_like_one.then_some(error)
}

/// Where a recording is named bare, how it is named; where no number stands for one, how it is written.
fn with_way_out(mut error: clap::Error, words: &[OsString]) -> clap::Error {
    let is_not = match error.source() {
        Some(why) if why.is::<ParseFloatError>() => {
            Some("this is not a number; write it without a unit, as in 0.5 or 15")
        }
        Some(why) if why.is::<ParseIntError>() => {
            Some("this is not a whole number; write it with digits alone, as in 10")
        }
        _ => None,
    };
    if let (Some(is_not), Some(value), Some(name)) =
        (is_not, error.get(ContextKind::InvalidValue), error.get(ContextKind::InvalidArg))
    {
        let message = format!("invalid value '{value}' for '{name}': {is_not}\n");
        return clap::Error::raw(error.kind(), message);
    }
    let command = Cli::command();
    let job = words.get(1).and_then(|word| command.find_subcommand(word));
    let takes_train = |job: &clap::Command| job.get_arguments().any(|arg| arg.get_id() == "train");
    if error.kind() == ErrorKind::UnknownArgument
        && let Some(job) = job.filter(|job| takes_train(job))
        && let Some(ContextValue::String(bare)) = error.get(ContextKind::InvalidArg)
        && !bare.starts_with('-')
    {
        let tip = format!("recordings are named after --train: {} --train {bare}", job.get_name());
        let tips = ContextValue::StyledStrs(vec![tip.into()]);
        error.insert(ContextKind::Suggested, tips);
    }
    error
}

/// What can be done without a window.
#[derive(Debug, Subcommand)]
pub enum Job {
    /// Say what a file holds, what would be loaded and what is wrong; write a column map for it.
    Inspect(Inspect),
    /// Write the built-in simulated sensor's recordings as CSV: `train_*.csv` and `test_*.csv`.
    Demo(Demo),
    /// Fit the conventional calibration and one with a past, and score both.
    Fit(Box<FitArgs>),
    /// Say whether the recordings carry the model: what they reach, load cases for coefficients, and which to record next.
    Check(Box<check::CheckArgs>),
    /// Print a description of a sensor to fill in: `sensor.toml`.
    Sensor,
    /// Fit, and write a report with tables and pictures: one HTML file.
    Report(Box<ReportArgs>),
    /// Find the model to take: tries sensible ones, cheap ones first, and scores each on recordings that it has not seen.
    Best(Box<best::BestArgs>),
    /// Fit every regressor without and with the past, on all and on every tenth sample: one table.
    Compare(Box<CompareArgs>),
    /// Fit at every pair of thresholds: curves, the map, and which thresholds to take.
    Sweep(Box<SweepArgs>),
    /// Apply a calibration: Conv. and Comp. of each sample as CSV.
    Apply(Apply),
    /// Measure hysteresis, nonlinearity, repeatability, creep, crosstalk and errors, before and after compensation.
    Metrology(metrology::MetrologyArgs),
    /// Print what a shell completes the words of a command by.
    Completions(installed::CompletionsArgs),
    /// Write the manual pages.
    #[command(hide = true)]
    Man(installed::ManArgs),
}

/// How much of the built-in recordings is written.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Pattern {
    /// All samples, 20 Hz.
    A,
    /// Every tenth sample, 2 Hz.
    B,
}

/// Arguments of `demo`.
#[derive(Debug, Args)]
pub struct Demo {
    /// Where to; made if it is not there.
    dir: PathBuf,
    /// The paper's amount of data: a is all of it, b every tenth sample.
    #[arg(long, value_enum, default_value = "a")]
    pattern: Pattern,
    /// Another seed makes another sensor of the same kind on other paths.
    #[arg(long, default_value_t = simulated::DEFAULT_SEED)]
    seed: u64,
    /// Write over files that are there already.
    #[arg(long)]
    force: bool,
}

/// How files are read, for all jobs that read recordings.
#[derive(Clone, Debug, Args)]
pub struct ReadArgs {
    /// What the columns of the files are, where their names do not say it; `inspect --write-map` writes one.
    #[arg(long, value_name = "MAP.json", value_parser = named_file())]
    columns: Option<PathBuf>,
    /// Take the gauges' mean over an interval off each recording: FROM:TO in seconds from its start, or "auto": the first quiet
    /// half second in which the reference shows no load. What a calibration made so is applied to must be tared, too.
    #[arg(long, value_name = "auto|FROM:TO")]
    tare: Option<Tare>,
    /// What a gauge can show at least and at most, as the logger writes it; what reaches it is clipped. One for all, or one for each
    /// gauge in their order, with nothing between the commas where it is not known.
    #[arg(long, value_name = "LOW:HIGH,…", value_parser = gauge_range, allow_hyphen_values = true)]
    gauge_range: Option<GaugeRange>,
    /// Leave out samples that look faulty: clipped, stuck, dropped out, spikes, beyond rated loads. Exported code then says where a gauge is clipped.
    #[arg(long)]
    leave_out_faulty: bool,
    /// Go on without files that cannot be read; the exit code is 1 then.
    #[arg(long)]
    keep_going: bool,
}

/// Of more recordings of a file that look faulty the others are counted.
const LISTED_FAULTY: usize = 8;

fn gauge_range(text: &str) -> Result<GaugeRange, String> {
    let ends = |text: &str| {
        let ends = text.split_once(':').and_then(|(low, high)| {
            let (low, high): (f64, f64) = (low.trim().parse().ok()?, high.trim().parse().ok()?);
            (low.is_finite() && high.is_finite() && low < high).then_some((low, high))
        });
        ends.ok_or_else(|| format!("{text:?} is not two rising numbers like -32768:32767"))
    };
    if !text.contains(',') {
        return ends(text).map(GaugeRange::All);
    }
    let own = |text: &str| match text.trim() {
        "" => Ok(None),
        text => ends(text).map(Some),
    };
    let all: Result<_, String> = text.split(',').map(own).collect();
    all.map(GaugeRange::Each)
}

/// The rated loads that arguments and files name; what comes first wins.
#[derive(Debug, Default)]
struct Rated {
    /// In the order of the recordings' axes.
    full_scale: Vec<f64>,
    by_axis: Vec<SensorFile>,
}

impl Rated {
    /// Those of `--full-scale`.
    fn of(full_scale: &[f64]) -> Self {
        Self { full_scale: full_scale.to_vec(), ..Self::default() }
    }

    /// They, then those of a sensor's file.
    fn and(mut self, sensor: &SensorFile) -> Self {
        self.by_axis.push(sensor.clone());
        self
    }

    /// They, then those that a calibration knows.
    fn and_of(self, calibration: Option<&Calibration>) -> Self {
        let Some(own) = calibration else { return self };
        let all = own.axes.iter().zip(&own.full_scale).zip(&own.rated);
        let rated_loads =
            all.filter(|(_, is_rated)| **is_rated).map(|((axis, scale), _)| (*axis, *scale));
        self.and(&SensorFile { rated_loads: rated_loads.collect(), ..SensorFile::default() })
    }

    /// One for each of these axes; what is no load, or one too many, is told elsewhere.
    fn on(&self, axes: &[Axis]) -> Vec<Option<f64>> {
        let is_of_them = self.full_scale.len() <= axes.len();
        let own = self.full_scale.iter().filter(|_| is_of_them);
        let mut rated: Vec<Option<f64>> =
            own.map(|load| Some(*load).filter(|load| *load > 0.0)).collect();
        for sensor in &self.by_axis {
            sensor.rate(axes, &mut rated);
        }
        rated
    }
}

impl ReadArgs {
    /// Nothing in the place of what cannot be done with a file, where that is wanted.
    fn or_left_out<T: Default>(&self, done: Result<T, JobError>) -> Result<T, JobError> {
        match done {
            Err(error) if self.keep_going => {
                tell(&format_args!("left out: {error}"));
                LEFT_OUT.fetch_add(1, Ordering::Relaxed);
                Ok(T::default())
            }
            done => done,
        }
    }

    /// Recordings of a file as they are wanted, in parts where what is left out is long; what was done, or looks wrong, goes to
    /// standard error.
    fn prepared(
        &self,
        recordings: Vec<Recording>,
        rated: &Rated,
    ) -> Result<Vec<Recording>, JobError> {
        let first = recordings.first();
        let n_gauges = first.map_or(0, Recording::n_gauges);
        if let Some(GaugeRange::Each(ranges)) = &self.gauge_range
            && ranges.len() != n_gauges
        {
            return Err(JobError::GaugeRanges { given: ranges.len(), n_gauges });
        }
        let range = ValidRange {
            gauges: self.gauge_range.clone(),
            rated: rated.on(first.map_or(&[], |own| own.axes())),
        };
        let all: Vec<&Recording> = recordings.iter().collect();
        let found = faults_of(&all, &range);
        let table = all.first().filter(|_| all.iter().all(|own| own.is_static()));
        let table = table.map(|_| Recording::table_of(&all));
        let of_table = table.as_ref().map(|table| (table, faults(table, &range)));
        let noted: Vec<(&Recording, &Faults)> = match &of_table {
            Some((table, found)) => vec![(table, found)],
            None => all.iter().copied().zip(&found).collect(),
        };
        let faulty = || {
            let noted = noted.iter();
            noted.filter(|(_, found)| found.n_samples() > 0)
        };
        for (recording, found) in faulty().take(LISTED_FAULTY) {
            let (name, words) = (recording.name(), found.in_words(recording).join(", "));
            let (n, of) = (found.n_samples(), recording.n_samples());
            let what = match self.leave_out_faulty {
                false => format!("looks faulty: {words}; --leave-out-faulty leaves them out"),
                true => format!("{n} of {of} samples left out: {words}"),
            };
            tell(&format_args!("note: {name}: {what}"));
        }
        if let Some(more) = and_more(faulty().count(), LISTED_FAULTY) {
            tell(&format_args!("note: {more} recordings of this file"));
        }
        let name = || recordings.first().map_or("", Recording::name).to_owned();
        let n = recordings.len();
        let parts = match self.leave_out_faulty {
            false => recordings,
            true => {
                let parts = recordings.iter().zip(&found);
                let parts = parts.flat_map(|(own, found)| found.left_out_of(own, &range));
                let parts: Vec<Recording> = parts.collect();
                match parts.len() {
                    0 => return Err(JobError::AllFaulty { name: name() }),
                    more if more > n => tell(&format_args!(
                        "note: {}: {more} parts remain, and history does not cross from one to the next",
                        name()
                    )),
                    _ => {}
                }
                parts
            }
        };
        parts.into_iter().map(|part| self.tared(part)).collect()
    }

    fn tared(&self, recording: Recording) -> Result<Recording, JobError> {
        let Some(tare) = self.tare else {
            return Ok(recording);
        };
        let (tared, (from, to)) = recording.tared(tare)?;
        if tare == Tare::Auto {
            let name = tared.name();
            tell(&format_args!("note: {name}: tared over {from:.3} s to {to:.3} s"));
        }
        Ok(tared)
    }
}

/// Arguments of `apply`.
#[derive(Debug, Args)]
pub struct Apply {
    #[command(flatten)]
    read: ReadArgs,
    /// A calibration: .json, or an ATI-style .cal, whose gauges are taken in the order of the recording.
    #[arg(value_parser = named_file())]
    calibration: PathBuf,
    /// Recordings with the gauges that it was made for; or - for rows on standard input, CSV with a header or JSON lines, each
    /// answered as it comes on standard output.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Where `<name>_loads.csv` goes; made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Say in a last column what became of each sample: ok, filling (the history is shorter than it can be), after a gap, restarted,
    /// beyond (the load is beyond what is known of the sensor), auxiliary held (such a channel was measured too long ago), rejected.
    /// Where several are true they are joined by +.
    #[arg(long, requires = "out")]
    status: bool,
    /// Answer the rows of the one file on standard output, and then those that a logger writes to it.
    #[arg(long, conflicts_with_all = ["out", "traces"])]
    follow: bool,
    #[command(flatten)]
    traces: traces::TraceArgs,
    /// Write over files that are there already.
    #[arg(long)]
    force: bool,
}

/// Why a job could not be done.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum JobError {
    #[error("{}", .0.text(Face::CommandLine))]
    Read(#[from] ReadError),
    #[error(transparent)]
    Map(#[from] MapFileError),
    #[error("{}", with_ways(.0.to_string(), .0.ways(), Face::CommandLine))]
    Tare(#[from] TareError),
    #[error("{name}: all samples look faulty; none would be left")]
    AllFaulty { name: String },
    #[error("out of limits: {}", .failed.join("; "))]
    OutOfLimits { failed: Vec<String> },
    #[error("{source}. It is in {folder}, or leave out what cannot be read by --keep-going")]
    InFolder { source: Box<JobError>, folder: ReadError },
    #[error("left out because they could not be read: {count}")]
    LeftOut { count: usize },
    #[error("{}: no file is called like this", .path.display())]
    NoMatch { path: PathBuf },
    #[error("{}: the folder holds no recordings", .path.display())]
    EmptyFolder { path: PathBuf },
    #[error(
        "every recording in the folder is called test…, so none is left to train on; name the files to train on"
    )]
    OnlyTests,
    #[error(transparent)]
    Sensor(#[from] SensorFileError),
    #[error(transparent)]
    Limits(#[from] LimitsError),
    #[error(transparent)]
    Layout(#[from] LayoutError),
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    #[error(transparent)]
    ReadCalibration(#[from] ReadCalibrationError),
    #[error(transparent)]
    Metrology(#[from] MetrologyError),
    #[error("{}: {source}", .path.display())]
    Apply { path: PathBuf, source: CalibrationError },
    #[error(transparent)]
    Target(#[from] TargetError),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("cannot make the directory {}: {source}", .path.display())]
    Directory { path: PathBuf, source: io::Error },
    #[error("cannot write the manual pages to {}: {source}", .path.display())]
    Manual { path: PathBuf, source: io::Error },
    #[error("cannot write to standard output: {0}")]
    Output(#[from] io::Error),
    #[error("the split is {0}; it must lie between 0 and 1, and leave both sides a sample")]
    Split(f64),
    #[error("the time is {0} minutes; it must be a number from zero up")]
    Minutes(f64),
    #[error("{}: the ending says no format; use one of {}", .path.display(), target_endings())]
    Ending { path: PathBuf },
    #[error("{}: a report is written as HTML; name a file that ends in .html", .path.display())]
    ReportEnding { path: PathBuf },
    #[error("{}: the ending says no format of traces; use {}", .path.display(), FileFormat::listed(TRACE_FORMATS))]
    TracesEnding { path: PathBuf },
    #[error(
        "traces from {from_secs} s to {to_secs} s hold nothing; the first must not be above the second"
    )]
    TraceRange { from_secs: f64, to_secs: f64 },
    #[error(
        "no sample lies between {from_secs} s and {to_secs} s on the clock of its recording; choose other times"
    )]
    NoTraces { from_secs: f64, to_secs: f64 },
    #[error("{}; --force exports it all the same", undetermined.finding().text(Face::CommandLine))]
    Undetermined { undetermined: Undetermined },
    #[error("{}: no reference load, so there is nothing to fit or to score; name its columns Fx, Fy and so on", .path.display())]
    NoReference { path: PathBuf },
    #[error("{} is no recording but a calibration or a session; apply a calibration with `apply`, and open a session in the window", .path.display())]
    NotRecording { path: PathBuf },
    #[error("{count} of {of} files would not be loaded")]
    NotLoaded { count: usize, of: usize },
    #[error("--full-scale has {given} where there are {}; write one for each", .axes.join(" "))]
    FullScales { given: usize, axes: Vec<&'static str> },
    #[error(
        "{recording}: what {pattern:?} stands for is not in its name, nor in that of its folder"
    )]
    NoGroup { recording: String, pattern: String },
    #[error(
        "--gauge-range has {given} ranges where there are {n_gauges} gauges; write one for all, or one for each"
    )]
    GaugeRanges { given: usize, n_gauges: usize },
    #[error("the recordings have no {axis}; their axes are {}", .axes.join(" "))]
    NoSuchAxis { axis: &'static str, axes: Vec<&'static str> },
    #[error("{} and {} are the same recording; name each once, and under --test what the fit has not seen", .first.display(), .second.display())]
    NamedTwice { first: PathBuf, second: PathBuf },
    #[error("{} is no calibration; the calibration comes first, then the recordings: apply {} {}", .recording.display(), .calibration.display(), .recording.display())]
    Swapped { recording: PathBuf, calibration: PathBuf },
    #[error("interrupted: more models were to be tried")]
    Interrupted,
    #[error("the recordings do not carry the model")]
    Insufficient,
    #[error("say where the loads go: --out DIR, or --traces FILE")]
    NoOutput,
    #[error(
        "standard input and a file that is followed are answered alone, on standard output: name nothing else"
    )]
    NotAlone,
    #[error(
        "rows that come one by one are tared over an interval: --tare FROM:TO, in seconds from the first of them"
    )]
    TareLive,
    #[error("{option} is for one file; name the one that it is for")]
    OneFile { option: &'static str },
    #[error("{}: {source}", .path.display())]
    Follow { path: PathBuf, source: io::Error },
    #[error("the rows have the gauges {} where the calibration was made for {}", .actual.join(" "), .expected.join(" "))]
    LiveGauges { expected: Vec<String>, actual: Vec<String> },
    #[error("the rows have no auxiliary channel {channel}, which the calibration needs")]
    LiveAuxiliary { channel: String },
    #[error("{} and {} would both be written to {}; apply them one by one", .first.display(), .second.display(), .output.display())]
    SameOutput { first: PathBuf, second: PathBuf, output: PathBuf },
}

impl JobError {
    /// Whether the arguments themselves were wrong, whatever is in the files.
    fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::NamedTwice { .. }
                | Self::NoOutput
                | Self::ReportEnding { .. }
                | Self::NotAlone
                | Self::OneFile { .. }
                | Self::TareLive
                | Self::NoGroup { .. }
                | Self::GaugeRanges { .. }
                | Self::FullScales { .. }
                | Self::NotRecording { .. }
                | Self::EmptyFolder { .. }
                | Self::NoMatch { .. }
                | Self::OnlyTests
                | Self::InFolder { .. }
                | Self::Swapped { .. }
                | Self::Read(ReadError::File { source: FileError::Folder { .. }, .. })
        )
    }
}

/// What scripts know wrong arguments by; clap has the same.
const USAGE: u8 = 2;
/// Exit code for recordings that do not carry their model, and for calibrations that exceed their limits.
const INSUFFICIENT: u8 = 3;

impl Job {
    /// Returns the recordings that the job was given, if it reads any.
    fn recordings(&mut self) -> Option<Named<'_>> {
        fn of(own: &mut choices::RecordingArgs) -> Named<'_> {
            Named {
                files: &mut own.train,
                test: Some(&mut own.test),
                is_split: own.split.is_some(),
            }
        }
        let all = |files| Named { files, test: None, is_split: false };
        Some(match self {
            Self::Fit(args) => of(&mut args.recordings),
            Self::Report(args) => of(&mut args.recordings),
            Self::Best(args) => of(&mut args.recordings),
            Self::Compare(args) => of(&mut args.recordings),
            Self::Sweep(args) => of(&mut args.recordings),
            Self::Check(args) => of(args.moved()),
            Self::Metrology(args) => match args.calibration {
                Some(_) => all(&mut args.files),
                None => Named { test: Some(&mut args.test), ..all(&mut args.files) },
            },
            Self::Apply(args) => all(&mut args.files),
            Self::Inspect(args) => all(&mut args.files),
            Self::Demo(_) | Self::Sensor | Self::Completions(_) | Self::Man(_) => {
                return None;
            }
        })
    }

    /// Puts the recordings of folders in their places, and returns the folders with notes on them.
    ///
    /// In a folder the files called `test…` are not for training. They are the test recordings unless others are named.
    fn open_folders(&mut self) -> Result<(Vec<PathBuf>, Vec<String>), JobError> {
        let (mut folders, mut notes) = (Vec::new(), Vec::new());
        let Some(named) = self.recordings() else {
            return Ok((folders, notes));
        };
        let mut tests = Vec::new();
        let name = |path: &PathBuf| -> String {
            path.file_name().unwrap_or_default().to_string_lossy().into()
        };
        if let Some(test) = named.test {
            *test = opened(test, &mut folders, |_, inside| inside)?;
            let names_test = !test.is_empty();
            let role = match names_test {
                true => "not used, since the test recordings are named",
                false => "the test recordings",
            };
            let train = opened(named.files, &mut folders, |folder, inside| {
                let is_test =
                    |path: &PathBuf| !named.is_split && Role::of_name(&name(path)) == Role::Test;
                let (own, train): (Vec<_>, Vec<_>) = inside.into_iter().partition(is_test);
                if !own.is_empty() {
                    let (folder, own) = (folder.display(), own.iter().map(name));
                    let own = listed(&own.collect::<Vec<_>>());
                    notes.push(format!("{folder}: files called test… are {role}: {own}"));
                }
                tests.extend(own);
                train
            })?;
            if train.is_empty() && !tests.is_empty() {
                return Err(JobError::OnlyTests);
            }
            *named.files = train;
            if !names_test {
                *test = tests;
            }
        } else {
            *named.files = opened(named.files, &mut folders, |_, inside| inside)?;
        }
        Ok((folders, notes))
    }
}

/// The recordings that a job was given.
struct Named<'a> {
    /// Those that it reads, or trains on.
    files: &'a mut Vec<PathBuf>,
    /// Those that it only tests on, if it trains.
    test: Option<&'a mut Vec<PathBuf>>,
    /// Whether each recording is trained on in part.
    is_split: bool,
}

/// Returns the files with patterns expanded, and in the place of each folder the recordings in it, or those that `taken` takes of
/// them.
fn opened(
    paths: &[PathBuf],
    folders: &mut Vec<PathBuf>,
    mut taken: impl FnMut(&Path, Vec<PathBuf>) -> Vec<PathBuf>,
) -> Result<Vec<PathBuf>, JobError> {
    let mut opened = Vec::with_capacity(paths.len());
    for path in expanded(paths) {
        if import::is_pattern(&path) && !path.exists() {
            return Err(JobError::NoMatch { path });
        }
        if !path.is_dir() {
            opened.push(path);
            continue;
        }
        let inside = match import::recordings_in(&path) {
            Ok(inside) if inside.is_empty() => return Err(JobError::EmptyFolder { path }),
            Ok(inside) => inside,
            Err(source) => return Err(JobError::Directory { path, source }),
        };
        opened.extend(taken(&path, inside));
        folders.push(path);
    }
    Ok(opened)
}

/// Of what cannot be read in a folder, that it is one of all of them.
fn in_folder(error: JobError, folders: &[PathBuf]) -> JobError {
    let text = error.to_string();
    let folder = folders.iter().find(|folder| text.contains(&*folder.to_string_lossy()));
    let refused = |folder| import::read(folder, None, &[], &Progress::default()).err();
    match (&error, folder.and_then(|folder| refused(folder))) {
        (JobError::Read(_) | JobError::NoReference { .. }, Some(folder)) => {
            JobError::InFolder { source: Box::new(error), folder }
        }
        _ => error,
    }
}

/// How many files were left out because they could not be read.
static LEFT_OUT: AtomicUsize = AtomicUsize::new(0);

/// Does a job; errors go to standard error, one line each.
pub fn run(mut job: Job) -> ExitCode {
    let done = job.open_folders().and_then(|(folders, notes)| {
        let done = done(job).map_err(|error| in_folder(error, &folders));
        if !matches!(done, Err(JobError::InFolder { .. })) {
            print_notes(&notes);
        }
        done?;
        match LEFT_OUT.load(Ordering::Relaxed) {
            0 => Ok(()),
            count => Err(JobError::LeftOut { count }),
        }
    });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever reads our output had enough (`| head`): no error of ours.
        Err(JobError::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            ExitCode::SUCCESS
        }
        Err(error) => {
            tell(&error);
            match error {
                JobError::Insufficient | JobError::OutOfLimits { .. } => {
                    ExitCode::from(INSUFFICIENT)
                }
                JobError::Interrupted => ExitCode::from(interrupted_code()),
                error if error.is_usage() => ExitCode::from(USAGE),
                _ => ExitCode::FAILURE,
            }
        }
    }
}

fn done(job: Job) -> Result<(), JobError> {
    match job {
        Job::Inspect(inspect) => inspect::run(&inspect),
        Job::Demo(demo) => write_demo(&demo),
        Job::Fit(args) => fit::run(&args),
        Job::Check(args) => check::run(*args),
        Job::Sensor => print_sensor(),
        Job::Report(args) => report::run(&args),
        Job::Best(args) => best::run(&args),
        Job::Compare(args) => compare::run(&args),
        Job::Sweep(args) => sweep::run(&args),
        Job::Apply(apply) => run_apply(&apply),
        Job::Metrology(args) => metrology::run(&args),
        Job::Completions(args) => installed::completions(&args),
        Job::Man(args) => installed::manual(&args),
    }
}

/// Prints every item of a description with what to enter.
fn print_sensor() -> Result<(), JobError> {
    let mut out = io::stdout().lock();
    for item in Item::all() {
        let (key, label, hint) = (item.key(), item.label(), item.hint());
        writeln!(out, "{key} = \"\"  # {label}: {hint}")?;
    }
    writeln!(
        out,
        "\n# In N and N·m; an axis that is not named has what the recordings reach\n[rated_loads]\n# Fx = 100"
    )?;
    Ok(())
}

/// Writes one line to standard error, made harmless; where nobody can hear it, the exit code still says how it went.
pub fn tell(message: &dyn Display) {
    let message = shown::message(message);
    let _ = writeln!(io::stderr(), "loopscope: {message}");
}

/// Fails where a figure exceeds its limit or is not known.
fn keep_limits(limits: &[Checked]) -> Result<(), JobError> {
    let failed = limits.iter().filter(|own| !own.pass);
    let failed: Vec<String> = failed.map(Checked::in_words).collect();
    match failed.is_empty() {
        true => Ok(()),
        false => Err(JobError::OutOfLimits { failed }),
    }
}

/// Says which file was written.
fn print_path(path: &Path) -> io::Result<()> {
    writeln!(io::stdout(), "{}", printable(&path.to_string_lossy()))
}

fn make_directory(path: &Path) -> Result<(), JobError> {
    std::fs::create_dir_all(path)
        .map_err(|source| JobError::Directory { path: path.to_owned(), source })
}

const DEMO_README: &str = "\
These recordings are simulated: the program's built-in sensor made them, no real one.
train_*.csv are for fitting, test_*.csv for scoring. Times in s, gauges in mV/V, forces in N, moments in N·m.
";

fn write_demo(demo: &Demo) -> Result<(), JobError> {
    make_directory(&demo.dir)?;
    let set = simulated::recordings(demo.seed);
    let step = match demo.pattern {
        Pattern::A => 1,
        Pattern::B => 10,
    };
    let names = (set.entries().iter()).map(|entry| format!("{}.csv", entry.recording.name()));
    let files: Vec<PathBuf> =
        names.chain(["README.txt".to_owned()]).map(|name| demo.dir.join(name)).collect();
    check_targets([], &files, demo.force)?;
    let mut written = Together::default();
    for (entry, path) in set.entries().iter().zip(&files) {
        let recording = entry.recording.decimated(step);
        written.write(path, |mut out| write_csv(&recording, &mut out))?;
    }
    written.write(&files[set.entries().len()], |out| out.write_all(DEMO_README.as_bytes()))?;
    written.finish()?;
    writeln!(
        io::stdout(),
        "{} simulated recordings in {}",
        set.entries().len(),
        printable(&demo.dir.to_string_lossy())
    )?;
    Ok(())
}

/// A file's name; nothing is read from standard input or written to standard output in place of one.
fn named_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path.as_os_str() == "-" {
        true => Err("standard input and output do not do here; name a file"),
        false => Ok(path),
    })
}

/// A recording that counts twice, or that a fit is scored on although it has seen it, makes the figures wrong.
fn check_distinct<'a>(files: impl Iterator<Item = &'a PathBuf>) -> Result<(), JobError> {
    let mut seen: HashMap<PathBuf, &PathBuf> = HashMap::new();
    for path in files {
        // What is not there is reported where it is read.
        let Ok(whole) = path.canonicalize() else {
            continue;
        };
        if let Some(first) = seen.insert(whole, path) {
            return Err(JobError::NamedTwice { first: first.clone(), second: path.clone() });
        }
    }
    Ok(())
}

/// Reads files one after another, warnings to standard error.
fn read_all(
    files: &[PathBuf],
    args: &ReadArgs,
    rated: &Rated,
) -> Result<Vec<Vec<Recording>>, JobError> {
    read_hearing(files, args, rated, &mut |_| {})
}

/// [`read_all`], with an ear for the warnings.
fn read_hearing(
    files: &[PathBuf],
    args: &ReadArgs,
    rated: &Rated,
    hear: &mut dyn FnMut(&LoadWarning),
) -> Result<Vec<Vec<Recording>>, JobError> {
    let map = args.columns.as_deref().map(ColumnMap::read).transpose()?;
    let progress = Progress::default();
    files
        .iter()
        .map(|path| {
            let mut read = || {
                let loaded = import::read(path, map.as_ref(), &[], &progress);
                let loaded = loaded.map_err(|error| unread(path, error))?;
                print_warnings(&loaded.warnings);
                loaded.warnings.iter().for_each(&mut *hear);
                args.prepared(loaded.recordings, rated)
            };
            args.or_left_out(read())
        })
        .collect()
}

/// Why a file could not be read; a calibration is no damaged recording.
fn unread(path: &Path, error: impl Into<JobError>) -> JobError {
    let path = path.to_owned();
    match Session::is_at(&path) || read_with_notes(&path).is_ok() {
        true => JobError::NotRecording { path },
        false => error.into(),
    }
}

fn print_warnings(warnings: &[LoadWarning]) {
    for warning in warnings {
        tell(&format_args!("warning: {}", warning.text(Face::CommandLine)));
    }
}

fn print_notes(notes: &[String]) {
    for note in notes {
        tell(&format_args!("note: {note}"));
    }
}

fn run_apply(args: &Apply) -> Result<(), JobError> {
    let (mut calibration, notes) =
        read_with_notes(&args.calibration).map_err(|error| swapped(args, error))?;
    print_notes(&notes);
    let names_gauges = names_gauges(&args.calibration);
    let is_live = args.follow || args.files.iter().any(|path| path.as_os_str() == "-");
    if is_live {
        return run_live(args, calibration, names_gauges);
    }
    if args.out.is_none() && args.traces.traces.is_none() {
        return Err(JobError::NoOutput);
    }
    args.traces.check()?;
    let outputs = load_files(args)?;
    let inputs = args.files.iter().chain([&args.calibration]);
    let inputs = inputs.chain(&args.read.columns);
    let written: Vec<PathBuf> = outputs.iter().chain(&args.traces.traces).cloned().collect();
    if let Some(out) = &args.out {
        make_directory(out)?;
    }
    check_targets(inputs, &written, args.force)?;
    let mut all = Vec::new();
    let rated = Rated::default().and_of(Some(&calibration));
    for (at, path) in args.files.iter().enumerate() {
        for recordings in read_all(std::slice::from_ref(path), &args.read, &rated)? {
            if let Some(recording) = recordings.first()
                && !names_gauges
            {
                name_gauges(&mut calibration, recording.gauge_names());
            }
            if let (Some(tare), Some(None)) =
                (calibration.tare, recordings.first().map(Recording::tare))
            {
                tell(&format_args!(
                    "note: {}: not tared, and the calibration was made of gauges less their mean over {tare}; add --tare",
                    path.display()
                ));
            }
            if !names_gauges && let Some(None) = recordings.first().map(Recording::tare) {
                tell(&format_args!(
                    "note: {}: not tared, and a calibration in .cal has no offset; add --tare",
                    path.display()
                ));
            }
            for beyond in recordings.iter().flat_map(|own| calibration.auxiliary_beyond(own)) {
                tell(&format_args!("warning: {beyond}"));
            }
            if let Some(output) = outputs.get(at) {
                if recordings.is_empty() && args.read.keep_going {
                    continue;
                }
                let applied =
                    write_atomically_applied(&calibration, path, &recordings, args.status, output);
                args.read.or_left_out(applied.and_then(|()| Ok(print_path(output)?)))?;
            }
            if args.traces.traces.is_some() {
                all.extend(recordings);
            }
        }
    }
    args.traces.check_intervals(all.iter(), 1)?;
    let mut traces = Together::default();
    args.traces.write(&mut traces, &calibration, all.iter(), 1)?;
    traces.finish()?;
    if let Some(path) = &args.traces.traces {
        print_path(path)?;
    }
    Ok(())
}

/// Answers samples as they come.
fn run_live(args: &Apply, calibration: Calibration, names_gauges: bool) -> Result<(), JobError> {
    let [path] = &args.files[..] else {
        return Err(JobError::NotAlone);
    };
    if args.out.is_some() || args.traces.traces.is_some() {
        return Err(JobError::NotAlone);
    }
    if args.read.tare == Some(Tare::Auto) {
        return Err(JobError::TareLive);
    }
    if let Some(tare) = calibration.tare.filter(|_| args.read.tare.is_none()) {
        tell(&format_args!(
            "note: the calibration was made of gauges less their mean over {tare}; those that come must be tared, too"
        ));
    }
    let map = args.read.columns.as_deref().map(ColumnMap::read);
    let tap = live::Tap { calibration, names_gauges, map: map.transpose()?, tare: args.read.tare };
    match path.as_os_str() == "-" {
        true => live::standard_input(tap),
        false => live::follow(tap, path),
    }
}

/// Why there is no calibration: perhaps it stands where the recordings should.
fn swapped(args: &Apply, error: ReadCalibrationError) -> JobError {
    let may_be_one =
        |path: &&PathBuf| target_for(path).is_some_and(|target| target.reader.is_some());
    match args.files.iter().find(may_be_one) {
        Some(calibration) if !may_be_one(&&args.calibration) => JobError::Swapped {
            recording: args.calibration.clone(),
            calibration: calibration.clone(),
        },
        _ => error.into(),
    }
}

/// Where the loads of each file go; none without a folder for them.
fn load_files(args: &Apply) -> Result<Vec<PathBuf>, JobError> {
    let Some(out) = &args.out else {
        return Ok(Vec::new());
    };
    let outputs: Vec<PathBuf> = (args.files.iter())
        .map(|path| {
            let mut name = path.file_stem().unwrap_or_default().to_owned();
            name.push("_loads.csv");
            out.join(name)
        })
        .collect();
    for (at, output) in outputs.iter().enumerate() {
        if let Some(earlier) = outputs[..at].iter().position(|other| other == output) {
            return Err(JobError::SameOutput {
                first: args.files[earlier].clone(),
                second: args.files[at].clone(),
                output: output.clone(),
            });
        }
    }
    Ok(outputs)
}

fn write_atomically_applied(
    calibration: &Calibration,
    path: &Path,
    recordings: &[Recording],
    with_status: bool,
    output: &Path,
) -> Result<(), JobError> {
    let check = |recording| calibration.prepared(recording).map(|_| ());
    let checked: Result<(), CalibrationError> = recordings.iter().try_for_each(check);
    checked.map_err(|source| JobError::Apply { path: path.to_owned(), source })?;
    write_atomically(output, |out| write_loads_csv(calibration, recordings, with_status, out))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn files_alone_mean_the_window() {
        let cli = Cli::parse_from(["loopscope", "a.csv", "b.csv"]);
        assert!(cli.job.is_none());
        assert_eq!(cli.files.len(), 2);
    }

    #[test]
    fn a_split_and_test_files_exclude_each_other() {
        let both = ["loopscope", "fit", "--split", "0.5", "--test", "a.csv"];
        assert!(Cli::try_parse_from(both).is_err());
    }
}
