//! How certain the coefficients of a fit are.

use serde::{Deserialize, Serialize};

use super::{CrossValidation, LinearMap};

/// Of more features it takes too long to be known at every step of a slider, and covariances would be most of a file.
pub(crate) const MOST_FEATURES: usize = 48;

/// The delete-one-group jackknife of the coefficients.
///
/// **Source** B. Efron, C. Stein, "The jackknife estimate of variance", 1981: with fits θᵢ to all parts but one, each of G in turn,
/// `cov = (G − 1)/G Σ (θᵢ − θ̄)(θᵢ − θ̄)ᵀ`. Parts are those of cross-validation, as neighbouring samples know of each other. Its rank is at most
/// G − 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoefficientUncertainty {
    /// What was left out in turn.
    pub left_out: CrossValidation,
    /// The standard uncertainty of each coefficient of the compensated matrix: a row per axis, a column per feature.
    pub standard: Vec<Vec<f64>>,
    /// For each axis the covariance of its coefficients.
    pub covariance: Vec<Vec<Vec<f64>>>,
}

impl CoefficientUncertainty {
    /// Of the matrices of fits that leave each part out; `None` with fewer than two.
    pub fn of(left_out: CrossValidation, fits: &[LinearMap]) -> Option<Self> {
        let matrices: Vec<&Vec<Vec<f64>>> = fits.iter().map(|map| &map.matrix).collect();
        let n = matrices.len();
        let first = matrices.first().filter(|_| n > 1)?;
        let factor = (n as f64 - 1.0) / n as f64;
        let deviations = |axis: usize, column: usize| {
            let mean = matrices.iter().map(|own| own[axis][column]).sum::<f64>() / n as f64;
            matrices
                .iter()
                .map(|own| own[axis][column] - mean)
                .collect::<Vec<f64>>()
        };
        let by_axis = |axis: usize| {
            (0..first[axis].len())
                .map(|column| deviations(axis, column))
                .collect::<Vec<_>>()
        };
        let deviations: Vec<Vec<Vec<f64>>> = (0..first.len()).map(by_axis).collect();
        let product =
            |a: &[f64], b: &[f64]| factor * a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let covariance = deviations.iter().map(|of_axis| {
            let row = |a: &Vec<f64>| of_axis.iter().map(|b| product(a, b)).collect();
            of_axis.iter().map(row).collect()
        });
        Some(Self {
            covariance: covariance.collect(),
            standard: deviations
                .iter()
                .map(|of_axis| of_axis.iter().map(|own| product(own, own).sqrt()).collect())
                .collect(),
            left_out,
        })
    }

    /// Whether it is of a matrix with so many rows and columns.
    pub(crate) fn is_of(&self, n_axes: usize, n_columns: usize) -> bool {
        let all = self.standard.iter().chain(self.covariance.iter().flatten());
        let square = self.covariance.iter().all(|own| own.len() == n_columns);
        let counts = self.standard.len() == n_axes && self.covariance.len() == n_axes;
        counts && square && all.into_iter().all(|row| row.len() == n_columns)
    }

    /// All numbers of it.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = &f64> {
        let covariance = self.covariance.iter().flatten().flatten();
        self.standard.iter().flatten().chain(covariance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a mean, the jackknife is what everybody knows: s²/n. Values 1, 2, 6 leave the means 4, 3.5, 1.5; s²/n is 7/3.
    #[test]
    fn of_a_mean_it_is_the_variance_over_the_number() {
        let fits = [4.0, 3.5, 1.5].map(|mean| LinearMap {
            columns: Vec::new(),
            matrix: vec![vec![mean, -mean]],
        });
        let found = CoefficientUncertainty::of(CrossValidation::default(), &fits).unwrap();
        assert!((found.standard[0][0] - (7.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!((found.covariance[0][0][1] + 7.0 / 3.0).abs() < 1e-12);
        assert_eq!(
            CoefficientUncertainty::of(CrossValidation::default(), &fits[..1]),
            None
        );
    }
}
