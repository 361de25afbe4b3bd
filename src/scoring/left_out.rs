//! Cross-validation of linear fits from normal equations: fits that each leave one part out, and their errors on this part,
//! with one ridge for all columns, or with one ridge for each block of feature columns.
//!
//! Guarantees: except for rounding, the squared errors equal those of [`fit`] to the normal equations of the other parts.
//! Usually, a part is subtracted from the total. If columns are nearly collinear, or a column nearly vanishes without a part,
//! the normal equations of the other parts are added up instead. Then [`fit`] determines the rank.
//!
//! The ridge strengths of blocks are chosen by forward selection. It adds the block that lowers the held-out error most with
//! its best strength, then the next block, as long as the error falls. The result is the simplest tried combination that is
//! nearly as good as the best one. So a block is used only if it helps on most held-out parts of the data.

mod lanes;

use std::collections::HashMap;

use rayon::prelude::*;

use crate::{
    calibration::{
        MANY_COLUMNS, NormalEquations, Ridge, RidgeChoice, Terms, fit, fit_targets, simplest_good,
    },
    column::column,
    features::ColumnKind,
    scoring::{
        cross_validation::RIDGE_STRENGTHS,
        left_out::lanes::{LANES, Work},
        metrics::root_mean,
    },
};

/// Cross-validation of a linear fit. Each fit uses all parts of the data but one.
#[derive(Clone, Copy, Debug)]
pub struct LeftOut<'a> {
    pub total: &'a NormalEquations,
    /// Normal equations of each part of the data. Every part must have samples.
    pub parts: &'a [NormalEquations],
    /// For each part, normal equations on which the fit without this part is scored. They differ from `parts` if the scored
    /// loads fade in.
    pub scored: &'a [NormalEquations],
    pub terms: Terms<'a>,
}

impl<'a> LeftOut<'a> {
    /// Creates a cross-validation in which each fit is scored on the part of the data that it leaves out.
    pub fn of(total: &'a NormalEquations, parts: &'a [NormalEquations], terms: Terms<'a>) -> Self {
        Self { total, parts, scored: parts, terms }
    }

    /// Replaces the normal equations on which the fits are scored.
    pub fn scored_on(self, scored: &'a [NormalEquations]) -> Self {
        Self { scored, ..self }
    }

    /// Returns the coefficients of each cross-validation fit, which leaves out one part of the data. `shares` holds the
    /// ridge penalties for each target.
    pub fn coefficients(&self, shares: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let fit = |_, rest: &NormalEquations| fit_targets(rest, self.terms, shares).coefficients;
        let fits = NormalEquations::each_without(self.parts, |_| true, fit).into_iter();
        fits.map(|(_, coefficients)| coefficients).collect()
    }

    /// Returns true if every fit has at least as many samples as coefficients without a ridge penalty.
    pub fn is_determined(&self, strengths: &[f64]) -> bool {
        let kinds = self.terms.used.iter().map(|&column| self.terms.kinds[column]);
        let part_samples = self.parts.iter().map(NormalEquations::n_samples);
        too_short(part_samples, kinds, strengths).is_none()
    }

    /// Returns the RMSE per target from the squared errors of all parts; `None` if [`Self::is_determined`] is false.
    pub fn rmse(&self, strengths: &[f64], squares: impl FnOnce() -> Vec<f64>) -> Option<Vec<f64>> {
        let squares = self.is_determined(strengths).then(squares)?;
        let q = self.total.n_targets();
        root_mean(&summed_by_target(&squares, q), self.total.n_samples())
    }

