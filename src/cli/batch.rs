//! `loopscope batch`: every sensor of a folder fitted, judged and exported, for a factory.
//!
//! Guarantees: one sensor that fails keeps none of the others up; a sensor's files appear together or not at all; what is there
//! already and was made of the same is not made again; the same input gives the same bytes.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Instant;

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use super::choices::{ModelArgs, RecordingArgs, SensorArgs};
use super::progress_line::ProgressLine;
use super::{JobError, ReadArgs, hearing, make_directory, named_file};
use crate::analysis::{Request, Told, report_of};
use crate::calibration::UsedRecording;
use crate::evaluation::limits::{Checked, Limits, Verdict};
use crate::evaluation::uncertainty::Uncertainty;
use crate::export::{
    Outline, Together, WriteError, add_calibration, check_targets, dcc_of, html_of, sha256_of_text,
    target_for, with_sources, write_atomically,
};
use crate::formats::csv::CsvWriter;
use crate::import::recordings_in;
use crate::panicked::caught;
use crate::progress::Progress;
use crate::recording::identity::SensorFile;
use crate::recording::{Axis, GroupPattern, Identity, Item};
use crate::shown::printable;

const PROGRAM: &str = concat!("LoopScope ", env!("CARGO_PKG_VERSION"));
/// What is made of every sensor.
const VERDICT: &str = "verdict.json";
const CERTIFICATE: &str = "certificate.html";
const DCC: &str = "certificate.xml";
/// Figures that are listed where nothing is limited.
const USUAL: [&str; 2] = ["U", "left_out_rmse"];

/// Arguments of `batch`.
#[derive(Debug, Args)]
pub struct BatchArgs {
    /// The folder with the sensors: one folder each, whose recordings are trained on; those whose names begin with "test" test.
    dir: PathBuf,
    /// Where a folder of each sensor, `summary.csv` and `batch.log` go; made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What each must keep: a TOML file like `U = 1.0` (percent of full scale), `rmse = { Fz = "0.2 N" }`, `condition = 1e4`.
    #[arg(long, value_name = "LIMITS.toml", value_parser = named_file())]
    limits: Option<PathBuf>,
    /// Whether each folder is a sensor, or each file; its name is the serial number where no `sensor.toml` in the folder (or .toml
    /// of the file's name) says another.
    #[arg(long, value_enum, default_value_t = From::Folder)]
    sensor_from: From,
    #[command(flatten)]
    sensor: SensorArgs,
    /// Export each calibration as a file with this ending, may be given several times.
    #[arg(long, value_name = "ENDING")]
    export: Vec<String>,
    /// Write a certificate of each: HTML to read and print.
    #[arg(long)]
    certificate: bool,
    /// Write the certificate for machines, too: a Digital Calibration Certificate (XML of PTB, schema 3.1.2).
    #[arg(long)]
    dcc: bool,
    /// Work on so many sensors side by side [default: as many as there are processors].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    jobs: Option<u16>,
    /// Make everything again, also what is there and was made of the same.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    read: ReadArgs,
    /// Train on this first part of each recording, test on the rest.
    #[arg(long, value_name = "FRACTION", allow_negative_numbers = true)]
    split: Option<f64>,
    /// What cross-validation leaves out together, as for `fit`.
    #[arg(long, value_name = "PATTERN")]
    group: Option<GroupPattern>,
    #[command(flatten)]
    model: ModelArgs,
}

/// What is one sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum From {
    /// Each folder.
    Folder,
    /// Each file.
    File,
}

/// One sensor of the batch.
struct Sensor {
    name: String,
    files: Vec<PathBuf>,
    description: Option<PathBuf>,
}

/// What came of one sensor, as its file says it.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Row {
    sensor: String,
    serial: String,
    /// `pass`, `fail`, `no limits`, or `error`.
    verdict: String,
    reasons: Vec<String>,
    /// What has to be known beside the figures.
    #[serde(default)]
    cautions: Vec<String>,
    /// The limited figures, or the usual ones, by name and axis, in their limits' units.
    values: BTreeMap<String, f64>,
    /// What it was made of.
    input_sha256: String,
    program: String,
    outputs: Vec<String>,
}

