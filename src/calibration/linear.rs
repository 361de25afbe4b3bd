//! Linear least squares from sums alone (Eq. 8), with the rank it really has, and ridge regression from the same sums.
//!
//! Guarantees: a column that is zero, or that the others already explain, gets the coefficient zero; so a past that
//! never differs leaves the conventional answer, exactly.

use faer::{Mat, Side};

use crate::calibration::NormalEquations;

/// A column counts as explained by the others when what is left of its squared length is below this share.
///
/// Sums carry relative rounding errors near 1e-15; squared lengths, so columns down to 1e-6 of their length survive.
const EXPLAINED_BELOW: f64 = 1e-12;

/// A least-squares solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// `p × q`, row-major; zero where a column was left out.
    pub coefficients: Vec<f64>,
    /// How many columns are independent.
    pub rank: usize,
}

/// How coefficients are shrunk: `min ‖Y − XB‖² + Σ penaltyⱼ bⱼ²`.
///
/// Targets are what the conventional calibration leaves over, and gauges and offset are not shrunk: the stronger the
/// ridge, the nearer the answer to the conventional one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ridge<'a> {
    /// Plain least squares.
    None,
    /// `penaltyⱼ = strength · ‖xⱼ‖²` for the columns that are marked: 1 halves the coefficient of a lone column.
    Relative {
        /// From zero up.
        strength: f64,
        /// One mark per column.
        columns: &'a [bool],
    },
    /// `penaltyⱼ = strength` for the columns that are marked: the variance of the noise over that of the coefficient.
    Absolute {
        /// From zero up.
        strength: f64,
        /// One mark per column.
        columns: &'a [bool],
    },
}

impl<'a> Ridge<'a> {
    /// The same columns and scale with another strength.
    #[must_use]
    pub fn with_strength(self, strength: f64) -> Self {
        match self {
            Self::None => Self::None,
            Self::Relative { columns, .. } => Self::Relative { strength, columns },
            Self::Absolute { columns, .. } => Self::Absolute { strength, columns },
        }
    }

    fn penalty(self, sums: &NormalEquations, column: usize) -> f64 {
        match self {
            Self::Relative { strength, columns } if columns[column] => {
                strength * sums.feature_product(column, column)
            }
            Self::Absolute { strength, columns } if columns[column] => strength,
            _ => 0.0,
        }
    }
}

/// Solves `min ‖Y − XB‖²`, shrunk by `ridge`, using the columns in `used` alone; the others get zero coefficients.
///
/// Cholesky with diagonal pivoting on columns scaled to unit length. The cost does not depend on the number of
/// samples: `O(p³ + p²q)`.
///
/// **Source** Eq. 5 and 8; with a ridge the diagonal of `XᵀX` grows by the penalties.
///
/// # Panics
/// If `used` names a column that is not there, or a ridge has another number of columns.
#[must_use]
pub fn fit(sums: &NormalEquations, used: &[usize], ridge: Ridge<'_>) -> Fit {
    let (m, q) = (used.len(), sums.n_targets());
    let penalties: Vec<f64> = used.iter().map(|&i| ridge.penalty(sums, i)).collect();
    let inverse_length: Vec<f64> = used
        .iter()
        .zip(&penalties)
        .map(|(&i, penalty)| inverse_length(sums.feature_product(i, i) + penalty))
        .collect();
    // The lower triangle of the scaled Gram matrix; becomes the factor, column by column.
    let mut lower: Vec<f64> = vec![0.0; m * m];
    for i in 0..m {
        for j in 0..=i {
            lower[i * m + j] =
                sums.feature_product(used[i], used[j]) * inverse_length[i] * inverse_length[j];
        }
        lower[i * m + i] += penalties[i] * inverse_length[i] * inverse_length[i];
    }
    let mut order: Vec<usize> = (0..m).collect();
    let mut rank = 0;
    while rank < m {
        let (pivot, largest) = (rank..m).map(|i| (i, lower[i * m + i])).fold(
            (rank, f64::NEG_INFINITY),
            |best, one| {
                if one.1 > best.1 { one } else { best }
            },
        );
        if largest.is_nan() || largest <= EXPLAINED_BELOW {
            break;
        }
        swap_symmetric(&mut lower, m, rank, pivot);
        order.swap(rank, pivot);
        let root = largest.sqrt();
        lower[rank * m + rank] = root;
        for i in rank + 1..m {
            lower[i * m + rank] /= root;
        }
        for i in rank + 1..m {
            let factor = lower[i * m + rank];
            for j in rank + 1..=i {
                lower[i * m + j] -= factor * lower[j * m + rank];
            }
        }
        rank += 1;
    }
    let mut coefficients = vec![0.0; sums.n_features() * q];
    let mut solution = vec![0.0; rank];
    for target in 0..q {
        for i in 0..rank {
            let known: f64 = (0..i).map(|j| lower[i * m + j] * solution[j]).sum();
            let right = sums.target_product(used[order[i]], target) * inverse_length[order[i]];
            solution[i] = (right - known) / lower[i * m + i];
        }
        for i in (0..rank).rev() {
            let known: f64 = (i + 1..rank).map(|j| lower[j * m + i] * solution[j]).sum();
            solution[i] = (solution[i] - known) / lower[i * m + i];
            coefficients[used[order[i]] * q + target] = solution[i] * inverse_length[order[i]];
        }
    }
    Fit { coefficients, rank }
}

