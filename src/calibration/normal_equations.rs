//! A recording, as far as linear least squares can tell: the sums `XᵀX`, `XᵀY`, `YᵀY` and n.
//!
//! Sums add up: over blocks, recordings and machines; and subtract, which is how one recording is left out. Guarantees:
//! one pass over the rows; products are collected over short blocks before they join the total, so that rounding
//! errors grow with the number of blocks and not of samples.

use std::ops::Range;

/// Rows that are multiplied before their sum joins the total; a block of 24 columns stays in the first-level cache.
pub const BLOCK_ROWS: usize = 128;
/// Columns multiplied at once; the width of a row in memory is a multiple of it.
const LANES: usize = 8;
/// Rows of the product that are worked on at once; `TILE × LANES` sums stay in registers.
pub(super) const TILE: usize = 4;

/// `n` and the Gram matrix of the columns `[X | Y]`: `p` features, then `q` targets.
///
/// **Source** Eq. 8: everything that the sum of squared residuals needs of the data.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalEquations {
    n_samples: u64,
    n_features: usize,
    n_targets: usize,
    /// `width × stride`, row-major; only entries on and above the diagonal mean anything.
    gram: Vec<f64>,
}

impl NormalEquations {
    /// No samples yet.
    #[must_use]
    pub fn new(n_features: usize, n_targets: usize) -> Self {
        let width = n_features + n_targets;
        Self {
            n_samples: 0,
            n_features,
            n_targets,
            gram: vec![0.0; width.next_multiple_of(TILE) * Self::stride_of(width)],
        }
    }

    /// How many numbers a row `[x | y]` takes in memory; what is beyond `n_features + n_targets` must be zero.
    #[must_use]
    pub fn stride(&self) -> usize {
        Self::stride_of(self.width())
    }

    pub(super) fn stride_of(width: usize) -> usize {
        width.next_multiple_of(LANES)
    }

    fn width(&self) -> usize {
        self.n_features + self.n_targets
    }

    /// How many samples are in the sums.
    #[must_use]
    pub fn n_samples(&self) -> u64 {
        self.n_samples
    }

    /// The number of feature columns p.
    #[must_use]
    pub fn n_features(&self) -> usize {
        self.n_features
    }

    /// The number of target columns q.
    #[must_use]
    pub fn n_targets(&self) -> usize {
        self.n_targets
    }

    /// Adds rows to the sums.
    ///
    /// **Shapes** `rows` is `m × stride`, row-major, each row `[x | y | 0 …]`.
    ///
    /// # Panics
    /// If `rows` is not a whole number of rows.
    pub fn add_rows(&mut self, rows: &[f64]) {
        let stride = self.stride();
        assert_eq!(rows.len() % stride, 0, "rows must be whole");
        self.n_samples += (rows.len() / stride) as u64;
        pulp::Arch::new().dispatch(AddRows {
            gram: &mut self.gram,
            rows,
            stride,
        });
    }

    /// Adds the sums of other samples.
    ///
    /// # Panics
    /// If the columns differ in number.
    pub fn add(&mut self, other: &Self) {
        self.combine(other, 1.0);
        self.n_samples += other.n_samples;
    }

    /// These sums without those of `part`, which must be in them.
    ///
    /// # Panics
    /// If the columns differ in number, or `part` holds more samples.
    #[must_use]
    pub fn without(&self, part: &Self) -> Self {
        let mut rest = self.clone();
        rest.combine(part, -1.0);
        rest.n_samples = self
            .n_samples
            .checked_sub(part.n_samples)
            .expect("a part has no more samples than the whole");
        rest
    }

    /// Adds products of the columns from `first` on with all columns, which so far were zero in the samples that the
    /// products are of; see [`AgedSums`](crate::calibration::AgedSums).
    ///
    /// **Shapes** `products` has one row of [`NormalEquations::stride`] per column.
    ///
    /// # Panics
    /// If `products` has more rows than there are columns from `first` on.
    pub(crate) fn add_products(&mut self, first: usize, products: &[f64]) {
        let stride = self.stride();
        for (column, row) in (first..).zip(products.chunks_exact(stride)) {
            let own = &mut self.gram[column * stride + column..(column + 1) * stride];
            for (sum, product) in own.iter_mut().zip(&row[column..]) {
                *sum += product;
            }
            for (before, product) in row[..first].iter().enumerate() {
                self.gram[before * stride + column] += product;
            }
        }
    }

