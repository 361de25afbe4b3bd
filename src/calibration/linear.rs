//! Linear least squares and ridge regression from normal equations (Eq. 8 of the paper of Koike et al., 2019), with the
//! numerical rank.
//!
//! Guarantees: a column gets the coefficient zero if it is zero, or a linear combination of columns of the same or an earlier
//! [`ColumnKind`]. So if a look-back never finds an earlier sample, the fit is exactly the conventional calibration.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};

use crate::{calibration::normal_equations::NormalEquations, features::ColumnKind};

/// A column counts as a linear combination of other columns if they leave at most this share of its squared length
/// unexplained. Sums have relative rounding errors near 1e-15. A column whose unexplained part is 1e-6 of its length is kept.
const EXPLAINED_BELOW: f64 = 1e-12;
/// Number of columns from which a fit first tries a factorisation without pivots, which then takes much less time.
pub const MANY_COLUMNS: usize = 64;
/// Share of each column's squared length that the columns before it must leave unexplained in a factorisation without pivots. It is
/// far above [`EXPLAINED_BELOW`], so pivots would find the same rank.
const SURELY_UNEXPLAINED: f64 = 1e-8;

/// Solution of a least-squares fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Coefficients, `n_columns × n_targets` row-major; zero for columns that are not fitted or are linear combinations of
    /// others.
    pub coefficients: Vec<f64>,
    /// Number of linearly independent columns.
    pub rank: usize,
}

/// Columns of a fit, and coefficients whose contribution was already subtracted from the targets.
#[derive(Clone, Copy, Debug)]
pub struct Terms<'a> {
    /// Indices of the fitted columns. Other columns get zero coefficients.
    pub used: &'a [usize],
    /// Kind of each column of the normal equations: offset, gauge, or appended feature.
    pub kinds: &'a [ColumnKind],
    /// Coefficients whose contribution was subtracted from the loads to give the targets, `n_columns × n_targets` row-major;
    /// empty if there are none. The fitted coefficients are added to them. For a column that is a linear combination of
    /// others, the fit returns minus its known coefficient, so that the sum is zero.
    pub known: &'a [f64],
}

/// Ridge, which shrinks the coefficients bⱼ of [`ColumnKind::Appended`]: `min ‖Y − XB‖² + Σ penaltyⱼ bⱼ²`. The targets are
/// residuals of the conventional calibration, and the coefficients of gauges and offset are not shrunk. So a stronger ridge
/// moves the result towards the conventional calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ridge<'a> {
    None,
    /// `penaltyⱼ = strength · ‖xⱼ‖²` with strength ≥ 0. With strength 1, the coefficient of a single column is halved.
    Relative(f64),
    /// `penaltyⱼ = shareⱼ · ‖xⱼ‖²`, with one share for each column of the normal equations. The share zero means no
    /// shrinkage.
    Shares(&'a [f64]),
    /// `penaltyⱼ = strength ≥ 0`, the ratio of the noise variance to the variance of the coefficient.
    Absolute(f64),
}

impl Ridge<'_> {
    fn penalty(self, sums: &NormalEquations, column: usize, kind: ColumnKind) -> f64 {
        match (self, kind) {
            (Self::Shares(shares), _) => shares[column] * sums.feature_product(column, column),
            (Self::None, _) | (_, ColumnKind::Offset | ColumnKind::Gauge) => 0.0,
            (Self::Relative(strength), ColumnKind::Appended) => {
                strength * sums.feature_product(column, column)
            }
            (Self::Absolute(strength), ColumnKind::Appended) => strength,
        }
    }
}

