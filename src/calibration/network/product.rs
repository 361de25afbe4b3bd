//! Matrix products on the calling thread. The crate faer computes most rows, and this file computes the last up to 15 rows.
//!
//! Guarantees: the results are repeatable on the same kind of processor.
//!
//! Faer processes 16 rows of single precision at a time. For a layer of 100 units, it would use only 4 of the last 16 rows,
//! and dependent sums would wait for each other. The code of this file computes the rows after the last multiple of 16, ten
//! columns at a time.

use crate::vectorised::vectorised;
use faer::linalg::matmul::matmul;
use faer::traits::RealField;
use faer::{Accum, MatMut, MatRef, Par};

/// Floating-point type in which a network is computed.
pub(super) trait Real: RealField + Copy + PartialOrd + From<f32> {
    /// Computes `out = left · right`.
    fn product(out: Out<Self>, left: View<Self>, right: View<Self>);
}

impl Real for f64 {
    fn product(out: Out<Self>, left: View<Self>, right: View<Self>) {
        by_faer(out, left, right);
    }
}

impl Real for f32 {
    fn product(mut out: Out<Self>, left: View<Self>, right: View<Self>) {
        let edge = out.n_rows % ROWS_OF_FAER;
        if edge == 0 || edge > LANES {
            by_faer(out, left, right);
            return;
        }
        let bulk = out.n_rows - edge;
        if bulk > 0 {
            by_faer(out.first_rows(bulk), left.first_rows(bulk), right);
        }
        let mut edge = Edge { out, left, right, first_row: bulk };
        vectorised(
            #[inline(always)]
            move || edge.write(),
        );
    }
}

fn by_faer<T: Real>(out: Out<T>, left: View<T>, right: View<T>) {
    let out = MatMut::from_column_major_slice_with_stride_mut(
        out.values,
        out.n_rows,
        out.n_columns,
        out.stride,
    );
    let (left, right) = (left.to_faer(), right.to_faer());
    matmul(out, Accum::Replace, left, right, T::from(1.0), Par::Seq);
}

/// Matrix to read. Consecutive columns are `stride` numbers apart in memory. If transposed, consecutive rows are `stride`
/// numbers apart instead.
#[derive(Clone, Copy)]
pub(super) struct View<'a, T> {
    values: &'a [T],
    n_rows: usize,
    n_columns: usize,
    stride: usize,
    transposed: bool,
}

impl<'a, T: Real> View<'a, T> {
    pub fn new(values: &'a [T], n_rows: usize, n_columns: usize, stride: usize) -> Self {
        Self { values, n_rows, n_columns, stride, transposed: false }
    }

    pub fn transpose(self) -> Self {
        Self {
            n_rows: self.n_columns,
            n_columns: self.n_rows,
            transposed: !self.transposed,
            ..self
        }
    }

    fn first_rows(self, n_rows: usize) -> Self {
        Self { n_rows, ..self }
    }

    fn to_faer(self) -> MatRef<'a, T> {
        let of = |n_rows, n_columns| {
            MatRef::from_column_major_slice_with_stride(self.values, n_rows, n_columns, self.stride)
        };
        if self.transposed {
            of(self.n_columns, self.n_rows).transpose()
        } else {
            of(self.n_rows, self.n_columns)
        }
    }
}

/// Matrix to write. Consecutive columns are `stride` numbers apart in memory. If `stride` is larger than the length of a
/// column, the numbers between columns stay unchanged.
pub(super) struct Out<'a, T> {
    values: &'a mut [T],
    n_rows: usize,
    n_columns: usize,
    stride: usize,
}

impl<'a, T> Out<'a, T> {
    pub fn new(values: &'a mut [T], n_rows: usize, n_columns: usize, stride: usize) -> Self {
        Self { values, n_rows, n_columns, stride }
    }

    fn first_rows(&mut self, n_rows: usize) -> Out<'_, T> {
        Out { values: &mut *self.values, n_rows, ..*self }
    }
}

/// Number of rows that faer processes at a time with the widest registers.
const ROWS_OF_FAER: usize = 16;
/// Maximum number of last rows that the code of this file computes.
const LANES: usize = 8;
/// Number of output columns that are computed together. Their sums fit into registers and hide the latency of dependent sums.
const COLUMNS: usize = 10;
/// Number of products that are summed in registers before the sums are added to the output. This many columns of the left
/// matrix are copied at a time.
const DEPTH: usize = 256;

/// One number for each of the last rows of the product.
type Lanes = [f32; LANES];

/// Product of which the rows from `first_row` on are computed here. There are at most [`LANES`] of these rows.
struct Edge<'a> {
    out: Out<'a, f32>,
    left: View<'a, f32>,
    right: View<'a, f32>,
    first_row: usize,
}

