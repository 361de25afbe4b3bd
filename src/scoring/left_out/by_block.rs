//! Chooses a ridge strength for each block of feature columns by cross-validation.
//!
//! The search is a forward selection. It adds the block that lowers the held-out error most with its best strength, then the
//! next block, as long as the error falls. The result is the simplest tried combination that is nearly as good as the best
//! one. So a block is used only if it helps on most held-out parts of the data.

use std::collections::HashMap;

use rayon::prelude::*;

use crate::{calibration::simplest_good, column::column, scoring::left_out::fits::LeftOut};

/// Ridge strengths to try for each block, in descending order.
const STRENGTHS: [f64; 6] = [1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-6];

/// Ridge strengths of all blocks, with one number per block: 0 leaves the block out, n means the n-th of [`STRENGTHS`].
type Levels = Vec<u8>;

/// Chosen ridge strength for each target (load axis) and each block; `None` if the block is left out.
pub type BlockStrengths = Vec<Vec<Option<f64>>>;

/// Combinations of blocks and strengths that have been tried, with their squared errors on each held-out part for each
/// target.
struct Tried<'a> {
    left_out: LeftOut<'a>,
    blocks: &'a [Vec<usize>],
    squares: HashMap<Levels, Vec<f64>>,
}

impl LeftOut<'_> {
    /// Chooses feature blocks and their ridge strengths for each target (load axis). A block is a list of columns. Returns
    /// `None` with fewer than two parts of the data.
    pub fn by_block(&self, blocks: &[Vec<usize>]) -> Option<BlockStrengths> {
        if self.parts.len() < 2 {
            return None;
        }
        let q = self.total.n_targets();
        let mut tried = Tried { left_out: *self, blocks, squares: HashMap::new() };
        let none: Levels = vec![0; blocks.len()];
        tried.add(vec![none.clone()]);
        let mut standing = vec![Some(none); q];
        while standing.iter().any(Option::is_some) {
            let asked = standing.iter().flatten().flat_map(further);
            tried.add(asked.collect());
            for (target, levels_of_target) in standing.iter_mut().enumerate() {
                let Some(levels) = levels_of_target else { continue };
                let next = further(levels)
                    .min_by(|a, b| tried.sum(a, target).total_cmp(&tried.sum(b, target)));
                let falls = |next: &Levels| tried.sum(next, target) < tried.sum(levels, target);
                *levels_of_target = next.filter(falls);
            }
        }
        let chosen: Vec<&Levels> = (0..q).map(|target| tried.simplest_good(target)).collect();
        let of_target = |levels: &&Levels| levels.iter().map(|level| strength(*level)).collect();
        Some(chosen.iter().map(of_target).collect())
    }
}

/// Returns the ridge penalty of each column, as a share of the column's squared length. It is infinite in a block that is
/// left out.
pub fn shares_of_blocks(
    n_columns: usize,
    blocks: &[Vec<usize>],
    strengths: &[Option<f64>],
) -> Vec<f64> {
    let mut shares = vec![0.0; n_columns];
    for (block, strength) in blocks.iter().zip(strengths) {
        let share = strength.unwrap_or(f64::INFINITY);
        block.iter().for_each(|column| shares[*column] = share);
    }
    shares
}

fn strength(level: u8) -> Option<f64> {
    Some(STRENGTHS[usize::from(level.checked_sub(1)?)])
}

/// Returns all combinations that add one more block, with each of its strengths.
fn further(levels: &Levels) -> impl Iterator<Item = Levels> {
    let free = (0..levels.len()).filter(|block| levels[*block] == 0);
    free.flat_map(move |block| {
        (1..=STRENGTHS.len() as u8).map(move |level| {
            let mut further = levels.clone();
            further[block] = level;
            further
        })
    })
}

