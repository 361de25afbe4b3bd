//! The calibration whose error is explained, fitted to all samples, and the noise of its residuals.

use faer::Mat;
use rayon::prelude::*;

use crate::{
    calibration::NormalEquations,
    progress::{Cancelled, Progress},
    scoring::budget::{
        columns::{Columns, Rows},
        held_out::{GAUGE_RIDGE, solve},
        noise::{Differences, Noise, differences},
        run::{Model, Run, Unit, add_run},
    },
};

/// Standard deviation below which a column is left out, absolute and as a share of its mean.
const CONSTANT: f64 = 1e-9;
const CONSTANT_SHARE: f64 = 1e-7;

/// The recordings with the columns of the calibration.
pub(super) struct Base<'a> {
    pub runs: &'a [Run<'a>],
    pub columns: &'a Columns,
    pub model: Model<'a>,
}

/// Fit of the base to all samples.
pub(super) struct BaseFit {
    /// Columns that vary.
    pub used: Vec<usize>,
    /// Coefficients of the raw columns, `n_base × n_axes`.
    pub coefficients: Mat<f64>,
    /// Mean squared residual on each axis.
    pub mean_squares: Vec<f64>,
}

impl<'a> Base<'a> {
    pub fn rows(&self, run: usize) -> Rows<'a> {
        Rows::new(self.columns, self.runs, run, self.model.map(|own| own.0))
    }

    pub fn fit(&self, progress: &Progress) -> Result<BaseFit, Cancelled> {
        let sums = self.sums(progress)?;
        let (n, columns) = (sums.n_samples() as f64, self.columns);
        let variance = |column: usize| {
            let sum = sums.feature_product(0, column);
            moments(n, sum, sums.feature_product(column, column)).1.powi(2)
        };
        let ridge = |column: usize| match self.model {
            Some((_, ridge)) if columns.model().contains(&column) => ridge * variance(column),
            _ => GAUGE_RIDGE,
        };
        let varies = |column: &usize| !columns.model().contains(column) || variance(*column) > 0.0;
        let used: Vec<usize> = columns.base().filter(varies).collect();
        let products = Mat::from_fn(used.len(), used.len(), |i, j| {
            let ridge = if i == j { n * ridge(used[i]) } else { 0.0 };
            sums.feature_product(used[i], used[j]) + ridge
        });
        let n_axes = columns.n_axes();
        let with_loads =
            Mat::from_fn(used.len(), n_axes, |i, axis| sums.target_product(used[i], axis));
        let fitted = solve(&products, &with_loads);
        let mut coefficients = Mat::zeros(columns.base().len(), n_axes);
        for (at, column) in used.iter().enumerate() {
            coefficients.row_mut(*column).copy_from(fitted.row(at));
        }
        let by_row: Vec<f64> =
            coefficients.row_iter().flat_map(|row| row.iter().copied()).collect();
        let squares = sums.squared_residuals(&by_row);
        let mean_squares = squares.iter().map(|own| own / n).collect();
        Ok(BaseFit { used, coefficients, mean_squares })
    }

    fn sums(&self, progress: &Progress) -> Result<NormalEquations, Cancelled> {
        let (n_base, n_axes) = (self.columns.base().len(), self.columns.n_axes());
        let of_run = |at: usize| {
            progress.check()?;
            let mut rows = self.rows(at);
            let mut sums = NormalEquations::new(n_base, n_axes);
            add_run(&mut sums, self.runs[at].n_samples, |sample, row| {
                rows.next_base(sample, &mut row[..n_base]);
                rows.loads(sample, &mut row[n_base..n_base + n_axes]);
            });
            Ok(sums)
        };
        let all: Result<Vec<NormalEquations>, Cancelled> =
            (0..self.runs.len()).into_par_iter().map(of_run).collect();
        let mut sums = NormalEquations::new(n_base, n_axes);
        all?.iter().for_each(|own| sums.add(own));
        Ok(sums)
    }

    /// Returns the noise of the residuals; `None` if there are too few samples.
    pub fn noise(
        &self,
        fit: &BaseFit,
        units: &[Unit],
        progress: &Progress,
    ) -> Result<Option<Noise>, Cancelled> {
        let of_run = |at: usize| -> Result<Vec<Differences>, Cancelled> {
            progress.check()?;
            let mut rows = self.rows(at);
            let own = units.iter().filter(|unit| unit.run == at);
            Ok(own.map(|unit| self.residual_differences(&mut rows, fit, unit)).collect())
        };
        let found: Result<Vec<_>, _> = (0..self.runs.len()).into_par_iter().map(of_run).collect();
        Ok(Noise::of(&found?.concat(), self.columns.n_axes()))
    }

    fn residual_differences(&self, rows: &mut Rows<'_>, fit: &BaseFit, unit: &Unit) -> Differences {
        let n_axes = self.columns.n_axes();
        let mut row = vec![0.0; self.columns.base().len()];
        let mut residuals = vec![0.0; unit.samples.len() * n_axes];
        for (sample, out) in unit.samples.clone().zip(residuals.chunks_exact_mut(n_axes)) {
            rows.next_base(sample, &mut row);
            rows.loads(sample, out);
            for (axis, out) in out.iter_mut().enumerate() {
                let own = fit.coefficients.col(axis).iter().zip(&row);
                *out -= own.map(|(coefficient, value)| coefficient * value).sum::<f64>();
            }
        }
        differences(&residuals, n_axes)
    }
}

/// Returns mean and standard deviation from sums. The deviation is 0 for a column that does not vary.
pub(super) fn moments(n: f64, sum: f64, square: f64) -> (f64, f64) {
    let mean = sum / n;
    let deviation = (square / n - mean * mean).max(0.0).sqrt();
    let varies = deviation > CONSTANT && deviation > CONSTANT_SHARE * mean.abs();
    (mean, if varies { deviation } else { 0.0 })
}