impl Edge<'_> {
    #[inline(always)]
    fn write(&mut self) {
        let mut panel = [[0.0; LANES]; DEPTH];
        let depth = self.left.n_columns;
        for start in (0..depth).step_by(DEPTH) {
            let panel = &mut panel[..(depth - start).min(DEPTH)];
            self.copy_panel(start, panel);
            let n_columns = self.out.n_columns;
            let whole = n_columns - n_columns % COLUMNS;
            for column in (0..whole).step_by(COLUMNS) {
                self.columns::<COLUMNS>(start, panel, column);
            }
            for column in whole..n_columns {
                self.columns::<1>(start, panel, column);
            }
        }
    }

    /// Copies the last rows of the left matrix into `panel`, from column `start` on. Lanes beyond the last row have arbitrary
    /// values.
    #[inline(always)]
    fn copy_panel(&self, start: usize, panel: &mut [Lanes]) {
        let View { values, stride, .. } = self.left;
        let n_rows = self.out.n_rows - self.first_row;
        if self.left.transposed {
            for lane in 0..n_rows {
                let row = &values[(self.first_row + lane) * stride + start..][..panel.len()];
                for (lanes, value) in panel.iter_mut().zip(row) {
                    lanes[lane] = *value;
                }
            }
        } else {
            for (k, lanes) in panel.iter_mut().enumerate() {
                let column = &values[(start + k) * stride + self.first_row..];
                match column.first_chunk() {
                    Some(all) => *lanes = *all,
                    None => lanes[..n_rows].copy_from_slice(&column[..n_rows]),
                }
            }
        }
    }

    /// Computes the last rows of `N` columns of the product, from column `first` on, and adds them to the output.
    #[inline(always)]
    fn columns<const N: usize>(&mut self, start: usize, panel: &[Lanes], first: usize) {
        let View { values, stride, .. } = self.right;
        let sums: [Lanes; N] = if self.right.transposed {
            sums_over_rows(panel, &values[start * stride + first..], stride)
        } else {
            sums_over_columns(panel, &values[first * stride + start..], stride)
        };
        let n_rows = self.out.n_rows - self.first_row;
        for (column, sums) in sums.iter().enumerate() {
            let at = (first + column) * self.out.stride + self.first_row;
            let out = &mut self.out.values[at..][..n_rows];
            for (lane, sum) in sums.iter().enumerate() {
                if let Some(out) = out.get_mut(lane) {
                    *out = if start == 0 { *sum } else { *out + sum };
                }
            }
        }
    }
}

/// Returns `N` columns of the product of `panel` with a right matrix whose columns are `stride` numbers apart.
#[inline(always)]
fn sums_over_columns<const N: usize>(panel: &[Lanes], right: &[f32], stride: usize) -> [Lanes; N] {
    let columns: [&[f32]; N] = std::array::from_fn(|at| &right[at * stride..][..panel.len()]);
    let mut sums = [[0.0; LANES]; N];
    for (k, lanes) in panel.iter().enumerate() {
        for column in 0..N {
            add_product(&mut sums[column], lanes, columns[column][k]);
        }
    }
    sums
}

/// Returns `N` columns of the product of `panel` with a right matrix whose rows are `stride` numbers apart.
#[inline(always)]
fn sums_over_rows<const N: usize>(panel: &[Lanes], right: &[f32], stride: usize) -> [Lanes; N] {
    let mut sums = [[0.0; LANES]; N];
    for (lanes, row) in panel.iter().zip(right.chunks(stride)) {
        let row: &[f32; N] = row.first_chunk().expect("each row of the right matrix has N numbers");
        for column in 0..N {
            add_product(&mut sums[column], lanes, row[column]);
        }
    }
    sums
}

#[inline(always)]
fn add_product(sum: &mut Lanes, left: &Lanes, right: f32) {
    for lane in 0..LANES {
        sum[lane] = left[lane].mul_add(right, sum[lane]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Matrix of integers without a simple relation. Its gaps must not be read.
    struct Stored {
        values: Vec<f32>,
        n_rows: usize,
        n_columns: usize,
        transposed: bool,
    }

    impl Stored {
        fn new(n_rows: usize, n_columns: usize, transposed: bool) -> Self {
            let (tall, wide) = if transposed { (n_columns, n_rows) } else { (n_rows, n_columns) };
            let number = |at: usize| ((at * 37 + tall) % 23) as f32 - 11.0;
            let in_column = |at: usize| at % (tall + 3) < tall;
            let values = (0..wide * (tall + 3))
                .map(|at| if in_column(at) { number(at) } else { f32::NAN })
                .collect();
            Self { values, n_rows: tall, n_columns: wide, transposed }
        }

        fn view(&self) -> View<'_, f32> {
            let view = View::new(&self.values, self.n_rows, self.n_columns, self.n_rows + 3);
            if self.transposed { view.transpose() } else { view }
        }

        fn at(&self, row: usize, column: usize) -> f32 {
            let (i, j) = if self.transposed { (column, row) } else { (row, column) };
            self.values[j * (self.n_rows + 3) + i]
        }
    }

    fn check(n_rows: usize, depth: usize, n_columns: usize, transposed: [bool; 2]) {
        let left = Stored::new(n_rows, depth, transposed[0]);
        let right = Stored::new(depth, n_columns, transposed[1]);
        let stride = n_rows + 2;
        let mut out = vec![0.5; stride * n_columns];
        f32::product(Out::new(&mut out, n_rows, n_columns, stride), left.view(), right.view());
        for (at, actual) in out.into_iter().enumerate() {
            let (row, column) = (at % stride, at / stride);
            let plain = |k| left.at(row, k) * right.at(k, column);
            let expected = if row < n_rows { (0..depth).map(plain).sum() } else { 0.5 };
            assert_eq!(actual, expected, "{n_rows} × {depth} × {n_columns}, {transposed:?}");
        }
    }

    /// Every sum is an integer below 300 · 11², so products must be exact.
    #[test]
    fn products_are_exact_and_write_nothing_else() {
        for n_rows in [1, 6, 8, 9, 16, 20, 100] {
            for depth in [1, 13, DEPTH, DEPTH + 44] {
                for n_columns in [1, 10, 23] {
                    for transposed in [[false, false], [true, false], [false, true], [true, true]] {
                        check(n_rows, depth, n_columns, transposed);
                    }
                }
            }
        }
    }
}
