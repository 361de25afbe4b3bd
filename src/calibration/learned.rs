//! What a network or a kernel has learned: the load itself, or what the linear calibration leaves over (hybrid).

use serde::{Deserialize, Serialize};

use crate::calibration::kernel::{Kernel, KernelError, KernelScratch};
use crate::calibration::network::{Network, NetworkError};
use crate::calibration::settings::Learner;

/// A regression that is not linear, on standardised features (without the offset).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Learned {
    /// Layers of units.
    Network(Network),
    /// Similarity to landmarks.
    Kernel(Kernel),
}

/// What makes a learned regression unusable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LearnedError {
    /// The network's.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The kernel's.
    #[error(transparent)]
    Kernel(#[from] KernelError),
}

/// Room for the steps between a row and its answer.
#[derive(Clone, Debug, Default)]
pub struct LearnedScratch {
    kernel: KernelScratch,
    answers: Vec<f64>,
}

impl Learned {
    /// What learned it.
    pub fn learner(&self) -> Learner {
        match self {
            Self::Network(_) => Learner::Network,
            Self::Kernel(_) => Learner::Kernel,
        }
    }

    /// What it is made of, in words.
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

    /// How many numbers it consists of.
    pub fn n_numbers(&self) -> usize {
        match self {
            Self::Network(network) => network.n_parameters(),
            Self::Kernel(kernel) => {
                let of_landmark = kernel.landmarks.iter().chain(&kernel.weights);
                of_landmark.map(Vec::len).sum()
            }
        }
    }

    /// Checks what a file could have wrong.
    ///
    /// # Errors
    /// [`LearnedError`] with the first thing found.
    pub fn validate(&self, n_columns: usize, n_axes: usize) -> Result<(), LearnedError> {
        match self {
            Self::Network(network) => Ok(network.validate(n_columns, n_axes)?),
            Self::Kernel(kernel) => Ok(kernel.validate(n_columns, n_axes)?),
        }
    }

    /// Adds the answers for whole rows to `loads`, `n × n_axes` row-major.
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

    /// Multiplies the answers with these shares, one per axis; without any it stays what it is.
    pub fn scale(&mut self, shares: &[f64]) {
        match self {
            Self::Kernel(kernel) => kernel.scale(shares),
            Self::Network(network) => network.scale(shares),
        }
    }

    /// Whether the answer on an axis is zero whatever the row: after a linear stage it stands alone there.
    pub fn is_silent(&self, axis: usize) -> bool {
        let is_zero = |values: &[f64]| values.iter().all(|value| *value == 0.0);
        match self {
            Self::Kernel(kernel) => is_zero(&kernel.weights[axis]) && kernel.offset[axis] == 0.0,
            Self::Network(network) => {
                is_zero(&[network.target_shift[axis], network.target_scale[axis]])
            }
        }
    }

    /// Whether [`Learned::deviations`] has an answer.
    pub fn knows_deviation(&self) -> bool {
        matches!(self, Self::Kernel(_))
    }

    /// Writes the standard deviations of the loads around the answers for whole rows, `n × n_axes` row-major; zero where
    /// the regression does not know.
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
