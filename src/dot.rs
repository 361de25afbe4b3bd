//! The dot product.

/// Returns the dot product. If one slice is longer, its remaining numbers are ignored.
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns the dot product of two slices of equal length. Several sums are computed side by side, so long slices take less time
/// than with [`dot`], and the rounding differs.
#[inline]
pub(crate) fn dot_of_long(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let ((a, rest_of_a), (b, rest_of_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + dot(rest_of_a, rest_of_b)
}
