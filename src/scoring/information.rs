//! Information that recordings contain about the coefficients of a fit, and the loads whose recording would add most
//! information.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};

use crate::calibration::{NormalEquations, unit_gram};
use crate::dot::dot;

/// Number that is added to the diagonal of the Gram matrix of columns with unit length, so that the matrix stays invertible
/// if columns are undetermined. [`fit`](crate::calibration::fit) drops a column if the share that the other columns do not
/// explain is smaller.
const NOTHING: f64 = 1e-12;
/// Number that is added to the same diagonal when loads are proposed, so that an undetermined coefficient has a finite
/// variance.
const PRIOR: f64 = 1e-6;

/// Gram matrix of some feature columns, each scaled to unit length, given by its eigenvalues and eigenvectors.
#[derive(Clone, Debug)]
pub struct Information {
    /// Indices of the columns in the Gram matrix. Columns that are zero in every sample are left out.
    columns: Vec<usize>,
    /// Reciprocal length of each column before it is scaled to unit length.
    inverse_lengths: Vec<f64>,
    /// Eigenvalues in ascending order: the squared singular values of the columns.
    squares: Vec<f64>,
    /// Eigenvector of each eigenvalue.
    directions: Vec<Vec<f64>>,
}

impl Information {
    /// Returns the information on these columns; `None` if all of them are zero.
    pub fn of(sums: &NormalEquations, columns: &[usize]) -> Option<Self> {
        let columns = sums.present_among(columns);
        let (scaled, inverse_lengths) = unit_gram(sums, &columns);
        let n = columns.len();
        let parts = (n > 0).then(|| scaled.self_adjoint_eigen(Side::Lower))?.ok()?;
        let (values, vectors) = (parts.S().column_vector(), parts.U());
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        Some(Self {
            squares: order.iter().map(|at| values[*at].max(0.0)).collect(),
            directions: (order.iter())
                .map(|at| (0..n).map(|column| vectors[(column, *at)]).collect())
                .collect(),
            columns,
            inverse_lengths,
        })
    }

    /// Reduces a row of all feature values to the columns of this matrix, and scales it like them.
    fn scaled(&self, row: &[f64]) -> Vec<f64> {
        let columns = self.columns.iter().zip(&self.inverse_lengths);
        columns.map(|(column, factor)| row[*column] * factor).collect()
    }

    fn solve(&self, row: &[f64]) -> Vec<f64> {
        let mut solution = vec![0.0; row.len()];
        for (square, direction) in self.squares.iter().zip(&self.directions) {
            let factor = dot(direction, row) / (square + PRIOR);
            for (out, own) in solution.iter_mut().zip(direction) {
                *out += factor * own;
            }
        }
        solution
    }

    /// Returns up to `count` loads that should be recorded next, each in a dwell of `weight` samples. `rows` holds the
    /// feature values of the possible loads. Each chosen row increases the logarithm of the determinant of the Gram matrix
    /// most (greedy D-optimal design). `region` holds the rows at which the variance of predictions is compared.
    pub fn next_best(
        &self,
        rows: &[Vec<f64>],
        region: &[Vec<f64>],
        weight: f64,
        count: usize,
    ) -> Vec<NextRow> {
        let rows: Vec<Vec<f64>> = rows.iter().map(|row| self.scaled(row)).collect();
        let region: Vec<Vec<f64>> = region.iter().map(|row| self.scaled(row)).collect();
        let variance = |row: &Vec<f64>| -> f64 {
            let directions = self.squares.iter().zip(&self.directions);
            directions.map(|(square, own)| dot(own, row).powi(2) / (square + PRIOR)).sum()
        };
        let mut variances: Vec<f64> = rows.iter().map(variance).collect();
        let mut of_region: Vec<f64> = region.iter().map(variance).collect();
        let before: f64 = of_region.iter().sum();
        // With the inverse Gram matrix C and v = xᵀCx, a chosen row x reduces the variance uᵀCu at a row u by `weight ·
        // (uᵀCx)² / (1 + weight · v)` (Sherman and Morrison).
        let mut taken: Vec<(Vec<f64>, f64)> = Vec::new();
        let mut found = Vec::new();
        for _ in 0..count {
            let best = variances.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
            let Some((at, own)) = best.filter(|(_, own)| **own > 0.0) else {
                break;
            };
            let (own, row) = (*own, &rows[at]);
            let mut solved = self.solve(row);
            for (before, factor) in &taken {
                let along = factor * dot(before, row);
                solved.iter_mut().zip(before).for_each(|(out, own)| *out -= along * own);
            }
            let factor = weight / (1.0 + weight * own);
            let less = |variances: &mut Vec<f64>, rows: &[Vec<f64>]| {
                for (variance, row) in variances.iter_mut().zip(rows) {
                    *variance = (*variance - factor * dot(&solved, row).powi(2)).max(0.0);
                }
            };
            less(&mut variances, &rows);
            less(&mut of_region, &region);
            // Each row is chosen only once, because a repetition would add less than another row.
            variances[at] = 0.0;
            taken.push((solved, factor));
            found.push(NextRow {
                at,
                gain: (weight * own).ln_1p(),
                left: of_region.iter().sum::<f64>() / before,
            });
        }
        found
    }
}

