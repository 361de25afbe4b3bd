//! Zero and sensitivity of each gauge in each recording, and the single fault that best explains why recordings disagree.
//!
//! The model of a gauge is `gauge = zero + sensitivity · (A · load)`. The matrix A is fitted to the other recordings. One
//! pass over the samples gives sums of products over contiguous parts of each recording, called units. Each possible fault is
//! then corrected in these sums, and the model is fitted again.

mod cause;
mod chance;
mod clipped;
mod columns;
mod disagrees;
mod fits;
mod mountings;
mod report;
mod returns;
mod steps;

use faer::Mat;
use serde::Serialize;

pub use crate::scoring::rig::cause::{Cause, Contradiction, Where, matters};
pub use crate::scoring::rig::report::{RigReport, Suspicion};
pub(crate) use crate::scoring::rig::report::{lag, lag_of_fit, same_samples};
use crate::{
    calibration::NormalEquations,
    min_max::MinMax,
    recording::{Axis, Recording},
    scoring::{
        faults::are_of_one_table,
        load_spread::hold_one_load,
        rig::fits::{Fit, Moments, Shape},
    },
};

/// Minimum number of units (contiguous parts of recordings) in all recordings together. The scatter between units shows which
/// differences arise by chance.
const UNITS: usize = 12;
/// Maximum number of runs. A run is one recording; with more recordings than this, consecutive recordings are combined into
/// one run.
const RUNS: usize = 24;
/// Number of samples that are collected before their products are added to the sums of a unit. Large blocks are faster.
const BLOCK: usize = 128;

/// Sums of products of `[1, time, gauges, loads]` over one contiguous interval of samples.
#[derive(Clone, Debug)]
struct Unit {
    run: usize,
    sums: Mat<f64>,
}

/// Sums of products over the recordings of one sensor, in order of time. Faults of the measuring rig are found from them.
#[derive(Debug)]
pub struct Rig {
    units: Vec<Unit>,
    shape: Shape,
    /// For each run, the indices of its recordings in the list given to [`Rig::of`].
    runs: Vec<Vec<usize>>,
    /// True if each recording holds one load, so that a change of the gauges is not told from the load that it belongs to.
    hold_one_load: bool,
    /// Mean and scale (standard deviation) of each gauge. The sums contain gauges minus this mean, divided by this scale.
    scales: Vec<(f64, f64)>,
    /// Largest minus smallest value of each gauge, divided by the gauge's scale.
    spans: Vec<f64>,
}

/// Zero and sensitivity of the gauges in one recording, or in consecutive recordings combined.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// Indices of the run's recordings in the list given to [`Rig::of`].
    pub recordings: Vec<usize>,
    /// Difference between each gauge's zero in this run and in the fit to the other runs, as a share of the gauge's range,
    /// with its standard error.
    pub zeros: Vec<Option<(f64, f64)>>,
    /// Ratio of each gauge's sensitivity in this run to that in the fit to the other runs, with its standard error.
    pub sensitivities: Vec<Option<(f64, f64)>>,
    /// Held-out error of this run's loads over all axes, as a share of full scale.
    pub error: f64,
}

impl Rig {
    /// Creates the sums of products over recordings that have the same gauges and axes. Returns `None` if no load moves, or
    /// if there are no gauges.
    pub fn of(recordings: &[&Recording], full_scale: &[f64]) -> Option<Self> {
        let first = recordings.first()?;
        let n_gauges = first.n_gauges();
        let axes: Vec<usize> =
            (0..first.axes().len()).filter(|axis| full_scale[*axis] > 0.0).collect();
        if axes.is_empty() || n_gauges == 0 {
            return None;
        }
        let (scales, spans) = scales(recordings, n_gauges);
        let shape = Shape {
            n_gauges,
            axes: axes.iter().map(|axis| first.axes()[*axis]).collect(),
            full_scale: axes.iter().map(|axis| full_scale[*axis]).collect(),
        };
        let order = by_table(recordings, in_order_of_time(recordings));
        let n_runs = order.len().min(RUNS);
        let run_of = |at: usize| at * n_runs / order.len();
        let mut runs: Vec<Vec<usize>> = vec![Vec::new(); n_runs];
        order.iter().enumerate().for_each(|(at, own)| runs[run_of(at)].extend(own));
        let loads = recordings.iter().map(|own| own.loads());
        let hold_one_load = hold_one_load(loads, first.axes().len());
        let mut rig = Self { units: Vec::new(), shape, runs, hold_one_load, scales, spans };
        rig.units = units(recordings, &rig, |_, _| true);
        Some(rig)
    }

