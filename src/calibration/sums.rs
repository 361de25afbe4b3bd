//! The one pass: a recording and its past samples become sums.
//!
//! Columns are those of the [`Design`], standardised; targets are what the conventional calibration leaves over,
//! `L − L_conv`. The residual instead of the load: small numbers keep their digits in `YᵀY − …`, and solving for a
//! correction refines the conventional solution on the way.

use std::ops::Range;

use rayon::prelude::*;

use crate::calibration::{NormalEquations, PresentLoads};
use crate::features::{Design, FeatureStream};
use crate::progress::Progress;
use crate::recording::Recording;

/// A run of samples whose sums are kept apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The samples, within one recording.
    pub samples: Range<usize>,
    /// The part that cross-validation leaves out with them.
    pub fold: usize,
}

/// Samples whose sums one thread makes at a time, however many threads there are.
const RUN: usize = 1 << 18;
/// Rows that are filled before they are multiplied.
pub(super) const BLOCK: usize = 128;

/// The sums of each piece of a recording, in the order of `pieces`, which must follow each other without a gap from
/// the first sample on: the blocks' memory runs through them. Once somebody has asked to stop, samples are missing.
///
/// **Shapes** `past` holds one index per sample for each look-back; targets are `L − conventional`.
///
/// # Panics
/// If the recording has no reference, or a piece reaches beyond it.
pub fn recording_sums(
    design: &Design,
    conventional: PresentLoads<'_>,
    past: &[Vec<u32>],
    pieces: &[Piece],
    progress: &Progress,
) -> Vec<NormalEquations> {
    let recording = conventional.recording;
    let n_axes = recording.axes().len();
    let n_columns = design.n_columns();
    let add = |stream: &mut FeatureStream<'_>, samples: Range<usize>| {
        let mut sums = NormalEquations::new(n_columns, n_axes);
        let stride = sums.stride();
        let mut rows = vec![0.0; BLOCK * stride];
        if progress.is_cancelled() {
            return sums;
        }
        for start in samples.clone().step_by(BLOCK) {
            let samples = start..(start + BLOCK).min(samples.end);
            let rows = &mut rows[..samples.len() * stride];
            for (k, row) in samples.zip(rows.chunks_exact_mut(stride)) {
                let (features, targets) = row.split_at_mut(n_columns);
                sample_row(stream, recording, |at| past[at][k], k, features);
                design.standardise(features);
                residual(conventional, k, &mut targets[..n_axes]);
            }
            sums.add_rows(rows);
        }
        sums
    };
    if design.features.has_memory() {
        let mut stream = FeatureStream::of(design, recording);
        let pieces = pieces.iter();
        return pieces
            .map(|piece| add(&mut stream, piece.samples.clone()))
            .collect();
    }
    // Nothing runs from sample to sample, so that threads can share even one long recording.
    let runs_of = |piece: &Piece| {
        let Range { start, end } = piece.samples;
        (start..end.max(start + 1))
            .step_by(RUN)
            .map(move |from| from..(from + RUN).min(end).max(from))
            .collect::<Vec<_>>()
    };
    pieces
        .par_iter()
        .map(|piece| {
            let runs = runs_of(piece).into_par_iter();
            let sums: Vec<NormalEquations> = runs
                .map(|samples| add(&mut FeatureStream::new(design), samples))
                .collect();
            let (first, others) = sums.split_first().expect("a piece has one run at least");
            let mut sums = first.clone();
            others.iter().for_each(|run| sums.add(run));
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
    let (time, auxiliary) = (recording.times()[k], recording.auxiliary().at(k));
    stream.raw_row(time, recording.gauges_at(k), auxiliary, past, row);
}

/// Writes what `known` loads leave over of the reference at sample `k`.
#[inline]
pub(super) fn residual(known: PresentLoads<'_>, k: usize, out: &mut [f64]) {
    known.row(k, out);
    let loads = &known.recording.loads()[k * out.len()..];
    for (out, load) in out.iter_mut().zip(loads) {
        *out = load - *out;
    }
}
