//! Probability that two groups of data parts differ at least this much by chance, given the scatter of the parts within
//! each group.

use statrs::function::beta::checked_beta_reg;

/// Minimum number of parts of the data for a test of the difference between two groups.
const FEWEST: usize = 3;

/// Returns the probability that values follow a straight line in `x` this closely by chance, or 1 if there are fewer than
/// [`FEWEST`] values. If each `x` is 0 or 1, this is the probability that the weighted means of the two groups differ this
/// much by chance.
///
/// It is an F test whose degrees of freedom allow for values that scatter together (Satterthwaite).
///
/// **Shapes** one row of values and one weight for each part.
pub fn of_slope(values: &[Vec<f64>], weights: &[f64], x: &[f64]) -> f64 {
    let largest = weights.iter().copied().fold(0.0, f64::max);
    let used: Vec<usize> = (0..values.len()).filter(|at| weights[*at] > 1e-12 * largest).collect();
    let all: f64 = used.iter().map(|at| weights[*at]).sum();
    let width = values.first().map_or(0, Vec::len);
    let mean =
        |of: &dyn Fn(usize) -> f64| used.iter().map(|at| weights[*at] * of(*at)).sum::<f64>() / all;
    let x_mean = mean(&|at| x[at]);
    let spread: f64 = used.iter().map(|at| weights[*at] * (x[*at] - x_mean).powi(2)).sum();
    if used.len() < FEWEST || spread.is_nan() || spread <= 1e-12 * all {
        return 1.0;
    }
    let means: Vec<f64> = (0..width).map(|i| mean(&|at| values[at][i])).collect();
    let slope = |i: usize| {
        let products = used.iter().map(|at| weights[*at] * (x[*at] - x_mean) * values[*at][i]);
        products.sum::<f64>() / spread
    };
    let slopes: Vec<f64> = (0..width).map(slope).collect();
    let rest = |at: usize, i: usize| values[at][i] - means[i] - slopes[i] * (x[at] - x_mean);
    let freedom = (used.len() - 2) as f64;
    let product = |i: usize, j: usize| {
        let products = used.iter().map(|at| weights[*at] * rest(*at, i) * rest(*at, j));
        products.sum::<f64>() / freedom
    };
    let trace: f64 = (0..width).map(|i| product(i, i)).sum();
    let squares: f64 = (0..width)
        .flat_map(|i| (0..width).map(move |j| (i, j)))
        .map(|(i, j)| product(i, j).powi(2))
        .sum();
    if trace.is_nan() || trace <= 0.0 {
        return 0.0;
    }
    let directions = (trace * trace / squares.max(f64::MIN_POSITIVE)).clamp(1.0, width as f64);
    let explained: f64 = slopes.iter().map(|slope| slope * slope).sum::<f64>() * spread;
    beyond_f(explained / trace, directions, directions * freedom)
}

/// Returns the probability that an F-distributed value with these degrees of freedom is larger than `f`.
pub fn beyond_f(f: f64, d1: f64, d2: f64) -> f64 {
    checked_beta_reg(0.5 * d2, 0.5 * d1, d2 / (d2 + d1 * f)).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SciPy 1.17: `stats.f.sf`, `stats.ttest_ind`.
    #[test]
    fn chances_are_those_of_the_tables() {
        for (f, d1, d2, expected) in [
            (4.0, 1.0, 10.0, 0.073_388_034),
            (30.0, 3.0, 12.0, 7.373_0e-6),
            (1.0, 5.5, 44.0, 0.433_495),
        ] {
            let own = beyond_f(f, d1, d2);
            assert!((own / expected - 1.0).abs() < 1e-4, "{own} {expected}");
        }
        let values: Vec<Vec<f64>> =
            [1.0, 2.0, 3.0, 6.0, 7.0, 9.0].map(|value| vec![value]).to_vec();
        let own = of_slope(&values, &[1.0; 6], &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        assert!((own - 0.007_182).abs() < 2e-6, "{own}");
        assert_eq!(of_slope(&values[..2], &[1.0; 2], &[0.0, 1.0]), 1.0);
    }
}
