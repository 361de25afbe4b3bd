//! Kernel regression: settings, fitted numbers, prediction.

use serde::{Deserialize, Serialize};

use crate::{
    calibration::{
        entries::{check_length, check_numbers},
        error::{CalibrationError, LARGEST},
    },
    dot::dot_of_long,
    features::{FeatureError, Range, Setting, Unit},
    vectorised::vectorised,
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
    /// Standardised landmarks.
    pub landmarks: Landmarks,
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
        rows("landmarks", n_columns, &self.landmarks.by_input, &|_| m)?;
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
                *load += offset + dot_of_long(weights, &scratch.similarities);
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
            scratch.whitened.extend(whitening.iter().map(|row| dot_of_long(row, &k[..row.len()])));
            let phi = &scratch.whitened;
            let fitted = posterior.iter().map(|row| dot_of_long(row, &phi[..row.len()]).powi(2));
            let fitted: f64 = fitted.sum();
            let unseen = (1.0 - dot_of_long(phi, phi)).max(0.0) / strength;
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
        similarities.resize(self.landmarks.len(), 0.0);
        self.landmarks.similarities(self.length_scale, x, similarities);
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

/// Landmarks of a kernel. They are stored input by input, so that a sample is compared with several landmarks at once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<Vec<f64>>", into = "Vec<Vec<f64>>")]
pub struct Landmarks {
    n: usize,
    /// One row of m numbers for each input.
    by_input: Vec<Vec<f64>>,
}

impl From<Vec<Vec<f64>>> for Landmarks {
    /// Takes one row for each landmark. If a row of a file is too short, its missing numbers become NaN, which
    /// [`Kernel::validate`] refuses.
    fn from(rows: Vec<Vec<f64>>) -> Self {
        let n_inputs = rows.iter().map(Vec::len).max().unwrap_or(0);
        let of_input =
            |input| rows.iter().map(move |row| row.get(input).copied().unwrap_or(f64::NAN));
        Self {
            n: rows.len(),
            by_input: (0..n_inputs).map(|input| of_input(input).collect()).collect(),
        }
    }
}

impl From<Landmarks> for Vec<Vec<f64>> {
    fn from(landmarks: Landmarks) -> Self {
        let row = |at| landmarks.by_input.iter().map(|column| column[at]).collect();
        (0..landmarks.n).map(row).collect()
    }
}

impl Landmarks {
    pub fn len(&self) -> usize {
        self.n
    }

    /// Writes the squared distance of a standardised row from each landmark.
    pub(super) fn square_distances(&self, x: &[f64], out: &mut [f64]) {
        vectorised(
            #[inline(always)]
            || {
                out.fill(0.0);
                for (x, landmarks) in x.iter().zip(&self.by_input) {
                    for (square, landmark) in out.iter_mut().zip(landmarks) {
                        *square += (landmark - x) * (landmark - x);
                    }
                }
            },
        );
    }

    /// Writes the kernel between a standardised row and each landmark.
    pub(super) fn similarities(&self, length_scale: f64, x: &[f64], out: &mut [f64]) {
        let factor = -0.5 / (length_scale * length_scale);
        self.square_distances(x, out);
        vectorised(
            #[inline(always)]
            || out.iter_mut().for_each(|square| *square = exp_of_negative(factor * *square)),
        );
    }
}

/// Returns eˣ for −708 ≤ x ≤ 0, to a few units in the last place, and e⁻⁷⁰⁸ for smaller numbers. Unlike [`f64::exp`], it can be
/// computed for several numbers at once. With x = n ln 2 + r, the result is 2ⁿ times the Taylor polynomial of eʳ.
#[inline(always)]
fn exp_of_negative(x: f64) -> f64 {
    /// 1 / k! of each power k.
    const TAYLOR: [f64; 14] = {
        let (mut coefficients, mut k) = ([1.0; 14], 1);
        while k < coefficients.len() {
            coefficients[k] = coefficients[k - 1] / k as f64;
            k += 1;
        }
        coefficients
    };
    /// After adding this number, the last bits of the sum are the nearest integer.
    const ROUND: f64 = 1.5 * (1_u64 << 52) as f64;
    /// First digits of ln 2. Their product with n is exact.
    const LN_2_HIGH: f64 = f64::from_bits(0x3FE6_2E42_FEE0_0000);
    const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    const EXPONENT_BIAS: u64 = 1023;
    let x = x.max(-708.0);
    let rounded = x * std::f64::consts::LOG2_E + ROUND;
    let n = rounded - ROUND;
    let r = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    let series = TAYLOR.iter().rev().fold(0.0, |sum, coefficient| sum * r + coefficient);
    series * f64::from_bits((rounded.to_bits().wrapping_add(EXPONENT_BIAS)) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_function_is_exact_to_a_few_last_digits() {
        for k in 0..700_000 {
            let x = -1e-3 * f64::from(k);
            let relative = exp_of_negative(x) / x.exp() - 1.0;
            assert!(relative.abs() < 5e-16, "{x}: {relative:e}");
        }
        assert_eq!(exp_of_negative(0.0), 1.0);
        assert!(exp_of_negative(-1e6) < 1e-300);
    }

    #[test]
    fn landmarks_of_a_file_with_a_short_row_are_refused() {
        let landmarks: Landmarks = serde_json::from_str("[[1.0, 2.0], [3.0]]").unwrap();
        assert!(landmarks.by_input[1][1].is_nan());
        let rows = vec![vec![1.0, 2.0], vec![3.0, 4.0], vec![5.0, 6.0]];
        assert_eq!(Vec::from(Landmarks::from(rows.clone())), rows);
    }
}
