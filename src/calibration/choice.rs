//! Rule that chooses among models, ridge strengths, thresholds, radii or time constants: the fit with the lowest held-out
//! error, and the smallest fit that is nearly as good.
//!
//! Guarantees: the held-out samples are cut into contiguous blocks, and two fits are compared by the difference of their
//! errors in each block. The lowest and the highest tenth of the differences are ignored; with five or more blocks, at least
//! one difference at each end. So one extreme block decides nothing. A fit is eligible only if its error is below that of the
//! conventional calibration with 90 % confidence. Moreover, in no group of recordings may its error exceed 1.1 times the
//! conventional error.

use statrs::function::beta::inv_beta_reg;

/// Maximum ratio of a fit's error to the conventional calibration's error in a group of recordings, for the fit to be
/// eligible.
pub(crate) const HARM: f64 = 1.1;
/// Share of the sorted error differences of the blocks that the trimmed mean ignores at each end.
const TRIMMED: f64 = 0.1;
/// Minimum number of blocks at which the trimmed mean ignores at least one difference at each end.
const FEWEST_TRIMMED: usize = 5;
/// Minimum number of blocks in a group at which the scatter of the errors is estimated within the group.
const FEWEST_OF_GROUP: usize = 3;
/// Share by which the error of a simpler setting of the same model may exceed the lowest error for the simpler setting to be
/// chosen.
pub(crate) const NEARLY: f64 = 0.01;
/// Maximum relative difference at which two errors count as equal, so that rounding errors do not decide the choice.
const TIE: f64 = 1e-9;

/// Contiguous blocks of held-out samples: number of samples and group of each block.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blocks {
    pub samples: Vec<f64>,
    pub groups: Vec<usize>,
}

/// Returns the weighted sum over the axes of the squared errors in each block. `squares` is `n_blocks × n_axes`, row-major.
pub(crate) fn weighed(squares: &[f64], weights: &[f64]) -> Vec<f64> {
    let of_block = |squares: &[f64]| {
        squares.iter().zip(weights).map(|(squares, weight)| squares * weight).sum()
    };
    squares.chunks_exact(weights.len().max(1)).map(of_block).collect()
}

/// Difference of the mean squared errors of two fits on the same blocks of held-out samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Mean squared error of the first fit over all samples, minus that of the second fit.
    pub difference: f64,
    /// Trimmed mean: mean of the error differences of the blocks, without the lowest and the highest differences.
    pub trimmed: f64,
    /// Standard error of the trimmed mean.
    pub standard_error: f64,
    /// Number of blocks whose differences are in the trimmed mean.
    counted: usize,
}

impl Comparison {
    /// Returns true if the error of the first fit is below that of the second with 90 % confidence by Student's t. Both the
    /// trimmed and the untrimmed mean of the differences must be negative. With only two blocks, the first error must be
    /// lower in both.
    fn is_below(&self) -> bool {
        let needed = match self.counted {
            0 | 1 => return false,
            2 => 1.0 + TIE,
            n => t_beyond((n - 1) as f64, 0.1),
        };
        self.difference < 0.0 && self.trimmed < -needed * self.standard_error
    }
}

/// Returns the value that Student's t with `freedom` degrees of freedom exceeds with this probability, at most one half.
pub(crate) fn t_beyond(freedom: f64, probability: f64) -> f64 {
    let x = inv_beta_reg(0.5 * freedom, 0.5, 2.0 * probability);
    (freedom * (1.0 - x) / x).sqrt()
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// The error of the fit is not below that of the conventional calibration with 90 % confidence.
    NotBetter,
    /// The error of the fit in one group of recordings exceeds [`HARM`] times that of the conventional calibration.
    Harms {
        group: usize,
        /// Ratio of the fit's error to the conventional error in this group.
        ratio: f64,
    },
}

/// Result of the choice among fits, as indices into the list of fits.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Eligible fit with the lowest error.
    pub accurate: usize,
    /// Smallest eligible fit whose error is nearly as low.
    pub smallest: usize,
    pub refused: Vec<Option<Refusal>>,
}

