//! Loads and errors over time as tables, one row per sample. Each row is computed when it is written, so only the loads of
//! one recording are in memory. Written numbers read back to the same value.

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
use crate::{
    calibration::{Calibration, Estimator, Status},
    export::atomic::{Together, WriteError},
    formats::csv::CsvWriter,
    progress::Progress,
    recording::{Axis, Recording},
};

pub static TRACE_FORMATS: &[FileFormat<BeginTraces>] = &[
    csv::FORMAT,
    #[cfg(feature = "parquet")]
    parquet::FORMAT,
];

/// Part of a recording for which loads are written.
#[derive(Clone, Debug, PartialEq)]
pub struct Interval<'a> {
    /// The whole recording that contains the part, because the look-back may need samples before the part.
    pub recording: &'a Recording,
    /// Decimation: one of every `decimation` samples is used.
    pub decimation: usize,
    /// Indices of the samples to write, counted after decimation.
    pub samples: Range<usize>,
}

/// Writes the loads of parts of recordings as one of `files`, like [`write_loads_csv`]: recordings of one file follow one
/// another, so states are kept through pauses between them up to [`Calibration::keep_secs`].
///
/// A row has the recording and the time. For each axis follow Reference, Uncompensated and Compensated loads, and the errors
/// Uncompensated − Reference and Compensated − Reference. Cells that need a missing reference are empty. The file name ending
/// selects one of [`TRACE_FORMATS`]. An unknown ending means the first format.
///
/// # Errors
/// [`WriteError`] if the file cannot be written, a recording has other gauges than the calibration, or the user stops the work.
pub fn write_traces(
    files: &mut Together,
    path: &Path,
    calibration: &Calibration,
    intervals: &[Interval<'_>],
    progress: &Progress,
) -> Result<(), WriteError> {
    let format = FileFormat::for_path(TRACE_FORMATS, path).unwrap_or(&TRACE_FORMATS[0]);
    let reference: Vec<Axis> = intervals
        .iter()
        .map(|interval| interval.recording)
        .flat_map(Recording::axes)
        .copied()
        .collect();
    let columns = Columns::of(calibration, &reference, &QUANTITIES);
    files.write(path, |out| {
        let mut table = (format.write)(&columns.head(), out)?;
        let mut row = Vec::new();
        progress.add_total(intervals.len() as u64);
        let design = calibration.design();
        let mut estimator = Estimator::new(calibration, &design).map_err(io::Error::other)?;
        let mut file = None;
        for interval in intervals {
            let recording = match interval.decimation {
                0 | 1 => Cow::Borrowed(interval.recording),
                step => Cow::Owned(interval.recording.decimated(step)),
            };
            progress.check().map_err(io::Error::other)?;
            let path = interval.recording.source().path();
            if path.is_none() || path != file {
                estimator.reset();
            }
            file = path;
            let recording = &*calibration.prepared(&recording).map_err(io::Error::other)?;
            for (k, sample) in samples_of(calibration, recording, &mut estimator).enumerate() {
                let (_, loads) = sample.loads(&mut estimator);
                if interval.samples.contains(&k) {
                    let loads = (estimator.conventional(), &loads[..]);
                    columns.fill(sample.clock_secs, sample.reference, loads, &mut row);
                    table.row(recording.name(), &row)?;
                }
            }
            progress.advance(1);
        }
        table.finish()
    })
}

fn reference_at(recording: &Recording, k: usize) -> (&[Axis], &[f64]) {
    let axes = recording.axes();
    (axes, &recording.loads()[k * axes.len()..][..axes.len()])
}

/// Writes the loads of one file's recordings as comma-separated text: time, Reference if known, Uncompensated and
/// Compensated per axis, and the status if requested. Exported code on a robot computes the same loads.
pub fn write_loads_csv(
    calibration: &Calibration,
    recordings: &[Recording],
    with_status: bool,
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let design = calibration.design();
    let mut estimator = Estimator::new(calibration, &design).map_err(io::Error::other)?;
    let mut loads = LoadRows::new(
        calibration,
        recordings.iter().flat_map(Recording::axes).copied().collect(),
        with_status,
        out,
    )?;
    for recording in recordings {
        let recording = &*calibration.prepared(recording).map_err(io::Error::other)?;
        for sample in samples_of(calibration, recording, &mut estimator) {
            loads.write(&mut estimator, sample)?;
        }
    }
    loads.flush()
}

/// Returns the samples of a prepared recording, whose loads `estimator` computes next.
fn samples_of<'a>(
    calibration: &Calibration,
    recording: &'a Recording,
    estimator: &mut Estimator<'_>,
) -> impl Iterator<Item = LiveSample<'a>> + use<'a> {
    estimator
        .set_subtracted_before((0..recording.n_gauges()).map(|gauge| recording.tared_by(gauge)));
    let has_auxiliary = !calibration.features.auxiliary.is_empty();
    recording.times().iter().enumerate().map(move |(k, time)| LiveSample {
        time: *time,
        clock_secs: recording.clock_time(k),
        gauges: recording.gauges_at(k),
        auxiliary: if has_auxiliary { recording.auxiliary().at(k) } else { &[] },
        reference: reference_at(recording, k),
        is_held: recording.auxiliary().is_held_at(*time),
    })
}