/// What `verdict.json` holds.
#[derive(Serialize)]
struct Full<'a> {
    #[serde(flatten)]
    row: &'a Row,
    identity: &'a Identity,
    checked: &'a [Checked],
    uncertainty: Option<&'a Uncertainty>,
    sources: &'a [UsedRecording],
    rank: usize,
    condition: Option<f64>,
    messages: &'a [String],
}

const FAILED: &str = "error";

/// What all sensors share.
struct Batch<'a> {
    args: &'a BatchArgs,
    limits: Limits,
    limits_text: String,
    common: SensorFile,
}

pub(super) fn run(args: &BatchArgs) -> Result<(), JobError> {
    for ending in &args.export {
        let path = PathBuf::from(exported(ending));
        if target_for(&path).is_none() {
            return Err(JobError::Ending { path });
        }
    }
    let limits = args.limits.as_deref().map(Limits::read).transpose()?;
    let mut common = args.sensor.read()?;
    // No two sensors have the same.
    for own in [Item::Serial, Item::Certificate] {
        common.identity.set(own, "");
    }
    let batch = Batch {
        args,
        limits: limits.unwrap_or_default(),
        limits_text: args
            .limits
            .as_ref()
            .and_then(|path| std::fs::read_to_string(path).ok())
            .unwrap_or_default(),
        common,
    };
    let sensors = sensors(args)?;
    if sensors.is_empty() {
        return Err(JobError::NoSensors {
            path: args.dir.clone(),
        });
    }
    make_directory(&args.out)?;
    // Two runs into one folder, or a folder of recordings taken for one of results, would undo each other.
    let summary = args.out.join("summary.csv");
    check_targets(
        sensors.iter().flat_map(|own| &own.files),
        std::slice::from_ref(&summary),
        true,
    )?;
    let rows = batch.all(&sensors)?;
    write_atomically(&summary, |out| write_summary(&rows, &batch.limits, out))?;
    let count = |verdict: &str| rows.iter().filter(|row| row.verdict == verdict).count();
    let (failed, out_of) = (count(FAILED), count(Verdict::Fail.word()));
    let mut out = io::stdout().lock();
    writeln!(
        out,
        "{} sensors: {} pass, {out_of} out of tolerance, {failed} failed{}",
        rows.len(),
        count(Verdict::Pass.word()),
        match count(Verdict::None.word()) {
            0 => String::new(),
            n => format!(", {n} without limits"),
        }
    )?;
    for row in rows
        .iter()
        .filter(|row| row.verdict == FAILED || row.verdict == Verdict::Fail.word())
    {
        let reasons = row.reasons.join("; ");
        writeln!(
            out,
            "{}: {}: {}",
            printable(&row.sensor),
            row.verdict,
            printable(&reasons)
        )?;
    }
    writeln!(out, "{}", printable(&summary.to_string_lossy()))?;
    match (failed, out_of) {
        (0, 0) => Ok(()),
        (0, _) => Err(JobError::OutOfTolerance { count: out_of }),
        (failed, _) => Err(JobError::SomeFailed { count: failed }),
    }
}

/// What a calibration with this ending is called.
fn exported(ending: &str) -> String {
    format!("calibration.{}", ending.trim_start_matches('.'))
}

/// All sensors, by name.
fn sensors(args: &BatchArgs) -> Result<Vec<Sensor>, JobError> {
    let unreadable = |source| JobError::Directory {
        path: args.dir.clone(),
        source,
    };
    let name = |path: &Path, whole: bool| {
        let name = if whole {
            path.file_name()
        } else {
            path.file_stem()
        };
        name.unwrap_or_default().to_string_lossy().into_owned()
    };
    if args.sensor_from == From::File {
        let files = recordings_in(&args.dir).map_err(unreadable)?;
        return Ok(files
            .into_iter()
            .map(|file| Sensor {
                name: name(&file, false),
                description: Some(file.with_extension("toml")).filter(|path| path.is_file()),
                files: vec![file],
            })
            .collect());
    }
    let mut folders: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(&args.dir).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let is_out = args
            .out
            .canonicalize()
            .is_ok_and(|out| path.canonicalize().is_ok_and(|own| own == out));
        if path.is_dir() && !is_out && !name(&path, true).starts_with('.') {
            folders.push(path);
        }
    }
    folders.sort();
    let sensor = |folder: PathBuf| {
        Ok(Sensor {
            name: name(&folder, true),
            description: Some(folder.join("sensor.toml")).filter(|path| path.is_file()),
            files: recordings_in(&folder).map_err(unreadable)?,
        })
    };
    folders.into_iter().map(sensor).collect()
}