    /// Returns the gauges of a sample minus their means, divided by their scales.
    fn standard(&self, gauges: &[f64]) -> impl Iterator<Item = f64> {
        gauges.iter().zip(&self.scales).map(|(own, (mean, scale))| (own - mean) / scale)
    }

    /// Returns the indices of a run's recordings in the list given to [`Rig::of`].
    pub fn recordings(&self, run: usize) -> &[usize] {
        &self.runs[run]
    }

    /// Returns the number of runs.
    pub fn n_runs(&self) -> usize {
        self.runs.len()
    }

    /// Returns the axes on which the load moves.
    pub fn axes(&self) -> &[Axis] {
        &self.shape.axes
    }

    fn total(&self, wanted: impl Fn(usize) -> bool) -> Mat<f64> {
        fits::sum(self.units.iter().filter(|unit| wanted(unit.run)), &self.shape)
    }

    /// Returns true if the zeros of the runs differ as if those of the reference did.
    fn are_zeros_of_reference(&self) -> bool {
        let fit = Fit::forward(&self.total(|_| true), &self.shape);
        let zeros = (0..self.n_runs()).map(|run| fit.means(&self.total(|own| own == run)));
        fits::look_like_loads(&zeros.collect::<Vec<_>>(), &fit, &self.shape)
    }

    /// Returns zeros and sensitivities of each run, compared with the fit to the other runs.
    pub fn table(&self) -> Vec<Run> {
        let errors = fits::left_out(&self.units, &self.shape);
        // For each gauge, the squared deviations of zero and sensitivity in single units from those of their run, with the
        // degrees of freedom.
        let mut scatter = vec![[(0.0, 0.0); 2]; self.shape.n_gauges];
        let mut estimates = Vec::new();
        for run in 0..self.n_runs() {
            let others = self.total(|other| other != run || self.n_runs() == 1);
            let fit = Fit::forward(&others, &self.shape);
            let sums = self.total(|own| own == run);
            let mean = fits::column_means(&sums);
            // For each gauge, zero and sensitivity with their weights.
            let estimated = |sums: &Mat<f64>| -> Vec<[(f64, f64); 2]> {
                let (n, moments) = (sums[(0, 0)], Moments::about(sums, &mean, &fit, &self.shape));
                let of_gauge = |(gauge, zero)| {
                    let (sensitivity, weight) = moments.sensitivity(gauge, &fit);
                    // If the load hardly moves in a run, the gauges' sensitivity is unknown and gets no weight.
                    let is_loaded = weight > 1e-6 * n;
                    [(zero, n), if is_loaded { (sensitivity, weight) } else { (0.0, 0.0) }]
                };
                fit.means(sums).into_iter().enumerate().map(of_gauge).collect()
            };
            let of_run = estimated(&sums);
            let units: Vec<&Unit> = self.units.iter().filter(|unit| unit.run == run).collect();
            for of_unit in units.iter().map(|unit| estimated(&unit.sums)) {
                let pairs = of_unit.as_flattened().iter().zip(of_run.as_flattened());
                for (sum, ((value, weight), (mean, _))) in
                    scatter.as_flattened_mut().iter_mut().zip(pairs)
                {
                    sum.0 += weight * (value - mean).powi(2);
                    sum.1 += (units.len() as f64 - 1.0) / units.len() as f64;
                }
            }
            estimates.push(of_run);
        }
        // Returns the zeros (`at` = 0) or sensitivities (`at` = 1) of a run with standard errors. A zero is divided by the span
        // of its gauge. A value is unknown if its confidence interval is wider than the gauge's range or sensitivity.
        let known = |of_run: &[[(f64, f64); 2]], at: usize| {
            let of_gauge = |(gauge, own): (usize, &[(f64, f64); 2])| {
                let ((value, weight), (squares, freedom)) = (own[at], scatter[gauge][at]);
                let span = if at == 0 { self.spans[gauge] } else { 1.0 };
                let error = (squares / freedom / weight).sqrt() / span;
                let is_known = weight > 0.0 && freedom > 0.5 && 2.0 * error < 1.0;
                is_known.then_some((value / span, error))
            };
            of_run.iter().enumerate().map(of_gauge).collect()
        };
        let rows = estimates.into_iter().enumerate().map(|(run, of_run)| Run {
            recordings: self.runs[run].clone(),
            zeros: known(&of_run, 0),
            sensitivities: known(&of_run, 1),
            error: fits::mean_error(&errors, &self.units, |own| own == run),
        });
        rows.collect()
    }
}

