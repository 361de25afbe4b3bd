//! Loads and errors over time as tables, one row per sample.
//!
//! Guarantees: rows are made as they are written, so the loads of one recording at a time are in memory; numbers are
//! written so that reading them gives the same value.

mod csv;
#[cfg(feature = "parquet")]
mod parquet;
mod table;

use std::borrow::Cow;
use std::io;
use std::ops::Range;
use std::path::Path;

use self::table::BeginTraces;
use super::format::FileFormat;
use crate::calibration::{Calibration, Estimator, Status};
use crate::export::atomic::{Together, WriteError};
use crate::formats::csv::CsvWriter;
use crate::progress::Progress;
use crate::recording::{Axis, Recording};

/// All formats of traces, one file each.
pub static TRACE_FORMATS: &[FileFormat<BeginTraces>] = &[
    csv::FORMAT,
    #[cfg(feature = "parquet")]
    parquet::FORMAT,
];

/// An interval of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Interval<'a> {
    /// All of the recording, since the past of a sample may lie before the interval.
    pub recording: &'a Recording,
    /// One of every `decimation` samples is used.
    pub decimation: usize,
    /// Which of these samples are written.
    pub samples: Range<usize>,
}

/// Writes what a calibration makes of intervals of recordings as one of `files`: recording, time, then Reference, Uncompensated,
/// Compensated and the errors Uncompensated − Reference and Compensated − Reference per axis. Where there is no reference, its cells are empty. The
/// ending says which of [`TRACE_FORMATS`]; without a known one it is the first.
///
/// # Errors
/// [`WriteError`] if the file cannot be written, a recording has other gauges than the calibration, or somebody asked to
/// stop.
pub fn write_traces(
    files: &mut Together,
    path: &Path,
    calibration: &Calibration,
    intervals: &[Interval<'_>],
    progress: &Progress,
) -> Result<(), WriteError> {
    let format = FileFormat::for_path(TRACE_FORMATS, path).unwrap_or(&TRACE_FORMATS[0]);
    let recordings = intervals.iter().map(|interval| interval.recording);
    let reference: Vec<Axis> = recordings.flat_map(Recording::axes).copied().collect();
    let columns = Columns::of(calibration, &reference, &KINDS);
    files.write(path, |out| {
        let mut table = (format.write)(&columns.head(), out)?;
        let mut row = Vec::new();
        let n_axes = calibration.axes.len();
        progress.add_total(intervals.len() as u64);
        for interval in intervals {
            let recording = match interval.decimation {
                0 | 1 => Cow::Borrowed(interval.recording),
                step => Cow::Owned(interval.recording.decimated(step)),
            };
            progress.check().map_err(io::Error::other)?;
            let loads = calibration.apply(&recording).map_err(io::Error::other)?;
            for k in interval.samples.start..interval.samples.end.min(recording.n_samples()) {
                let own = k * n_axes..(k + 1) * n_axes;
                let loads = (&loads.conventional[own.clone()], &loads.compensated[own]);
                columns.fill(recording.clock_time(k), reference_at(&recording, k), loads, &mut row);
                table.row(recording.name(), &row)?;
            }
            progress.advance(1);
        }
        table.finish()
    })
}

/// What was really applied at sample `k`, where that is known.
fn reference_at(recording: &Recording, k: usize) -> (&[Axis], &[f64]) {
    let axes = recording.axes();
    (axes, &recording.loads()[k * axes.len()..][..axes.len()])
}

/// Writes what a calibration makes, sample by sample, of the recordings of one file, one after another, as comma-separated text:
/// time, Reference where there is a reference, Uncompensated and Compensated per axis, and where it is asked for what became of the sample. What runs
/// on a robot gives the same.
///
/// # Errors
/// Whatever `out` fails with.
pub fn write_loads_csv(
    calibration: &Calibration,
    recordings: &[Recording],
    with_status: bool,
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let design = calibration.design();
    let mut estimator = Estimator::new(calibration, &design).map_err(io::Error::other)?;
    let axes = recordings.iter().flat_map(Recording::axes).copied();
    let mut loads = LoadRows::new(calibration, axes.collect(), with_status, out)?;
    for recording in recordings {
        let recording = &*calibration.prepared(recording).map_err(io::Error::other)?;
        estimator.come_less((0..recording.n_gauges()).map(|gauge| recording.tared_by(gauge)));
        for (k, time) in recording.times().iter().enumerate() {
            let sample = LiveSample {
                time: *time,
                clock_secs: recording.clock_time(k),
                gauges: recording.gauges_at(k),
                auxiliary: if calibration.features.auxiliary.is_empty() {
                    &[]
                } else {
                    recording.auxiliary().at(k)
                },
                reference: reference_at(recording, k),
                is_held: recording.auxiliary().is_held_at(*time),
            };
            loads.write(&mut estimator, sample)?;
        }
    }
    loads.flush()
}

/// A sample as it comes.
#[derive(Clone, Copy, Debug)]
pub struct LiveSample<'a> {
    /// Its time (s).
    pub time: f64,
    /// Its time as it is written (s).
    pub clock_secs: f64,
    /// Its gauges, in the order of the calibration.
    pub gauges: &'a [f64],
    /// Its auxiliary channels, in the order of the calibration.
    pub auxiliary: &'a [f64],
    /// What was really applied, where that is known.
    pub reference: (&'a [Axis], &'a [f64]),
    /// Whether an auxiliary channel shows what was measured too long ago.
    pub is_held: bool,
}

