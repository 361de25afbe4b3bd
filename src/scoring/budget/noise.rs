//! White noise of the calibration's residuals, from differences between neighbouring samples.
//!
//! A load that changes smoothly leaves little in differences of a high order, noise as much as in the samples. The noise is
//! the smallest of the figures of order 1 to 4, each the median over short chunks.

use rayon::prelude::*;

use crate::{
    progress::{Cancelled, Progress},
    scoring::budget::{
        inputs::Inputs,
        run::{Run, Unit},
        time_scale::middle,
    },
};

/// Number of differences in a chunk.
pub const CHUNK: usize = 25;
const ORDERS: usize = 4;
/// Minimum number of chunks. With fewer, the noise is unknown.
const FEWEST_CHUNKS: usize = 4;

/// Mean squared differences of the residuals of one unit, for each order, chunk and axis, scaled to the variance of white noise.
type Differences = [Vec<Vec<f64>>; ORDERS];

/// Noise of the residuals, and the chunks in which it was measured.
#[derive(Debug)]
pub struct Noise {
    /// Variance of the noise on each axis.
    pub variances: Vec<f64>,
    /// Order of the differences.
    pub order: usize,
    /// For each unit, the numbers of the chunks that are not above the median.
    pub quiet: Vec<Vec<usize>>,
}

/// Returns the mean squared differences of residuals, `n_samples × n_axes` row-major.
fn differences(residuals: &[f64], n_axes: usize) -> Differences {
    let mut changes = residuals.to_vec();
    let mut length = residuals.len();
    let mut scale = 1.0;
    [1, 2, 3, 4].map(|order| {
        length = length.saturating_sub(n_axes);
        for at in 0..length {
            changes[at] = changes[at + n_axes] - changes[at];
        }
        scale *= 2.0 * (2.0 * f64::from(order) - 1.0) / f64::from(order);
        let chunks = changes[..length].chunks_exact(CHUNK * n_axes);
        let mean = |chunk: &[f64], axis: usize| {
            let squares = chunk.iter().skip(axis).step_by(n_axes).map(|own| own * own);
            squares.sum::<f64>() / (CHUNK as f64 * scale)
        };
        chunks.map(|chunk| (0..n_axes).map(|axis| mean(chunk, axis)).collect()).collect()
    })
}

impl Noise {
    /// Measures the noise of the conventional calibration; `None` if there are too few samples.
    pub fn measure(
        runs: &[Run<'_>],
        inputs: &Inputs,
        units: &[Unit],
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let n_axes = inputs.load_means.len();
        let of_unit = |unit: &Unit| {
            progress.check()?;
            let residuals = inputs.residuals(&runs[unit.run], unit.samples.clone());
            Ok(differences(&residuals, n_axes))
        };
        let found: Result<Vec<_>, Cancelled> = units.par_iter().map(of_unit).collect();
        Ok(Self::of(&found?, n_axes))
    }

    fn of(units: &[Differences], n_axes: usize) -> Option<Self> {
        let mut best: Option<(usize, Vec<f64>)> = None;
        for order in 0..ORDERS {
            let chunks: Vec<&Vec<f64>> = units.iter().flat_map(|own| &own[order]).collect();
            if chunks.len() < FEWEST_CHUNKS {
                return None;
            }
            let of_axis = |axis: usize| middle(chunks.iter().map(|own| own[axis]).collect());
            let variances: Vec<f64> = (0..n_axes).filter_map(of_axis).collect();
            let is_less = best.as_ref().is_none_or(|(_, best)| relative(&variances, best) < 1.0);
            if is_less {
                best = Some((order, variances));
            }
        }
        let (order, variances) = best?;
        let of_unit = |own: &Differences| -> Vec<f64> {
            own[order].iter().map(|chunk| relative(chunk, &variances)).collect()
        };
        let sizes: Vec<Vec<f64>> = units.iter().map(of_unit).collect();
        let limit = middle(sizes.iter().flatten().copied().collect())?;
        let quiet = |unit: &Vec<f64>| -> Vec<usize> {
            (0..unit.len()).filter(|chunk| unit[*chunk] <= limit).collect()
        };
        Some(Self { quiet: sizes.iter().map(quiet).collect(), order: order + 1, variances })
    }
}

fn relative(variances: &[f64], to: &[f64]) -> f64 {
    let shares = variances.iter().zip(to).map(|(own, of)| own / of.max(1e-300));
    shares.sum::<f64>() / variances.len() as f64
}
