//! Whether one fit predicts left-out parts better than another, or only luckier.

use crate::calibration::Paired;

/// Compares two fits by their squared errors on each part.
///
/// Pairs, because some recordings are hard for every threshold: what they share cancels.
///
/// **Shapes** `one` and `other` hold `n_parts × n_axes` sums of squared errors; `weights` one factor per axis, see
/// [`Measure::weights`](crate::questions::thresholds::Measure::weights).
///
/// **Units** those of the measure, squared.
///
/// `None` with fewer than two parts.
pub fn paired(one: &[f64], other: &[f64], part_samples: &[u64], weights: &[f64]) -> Option<Paired> {
    if part_samples.iter().filter(|n| **n > 0).count() < 2 {
        return None;
    }
    let total = part_samples.iter().sum::<u64>() as f64;
    let q = weights.len();
    // Each part's share of the difference: `w d`.
    let shares: Vec<(f64, f64)> = one
        .chunks_exact(q)
        .zip(other.chunks_exact(q))
        .zip(part_samples)
        .map(|((one, other), n)| {
            let squares = one.iter().zip(other).zip(weights);
            let difference: f64 = squares.map(|((a, b), weight)| weight * (a - b)).sum();
            (*n as f64 / total, difference / total)
        })
        .collect();
    Some(Paired::of(&shares))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four parts of ten samples, mean squares 1 2 3 6 above the other's: mean 3, deviation √(14/3), over √4.
    #[test]
    fn equal_parts_give_the_textbook_standard_error() {
        let one = [10.0, 20.0, 30.0, 60.0].map(|d| 50.0 + d);
        let paired = paired(&one, &[50.0; 4], &[10; 4], &[1.0]).unwrap();
        assert!((paired.difference - 3.0).abs() < 1e-12);
        assert!((paired.standard_error - (14.0_f64 / 3.0).sqrt() / 2.0).abs() < 1e-12);
        assert!(!paired.is_within_one_standard_error());
    }

    /// Weights 1 and 4 over two axes; a part with three times the samples counts three times.
    #[test]
    fn axes_are_weighted_and_parts_count_by_their_samples() {
        let one = [2.0, 1.0, 0.0, 0.0];
        let found = paired(&one, &[0.0; 4], &[1, 3], &[1.0, 4.0]).unwrap();
        assert!((found.difference - 6.0 / 4.0).abs() < 1e-12);
        // Shares w d: 1.5 and 0; less w D: 1.125 and −1.125.
        let expected = (2.0 * 2.0 * 1.125_f64.powi(2)).sqrt();
        assert!((found.standard_error - expected).abs() < 1e-12);
    }

    #[test]
    fn one_part_says_nothing_about_luck() {
        assert_eq!(paired(&[1.0], &[2.0], &[5], &[1.0]), None);
    }
}
