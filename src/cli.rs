//! The command line: the window, or one job for scripts and machines without a display.

mod inspect;

use std::fmt::Display;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use clap::{Args, Parser, Subcommand, ValueEnum};
use serde::Serialize;

pub use inspect::Inspect;

use crate::analysis::{Analysis, AnalysisError, Request, View, analyse};
use crate::calibration::{Calibration, CalibrationError, FitSettings, Scores};
use crate::evaluation::metrics::percent_change;
use crate::export::{
    CalibrationFormat, ReadCalibrationError, WriteError, look_back_text, read_calibration,
    write_atomically, write_calibration, write_loads_csv,
};
use crate::features::{Distance, Thresholds};
use crate::progress::Progress;
use crate::recording::columns::{ColumnMap, MapFileError};
use crate::recording::delimited::{self, LoadWarning, ReadError};
use crate::recording::write_csv::write_csv;
use crate::recording::{Entry, LayoutError, Recording, RecordingSet, Role, simulated};

/// Calibrate force/torque sensors and see what their past does to them.
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
pub struct Cli {
    /// The job; without one the window opens.
    #[command(subcommand)]
    pub job: Option<Job>,
    /// Recordings (delimited text) or a calibration (JSON) to open in the window.
    pub files: Vec<PathBuf>,
}

/// What can be done without a window.
#[derive(Debug, Subcommand)]
pub enum Job {
    /// Say what a file holds, what would be loaded and what is wrong; write a column map for it.
    Inspect(Inspect),
    /// Write the built-in simulated sensor's recordings as CSV: `train_*.csv` and `test_*.csv`.
    Demo(Demo),
    /// Fit the conventional and the look-back calibration, and score both.
    Fit(Box<FitArgs>),
    /// Apply a calibration: Conv. and Comp. of each sample as CSV.
    Apply(Apply),
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
}

/// Arguments of `fit`.
#[derive(Debug, Args)]
pub struct FitArgs {
    #[command(flatten)]
    read: ReadArgs,
    /// Recordings to fit; without any, those of the built-in simulated sensor.
    #[arg(long, num_args = 1.., value_name = "FILE")]
    train: Vec<PathBuf>,
    /// Recordings to score the fit on.
    #[arg(long, num_args = 1.., value_name = "FILE")]
    test: Vec<PathBuf>,
    /// Instead of test files: train on this first part of each recording, test on the rest.
    #[arg(
        long,
        value_name = "FRACTION",
        conflicts_with = "test",
        allow_negative_numbers = true
    )]
    split: Option<f64>,
    /// How much the load must have differed: newtons, or over full scale a share of it (0.1 is 10 %) [default: 3, or
    /// 0.25 of full scale].
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    f_th: Option<f64>,
    /// How old the past sample may be, in seconds.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 15.0,
        allow_negative_numbers = true
    )]
    t_th: f64,
    /// What F_th is measured in; without a force axis it is full-scale.
    #[arg(long, value_enum, default_value = "force")]
    distance: DistanceArg,
    /// Full scale of each axis in N and N·m, in axis order; by default half the peak-to-peak training reference.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "FS,…",
        allow_negative_numbers = true
    )]
    full_scale: Vec<f64>,
    /// Fit without a constant term, as the paper does.
    #[arg(long)]
    no_offset: bool,
    /// Use every N-th sample only.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    decimate: usize,
    /// Write the calibration: .json (complete) or .csv (the matrices); may be given several times.
    #[arg(long, value_name = "FILE")]
    export: Vec<PathBuf>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// [`Distance`] as an argument.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum DistanceArg {
    /// Norm over the force axes, in newtons.
    Force,
    /// Norm over all axes, each divided by its full scale.
    FullScale,
}

/// How files are read, for all jobs that read recordings.
#[derive(Debug, Args)]
pub struct ReadArgs {
    /// What the columns of the files are, where their names do not say it; `inspect --write-map` writes one.
    #[arg(long, value_name = "MAP.json")]
    columns: Option<PathBuf>,
}