/// Returns the sums of products over the units of each run. Samples are omitted for which `is_used`, given the index of the
/// recording and of the sample, is false.
fn units(
    recordings: &[&Recording],
    rig: &Rig,
    is_used: impl Fn(usize, usize) -> bool,
) -> Vec<Unit> {
    let (n_runs, shape) = (rig.n_runs(), &rig.shape);
    let axes = shape.axes_in(recordings[0]);
    let mut units = Vec::new();
    for (run, numbers) in rig.runs.iter().enumerate() {
        let n: usize = numbers.iter().map(|at| recordings[*at].n_samples()).sum();
        let n_units = UNITS.div_ceil(n_runs).max(2).min(n);
        let mut sums = vec![NormalEquations::new(shape.width(), 0); n_units];
        let mut rows: Vec<f64> = Vec::new();
        let samples =
            numbers.iter().flat_map(|at| (0..recordings[*at].n_samples()).map(move |k| (*at, k)));
        for (k, (at, sample)) in samples.enumerate() {
            let (unit, recording) = (k * n_units / n, recordings[at]);
            let stride = sums[unit].stride();
            if is_used(at, sample) {
                let loads = &recording.loads()[sample * recording.axes().len()..];
                let loads =
                    axes.iter().zip(&shape.full_scale).map(|(axis, full)| loads[*axis] / full);
                let time = (run as f64 + k as f64 / n as f64) / n_runs as f64 - 0.5;
                rows.extend([1.0, time]);
                rows.extend(rig.standard(recording.gauges_at(sample)).chain(loads));
                rows.resize(rows.len().next_multiple_of(stride), 0.0);
            }
            if rows.len() >= BLOCK * stride || (k + 1) * n_units / n > unit {
                sums[unit].add_rows(&rows);
                rows.clear();
            }
        }
        let width = shape.width();
        units.extend(sums.iter().map(|sums| {
            let sums = Mat::from_fn(width, width, |i, j| sums.feature_product(i, j));
            Unit { run, sums }
        }));
    }
    units
}

/// Returns the indices of recordings in order of their start times, or in the given order if a start time is unknown.
fn in_order_of_time(recordings: &[&Recording]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..recordings.len()).collect();
    let started: Option<Vec<f64>> = recordings.iter().map(|own| own.started()).collect();
    if let Some(started) = started {
        order.sort_by(|a, b| started[*a].total_cmp(&started[*b]));
    }
    order
}

/// Combines the static load cases of each table into one run, if there are other tables or recordings to compare with.
fn by_table(recordings: &[&Recording], order: Vec<usize>) -> Vec<Vec<usize>> {
    let tables = order.chunk_by(|a, b| are_of_one_table(recordings[*a], recordings[*b]));
    let tables: Vec<Vec<usize>> = tables.map(<[usize]>::to_vec).collect();
    match tables.len() {
        1 => order.into_iter().map(|own| vec![own]).collect(),
        _ => tables,
    }
}

/// Returns mean and standard deviation of each gauge, and each gauge's range in standard deviations.
fn scales(recordings: &[&Recording], n_gauges: usize) -> (Vec<(f64, f64)>, Vec<f64>) {
    let of_gauge = |gauge: usize| {
        let values = || {
            recordings.iter().flat_map(move |own| own.gauges()[gauge..].iter().step_by(n_gauges))
        };
        let n = values().count().max(1) as f64;
        let mean = values().sum::<f64>() / n;
        let variance = values().map(|value| (value - mean).powi(2)).sum::<f64>() / n;
        // The computed standard deviation of a constant gauge is not exactly zero, because its mean is rounded.
        let scale = if variance.sqrt() > 1e-9 * mean.abs() { variance.sqrt() } else { 1.0 };
        let ends: MinMax = values().copied().collect();
        ((mean, scale), (ends.span() / scale).max(f64::MIN_POSITIVE))
    };
    (0..n_gauges).map(of_gauge).unzip()
}
