//! The dot product.

/// Returns the dot product of the entries that both have: rows of a triangle end on the diagonal.
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