/// Arguments of `apply`.
#[derive(Debug, Args)]
pub struct Apply {
    #[command(flatten)]
    read: ReadArgs,
    /// A calibration in JSON.
    calibration: PathBuf,
    /// Recordings with the gauges that it was made for.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Where `<name>_loads.csv` goes; made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Why a job could not be done.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum JobError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Map(#[from] MapFileError),
    #[error(transparent)]
    Layout(#[from] LayoutError),
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    #[error(transparent)]
    ReadCalibration(#[from] ReadCalibrationError),
    #[error("{}: {source}", .path.display())]
    Apply {
        path: PathBuf,
        source: CalibrationError,
    },
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("cannot make the directory {}: {source}", .path.display())]
    Directory { path: PathBuf, source: io::Error },
    #[error("cannot write to standard output: {0}")]
    Output(#[from] io::Error),
    #[error("the split is {0}; it must lie between 0 and 1, and leave both sides a sample")]
    Split(f64),
    #[error("{}: the ending says no format; use .json or .csv", .path.display())]
    Ending { path: PathBuf },
    #[error("{}: no reference load, so there is nothing to fit or to score; name its columns Fx, Fy and so on", .path.display())]
    NoReference { path: PathBuf },
    #[error("{} would be written over {}, which is read; choose another name", .output.display(), .input.display())]
    OverInput { input: PathBuf, output: PathBuf },
    #[error("{} and {} would both be written to {}; apply them one by one", .first.display(), .second.display(), .output.display())]
    SameOutput {
        first: PathBuf,
        second: PathBuf,
        output: PathBuf,
    },
}

/// Does a job; errors go to standard error, one line each.
#[must_use]
pub fn run(job: Job) -> ExitCode {
    let done = match job {
        Job::Inspect(inspect) => inspect::run(&inspect),
        Job::Demo(demo) => write_demo(&demo),
        Job::Fit(fit) => run_fit(&fit),
        Job::Apply(apply) => run_apply(&apply),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever reads our output had enough (`| head`): no error of ours.
        Err(JobError::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            ExitCode::SUCCESS
        }
        Err(error) => {
            tell(&error);
            ExitCode::FAILURE
        }
    }
}

/// Writes one line to standard error; where nobody can hear it, the exit code still says how it went.
pub fn tell(message: &dyn Display) {
    let _ = writeln!(io::stderr(), "loopscope: {message}");
}

fn make_directory(path: &Path) -> Result<(), JobError> {
    std::fs::create_dir_all(path).map_err(|source| JobError::Directory {
        path: path.to_owned(),
        source,
    })
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
    write_atomically(&demo.dir.join("README.txt"), |out| {
        out.write_all(DEMO_README.as_bytes())
    })?;
    for entry in set.entries() {
        let recording = entry.recording.decimated(step);
        let path = demo.dir.join(format!("{}.csv", recording.name()));
        write_atomically(&path, |mut out| write_csv(&recording, &mut out))?;
    }
    writeln!(
        io::stdout(),
        "{} simulated recordings in {}",
        set.entries().len(),
        demo.dir.display()
    )?;
    Ok(())
}

/// Reads files one after another, warnings to standard error.
fn read_all(files: &[PathBuf], args: &ReadArgs) -> Result<Vec<Vec<Recording>>, JobError> {
    let map = args.columns.as_deref().map(ColumnMap::read).transpose()?;
    let progress = Progress::default();
    files
        .iter()
        .map(|path| {
            let loaded = match &map {
                Some(map) => delimited::read_mapped(path, map, &progress)?,
                None => delimited::read(path, &progress)?,
            };
            print_warnings(&loaded.warnings);
            Ok(loaded.recordings)
        })
        .collect()
}

fn print_warnings(warnings: &[LoadWarning]) {
    for warning in warnings {
        tell(&format_args!("warning: {warning}"));
    }
}

/// The recordings that `fit` works on, with their roles.
fn recordings_to_fit(args: &FitArgs) -> Result<RecordingSet, JobError> {
    let mut set = RecordingSet::default();
    if args.train.is_empty() {
        let built_in = simulated::recordings(simulated::DEFAULT_SEED);
        for entry in built_in.entries() {
            if entry.role == Role::Train || args.test.is_empty() {
                set.push(entry.clone())?;
            }
        }
    }
    for (files, role) in [(&args.train, Role::Train), (&args.test, Role::Test)] {
        for (path, recordings) in files.iter().zip(read_all(files, &args.read)?) {
            for recording in recordings {
                if !recording.has_reference() {
                    return Err(JobError::NoReference { path: path.clone() });
                }
                set.push(Entry::new(recording, role))?;
            }
        }
    }
    match args.split {
        None => Ok(set),
        Some(fraction) => {
            let split = set.split(fraction);
            let tests = split.entries().iter().any(|entry| entry.role == Role::Test);
            if fraction > 0.0 && fraction < 1.0 && tests {
                Ok(split)
            } else {
                Err(JobError::Split(fraction))
            }
        }
    }
}

/// Nobody means to lose a recording: what is read is not written over.
fn check_not_over<'a>(
    inputs: impl Iterator<Item = &'a PathBuf> + Clone,
    outputs: &[PathBuf],
) -> Result<(), JobError> {
    for output in outputs {
        // A file that is not there yet has no such path, and is no input.
        let Ok(existing) = output.canonicalize() else {
            continue;
        };
        let mut inputs = inputs.clone();
        if let Some(input) = inputs.find(|path| path.canonicalize().is_ok_and(|p| p == existing)) {
            return Err(JobError::OverInput {
                input: input.clone(),
                output: output.clone(),
            });
        }
    }
    Ok(())
}

fn run_fit(args: &FitArgs) -> Result<(), JobError> {
    // Before any work: a wrong ending must not cost the time of a fit.
    for path in &args.export {
        if CalibrationFormat::from_path(path).is_none() {
            return Err(JobError::Ending { path: path.clone() });
        }
    }
    check_not_over(args.train.iter().chain(&args.test), &args.export)?;
    let recordings = recordings_to_fit(args)?;
    let distance = match args.distance {
        DistanceArg::Force => Distance::Force,
        DistanceArg::FullScale => Distance::FullScale,
    }
    .effective(&recordings.layout().axes);
    let settings = FitSettings {
        thresholds: Thresholds {
            f_th: args.f_th.unwrap_or(Thresholds::default_for(distance).f_th),
            t_th_secs: args.t_th,
        },
        distance,
        offset: !args.no_offset,
        decimation: args.decimate,
        full_scale: args.full_scale.iter().copied().map(Some).collect(),
    };
    let request = Request {
        recordings: Arc::new(recordings),
        settings,
        view: View::One(0),
        calibration: None,
    };
    let analysis = analyse(&request, &Progress::default())?;
    for path in &args.export {
        write_calibration(&analysis.calibration, path)?;
    }
    let mut out = io::stdout().lock();
    if args.json {
        serde_json::to_writer_pretty(&mut out, &FitReport::new(&analysis))
            .map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        print_fit(&analysis, &mut out)?;
    }
    Ok(())
}

/// What `fit --json` prints.
#[derive(Debug, Serialize)]
struct FitReport<'a> {
    simulated: bool,
    recordings: usize,
    n_train: u64,
    n_test: u64,
    axes: Vec<&'static str>,
    units: &'a [String],
    full_scale: &'a [f64],
    f_th: f64,
    t_th: f64,
    distance: Distance,
    offset: bool,
    decimation: usize,
    conventional: &'a Scores,
    compensated: &'a Scores,
    rank: usize,
    condition: Option<f64>,
    features: &'a [String],
}