/// Like [`fit`], with a relative ridge of its own strength for each target.
///
/// The rank is that of the columns themselves, without a ridge.
///
/// # Panics
/// If there is not one strength per target and one mark per column.
#[must_use]
pub fn fit_targets(
    sums: &NormalEquations,
    used: &[usize],
    columns: &[bool],
    strengths: &[f64],
) -> Fit {
    let q = sums.n_targets();
    assert_eq!(strengths.len(), q, "one strength per target");
    let mut found = fit(sums, used, Ridge::None);
    for (at, &strength) in strengths.iter().enumerate() {
        if strength == 0.0 || strengths[..at].contains(&strength) {
            continue;
        }
        let shrunk = fit(sums, used, Ridge::Relative { strength, columns }).coefficients;
        for target in (at..q).filter(|target| strengths[*target] == strength) {
            for feature in 0..sums.n_features() {
                found.coefficients[feature * q + target] = shrunk[feature * q + target];
            }
        }
    }
    found
}

/// The condition number of the design: the largest over the smallest singular value of its independent columns, each
/// scaled to unit length; `None` where no column is independent.
///
/// Computed from sums, so values beyond about 1e7 only say "very large".
#[must_use]
pub fn condition_number(sums: &NormalEquations, used: &[usize], rank: usize) -> Option<f64> {
    let inverse_length: Vec<f64> = used
        .iter()
        .map(|&i| inverse_length(sums.feature_product(i, i)))
        .collect();
    let scaled = Mat::from_fn(used.len(), used.len(), |i, j| {
        sums.feature_product(used[i], used[j]) * inverse_length[i] * inverse_length[j]
    });
    let mut squares = scaled.self_adjoint_eigenvalues(Side::Lower).ok()?;
    squares.sort_unstable_by(|a, b| b.total_cmp(a));
    let smallest = squares[rank.checked_sub(1)?];
    (smallest > 0.0).then(|| (squares[0] / smallest).sqrt())
}

fn inverse_length(square: f64) -> f64 {
    if square > 0.0 {
        1.0 / square.sqrt()
    } else {
        0.0
    }
}