/// Solves `min ‖Y − XB‖²` with a ridge, whose penalties are added to the diagonal of `XᵀX` (Eq. 5 and 8 of the paper of Koike
/// et al., 2019).
///
/// The columns are scaled to unit length. The Cholesky factorisation pivots within each [`ColumnKind`]. The cost is `O(p³ +
/// p²q)` for p columns and q targets. Panics if `terms` and `sums` have different numbers of columns.
pub fn fit(sums: &NormalEquations, terms: Terms<'_>, ridge: Ridge<'_>) -> Fit {
    let Terms { used, kinds, known } = terms;
    let (m, q) = (used.len(), sums.n_targets());
    let penalties: Vec<f64> = used.iter().map(|&i| ridge.penalty(sums, i, kinds[i])).collect();
    let inverse_length: Vec<f64> = used
        .iter()
        .zip(&penalties)
        .map(|(&i, penalty)| inverse_length(sums.feature_product(i, i) + penalty))
        .collect();
    let scaled = |i: usize, j: usize| {
        let penalty = if i == j { penalties[i] } else { 0.0 };
        (sums.feature_product(used[i], used[j]) + penalty) * inverse_length[i] * inverse_length[j]
    };
    if m >= MANY_COLUMNS
        && let Some(found) = without_pivots(sums, used, &inverse_length, scaled)
    {
        return found;
    }
    // Lower triangle of the scaled Gram matrix, replaced column by column by its Cholesky factor.
    let mut lower: Vec<f64> = vec![0.0; m * m];
    for i in 0..m {
        for j in 0..=i {
            lower[i * m + j] = scaled(i, j);
        }
    }
    let mut order: Vec<usize> = (0..m).collect();
    let mut rank = 0;
    for kind in [ColumnKind::Offset, ColumnKind::Gauge, ColumnKind::Appended] {
        loop {
            let of_kind = (rank..m).filter(|&i| kinds[used[order[i]]] == kind);
            let (pivot, largest) = of_kind.map(|i| (i, lower[i * m + i])).fold(
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
            let column: Vec<f64> = (rank + 1..m).map(|i| lower[i * m + rank]).collect();
            for (i, factor) in (rank + 1..m).zip(&column) {
                let row = &mut lower[i * m..][rank + 1..=i];
                for (entry, other) in row.iter_mut().zip(&column) {
                    *entry -= factor * other;
                }
            }
            rank += 1;
        }
    }
    let (independent, explained) = order.split_at(rank);
    let known = |column: usize, target: usize| known.get(column * q + target).unwrap_or(&0.0);
    let mut coefficients = vec![0.0; sums.n_features() * q];
    let mut solution = vec![0.0; rank];
    for target in 0..q {
        for (i, &at) in independent.iter().enumerate() {
            let before: f64 = (0..i).map(|j| lower[i * m + j] * solution[j]).sum();
            let given_back: f64 = explained
                .iter()
                .map(|&other| {
                    sums.feature_product(used[at], used[other]) * known(used[other], target)
                })
                .sum();
            let right = (sums.target_product(used[at], target) + given_back) * inverse_length[at];
            solution[i] = (right - before) / lower[i * m + i];
        }
        for i in (0..rank).rev() {
            let later: f64 = (i + 1..rank).map(|j| lower[j * m + i] * solution[j]).sum();
            solution[i] = (solution[i] - later) / lower[i * m + i];
            coefficients[used[order[i]] * q + target] = solution[i] * inverse_length[order[i]];
        }
        for &other in explained {
            coefficients[used[other] * q + target] = 0.0 - known(used[other], target);
        }
    }
    Fit { coefficients, rank }
}

/// Solves like [`fit`] by a Cholesky factorisation without pivots. Returns `None` unless all columns are surely independent.
fn without_pivots(
    sums: &NormalEquations,
    used: &[usize],
    inverse_length: &[f64],
    scaled: impl Fn(usize, usize) -> f64,
) -> Option<Fit> {
    let (m, q) = (used.len(), sums.n_targets());
    let lower = Mat::from_fn(m, m, |i, j| if i < j { 0.0 } else { scaled(i, j) });
    let factor = lower.llt(Side::Lower).ok()?;
    let is_unexplained = |root: &f64| root * root >= SURELY_UNEXPLAINED;
    if !factor.L().diagonal().column_vector().iter().all(is_unexplained) {
        return None;
    }
    let right = |i, target| sums.target_product(used[i], target) * inverse_length[i];
    let solution = factor.solve(&Mat::from_fn(m, q, right));
    let mut coefficients = vec![0.0; sums.n_features() * q];
    for (i, &column) in used.iter().enumerate() {
        for target in 0..q {
            coefficients[column * q + target] = solution[(i, target)] * inverse_length[i];
        }
    }
    Some(Fit { coefficients, rank: m })
}

impl Terms<'_> {
    /// Returns the list for [`Ridge::Shares`] with one strength: the strength for appended columns, zero for gauges and
    /// offset.
    pub fn shares(&self, strength: f64) -> Vec<f64> {
        let share = |kind: &ColumnKind| match kind {
            ColumnKind::Appended => strength,
            ColumnKind::Gauge | ColumnKind::Offset => 0.0,
        };
        self.kinds.iter().map(share).collect()
    }

    pub fn of_targets(&self, strengths: &[f64]) -> Vec<Vec<f64>> {
        strengths.iter().map(|one| self.shares(*one)).collect()
    }

    /// Returns the columns that the fit uses: those whose relative ridge strength is finite. An infinite ridge excludes a
    /// column.
    pub fn kept(&self, shares: &[f64]) -> Vec<usize> {
        let used = self.used.iter().copied();
        used.filter(|column| shares[*column].is_finite()).collect()
    }
}

