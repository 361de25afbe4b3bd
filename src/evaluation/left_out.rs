//! Leave-one-out fits, eight at a time: each part that is left out has a lane of its own.
//!
//! Guarantees: the squared errors are those of [`fit`] to the sums without the part, up to rounding; a fit whose columns
//! nearly explain each other goes to [`fit`] itself, which finds the rank.
//!
//! How: Cholesky without pivoting, the targets as further rows of the matrix, so that forward substitution comes with
//! the factor. All fits have the same shape, so every step does one operation on eight of them.

#![expect(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays, as the compiler vectorises it"
)]
#![expect(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "a pivot that is no number counts as too small"
)]

use crate::calibration::{NormalEquations, Ridge, fit};

/// Fits worked on at once.
const LANES: usize = 8;

/// One number per lane.
type Lanes = [f64; LANES];

/// What must be left of each column's squared length, as a share, after the columns before it have explained theirs.
///
/// Far above the share at which [`fit`] drops a column: whoever is anywhere near that takes the careful way.
const SURELY_INDEPENDENT: f64 = 1e-6;

/// The fits that leave each part out of the total, on some of the columns.
#[derive(Clone, Copy, Debug)]
pub struct LeftOut<'a> {
    /// The sums over all parts.
    pub total: &'a NormalEquations,
    /// What is left out in turn; parts without samples say nothing and do not belong here.
    pub parts: &'a [NormalEquations],
    /// The columns that are fitted.
    pub used: &'a [usize],
    /// For every column of the sums, whether the ridge shrinks it.
    pub shrunk: &'a [bool],
}

impl LeftOut<'_> {
    /// [`Self::squares`] with a strength of its own for each target.
    #[must_use]
    pub fn squares_by_target(&self, strengths: &[f64]) -> Vec<f64> {
        let q = self.total.n_targets();
        let mut squares = vec![0.0; self.parts.len() * q];
        for target in 0..q {
            if strengths[..target].contains(&strengths[target]) {
                continue; // filled in with the first target of this strength
            }
            let with_it = self.squares(strengths[target]);
            for at in 0..squares.len() {
                if strengths[at % q] == strengths[target] {
                    squares[at] = with_it[at];
                }
            }
        }
        squares
    }

    /// Sums of squared errors of each part, predicted by the fit to the others with a ridge relative to the columns'
    /// lengths.
    ///
    /// **Shapes** `n_parts × n_targets`, row-major.
    ///
    /// # Panics
    /// If the sums differ in their columns, or `used` or `shrunk` do not fit them.
    #[must_use]
    pub fn squares(&self, strength: f64) -> Vec<f64> {
        let q = self.total.n_targets();
        let mut squares = vec![0.0; self.parts.len() * q];
        let mut work = Work::new(self.used.len(), q);
        let groups = self.parts.chunks(LANES).zip(squares.chunks_mut(LANES * q));
        for (parts, squares) in groups {
            pulp::Arch::new().dispatch(Group {
                left_out: self,
                parts,
                strength,
                work: &mut work,
            });
            for ((lane, part), squares) in parts.iter().enumerate().zip(squares.chunks_mut(q)) {
                if work.least_pivot[lane] >= SURELY_INDEPENDENT {
                    for (square, lanes) in squares.iter_mut().zip(&work.squares) {
                        *square = lanes[lane].max(0.0);
                    }
                } else {
                    squares.copy_from_slice(&self.squares_of(part, strength));
                }
            }
        }
        squares
    }

    /// The careful way.
    fn squares_of(&self, part: &NormalEquations, strength: f64) -> Vec<f64> {
        let columns = self.shrunk;
        let ridge = Ridge::Relative { strength, columns };
        let rest = self.total.without(part);
        part.squared_residuals(&fit(&rest, self.used, ridge).coefficients)
    }
}

/// Room for one group of fits of `m` columns and `q` targets.
struct Work {
    m: usize,
    q: usize,
    /// The part's products: the lower triangle of `XᵀX` row by row, then a row of `XᵀY` for each target.
    part: Vec<Lanes>,
    /// Likewise those of the rest, each column scaled to length one; becomes the factor.
    factor: Vec<Lanes>,
    inverse_length: Vec<Lanes>,
    inverse_root: Vec<Lanes>,
    coefficients: Vec<Lanes>,
    least_pivot: Lanes,
    squares: Vec<Lanes>,
}

