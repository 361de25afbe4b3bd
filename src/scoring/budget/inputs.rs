//! Standardised gauges, conventional loads and expected gauges, which the columns of the causes are made of.

use std::ops::Range;

use faer::{Mat, Side};

use crate::{
    calibration::NormalEquations,
    scoring::{
        budget::run::{Run, add_run},
        inverse::inverse_above,
    },
};

/// Maximum number of gauges of which each has columns of its own. With more gauges, the strongest principal components take
/// their place.
pub const MOST_GAUGES: usize = 8;
/// Maximum number of gauges with columns of hysteresis.
const MOST_EXPECTED: usize = 16;
/// Correlation of two gauges' predictions from which one of them is enough.
const ALIKE: f64 = 0.999;
/// Standard deviation below which a channel counts as constant, as a share of its mean.
const CONSTANT: f64 = 1e-9;
/// Standard deviation of a conventional load below which its axis has no columns, as a share of the largest one.
const UNMOVED: f64 = 1e-6;
/// Share of the largest eigenvalue, below which a direction counts as undetermined.
const UNDETERMINED: f64 = 1e-13;

/// Mean and standard deviation of the channels that vary.
#[derive(Debug, Default)]
pub struct Channels {
    /// Numbers of the channels that vary.
    kept: Vec<usize>,
    mean: Vec<f64>,
    deviation: Vec<f64>,
}

impl Channels {
    fn of<'a>(runs: &'a [Run<'a>], values: impl Fn(&'a Run<'a>) -> (&'a [f64], usize)) -> Self {
        let n_channels = runs.first().map_or(0, |run| values(run).1);
        let mut channels = Self::default();
        for channel in 0..n_channels {
            let all =
                || runs.iter().flat_map(|run| values(run).0[channel..].iter().step_by(n_channels));
            let n = all().count() as f64;
            let mean = all().sum::<f64>() / n;
            let deviation = (all().map(|value| (value - mean).powi(2)).sum::<f64>() / n).sqrt();
            if deviation > CONSTANT * (mean.abs() + 1e-30) {
                channels.kept.push(channel);
                channels.mean.push(mean);
                channels.deviation.push(deviation);
            }
        }
        channels
    }

    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Writes the channels of one sample minus their means, divided by their standard deviations.
    pub fn standardise(&self, sample: &[f64], out: &mut [f64]) {
        for (at, out) in out.iter_mut().enumerate() {
            *out = (sample[self.kept[at]] - self.mean[at]) / self.deviation[at];
        }
    }
}

/// Linear maps from the gauges to the inputs of the columns.
#[derive(Debug)]
pub struct Inputs {
    pub gauges: Channels,
    pub auxiliary: Channels,
    pub load_means: Vec<f64>,
    /// True for each axis whose conventional load moves.
    pub moves: Vec<bool>,
    /// Coefficients from the standardised gauges to the loads minus their means, `n_gauges × n_axes`.
    pub conventional: Mat<f64>,
    /// Coefficients of the conventional loads of the axes that move, which have the standard deviation 1.
    pub loads: Mat<f64>,
    /// Coefficients from these loads to the gauges that they predict, which have the standard deviation 1; to the least alike
    /// of them if there are many gauges.
    pub expected: Mat<f64>,
    /// Coefficients of the principal components, which have the standard deviation 1; `None` if there are few gauges.
    pub components: Option<Mat<f64>>,
    /// Coefficients from the loads minus their means to the standardised gauges, `n_axes × n_gauges`.
    pub gauges_from_loads: Mat<f64>,
}

