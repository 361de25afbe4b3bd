//! Normal equations: the sums `XᵀX`, `XᵀY`, `YᵀY` and the number of samples n. Least squares needs no other data of a
//! recording.
//!
//! The sums of several parts of a recording, of several recordings or of several computers can be added. To leave out a
//! recording, the sums of the other recordings are added. Subtraction would leave rounding errors that raise the rank.
//!
//! Guarantees: one pass over the rows. Products are summed over short blocks of rows before they are added to the total, so
//! rounding errors grow only with the number of blocks.

use crate::vectorised::vectorised;
use std::ops::Range;

/// Number of feature rows whose products are summed before they are added to the total. With 24 columns, these rows fit into
/// the first-level cache.
pub const BLOCK_ROWS: usize = 128;
/// Number of columns whose products are computed together. The length of a row in memory is a multiple of this number.
const LANES: usize = 8;
/// Number of rows of the Gram matrix that are computed together. `TILE × LANES` sums fit into registers.
pub(super) const TILE: usize = 4;

/// Normal equations: number of samples and Gram matrix of the columns `[X | Y]`, `p` features and then `q` targets. The sum
/// of squared residuals (Eq. 8 of the paper of Koike et al., 2019) depends on the data only through them.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalEquations {
    n_samples: u64,
    n_features: usize,
    n_targets: usize,
    /// Gram matrix, `width × stride`, row-major. Only entries on and above the diagonal are valid.
    gram: Vec<f64>,
}

impl NormalEquations {
    pub fn new(n_features: usize, n_targets: usize) -> Self {
        let width = n_features + n_targets;
        Self {
            n_samples: 0,
            n_features,
            n_targets,
            gram: vec![0.0; width.next_multiple_of(TILE) * Self::stride_of(width)],
        }
    }

    /// Returns the length of a row `[x | y]` in memory. Numbers after the first `n_features + n_targets` must be zero.
    pub fn stride(&self) -> usize {
        Self::stride_of(self.width())
    }

    pub(super) fn stride_of(width: usize) -> usize {
        width.next_multiple_of(LANES)
    }

    fn width(&self) -> usize {
        self.n_features + self.n_targets
    }

    pub fn n_samples(&self) -> u64 {
        self.n_samples
    }

    pub fn n_features(&self) -> usize {
        self.n_features
    }

    pub fn n_targets(&self) -> usize {
        self.n_targets
    }

    /// Adds samples to the sums, given as rows `[x | y | 0 …]` of [`Self::stride`] numbers each. Panics if the last row is
    /// not complete.
    pub fn add_rows(&mut self, rows: &[f64]) {
        let stride = self.stride();
        assert_eq!(rows.len() % stride, 0, "each row must have stride numbers");
        self.n_samples += (rows.len() / stride) as u64;
        let gram = &mut self.gram[..];
        vectorised(
            #[inline(always)]
            move || {
                for block in rows.chunks(BLOCK_ROWS * stride) {
                    for (first_row, sums) in tile_rows(gram, stride) {
                        // Tiles below the diagonal are never read, so they are not computed.
                        let columns = first_row / LANES * LANES..stride;
                        add_tiles(sums, block, first_row, columns);
                    }
                }
            },
        );
    }

    /// Adds the sums of other samples. Panics if the numbers of columns differ.
    pub fn add(&mut self, other: &Self) {
        assert_eq!(
            (self.n_features, self.n_targets),
            (other.n_features, other.n_targets),
            "both sums must have the same columns"
        );
        for (sum, value) in self.gram.iter_mut().zip(&other.gram) {
            *sum += value;
        }
        self.n_samples += other.n_samples;
    }

    /// For each part for which `wanted` is true, sums all other parts, and returns the result of `take` for the index of the
    /// part and this sum. The parts are added by recursive halving. Panics if the parts have different columns.
    pub fn each_without<T: Send>(
        parts: &[Self],
        wanted: impl Fn(usize) -> bool + Sync,
        take: impl Fn(usize, &Self) -> T + Sync,
    ) -> Vec<(usize, T)> {
        let Some(first) = parts.first() else {
            return Vec::new();
        };
        let nothing = Self::new(first.n_features, first.n_targets);
        without_each_of(parts, 0, nothing, &wanted, &take)
    }

    /// Returns the normal equations of the same samples with the targets `Y − XB`, where B is `coefficients`. Panics unless B
    /// is `p × q`, row-major.
    pub fn less(&self, coefficients: &[f64]) -> Self {
        let (p, q, stride) = (self.n_features, self.n_targets, self.stride());
        let mut rest = self.clone();
        for (target, square) in self.squared_residuals(coefficients).into_iter().enumerate() {
            for i in 0..p {
                let explained: f64 =
                    (0..p).map(|j| self.feature_product(i, j) * coefficients[j * q + target]).sum();
                rest.gram[i * stride + p + target] -= explained;
            }
            rest.gram[(p + target) * stride + p + target] = square;
        }
        rest
    }

