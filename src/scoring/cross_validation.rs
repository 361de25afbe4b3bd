//! Cross-validation by group: how training recordings are cut, and which ridge the parts ask for. The fits to what remains
//! are those of [`LeftOut`](crate::scoring::left_out::LeftOut).
//!
//! Samples are never shuffled: neighbours in time know of each other, and a shuffled test would praise a fit for what it
//! has seen. So do recordings of one group (see [`Groups`](crate::recording::Groups)), which are left out together; where
//! nothing is grouped, each recording is a group. Two groups are enough where there are more recordings: each is then
//! predicted by the other, which is hard on the fit and never flatters it. With fewer than three training recordings, five
//! contiguous blocks of them take the place of groups.
//! The trigger of the look-back stays the conventional calibration of *all* training recordings: it only says where to
//! look, not what to answer.

use crate::calibration::{Piece, simplest_good};

/// With fewer training recordings than this, blocks are left out instead.
pub const FEWEST_RECORDINGS: usize = 3;
/// How many blocks take the place of recordings.
pub const BLOCKS: usize = 5;

/// How training recordings of these lengths and groups are cut into parts that are left out in turn.
///
/// One list of pieces per recording; groups are numbered anew as they come. Blocks are as even as whole samples allow, the longer ones first, over all training
/// samples in order; features are those of the whole recording, only sums are cut.
///
/// # Panics
/// If the lists differ in length.
pub fn folds(n_samples: &[usize], groups: &[usize]) -> Vec<Vec<Piece>> {
    assert_eq!(n_samples.len(), groups.len());
    if are_left_out_whole(groups) {
        let mut seen = Vec::new();
        let recordings = n_samples.iter().zip(groups);
        return recordings
            .map(|(&n, group)| {
                let known = seen.iter().position(|own| *own == group);
                let fold = known.unwrap_or_else(|| {
                    seen.push(group);
                    seen.len() - 1
                });
                vec![Piece { samples: 0..n, fold }]
            })
            .collect();
    }
    let total: usize = n_samples.iter().sum();
    let (even, longer) = (total / BLOCKS, total % BLOCKS);
    let starts: Vec<usize> = (0..=BLOCKS).map(|block| block * even + block.min(longer)).collect();
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

/// Maximum number of fits that leave parts out, where a fit takes too long to do without each part alone.
pub(crate) const MOST_FITS: usize = 5;

/// Returns the number of the fit that does without a part, where no more than [`MOST_FITS`] are made.
pub(crate) fn fit_without(part: usize, n_parts: usize) -> usize {
    part % n_parts.min(MOST_FITS)
}

/// Whether training recordings of these groups are left out whole, rather than blocks of them.
pub fn are_left_out_whole(groups: &[usize]) -> bool {
    groups.len() >= FEWEST_RECORDINGS && groups.iter().any(|group| *group != groups[0])
}

/// Strengths of the ridge that are tried: none, ever stronger ones, and one that leaves nothing but the conventional
/// calibration.
pub const RIDGE_STRENGTHS: [f64; 12] =
    [0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 10.0, 1e9];

/// The position of the strongest ridge whose squared errors over the parts are nearly the lowest; `square(at, part)` is the sum of squares of a part at a strength.
pub(crate) fn strongest_good(n_parts: usize, square: impl Fn(usize, usize) -> f64) -> usize {
    simplest_good(RIDGE_STRENGTHS.len(), n_parts, square)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(pieces: &[Vec<Piece>]) -> Vec<Vec<(std::ops::Range<usize>, usize)>> {
        pieces
            .iter()
            .map(|pieces| pieces.iter().map(|piece| (piece.samples.clone(), piece.fold)).collect())
            .collect()
    }

    #[test]
    fn three_recordings_are_left_out_whole() {
        assert_eq!(
            samples(&folds(&[4, 5, 6], &[0, 1, 2])),
            [vec![(0..4, 0)], vec![(0..5, 1)], vec![(0..6, 2)]]
        );
    }

    #[test]
    fn recordings_of_one_group_are_one_part_and_two_groups_are_enough() {
        assert_eq!(
            samples(&folds(&[4, 5, 6, 7], &[7, 3, 7, 1])),
            [vec![(0..4, 0)], vec![(0..5, 1)], vec![(0..6, 0)], vec![(0..7, 2)]]
        );
        assert_eq!(
            samples(&folds(&[4, 5, 6], &[0, 1, 1])),
            [vec![(0..4, 0)], vec![(0..5, 1)], vec![(0..6, 1)]]
        );
        assert_eq!(folds(&[4, 5, 6], &[2; 3]), folds(&[4, 5, 6], &[0; 3]));
        assert_eq!(folds(&[4, 5, 6], &[2; 3])[0].len(), 2, "blocks of three samples");
    }

    #[test]
    fn one_or_two_recordings_are_left_out_by_five_blocks() {
        assert_eq!(
            samples(&folds(&[12], &[0])),
            [vec![(0..3, 0), (3..6, 1), (6..8, 2), (8..10, 3), (10..12, 4)]]
        );
        assert_eq!(
            samples(&folds(&[5, 5], &[0, 1])),
            [vec![(0..2, 0), (2..4, 1), (4..5, 2)], vec![(0..1, 2), (1..3, 3), (3..5, 4)]]
        );
        assert_eq!(samples(&folds(&[2], &[0])), [vec![(0..1, 0), (1..2, 1)]]);
    }
}