impl<'a> FitReport<'a> {
    fn new(analysis: &'a Analysis) -> Self {
        let calibration = &analysis.calibration;
        let quality = &calibration.quality;
        Self {
            simulated: calibration.simulated,
            recordings: analysis.recordings.len(),
            n_train: quality.n_train,
            n_test: quality.n_test,
            axes: calibration.axes.iter().map(|axis| axis.symbol()).collect(),
            units: &calibration.units,
            full_scale: &calibration.full_scale,
            f_th: calibration.thresholds.f_th,
            t_th: calibration.thresholds.t_th_secs,
            distance: calibration.distance,
            offset: calibration.offset,
            decimation: calibration.decimation,
            conventional: &quality.conventional,
            compensated: &quality.compensated,
            rank: quality.rank,
            condition: quality.condition,
            features: &calibration.compensated.features,
        }
    }
}

fn print_fit(analysis: &Analysis, out: &mut impl Write) -> io::Result<()> {
    let calibration = &analysis.calibration;
    let quality = &calibration.quality;
    if calibration.simulated {
        writeln!(out, "The built-in simulated sensor")?;
    }
    writeln!(
        out,
        "{} recordings, {} training and {} test samples, {} gauges; {}{}",
        analysis.recordings.len(),
        quality.n_train,
        quality.n_test,
        calibration.gauges.len(),
        look_back_text(calibration.thresholds, calibration.distance),
        if calibration.offset {
            ""
        } else {
            "; no offset"
        },
    )?;
    let condition = quality
        .condition
        .map_or_else(|| "none".to_owned(), |condition| format!("{condition:.4}"));
    writeln!(
        out,
        "rank {} of {} features, condition number {condition}",
        quality.rank,
        calibration.compensated.features.len(),
    )?;
    let tables = [
        ("train", scores_of(quality, |scores| &scores.train_rmse)),
        ("test", scores_of(quality, |scores| &scores.test_rmse)),
        (
            "leave-one-out",
            scores_of(quality, |scores| &scores.cv_rmse),
        ),
    ];
    for (name, scores) in tables {
        let Some((conventional, compensated)) = scores else {
            continue;
        };
        writeln!(
            out,
            "\nRMSE, {name:<14}      Conv.         Comp.     change"
        )?;
        for (at, axis) in calibration.axes.iter().enumerate() {
            let (before, after) = (conventional[at], compensated[at]);
            let change = percent_change(before, after)
                .map_or_else(String::new, |percent| format!("{percent:+9.1} %"));
            let label = format!("{} [{}]", axis.symbol(), axis.unit());
            writeln!(out, "  {label:<14} {before:>14.6} {after:>13.6} {change}")?;
        }
    }
    Ok(())
}

