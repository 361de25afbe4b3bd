//! The one pass: a recording and its past samples become sums.
//!
//! Columns are those of the [`Design`], standardised; targets are what the conventional calibration leaves over,
//! `L − L_conv`. The residual instead of the load: small numbers keep their digits in `YᵀY − …`, and solving for a
//! correction refines the conventional solution on the way.

use std::ops::Range;

use crate::calibration::NormalEquations;
use crate::features::{Design, FeatureStream};
use crate::recording::Recording;

/// A run of samples whose sums are kept apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The samples, within one recording.
    pub samples: Range<usize>,
    /// The part that cross-validation leaves out with them.
    pub fold: usize,
}

/// Rows that are filled before they are multiplied.
pub(super) const BLOCK: usize = 128;

/// The sums of each piece of a recording, in the order of `pieces`, which must follow each other without a gap from
/// the first sample on: the blocks' memory runs through them.
///
/// **Shapes** `conventional` is `n × n_axes` row-major, `past` one index per sample for each look-back; targets are
/// `L − conventional`.
///
/// # Panics
/// If the recording has no reference, or a piece reaches beyond it.
pub fn recording_sums(
    recording: &Recording,
    design: &Design,
    conventional: &[f64],
    past: &[Vec<u32>],
    pieces: &[Piece],
) -> Vec<NormalEquations> {
    let n_axes = recording.axes().len();
    let n_columns = design.n_columns();
    let mut stream = FeatureStream::of(design, recording);
    let mut rows = Vec::new();
    pieces
        .iter()
        .map(|piece| {
            let mut sums = NormalEquations::new(n_columns, n_axes);
            let stride = sums.stride();
            rows.resize(BLOCK * stride, 0.0);
            for start in piece.samples.clone().step_by(BLOCK) {
                let samples = start..(start + BLOCK).min(piece.samples.end);
                let rows = &mut rows[..samples.len() * stride];
                for (k, row) in samples.zip(rows.chunks_exact_mut(stride)) {
                    let (features, targets) = row.split_at_mut(n_columns);
                    sample_row(&mut stream, recording, |at| past[at][k], k, features);
                    design.standardise(features);
                    residual(recording, conventional, k, &mut targets[..n_axes]);
                }
                sums.add_rows(rows);
            }
            sums
        })
        .collect()
}

/// Writes the raw row of sample `k`, whose past sample by look-back i is `past(i)`; samples must come in order.
#[inline]
pub(crate) fn sample_row(
    stream: &mut FeatureStream<'_>,
    recording: &Recording,
    past: impl Fn(usize) -> u32,
    k: usize,
    row: &mut [f64],
) {
    let past = |look_back| recording.gauges_at(past(look_back) as usize);
    stream.raw_row(recording.times()[k], recording.gauges_at(k), past, row);
}

/// Writes what `known` loads leave over of the reference at sample `k`.
#[inline]
pub(super) fn residual(recording: &Recording, known: &[f64], k: usize, out: &mut [f64]) {
    let at = k * out.len();
    let loads = &recording.loads()[at..];
    for ((out, load), known) in out.iter_mut().zip(loads).zip(&known[at..]) {
        *out = load - known;
    }
}
