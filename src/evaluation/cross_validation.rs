//! Leave-one-recording-out: each training recording scored by a fit to the others, from sums alone.
//!
//! Samples are never shuffled: neighbours in time know of each other, and a shuffled test would praise a fit for what it
//! has seen. With fewer than three training recordings, five contiguous blocks of them take the place of recordings.
//! The trigger of the look-back stays the conventional calibration of *all* training recordings: it only says where to
//! look, not what to answer.

use rayon::prelude::*;

use crate::calibration::{Fit, NormalEquations, Piece, Ridge, fit};
use crate::evaluation::metrics::root_mean;

/// With fewer training recordings than this, blocks are left out instead.
pub const FEWEST_RECORDINGS: usize = 3;
/// How many blocks take the place of recordings.
pub const BLOCKS: usize = 5;

/// How training recordings of these lengths are cut into parts that are left out in turn.
///
/// One list of pieces per recording. Blocks are as even as whole samples allow, the longer ones first, over all training
/// samples in order; features are those of the whole recording, only sums are cut.
#[must_use]
pub fn folds(n_samples: &[usize]) -> Vec<Vec<Piece>> {
    if n_samples.len() >= FEWEST_RECORDINGS {
        return n_samples
            .iter()
            .enumerate()
            .map(|(fold, &n)| {
                vec![Piece {
                    samples: 0..n,
                    fold,
                }]
            })
            .collect();
    }
    let total: usize = n_samples.iter().sum();
    let (even, longer) = (total / BLOCKS, total % BLOCKS);
    let starts: Vec<usize> = (0..=BLOCKS)
        .map(|block| block * even + block.min(longer))
        .collect();
    let mut first = 0;
    n_samples
        .iter()
        .map(|&n| {
            let own = first..first + n;
            first += n;
            starts
                .windows(2)
                .enumerate()
                .map(|(fold, block)| Piece {
                    samples: block[0].max(own.start)..block[1].min(own.end),
                    fold,
                })
                .filter(|piece| !piece.samples.is_empty())
                .map(|piece| Piece {
                    samples: piece.samples.start - own.start..piece.samples.end - own.start,
                    ..piece
                })
                .collect()
        })
        .collect()
}

/// Sums of squared errors of each part, per axis, each part predicted by what `solve` makes of the others' sums.
///
/// One entry per part that holds samples; `None` with fewer than two of them.
#[must_use]
pub fn left_out_squares(
    total: &NormalEquations,
    parts: &[NormalEquations],
    solve: impl Fn(&NormalEquations) -> Fit + Sync,
) -> Option<Vec<Vec<f64>>> {
    let parts: Vec<_> = parts.iter().filter(|part| part.n_samples() > 0).collect();
    (parts.len() > 1).then(|| {
        parts
            .par_iter()
            .map(|part| part.squared_residuals(&solve(&total.without(part)).coefficients))
            .collect()
    })
}

/// Root mean squared error per axis over all parts, each predicted by what `solve` makes of the others' sums.
///
/// `None` with fewer than two parts that hold samples.
#[must_use]
pub fn cross_validate(
    total: &NormalEquations,
    parts: &[NormalEquations],
    solve: impl Fn(&NormalEquations) -> Fit + Sync,
) -> Option<Vec<f64>> {
    let squares = left_out_squares(total, parts, solve)?;
    root_mean(&summed(&squares, total.n_targets()), total.n_samples())
}

fn summed(parts: &[Vec<f64>], n_axes: usize) -> Vec<f64> {
    (0..n_axes)
        .map(|axis| parts.iter().map(|part| part[axis]).sum())
        .collect()
}

/// Strengths of the ridge that are tried: none, ever stronger ones, and one that leaves nothing but the conventional
/// calibration.
pub const RIDGE_STRENGTHS: [f64; 12] = [
    0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 10.0, 1e9,
];

/// For each axis the strength of the ridge on the marked columns that left-out parts ask for: the strongest one that
/// does no worse than the best within one standard error over the parts.
///
/// The error is that of the difference to the best, part by part, of the sums of squares. So where the parts disagree
/// about what the blocks bring, the answer stays near the conventional calibration. With fewer than two parts nothing
/// can be compared, and all strengths are zero. Scores of cross-validation with the strengths chosen by it are slightly
/// too good: one number per axis was fitted to all parts.
#[must_use]
pub fn choose_ridge(
    total: &NormalEquations,
    parts: &[NormalEquations],
    used: &[usize],
    columns: &[bool],
) -> Vec<f64> {
    let n_axes = total.n_targets();
    let squares: Option<Vec<Vec<Vec<f64>>>> = RIDGE_STRENGTHS
        .iter()
        .map(|&strength| {
            let ridge = Ridge::Relative { strength, columns };
            left_out_squares(total, parts, |sums| fit(sums, used, ridge))
        })
        .collect();
    let Some(squares) = squares else {
        return vec![0.0; n_axes];
    };
    (0..n_axes)
        .map(|axis| {
            let n_parts = squares[0].len();
            RIDGE_STRENGTHS[strongest_good(n_parts, |at, part| squares[at][part][axis])]
        })
        .collect()
}