/// Loads, a row as each sample comes: comma-separated text, or JSON lines.
pub struct LoadRows<W: io::Write> {
    columns: Columns,
    out: RowWriter<W>,
    row: Vec<Option<f64>>,
}

/// What rows of loads are written as.
enum RowWriter<W: io::Write> {
    Csv {
        out: CsvWriter<W>,
        with_status: bool,
    },
    /// One object a line, with these keys before the status.
    Json {
        out: W,
        keys: Vec<String>,
    },
}

impl<W: io::Write> LoadRows<W> {
    /// Writes the head of a text; `reference` are the axes that are known.
    ///
    /// # Errors
    /// Whatever `out` fails with.
    pub fn new(
        calibration: &Calibration,
        reference: Vec<Axis>,
        with_status: bool,
        out: W,
    ) -> io::Result<Self> {
        let columns = Columns::of(calibration, &reference, &KINDS[..3]);
        let mut out = CsvWriter::new(out);
        let status = with_status.then(|| "status".to_owned());
        out.row(columns.head().into_iter().chain(status))?;
        Ok(Self { columns, out: RowWriter::Csv { out, with_status }, row: Vec::new() })
    }

    /// As [`Self::new`] with a status, or JSON lines, which have no head.
    ///
    /// # Errors
    /// Whatever `out` fails with.
    pub fn live(
        calibration: &Calibration,
        reference: Vec<Axis>,
        is_json: bool,
        out: W,
    ) -> io::Result<Self> {
        if !is_json {
            return Self::new(calibration, reference, true, out);
        }
        let columns = Columns::of(calibration, &reference, &KINDS[..3]);
        let key =
            |(kind, axis, _): &(Kind, Axis, usize)| format!("{}_{}", axis.symbol(), kind.label());
        let keys = ["t".to_owned()].into_iter().chain(columns.columns.iter().map(key)).collect();
        Ok(Self { columns, out: RowWriter::Json { out, keys }, row: Vec::new() })
    }

    /// Runs a sample and writes its row.
    ///
    /// # Errors
    /// Whatever `out` fails with.
    pub fn write(
        &mut self,
        estimator: &mut Estimator<'_>,
        sample: LiveSample<'_>,
    ) -> io::Result<()> {
        let n_axes = estimator.conventional().len();
        let updated = estimator.update_with(sample.time, sample.gauges, sample.auxiliary);
        let (status, compensated) = match updated {
            Ok((mut status, loads)) => {
                if sample.is_held {
                    status |= Status::AUXILIARY_HELD;
                }
                (status, loads.to_vec())
            }
            Err(error) => (error.status(), vec![f64::NAN; n_axes]),
        };
        let loads = (estimator.conventional(), &compensated[..]);
        (self.columns).fill(sample.clock_secs, sample.reference, loads, &mut self.row);
        self.end_row(&status.to_string(), None)
    }