    /// Returns the ridge strength of each target, and the squared errors with it. With fewer than two parts of the data,
    /// there are no errors, and an automatic strength is zero.
    ///
    /// An automatic ridge is the strongest one whose held-out error is nearly the lowest. It is used if this error is below
    /// the error of the conventional calibration with 90 % confidence. If the parts disagree, the fit stays near the
    /// conventional calibration. The errors are slightly too low, because the strength is chosen from the same parts.
    /// [`Self::by_block`] chooses one strength for each feature block.
    pub fn with_ridge(&self, ridge: RidgeChoice) -> (Vec<f64>, Option<Vec<f64>>) {
        let (q, n_parts) = (self.total.n_targets(), self.parts.len());
        match ridge {
            RidgeChoice::Strength(strength) => {
                (vec![strength; q], (n_parts > 1).then(|| self.squares(strength)))
            }
            RidgeChoice::Auto | RidgeChoice::ByBlock if n_parts < 2 => (vec![0.0; q], None),
            RidgeChoice::Auto | RidgeChoice::ByBlock => {
                let tried: Vec<Vec<f64>> =
                    RIDGE_STRENGTHS.iter().map(|strength| self.squares(*strength)).collect();
                let chosen: Vec<usize> = (0..q)
                    .map(|axis| {
                        let square = |at: usize, part: usize| tried[at][part * q + axis];
                        simplest_good(tried.len(), n_parts, square)
                    })
                    .collect();
                let squares = (0..n_parts * q).map(|at| tried[chosen[at % q]][at]).collect();
                let strengths = chosen.iter().map(|at| RIDGE_STRENGTHS[*at]).collect();
                (strengths, Some(squares))
            }
        }
    }

    /// Returns the squared errors like [`Self::squares_with`], with separate penalties (`shares`) for each target.
    pub fn squares_by_target(&self, shares: &[Vec<f64>]) -> Vec<f64> {
        let q = self.total.n_targets();
        let mut squares = vec![0.0; self.parts.len() * q];
        for target in 0..q {
            if shares[..target].contains(&shares[target]) {
                continue; // computed with the first target that has the same shares
            }
            let with_it = self.squares_with(&shares[target]);
            for at in 0..squares.len() {
                if shares[at % q] == shares[target] {
                    squares[at] = with_it[at];
                }
            }
        }
        squares
    }

    /// Returns the sums of squared errors on the left-out parts, `n_parts × n_targets` row-major. Each part is predicted by
    /// the fit to all other parts. The ridge penalty of an appended (feature) column is `strength` times its squared length.
    /// Panics if the parts differ in columns.
    pub fn squares(&self, strength: f64) -> Vec<f64> {
        self.squares_with(&self.terms.shares(strength))
    }

    /// Returns the squared errors like [`Self::squares`], with the ridge penalty of each column as a share of its squared
    /// length. An infinite share removes the column.
    pub fn squares_with(&self, shares: &[f64]) -> Vec<f64> {
        let q = self.total.n_targets();
        // Columns that are zero in every part are dropped, because the fast computation cannot handle them.
        let used = self.total.present_among(&self.terms.kept(shares));
        let left_out = LeftOut { terms: Terms { used: &used, ..self.terms }, ..*self };
        let mut squares = vec![0.0; self.parts.len() * q];
        let mut is_sure = vec![false; self.parts.len()];
        if used.len() < MANY_COLUMNS {
            let mut work = Work::new(used.len(), q);
            (self.parts.chunks(LANES))
                .zip(self.scored.chunks(LANES))
                .zip(squares.chunks_mut(LANES * q))
                .zip(is_sure.chunks_mut(LANES))
                .for_each(|(((parts, scored), squares), is_sure)| {
                    work.fit(left_out.total, left_out.terms, [parts, scored], shares);
                    for (lane, (squares, is_sure)) in squares.chunks_mut(q).zip(is_sure).enumerate()
                    {
                        *is_sure = work.answer(lane, squares);
                    }
                });
        }
        let careful = NormalEquations::each_without(
            self.parts,
            |at| !is_sure[at],
            |at, rest| {
                let found = fit(rest, left_out.terms, Ridge::Shares(shares));
                self.scored[at].squared_residuals(&found.coefficients)
            },
        );
        for (at, careful) in careful {
            squares[at * q..][..q].copy_from_slice(&careful);
        }
        squares
    }
}

/// Returns the sums over all parts of `n_parts × n_targets` squares, one number per target.
pub fn summed_by_target(squares: &[f64], n_targets: usize) -> Vec<f64> {
    (0..n_targets).map(|target| column(squares, n_targets, target).sum()).collect()
}