type BothRmse<'a> = Option<(&'a [f64], &'a [f64])>;

fn scores_of(
    quality: &crate::calibration::Quality,
    pick: fn(&Scores) -> &Option<Vec<f64>>,
) -> BothRmse<'_> {
    let conventional = pick(&quality.conventional).as_deref()?;
    let compensated = pick(&quality.compensated).as_deref()?;
    Some((conventional, compensated))
}

fn run_apply(args: &Apply) -> Result<(), JobError> {
    let calibration = read_calibration(&args.calibration)?;
    let outputs: Vec<PathBuf> = args
        .files
        .iter()
        .map(|path| {
            let mut name = path.file_stem().unwrap_or_default().to_owned();
            name.push("_loads.csv");
            args.out.join(name)
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
    check_not_over(args.files.iter().chain([&args.calibration]), &outputs)?;
    make_directory(&args.out)?;
    for (path, output) in args.files.iter().zip(&outputs) {
        for recordings in read_all(std::slice::from_ref(path), &args.read)? {
            write_atomically_applied(&calibration, path, &recordings, output)?;
        }
        writeln!(io::stdout(), "{}", output.display())?;
    }
    Ok(())
}

fn write_atomically_applied(
    calibration: &Calibration,
    path: &Path,
    recordings: &[Recording],
    output: &Path,
) -> Result<(), JobError> {
    let applied = recordings
        .iter()
        .map(|recording| Ok((recording, calibration.apply(recording)?)))
        .collect::<Result<Vec<_>, CalibrationError>>()
        .map_err(|source| JobError::Apply {
            path: path.to_owned(),
            source,
        })?;
    write_atomically(output, |out| write_loads_csv(calibration, &applied, out))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

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
