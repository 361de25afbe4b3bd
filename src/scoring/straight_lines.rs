//! Deviation of samples from a straight line in time.

/// Returns the deviation of three successive samples from a straight line. It is divided by √6, so that it has the noise of
/// one sample.
pub fn bend([a, b, c]: [f64; 3]) -> f64 {
    (a - 2.0 * b + c).abs() / 6_f64.sqrt()
}
