//! The dot product.

/// Returns the dot product. If one slice is longer, its remaining numbers are ignored.
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