/// Solves like [`fit`], with separate [`Ridge::Shares`] for each target. A column with an infinite share is left out for this
/// target. The returned rank is that of the fit without ridge.
pub fn fit_targets(sums: &NormalEquations, terms: Terms<'_>, shares: &[Vec<f64>]) -> Fit {
    let q = sums.n_targets();
    assert_eq!(shares.len(), q, "there must be one list of ridge shares per target");
    let mut found = fit(sums, terms, Ridge::None);
    for (at, ridge_shares) in shares.iter().enumerate() {
        if ridge_shares.iter().all(|share| *share == 0.0) || shares[..at].contains(ridge_shares) {
            continue;
        }
        let kept = Terms { used: &terms.kept(ridge_shares), ..terms };
        let shrunk = fit(sums, kept, Ridge::Shares(ridge_shares)).coefficients;
        for target in (at..q).filter(|target| shares[*target] == *ridge_shares) {
            for feature in 0..sums.n_features() {
                found.coefficients[feature * q + target] = shrunk[feature * q + target];
            }
        }
    }
    found
}

/// Returns the condition number of the design: the ratio of the largest to the smallest singular value of its linearly
/// independent columns, scaled to unit length. Values above about 1e7 are not accurate. `None` if the rank is zero.
pub fn condition_number(sums: &NormalEquations, used: &[usize], rank: usize) -> Option<f64> {
    let (scaled, _) = unit_gram(sums, used);
    let mut squares = scaled.self_adjoint_eigenvalues(Side::Lower).ok()?;
    squares.sort_unstable_by(|a, b| b.total_cmp(a));
    let smallest = squares[rank.checked_sub(1)?];
    (smallest > 0.0).then(|| (squares[0] / smallest).sqrt())
}

/// Returns the Gram matrix of these columns, scaled to unit length, and the factor that scales each column; zero for a zero
/// column.
fn unit_gram(sums: &NormalEquations, columns: &[usize]) -> (Mat<f64>, Vec<f64>) {
    let product = |i: usize, j: usize| sums.feature_product(columns[i], columns[j]);
    let n = columns.len();
    let factors: Vec<f64> = (0..n).map(|i| inverse_length(product(i, i))).collect();
    (Mat::from_fn(n, n, |i, j| product(i, j) * factors[i] * factors[j]), factors)
}

fn inverse_length(square: f64) -> f64 {
    if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 }
}