impl Tried<'_> {
    fn add(&mut self, asked: Vec<Levels>) {
        let mut new: Vec<Levels> =
            asked.into_iter().filter(|levels| !self.squares.contains_key(levels)).collect();
        new.sort_unstable();
        new.dedup();
        let tried = &*self;
        let found: Vec<(Levels, Vec<f64>)> = (new.into_par_iter())
            .map(|levels| {
                let squares = tried.try_one(&levels);
                (levels, squares)
            })
            .collect();
        self.squares.extend(found);
    }

    fn try_one(&self, levels: &Levels) -> Vec<f64> {
        let strengths: Vec<Option<f64>> = levels.iter().map(|level| strength(*level)).collect();
        let n_columns = self.left_out.total.n_features();
        let shares = shares_of_blocks(n_columns, self.blocks, &strengths);
        self.left_out.squares_with(&shares)
    }

    fn sum(&self, levels: &Levels, target: usize) -> f64 {
        let q = self.left_out.total.n_targets();
        column(&self.squares[levels], q, target).sum()
    }

    /// Returns a combination of blocks that is nearly as good as the best: the one with the fewest columns, then with the
    /// strongest ridge.
    fn simplest_good(&self, target: usize) -> &Levels {
        let q = self.left_out.total.n_targets();
        let cost = |levels: &Levels| {
            let taken = self.blocks.iter().zip(levels).filter(|(_, level)| **level > 0);
            let columns: usize = taken.map(|(block, _)| block.len()).sum();
            let weakness: u32 = levels.iter().map(|level| u32::from(*level)).sum();
            (columns, weakness)
        };
        let mut tried: Vec<(&Levels, &Vec<f64>)> = self.squares.iter().collect();
        tried.sort_by(|(a, _), (b, _)| {
            let by_error = || self.sum(b, target).total_cmp(&self.sum(a, target));
            (cost(b).cmp(&cost(a))).then_with(by_error).then(b.cmp(a))
        });
        let square = |at: usize, part: usize| tried[at].1[part * q + target];
        tried[simplest_good(tried.len(), self.left_out.parts.len(), square)].0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::{NormalEquations, Ridge, Terms, fit};
    use crate::features::ColumnKind;
    use crate::random::Random;

    /// Columns: a gauge; two columns of a block on which the load depends; one column of a block that is noise for the first
    /// target and determines the second.
    fn parts(n_parts: usize) -> Vec<NormalEquations> {
        let part = |part: usize| {
            let mut random = Random::new(11, &[part as u64]);
            let mut sums = NormalEquations::new(4, 2);
            for _ in 0..30 {
                let [a, b, c, d, noise, other] = [(); 6].map(|()| random.normal());
                let mut row = vec![a, b, c, d, a + 0.5 * b - 0.3 * c + noise, a + d + 0.1 * other];
                row.resize(sums.stride(), 0.0);
                sums.add_rows(&row);
            }
            sums
        };
        (0..n_parts).map(part).collect()
    }

    fn total(parts: &[NormalEquations]) -> NormalEquations {
        let mut total = NormalEquations::new(4, 2);
        parts.iter().for_each(|part| total.add(part));
        total
    }

    const KINDS: [ColumnKind; 4] =
        [ColumnKind::Gauge, ColumnKind::Appended, ColumnKind::Appended, ColumnKind::Appended];

    const TERMS: Terms<'_> = Terms { used: &[0, 1, 2, 3], kinds: &KINDS, known: &[] };

    #[test]
    fn a_block_is_used_only_on_the_axis_that_it_helps() {
        let parts = parts(8);
        let total = total(&parts);
        let left_out = LeftOut::of(&total, &parts, TERMS);
        let blocks = [vec![1, 2], vec![3]];
        let chosen = left_out.by_block(&blocks).unwrap();
        assert!(chosen[0][0].is_some() && chosen[0][1].is_none(), "{chosen:?}");
        assert!(chosen[1][0].is_none() && chosen[1][1].is_some(), "{chosen:?}");
        let alone = LeftOut::of(&total, &parts[..1], TERMS);
        assert_eq!(alone.by_block(&blocks), None);
    }

    /// With a ridge per block, each fit equals a direct solution with these penalties. A removed block has no coefficients.
    #[test]
    fn shares_are_those_of_fits_to_the_other_parts() {
        let parts = parts(5);
        let total = total(&parts);
        let left_out = LeftOut::of(&total, &parts, TERMS);
        let shares = shares_of_blocks(4, &[vec![1, 2], vec![3]], &[Some(0.3), None]);
        let squares = left_out.squares_with(&shares);
        for at in 0..parts.len() {
            let mut rest = NormalEquations::new(4, 2);
            let others = parts.iter().enumerate().filter(|(other, _)| *other != at);
            others.for_each(|(_, part)| rest.add(part));
            let terms = Terms { used: &[0, 1, 2], ..TERMS };
            let found = fit(&rest, terms, Ridge::Shares(&[0.0, 0.3, 0.3, 0.0]));
            let expected = parts[at].squared_residuals(&found.coefficients);
            for (actual, expected) in squares[at * 2..][..2].iter().zip(expected) {
                assert!((actual - expected).abs() < 1e-9 * expected);
            }
        }
    }
}
