//! Crosstalk rows: the reading of an unloaded axis while another axis is loaded alone. Neither noise nor an offset of the axis
//! counts as crosstalk.

use rayon::prelude::*;

use crate::questions::metrology::figures::{Found, Result};
use crate::questions::metrology::measured::{Columns, Measured, OUTPUTS};
use crate::questions::metrology::quantity::Quantity;
use crate::questions::metrology::reason::Reason;
use crate::recording::Axis;

/// Minimum number of samples in which an axis is loaded alone.
const FEWEST_SAMPLES: usize = 10;
/// Minimum of the largest load of an axis that is loaded alone, as a share of full scale.
const PRESENT: f64 = 0.1;
/// Number of load cells per full scale on each side of zero, in which deviations are averaged.
const CELLS: usize = 10;
/// Largest mean deviation that counts as noise, in standard errors.
const STANDARD_ERRORS: f64 = 3.0;

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    n: f64,
    sum: f64,
    squares: f64,
}

impl Sums {
    fn add(&mut self, value: f64) {
        self.n += 1.0;
        self.sum += value;
        self.squares += value * value;
    }

    fn mean(&self) -> f64 {
        self.sum / self.n
    }

    /// Returns the mean, if it exceeds the noise.
    fn systematic(&self) -> f64 {
        let mean = self.mean();
        let variance = (self.squares / self.n - mean * mean).max(0.0);
        let standard_error = (variance / (self.n - 1.0)).sqrt();
        if mean.abs() > STANDARD_ERRORS * standard_error { mean } else { 0.0 }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Alone {
    count: usize,
    /// Largest magnitude of the axis' load.
    reached: f64,
    /// Error per load, by output and axis; `None` if the load does not change.
    slopes: [Vec<Option<f64>>; OUTPUTS],
    /// Largest mean deviation over the load cells, by output and axis.
    largest: [Vec<f64>; OUTPUTS],
}

/// Returns the samples in which each axis is loaded alone; one entry per loaded axis.
pub(crate) fn intervals_alone(measured: &Measured<'_>) -> Vec<Alone> {
    let axes = (0..measured.axes.len()).into_par_iter();
    axes.map(|loaded| alone(measured, loaded)).collect()
}

/// Returns the samples of a run in which only this axis is loaded; `None` without a reference for each axis.
fn samples<'a>(
    measured: &'a Measured<'_>,
    run: &'a Columns<'_>,
    loaded: usize,
) -> Option<(Vec<&'a [f64]>, Vec<usize>)> {
    let loads = run.all_loads()?;
    let share = measured.settings.alone_share;
    let others = measured.full_scale.iter().enumerate();
    let others: Vec<(usize, f64)> = others
        .filter(|(axis, _)| *axis != loaded)
        .map(|(axis, full_scale)| (axis, share * full_scale))
        .collect();
    let is_alone = |k: &usize| others.iter().all(|(axis, most)| loads[*axis][*k].abs() <= *most);
    let found = (0..run.times.len()).filter(is_alone).collect();
    Some((loads, found))
}

fn alone(measured: &Measured<'_>, loaded: usize) -> Alone {
    let n_axes = measured.axes.len();
    let full_scale = measured.full_scale[loaded];
    let present = PRESENT.max(measured.settings.alone_share) * full_scale;
    let mut found = Alone {
        count: 0,
        reached: 0.0,
        slopes: std::array::from_fn(|_| vec![None; n_axes]),
        largest: std::array::from_fn(|_| vec![0.0; n_axes]),
    };
    let runs: Vec<_> = (measured.runs.iter())
        .filter_map(|run| Some((run, samples(measured, run, loaded)?)))
        .collect();
    for (_, (loads, samples)) in &runs {
        for load in samples.iter().map(|k| loads[loaded][*k].abs()) {
            found.count += usize::from(load > present);
            found.reached = found.reached.max(load);
        }
    }
    let is_scaled = full_scale > 0.0;
    if !is_scaled || found.count < FEWEST_SAMPLES {
        return found;
    }
    for output in 0..OUTPUTS {
        for axis in (0..n_axes).filter(|axis| *axis != loaded) {
            let points = |(run, (loads, samples)): &(&Columns<'_>, (Vec<&[f64]>, Vec<usize>))| {
                let error = |k: usize| run.output(output, axis, k) - loads[axis][k];
                let points = samples.iter().map(|k| (loads[loaded][*k], error(*k)));
                points.collect::<Vec<_>>()
            };
            let points: Vec<_> = runs.iter().map(points).filter(|own| !own.is_empty()).collect();
            let Some(slope) = slope(&points, present) else {
                continue;
            };
            found.slopes[output][axis] = Some(slope);
            found.largest[output][axis] = largest_deviation(&points, slope, full_scale);
        }
    }
    found
}

/// Returns the least-squares slope of errors over loads, with an offset for each run; `None` if no run has different loads.
fn slope(runs: &[Vec<(f64, f64)>], apart: f64) -> Option<f64> {
    let (mut xx, mut xy, mut reach) = (0.0, 0.0, 0.0_f64);
    for points in runs {
        let (x0, y0) = means(points);
        for (x, y) in points {
            xx += (x - x0) * (x - x0);
            xy += (x - x0) * (y - y0);
            reach = reach.max((x - x0).abs());
        }
    }
    (reach > apart).then(|| xy / xx)
}

fn means(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let sums = points.iter().fold((0.0, 0.0), |sums, (x, y)| (sums.0 + x, sums.1 + y));
    (sums.0 / n, sums.1 / n)
}

/// Returns the largest mean deviation in a load cell, relative to the errors at no load.
fn largest_deviation(runs: &[Vec<(f64, f64)>], slope: f64, full_scale: f64) -> f64 {
    let mut cells = [Sums::default(); 2 * CELLS];
    for points in runs {
        let (x0, y0) = means(points);
        let offset = y0 - slope * x0;
        for (x, y) in points {
            let place = CELLS as f64 * (1.0 + x / full_scale);
            cells[(place.max(0.0) as usize).min(2 * CELLS - 1)].add(y - offset);
        }
    }
    let full = cells.iter().filter(|cell| cell.n >= FEWEST_SAMPLES as f64);
    full.map(|cell| cell.systematic().abs()).fold(0.0, f64::max)
}

pub(crate) fn crosstalk_figures(
    measured: &Measured<'_>,
    alone: &[Alone],
    axis: usize,
    output: usize,
) -> Vec<(Quantity, Result<Found>)> {
    let of_axis = |(loaded, from): (usize, &Axis)| {
        let slope = response(measured, alone, (loaded, axis), output);
        let largest = slope.clone().map(|_| Found::everywhere(alone[loaded].largest[output][axis]));
        let full = slope.map(|slope| Found::everywhere(slope * measured.full_scale[loaded]));
        [(Quantity::Crosstalk(*from), full), (Quantity::CrosstalkDeviation(*from), largest)]
    };
    measured.axes.iter().enumerate().flat_map(of_axis).collect()
}

/// Returns the slope of the error of `axis` over the load of `loaded`, which is loaded alone.
fn response(
    measured: &Measured<'_>,
    alone: &[Alone],
    (loaded, axis): (usize, usize),
    output: usize,
) -> Result<f64> {
    let (settings, loaded_axis) = (measured.settings, measured.axes[loaded]);
    if measured.axes.len() == 1 {
        return Err(Reason::OnlyAxis { axis: loaded_axis });
    }
    if loaded == axis {
        return Err(Reason::LoadedAxis { axis: loaded_axis });
    }
    let full_scale = measured.full_scale[loaded];
    if full_scale <= 0.0 {
        return Err(Reason::NoFullScale { axis: loaded_axis });
    }
    let found = &alone[loaded];
    if found.count < FEWEST_SAMPLES || found.reached < settings.loaded_share * full_scale {
        return Err(Reason::NeverAlone {
            axis: loaded_axis,
            loaded_share: settings.loaded_share,
            alone_share: settings.alone_share,
        });
    }
    found.slopes[output][axis].ok_or(Reason::NotLinear { axis: loaded_axis })
}
