//! Samples of one recording for the error budget, and the units and blocks into which they are divided.

use std::ops::Range;

use crate::calibration::NormalEquations;

/// Number of rows whose products are summed together.
const ROWS: usize = 256;
/// Maximum number of blocks of a unit.
const BLOCKS: usize = 8;
/// Minimum number of samples of a block, unless the whole unit is shorter.
const FEWEST_SAMPLES: usize = 10;
/// Minimum length of a block, as a multiple of the time in which the load changes.
const CHANGES: f64 = 2.0;
/// Number of segments that take the place of recordings, if there is one recording or if there are two.
const SEGMENTS: [usize; 2] = [4, 3];

/// Samples of one recording. All recordings of a budget have equal numbers of gauges, axes and auxiliary channels.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// Number of samples.
    pub n_samples: usize,
    /// Gauges, `n_samples × n_gauges` row-major.
    pub gauges: &'a [f64],
    /// Reference loads, `n_samples × n_axes` row-major.
    pub loads: &'a [f64],
    /// Auxiliary channels, `n_samples × n_auxiliary` row-major.
    pub auxiliary: &'a [f64],
    /// Number of the cross-validation part that contains this recording.
    pub part: usize,
    /// False if the order of the rows takes the place of times, so that nothing is known about speeds.
    pub has_times: bool,
}

/// Function that writes the model's columns of the next sample, given the number of the sample.
pub type ColumnStream<'a> = Box<dyn FnMut(usize, &mut [f64]) + 'a>;

/// Columns that a compensated calibration adds to the gauges.
#[derive(Clone, Copy)]
pub struct Model<'a> {
    /// Number of the columns.
    pub n_columns: usize,
    /// Ridge on these columns, per sample.
    pub ridge: f64,
    /// Returns the columns of a run from its first sample on, as the calibration computes them after a cold start.
    pub stream: &'a (dyn Fn(usize) -> ColumnStream<'a> + Sync),
}

/// Contiguous samples of one recording that cross-validation leaves out together: the whole recording, or a segment if there
/// are fewer than three recordings.
#[derive(Debug)]
pub struct Unit {
    pub run: usize,
    pub samples: Range<usize>,
    pub part: usize,
    /// Number of the first block of this unit among the blocks of all units.
    pub first_block: usize,
    /// Contiguous blocks, which together are the samples of the unit.
    pub blocks: Vec<Range<usize>>,
}

impl Unit {
    /// Divides the runs into units. `change_samples` is the number of samples in which the load changes, and `most_blocks`
    /// the number of blocks for which there is memory.
    pub fn all(runs: &[Run<'_>], change_samples: f64, most_blocks: usize) -> Vec<Self> {
        let of_run = SEGMENTS.get(runs.len() - 1).copied();
        let most = (most_blocks / runs.len()).clamp(1, BLOCKS);
        let mut units: Vec<Self> = Vec::new();
        for (at, run) in runs.iter().enumerate() {
            let segments = of_run.unwrap_or(1).min(run.n_samples);
            for samples in split(&(0..run.n_samples), segments) {
                let least = FEWEST_SAMPLES.max((CHANGES * change_samples) as usize);
                let blocks = split(&samples, (samples.len() / least).clamp(1, most));
                let first_block = units.last().map_or(0, |own| own.first_block + own.blocks.len());
                let part = if of_run.is_some() { units.len() } else { run.part };
                units.push(Self { run: at, samples, part, first_block, blocks });
            }
        }
        units
    }

    /// Returns the numbers of the unit's blocks among the blocks of all units.
    pub fn block_numbers(&self) -> Range<usize> {
        self.first_block..self.first_block + self.blocks.len()
    }

    /// Returns the time of a sample, from -1 at the start of the unit to 1 at its end.
    pub fn time(&self, sample: usize) -> f64 {
        let last = (self.samples.len() - 1).max(1) as f64;
        2.0 * (sample - self.samples.start) as f64 / last - 1.0
    }
}

/// Splits a range into contiguous ranges, whose lengths differ by at most one; the first ones are longer.
fn split(samples: &Range<usize>, count: usize) -> Vec<Range<usize>> {
    let (even, longer) = (samples.len() / count, samples.len() % count);
    let start = |at: usize| samples.start + at * even + at.min(longer);
    (0..count).map(|at| start(at)..start(at + 1)).collect()
}

/// Adds the rows of all samples of a recording. `write` writes the row of one sample.
pub fn add_run(
    sums: &mut NormalEquations,
    n_samples: usize,
    mut write: impl FnMut(usize, &mut [f64]),
) {
    let stride = sums.stride();
    let mut rows = vec![0.0; ROWS * stride];
    for first in (0..n_samples).step_by(ROWS) {
        let rows = &mut rows[..ROWS.min(n_samples - first) * stride];
        (first..).zip(rows.chunks_exact_mut(stride)).for_each(|(sample, row)| write(sample, row));
        sums.add_rows(rows);
    }
}
