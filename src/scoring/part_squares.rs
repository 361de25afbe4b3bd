//! The squared errors of parts that a fit has not seen: by them, part by part, fits of any kind are compared.

use crate::scoring::left_out::summed_by_target;
use crate::scoring::metrics::root_mean;

/// What a fit to the other parts leaves over of each part.
///
/// The parts are those of the recordings, the same for every regressor, so that two of them can be compared part by part.
#[derive(Clone, Debug, PartialEq)]
pub struct PartSquares {
    /// The number of samples of each part.
    pub part_samples: Vec<u64>,
    /// Sums of squared errors, `n_parts × n_axes` row-major.
    pub squares: Vec<f64>,
}

impl PartSquares {
    /// Root mean squared error per axis over all parts; `None` without samples.
    pub fn rmse(&self) -> Option<Vec<f64>> {
        let n_axes = self.squares.len() / self.part_samples.len().max(1);
        let squares = summed_by_target(&self.squares, n_axes);
        root_mean(&squares, self.part_samples.iter().sum())
    }
}