impl Inputs {
    /// Computes means, standard deviations and covariances of the channels, and the linear maps from them. Returns `None` if
    /// no gauge varies, or if no conventional load varies.
    pub fn of(runs: &[Run<'_>], n_axes: usize) -> Option<Self> {
        let width = |values: &[f64], run: &Run<'_>| values.len() / run.n_samples;
        let gauges = Channels::of(runs, |run| (run.gauges, width(run.gauges, run)));
        let auxiliary = Channels::of(runs, |run| (run.auxiliary, width(run.auxiliary, run)));
        let n: usize = runs.iter().map(|run| run.n_samples).sum();
        let load_means: Vec<f64> = (0..n_axes)
            .map(|axis| {
                let values = runs.iter().flat_map(|run| run.loads[axis..].iter().step_by(n_axes));
                values.sum::<f64>() / n as f64
            })
            .collect();
        let covariance = covariance(runs, &gauges, &load_means);
        let g = gauges.len();
        let among_gauges = covariance.submatrix(0, 0, g, g).to_owned();
        let with_loads = covariance.submatrix(0, g, g, n_axes).to_owned();
        let among_loads = covariance.submatrix(g, g, n_axes, n_axes).to_owned();
        let conventional = pseudo_inverse(&among_gauges)? * &with_loads;
        let deviations = deviations(&(conventional.transpose() * &among_gauges * &conventional));
        let largest = deviations.iter().copied().fold(0.0, f64::max);
        let moves: Vec<bool> = deviations.iter().map(|own| *own > UNMOVED * largest).collect();
        let moving: Vec<usize> = (0..n_axes).filter(|axis| moves[*axis]).collect();
        if moving.is_empty() {
            return None;
        }
        let loads = Mat::from_fn(g, moving.len(), |gauge, at| {
            conventional[(gauge, moving[at])] / deviations[moving[at]]
        });
        let of_loads = loads.transpose() * &among_gauges * &loads;
        let components = (g > MOST_GAUGES).then(|| components(&among_gauges)).flatten();
        let predicted = pseudo_inverse(&of_loads)? * loads.transpose() * &among_gauges;
        let deviations = self::deviations(&(predicted.transpose() * &of_loads * &predicted));
        let expected = Mat::from_fn(moving.len(), g, |load, gauge| {
            predicted[(load, gauge)] / (deviations[gauge] + 1e-12)
        });
        let expected = if components.is_some() { unlike(&expected, &of_loads) } else { expected };
        let gauges_from_loads = pseudo_inverse(&among_loads)? * with_loads.transpose();
        Some(Self {
            gauges,
            auxiliary,
            load_means,
            moves,
            conventional,
            loads,
            expected,
            components,
            gauges_from_loads,
        })
    }

    /// Returns the residuals of the conventional calibration in some samples, `n_samples × n_axes` row-major.
    pub fn residuals(&self, run: &Run<'_>, samples: Range<usize>) -> Vec<f64> {
        let n_axes = self.load_means.len();
        let width = run.gauges.len() / run.n_samples;
        let mut gauges = vec![0.0; self.gauges.len()];
        let mut residuals = run.loads[samples.start * n_axes..samples.end * n_axes].to_vec();
        let all = run.gauges[samples.start * width..].chunks_exact(width);
        for (sample, out) in all.zip(residuals.chunks_exact_mut(n_axes)) {
            self.gauges.standardise(sample, &mut gauges);
            for (axis, (out, mean)) in out.iter_mut().zip(&self.load_means).enumerate() {
                let own = self.conventional.col(axis).iter().zip(&gauges);
                *out -= mean + own.map(|(own, gauge)| own * gauge).sum::<f64>();
            }
        }
        residuals
    }

    /// Returns the number of inputs of curvature: gauges or principal components.
    pub fn n_curved(&self) -> usize {
        self.components.as_ref().map_or(self.gauges.len(), Mat::ncols)
    }
}

/// Returns the covariance matrix of the standardised gauges and the loads.
fn covariance(runs: &[Run<'_>], gauges: &Channels, load_means: &[f64]) -> Mat<f64> {
    let (g, n_axes) = (gauges.len(), load_means.len());
    let mut sums = NormalEquations::new(g + n_axes, 0);
    for run in runs {
        let width = run.gauges.len() / run.n_samples;
        add_run(&mut sums, run.n_samples, |k, row| {
            gauges.standardise(&run.gauges[k * width..][..width], &mut row[..g]);
            let loads = run.loads[k * n_axes..][..n_axes].iter().zip(load_means);
            for (out, (load, mean)) in row[g..].iter_mut().zip(loads) {
                *out = load - mean;
            }
        });
    }
    let n = sums.n_samples() as f64;
    Mat::from_fn(g + n_axes, g + n_axes, |i, j| sums.feature_product(i, j) / n)
}

/// Returns the columns of gauges whose predictions are least alike. `of_loads` is the covariance matrix of the loads.
fn unlike(expected: &Mat<f64>, of_loads: &Mat<f64>) -> Mat<f64> {
    let correlations = expected.transpose() * of_loads * expected;
    let mut taken = vec![0];
    while taken.len() < MOST_EXPECTED {
        let likeness = |gauge: &usize| {
            let with = taken.iter().map(|other| correlations[(*gauge, *other)].abs());
            with.fold(0.0, f64::max)
        };
        let all = 0..expected.ncols();
        let next = all.min_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        let Some(next) = next.filter(|own| likeness(own) < ALIKE) else { break };
        taken.push(next);
    }
    Mat::from_fn(expected.nrows(), taken.len(), |load, at| expected[(load, taken[at])])
}

fn deviations(covariance: &Mat<f64>) -> Vec<f64> {
    (0..covariance.nrows()).map(|at| covariance[(at, at)].max(0.0).sqrt()).collect()
}

/// Returns the pseudo-inverse of a symmetric, positive semi-definite matrix.
pub fn pseudo_inverse(of: &Mat<f64>) -> Option<Mat<f64>> {
    inverse_above(of, UNDETERMINED)
}

/// Returns the strongest principal components, scaled to the standard deviation 1.
fn components(covariance: &Mat<f64>) -> Option<Mat<f64>> {
    let eigen = covariance.self_adjoint_eigen(Side::Lower).ok()?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    let n = covariance.nrows();
    Some(Mat::from_fn(n, MOST_GAUGES, |i, at| {
        let j = n - 1 - at;
        if values[j] > UNDETERMINED { vectors[(i, j)] / values[j].sqrt() } else { 0.0 }
    }))
}