impl Blocks {
    /// Creates one block for each part that cross-validation leaves out, given the number of samples of each part. Each
    /// block is a group of its own.
    pub fn of_parts(samples: &[u64]) -> Self {
        let samples: Vec<f64> = samples.iter().map(|n| *n as f64).collect();
        Self { groups: (0..samples.len()).collect(), samples }
    }

    pub fn compare(&self, one: &[f64], other: &[f64]) -> Comparison {
        let mut blocks: Vec<(f64, f64)> = (one.iter().zip(other).zip(&self.samples))
            .filter(|(_, n)| **n > 0.0)
            .map(|((one, other), n)| ((one - other) / n, *n))
            .collect();
        blocks.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mean = |blocks: &[(f64, f64)]| {
            let all: f64 = blocks.iter().map(|(_, n)| n).sum();
            blocks.iter().map(|(error, n)| error * n).sum::<f64>() / all.max(f64::MIN_POSITIVE)
        };
        let n = blocks.len();
        let aside = if n < FEWEST_TRIMMED { 0 } else { ((TRIMMED * n as f64) as usize).max(1) };
        let difference = mean(&blocks);
        let trimmed = mean(&blocks[aside..n - aside]);
        // Winsorised variance of the differences (Yuen 1974), with each block weighted by its number of samples.
        let ends = (n > 0).then(|| (blocks[aside].0, blocks[n - 1 - aside].0));
        let (low, high) = ends.unwrap_or_default();
        blocks.iter_mut().for_each(|(error, _)| *error = error.clamp(low, high));
        let centre = mean(&blocks);
        let all: f64 = blocks.iter().map(|(_, n)| n).sum();
        let squares = blocks.iter().map(|(error, n)| (n / all * (error - centre)).powi(2));
        let kept = (n - 2 * aside) as f64 / n.max(1) as f64;
        let correction = n as f64 / n.saturating_sub(1).max(1) as f64;
        Comparison {
            difference,
            trimmed,
            standard_error: (correction * squares.sum::<f64>()).sqrt() / kept.max(f64::EPSILON),
            counted: n - 2 * aside,
        }
    }

    /// Returns true if the RMS error of one fit is below `factor` times that of the other fit with 90 % confidence. `one` and
    /// `other` are their squared errors in each block.
    pub fn is_below(&self, one: &[f64], other: &[f64], factor: f64) -> bool {
        let other: Vec<f64> =
            other.iter().map(|square| factor * factor * (1.0 - TIE) * square).collect();
        one.iter().all(|square| square.is_finite()) && self.compare(one, &other).is_below()
    }

    /// Returns the group of recordings with the largest ratio of the fit's error to the conventional error, if a group
    /// exceeds [`HARM`].
    ///
    /// A group of at least [`FEWEST_OF_GROUP`] blocks must exceed the limit with 90 % confidence. In a group of fewer
    /// blocks, the conventional error may be low by chance. If the conventional error of the group is below the mean of all
    /// groups, the fit's error is compared with this mean.
    fn harm(&self, fitted: &[f64], conventional: &[f64]) -> Option<Refusal> {
        let pooled = conventional.iter().sum::<f64>() / self.samples.iter().sum::<f64>();
        let n_groups = self.groups.iter().max().map_or(0, |last| last + 1);
        let harms = (0..n_groups).filter_map(|group| {
            let of = |values: &[f64]| -> Vec<f64> {
                let all = values.iter().zip(&self.groups);
                all.filter(|(_, of)| **of == group).map(|(value, _)| *value).collect()
            };
            let (fitted, conventional) = (of(fitted), of(conventional));
            let samples = of(&self.samples);
            let sum = |values: &[f64]| values.iter().sum::<f64>();
            let n = sum(&samples);
            let blocks = Self { groups: vec![0; samples.len()], samples };
            let harms = if fitted.len() < FEWEST_OF_GROUP {
                sum(&fitted) > HARM * HARM * sum(&conventional).max(pooled * n)
            } else {
                blocks.is_below(&conventional, &fitted, 1.0 / HARM)
            };
            let ratio = (sum(&fitted) / sum(&conventional)).sqrt();
            harms.then_some((group, ratio))
        });
        let worst = harms.max_by(|a, b| a.1.total_cmp(&b.1));
        worst.map(|(group, ratio)| Refusal::Harms { group, ratio })
    }

