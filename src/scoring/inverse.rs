//! Inverse of a symmetric matrix along the directions that it determines.

use faer::{Mat, Side};

/// Returns the pseudo-inverse of a symmetric, positive semi-definite matrix. Eigenvalues up to `least` times the largest one
/// count as zero.
pub fn inverse_above(of: &Mat<f64>, least: f64) -> Option<Mat<f64>> {
    let eigen = of.self_adjoint_eigen(Side::Lower).ok()?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    let largest = values.iter().copied().fold(0.0, f64::max);
    let scaled = Mat::from_fn(of.nrows(), of.ncols(), |i, j| {
        if values[j] > least * largest { vectors[(i, j)] / values[j] } else { 0.0 }
    });
    Some(scaled * vectors.transpose())
}
