//! Kernel regression: settings, fitted numbers, prediction.

use serde::{Deserialize, Serialize};

use crate::{
    calibration::{
        entries::{check_length, check_numbers},
        error::{CalibrationError, LARGEST},
    },
    dot::dot,
    features::{FeatureError, Range, Setting, Unit},
};

/// Setting for the number of landmarks. Beyond its maximum, computing the landmarks' kernel matrix would take longer than the
/// pass over the samples.
pub const LANDMARKS: Setting = Setting {
    key: "landmarks",
    option: "landmarks",
    label: "Landmarks",
    what: "the number of landmarks",
    unit: Unit::NONE,
    default: &[200.0],
    range: Range::Whole(1, 2000),
    step: 0.25,
    explanation: "Number of training samples (landmarks) with which a kernel compares every sample. More landmarks make fit and \
                  prediction slower and the file larger",
    source: "",
};

/// Setting for the length scale ℓ, divided by the root mean square distance of a sample from the mean sample.
const LENGTH_SCALE: Setting = Setting {
    key: "length_scale",
    option: "",
    label: "Length scale",
    what: "the kernel's length scale",
    range: Range::Positive,
    explanation: "Length scale in units of a sample's typical distance from the mean; if empty, it is chosen by cross-validation",
    ..LANDMARKS
};

/// Settings of a kernel fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct KernelSettings {
    /// Number of landmark samples.
    pub landmarks: usize,
    /// Length scale ℓ divided by the RMS distance of a sample from the mean sample; `None` to choose it by cross-validation.
    pub length_scale: Option<f64>,
}

impl Default for KernelSettings {
    fn default() -> Self {
        Self { landmarks: LANDMARKS.number() as usize, length_scale: None }
    }
}

/// End of the range of tried ridge strengths, at which the chosen strength of a kernel lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GridEdge {
    /// Weakest tried ridge strength that keeps the landmark weights below their limit.
    Weakest,
    /// Strongest tried ridge strength.
    Strongest,
}

impl KernelSettings {
    /// Checks every setting. The error describes the first invalid one.
    pub(crate) fn validate(&self) -> Result<(), FeatureError> {
        LANDMARKS.check(self.landmarks as f64)?;
        self.length_scale.map_or(Ok(()), |scale| LENGTH_SCALE.check(scale))
    }
}

/// Fitted kernel regression `load = offset + Σ weight · k(x, landmark)` with m landmarks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kernel {
    /// Mean of each input, which is subtracted from it.
    pub input_shift: Vec<f64>,
    /// Factor by which each input is multiplied after subtracting its mean; zero for a constant input.
    pub input_scale: Vec<f64>,
    /// Length scale ℓ, in the unit of the standardised inputs.
    pub length_scale: f64,
    /// Standardised landmarks: m rows of n_inputs.
    pub landmarks: Vec<Vec<f64>>,
    /// Weights of the kernel values: one row of m numbers per axis.
    pub weights: Vec<Vec<f64>>,
    /// Constant part of the load of each axis.
    pub offset: Vec<f64>,
    /// Noise variance and matrices from which the uncertainty band of the load is computed.
    pub band: Band,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Band {
    pub noise_variance: Vec<f64>,
    /// Ridge strength: ratio of the noise variance to the prior variance of the fitted function.
    pub strength: f64,
    /// Rows of the lower triangular matrix W, which whitens the kernel values: `φ = W k`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub whitening: Vec<Vec<f64>>,
    /// Rows of the lower triangular matrix P: `|P φ|²` is the variance of the fitted function divided by the noise variance.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub posterior: Vec<Vec<f64>>,
}

impl Kernel {
    /// Checks the shapes and numbers of a kernel from a file.
    pub fn validate(&self, n_columns: usize, n_axes: usize) -> Result<(), CalibrationError> {
        let m = self.landmarks.len();
        let place = |field: &str| format!("learned.kernel.{field}");
        let vector =
            |field: &str, n, numbers: &[f64]| check_numbers(&place(field), n, numbers, -LARGEST);
        let rows = |field: &str, n, rows: &[Vec<f64>], width: &dyn Fn(usize) -> usize| {
            check_length(&place(field), n, rows.len())?;
            let mut rows = rows.iter().enumerate();
            rows.try_for_each(|(at, row)| vector(field, width(at), row))
        };
        let triangle = |at| at + 1;
        vector("input_shift", n_columns, &self.input_shift)?;
        vector("input_scale", n_columns, &self.input_scale)?;
        rows("landmarks", m, &self.landmarks, &|_| n_columns)?;
        rows("weights", n_axes, &self.weights, &|_| m)?;
        vector("offset", n_axes, &self.offset)?;
        vector("noise_variance", n_axes, &self.band.noise_variance)?;
        if self.has_band() {
            rows("whitening", m, &self.band.whitening, &triangle)?;
            rows("posterior", m, &self.band.posterior, &triangle)?;
        }
        for scale in [self.length_scale, self.band.strength] {
            LENGTH_SCALE.check(scale)?;
        }
        Ok(())
    }