impl Work {
    fn new(m: usize, q: usize) -> Self {
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
            squares: room(q),
        }
    }
}

/// Where row `i` of a lower triangle begins, diagonal included.
const fn row_start(i: usize) -> usize {
    i * (i + 1) / 2
}

/// Compiled for each instruction set; which one is decided when the program runs.
struct Group<'a> {
    left_out: &'a LeftOut<'a>,
    parts: &'a [NormalEquations],
    strength: f64,
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
            let own = |part: &NormalEquations| part.target_square(target);
            let square = gathered(self.parts, own);
            self.work.squares[target] = self.work.squares_on_part(target, square);
        }
    }
}

/// One number of each part; lanes without a part repeat the last one.
#[inline(always)]
fn gathered(parts: &[NormalEquations], number: impl Fn(&NormalEquations) -> f64) -> Lanes {
    std::array::from_fn(|lane| number(&parts[lane.min(parts.len() - 1)]))
}

impl Group<'_> {
    /// Fills in the products of the parts and of what is left without them.
    #[inline(always)]
    fn gather(&mut self) {
        let LeftOut {
            total,
            used,
            shrunk,
            ..
        } = *self.left_out;
        let work = &mut *self.work;
        for (i, &column) in used.iter().enumerate() {
            let penalty = if shrunk[column] { self.strength } else { 0.0 };
            let all = total.feature_product(column, column);
            let part = gathered(self.parts, |part| part.feature_product(column, column));
            work.part[row_start(i) + i] = part;
            let mut present = [0.0; LANES];
            for lane in 0..LANES {
                let square = (all - part[lane]) * (1.0 + penalty);
                let is_there = square > 0.0;
                work.inverse_length[i][lane] = if is_there { 1.0 / square.sqrt() } else { 0.0 };
                present[lane] = f64::from(u8::from(is_there));
            }
            work.factor[row_start(i) + i] = present;
            for (j, &other) in used[..i].iter().enumerate() {
                let all = total.feature_product(column, other);
                let part = gathered(self.parts, |part| part.feature_product(column, other));
                let at = row_start(i) + j;
                work.part[at] = part;
                for lane in 0..LANES {
                    let scale = work.inverse_length[i][lane] * work.inverse_length[j][lane];
                    work.factor[at][lane] = (all - part[lane]) * scale;
                }
            }
        }
        for target in 0..work.q {
            for (j, &column) in used.iter().enumerate() {
                let all = total.target_product(column, target);
                let part = gathered(self.parts, |part| part.target_product(column, target));
                let at = row_start(work.m) + target * work.m + j;
                work.part[at] = part;
                for lane in 0..LANES {
                    work.factor[at][lane] = (all - part[lane]) * work.inverse_length[j][lane];
                }
            }
        }
    }
}

impl Work {
    /// Cholesky, column by column; a pivot that is not surely positive is noted and counts as infinite.
    #[inline(always)]
    fn factorise(&mut self) {
        let m = self.m;
        self.least_pivot = [f64::INFINITY; LANES];
        for j in 0..m {
            let (before, from_row) = self.factor.split_at_mut(row_start(j));
            debug_assert_eq!(before.len(), row_start(j));
            let (row, below) = from_row.split_at_mut(j + 1);
            let (own, pivot) = row.split_at_mut(j);
            let pivot = reduced(pivot[0], own, own);
            for lane in 0..LANES {
                // Not `min`, which would take NaN for the larger one.
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
                let value = reduced(entry[0], done, own);
                for lane in 0..LANES {
                    entry[0][lane] = value[lane] * inverse_root[lane];
                }
                start += len;
            }
        }
    }

    /// The coefficients of one target, on columns of length one.
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

