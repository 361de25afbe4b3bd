//! Root mean squared errors (RMSE) per axis and per group of axes.

use crate::{calibration::NormalEquations, recording::Axis};

/// Returns the RMSE per axis of a linear fit on the samples in the normal equations `sums`; `None` without samples. This is
/// the error that Eq. 8 of Koike et al. (2019) minimises.
pub fn rmse(sums: &NormalEquations, coefficients: &[f64]) -> Option<Vec<f64>> {
    root_mean(&sums.squared_residuals(coefficients), sums.n_samples())
}

/// Returns the root mean square of each column from its sum of squares over `n` samples; `None` if `n` is zero.
pub fn root_mean(squares: &[f64], n: u64) -> Option<Vec<f64>> {
    (n > 0).then(|| squares.iter().map(|square| (square / n as f64).sqrt()).collect())
}

/// Returns the RMSE per axis of predicted loads against the reference loads `truth`. Both are `n × n_axes`, row-major.
pub fn rmse_of_loads(predicted: &[f64], truth: &[f64], n_axes: usize) -> Option<Vec<f64>> {
    let mut squares = vec![0.0; n_axes];
    for (predicted, truth) in predicted.chunks_exact(n_axes).zip(truth.chunks_exact(n_axes)) {
        for axis in 0..n_axes {
            squares[axis] += (predicted[axis] - truth[axis]).powi(2);
        }
    }
    root_mean(&squares, (truth.len() / n_axes.max(1)) as u64)
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Group {
    /// Force axes Fx Fy Fz (N).
    Force,
    /// Moment axes Mx My Mz (N·m).
    Moment,
}

impl Group {
    pub fn contains(self, axis: Axis) -> bool {
        axis.is_force() == (self == Self::Force)
    }

    /// Returns the root mean square of the RMSE of all force axes or all moment axes; `None` if there is no such axis.
    pub fn rmse(self, axes: &[Axis], rmse: &[f64]) -> Option<f64> {
        let chosen = axes.iter().zip(rmse).filter(|(axis, _)| self.contains(**axis));
        let squares: Vec<f64> = chosen.map(|(_, value)| value * value).collect();
        let n = squares.len();
        (n > 0).then(|| (squares.iter().sum::<f64>() / n as f64).sqrt())
    }
}

/// Returns the change from `from` to `to` in percent of `from`; `None` if `from` is zero.
pub fn percent_change(from: f64, to: f64) -> Option<f64> {
    (from > 0.0).then(|| 100.0 * (to / from - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors (3, 0) and (4, 1): √((9 + 16) / 2) and √(1 / 2).
    #[test]
    fn rmse_of_known_errors() {
        let rmse = rmse_of_loads(&[3.0, 0.0, 4.0, 1.0], &[0.0; 4], 2).unwrap();
        assert!((rmse[0] - 12.5_f64.sqrt()).abs() < 1e-15);
        assert!((rmse[1] - 0.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(rmse_of_loads(&[], &[], 2), None);
    }

    #[test]
    fn a_group_averages_the_squares_of_its_own_axes() {
        let axes = [Axis::Fx, Axis::Fz, Axis::Mx];
        assert_eq!(Group::Force.rmse(&axes, &[1.0, 7.0, 9.0]), Some(5.0));
        assert_eq!(Group::Moment.rmse(&axes, &[1.0, 7.0, 9.0]), Some(9.0));
        assert_eq!(Group::Moment.rmse(&axes[..2], &[1.0, 7.0]), None);
    }
}
