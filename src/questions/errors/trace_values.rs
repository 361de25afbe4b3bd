//! What traces are of: tables that are there anyway, read column by column, or loads that are made where somebody looks.

use std::fmt;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use crate::calibration::{Calibration, Past};
use crate::features::Design;
use crate::recording::Recording;
use crate::scoring::series::Values;

/// One recording's place in the traces.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Its index in the set.
    pub recording: usize,
    /// Its name.
    pub name: String,
    /// Its samples, counted over the traces.
    pub samples: Range<usize>,
    /// Added to a time on the axis, this gives the time on the recording's own clock (s).
    pub clock_offset_secs: f64,
}

/// A table of one recording, row-major.
#[derive(Clone, Debug)]
pub(crate) enum Table {
    /// Its reference.
    Reference(Arc<Recording>),
    /// Loads.
    Loads(Arc<Vec<f64>>),
}

impl Table {
    fn values(&self) -> &[f64] {
        match self {
            Self::Reference(recording) => recording.loads(),
            Self::Loads(loads) => loads,
        }
    }
}

/// A column of a table, with the table's width.
pub(crate) type Column = (Table, usize, usize);

/// A column of one table for each recording on screen, end to end.
#[derive(Debug)]
pub(crate) struct Columns {
    pub segments: Arc<[Segment]>,
    /// One for each segment.
    pub columns: Vec<Column>,
}

/// Hands the parts of `samples` to `take`, each with its segment's position, its own samples and where they begin in `samples`.
fn by_segment(
    segments: &[Segment],
    samples: Range<usize>,
    mut take: impl FnMut(usize, Range<usize>, usize),
) {
    let first = segments.partition_point(|segment| segment.samples.end <= samples.start);
    for (at, segment) in segments.iter().enumerate().skip(first) {
        let start = samples.start.max(segment.samples.start);
        let end = samples.end.min(segment.samples.end);
        if start >= end {
            break;
        }
        let before = segment.samples.start;
        take(at, start - before..end - before, start - samples.start);
    }
}

fn n_samples(segments: &[Segment]) -> usize {
    segments.last().map_or(0, |last| last.samples.end)
}

impl Values for Columns {
    fn n_samples(&self) -> usize {
        n_samples(&self.segments)
    }

    fn read(&self, samples: Range<usize>, out: &mut [f64]) {
        by_segment(&self.segments, samples, |at, own, begin| {
            let (table, column, width) = &self.columns[at];
            let out = &mut out[begin..begin + own.len()];
            let rows = table.values()[own.start * width..own.end * width].chunks_exact(*width);
            for (out, row) in out.iter_mut().zip(rows) {
                *out = row[*column];
            }
        });
    }
}

/// Samples whose loads are made at a time.
const BLOCK: usize = 4096;
/// Blocks that are kept; more than a picture shows sample by sample.
const KEPT: usize = 64;

/// The loads of one block, axis after axis.
type Block = Arc<[f64]>;

/// Loads of too many samples to be kept: of those that were looked at last, the others are made when somebody looks.
pub(crate) struct Made {
    segments: Arc<[Segment]>,
    /// One for each segment.
    recordings: Vec<Arc<Recording>>,
    calibration: Calibration,
    design: Design,
    /// By recording; without it, the loads are those of the present gauges.
    past: Option<Arc<Vec<Past>>>,
    kept: Vec<Mutex<Option<(usize, Block)>>>,
}

impl fmt::Debug for Made {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Made").finish_non_exhaustive()
    }
}

/// One axis of them.
#[derive(Debug)]
pub(crate) struct MadeAxis {
    pub made: Arc<Made>,
    pub axis: usize,
}

impl Made {
    /// The conventional loads, or with the past the compensated ones.
    ///
    /// The calibration must be [quick anywhere](Calibration::is_quick_anywhere) for the latter.
    pub fn new(
        segments: &Arc<[Segment]>,
        recordings: Vec<Arc<Recording>>,
        calibration: &Calibration,
        past: Option<Arc<Vec<Past>>>,
    ) -> Self {
        Self {
            segments: Arc::clone(segments),
            recordings,
            design: calibration.design(),
            calibration: calibration.clone(),
            past,
            kept: (0..KEPT).map(|_| Mutex::default()).collect(),
        }
    }

    fn block(&self, number: usize) -> Block {
        let slot = &self.kept[number % KEPT];
        let kept = |slot: &Mutex<Option<(usize, Block)>>| {
            let slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
            let own = slot.as_ref().filter(|(own, _)| *own == number);
            own.map(|(_, block)| Arc::clone(block))
        };
        kept(slot).unwrap_or_else(|| {
            let block = self.make(number);
            *slot.lock().unwrap_or_else(PoisonError::into_inner) =
                Some((number, Arc::clone(&block)));
            block
        })
    }

    fn make(&self, number: usize) -> Block {
        let n_axes = self.calibration.axes.len();
        let start = number * BLOCK;
        let samples = start..(start + BLOCK).min(n_samples(&self.segments));
        let mut rows = vec![0.0; samples.len() * n_axes];
        by_segment(&self.segments, samples.clone(), |at, own, begin| {
            let rows = &mut rows[begin * n_axes..(begin + own.len()) * n_axes];
            let recording = &self.recordings[at];
            match &self.past {
                Some(past) => {
                    let past = &past[self.segments[at].recording];
                    self.calibration.compensated_loads_of(&self.design, recording, past, own, rows);
                }
                None => {
                    let width = recording.n_gauges();
                    let gauges = &recording.gauges()[own.start * width..own.end * width];
                    (self.calibration.conventional).apply_rows(gauges, width, rows);
                }
            }
        });
        let axes = (0..n_axes).flat_map(|axis| rows.iter().skip(axis).step_by(n_axes));
        axes.copied().collect()
    }
}

impl Values for MadeAxis {
    fn n_samples(&self) -> usize {
        n_samples(&self.made.segments)
    }

    fn read(&self, samples: Range<usize>, out: &mut [f64]) {
        let (n, mut at, mut rest) = (self.n_samples(), samples.start, out);
        while !rest.is_empty() {
            let number = at / BLOCK;
            let width = (n - number * BLOCK).min(BLOCK);
            let own = at - number * BLOCK..(at - number * BLOCK + rest.len()).min(width);
            let block = self.made.block(number);
            let (now, later) = rest.split_at_mut(own.len());
            now.copy_from_slice(&block[self.axis * width..][own]);
            at += now.len();
            rest = later;
        }
    }
}
