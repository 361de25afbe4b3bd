//! Leave-one-recording-out: each training recording scored by a fit to the others, from sums alone.
//!
//! Samples are never shuffled: neighbours in time know of each other, and a shuffled test would praise a fit for what it
//! has seen. With fewer than three training recordings, five contiguous blocks of them take the place of recordings.
//! The trigger of the look-back stays the conventional calibration of *all* training recordings: it only says where to
//! look, not what to answer.

use rayon::prelude::*;

use crate::calibration::{NormalEquations, Piece, fit};
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

/// Root mean squared error per axis over all parts, each predicted by a fit to the others.
///
/// `None` with fewer than two parts that hold samples.
#[must_use]
pub fn cross_validate(
    total: &NormalEquations,
    parts: &[NormalEquations],
    used: &[usize],
) -> Option<Vec<f64>> {
    let parts: Vec<_> = parts.iter().filter(|part| part.n_samples() > 0).collect();
    if parts.len() < 2 {
        return None;
    }
    let squares = parts
        .par_iter()
        .map(|part| part.squared_residuals(&fit(&total.without(part), used).coefficients))
        .collect::<Vec<_>>()
        .into_iter()
        .reduce(|sum, part| sum.iter().zip(part).map(|(a, b)| a + b).collect())?;
    root_mean(&squares, total.n_samples())
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
        let rmse = cross_validate(&total, &parts, &[0]).unwrap();
        assert!((rmse[0] - 3.0).abs() < 1e-12);
        assert_eq!(cross_validate(&total, &parts[..1], &[0]), None);
    }
}
