//! Normal equations of a recording with its look-backs, computed in one pass.
//!
//! The columns are the standardised feature columns of the [`Design`]. The targets are the residuals of the conventional
//! calibration, `L − L_conv`. Residuals are small, so differences such as `YᵀY − …` lose few digits.

use std::ops::Range;

use rayon::prelude::*;

use crate::{
    calibration::{linear_map::PresentLoads, normal_equations::NormalEquations},
    features::{Design, FeatureStream},
    lanes,
    progress::Progress,
    recording::{AuxiliaryTable, Recording},
};

/// Range of samples of one recording for which separate sums are computed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    pub samples: Range<usize>,
    /// Index of the cross-validation part to which these samples belong. All samples of a part are left out together.
    pub fold: usize,
}

/// Number of samples whose sums one thread computes at a time. It is constant, so the number of threads does not change the
/// result.
const RUN: usize = 1 << 18;
/// Number of feature rows that are computed before their products are summed.
const BLOCK: usize = 128;

/// Sums over samples, to which blocks of feature rows are added.
pub(super) trait TakesRows: Send {
    fn add_rows(&mut self, rows: &[f64], classes: &[usize]);

    fn add(&mut self, other: &Self);
}

impl TakesRows for NormalEquations {
    fn add_rows(&mut self, rows: &[f64], _: &[usize]) {
        Self::add_rows(self, rows);
    }

    fn add(&mut self, other: &Self) {
        Self::add(self, other);
    }
}

/// Pass over a recording that computes feature rows and adds their products to sums.
pub(super) struct Pass<'a> {
    pub design: &'a Design,
    /// Loads that are subtracted from the reference to give the targets.
    pub conventional: PresentLoads<'a>,
    /// For each look-back, the index of the earlier sample that it finds for each sample; its own index if none.
    pub past: Vec<&'a [u32]>,
    /// True if all states start anew at each piece, as if the recording were cut there.
    pub is_cold: bool,
    /// Factors with which the rows fade in, see [`FeatureStream::share`]; empty without a fade.
    pub fade: &'a [Vec<f64>],
    pub progress: &'a Progress,
}

