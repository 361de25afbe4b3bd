//! Values that the traces plot: columns of existing load tables, or loads that are computed only for the visible samples.

use std::ops::Range;
use std::sync::{Arc, Mutex};

use crate::{
    calibration::{Calibration, Past},
    column::column,
    features::Design,
    panicked::locked,
    recording::Recording,
    scoring::series::Values,
};

#[derive(Debug)]
pub struct Segment {
    /// Index of the recording in the recording set.
    pub recording: usize,
    pub name: String,
    /// Samples of the recording, counted from the first sample of the first recording on screen.
    pub samples: Range<usize>,
    /// Difference between the recording's own clock and the common time axis of the trace panes (s).
    pub clock_offset_secs: f64,
}

/// Row-major table with one row per sample of a recording: its reference loads, or loads that a calibration computed.
#[derive(Clone, Debug)]
pub enum Table {
    Reference(Arc<Recording>),
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

/// Load of one axis in the recordings on screen, which follow one another.
#[derive(Debug)]
pub struct Columns {
    pub segments: Arc<[Segment]>,
    /// For each segment (recording on screen): the table, the position of the column in it, and the table's number of
    /// columns.
    pub columns: Vec<(Table, usize, usize)>,
}

/// Calls `take` for each segment (recording on screen) that overlaps `samples`. The arguments are the index of the segment,
/// the overlapping samples counted within the segment, and their start counted within `samples`.
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
        by_segment(&self.segments, samples, |at, samples, begin| {
            let (table, at, width) = &self.columns[at];
            let values = column(&table.values()[samples.start * width..], *width, *at);
            out[begin..][..samples.len()]
                .iter_mut()
                .zip(values)
                .for_each(|(out, value)| *out = value);
        });
    }
}

/// Number of samples whose loads are computed together, as one block.
const BLOCK: usize = 4096;
/// Maximum number of computed blocks of loads that are kept in memory. A plot that shows single samples needs fewer blocks.
const KEPT: usize = 64;

/// Loads of one block of samples: first all samples of the first axis, then of the next axis.
type Block = Arc<[f64]>;

/// Loads of recordings with more samples than fit in memory. The newest blocks of loads are kept; other blocks are computed
/// when they are read.
#[derive(Debug)]
pub struct Made {
    segments: Arc<[Segment]>,
    recordings: Vec<Arc<Recording>>,
    calibration: Calibration,
    design: Design,
    /// Earlier samples that the look-backs found in each recording; `None` for conventional loads.
    past: Option<Arc<Vec<Past>>>,
    kept: Vec<Mutex<Option<(usize, Block)>>>,
}

#[derive(Debug)]
pub struct MadeAxis {
    pub made: Arc<Made>,
    pub axis: usize,
}

impl Made {
    /// Returns the conventional loads, or the compensated loads if `past` (the earlier samples that the look-backs found) is
    /// given.
    ///
    /// For compensated loads, [`Calibration::is_quick_anywhere`] must be true: each load is then computed without the samples
    /// before it.
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
            let slot = locked(slot);
            let known = slot.as_ref().filter(|(known, _)| *known == number);
            known.map(|(_, block)| Arc::clone(block))
        };
        kept(slot).unwrap_or_else(|| {
            let block = self.make(number);
            *locked(slot) = Some((number, Arc::clone(&block)));
            block
        })
    }

    fn make(&self, number: usize) -> Block {
        let n_axes = self.calibration.axes.len();
        let start = number * BLOCK;
        let samples = start..(start + BLOCK).min(n_samples(&self.segments));
        let mut rows = vec![0.0; samples.len() * n_axes];
        by_segment(&self.segments, samples.clone(), |at, samples, begin| {
            let rows = &mut rows[begin * n_axes..(begin + samples.len()) * n_axes];
            let recording = &self.recordings[at];
            match &self.past {
                Some(past) => {
                    let past = &past[self.segments[at].recording];
                    let first = samples.start;
                    self.calibration.compensated_loads_from(
                        &self.design,
                        recording,
                        past,
                        first,
                        rows,
                    );
                }
                None => {
                    let width = recording.n_gauges();
                    let gauges = &recording.gauges()[samples.start * width..samples.end * width];
                    (self.calibration.conventional).apply_rows(gauges, width, rows);
                }
            }
        });
        (0..n_axes).flat_map(|axis| column(&rows, n_axes, axis)).collect()
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
            let of_block = at - number * BLOCK..(at - number * BLOCK + rest.len()).min(width);
            let block = self.made.block(number);
            let (now, later) = rest.split_at_mut(of_block.len());
            now.copy_from_slice(&block[self.axis * width..][of_block]);
            at += now.len();
            rest = later;
        }
    }
}
