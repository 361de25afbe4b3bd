//! Squared errors on the held-out parts of a cross-validation. Models of any kind are compared by them.

use crate::scoring::{left_out::summed_by_target, metrics::root_mean};

/// Squared errors on each part of the data, by the fit to all other parts. All models use the same parts.
#[derive(Debug)]
pub struct PartSquares {
    pub part_samples: Vec<u64>,
    /// Sums of squared errors, `n_parts × n_axes` row-major.
    pub squares: Vec<f64>,
}

impl PartSquares {
    /// Returns the RMSE per axis over all parts; `None` without samples.
    pub fn rmse(&self) -> Option<Vec<f64>> {
        let n_axes = self.squares.len() / self.part_samples.len().max(1);
        let squares = summed_by_target(&self.squares, n_axes);
        root_mean(&squares, self.part_samples.iter().sum())
    }
}