    /// Chooses among `n` fits. Fit 0 is the conventional calibration; the others are sorted from the smallest to the largest.
    /// `squares(at)` is the weighted squared error of fit `at` in each block. The smallest fit is the first whose error is
    /// below `1 + within` times the lowest error with 90 % confidence.
    pub fn choose<'a>(
        &self,
        n: usize,
        within: f64,
        squares: impl Fn(usize) -> &'a [f64],
    ) -> Choice {
        let refusal = |at: usize| {
            let is_better = at == 0 || self.is_below(squares(at), squares(0), 1.0);
            let harm = (at > 0).then(|| self.harm(squares(at), squares(0))).flatten();
            harm.or((!is_better).then_some(Refusal::NotBetter))
        };
        let refused: Vec<Option<Refusal>> = (0..n).map(refusal).collect();
        let mut eligible: Vec<usize> = (0..n).filter(|at| refused[*at].is_none()).collect();
        let smallest_first = eligible.clone();
        let sum = |at: usize| squares(at).iter().sum::<f64>();
        eligible.sort_by(|a, b| sum(*a).total_cmp(&sum(*b)));
        let is_beaten = |at: &usize| {
            eligible.iter().any(|other| {
                let found = self.compare(squares(*other), squares(*at));
                Comparison { difference: found.trimmed, ..found }.is_below()
            })
        };
        let lowest = eligible.iter().find(|at| !is_beaten(at)).or(eligible.first());
        let accurate = lowest.copied().unwrap_or(0);
        let nearly = |at: &usize| {
            *at == accurate
                || sum(*at) <= sum(accurate) * (1.0 + TIE)
                || self.is_below(squares(*at), squares(accurate), 1.0 + within)
        };
        let smallest = smallest_first.into_iter().find(nearly).unwrap_or(accurate);
        Choice { accurate, smallest, refused }
    }
}

/// Chooses one of the `n_tried` settings of a model, and returns its index. The last setting is the simplest; another one is
/// chosen only if it is better with 90 % confidence. `square(at, part)` is the squared error of setting `at` on a held-out
/// part.
pub(crate) fn simplest_good(
    n_tried: usize,
    n_parts: usize,
    square: impl Fn(usize, usize) -> f64,
) -> usize {
    let Some(last) = n_tried.checked_sub(1) else { return 0 };
    let squares: Vec<Vec<f64>> =
        (0..n_tried).rev().map(|at| (0..n_parts).map(|part| square(at, part)).collect()).collect();
    let is_finite = |errors: &Vec<f64>| errors.iter().all(|square| square.is_finite());
    if !is_finite(&squares[0]) {
        // The simplest setting cannot be fitted, so the simplest one that can be fitted is chosen.
        return (0..n_tried).rev().find(|at| is_finite(&squares[last - at])).unwrap_or(0);
    }
    let blocks = Blocks::of_parts(&vec![1; n_parts]);
    last - blocks.choose(n_tried, NEARLY, |at| &squares[at]).smallest
}

/// Factors that are tried for the prediction of a hybrid regressor's network or kernel. With zero, the linear part stands
/// alone.
pub(crate) const SHARES: [f64; 5] = [1.0, 0.75, 0.5, 0.25, 0.0];