    /// Writes the row of a sample that was not run: its time, as far as it is known, its status, and in JSON lines why.
    ///
    /// # Errors
    /// Whatever `out` fails with.
    pub fn write_without_load(
        &mut self,
        time: Option<f64>,
        status: &str,
        why: Option<&str>,
    ) -> io::Result<()> {
        self.row.clear();
        self.row.push(time);
        self.row.resize(1 + self.columns.columns.len(), None);
        self.end_row(status, why)
    }

    fn end_row(&mut self, status: &str, why: Option<&str>) -> io::Result<()> {
        match &mut self.out {
            RowWriter::Csv { out, with_status } => {
                csv::write_cells(out, &self.row)?;
                if *with_status {
                    out.cell(status)?;
                }
                out.end_row()
            }
            RowWriter::Json { out, keys } => {
                let numbers = self.row.iter().map(|number| serde_json::json!(number));
                let texts = [("status", Some(status)), ("why", why)].into_iter();
                let texts = texts.filter_map(|(key, text)| Some((key.to_owned(), text?.into())));
                let members = keys.iter().cloned().zip(numbers).chain(texts);
                writeln!(out, "{}", serde_json::Value::Object(members.collect()))
            }
        }
    }

    /// Hands on what is written.
    ///
    /// # Errors
    /// Whatever `out` fails with.
    pub fn flush(&mut self) -> io::Result<()> {
        match &mut self.out {
            RowWriter::Csv { out, .. } => out.flush(),
            RowWriter::Json { out, .. } => out.flush(),
        }
    }
}

/// What is told of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Calculated,
    Conventional,
    Compensated,
    ConventionalError,
    CompensatedError,
}

const KINDS: [Kind; 5] = [
    Kind::Calculated,
    Kind::Conventional,
    Kind::Compensated,
    Kind::ConventionalError,
    Kind::CompensatedError,
];

impl Kind {
    fn label(self) -> &'static str {
        match self {
            Self::Calculated => "calc",
            Self::Conventional => "conv",
            Self::Compensated => "comp",
            Self::ConventionalError => "conv error",
            Self::CompensatedError => "comp error",
        }
    }

    fn needs_reference(self) -> bool {
        !matches!(self, Self::Conventional | Self::Compensated)
    }
}

/// Time, then one column for each kind and axis.
struct Columns {
    /// Kind, axis, and the place of the axis in the calibration.
    columns: Vec<(Kind, Axis, usize)>,
}

impl Columns {
    /// What needs a reference is there for the axes that some recording has one for.
    fn of(calibration: &Calibration, reference: &[Axis], kinds: &[Kind]) -> Self {
        let has_reference = |axis: &Axis| reference.contains(axis);
        let columns = kinds.iter().flat_map(|kind| {
            let axes = calibration.axes.iter().enumerate();
            axes.filter(|(_, axis)| !kind.needs_reference() || has_reference(axis))
                .map(|(at, axis)| (*kind, *axis, at))
        });
        Self { columns: columns.collect() }
    }

    fn head(&self) -> Vec<String> {
        let columns = self.columns.iter();
        let labels = columns
            .map(|(kind, axis, _)| format!("{} {} [{}]", axis.symbol(), kind.label(), axis.unit()));
        std::iter::once("t [s]".to_owned()).chain(labels).collect()
    }

    /// The numbers of one sample, given its reference and its conventional and compensated load; `None` where there is none.
    fn fill(
        &self,
        time: f64,
        (axes, reference): (&[Axis], &[f64]),
        (conventional, compensated): (&[f64], &[f64]),
        row: &mut Vec<Option<f64>>,
    ) {
        row.clear();
        row.push(Some(time));
        row.extend(self.columns.iter().map(|(kind, axis, at)| {
            let reference = || {
                let column = axes.iter().position(|own| own == axis)?;
                Some(reference[column])
            };
            let known = |load: f64| load.is_finite().then_some(load);
            let (conventional, compensated) = (known(conventional[*at]), known(compensated[*at]));
            match kind {
                Kind::Calculated => reference(),
                Kind::Conventional => conventional,
                Kind::Compensated => compensated,
                Kind::ConventionalError => Some(conventional? - reference()?),
                Kind::CompensatedError => Some(compensated? - reference()?),
            }
        }));
    }
}
