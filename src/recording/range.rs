//! From the least to the greatest of some numbers.

/// The range of no numbers.
pub(crate) const NO_RANGE: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// Returns the range of these numbers.
pub(crate) fn range_of(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    values.into_iter().fold(NO_RANGE, including)
}

/// Returns the range with one more number in it.
#[inline]
pub(crate) fn including((low, high): (f64, f64), value: f64) -> (f64, f64) {
    (low.min(value), high.max(value))
}

/// Returns what two ranges reach together.
pub(crate) fn joined(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}
