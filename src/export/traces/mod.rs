//! Loads and errors over time as tables, one row per sample.
//!
//! Guarantees: rows are made as they are written, so the loads of one recording at a time are in memory; numbers are
//! written so that reading them gives the same value.

mod csv;
#[cfg(feature = "parquet")]
mod parquet;

use std::io;
use std::ops::Range;
use std::path::Path;

use super::format::FileFormat;
use super::{WriteError, write_atomically};
use crate::calibration::{AppliedLoads, Calibration};
use crate::formats::csv::CsvWriter;
use crate::progress::Progress;
use crate::recording::{Axis, Recording};

/// A table of traces that is being written.
pub trait TraceTable {
    /// Writes a row: the recording, and the numbers that are there.
    ///
    /// # Errors
    /// Whatever the file fails with.
    fn row(&mut self, recording: &str, row: &[Option<f64>]) -> io::Result<()>;

    /// Writes what is still to be written.
    ///
    /// # Errors
    /// Whatever the file fails with.
    fn finish(self: Box<Self>) -> io::Result<()>;
}

/// Begins a table whose first column is of recordings, and whose others are of numbers with these heads.
pub type BeginTraces =
    for<'o> fn(&[String], &'o mut dyn io::Write) -> io::Result<Box<dyn TraceTable + 'o>>;

/// All formats of traces, one file each.
pub static TRACE_FORMATS: &[FileFormat<BeginTraces>] = &[
    csv::FORMAT,
    #[cfg(feature = "parquet")]
    parquet::FORMAT,
];

/// A interval of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Interval<'a> {
    /// All of the recording, since the past of a sample may lie before the interval.
    pub recording: &'a Recording,
    /// Every so many-th of its samples is used.
    pub decimation: usize,
    /// Which of these samples are written.
    pub samples: Range<usize>,
}

/// Writes what a calibration makes of intervals of recordings, whole or not at all: recording, time, then Calc., Conv.,
/// Comp. and the errors Conv. − Calc. and Comp. − Calc. per axis. Where there is no reference, its cells are empty. The
/// ending says which of [`TRACE_FORMATS`]; without a known one it is the first.
///
/// # Errors
/// [`WriteError`] if the file cannot be written, a recording has other gauges than the calibration, or somebody asked to
/// stop.
pub fn write_traces(
    path: &Path,
    calibration: &Calibration,
    intervals: &[Interval<'_>],
    progress: &Progress,
) -> Result<(), WriteError> {
    let format = FileFormat::for_path(TRACE_FORMATS, path).unwrap_or(&TRACE_FORMATS[0]);
    let recordings = intervals.iter().map(|interval| interval.recording);
    let columns = Columns::of(calibration, recordings, &KINDS);
    write_atomically(path, |out| {
        let mut table = (format.write)(&columns.head(), out)?;
        let mut row = Vec::new();
        for_each(calibration, intervals, progress, |part| {
            columns.fill(part.recording, part.loads, part.sample, &mut row);
            table.row(part.recording.name(), &row)
        })?;
        table.finish()
    })
}

/// One sample that is to be written.
struct Part<'a> {
    recording: &'a Recording,
    loads: &'a AppliedLoads,
    sample: usize,
}

/// Applies the calibration to one recording after the other and hands over each sample.
fn for_each(
    calibration: &Calibration,
    intervals: &[Interval<'_>],
    progress: &Progress,
    mut write: impl FnMut(Part<'_>) -> io::Result<()>,
) -> io::Result<()> {
    progress.add_total(intervals.len() as u64);
    for interval in intervals {
        let decimated;
        let recording = match interval.decimation {
            0 | 1 => interval.recording,
            step => {
                decimated = interval.recording.decimated(step);
                &decimated
            }
        };
        progress.check().map_err(io::Error::other)?;
        let loads = calibration.apply(recording).map_err(io::Error::other)?;
        for sample in interval.samples.start..interval.samples.end.min(recording.n_samples()) {
            let loads = &loads;
            write(Part {
                recording,
                loads,
                sample,
            })?;
        }
        progress.advance(1);
    }
    Ok(())
}

/// Writes recordings with what a calibration makes of them, one row per sample: time, then per axis Calc. (where the
/// recording has it), Conv. and Comp.
///
/// The recordings are the uninterrupted runs of one file, so the rows are those of the file.
///
/// # Errors
/// Whatever `out` fails with.
pub fn write_loads_csv(
    calibration: &Calibration,
    recordings: &[(&Recording, AppliedLoads)],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let columns = Columns::of(
        calibration,
        recordings.iter().map(|(recording, _)| *recording),
        &KINDS[..3],
    );
    let mut csv = CsvWriter::new(out);
    csv.row(columns.head())?;
    let mut row = Vec::new();
    for (recording, loads) in recordings {
        for sample in 0..recording.n_samples() {
            columns.fill(recording, loads, sample, &mut row);
            csv::write_row(&mut csv, &row)?;
        }
    }
    csv.flush()
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
    n_axes: usize,
    /// Kind, axis, and the place of the axis in the calibration.
    columns: Vec<(Kind, Axis, usize)>,
}

impl Columns {
    /// What needs a reference is there for the axes that some recording has one for.
    fn of<'a>(
        calibration: &Calibration,
        recordings: impl Iterator<Item = &'a Recording> + Clone,
        kinds: &[Kind],
    ) -> Self {
        let has_reference = |axis: &Axis| {
            recordings
                .clone()
                .any(|recording| recording.axes().contains(axis))
        };
        let columns = kinds.iter().flat_map(|kind| {
            let axes = calibration.axes.iter().enumerate();
            axes.filter(|(_, axis)| !kind.needs_reference() || has_reference(axis))
                .map(|(at, axis)| (*kind, *axis, at))
        });
        Self {
            n_axes: calibration.axes.len(),
            columns: columns.collect(),
        }
    }

    fn head(&self) -> Vec<String> {
        let columns = self.columns.iter();
        let labels = columns
            .map(|(kind, axis, _)| format!("{} {} [{}]", axis.symbol(), kind.label(), axis.unit()));
        std::iter::once("t [s]".to_owned()).chain(labels).collect()
    }

    /// The numbers of one sample; `None` where the recording has no reference.
    fn fill(
        &self,
        recording: &Recording,
        loads: &AppliedLoads,
        sample: usize,
        row: &mut Vec<Option<f64>>,
    ) {
        let truth = &recording.loads()[sample * recording.axes().len()..];
        let first = sample * self.n_axes;
        row.clear();
        row.push(Some(recording.times()[sample]));
        row.extend(self.columns.iter().map(|(kind, axis, at)| {
            let reference = || {
                let column = recording.axes().iter().position(|own| own == axis)?;
                Some(truth[column])
            };
            let (conventional, compensated) = (
                loads.conventional[first + at],
                loads.compensated[first + at],
            );
            match kind {
                Kind::Calculated => reference(),
                Kind::Conventional => Some(conventional),
                Kind::Compensated => Some(compensated),
                Kind::ConventionalError => Some(conventional - reference()?),
                Kind::CompensatedError => Some(compensated - reference()?),
            }
        }));
    }
}
