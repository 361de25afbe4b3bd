//! Computes eight linear fits at a time, each with one part of the data left out. Each fit uses one SIMD lane.
//!
//! The normal equations of the left-out part are subtracted from the total. The Cholesky factorisation does not pivot. The
//! targets are further rows of the matrix, so the factorisation includes forward substitution. Each step is one operation on
//! eight fits.

#![expect(
    clippy::needless_range_loop,
    reason = "the compiler vectorises loops that index the same lane of several arrays"
)]
#![expect(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "the negated comparison counts a pivot or share that is NaN as too small"
)]

use crate::calibration::{NormalEquations, Terms};

/// Number of fits that are computed together, each in one SIMD lane.
pub const LANES: usize = 8;

/// One number for each of the eight fits.
type Lanes = [f64; LANES];

/// Minimum share of a column's squared length that the columns before it leave unexplained. With a smaller share, this fast
/// fit is discarded. The limit is far above the share at which [`fit`](crate::calibration::fit) drops a column.
const SURELY_INDEPENDENT: f64 = 1e-6;

/// Minimum share of a column's squared length that remains after subtraction of the left-out part. With a smaller share, this
/// fast fit is discarded. The difference has the rounding errors of the total, near 1e-15. With at least this share, they
/// stay far below [`SURELY_INDEPENDENT`].
const SURELY_REMAINS: f64 = 1e-2;

/// Buffers for eight fits of `m` columns and `q` targets.
pub struct Work {
    m: usize,
    q: usize,
    /// Sums of products over the left-out part: the lower triangle of `XᵀX` row by row, then one row of `XᵀY` for each
    /// target.
    part: Vec<Lanes>,
    /// Sums of products over the other parts in the same layout as `part`, with columns scaled to length one. The Cholesky
    /// factor overwrites them.
    factor: Vec<Lanes>,
    inverse_length: Vec<Lanes>,
    inverse_root: Vec<Lanes>,
    coefficients: Vec<Lanes>,
    least_pivot: Lanes,
    /// Share of a column's squared length that remains without the left-out part of the data, the smallest of all columns.
    least_remains: Lanes,
    squares: Vec<Lanes>,
}

impl Work {
    pub fn new(m: usize, q: usize) -> Self {
        let room = |len| vec![[0.0; LANES]; len];
        let products = row_start(m) + q * m;
        Self {
            m,
            q,
            part: room(products),
            factor: room(products),
            inverse_length: room(m),
            inverse_root: room(m),
            coefficients: room(m),
            least_pivot: [0.0; LANES],
            least_remains: [0.0; LANES],
            squares: room(q),
        }
    }

    /// Fits the normal equations `total` without each of up to [`LANES`] `parts`. Each fit is scored on the normal equations
    /// in `scored` that belong to its part.
    pub fn fit(
        &mut self,
        total: &NormalEquations,
        terms: Terms<'_>,
        [parts, scored]: [&[NormalEquations]; 2],
        shares: &[f64],
    ) {
        pulp::Arch::new().dispatch(Group { total, terms, parts, scored, shares, work: self });
    }

    /// Writes the sums of squared errors of one fit on its left-out part, one for each target. Returns false if the errors
    /// are not reliable.
    pub fn answer(&self, lane: usize, squares: &mut [f64]) -> bool {
        for (square, lanes) in squares.iter_mut().zip(&self.squares) {
            *square = lanes[lane].max(0.0);
        }
        self.least_pivot[lane] >= SURELY_INDEPENDENT && self.least_remains[lane] >= SURELY_REMAINS
    }
}

/// Returns the index of the first element of row `i` in a lower triangle that is stored row by row with its diagonal.
const fn row_start(i: usize) -> usize {
    i * (i + 1) / 2
}

/// Fits that are computed together. The code is compiled for each instruction set.
struct Group<'a> {
    total: &'a NormalEquations,
    terms: Terms<'a>,
    parts: &'a [NormalEquations],
    scored: &'a [NormalEquations],
    /// Ridge penalty of each column, as a share of its squared length.
    shares: &'a [f64],
    work: &'a mut Work,
}

impl pulp::WithSimd for Group<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        self.gather();
        self.work.factorise();
        for target in 0..self.work.q {
            self.work.substitute_back(target);
            let square_of = |part: &NormalEquations| part.target_square(target);
            let square = gathered(self.scored, square_of);
            self.work.squares[target] = self.work.squares_on_part(target, square);
        }
    }
}

/// Returns one number of each part of the data, each in its own SIMD lane. If there are fewer parts than lanes, the
/// remaining lanes repeat the number of the last part.
#[inline(always)]
fn gathered(parts: &[NormalEquations], number: impl Fn(&NormalEquations) -> f64) -> Lanes {
    std::array::from_fn(|lane| number(&parts[lane.min(parts.len() - 1)]))
}