    /// Returns false if the file of the kernel does not contain the matrices of its uncertainty band.
    pub fn has_band(&self) -> bool {
        !(self.band.whitening.is_empty() && self.band.posterior.is_empty())
    }

    /// Removes the matrices of the uncertainty band, which are most of a file.
    pub fn remove_band(&mut self) {
        self.band.whitening.clear();
        self.band.posterior.clear();
    }

    /// Multiplies the predictions by one factor per axis. The uncertainty band does not change.
    pub(crate) fn scale(&mut self, shares: &[f64]) {
        let axes = self.weights.iter_mut().zip(&mut self.offset).zip(shares);
        for ((weights, offset), share) in axes {
            weights.iter_mut().for_each(|weight| *weight *= share);
            *offset *= share;
        }
    }

    /// Adds the predictions for rows of standardised features to `loads`, `n × n_axes` row-major.
    pub fn add(&self, rows: &[f64], scratch: &mut KernelScratch, loads: &mut [f64]) {
        for (row, load) in self.each_row(rows, loads) {
            self.similarities(row, scratch);
            for ((load, weights), offset) in load.iter_mut().zip(&self.weights).zip(&self.offset) {
                *load += offset + dot(weights, &scratch.similarities);
            }
        }
    }

    /// Writes the standard deviations of the loads around the predictions for rows, `n × n_axes` row-major.
    pub fn deviations(&self, rows: &[f64], scratch: &mut KernelScratch, out: &mut [f64]) {
        let Band { noise_variance, strength, whitening, posterior } = &self.band;
        for (row, out) in self.each_row(rows, out) {
            self.similarities(row, scratch);
            scratch.whitened.clear();
            let k = &scratch.similarities;
            scratch.whitened.extend(whitening.iter().map(|row| dot(row, k)));
            let phi = &scratch.whitened;
            let fitted: f64 = posterior.iter().map(|row| dot(row, phi).powi(2)).sum();
            let unseen = (1.0 - dot(phi, phi)).max(0.0) / strength;
            for (out, noise) in out.iter_mut().zip(noise_variance) {
                *out = (noise * (1.0 + fitted + unseen)).sqrt();
            }
        }
    }

    fn each_row<'a>(
        &self,
        rows: &'a [f64],
        out: &'a mut [f64],
    ) -> impl Iterator<Item = (&'a [f64], &'a mut [f64])> + use<'a> {
        let out = out.chunks_exact_mut(self.offset.len());
        rows.chunks_exact(self.input_shift.len()).zip(out)
    }

    fn similarities(&self, row: &[f64], scratch: &mut KernelScratch) {
        let KernelScratch { x, similarities, .. } = scratch;
        standardise(row, &self.input_shift, &self.input_scale, x);
        similarities.clear();
        similarities.extend(similarities_to(&self.landmarks, self.length_scale, x));
    }
}

#[derive(Clone, Debug, Default)]
pub struct KernelScratch {
    x: Vec<f64>,
    similarities: Vec<f64>,
    whitened: Vec<f64>,
}

pub(super) fn standardise(row: &[f64], shift: &[f64], scale: &[f64], out: &mut Vec<f64>) {
    out.clear();
    let columns = row.iter().zip(shift).zip(scale);
    out.extend(columns.map(|((value, shift), scale)| (value - shift) * scale));
}

/// Returns the kernel between a standardised row and each landmark.
pub(super) fn similarities_to(
    landmarks: &[Vec<f64>],
    length_scale: f64,
    x: &[f64],
) -> impl Iterator<Item = f64> {
    let factor = -0.5 / (length_scale * length_scale);
    let landmarks = landmarks.iter();
    landmarks.map(move |landmark| (factor * square_distance(landmark, x)).exp())
}

pub(super) fn square_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}