    /// Adds the products of the columns from `first` on with all columns: one row of [`Self::stride`] numbers per column. In
    /// these sums, the columns must have been zero for the samples of the products; see
    /// [`AgedSums`](crate::calibration::AgedSums). Panics if there are more rows than columns.
    pub(crate) fn add_products(&mut self, first: usize, products: &[f64]) {
        let stride = self.stride();
        for (column, row) in (first..).zip(products.chunks_exact(stride)) {
            let sums_of_row = &mut self.gram[column * stride + column..(column + 1) * stride];
            for (sum, product) in sums_of_row.iter_mut().zip(&row[column..]) {
                *sum += product;
            }
            for (before, product) in row[..first].iter().enumerate() {
                self.gram[before * stride + column] += product;
            }
        }
    }

    pub fn without(&self, features: Range<usize>) -> Self {
        let (mut rest, stride) = (self.clone(), self.stride());
        for (i, row) in rest.gram.chunks_exact_mut(stride).enumerate() {
            if features.contains(&i) { row.fill(0.0) } else { row[features.clone()].fill(0.0) }
        }
        rest
    }

    pub fn size_bytes(&self) -> usize {
        self.gram.len() * size_of::<f64>()
    }

    /// Returns those of `columns` that are not zero in every sample.
    pub fn present_among(&self, columns: &[usize]) -> Vec<usize> {
        let columns = columns.iter().copied();
        columns.filter(|&column| self.feature_product(column, column) > 0.0).collect()
    }

    /// Returns an entry of `XᵀX`.
    pub fn feature_product(&self, i: usize, j: usize) -> f64 {
        self.gram[i.min(j) * self.stride() + i.max(j)]
    }

    /// Returns an entry of `XᵀY`.
    pub fn target_product(&self, feature: usize, target: usize) -> f64 {
        self.gram[feature * self.stride() + self.n_features + target]
    }

    /// Returns a diagonal entry of `YᵀY`.
    pub fn target_square(&self, target: usize) -> f64 {
        let at = self.n_features + target;
        self.gram[at * self.stride() + at]
    }

    /// Returns the sum of squared residuals of each target, `YᵀY − 2BᵀXᵀY + BᵀXᵀXB`. Panics unless B is `p × q`, row-major.
    pub fn squared_residuals(&self, coefficients: &[f64]) -> Vec<f64> {
        let (p, q) = (self.n_features, self.n_targets);
        assert_eq!(
            coefficients.len(),
            p * q,
            "there must be one coefficient per feature and target"
        );
        (0..q)
            .map(|target| {
                let b = |feature: usize| coefficients[feature * q + target];
                let explained: f64 = (0..p)
                    .map(|i| {
                        let row = &self.gram[i * self.stride()..];
                        let later: f64 = (i + 1..p).map(|j| row[j] * b(j)).sum();
                        b(i) * (row[i] * b(i) + 2.0 * (later - row[p + target]))
                    })
                    .sum();
                (self.target_square(target) + explained).max(0.0)
            })
            .collect()
    }
}

/// Computes [`NormalEquations::each_without`] for `parts`, of which the first has the index `first`. `rest` is the sum of all
/// parts that are not in `parts`.
fn without_each_of<T: Send>(
    parts: &[NormalEquations],
    first: usize,
    mut rest: NormalEquations,
    wanted: &(impl Fn(usize) -> bool + Sync),
    take: &(impl Fn(usize, &NormalEquations) -> T + Sync),
) -> Vec<(usize, T)> {
    if !(first..first + parts.len()).any(wanted) {
        return Vec::new();
    }
    if parts.len() == 1 {
        return vec![(first, take(first, &rest))];
    }
    let (left, right) = parts.split_at(parts.len() / 2);
    let mut rest_of_left = rest.clone();
    right.iter().for_each(|part| rest_of_left.add(part));
    left.iter().for_each(|part| rest.add(part));
    let (mut taken, others) = rayon::join(
        || without_each_of(left, first, rest_of_left, wanted, take),
        || without_each_of(right, first + left.len(), rest, wanted, take),
    );
    taken.extend(others);
    taken
}

/// Iterates over the rows of the Gram matrix, `TILE` rows at a time. Each item has the index of its first row.
#[inline(always)]
pub(super) fn tile_rows(
    sums: &mut [f64],
    stride: usize,
) -> impl Iterator<Item = (usize, &mut [f64])> {
    // `chunks_exact_mut` is avoided here and below, because its division would take longer than the products of a few rows.
    let (mut rest, mut first) = (sums, 0);
    std::iter::from_fn(move || {
        let (tile, more) = std::mem::take(&mut rest).split_at_mut_checked(TILE * stride)?;
        rest = more;
        first += TILE;
        Some((first - TILE, tile))
    })
}