#[derive(Clone, Copy, Debug)]
pub struct LiveSample<'a> {
    /// Time of the sample since the start of the recording (s), from which loads are computed.
    pub time: f64,
    /// Time of the sample as it is written to the file (s).
    pub clock_secs: f64,
    /// Gauges of the sample, in the order of the calibration.
    pub gauges: &'a [f64],
    pub auxiliary: &'a [f64],
    /// Axes of the reference load and its values; empty if there is no reference.
    pub reference: (&'a [Axis], &'a [f64]),
    /// True if an auxiliary channel has had no new value for too long.
    pub is_held: bool,
}

impl LiveSample<'_> {
    /// Returns the status and the compensated load of the sample.
    fn loads(&self, estimator: &mut Estimator<'_>) -> (Status, Vec<f64>) {
        estimator.update_or_nan(self.time, self.gauges, self.auxiliary, self.is_held)
    }
}

/// Writer of loads, one row per sample, as comma-separated text or JSON lines.
pub struct LoadRows<W: io::Write> {
    columns: Columns,
    out: RowWriter<W>,
    row: Vec<Option<f64>>,
}

enum RowWriter<W: io::Write> {
    Csv {
        out: CsvWriter<W>,
        with_status: bool,
    },
    /// One JSON object per sample and line. `keys` are the JSON keys before the status.
    Json {
        out: W,
        keys: Vec<String>,
    },
}

impl<W: io::Write> LoadRows<W> {
    /// Begins comma-separated text and writes its header. `reference` lists the axes with a known reference load.
    pub fn new(
        calibration: &Calibration,
        reference: Vec<Axis>,
        with_status: bool,
        out: W,
    ) -> io::Result<Self> {
        let columns = Columns::of(calibration, &reference, &QUANTITIES[..3]);
        let mut out = CsvWriter::new(out);
        let status = with_status.then(|| "status".to_owned());
        out.row(columns.head().into_iter().chain(status))?;
        Ok(Self { columns, out: RowWriter::Csv { out, with_status }, row: Vec::new() })
    }

    /// Begins the output like [`Self::new`], but with a status column, or as JSON lines without a header.
    pub fn live(
        calibration: &Calibration,
        reference: Vec<Axis>,
        is_json: bool,
        out: W,
    ) -> io::Result<Self> {
        if !is_json {
            return Self::new(calibration, reference, true, out);
        }
        let columns = Columns::of(calibration, &reference, &QUANTITIES[..3]);
        let keys = columns.0.iter().map(|(label, _, axis, _)| format!("{axis}_{label}"));
        let keys = ["t".to_owned()].into_iter().chain(keys).collect();
        Ok(Self { columns, out: RowWriter::Json { out, keys }, row: Vec::new() })
    }

