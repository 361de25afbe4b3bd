//! The rule by which strengths and models are chosen: of those that do as well as the best within one standard error, the
//! simplest.
//!
//! Guarantees: what parts disagree about is not taken for better; where all are alike, the simplest is taken.

/// Where only one of two parts tells what is tried apart, mean and standard error are equal, and rounding must not decide.
const TIE: f64 = 1e-9;

/// The position of the last, which is the simplest, of `n_tried` whose squared errors exceed those of the best by no more
/// than one standard error of the difference over the parts; `square(at, part)` is the sum of squares of a part. What has a
/// square that is not finite is not taken.
pub(crate) fn simplest_good(
    n_tried: usize,
    n_parts: usize,
    square: impl Fn(usize, usize) -> f64,
) -> usize {
    let tried = 0..n_tried;
    let sum = |at: usize| (0..n_parts).map(|part| square(at, part)).sum::<f64>();
    let best = tried.clone().min_by(|a, b| sum(*a).total_cmp(&sum(*b))).unwrap_or(0);
    let chosen = tried.rev().find(|&at| {
        let differences = (0..n_parts).map(|part| square(at, part) - square(best, part));
        let n = n_parts as f64;
        let parts: Vec<(f64, f64)> = differences.map(|own| (1.0 / n, own / n)).collect();
        Paired::of(&parts).is_within_one_standard_error()
    });
    chosen.unwrap_or(best)
}

/// How much larger one mean squared error is than another, over the same parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paired {
    /// The difference of the pooled mean squared errors.
    pub difference: f64,
    /// Its standard error, over the parts.
    pub standard_error: f64,
}

impl Paired {
    /// Of each part's share `w` of the samples, and `w d` with `d` its difference of mean squared errors.
    ///
    /// The difference is `D = Σ w d` and its standard error `√(R/(R−1) Σ w² (d − D)²)` over R parts: for parts of equal size the
    /// deviation of `d` over √R, for a single one zero.
    pub(crate) fn of(parts: &[(f64, f64)]) -> Self {
        let difference: f64 = parts.iter().map(|(_, share)| share).sum();
        let squares = parts.iter().map(|(w, share)| (share - w * difference).powi(2));
        let n = parts.iter().filter(|(w, _)| *w > 0.0).count() as f64;
        let correction = n / (n - 1.0).max(1.0);
        Self { difference, standard_error: (correction * squares.sum::<f64>()).sqrt() }
    }

    /// Whether the difference is no larger than its standard error.
    pub fn is_within_one_standard_error(&self) -> bool {
        self.difference <= self.standard_error * (1.0 + TIE)
    }
}

/// How much of what a second stage has learned may be added to the linear one, the most first; with nothing the linear one
/// stands alone.
pub(crate) const SHARES: [f64; 5] = [1.0, 0.75, 0.5, 0.25, 0.0];

/// The position of the best of [`SHARES`]; nothing, where that does as well within one standard error. `square(at, part)` is
/// the sum of squares of a part with a share.
///
/// What is learned is not shrunk a second time: a share between only says that two stages agree about the direction, not
/// about the size.
pub(crate) fn best_share(n_parts: usize, square: impl Fn(usize, usize) -> f64) -> usize {
    let sum = |at: &usize| (0..n_parts).map(|part| square(*at, part)).sum::<f64>();
    let best = (0..SHARES.len()).min_by(|a, b| sum(a).total_cmp(&sum(b)));
    let tried = [best.unwrap_or(0), SHARES.len() - 1];
    tried[simplest_good(tried.len(), n_parts, |at, part| square(tried[at], part))]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over three parts the second is 1, 2, 3 worse than the first: by 2 with a standard error of 1/√3.
    #[test]
    fn what_all_parts_say_is_worse_is_not_taken_and_what_they_disagree_about_is() {
        let worse = [[5.0, 5.0, 5.0], [6.0, 7.0, 8.0]];
        assert_eq!(simplest_good(2, 3, |at, part| worse[at][part]), 0);
        let unsure = [[5.0, 5.0, 5.0], [5.0, 3.0, 8.0]];
        assert_eq!(simplest_good(2, 3, |at, part| unsure[at][part]), 1);
        assert_eq!(simplest_good(2, 3, |_, _| 4.0), 1);
        let broken = [5.0, f64::INFINITY];
        assert_eq!(simplest_good(2, 3, |at, _| broken[at]), 0);
        assert_eq!(simplest_good(2, 1, |at, _| [1.0, 2.0][at]), 0);
    }

    /// What remains of a target of 1 when a share of `learned` is taken off it, part by part.
    #[test]
    fn a_second_stage_is_taken_by_its_best_share_or_not_at_all() {
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