/// The position of the strongest ridge whose squared errors exceed those of the best by no more than one standard error
/// of the difference over the parts; `square(at, part)` is the sum of squares of a part at a strength.
pub(crate) fn strongest_good(n_parts: usize, square: impl Fn(usize, usize) -> f64) -> usize {
    let tried = 0..RIDGE_STRENGTHS.len();
    let sum = |at: usize| (0..n_parts).map(|part| square(at, part)).sum::<f64>();
    let best = tried
        .clone()
        .min_by(|a, b| sum(*a).total_cmp(&sum(*b)))
        .unwrap_or(0);
    let chosen = tried.rev().find(|&at| {
        let differences = (0..n_parts).map(|part| square(at, part) - square(best, part));
        let (mean, error) = mean_and_standard_error(differences);
        mean <= error
    });
    chosen.unwrap_or(best)
}

/// The mean of some values and its standard error; zero for a single value.
fn mean_and_standard_error(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    let squares: f64 = values.map(|value| (value - mean).powi(2)).sum();
    let variance = squares / (n - 1.0).max(1.0);
    (mean, (variance / n).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(pieces: &[Vec<Piece>]) -> Vec<Vec<(std::ops::Range<usize>, usize)>> {
        pieces
            .iter()
            .map(|pieces| {
                pieces
                    .iter()
                    .map(|piece| (piece.samples.clone(), piece.fold))
                    .collect()
            })
            .collect()
    }

    #[test]
    fn three_recordings_are_left_out_whole() {
        assert_eq!(
            samples(&folds(&[4, 5, 6])),
            [vec![(0..4, 0)], vec![(0..5, 1)], vec![(0..6, 2)]]
        );
    }

    #[test]
    fn one_or_two_recordings_are_left_out_by_five_blocks() {
        assert_eq!(
            samples(&folds(&[12])),
            [vec![
                (0..3, 0),
                (3..6, 1),
                (6..8, 2),
                (8..10, 3),
                (10..12, 4)
            ]]
        );
        assert_eq!(
            samples(&folds(&[5, 5])),
            [
                vec![(0..2, 0), (2..4, 1), (4..5, 2)],
                vec![(0..1, 2), (1..3, 3), (3..5, 4)]
            ]
        );
        assert_eq!(samples(&folds(&[2])), [vec![(0..1, 0), (1..2, 1)]]);
    }

    /// A mean fitted without the part: parts {0, 0} and {3} are scored by 3 and by 0, so every error is 3.
    #[test]
    fn a_left_out_part_takes_no_part_in_its_fit() {
        let part = |values: &[f64]| {
            let mut sums = NormalEquations::new(1, 1);
            for value in values {
                let mut row = vec![0.0; sums.stride()];
                row[..2].copy_from_slice(&[1.0, *value]);
                sums.add_rows(&row);
            }
            sums
        };
        let parts = [part(&[0.0, 0.0]), part(&[3.0])];
        let mut total = parts[0].clone();
        total.add(&parts[1]);
        let solve = |sums: &NormalEquations| fit(sums, &[0], Ridge::None);
        let rmse = cross_validate(&total, &parts, solve).unwrap();
        assert!((rmse[0] - 3.0).abs() < 1e-12);
        assert_eq!(cross_validate(&total, &parts[..1], solve), None);
    }

    /// Six parts whose target is the first column; the second is noise with another sign in every part.
    #[test]
    fn the_ridge_is_strong_where_the_columns_only_memorise() {
        let part = |sign: f64, useful: f64| {
            let mut sums = NormalEquations::new(1, 1);
            for k in 0..20 {
                let x = (f64::from(k) * 0.7).sin();
                let mut row = vec![0.0; sums.stride()];
                row[..2].copy_from_slice(&[x, (useful + sign) * x]);
                sums.add_rows(&row);
            }
            sums
        };
        let strength = |useful: f64| {
            let signs = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
            let parts = signs.map(|sign| part(0.1 * sign, useful));
            let mut total = NormalEquations::new(1, 1);
            parts.iter().for_each(|part| total.add(part));
            choose_ridge(&total, &parts, &[0], &[true])[0]
        };
        assert_eq!(strength(0.0), 1e9);
        assert!(strength(10.0) < 0.1);
    }
}
