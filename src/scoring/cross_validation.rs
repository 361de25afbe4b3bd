//! Cross-validation by group: cuts training recordings into parts, and chooses the ridge strength by them. The fits without
//! each part are those of [`LeftOut`](crate::scoring::left_out::LeftOut).
//!
//! Samples are never shuffled: neighbours in time are nearly equal, so a shuffled test would flatter the fit. The recordings of a
//! group (see [`Groups`](crate::recording::Groups)) are left out together; an ungrouped recording is a group of its own. Two
//! groups are enough if there are more recordings: each group is then predicted by the other. With fewer than three training
//! recordings, five contiguous blocks take the place of groups.
//! The look-back always searches by the conventional calibration of *all* training recordings: it chooses the past sample, not
//! the load.

use crate::calibration::{Piece, simplest_good};

/// Minimum number of training recordings for leaving out recordings; with fewer, blocks are left out.
pub const FEWEST_RECORDINGS: usize = 3;
/// Number of blocks that take the place of recordings.
pub const BLOCKS: usize = 5;

/// Returns the parts that are left out in turn, for training recordings of these lengths and groups.
///
/// Each recording has a list of pieces. Groups are numbered in their order of appearance. Blocks divide all training samples
/// evenly, the longer ones first.
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

/// Ridge strengths to try, from none to one that leaves only the conventional calibration.
pub const RIDGE_STRENGTHS: [f64; 12] =
    [0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 10.0, 1e9];

/// Returns the position of the strongest ridge whose squared error is nearly the lowest. `square(at, part)` is the sum of squared
/// errors of a part at a strength.
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