impl Batch<'_> {
    /// Every sensor, in their order.
    fn all(&self, sensors: &[Sensor]) -> Result<Vec<Row>, JobError> {
        let processors = thread::available_parallelism().map_or(1, usize::from);
        let jobs = self
            .args
            .jobs
            .map_or(processors, usize::from)
            .min(sensors.len());
        let log = std::fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(self.args.out.join("batch.log"));
        let log = log.map_err(|source| JobError::Directory {
            path: self.args.out.join("batch.log"),
            source,
        })?;
        let log = Mutex::new(log);
        let start = Instant::now();
        let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let line = Mutex::new(ProgressLine::default());
        let rows: Vec<Mutex<Option<Row>>> = sensors.iter().map(|_| Mutex::new(None)).collect();
        thread::scope(|scope| {
            for _ in 0..jobs {
                scope.spawn(|| {
                    loop {
                        let at = next.fetch_add(1, Ordering::Relaxed);
                        let Some(sensor) = sensors.get(at) else {
                            return;
                        };
                        let began = Instant::now();
                        let (row, told, messages) = self.row_of(sensor);
                        let finished = done.fetch_add(1, Ordering::Relaxed) + 1;
                        let mut entry = String::new();
                        let now = jiff::Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ");
                        let secs = began.elapsed().as_secs_f64();
                        let _ = writeln!(
                            entry,
                            "{now} {}: {}{told}, {secs:.2} s",
                            row.sensor, row.verdict
                        );
                        for text in row.reasons.iter().chain(&messages) {
                            let _ = writeln!(entry, "    {text}");
                        }
                        let mut log = log.lock().unwrap_or_else(PoisonError::into_inner);
                        // A log that cannot be written keeps no sensor up.
                        let _ = log.write_all(printable_lines(&entry).as_bytes());
                        drop(log);
                        *rows[at].lock().unwrap_or_else(PoisonError::into_inner) = Some(row);
                        let left = start.elapsed().as_secs_f64() / finished as f64
                            * (sensors.len() - finished) as f64;
                        let mut line = line.lock().unwrap_or_else(PoisonError::into_inner);
                        line.say(&format!(
                            "{finished} of {} sensors, {left:.0} s left",
                            sensors.len()
                        ));
                    }
                });
            }
        });
        line.lock().unwrap_or_else(PoisonError::into_inner).end();
        let rows = rows
            .into_iter()
            .map(|row| row.into_inner().unwrap_or_else(PoisonError::into_inner));
        Ok(rows.flatten().collect())
    }

    /// What came of one, whether it was there already, and what there is to say of it.
    fn row_of(&self, sensor: &Sensor) -> (Row, &'static str, Vec<String>) {
        let folder = self.args.out.join(&sensor.name);
        let failed = |reason: String| Row {
            sensor: sensor.name.clone(),
            serial: sensor.name.clone(),
            verdict: FAILED.to_owned(),
            reasons: vec![reason],
            cautions: Vec::new(),
            values: BTreeMap::new(),
            input_sha256: String::new(),
            program: PROGRAM.to_owned(),
            outputs: Vec::new(),
        };
        let key = match self.key(sensor) {
            Ok(key) => key,
            Err(reason) => return (self.kept(&folder, failed(reason)), "", Vec::new()),
        };
        if let Some(row) = there(&folder, &key).filter(|_| !self.args.force) {
            return (row, " (unchanged)", Vec::new());
        }
        let (made, messages) = hearing(|| caught(|| self.made(sensor, &folder, key.clone())));
        match made {
            Ok(Ok(row)) => (row, "", messages),
            Ok(Err(error)) => (self.kept(&folder, failed(error.to_string())), "", messages),
            Err(panic) => (self.kept(&folder, failed(panic.to_string())), "", messages),
        }
    }

    /// Everything that a sensor's files are made of, in one hash.
    fn key(&self, sensor: &Sensor) -> Result<String, String> {
        if sensor.files.is_empty() {
            return Err("the folder holds no recordings".to_owned());
        }
        let args = self.args;
        let mut text = format!(
            "{PROGRAM}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{}\n{:?}\n",
            args.export,
            args.certificate,
            args.dcc,
            args.model,
            args.split,
            args.group,
            args.read,
            self.limits_text,
            self.common
        );
        let own = sensor
            .files
            .iter()
            .chain(&sensor.description)
            .chain(args.read.map_file());
        for path in own {
            let hash = crate::export::sha256(path)
                .map_err(|error| format!("{}: {error}", path.display()))?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let _ = writeln!(text, "{name} {hash}");
        }
        Ok(sha256_of_text(&text))
    }

    fn made(&self, sensor: &Sensor, folder: &Path, key: String) -> Result<Row, JobError> {
        let args = self.args;
        let own = sensor
            .description
            .as_deref()
            .map(SensorFile::read)
            .transpose()?
            .unwrap_or_default();
        let mut identity = self.common.identity.with(&own.identity);
        if identity.get(Item::Serial).is_empty() {
            identity.set(Item::Serial, sensor.name.clone());
        }
        let is_test = |path: &&PathBuf| {
            let name = path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .to_lowercase();
            name.starts_with("test")
        };
        let (test, train): (Vec<&PathBuf>, Vec<&PathBuf>) = match args.split {
            Some(_) => (Vec::new(), sensor.files.iter().collect()),
            None if args.sensor_from == From::File => (Vec::new(), sensor.files.iter().collect()),
            None => sensor.files.iter().partition(is_test),
        };
        if train.is_empty() {
            return Err(JobError::OnlyTests);
        }
        let recordings = RecordingArgs {
            read: args.read.clone(),
            train: train.into_iter().cloned().collect(),
            test: test.into_iter().cloned().collect(),
            split: args.split,
            group: args.group.clone(),
        };
        let recordings = recordings.read(&args.model.rated().and(&own).and(&self.common))?;
        let mut settings = args.model.settings(&recordings);
        let axes = recordings.layout().axes.clone();
        own.rate(&axes, &mut settings.full_scale);
        self.common.rate(&axes, &mut settings.full_scale);
        let outputs: Vec<String> = args.export.iter().map(|ending| exported(ending)).collect();
        for output in &outputs {
            let path = folder.join(output);
            if let Some(target) = target_for(&path) {
                let refused = |refusal| WriteError {
                    path: path.clone(),
                    source: io::Error::other(refusal),
                };
                target
                    .check(&Outline::of_fit(&settings, recordings.layout()))
                    .map_err(refused)?;
            }
        }
        let request = Request::fit(Arc::new(recordings), settings);
        let told = if args.certificate {
            Told::Certificate
        } else {
            Told::Figures
        };
        let mut data = report_of(
            &request,
            &identity,
            &self.limits,
            told,
            &Progress::default(),
        )?;
        if let Some(undetermined) = data.calibration.undetermined() {
            return Err(JobError::Undetermined { undetermined });
        }
        let calibration = Arc::new(with_sources(&data.calibration, &request.recordings));
        data.calibration = Arc::clone(&calibration);
        if let Some(certificate) = &mut data.certificate {
            certificate.dated = false;
        }
        let certificate = data.certificate.clone().unwrap_or_default();
        let checked = certificate.checked;
        let verdict = Verdict::of(&checked);
        let mut all = vec![VERDICT.to_owned()];
        all.extend(outputs.iter().cloned());
        all.extend(args.certificate.then(|| CERTIFICATE.to_owned()));
        all.extend(args.dcc.then(|| DCC.to_owned()));
        let row = Row {
            sensor: sensor.name.clone(),
            serial: identity.get(Item::Serial).trim().to_owned(),
            verdict: verdict.word().to_owned(),
            reasons: checked
                .iter()
                .filter(|own| !own.pass)
                .map(Checked::told)
                .collect(),
            cautions: data.warnings.clone(),
            values: values(&checked, &certificate.measured, self.limits.is_empty()),
            input_sha256: key,
            program: PROGRAM.to_owned(),
            outputs: all,
        };
        make_directory(folder)?;
        let mut files = Together::default();
        for output in &outputs {
            add_calibration(&mut files, &calibration, &folder.join(output))?;
        }
        if args.certificate {
            let html = html_of(&data);
            files.write(&folder.join(CERTIFICATE), |out| {
                out.write_all(html.as_bytes())
            })?;
        }
        if args.dcc {
            let xml = dcc_of(&data)?;
            files.write(&folder.join(DCC), |out| out.write_all(xml.as_bytes()))?;
        }
        let full = Full {
            row: &row,
            identity: &identity,
            checked: &checked,
            uncertainty: data.uncertainty.as_ref().ok(),
            sources: &calibration.sources,
            rank: calibration.quality.rank,
            condition: calibration.quality.condition,
            messages: &data.warnings,
        };
        files.write(&folder.join(VERDICT), |out| write_json(&full, out))?;
        files.finish()?;
        Ok(row)
    }

    /// A sensor that failed leaves its reason, and nothing that looks like a result of before.
    fn kept(&self, folder: &Path, row: Row) -> Row {
        if std::fs::create_dir_all(folder).is_ok() {
            let before = self
                .args
                .export
                .iter()
                .map(|ending| exported(ending))
                .chain([CERTIFICATE, DCC].map(str::to_owned));
            for file in before {
                // One that is not there need not go.
                let _ = std::fs::remove_file(folder.join(file));
            }
            let _ = write_atomically(&folder.join(VERDICT), |out| write_json(&row, out));
        }
        row
    }
}