    fn combine(&mut self, other: &Self, sign: f64) {
        assert_eq!(
            (self.n_features, self.n_targets),
            (other.n_features, other.n_targets),
            "sums over the same columns"
        );
        for (sum, value) in self.gram.iter_mut().zip(&other.gram) {
            *sum += sign * value;
        }
    }

    /// Entry of `XᵀX`.
    #[must_use]
    pub fn feature_product(&self, i: usize, j: usize) -> f64 {
        self.gram[i.min(j) * self.stride() + i.max(j)]
    }

    /// Entry of `XᵀY`.
    #[must_use]
    pub fn target_product(&self, feature: usize, target: usize) -> f64 {
        self.gram[feature * self.stride() + self.n_features + target]
    }

    /// Diagonal entry of `YᵀY`.
    #[must_use]
    pub fn target_square(&self, target: usize) -> f64 {
        let at = self.n_features + target;
        self.gram[at * self.stride() + at]
    }

    /// The sum of squared residuals of each target, `YᵀY − 2BᵀXᵀY + BᵀXᵀXB`, without predicting a sample.
    ///
    /// **Shapes** `coefficients` is `p × q`, row-major.
    ///
    /// # Panics
    /// If `coefficients` has another shape.
    #[must_use]
    pub fn squared_residuals(&self, coefficients: &[f64]) -> Vec<f64> {
        let (p, q) = (self.n_features, self.n_targets);
        assert_eq!(
            coefficients.len(),
            p * q,
            "one coefficient per feature and target"
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

/// Compiled for each instruction set; which one is decided when the program runs.
struct AddRows<'a> {
    gram: &'a mut [f64],
    rows: &'a [f64],
    stride: usize,
}

impl pulp::WithSimd for AddRows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for block in self.rows.chunks(BLOCK_ROWS * self.stride) {
            for (first_row, sums) in tile_rows(self.gram, self.stride) {
                // Tiles that lie wholly below the diagonal are never read.
                let columns = first_row / LANES * LANES..self.stride;
                add_tiles(sums, block, first_row, columns);
            }
        }
    }
}

/// `TILE` rows of sums at a time, with the number of the first.
#[inline(always)]
pub(super) fn tile_rows(
    sums: &mut [f64],
    stride: usize,
) -> impl Iterator<Item = (usize, &mut [f64])> {
    // Not `chunks_exact_mut`, here and below: where few rows are added at a time, its division would take longer than
    // the products.
    let (mut rest, mut first) = (sums, 0);
    std::iter::from_fn(move || {
        let (tile, more) = std::mem::take(&mut rest).split_at_mut_checked(TILE * stride)?;
        rest = more;
        first += TILE;
        Some((first - TILE, tile))
    })
}

/// Adds to `TILE` rows of sums the products of the columns from `left_column` on with those in `columns`, a tile of
/// `TILE × LANES` at a time.
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

    /// `m` rows of `p` features and `q` targets with no simple relation, padded.
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

    #[test]
    fn a_part_taken_out_leaves_the_rest() {
        let (first, second) = (rows(40, 3, 1), rows(60, 3, 1));
        let sums = |rows: &[&[f64]]| {
            let mut sums = NormalEquations::new(3, 1);
            for rows in rows {
                sums.add_rows(rows);
            }
            sums
        };
        let rest = sums(&[&first, &second]).without(&sums(&[&first]));
        let expected = sums(&[&second]);
        assert_eq!(rest.n_samples(), 60);
        for i in 0..3 {
            assert!((rest.feature_product(i, i) - expected.feature_product(i, i)).abs() < 1e-8);
        }
    }
}