/// Exchanges rows and columns `a ≤ b` of the symmetric matrix in the lower triangle, and of the Cholesky columns computed so
/// far.
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

    /// Returns rows `[1, a, b, c | y₀, y₁]` without an exact relation.
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

    /// Returns gauge columns that are all used.
    fn gauges(p: usize) -> (Vec<usize>, Vec<ColumnKind>) {
        ((0..p).collect(), vec![ColumnKind::Gauge; p])
    }

    fn plain(sums: &NormalEquations) -> Fit {
        let (used, kinds) = gauges(sums.n_features());
        let terms = Terms { used: &used, kinds: &kinds, known: &[] };
        fit(sums, terms, Ridge::None)
    }

    #[test]
    fn coefficients_equal_those_of_a_qr_solution() {
        let rows = rows(200);
        let fit = plain(&sums(&rows, 4));
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
        let padded = plain(&sums(&with_zero, 5));
        let plain = plain(&sums(&rows(80), 4));
        assert_eq!(padded.rank, 4);
        assert_eq!(padded.coefficients[..8], plain.coefficients);
        assert_eq!(padded.coefficients[8..], [0.0, 0.0]);
    }

    #[test]
    fn a_repeated_column_lowers_the_rank_and_keeps_the_residual() {
        let rows = rows(80);
        let repeated: Vec<_> =
            rows.iter().map(|row| [&row[..4], &row[2..3], &row[4..]].concat()).collect();
        let plain_sums = sums(&rows, 4);
        let repeated_sums = sums(&repeated, 5);
        let repeated = plain(&repeated_sums);
        let plain = plain(&plain_sums);
        assert_eq!(repeated.rank, 4);
        let (a, b) = (
            plain_sums.squared_residuals(&plain.coefficients),
            repeated_sums.squared_residuals(&repeated.coefficients),
        );
        assert!((a[0] - b[0]).abs() < 1e-9 * a[0]);
    }

    /// `(XᵀX + D) b = Xᵀy` holds, with the penalties D of the ridge.
    #[test]
    fn a_ridge_solves_the_normal_equations_with_its_penalties() {
        let sums = sums(&rows(80), 4);
        let kinds =
            [ColumnKind::Gauge, ColumnKind::Appended, ColumnKind::Appended, ColumnKind::Gauge];
        let terms = Terms { used: &[0, 1, 2, 3], kinds: &kinds, known: &[] };
        let of_strength: [fn(f64) -> Ridge<'static>; 2] = [Ridge::Relative, Ridge::Absolute];
        for (ridge, strength) in of_strength.into_iter().zip([0.3, 7.0]) {
            let b = fit(&sums, terms, ridge(strength)).coefficients;
            for i in 0..4 {
                let product: f64 = (0..4).map(|j| sums.feature_product(i, j) * b[j * 2]).sum();
                let left = product + ridge(strength).penalty(&sums, i, kinds[i]) * b[i * 2];
                assert!((left - sums.target_product(i, 0)).abs() < 1e-9);
            }
            let free = fit(&sums, terms, Ridge::None).coefficients;
            let nearly = fit(&sums, terms, ridge(1e-14)).coefficients;
            assert!((free[2] - nearly[2]).abs() < 1e-9);
            assert!(fit(&sums, terms, ridge(1e14)).coefficients[2].abs() < 1e-9);
        }
    }

    /// The offset explains a gauge that is constantly 3, in any order of columns, and cancels its known coefficient.
    #[test]
    fn a_constant_gauge_loses_its_known_coefficient() {
        let rows: Vec<Vec<f64>> = (0..30)
            .map(|k| {
                let x = (0.4 * f64::from(k)).sin();
                vec![3.0, x, 1.0, 2.0 * x + 5.0]
            })
            .collect();
        let known = [10.0, 0.5, 1.0];
        let left_over: Vec<Vec<f64>> = rows
            .iter()
            .map(|row| {
                let known: f64 = row.iter().zip(known).map(|(x, b)| x * b).sum();
                vec![row[0], row[1], row[2], row[3] - known]
            })
            .collect();
        let terms = Terms {
            used: &[0, 1, 2],
            kinds: &[ColumnKind::Gauge, ColumnKind::Gauge, ColumnKind::Offset],
            known: &known,
        };
        let fit = fit(&sums(&left_over, 3), terms, Ridge::None);
        assert_eq!(fit.rank, 2);
        for ((b, known), expected) in fit.coefficients.iter().zip(known).zip([0.0, 2.0, 5.0]) {
            assert!((b + known - expected).abs() < 1e-12, "{b} {known} {expected}");
        }
    }

    #[test]
    fn no_samples_give_zero_coefficients() {
        let fit = plain(&NormalEquations::new(2, 1));
        assert_eq!((fit.rank, fit.coefficients), (0, vec![0.0, 0.0]));
    }

    #[test]
    fn orthogonal_columns_have_condition_one() {
        let rows = vec![vec![1.0, 1.0, 0.0], vec![1.0, -1.0, 0.0]];
        let condition = condition_number(&sums(&rows, 2), &[0, 1], 2).unwrap();
        assert!((condition - 1.0).abs() < 1e-12);
    }
}
