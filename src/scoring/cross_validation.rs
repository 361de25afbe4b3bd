//! Cuts training recordings into parts that cross-validation leaves out in turn.
//!
//! Samples are never shuffled. Neighbouring samples are nearly equal, so the error on shuffled samples would be too low. The
//! recordings of a group (see [`Groups`](crate::recording::Groups)) are left out together. A recording without group is a
//! group of its own; the pieces of one run of a file count as one recording. Two groups of recordings are enough if there are
//! at least three recordings: the fit to each group then predicts the other. With fewer than three training recordings, five
//! contiguous blocks of samples take the place of groups. The
//! look-back always uses the conventional calibration of *all* training recordings, because it only selects the earlier
//! sample.

use std::collections::HashSet;
use std::sync::Arc;

use crate::{
    calibration::{CrossValidation, Piece},
    recording::{Entry, GroupedBy, RecordingSet, Role},
};

/// Minimum number of training recordings for leaving out whole recordings. With fewer, blocks of samples are left out.
pub const FEWEST_RECORDINGS: usize = 3;
/// Number of blocks of samples that take the place of recordings if there are too few recordings.
pub const BLOCKS: usize = 5;

/// Division of the training recordings into parts that cross-validation leaves out in turn.
#[derive(Clone, Debug)]
pub struct Folds {
    /// Pieces of each recording, each with the number of the cross-validation part that contains it. A recording that is not
    /// used for training is one piece.
    pub pieces: Vec<Vec<Piece>>,
    pub n_parts: usize,
    /// True if whole recordings are left out, false if blocks of samples are left out.
    pub are_whole: bool,
}

impl Folds {
    /// Divides recordings into parts. Each recording is given as its number of samples and its group (`None` if not used for
    /// training). Groups are numbered in their order of appearance. Blocks have equal numbers of samples, or one more in the
    /// first blocks.
    pub fn of(recordings: &[(usize, Option<usize>)], by: GroupedBy) -> Self {
        let mut groups: Vec<usize> = recordings.iter().filter_map(|(_, group)| *group).collect();
        let mut n_training = groups.len();
        let mut seen = HashSet::new();
        groups.retain(|group| seen.insert(*group));
        if by == GroupedBy::Recording {
            // A group then holds the pieces of one run, which count as one recording.
            n_training = groups.len();
        }
        let are_whole = n_training >= FEWEST_RECORDINGS && groups.len() > 1;
        let training = recordings.iter().filter(|(_, group)| group.is_some());
        let total: usize = training.map(|(n, _)| n).sum();
        let (even, longer) = (total / BLOCKS, total % BLOCKS);
        let start = |block: usize| block * even + block.min(longer);
        let mut first = 0;
        let pieces = recordings.iter().map(|&(n, group)| {
            let whole = |fold| vec![Piece { samples: 0..n, fold }];
            let Some(group) = group else { return whole(0) };
            if are_whole {
                return whole(groups.iter().position(|known| *known == group).unwrap_or_default());
            }
            let samples = first..first + n;
            first += n;
            let within = |at: usize| at.clamp(samples.start, samples.end) - samples.start;
            let blocks = (0..BLOCKS)
                .map(|fold| Piece { samples: within(start(fold))..within(start(fold + 1)), fold });
            blocks.filter(|piece| !piece.samples.is_empty()).collect()
        });
        let pieces: Vec<Vec<Piece>> = pieces.collect();
        let trained = pieces.iter().zip(recordings).filter(|(_, (_, group))| group.is_some());
        let n_parts = trained.flat_map(|(pieces, _)| pieces).map(|piece| piece.fold + 1).max();
        Self { n_parts: n_parts.unwrap_or(0), pieces, are_whole }
    }

    pub fn cross_validation(&self, by: GroupedBy) -> CrossValidation {
        let by = if self.are_whole { by } else { GroupedBy::Block };
        CrossValidation { by, groups: self.n_parts, parts: self.n_parts }
    }
}

/// Recordings for one fit of a cross-validation, and the recordings that this fit leaves out.
#[derive(Debug)]
pub struct Fold {
    /// The recordings for the fit, with the role train, and the left-out recordings, with the role test.
    pub set: Arc<RecordingSet>,
    /// For each left-out recording, the number of its cross-validation part. (Left-out recordings have the role test here.)
    pub parts: Vec<usize>,
}

impl Fold {
    /// Creates the set for one fit from recordings of one set. A recording that is left out is given with the number of its
    /// part.
    pub fn of(recordings: impl Iterator<Item = (Entry, Option<usize>)>) -> Self {
        let (mut set, mut parts) = (RecordingSet::default(), Vec::new());
        for (entry, part) in recordings {
            let role = if part.is_some() { Role::Test } else { Role::Train };
            parts.extend(part);
            set.push(Entry { role, ..entry })
                .expect("recordings of one set have equal gauges and axes");
        }
        Self { set: Arc::new(set), parts }
    }
}

/// Maximum number of fits of a cross-validation if one fit for each part would take too long.
pub const MOST_FITS: usize = 5;

/// Returns the index of the fit that leaves out this part. If there are more than [`MOST_FITS`] parts, a fit leaves out
/// several.
pub fn fit_without(part: usize, n_parts: usize) -> usize {
    part % n_parts.min(MOST_FITS)
}

/// Strengths of the ridge that are tried. The last one is so large that only the conventional calibration is left.
pub const RIDGE_STRENGTHS: [f64; 12] =
    [0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 10.0, 1e9];

#[cfg(test)]
mod tests {
    use super::*;

    fn folds(n_samples: &[usize], groups: &[usize]) -> Vec<Vec<Piece>> {
        let recordings: Vec<_> =
            n_samples.iter().copied().zip(groups.iter().copied().map(Some)).collect();
        Folds::of(&recordings, GroupedBy::Group).pieces
    }

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
        assert_eq!(folds(&[4, 5, 6], &[2; 3])[0].len(), 2, "blocks have three samples");
    }

    #[test]
    fn pieces_of_one_or_two_runs_are_left_out_by_five_blocks() {
        let pieces = [(4, Some(0)), (5, Some(0)), (6, Some(1)), (9, Some(1))];
        let folds = Folds::of(&pieces, GroupedBy::Recording);
        assert_eq!((folds.n_parts, folds.are_whole), (5, false));
        let of_three = [&pieces[..], &[(8, Some(2))]].concat();
        let folds = Folds::of(&of_three, GroupedBy::Recording);
        assert_eq!((folds.n_parts, folds.are_whole), (3, true));
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