impl Pass<'_> {
    /// Returns the sums of each piece of the recording. The pieces must cover the recording without gaps from its first
    /// sample on, because the states of the feature blocks need every sample. After cancellation, samples are missing in the
    /// sums.
    ///
    /// `class` returns the class of the sums to which a sample is added, or `None` to skip it. A skipped sample keeps its
    /// place in the blocks of rows. So the result can be added to sums in which the columns of these samples are zero,
    /// without other rounding errors.
    pub fn sums<T: TakesRows>(
        &self,
        pieces: &[Piece],
        empty: impl Fn() -> T + Sync,
        class: impl Fn(usize, &[&[u32]]) -> Option<usize> + Copy + Sync,
    ) -> Vec<T> {
        let cold: Vec<Vec<u32>>;
        let mut past = self.past.clone();
        if self.is_cold {
            cold = past.iter().map(|past| cold_past(past, pieces)).collect();
            past = cold.iter().map(Vec::as_slice).collect();
        }
        let (design, recording) = (self.design, self.conventional.recording);
        let stride = NormalEquations::stride_of(design.n_columns() + recording.axes().len());
        let add = |stream: &mut FeatureStream<'_>, samples: Range<usize>| {
            let mut sums = empty();
            if self.progress.is_cancelled() {
                return sums;
            }
            let mut block = Block {
                stride,
                rows: vec![0.0; BLOCK * stride],
                kept: Vec::with_capacity(BLOCK),
                classes: Vec::with_capacity(BLOCK),
            };
            for start in samples.clone().step_by(BLOCK) {
                let samples = start..(start + BLOCK).min(samples.end);
                let (stream, past, filled) = (&mut *stream, &past[..], &mut block);
                pulp::Arch::new().dispatch(
                    #[inline(always)]
                    move || self.fill(stream, (past, samples), class, filled),
                );
                sums.add_rows(&block.rows[..block.classes.len() * stride], &block.classes);
            }
            sums
        };
        if design.features.has_memory() {
            let start = || FeatureStream::new(design).fading(self.fade);
            let mut stream = start();
            let sums = pieces.iter().map(|piece| {
                if self.is_cold {
                    stream = start();
                }
                add(&mut stream, piece.samples.clone())
            });
            return sums.collect();
        }
        // No feature has a state that depends on earlier samples, so several threads can share one long recording.
        let of_piece = |piece: &Piece| {
            let Range { start, end } = piece.samples;
            let runs = (start..end.max(start + 1)).into_par_iter().step_by(RUN).map(|from| {
                add(&mut FeatureStream::new(design), from..(from + RUN).min(end).max(from))
            });
            let mut sums = runs.collect::<Vec<T>>().into_iter();
            let mut all = sums.next().expect("a piece has at least one run");
            sums.for_each(|run| all.add(&run));
            all
        };
        pieces.par_iter().map(of_piece).collect()
    }

    #[inline(always)]
    fn fill(
        &self,
        stream: &mut FeatureStream<'_>,
        (past, samples): (&[&[u32]], Range<usize>),
        class: impl Fn(usize, &[&[u32]]) -> Option<usize>,
        block: &mut Block,
    ) {
        let (design, conventional) = (self.design, self.conventional);
        let recording = conventional.recording;
        let (from, reference) = (RowsOf::of(recording), recording.loads());
        let (n_columns, n_axes) = (design.n_columns(), recording.axes().len());
        let has_memory = design.features.has_memory();
        let Block { stride, rows, kept, classes } = block;
        let stride = *stride;
        kept.clear();
        classes.clear();
        for k in samples {
            // Feature blocks with a state need every sample, so samples without a class are kept in the block of rows at
            // first.
            if let Some(class) = class(k, past).or(has_memory.then_some(NONE)) {
                kept.push(k);
                classes.push(class);
            }
        }
        let rows = &mut rows[..kept.len() * stride];
        stream.standardised_rows(
            kept,
            from.times,
            |k| from.gauges_at(k),
            |k| from.auxiliary.at(k),
            |look_back, k| from.gauges_at(past[look_back][k] as usize),
            (rows, stride),
        );
        for (row, k) in rows.chunks_exact_mut(stride).zip(&*kept) {
            residual(reference, conventional, *k, &mut row[n_columns..][..n_axes]);
        }
        if classes.contains(&NONE) {
            let of_some = |at: &usize| classes[*at] != NONE;
            let wanted = (0..classes.len()).filter(of_some).enumerate();
            wanted
                .for_each(|(to, at)| rows.copy_within(at * stride..(at + 1) * stride, to * stride));
            classes.retain(|class| *class != NONE);
        }
    }
}

/// Feature rows whose products are summed together.
struct Block {
    stride: usize,
    rows: Vec<f64>,
    kept: Vec<usize>,
    classes: Vec<usize>,
}

/// Marks a sample that is left out of all sums of products. Other samples have the index of their sum.
const NONE: usize = usize::MAX;

/// Returns the normal equations of each piece of the recording; see [`Pass::sums`]. Panics if the recording has no reference
/// load, or if a piece ends after its last sample. With factors of a `fade`, each row is multiplied by its share, so the sums give
/// the errors of loads that fade in from the conventional load.
pub fn recording_sums(
    design: &Design,
    conventional: PresentLoads<'_>,
    past: &[Vec<u32>],
    pieces: &[Piece],
    is_cold: bool,
    fade: &[Vec<f64>],
    progress: &Progress,
) -> Vec<NormalEquations> {
    let n_axes = conventional.recording.axes().len();
    let past = past.iter().map(Vec::as_slice).collect();
    let pass = Pass { design, conventional, past, is_cold, fade, progress };
    let empty = || NormalEquations::new(design.n_columns(), n_axes);
    pass.sums(pieces, empty, |_, _| Some(0))
}