/// Exchanges rows and columns `a ≤ b` of the lower triangle, the finished part of the factor included.
fn swap_symmetric(lower: &mut [f64], m: usize, a: usize, b: usize) {
    if a == b {
        return;
    }
    for j in 0..a {
        lower.swap(a * m + j, b * m + j);
    }
    lower.swap(a * m + a, b * m + b);
    for i in a + 1..b {
        lower.swap(i * m + a, b * m + i);
    }
    for i in b + 1..m {
        lower.swap(i * m + a, i * m + b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::linalg::solvers::SolveLstsq as _;

    fn sums(rows: &[Vec<f64>], p: usize) -> NormalEquations {
        let mut sums = NormalEquations::new(p, rows[0].len() - p);
        let stride = sums.stride();
        for row in rows {
            let mut padded = row.clone();
            padded.resize(stride, 0.0);
            sums.add_rows(&padded);
        }
        sums
    }

    /// Rows `[1, a, b, c | y₀, y₁]` with no exact relation.
    fn rows(m: usize) -> Vec<Vec<f64>> {
        (0..m)
            .map(|k| {
                let t = k as f64;
                let (a, b, c) = ((0.3 * t).sin(), (0.17 * t + 1.0).cos(), (0.05 * t).sin());
                let noise = ((k * 37) % 11) as f64 * 0.01;
                vec![1.0, a, b, c, 2.0 * a - b + noise, c + 0.5 * b * b]
            })
            .collect()
    }

    #[test]
    fn coefficients_equal_those_of_a_qr_solution() {
        let rows = rows(200);
        let fit = fit(&sums(&rows, 4), &[0, 1, 2, 3], Ridge::None);
        let x = Mat::from_fn(200, 4, |i, j| rows[i][j]);
        let y = Mat::from_fn(200, 2, |i, j| rows[i][4 + j]);
        let qr = x.col_piv_qr().solve_lstsq(&y);
        assert_eq!(fit.rank, 4);
        for i in 0..4 {
            for j in 0..2 {
                assert!((fit.coefficients[i * 2 + j] - qr[(i, j)]).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn a_zero_column_changes_nothing() {
        let with_zero: Vec<_> = rows(80)
            .into_iter()
            .map(|mut row| {
                row.insert(4, 0.0);
                row
            })
            .collect();
        let plain = fit(&sums(&rows(80), 4), &[0, 1, 2, 3], Ridge::None);
        let padded = fit(&sums(&with_zero, 5), &[0, 1, 2, 3, 4], Ridge::None);
        assert_eq!(padded.rank, 4);
        assert_eq!(padded.coefficients[..8], plain.coefficients);
        assert_eq!(padded.coefficients[8..], [0.0, 0.0]);
    }

    #[test]
    fn a_repeated_column_lowers_the_rank_and_keeps_the_residual() {
        let rows = rows(80);
        let repeated: Vec<_> = rows
            .iter()
            .map(|row| [&row[..4], &row[2..3], &row[4..]].concat())
            .collect();
        let plain_sums = sums(&rows, 4);
        let plain = fit(&plain_sums, &[0, 1, 2, 3], Ridge::None);
        let repeated_sums = sums(&repeated, 5);
        let repeated = fit(&repeated_sums, &[0, 1, 2, 3, 4], Ridge::None);
        assert_eq!(repeated.rank, 4);
        let (a, b) = (
            plain_sums.squared_residuals(&plain.coefficients),
            repeated_sums.squared_residuals(&repeated.coefficients),
        );
        assert!((a[0] - b[0]).abs() < 1e-9 * a[0]);
    }

    /// `(XᵀX + D) b = Xᵀy` holds, with D as the ridge defines it.
    #[test]
    fn a_ridge_solves_the_normal_equations_with_its_penalties() {
        let sums = sums(&rows(80), 4);
        let columns = [false, true, true, false];
        for ridge in [
            Ridge::Relative {
                strength: 0.3,
                columns: &columns,
            },
            Ridge::Absolute {
                strength: 7.0,
                columns: &columns,
            },
        ] {
            let b = fit(&sums, &[0, 1, 2, 3], ridge).coefficients;
            for i in 0..4 {
                let product: f64 = (0..4).map(|j| sums.feature_product(i, j) * b[j * 2]).sum();
                let left = product + ridge.penalty(&sums, i) * b[i * 2];
                assert!((left - sums.target_product(i, 0)).abs() < 1e-9);
            }
            let (weak, strong) = (ridge.with_strength(1e-14), ridge.with_strength(1e14));
            let free = fit(&sums, &[0, 1, 2, 3], Ridge::None).coefficients;
            let nearly = fit(&sums, &[0, 1, 2, 3], weak).coefficients;
            assert!((free[2] - nearly[2]).abs() < 1e-9);
            assert!(fit(&sums, &[0, 1, 2, 3], strong).coefficients[2].abs() < 1e-9);
        }
    }

    #[test]
    fn no_samples_give_zero_coefficients() {
        let fit = fit(&NormalEquations::new(2, 1), &[0, 1], Ridge::None);
        assert_eq!((fit.rank, fit.coefficients), (0, vec![0.0, 0.0]));
    }

    #[test]
    fn orthogonal_columns_have_condition_one() {
        let rows = vec![vec![1.0, 1.0, 0.0], vec![1.0, -1.0, 0.0]];
        let condition = condition_number(&sums(&rows, 2), &[0, 1], 2).unwrap();
        assert!((condition - 1.0).abs() < 1e-12);
    }
}