/// Returns the index of the best factor in [`SHARES`], or of the factor zero if its error is nearly as low. `square(at,
/// part)` is the squared error with factor `at` on a held-out part.
pub(crate) fn best_share(n_parts: usize, square: impl Fn(usize, usize) -> f64) -> usize {
    let sum = |at: &usize| (0..n_parts).map(|part| square(*at, part)).sum::<f64>();
    let best = (0..SHARES.len()).min_by(|a, b| sum(a).total_cmp(&sum(b)));
    let tried = [best.unwrap_or(0), SHARES.len() - 1];
    tried[simplest_good(tried.len(), n_parts, |at, part| square(tried[at], part))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Chooses among fits with these mean squared errors in ten blocks, which form groups of two.
    fn chosen(within: f64, fits: &[[f64; 10]]) -> Choice {
        let blocks = Blocks { samples: vec![1.0; 10], groups: (0..10).map(|at| at / 2).collect() };
        blocks.choose(fits.len(), within, |at| &fits[at])
    }

    /// Values from tables of Student's t.
    #[test]
    fn the_quantile_equals_tables() {
        for (freedom, expected) in
            [(1, 3.078), (2, 1.886), (3, 1.638), (4, 1.533), (9, 1.383), (30, 1.310), (1000, 1.282)]
        {
            assert!((t_beyond(f64::from(freedom), 0.1) - expected).abs() < 3e-3, "{freedom}");
        }
    }

    /// Without a tenth at each end, the mean of 1 … 10 is the same. Yuen's standard error is the winsorised one divided by 0.8.
    #[test]
    fn the_standard_error_is_yuens() {
        let one: Vec<f64> = (1..=10).map(f64::from).collect();
        let blocks = Blocks::of_parts(&[1; 10]);
        let found = blocks.compare(&one, &[0.0; 10]);
        assert!((found.trimmed - 5.5).abs() < 1e-12 && (found.difference - 5.5).abs() < 1e-12);
        // Winsorised: 2 2 3 4 5 6 7 8 9 9, of variance 66.5/9.
        let expected = (66.5_f64 / 9.0).sqrt() / (0.8 * 10_f64.sqrt());
        assert!((found.standard_error - expected).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn all_alike_leaves_the_conventional_calibration() {
        let found = chosen(0.05, &[[1.0; 10]; 4]);
        assert_eq!((found.accurate, found.smallest), (0, 0));
        assert_eq!(found.refused[1], Some(Refusal::NotBetter));
        assert_eq!(simplest_good(3, 4, |_, _| 4.0), 2);
    }

    #[test]
    fn of_two_equally_good_fits_the_smaller_is_chosen() {
        let found = chosen(0.05, &[[1.0; 10], [0.5; 10], [0.5; 10]]);
        assert_eq!(found.smallest, 1);
        // The RMSE is 3 % above the lowest in every block.
        let near = 0.5 * 1.03 * 1.03;
        let found = chosen(0.05, &[[1.0; 10], [near; 10], [0.5; 10]]);
        assert_eq!((found.accurate, found.smallest), (2, 1));
        let found = chosen(0.02, &[[1.0; 10], [near; 10], [0.5; 10]]);
        assert_eq!((found.accurate, found.smallest), (2, 2));
    }

    /// An extreme block raises the standard error, and must not make its candidate eligible.
    #[test]
    fn one_extreme_block_does_not_make_a_candidate_eligible() {
        let mut wild = [0.3; 10];
        wild[7] = 50.0;
        let found = chosen(0.05, &[[1.0; 10], wild, [0.4; 10]]);
        assert_eq!((found.accurate, found.smallest), (2, 2));
        let Some(Refusal::Harms { group: 3, ratio }) = found.refused[1] else {
            panic!("{found:?}")
        };
        assert!((ratio - (50.3_f64 / 2.0).sqrt()).abs() < 1e-12);
    }

    /// A block with large errors in all fits must not hide a difference.
    #[test]
    fn one_extreme_block_does_not_hide_a_gain() {
        let (mut conventional, mut better) = ([1.0; 10], [0.5; 10]);
        (conventional[4], better[4]) = (80.0, 82.0);
        let blocks = Blocks::of_parts(&[1; 10]);
        assert!(blocks.compare(&better, &conventional).trimmed < -0.3);
        (conventional[4], better[4]) = (82.0, 80.0);
        assert!(blocks.is_below(&better, &conventional, 1.0));
    }

    #[test]
    fn a_group_that_is_harmed_refuses_a_candidate() {
        let mut harms = [0.2; 10];
        harms[2..4].copy_from_slice(&[1.3, 1.3]);
        let found = chosen(0.05, &[[1.0; 10], harms]);
        assert_eq!((found.accurate, found.smallest), (0, 0));
        assert!(matches!(found.refused[1], Some(Refusal::Harms { group: 1, .. })));
        harms[2..4].copy_from_slice(&[1.15, 1.15]);
        assert_eq!(chosen(0.05, &[[1.0; 10], harms]).accurate, 1);
    }

    /// An error that is large only relative to a very small conventional error does not count as harm.
    #[test]
    fn a_group_without_error_does_not_refuse_all() {
        let (mut conventional, mut fitted) = ([1.0; 10], [0.3; 10]);
        conventional[..2].copy_from_slice(&[0.01; 2]);
        fitted[..2].copy_from_slice(&[0.02; 2]);
        assert_eq!(chosen(0.05, &[conventional, fitted]).accurate, 1);
    }

    /// Checks one group of six blocks, then two blocks, then one block.
    #[test]
    fn few_parts_must_agree() {
        let blocks = Blocks { samples: vec![5.0; 6], groups: vec![0; 6] };
        assert!(blocks.is_below(&[0.5, 0.6, 0.4, 0.5, 0.7, 0.5], &[1.0; 6], 1.0));
        assert!(!blocks.is_below(&[0.5, 1.6, 0.4, 1.5, 0.7, 1.1], &[1.0; 6], 1.0));
        let two = Blocks::of_parts(&[1, 1]);
        assert!(two.is_below(&[0.1, 0.9], &[1.0; 2], 1.0));
        assert!(!two.is_below(&[0.1, 1.1], &[1.0; 2], 1.0));
        assert!(!Blocks::of_parts(&[1]).is_below(&[0.1], &[1.0], 1.0));
    }

    /// With noise alone, a candidate is accepted in at most a tenth of the cases, as the confidence requires.
    #[test]
    fn noise_is_accepted_as_a_gain_in_a_tenth_of_the_cases() {
        let mut random = Random::new(5, &[]);
        let mut taken = 0;
        for _ in 0..2_000 {
            let mut of = || -> Vec<f64> { (0..12).map(|_| random.normal().powi(2)).collect() };
            let (one, other) = (of(), of());
            taken += usize::from(Blocks::of_parts(&[1; 12]).is_below(&one, &other, 1.0));
        }
        assert!((100..260).contains(&taken), "{taken} of 2000");
    }

    /// Over three parts, the second setting is worse than the first by 1, 2, 3.
    #[test]
    fn the_simplest_is_chosen_unless_another_is_better_with_confidence() {
        let worse = [[5.0, 5.0, 5.0], [6.0, 7.0, 8.0]];
        assert_eq!(simplest_good(2, 3, |at, part| worse[at][part]), 0);
        let unsure = [[5.0, 5.0, 5.0], [5.0, 3.0, 8.0]];
        assert_eq!(simplest_good(2, 3, |at, part| unsure[at][part]), 1);
        let broken = [5.0, f64::INFINITY];
        assert_eq!(simplest_good(2, 3, |at, _| broken[at]), 0);
    }

    /// A target of 1 is reduced by a share of `learned` in each part; the squares are those of the remainder.
    #[test]
    fn a_second_stage_is_added_with_its_best_share_or_not_at_all() {
        let share = |learned: [f64; 4]| {
            let rest = |at: usize, part: usize| (1.0 - SHARES[at] * learned[part]).powi(2);
            SHARES[best_share(4, rest)]
        };
        assert_eq!(share([1.0, 0.9, 1.1, 1.0]), 1.0);
        assert_eq!(share([2.0, 1.9, 2.1, 2.0]), 0.5);
        assert_eq!(share([0.0; 4]), 0.0);
        assert_eq!(share([2.0, -1.5, 1.0, -2.0]), 0.0);
    }
}
