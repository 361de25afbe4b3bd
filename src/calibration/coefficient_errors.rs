//! Standard errors of the coefficients of a linear fit.

use serde::{Deserialize, Serialize};

use crate::calibration::{cross_validation::CrossValidation, linear_map::LinearMap};

/// Maximum number of features for which standard errors are computed. With more, the window would react too slowly to a
/// slider.
pub(crate) const MOST_FEATURES: usize = 48;

/// Standard errors of the coefficients by the delete-one-group jackknife.
///
/// **Source** B. Efron, C. Stein, "The jackknife estimate of variance", 1981: `var = (G − 1)/G Σ (θᵢ − θ̄)²`. The θᵢ are the
/// coefficients of G fits, each without one of G parts of the recordings. The parts are those of cross-validation, because
/// neighbouring samples are correlated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoefficientErrors {
    pub left_out: CrossValidation,
    /// Standard error of each coefficient of the compensated matrix: one row per axis, one column per feature.
    pub standard: Vec<Vec<f64>>,
}

impl CoefficientErrors {
    /// Computes the standard errors from fits that each leave out one part of the recordings; `None` with fewer than two
    /// fits.
    pub fn of(left_out: CrossValidation, fits: &[LinearMap]) -> Option<Self> {
        let n = fits.len() as f64;
        let first = &fits.first().filter(|_| fits.len() > 1)?.matrix;
        let standard = |axis: usize, column: usize| {
            let of_fits = || fits.iter().map(|fit| fit.matrix[axis][column]);
            let mean = of_fits().sum::<f64>() / n;
            let squares = of_fits().map(|coefficient| (coefficient - mean).powi(2));
            ((n - 1.0) / n * squares.sum::<f64>()).sqrt()
        };
        let of_axis =
            |axis: usize| (0..first[axis].len()).map(|column| standard(axis, column)).collect();
        Some(Self { standard: (0..first.len()).map(of_axis).collect(), left_out })
    }

    /// Returns true if there is one standard error for each coefficient of an `n_axes × n_columns` matrix.
    pub(crate) fn is_of(&self, n_axes: usize, n_columns: usize) -> bool {
        self.standard.len() == n_axes && self.standard.iter().all(|row| row.len() == n_columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For a mean, the jackknife gives s²/n. The values 1, 2, 6 have the leave-one-out means 4, 3.5, 1.5, and s²/n is 7/3.
    #[test]
    fn the_jackknife_of_a_mean_is_the_variance_over_the_number() {
        let fits = [4.0, 3.5, 1.5].map(|mean| LinearMap::new(Vec::new(), vec![vec![mean, -mean]]));
        let found = CoefficientErrors::of(CrossValidation::default(), &fits).unwrap();
        assert!((found.standard[0][0] - (7.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert_eq!(CoefficientErrors::of(CrossValidation::default(), &fits[..1]), None);
    }
}
