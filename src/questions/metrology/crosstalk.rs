//! The rows about crosstalk: what an axis that is not loaded reads while another one alone is.
//!
//! Guarantees: noise is no crosstalk, however large; an offset of the axis is none either.

use rayon::prelude::*;

use crate::questions::metrology::figures::{Found, Result};
use crate::questions::metrology::measured::{Columns, Measured, OUTPUTS};
use crate::questions::metrology::quantity::Quantity;
use crate::questions::metrology::reason::Reason;
use crate::recording::Axis;

/// Fewer samples than this are no interval but a load that passes by.
const FEWEST_SAMPLES: usize = 10;
/// From this share of its full scale on an axis can be the one that is loaded alone.
const PRESENT: f64 = 0.1;
/// So many cells of load a full scale is divided into, to each side: in each, the deviations are averaged.
const CELLS: usize = 10;
/// A mean deviation within so many of its standard errors is noise.
const STANDARD_ERRORS: f64 = 3.0;

/// Sums over samples: how many, of the values, of their squares.
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

    /// The mean, where it is more than noise.
    fn systematic(&self) -> f64 {
        let mean = self.mean();
        let variance = (self.squares / self.n - mean * mean).max(0.0);
        let standard_error = (variance / (self.n - 1.0)).sqrt();
        if mean.abs() > STANDARD_ERRORS * standard_error { mean } else { 0.0 }
    }
}

/// What all axes do while one alone is loaded, or none.
#[derive(Clone, Debug)]
pub(crate) struct Alone {
    /// In how many samples it is loaded.
    count: usize,
    /// The greatest size of its load.
    reached: f64,
    /// Per output and axis: error per load; `None` where the load does not change.
    slopes: [Vec<Option<f64>>; OUTPUTS],
    /// Per output and axis: the largest mean deviation over the cells of load.
    largest: [Vec<f64>; OUTPUTS],
}

/// Which axis is loaded alone, sample by sample; one entry per loaded axis.
pub(crate) fn intervals_alone(measured: &Measured<'_>) -> Vec<Alone> {
    let axes = (0..measured.axes.len()).into_par_iter();
    axes.map(|loaded| alone(measured, loaded)).collect()
}

/// The samples of a run in which no axis but this one is loaded; `None` without a reference for each axis.
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

/// Errors over loads by least squares, each run with an offset of its own; `None` where no run has loads enough apart.
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

/// The largest mean over a cell of load of what the errors are away from those at no load.
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

/// What `axis` reads while each other one alone is loaded.
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

/// The slope of the error of `axis` over the load of `loaded`, which alone is loaded.
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