/// Returns the smallest number of samples that remain when one part is left out, and the number of coefficients that the
/// ridge does not penalise. Returns `None` if there are enough samples for these coefficients.
pub fn too_short(
    part_samples: impl Iterator<Item = u64> + Clone,
    kinds: impl Iterator<Item = ColumnKind>,
    strengths: &[f64],
) -> Option<(u64, usize)> {
    let is_shrunk = strengths.iter().all(|strength| *strength > 0.0);
    let free = kinds.filter(|kind| !(is_shrunk && *kind == ColumnKind::Appended)).count();
    let total: u64 = part_samples.clone().sum();
    let samples = total - part_samples.max().unwrap_or(0);
    (samples < (free as u64).max(1)).then_some((samples, free))
}

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
    use crate::random::Random;
    use crate::scoring::left_out::*;

    /// Columns of blocks that a ridge shrinks need no samples of their own.
    #[test]
    fn shrunk_columns_need_no_samples() {
        let kinds = [ColumnKind::Gauge, ColumnKind::Appended];
        let too_short = |samples: &[u64], strength| {
            too_short(samples.iter().copied(), kinds.into_iter(), &[strength])
        };
        assert_eq!(too_short(&[1, 3], 0.0), Some((1, 2)));
        assert_eq!(too_short(&[1, 3], 0.1), None);
        assert_eq!(too_short(&[2, 3], 0.0), None);
        assert_eq!(too_short(&[9], 0.1), Some((0, 1)));
    }

    /// Returns `n` parts of `p` random columns and two targets. Column 1 is `explained` times column 0 plus a small
    /// independent term.
    fn parts(n: usize, p: usize, small: f64) -> (NormalEquations, Vec<NormalEquations>) {
        let parts: Vec<_> = (0..n)
            .map(|part| {
                let mut sums = NormalEquations::new(p, 2);
                for k in 0..40 + part {
                    let t = (k * 7 + part * 131) as f64;
                    let mut row = vec![0.0; sums.stride()];
                    for (column, value) in row[..p + 2].iter_mut().enumerate() {
                        *value = (t * (0.11 + 0.07 * column as f64)).sin() + 0.1 * column as f64;
                    }
                    if p > 1 {
                        row[1] = 3.0 * row[0] + small * row[1];
                    }
                    sums.add_rows(&row);
                }
                sums
            })
            .collect();
        let mut total = NormalEquations::new(p, 2);
        parts.iter().for_each(|part| total.add(part));
        (total, parts)
    }

    #[track_caller]
    fn assert_as_one_by_one(n: usize, p: usize, small: f64, used: &[usize], strength: f64) {
        let (total, parts) = parts(n, p, small);
        let shrunk = |column: usize| match column % 3 {
            0 => ColumnKind::Gauge,
            _ => ColumnKind::Appended,
        };
        let terms = Terms { used, kinds: &(0..p).map(shrunk).collect::<Vec<_>>(), known: &[] };
        let left_out = LeftOut::of(&total, &parts, terms);
        let one_by_one = NormalEquations::each_without(
            &parts,
            |_| true,
            |at, rest| {
                let found = fit(rest, terms, Ridge::Relative(strength));
                parts[at].squared_residuals(&found.coefficients)
            },
        );
        let expected = one_by_one.into_iter().flat_map(|(_, squares)| squares);
        for (actual, expected) in left_out.squares(strength).iter().zip(expected) {
            let error = (actual / expected - 1.0).abs();
            assert!(error < 1e-10, "{n} parts, {p} columns, {small}: {error}");
        }
    }

    #[test]
    fn eight_at_once_equal_one_by_one() {
        for n in [2, 7, 8, 9, 20] {
            for p in [1, 2, 5, 14] {
                let all: Vec<usize> = (0..p).collect();
                for strength in [0.0, 0.01, 3.0] {
                    assert_as_one_by_one(n, p, 1.0, &all, strength);
                }
            }
        }
        assert_as_one_by_one(10, 9, 1.0, &[7, 2, 4], 0.1);
    }

    /// Column 1 equals column 0, exactly or within a thousandth.
    #[test]
    fn columns_that_explain_each_other_take_the_careful_way() {
        for small in [0.0, 1e-4] {
            assert_as_one_by_one(9, 6, small, &[0, 1, 2, 3, 4, 5], 0.0);
        }
    }

    /// A column that moves in one part alone cannot be fitted without this part.
    #[test]
    fn a_column_that_only_the_left_out_part_has_gets_no_coefficient() {
        let part = |has: f64| {
            let mut sums = NormalEquations::new(2, 1);
            for k in 0..5 {
                let mut row = vec![0.0; sums.stride()];
                let x = f64::from(k) - 1.7;
                row[..3].copy_from_slice(&[x, has * x * x, 2.0 * x + 5.0 * has]);
                sums.add_rows(&row);
            }
            sums
        };
        let parts = [part(1.0), part(0.0), part(0.0)];
        let mut total = NormalEquations::new(2, 1);
        parts.iter().for_each(|part| total.add(part));
        let terms = Terms { used: &[0, 1], kinds: &[ColumnKind::Gauge; 2], known: &[] };
        let left_out = LeftOut::of(&total, &parts, terms);
        assert!((left_out.squares(0.0)[0] - 125.0).abs() < 1e-9, "there are five errors of 5");
    }

    /// The fit is a mean. The parts {0, 0} and {3} are predicted as 3 and 0, so every error is 3.
    #[test]
    fn a_left_out_part_takes_no_part_in_its_fit() {
        let parts = [&[0.0, 0.0][..], &[3.0]].map(|values| {
            let mut sums = NormalEquations::new(1, 1);
            for value in values {
                let mut row = vec![0.0; sums.stride()];
                row[..2].copy_from_slice(&[1.0, *value]);
                sums.add_rows(&row);
            }
            sums
        });
        let mut total = parts[0].clone();
        total.add(&parts[1]);
        let terms = Terms { used: &[0], kinds: &[ColumnKind::Offset], known: &[] };
        let left_out = |parts| LeftOut::of(&total, parts, terms);
        let rmse = left_out(&parts);
        let rmse = rmse.rmse(&[0.0], || rmse.squares(0.0)).unwrap();
        assert!((rmse[0] - 3.0).abs() < 1e-12);
        assert_eq!(left_out(&parts[..1]).rmse(&[0.0], Vec::new), None);
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
            let terms = Terms { used: &[0], kinds: &[ColumnKind::Appended], known: &[] };
            let left_out = LeftOut::of(&total, &parts, terms);
            left_out.with_ridge(RidgeChoice::Auto).0[0]
        };
        assert_eq!(strength(0.0), 1e9);
        assert!(strength(10.0) < 0.1);
    }

    /// One part of a random design: rows `[x | load]`.
    type Samples = Vec<Vec<f64>>;

    /// Returns the coefficients by Gram-Schmidt on the samples. A column that earlier columns explain gets zero.
    fn explicit_fit(rows: &[&Vec<f64>], in_order: &[usize]) -> Vec<(usize, f64)> {
        let column = |at: usize| -> Vec<f64> { rows.iter().map(|row| row[at]).collect() };
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        type MadeOf = Vec<(usize, f64)>;
        let mut basis: Vec<(Vec<f64>, MadeOf)> = Vec::new(); // orthogonal vectors, each with its combination of columns
        for &at in in_order {
            let mut left = column(at);
            let length = dot(&left, &left).sqrt();
            let mut made_of = vec![(at, 1.0)];
            for _ in 0..2 {
                for (other, its) in &basis {
                    let share = dot(&left, other) / dot(other, other);
                    left.iter_mut().zip(other).for_each(|(x, o)| *x -= share * o);
                    made_of.extend(its.iter().map(|(column, b)| (*column, -share * b)));
                }
            }
            if dot(&left, &left).sqrt() > 1e-8 * length {
                basis.push((left, made_of));
            }
        }
        let loads = column(rows[0].len() - 1);
        let shares = basis.iter().flat_map(|(vector, made_of)| {
            let share = dot(&loads, vector) / dot(vector, vector);
            made_of.iter().map(move |(column, b)| (*column, share * b))
        });
        shares.collect()
    }

    /// Some parts are short. Some gauges move in one part alone and are constant or zero elsewhere. Their scales differ by a
    /// factor of up to a million.
    #[test]
    fn errors_are_those_of_explicit_refits_on_random_designs() {
        for seed in 0..400 {
            let mut random = Random::new(seed, &[]);
            let mut whole =
                |low: usize, high: usize| random.between(low as f64, high as f64) as usize;
            let (n_parts, n_gauges, n_appended) = (whole(2, 8), whole(1, 7), whole(0, 5));
            let p = n_gauges + n_appended + 1;
            let lengths: Vec<usize> = (0..n_parts).map(|_| whole(p + 1, 3 * p + 4)).collect();
            let lives_in: Vec<usize> = (0..n_gauges).map(|_| whole(0, 3 * n_parts)).collect();
            let stands_at: Vec<f64> = (0..n_gauges)
                .map(|_| if random.between(0.0, 1.0) < 0.5 { 0.0 } else { random.normal() })
                .collect();
            let size: Vec<f64> =
                (0..n_gauges).map(|_| 10f64.powf(random.between(-3.0, 3.0))).collect();
            let known: Vec<f64> = (0..p)
                .map(|at| match at {
                    _ if at < n_gauges => random.normal() / size[at],
                    _ if at + 1 < p => 0.0,
                    _ => random.normal(),
                })
                .collect();
            let samples: Vec<Samples> = lengths
                .iter()
                .enumerate()
                .map(|(part, &n)| {
                    let sample = |_| {
                        let mut row: Vec<f64> = (0..n_gauges)
                            .map(|gauge| {
                                let moves = lives_in[gauge] >= n_parts || lives_in[gauge] == part;
                                let value = if moves { random.normal() } else { stands_at[gauge] };
                                size[gauge] * value
                            })
                            .collect();
                        row.extend((0..n_appended).map(|_| random.normal()));
                        row.push(1.0);
                        row.push(3.0 * random.normal() + row[0] / size[0]);
                        row
                    };
                    (0..n).map(sample).collect()
                })
                .collect();
            let parts: Vec<NormalEquations> = samples
                .iter()
                .map(|samples| {
                    let mut sums = NormalEquations::new(p, 1);
                    for row in samples {
                        let mut padded = row.clone();
                        padded[p] -= row.iter().zip(&known).map(|(x, b)| x * b).sum::<f64>();
                        padded.resize(sums.stride(), 0.0);
                        sums.add_rows(&padded);
                    }
                    sums
                })
                .collect();
            let mut total = NormalEquations::new(p, 1);
            parts.iter().for_each(|part| total.add(part));
            let mut kinds = vec![ColumnKind::Gauge; n_gauges];
            kinds.resize(p - 1, ColumnKind::Appended);
            kinds.push(ColumnKind::Offset);
            let used: Vec<usize> = (0..p).collect();
            let terms = Terms { used: &used, kinds: &kinds, known: &known };
            let left_out = LeftOut::of(&total, &parts, terms);
            let in_order: Vec<usize> = std::iter::once(p - 1).chain(0..p - 1).collect();
            for (at, square) in left_out.squares(0.0).into_iter().enumerate() {
                let others = samples.iter().enumerate().filter(|(other, _)| *other != at);
                let rows: Vec<&Vec<f64>> = others.flat_map(|(_, samples)| samples).collect();
                let fitted = explicit_fit(&rows, &in_order);
                let explicit: f64 = samples[at]
                    .iter()
                    .map(|row| row[p] - fitted.iter().map(|(at, b)| row[*at] * b).sum::<f64>())
                    .map(|error| error * error)
                    .sum();
                let error = (square / explicit - 1.0).abs();
                assert!(error < 1e-6, "seed {seed}, part {at}: {square} instead of {explicit}");
            }
        }
    }

    /// Without a part, there are fewer samples than coefficients: no score, unless a ridge determines the solution.
    #[test]
    fn where_the_others_do_not_determine_a_fit_there_is_no_figure() {
        let (total, parts) = parts(2, 60, 1.0);
        let used: Vec<usize> = (0..60).collect();
        let figure = |kinds: &[ColumnKind], strength: f64| {
            let terms = Terms { used: &used, kinds, known: &[] };
            let left_out = LeftOut::of(&total, &parts, terms);
            left_out.rmse(&[strength; 2], || left_out.squares(strength))
        };
        let appended = [&[ColumnKind::Gauge; 5][..], &[ColumnKind::Appended; 55]].concat();
        assert_eq!(figure(&[ColumnKind::Gauge; 60], 0.1), None);
        assert_eq!(figure(&appended, 0.0), None);
        assert!(figure(&appended, 0.1).is_some());
    }
}

#[cfg(test)]
mod by_block_tests {
    use crate::calibration::{NormalEquations, Ridge, Terms, fit};
    use crate::features::ColumnKind;
    use crate::random::Random;
    use crate::scoring::left_out::*;

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