    /// Computes the loads of a sample and writes its row.
    pub fn write(
        &mut self,
        estimator: &mut Estimator<'_>,
        sample: LiveSample<'_>,
    ) -> io::Result<()> {
        let (status, compensated) = sample.loads(estimator);
        let loads = (estimator.conventional(), &compensated[..]);
        (self.columns).fill(sample.clock_secs, sample.reference, loads, &mut self.row);
        self.end_row(&status.to_string(), None)
    }

    /// Writes the row of a sample for which no load can be computed: its time if known, its status, and in JSON lines the
    /// reason.
    pub fn write_without_load(
        &mut self,
        time: Option<f64>,
        status: &str,
        why: Option<&str>,
    ) -> io::Result<()> {
        self.row.clear();
        self.row.push(time);
        self.row.resize(1 + self.columns.0.len(), None);
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
                let texts = [("status", Some(status)), ("why", why)]
                    .into_iter()
                    .filter_map(|(key, text)| Some((key.to_owned(), text?.into())));
                let members = keys.iter().cloned().zip(numbers).chain(texts);
                writeln!(out, "{}", serde_json::Value::Object(members.collect()))
            }
        }
    }

    pub fn flush(&mut self) -> io::Result<()> {
        match &mut self.out {
            RowWriter::Csv { out, .. } => out.flush(),
            RowWriter::Json { out, .. } => out.flush(),
        }
    }
}

/// Reference, conventional and compensated load of one axis; `None` for a missing load.
type Loads = [Option<f64>; 3];
/// Function that computes a quantity.
type Computation = fn(Loads) -> Option<f64>;

/// Label of a quantity, whether it needs a reference, and its computation.
type Quantity = (&'static str, bool, Computation);

const QUANTITIES: [Quantity; 5] = [
    ("reference", true, |[reference, ..]| reference),
    ("uncompensated", false, |[_, conventional, _]| conventional),
    ("compensated", false, |[.., compensated]| compensated),
    ("uncompensated error", true, |[reference, conventional, _]| Some(conventional? - reference?)),
    ("compensated error", true, |[reference, _, compensated]| Some(compensated? - reference?)),
];

/// Table columns: label, computation, axis, and index of the axis in the calibration.
struct Columns(Vec<(&'static str, Computation, Axis, usize)>);

impl Columns {
    /// Returns the table columns for these quantities. A quantity that needs a reference has a column only for axes with a
    /// reference in at least one recording.
    fn of(calibration: &Calibration, reference: &[Axis], quantities: &[Quantity]) -> Self {
        let columns = quantities.iter().flat_map(|&(label, needs_reference, of)| {
            let axes = calibration.axes.iter().enumerate();
            axes.filter(move |(_, axis)| !needs_reference || reference.contains(axis))
                .map(move |(at, axis)| (label, of, *axis, at))
        });
        Self(columns.collect())
    }

    fn head(&self) -> Vec<String> {
        let columns = self.0.iter();
        let labels = columns.map(|(label, _, axis, _)| format!("{axis} {label} [{}]", axis.unit()));
        std::iter::once("t [s]".to_owned()).chain(labels).collect()
    }

    /// Computes the numbers of one row from the reference, conventional and compensated loads of the sample; `None` for a
    /// missing number.
    fn fill(
        &self,
        time: f64,
        (axes, reference): (&[Axis], &[f64]),
        (conventional, compensated): (&[f64], &[f64]),
        row: &mut Vec<Option<f64>>,
    ) {
        row.clear();
        row.push(Some(time));
        let known = |load: f64| load.is_finite().then_some(load);
        row.extend(self.0.iter().map(|(_, of, axis, at)| {
            let column = axes.iter().position(|known| known == axis);
            let reference = column.map(|column| reference[column]);
            of([reference, known(conventional[*at]), known(compensated[*at])])
        }));
    }
}
