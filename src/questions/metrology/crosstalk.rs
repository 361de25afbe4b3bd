//! Crosstalk rows: the reading of an unloaded axis while another axis is loaded alone. Neither noise nor an offset of the axis
//! counts as crosstalk.

use rayon::prelude::*;

use crate::{
    questions::metrology::{
        figures::{Figure, Found, OUTPUTS, Value},
        measured::{Columns, Measured},
        quantity::Quantity,
        reason::Reason,
    },
    recording::Axis,
};

/// Minimum number of samples from which the slope of crosstalk is computed.
const FEWEST_SAMPLES: usize = 10;
/// Load above which an axis counts as loaded when its crosstalk is measured, as a share of full scale.
const PRESENT: f64 = 0.1;
/// Crosstalk while one axis is loaded alone, by output and responding axis: the error at full load. `None` if the load does
/// not change enough for a slope.
pub type Response = [Vec<Option<f64>>; OUTPUTS];

pub fn responses(measured: &Measured<'_>) -> Vec<Found<Response>> {
    let axes = (0..measured.axes.len()).into_par_iter();
    axes.map(|loaded| response(measured, loaded)).collect()
}

/// Returns the reference loads of a recording, and the samples in which no axis but `loaded` is loaded. Returns `None`
/// without a reference for each axis.
fn samples<'a>(
    measured: &Measured<'_>,
    columns: &'a Columns<'_>,
    loaded: usize,
) -> Option<(Vec<&'a [f64]>, Vec<usize>)> {
    let loads: Vec<&[f64]> = columns.loads.iter().map(Option::as_deref).collect::<Option<_>>()?;
    let share = measured.settings.alone_share;
    let others = measured.full_scale.iter().enumerate();
    let others: Vec<(usize, f64)> = others
        .filter(|(axis, _)| *axis != loaded)
        .map(|(axis, full_scale)| (axis, share * full_scale))
        .collect();
    let is_alone = |k: &usize| others.iter().all(|(axis, most)| loads[*axis][*k].abs() <= *most);
    let found = (0..columns.run.times.len()).filter(is_alone).collect();
    Some((loads, found))
}

fn response(measured: &Measured<'_>, loaded: usize) -> Found<Response> {
    let (axis, n_axes, settings) = (measured.axes[loaded], measured.axes.len(), measured.settings);
    let full_scale = measured.full_scale[loaded];
    if n_axes == 1 {
        return Err(Reason::OnlyAxis { axis });
    }
    if full_scale <= 0.0 {
        return Err(Reason::NoFullScale { axis });
    }
    let runs: Vec<_> = (measured.runs.iter())
        .filter_map(|columns| Some((columns, samples(measured, columns, loaded)?)))
        .collect();
    let sizes = || {
        let runs = runs.iter();
        runs.flat_map(|(_, (loads, samples))| samples.iter().map(|k| loads[loaded][*k].abs()))
    };
    let present = PRESENT.max(settings.alone_share) * full_scale;
    let count = sizes().filter(|load| *load > present).count();
    if count < FEWEST_SAMPLES || sizes().fold(0.0, f64::max) < settings.loaded_share * full_scale {
        let (loaded_share, alone_share) = (settings.loaded_share, settings.alone_share);
        return Err(Reason::NeverAlone { axis, loaded_share, alone_share });
    }
    let of = |output: usize, axis: usize| {
        let points: Vec<Vec<(f64, f64)>> = (runs.iter())
            .map(|(columns, (loads, samples))| {
                let outputs = columns.run.outputs()[output];
                let error = |k: usize| outputs[k * n_axes + axis] - loads[axis][k];
                samples.iter().map(|k| (loads[loaded][*k], error(*k))).collect()
            })
            .filter(|points: &Vec<_>| !points.is_empty())
            .collect();
        Some(slope(&points, present)? * full_scale)
    };
    Ok(std::array::from_fn(|output| {
        (0..n_axes).map(|axis| if axis == loaded { None } else { of(output, axis) }).collect()
    }))
}

/// Returns the least-squares slope of errors against loads, with an offset for each recording. Returns `None` if no load
/// differs from the mean of its recording by more than `apart`.
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

pub fn crosstalk_figures(
    measured: &Measured<'_>,
    responses: &[Found<Response>],
    axis: usize,
    output: usize,
) -> Vec<(Quantity, Figure)> {
    let of_axis = |(loaded, from): (usize, &Axis)| {
        let found = match &responses[loaded] {
            Err(reason @ Reason::OnlyAxis { .. }) => Err(reason.clone()),
            _ if loaded == axis => Err(Reason::LoadedAxis { axis: *from }),
            Ok(response) => response[output][axis].ok_or(Reason::NotLinear { axis: *from }),
            Err(reason) => Err(reason.clone()),
        };
        (Quantity::Crosstalk(*from), found.map(Value::everywhere))
    };
    measured.axes.iter().enumerate().map(of_axis).collect()
}