/// Returns for each sample the index of its earlier sample (found by the look-back). A sample gets its own index if its
/// earlier sample lies before the start of its piece of the recording.
fn cold_past(past: &[u32], pieces: &[Piece]) -> Vec<u32> {
    let of_piece = |piece: &Piece| {
        let start = piece.samples.start as u32;
        let samples = piece.samples.clone();
        samples.map(move |k| if past[k] < start { k as u32 } else { past[k] })
    };
    pieces.iter().flat_map(of_piece).collect()
}

/// Samples of a recording, from which feature rows are computed.
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

    #[inline(always)]
    fn gauges_at(&self, k: usize) -> &'a [f64] {
        &self.gauges[k * self.n_gauges..][..self.n_gauges]
    }

    /// Writes the raw feature row of sample `k`. `past(i)` is the index of the earlier sample that look-back i found for it.
    /// Samples must come in order.
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
}

/// Writes the residual of sample `k`: its reference load minus the `known` load.
#[inline(always)]
fn residual(reference: &[f64], known: PresentLoads<'_>, k: usize, out: &mut [f64]) {
    let n_axes = out.len();
    let loads = &reference[k * n_axes..][..n_axes];
    match known.kept {
        Some(kept) => {
            let kept = &kept[k * n_axes..][..n_axes];
            lanes::write(out, [loads, kept], |[load, kept]| load - kept);
        }
        None => {
            known.row(k, out);
            for (out, load) in out.iter_mut().zip(loads) {
                *out = load - *out;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::conventional::Conventional;
    use crate::calibration::linear_map::loads_from_gauges;
    use crate::calibration::past_samples;
    use crate::features::{Blocks, Creep, FeatureSettings, FixedLag, LoadPath, Play, Thresholds};
    use crate::recording::simulated;

    /// The sums of cold pieces equal those of recordings that are cut at the same samples.
    #[test]
    fn cold_pieces_are_recordings_of_their_own() {
        let set = simulated::recordings(3);
        let recording = set.entries()[1].recording.decimated(2);
        let conventional = Conventional::fit(&[&recording], true, &Progress::default());
        let blocks = Blocks::default().with(&Creep, &[3.0]).with(&Play, &[0.3, 1.2]);
        let features = FeatureSettings {
            look_backs: vec![Thresholds { f_th: 2.0, t_th_secs: 5.0 }],
            blocks: blocks.with(&FixedLag, &[0.7]),
            ..FeatureSettings::present()
        };
        let design = Design {
            features,
            scale: conventional.scale.clone(),
            offset: true,
            history_step_secs: 0.0,
        };
        let weights = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
        let of = |recording: &Recording, pieces: &[Piece], is_cold: bool| {
            let loads = loads_from_gauges(&conventional.map, recording);
            let path = LoadPath::new(&loads, &weights);
            let past = past_samples(&design.features, &path, recording, &Progress::default());
            let present = PresentLoads { map: &conventional.map, recording, kept: Some(&loads) };
            recording_sums(&design, present, &past, pieces, is_cold, &[], &Progress::default())
        };
        let n = recording.n_samples();
        let cuts = [0, n / 3, n / 2, n];
        let pieces: Vec<Piece> = (cuts.windows(2).enumerate())
            .map(|(fold, cut)| Piece { samples: cut[0]..cut[1], fold })
            .collect();
        let (cold, warm) = (of(&recording, &pieces, true), of(&recording, &pieces, false));
        for (piece, cold) in pieces.iter().zip(&cold) {
            let segment = recording.segment(piece.samples.clone());
            let whole = Piece { samples: 0..segment.n_samples(), fold: 0 };
            let expected = &of(&segment, &[whole], false)[0];
            for column in 0..design.n_columns() {
                let [actual, expected] =
                    [cold, expected].map(|sums| sums.feature_product(column, column));
                assert!((actual - expected).abs() <= 1e-9 * expected.abs(), "column {column}");
            }
        }
        assert_ne!(cold[1], warm[1]);
        assert_eq!(cold[0], warm[0]);
    }
}
