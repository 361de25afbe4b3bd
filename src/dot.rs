//! The dot product.

/// Returns the dot product over the common length. Rows of a triangular matrix may be shorter.
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