impl Group<'_> {
    /// Computes the sums of products of each left-out part, and of the total without this part.
    #[inline(always)]
    fn gather(&mut self) {
        let total = self.total;
        let is_same = std::ptr::eq(self.parts, self.scored);
        let (parts, scored) = (self.parts, self.scored);
        let scored_part = |part: Lanes, product_of: &dyn Fn(&NormalEquations) -> f64| {
            if is_same { part } else { gathered(scored, product_of) }
        };
        let used = self.terms.used;
        let work = &mut *self.work;
        work.least_remains = [f64::INFINITY; LANES];
        for (i, &column) in used.iter().enumerate() {
            let penalty = self.shares[column];
            let all = total.feature_product(column, column);
            let product_of = |part: &NormalEquations| part.feature_product(column, column);
            let part = gathered(parts, product_of);
            work.part[row_start(i) + i] = scored_part(part, &product_of);
            let mut present = [0.0; LANES];
            for lane in 0..LANES {
                let remains = (all - part[lane]) / all;
                if !(remains >= work.least_remains[lane]) {
                    work.least_remains[lane] = remains;
                }
                let square = (all - part[lane]) * (1.0 + penalty);
                let is_there = square > 0.0;
                work.inverse_length[i][lane] = if is_there { 1.0 / square.sqrt() } else { 0.0 };
                present[lane] = f64::from(u8::from(is_there));
            }
            work.factor[row_start(i) + i] = present;
            for (j, &other) in used[..i].iter().enumerate() {
                let all = total.feature_product(column, other);
                let product_of = |part: &NormalEquations| part.feature_product(column, other);
                let part = gathered(parts, product_of);
                let at = row_start(i) + j;
                work.part[at] = scored_part(part, &product_of);
                for lane in 0..LANES {
                    let scale = work.inverse_length[i][lane] * work.inverse_length[j][lane];
                    work.factor[at][lane] = (all - part[lane]) * scale;
                }
            }
        }
        for target in 0..work.q {
            for (j, &column) in used.iter().enumerate() {
                let all = total.target_product(column, target);
                let product_of = |part: &NormalEquations| part.target_product(column, target);
                let part = gathered(parts, product_of);
                let at = row_start(work.m) + target * work.m + j;
                work.part[at] = scored_part(part, &product_of);
                for lane in 0..LANES {
                    work.factor[at][lane] = (all - part[lane]) * work.inverse_length[j][lane];
                }
            }
        }
    }
}

impl Work {
    /// Computes the Cholesky factor column by column. A pivot that is too small counts as infinite.
    #[inline(always)]
    fn factorise(&mut self) {
        let m = self.m;
        self.least_pivot = [f64::INFINITY; LANES];
        for j in 0..m {
            let (before, from_row) = self.factor.split_at_mut(row_start(j));
            debug_assert_eq!(before.len(), row_start(j));
            let (row, below) = from_row.split_at_mut(j + 1);
            let (factors, pivot) = row.split_at_mut(j);
            let pivot = reduced(pivot[0], factors, factors);
            for lane in 0..LANES {
                // The values are compared, because `min` would ignore NaN.
                if !(pivot[lane] >= self.least_pivot[lane]) {
                    self.least_pivot[lane] = pivot[lane];
                }
                let sure = pivot[lane] >= SURELY_INDEPENDENT;
                self.inverse_root[j][lane] = if sure { 1.0 / pivot[lane].sqrt() } else { 0.0 };
            }
            let inverse_root = self.inverse_root[j];
            let mut start = 0;
            for i in j + 1..m + self.q {
                let len = if i < m { i + 1 } else { m };
                let row = &mut below[start..start + len];
                let (done, entry) = row.split_at_mut(j);
                let value = reduced(entry[0], done, factors);
                for lane in 0..LANES {
                    entry[0][lane] = value[lane] * inverse_root[lane];
                }
                start += len;
            }
        }
    }

    /// Computes the coefficients of one target by back substitution, for columns that are scaled to length one.
    #[inline(always)]
    fn substitute_back(&mut self, target: usize) {
        let m = self.m;
        let right = row_start(m) + target * m;
        for j in (0..m).rev() {
            let mut value = self.factor[right + j];
            for i in j + 1..m {
                let factor = &self.factor[row_start(i) + j];
                for lane in 0..LANES {
                    value[lane] -= factor[lane] * self.coefficients[i][lane];
                }
            }
            for lane in 0..LANES {
                self.coefficients[j][lane] = value[lane] * self.inverse_root[j][lane];
            }
        }
    }

    /// Returns the squared errors of one target on the left-out part, `yᵀy − 2bᵀXᵀy + bᵀXᵀXb`; see
    /// [`NormalEquations::squared_residuals`].
    #[inline(always)]
    fn squares_on_part(&mut self, target: usize, mut square: Lanes) -> Lanes {
        let m = self.m;
        for (coefficient, scale) in self.coefficients.iter_mut().zip(&self.inverse_length) {
            for lane in 0..LANES {
                coefficient[lane] *= scale[lane];
            }
        }
        let right = &self.part[row_start(m) + target * m..][..m];
        for (i, right) in right.iter().enumerate() {
            let row = &self.part[row_start(i)..][..=i];
            let mut earlier = [0.0; LANES];
            for (product, coefficient) in row[..i].iter().zip(&self.coefficients) {
                for lane in 0..LANES {
                    earlier[lane] += product[lane] * coefficient[lane];
                }
            }
            let coefficients = self.coefficients[i];
            for lane in 0..LANES {
                let explained =
                    row[i][lane] * coefficients[lane] + 2.0 * (earlier[lane] - right[lane]);
                square[lane] += coefficients[lane] * explained;
            }
        }
        square
    }
}

/// Returns `value − Σ aₖ bₖ`, summed over the length of `b`.
#[inline(always)]
fn reduced(mut value: Lanes, a: &[Lanes], b: &[Lanes]) -> Lanes {
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            value[lane] = (-a[lane]).mul_add(b[lane], value[lane]);
        }
    }
    value
}
