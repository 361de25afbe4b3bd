//! Number of coefficients of a fit that the recordings determine, instead of the ridge.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};

use crate::calibration::NormalEquations;

/// Number that is added to the diagonal of the Gram matrix of columns with unit length, so that the matrix stays invertible
/// if columns are undetermined. [`fit`](crate::calibration::fit) drops a column if the share that the other columns do not
/// explain is smaller.
const NOTHING: f64 = 1e-12;
/// Returns the effective number of coefficients of a fit with ridge: the trace of `(G + D)⁻¹ G` with Gram matrix G and
/// penalties D. `shares` is the penalty of each column as in [`Ridge::Shares`](crate::calibration::Ridge::Shares).
pub fn free_coefficients(sums: &NormalEquations, shares: &[f64]) -> Option<f64> {
    let all: Vec<usize> =
        (0..sums.n_features()).filter(|column| shares[*column].is_finite()).collect();
    let columns = sums.present_among(&all);
    let n = columns.len();
    let length = |i: usize| sums.feature_product(columns[i], columns[i]).sqrt();
    let gram = Mat::from_fn(n, n, |i, j| {
        sums.feature_product(columns[i], columns[j]) / (length(i) * length(j))
    });
    let shrunk = Mat::from_fn(n, n, |i, j| {
        let on_diagonal = if i == j { shares[columns[i]] + NOTHING } else { 0.0 };
        gram[(i, j)] + on_diagonal
    });
    let solved = shrunk.llt(Side::Lower).ok()?.solve(&gram);
    Some((0..n).map(|i| solved[(i, i)]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const P: usize = 5;

    /// Returns the sums of random rows of features. With `repeats`, the last feature copies the first.
    fn data(seed: u64, repeats: bool) -> NormalEquations {
        let mut random = Random::new(seed, &[1]);
        let mut sums = NormalEquations::new(P, 1);
        let stride = sums.stride();
        let mut row = || {
            let mut row: Vec<f64> =
                (0..P).map(|at| 10_f64.powi(at as i32 - 2) * random.normal()).collect();
            row[1] += 5.0 * row[0];
            if repeats {
                row[P - 1] = row[0];
            }
            row
        };
        for _ in 0..40 {
            let mut padded = row();
            padded.resize(stride, 0.0);
            sums.add_rows(&padded);
        }
        sums
    }

    #[test]
    fn a_column_that_repeats_another_adds_no_free_coefficient() {
        let repeated = data(3, true);
        let free = free_coefficients(&repeated, &[0.0; P]).unwrap();
        assert!((free - 4.0).abs() < 1e-3, "{free}");
    }

    /// A ridge of λ times the squared length leaves 1/(1 + λ) of the coefficient of a single column.
    #[test]
    fn a_ridge_leaves_a_part_of_the_coefficients_free() {
        let sums = data(1, false);
        let only = |shares: [f64; P]| free_coefficients(&sums, &shares).unwrap();
        assert!((only([0.0; P]) - 5.0).abs() < 1e-6);
        let gone = f64::INFINITY;
        assert!((only([3.0, gone, gone, gone, gone]) - 0.25).abs() < 1e-9);
    }
}
