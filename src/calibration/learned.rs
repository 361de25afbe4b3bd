use serde::{Deserialize, Serialize};

use crate::calibration::kernel::{Kernel, KernelError, KernelScratch};
use crate::calibration::network::{Network, NetworkError};
use crate::calibration::settings::Learner;

/// Nonlinear part of a calibration: learns the load from standardised features, or the residuals of the linear part (hybrid).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Learned {
    Network(Network),
    Kernel(Kernel),
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LearnedError {
    #[error(transparent)]
    Network(#[from] NetworkError),
    #[error(transparent)]
    Kernel(#[from] KernelError),
}

#[derive(Clone, Debug, Default)]
pub struct LearnedScratch {
    kernel: KernelScratch,
    answers: Vec<f64>,
}

impl Learned {
    pub fn learner(&self) -> Learner {
        match self {
            Self::Network(_) => Learner::Network,
            Self::Kernel(_) => Learner::Kernel,
        }
    }

    pub fn describe(&self) -> String {
        match self {
            Self::Kernel(kernel) => format!(
                "kernel on {} landmarks, length scale {:.3}, ridge {:e}",
                kernel.landmarks.len(),
                kernel.length_scale,
                kernel.band.strength
            ),
            Self::Network(network) => {
                let mut widths = vec![network.n_inputs().to_string()];
                widths.extend(network.layers.iter().map(|layer| layer.biases.len().to_string()));
                format!(
                    "network of {} units, {} numbers",
                    widths.join(" → "),
                    network.n_parameters()
                )
            }
        }
    }

    pub fn n_numbers(&self) -> usize {
        match self {
            Self::Network(network) => network.n_parameters(),
            Self::Kernel(kernel) => {
                let of_landmark = kernel.landmarks.iter().chain(&kernel.weights);
                of_landmark.map(Vec::len).sum()
            }
        }
    }

    /// Checks everything that a file may contain.
    pub fn validate(&self, n_columns: usize, n_axes: usize) -> Result<(), LearnedError> {
        match self {
            Self::Network(network) => Ok(network.validate(n_columns, n_axes)?),
            Self::Kernel(kernel) => Ok(kernel.validate(n_columns, n_axes)?),
        }
    }

    /// Adds the predictions for rows to `loads`, `n × n_axes` row-major.
    pub fn add(
        &self,
        rows: &[f64],
        scratch: &mut LearnedScratch,
        loads: &mut [f64],
        n_axes: usize,
    ) {
        match self {
            Self::Kernel(kernel) => {
                let width = kernel.input_shift.len();
                for (row, load) in rows.chunks_exact(width).zip(loads.chunks_exact_mut(n_axes)) {
                    kernel.add(row, &mut scratch.kernel, load);
                }
            }
            Self::Network(network) => {
                scratch.answers.resize(loads.len(), 0.0);
                network.predict_rows(rows, &mut scratch.answers);
                for (load, answer) in loads.iter_mut().zip(&scratch.answers) {
                    *load += answer;
                }
            }
        }
    }

    /// Multiplies the predictions by a factor per axis. Without factors nothing changes.
    pub fn scale(&mut self, shares: &[f64]) {
        match self {
            Self::Kernel(kernel) => kernel.scale(shares),
            Self::Network(network) => network.scale(shares),
        }
    }

    /// Returns true if the prediction on an axis is always zero, so that the linear stage stands alone.
    pub fn is_silent(&self, axis: usize) -> bool {
        let is_zero = |values: &[f64]| values.iter().all(|value| *value == 0.0);
        match self {
            Self::Kernel(kernel) => is_zero(&kernel.weights[axis]) && kernel.offset[axis] == 0.0,
            Self::Network(network) => {
                is_zero(&[network.target_shift[axis], network.target_scale[axis]])
            }
        }
    }

    /// Returns true if [`Learned::deviations`] gives values.
    pub fn knows_deviation(&self) -> bool {
        matches!(self, Self::Kernel(_))
    }

    /// Writes the standard deviations around the predictions, `n × n_axes` row-major; zeros if the regression has none.
    pub fn deviations(
        &self,
        rows: &[f64],
        scratch: &mut LearnedScratch,
        out: &mut [f64],
        n_axes: usize,
    ) {
        match self {
            Self::Kernel(kernel) => {
                let width = kernel.input_shift.len();
                for (row, out) in rows.chunks_exact(width).zip(out.chunks_exact_mut(n_axes)) {
                    kernel.deviation(row, &mut scratch.kernel, out);
                }
            }
            Self::Network(_) => out.fill(0.0),
        }
    }
}