fn write_json(value: &impl Serialize, out: &mut dyn io::Write) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, value).map_err(io::Error::from)?;
    writeln!(out)
}

/// What stands there, if it was made of the same and is whole.
fn there(folder: &Path, key: &str) -> Option<Row> {
    let text = std::fs::read(folder.join(VERDICT)).ok()?;
    let row: Row = serde_json::from_slice(&text).ok()?;
    let is_whole = row
        .outputs
        .iter()
        .all(|output| folder.join(output).is_file());
    (row.verdict != FAILED && row.input_sha256 == key && is_whole).then_some(row)
}

/// What the summary has of a sensor.
fn values(
    checked: &[Checked],
    measured: &[crate::evaluation::limits::Measurement],
    usual: bool,
) -> BTreeMap<String, f64> {
    if usual {
        let of = measured.iter().filter(|own| USUAL.contains(&&*own.id));
        return of
            .filter_map(|own| {
                Some((
                    column(&own.id, own.axis, own.unit),
                    *own.value.as_ref().ok()?,
                ))
            })
            .collect();
    }
    checked
        .iter()
        .filter_map(|own| Some((column(&own.figure, own.axis, &own.unit), own.value?)))
        .collect()
}

/// What a figure's column is called.
fn column(id: &str, axis: Option<Axis>, unit: &str) -> String {
    let axis = axis.map_or_else(String::new, |axis| format!("_{}", axis.symbol()));
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" [{unit}]")
    };
    format!("{id}{axis}{unit}")
}