    /// `yᵀy − 2bᵀXᵀy + bᵀXᵀXb` on the part; see [`NormalEquations::squared_residuals`].
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
            let own = self.coefficients[i];
            for lane in 0..LANES {
                let explained = row[i][lane] * own[lane] + 2.0 * (earlier[lane] - right[lane]);
                square[lane] += own[lane] * explained;
            }
        }
        square
    }
}

/// `value − Σ aₖ bₖ`, over the length of `b`.
#[inline(always)]
fn reduced(mut value: Lanes, a: &[Lanes], b: &[Lanes]) -> Lanes {
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            value[lane] = (-a[lane]).mul_add(b[lane], value[lane]);
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::cross_validation::left_out_squares;

    /// `n` parts of `p` columns and two targets without a simple relation; column 1 is `explained` times column 0 plus
    /// something small of its own.
    fn parts(n: usize, p: usize, small: f64) -> (NormalEquations, Vec<NormalEquations>) {
        let parts: Vec<_> = (0..n)
            .map(|part| {
                let mut sums = NormalEquations::new(p, 2);
                for k in 0..40 + part {
                    let t = (k * 7 + part * 131) as f64;
                    let mut row = vec![0.0; sums.stride()];
                    for (column, value) in row[..p + 2].iter_mut().enumerate() {
                        *value = (t * (0.11 + 0.07 * column as f64)).sin() + 0.1 * column as f64;
                    }
                    if p > 1 {
                        row[1] = 3.0 * row[0] + small * row[1];
                    }
                    sums.add_rows(&row);
                }
                sums
            })
            .collect();
        let mut total = NormalEquations::new(p, 2);
        parts.iter().for_each(|part| total.add(part));
        (total, parts)
    }

    #[track_caller]
    fn assert_as_one_by_one(n: usize, p: usize, small: f64, used: &[usize], strength: f64) {
        let (total, parts) = parts(n, p, small);
        let columns: Vec<bool> = (0..p).map(|column| column % 3 != 0).collect();
        let left_out = LeftOut {
            total: &total,
            parts: &parts,
            used,
            shrunk: &columns,
        };
        let ridge = Ridge::Relative {
            strength,
            columns: &columns,
        };
        let expected = left_out_squares(&total, &parts, |sums| fit(sums, used, ridge)).unwrap();
        for (actual, expected) in left_out.squares(strength).iter().zip(expected.concat()) {
            let error = (actual / expected - 1.0).abs();
            assert!(error < 1e-10, "{n} parts, {p} columns, {small}: {error}");
        }
    }

    #[test]
    fn eight_at_once_equal_one_by_one() {
        for n in [2, 7, 8, 9, 20] {
            for p in [1, 2, 5, 14] {
                let all: Vec<usize> = (0..p).collect();
                for strength in [0.0, 0.01, 3.0] {
                    assert_as_one_by_one(n, p, 1.0, &all, strength);
                }
            }
        }
        assert_as_one_by_one(10, 9, 1.0, &[7, 2, 4], 0.1);
    }

    /// Column 1 is column 0 again, up to nothing at all or to less than a thousandth.
    #[test]
    fn columns_that_explain_each_other_take_the_careful_way() {
        for small in [0.0, 1e-4] {
            assert_as_one_by_one(9, 6, small, &[0, 1, 2, 3, 4, 5], 0.0);
        }
    }

    /// What only one part has cannot be learned from the others.
    #[test]
    fn a_column_that_only_the_left_out_part_has_gets_no_coefficient() {
        let part = |has: f64| {
            let mut sums = NormalEquations::new(2, 1);
            for k in 0..5 {
                let mut row = vec![0.0; sums.stride()];
                let x = f64::from(k) - 1.7;
                row[..3].copy_from_slice(&[x, has * x * x, 2.0 * x + 5.0 * has]);
                sums.add_rows(&row);
            }
            sums
        };
        let parts = [part(1.0), part(0.0), part(0.0)];
        let mut total = NormalEquations::new(2, 1);
        parts.iter().for_each(|part| total.add(part));
        let squares = LeftOut {
            total: &total,
            parts: &parts,
            used: &[0, 1],
            shrunk: &[false; 2],
        }
        .squares(0.0);
        assert!((squares[0] - 125.0).abs() < 1e-9, "five errors of 5");
    }
}
