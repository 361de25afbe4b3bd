use serde::{Deserialize, Serialize};

use crate::calibration::{
    error::CalibrationError,
    kernel::{Kernel, KernelScratch},
    network::Network,
};

/// Nonlinear part of a calibration. From standardised features, it predicts the load, or the residual of a linear fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Learned {
    Network(Network),
    Kernel(Kernel),
}

#[derive(Clone, Debug, Default)]
pub struct LearnedScratch {
    pub(super) kernel: KernelScratch,
    answers: Vec<f64>,
}

impl Learned {
    pub fn describe(&self) -> String {
        match self {
            Self::Kernel(kernel) => format!(
                "kernel on {} landmarks, length scale {:.3}, ridge {:e}",
                kernel.landmarks.len(),
                kernel.length_scale,
                kernel.band.strength
            ),
            Self::Network(network) => {
                let mut widths = network.n_inputs().to_string();
                for layer in &network.layers {
                    widths += &format!(" → {}", layer.biases.len());
                }
                format!("network of {widths} units, {} weights and biases", network.n_parameters())
            }
        }
    }

    pub fn n_numbers(&self) -> usize {
        match self {
            Self::Network(network) => network.n_parameters(),
            Self::Kernel(kernel) => {
                kernel.landmarks.len() * (kernel.input_shift.len() + kernel.weights.len())
            }
        }
    }

    /// Checks the shapes and numbers of a network or kernel from a file.
    pub fn validate(&self, n_columns: usize, n_axes: usize) -> Result<(), CalibrationError> {
        match self {
            Self::Network(network) => network.validate(n_columns, n_axes),
            Self::Kernel(kernel) => kernel.validate(n_columns, n_axes),
        }
    }

    /// Adds the predictions for rows of standardised features to `loads`, `n × n_axes` row-major.
    pub fn add(&self, rows: &[f64], scratch: &mut LearnedScratch, loads: &mut [f64]) {
        match self {
            Self::Kernel(kernel) => kernel.add(rows, &mut scratch.kernel, loads),
            Self::Network(network) => {
                scratch.answers.resize(loads.len(), 0.0);
                network.predict_rows(rows, &mut scratch.answers);
                for (load, answer) in loads.iter_mut().zip(&scratch.answers) {
                    *load += answer;
                }
            }
        }
    }

    /// Multiplies the predictions of the network or kernel by one factor per axis.
    pub fn scale(&mut self, shares: &[f64]) {
        match self {
            Self::Kernel(kernel) => kernel.scale(shares),
            Self::Network(network) => network.scale(shares),
        }
    }

    /// Returns true if the prediction of the network or kernel on an axis is always zero.
    pub fn is_silent(&self, axis: usize) -> bool {
        match self {
            Self::Kernel(kernel) => {
                kernel.offset[axis] == 0.0
                    && kernel.weights[axis].iter().all(|weight| *weight == 0.0)
            }
            Self::Network(network) => {
                network.target_shift[axis] == 0.0 && network.target_scale[axis] == 0.0
            }
        }
    }
}