/// Multiplies `TILE` columns of the rows in `block`, from `left_column` on, by `columns`, and adds the products to `TILE`
/// rows of the Gram matrix.
#[inline(always)]
pub(super) fn add_tiles(
    sums: &mut [f64],
    block: &[f64],
    left_column: usize,
    columns: Range<usize>,
) {
    let stride = sums.len() / TILE;
    for first_column in columns.step_by(LANES) {
        let mut tile = [[0.0_f64; LANES]; TILE];
        let mut rest = block;
        while let Some((row, more)) = rest.split_at_checked(stride) {
            rest = more;
            let left: &[f64; TILE] = row[left_column..][..TILE].try_into().expect("a tile");
            let right: &[f64; LANES] = row[first_column..][..LANES].try_into().expect("lanes");
            for i in 0..TILE {
                for lane in 0..LANES {
                    tile[i][lane] = left[i].mul_add(right[lane], tile[i][lane]);
                }
            }
        }
        for (i, products) in tile.iter().enumerate() {
            let total = &mut sums[i * stride + first_column..][..LANES];
            for (total, product) in total.iter_mut().zip(products) {
                *total += product;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns `m` padded rows of `p` features and `q` targets without a simple relation.
    fn rows(m: usize, p: usize, q: usize) -> Vec<f64> {
        let stride = NormalEquations::stride_of(p + q);
        (0..m * stride)
            .map(|at| {
                let (k, column) = (at / stride, at % stride);
                if column < p + q {
                    ((k * 7 + column * 13) % 31) as f64 - 15.0 + 0.1 * (k as f64).sin()
                } else {
                    0.0
                }
            })
            .collect()
    }

    #[test]
    fn sums_equal_the_plain_products() {
        for (p, q) in [(1, 1), (3, 1), (7, 6), (13, 6), (64, 6)] {
            for m in [0, 1, 127, 128, 300] {
                let rows = rows(m, p, q);
                let mut sums = NormalEquations::new(p, q);
                sums.add_rows(&rows);
                let stride = sums.stride();
                let plain = |i: usize, j: usize| -> f64 {
                    rows.chunks_exact(stride).map(|row| row[i] * row[j]).sum()
                };
                assert_eq!(sums.n_samples(), m as u64);
                for i in 0..p {
                    for j in 0..p {
                        assert!((sums.feature_product(i, j) - plain(i, j)).abs() < 1e-8);
                    }
                    for target in 0..q {
                        let expected = plain(i, p + target);
                        assert!((sums.target_product(i, target) - expected).abs() < 1e-8);
                    }
                }
            }
        }
    }

    #[test]
    fn squared_residuals_equal_those_of_predicted_samples() {
        let (p, q) = (4, 2);
        let rows = rows(50, p, q);
        let mut sums = NormalEquations::new(p, q);
        sums.add_rows(&rows);
        let b: Vec<f64> = (0..p * q).map(|at| 0.3 - 0.1 * at as f64).collect();
        let stride = sums.stride();
        for (target, square) in sums.squared_residuals(&b).iter().enumerate() {
            let plain: f64 = rows
                .chunks_exact(stride)
                .map(|row| {
                    let predicted: f64 = (0..p).map(|i| row[i] * b[i * q + target]).sum();
                    (row[p + target] - predicted).powi(2)
                })
                .sum();
            assert!((square - plain).abs() < 1e-9 * plain);
        }
    }

    /// The second column is nonzero only in the first part. Without this part it must be exactly zero, without rounding errors.
    #[test]
    fn leaving_out_a_part_removes_it_exactly() {
        let parts: Vec<NormalEquations> = (0..5)
            .map(|part| {
                let mut sums = NormalEquations::new(3, 1);
                let stride = sums.stride();
                let mut rows = rows(40 + part, 3, 1);
                if part > 0 {
                    rows.iter_mut().skip(1).step_by(stride).for_each(|x| *x = 0.0);
                }
                sums.add_rows(&rows);
                sums
            })
            .collect();
        let rests = NormalEquations::each_without(&parts, |at| at != 3, |_, rest| rest.clone());
        let positions: Vec<usize> = rests.iter().map(|(at, _)| *at).collect();
        assert_eq!(positions, [0, 1, 2, 4]);
        for (at, rest) in rests {
            let others = parts.iter().enumerate().filter(|(other, _)| *other != at);
            let samples: u64 = others.clone().map(|(_, part)| part.n_samples()).sum();
            let square: f64 = others.map(|(_, part)| part.feature_product(1, 1)).sum();
            assert_eq!(rest.n_samples(), samples);
            assert_eq!(rest.feature_product(1, 1), square);
        }
    }

    #[test]
    fn sums_with_subtracted_coefficients_are_those_of_residuals() {
        let (p, q) = (3, 2);
        let mut rows = rows(60, p, q);
        let mut sums = NormalEquations::new(p, q);
        sums.add_rows(&rows);
        let b = [0.5, -1.0, 0.25, 2.0, 0.0, 1.5];
        let stride = sums.stride();
        for row in rows.chunks_exact_mut(stride) {
            for target in 0..q {
                row[p + target] -= (0..p).map(|i| row[i] * b[i * q + target]).sum::<f64>();
            }
        }
        let mut expected = NormalEquations::new(p, q);
        expected.add_rows(&rows);
        let actual = sums.less(&b);
        for target in 0..q {
            for i in 0..p {
                let difference =
                    actual.target_product(i, target) - expected.target_product(i, target);
                assert!(difference.abs() < 1e-9);
            }
            let difference = actual.target_square(target) - expected.target_square(target);
            assert!(difference.abs() < 1e-9 * expected.target_square(target));
        }
    }
}