fn write_summary(rows: &[Row], limits: &Limits, out: &mut dyn io::Write) -> io::Result<()> {
    // In the order of the limits, each by axis.
    let mut columns: Vec<&String> = rows.iter().flat_map(|row| row.values.keys()).collect();
    let order = |name: &str| {
        let names = limits.figures();
        let place = names
            .iter()
            .position(|figure| name.starts_with(figure))
            .unwrap_or(names.len());
        let axis = Axis::ALL
            .iter()
            .position(|axis| name.contains(&format!("_{}", axis.symbol())));
        (
            place,
            name.split(['_', ' ']).next().unwrap_or_default().to_owned(),
            axis,
        )
    };
    columns.sort_by_cached_key(|name| order(name));
    columns.dedup();
    let mut csv = CsvWriter::new(out);
    let head = ["sensor", "serial", "verdict", "reasons"].map(str::to_owned);
    let tail = ["input_sha256", "program", "cautions"].map(str::to_owned);
    csv.row(
        head.into_iter()
            .chain(columns.iter().map(|name| (*name).clone()))
            .chain(tail),
    )?;
    for row in rows {
        let words = [
            row.sensor.clone(),
            row.serial.clone(),
            row.verdict.clone(),
            row.reasons.join("; "),
        ];
        let values = columns.iter().map(|name| {
            row.values
                .get(*name)
                .map_or_else(String::new, f64::to_string)
        });
        let tail = [
            row.input_sha256.clone(),
            row.program.clone(),
            row.cautions.join("; "),
        ];
        csv.row(words.into_iter().chain(values).chain(tail))?;
    }
    csv.flush()
}

/// Each line made harmless.
fn printable_lines(text: &str) -> String {
    let lines = text.lines().map(|line| format!("{}\n", printable(line)));
    lines.collect()
}
