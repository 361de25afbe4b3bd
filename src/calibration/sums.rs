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
use crate::recording::{AuxiliaryTable, Recording};

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
    let (from, reference) = (RowsOf::of(recording), recording.loads());
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
                from.standardised_row(stream, |at| past[at][k], k, features);
                residual(reference, conventional, k, &mut targets[..n_axes]);
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

/// The samples of a recording, as rows are made of them.
#[derive(Clone, Copy)]
pub(crate) struct RowsOf<'a> {
    times: &'a [f64],
    gauges: &'a [f64],
    n_gauges: usize,
    auxiliary: &'a AuxiliaryTable,
}

impl<'a> RowsOf<'a> {
    pub fn of(recording: &'a Recording) -> Self {
        Self {
            times: recording.times(),
            gauges: recording.gauges(),
            n_gauges: recording.n_gauges(),
            auxiliary: recording.auxiliary(),
        }
    }

    #[inline]
    fn gauges_at(&self, k: usize) -> &'a [f64] {
        &self.gauges[k * self.n_gauges..][..self.n_gauges]
    }

    /// Writes the raw row of sample `k`, whose past sample by look-back i is `past(i)`; samples must come in order.
    #[inline]
    pub fn raw_row(
        &self,
        stream: &mut FeatureStream<'_>,
        past: impl Fn(usize) -> u32,
        k: usize,
        row: &mut [f64],
    ) {
        let past = |look_back| self.gauges_at(past(look_back) as usize);
        let (time, auxiliary) = (self.times[k], self.auxiliary.at(k));
        stream.raw_row(time, self.gauges_at(k), auxiliary, past, row);
    }

    /// [`Self::raw_row`], standardised.
    #[inline]
    pub fn standardised_row(
        &self,
        stream: &mut FeatureStream<'_>,
        past: impl Fn(usize) -> u32,
        k: usize,
        row: &mut [f64],
    ) {
        let past = |look_back| self.gauges_at(past(look_back) as usize);
        let (time, auxiliary) = (self.times[k], self.auxiliary.at(k));
        stream.standardised_row(time, self.gauges_at(k), auxiliary, past, row);
    }
}

/// Writes what `known` loads leave over of the `reference` of a recording at sample `k`.
#[inline]
pub(super) fn residual(reference: &[f64], known: PresentLoads<'_>, k: usize, out: &mut [f64]) {
    let n_axes = out.len();
    let loads = &reference[k * n_axes..][..n_axes];
    match known.kept {
        Some(kept) => {
            let kept = &kept[k * n_axes..][..n_axes];
            for ((out, load), kept) in out.iter_mut().zip(loads).zip(kept) {
                *out = load - kept;
            }
        }
        None => {
            known.row(k, out);
            for (out, load) in out.iter_mut().zip(loads) {
                *out = load - *out;
            }
        }
    }
}