/// A load that should be recorded next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextRow {
    pub at: usize,
    /// Increase of the logarithm of the Gram matrix's determinant if this load is recorded.
    pub gain: f64,
    /// Share of the summed prediction variance in the region that remains after this load and the loads before it are
    /// recorded.
    pub left: f64,
}

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
    use faer::linalg::solvers::DenseSolveCore as _;

    const P: usize = 5;

    /// Returns random rows of features, and their sums. With `repeats`, the last feature copies the first.
    fn data(n: usize, seed: u64, repeats: bool) -> (Vec<Vec<f64>>, NormalEquations) {
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
        let rows: Vec<Vec<f64>> = (0..n).map(|_| row()).collect();
        for row in &rows {
            let mut padded = row.clone();
            padded.resize(stride, 0.0);
            sums.add_rows(&padded);
        }
        (rows, sums)
    }

    fn gram(rows: &[Vec<f64>]) -> Mat<f64> {
        Mat::from_fn(P, P, |i, j| rows.iter().map(|row| row[i] * row[j]).sum())
    }

    fn log_det(mut matrix: Mat<f64>) -> f64 {
        let mut sum = 0.0;
        for i in 0..P {
            sum += matrix[(i, i)].ln();
            for j in i + 1..P {
                let factor = matrix[(j, i)] / matrix[(i, i)];
                for k in i..P {
                    let own = matrix[(i, k)];
                    matrix[(j, k)] -= factor * own;
                }
            }
        }
        sum
    }

    #[test]
    fn a_column_that_repeats_another_adds_no_free_coefficient() {
        let (_, repeated) = data(40, 3, true);
        let free = free_coefficients(&repeated, &[0.0; P]).unwrap();
        assert!((free - 4.0).abs() < 1e-3, "{free}");
    }

    /// A ridge of λ times the squared length leaves 1/(1 + λ) of the coefficient of a single column.
    #[test]
    fn a_ridge_leaves_a_part_of_the_coefficients_free() {
        let (_, sums) = data(40, 1, false);
        let only = |shares: [f64; P]| free_coefficients(&sums, &shares).unwrap();
        assert!((only([0.0; P]) - 5.0).abs() < 1e-6);
        let gone = f64::INFINITY;
        assert!((only([3.0, gone, gone, gone, gone]) - 0.25).abs() < 1e-9);
    }

    #[test]
    fn gains_and_variances_are_those_of_explicit_determinants_and_inverses() {
        let (rows, sums) = data(60, 1, false);
        let (more, _) = data(12, 2, false);
        let own = Information::of(&sums, &[0, 1, 2, 3, 4]).unwrap();
        let weight = 3.0;
        let found = own.next_best(&more, &rows, weight, 4);
        let with = |chosen: &[usize]| {
            let mut all = gram(&rows);
            for at in chosen {
                all += gram(&[more[*at].clone()]) * faer::Scale(weight);
            }
            all
        };
        let variance = |matrix: &Mat<f64>| -> f64 {
            let inverse = matrix.partial_piv_lu().inverse();
            let of = |row: &Vec<f64>| -> f64 {
                (0..P).map(|i| row[i] * (0..P).map(|j| inverse[(i, j)] * row[j]).sum::<f64>()).sum()
            };
            rows.iter().map(of).sum()
        };
        let mut chosen = Vec::new();
        for next in &found {
            let before = log_det(with(&chosen));
            let gain = |at: usize| log_det(with(&[&chosen[..], &[at]].concat())) - before;
            let left = (0..more.len()).filter(|at| !chosen.contains(at));
            let best = left.max_by(|a, b| gain(*a).total_cmp(&gain(*b))).unwrap();
            assert_eq!(next.at, best);
            assert!(
                (next.gain / gain(best) - 1.0).abs() < 1e-3,
                "{} for {}",
                next.gain,
                gain(best)
            );
            chosen.push(next.at);
            let left = variance(&with(&chosen)) / variance(&with(&[]));
            assert!((next.left - left).abs() < 1e-3, "{} for {left}", next.left);
        }
        assert_eq!(found.len(), 4);
    }

    #[test]
    fn a_direction_that_nothing_determines_is_found() {
        let (_, sums) = data(40, 3, true);
        let own = Information::of(&sums, &[0, 1, 2, 3, 4]).unwrap();
        assert!(own.squares[0] < 1e-12);
        let direction = &own.directions[0];
        assert!(
            (direction[0] + direction[4]).abs() < 1e-6
                && (direction[0].abs() - 0.5_f64.sqrt()).abs() < 1e-6
        );
        assert!(Information::of(&NormalEquations::new(2, 1), &[0, 1]).is_none());
    }
}
