//! Metrology rows that need no loop: dwells (zero return, creep, recovery), errors of all samples, load cases, crosstalk,
//! noise, and effects of the temperature.
//!
//! Crosstalk is the reading of an unloaded axis while another axis is loaded alone. Neither noise nor an offset of the axis
//! counts as crosstalk.

use std::{collections::BTreeMap, ops::Range};

use rayon::prelude::*;

use crate::{
    min_max::MinMax,
    questions::metrology::{
        figures::{
            Figure, Found, MetrologyError, OUTPUTS, Place, Quantity, Reason, Rules, Run, Value,
        },
        measured::{AxisRun, AxisView, Columns, Measured},
    },
    recording::{Axis, load_cases, median::white_noise},
    scoring::{
        holds::{Drift, Hold},
        metrics::root_mean,
        quantile::quantile,
        straight_lines::Line,
    },
};

/// Minimum number of different loads on a branch, for a line that shows nonlinearity.
pub const FEWEST_LOADS: usize = 3;

type Dwelling<'a> = (&'a AxisRun<'a>, &'a Hold);

/// Returns the slope of the readings over the load, if there is one gauge and one axis.
pub fn sensitivity(view: &AxisView<'_>) -> Figure {
    let (axis, runs) = (view.axis, &view.runs);
    let is_single = |run: &AxisRun<'_>| run.columns.run.gauges.len() == run.loads.len();
    if view.measured.axes.len() > 1 || !runs.iter().all(is_single) {
        return Err(Reason::ManyGauges { axis });
    }
    let mut points: Vec<(f64, f64)> = Vec::new();
    for run in runs {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (load, reading) = (mean(run.loads), mean(run.columns.run.gauges));
        let pairs = run.loads.iter().zip(run.columns.run.gauges);
        points.extend(pairs.map(|(x, y)| (x - load, y - reading)));
    }
    let line = Line::best_fit(&points).ok_or(Reason::NotLinear { axis })?;
    let freedom = points.len() as f64 - 1.0 - runs.len() as f64;
    let variance = line.squares(&points) / freedom;
    let uncertainty = (freedom > 0.0).then(|| (variance / line.spread).sqrt());
    Ok(Value { uncertainty, ..Value::everywhere(line.slope) })
}

pub fn dwell_figures(view: &AxisView<'_>, output: usize) -> Vec<(Quantity, Figure)> {
    let drift = |(run, hold): Dwelling<'_>| {
        let errors: Vec<f64> = run.errors(output, hold.samples.clone()).collect();
        let drift = Drift::of(&run.times()[hold.samples.clone()], &errors);
        let place = run.place(hold.samples.clone());
        (drift.expect("a dwell has samples and a duration"), Some(place))
    };
    let creep = loaded_hold(view).map(drift);
    let size = |(drift, place): (Drift, _)| Value::at(drift.size, place);
    let time_constant = creep.clone().and_then(|(drift, place)| {
        let tau_secs = drift.tau_secs()?;
        Ok(Value::at(tau_secs, place))
    });
    vec![
        (Quantity::ZeroReturn, zero_return(view, output)),
        (Quantity::CreepTime, time_constant),
        (Quantity::Creep, creep.map(size)),
        (Quantity::CreepRecovery, recovery(view).map(drift).map(size)),
    ]
}

/// Returns the zero return: the largest change of an output between two neighbouring dwells at zero load, if the axis was
/// loaded between them.
pub fn zero_return(view: &AxisView<'_>, output: usize) -> Figure {
    let least = view.loaded_from()?;
    check_zero(view)?;
    let secs = view.measured.settings.hold_secs;
    let pairs = view.runs.iter().flat_map(|run| {
        let dwells = dwells_at_zero(view, run);
        let pairs = dwells.windows(2).map(|pair| (run, pair[0], pair[1]));
        pairs.collect::<Vec<_>>()
    });
    let loaded = pairs
        .filter(|(run, before, after)| run.reaches(least, before.samples.end..after.samples.start));
    let returned = loaded.map(|(run, before, after)| {
        let size = mean_error(run, output, beginning(run, after, secs))
            - mean_error(run, output, end(run, before, secs));
        Value::at(size, Some(run.place(before.samples.start..after.samples.end)))
    });
    let largest =
        returned.reduce(
            |largest, other| {
                if other.value.abs() > largest.value.abs() { other } else { largest }
            },
        );
    largest.ok_or(Reason::NoReturn { axis: view.axis, share: view.measured.settings.loaded_share })
}

/// Returns the longest dwell during which the axis is loaded.
fn loaded_hold<'a>(view: &'a AxisView<'a>) -> Found<Dwelling<'a>> {
    let least = view.loaded_from()?;
    let holds = view.runs.iter().flat_map(|run| {
        let holds = view.measured.holds[run.index].iter();
        holds.filter(move |hold| mean_load(run, hold).abs() >= least).map(move |hold| (run, hold))
    });
    let settings = view.measured.settings;
    longest(holds).ok_or(Reason::NoHold {
        axis: view.axis,
        share: settings.loaded_share,
        secs: settings.hold_secs,
    })
}

/// Returns the longest dwell at zero load that follows a load on the axis.
fn recovery<'a>(view: &'a AxisView<'a>) -> Found<Dwelling<'a>> {
    let least = view.loaded_from()?;
    check_zero(view)?;
    let after_a_load = view.runs.iter().flat_map(|run| {
        let mut since = 0;
        dwells_at_zero(view, run).into_iter().filter_map(move |rest| {
            let loaded = run.reaches(least, since..rest.samples.start);
            since = rest.samples.end;
            loaded.then_some((run, rest))
        })
    });
    longest(after_a_load)
        .ok_or(Reason::NoRecovery { axis: view.axis, share: view.measured.settings.loaded_share })
}

/// Returns the dwells in which the loads of all axes of the recording are near zero.
fn dwells_at_zero<'a>(view: &AxisView<'a>, run: &AxisRun<'_>) -> Vec<&'a Hold> {
    let measured = view.measured;
    let holds = measured.holds[run.index].iter();
    holds.filter(|hold| measured.is_at_zero(run.index, hold)).collect()
}

fn check_zero(view: &AxisView<'_>) -> Found<()> {
    let settings = view.measured.settings;
    if view.runs.iter().all(|run| dwells_at_zero(view, run).is_empty()) {
        return Err(Reason::NoZero { share: settings.zero_share, secs: settings.hold_secs });
    }
    Ok(())
}

/// Returns the longest dwell. If several dwells are equally long, the first dwell is returned.
fn longest<'a>(holds: impl Iterator<Item = Dwelling<'a>>) -> Option<Dwelling<'a>> {
    let secs = |(run, hold): &Dwelling<'_>| {
        run.times()[hold.samples.end - 1] - run.times()[hold.samples.start]
    };
    holds.reduce(|longest, other| if secs(&other) > secs(&longest) { other } else { longest })
}

fn mean_load(run: &AxisRun<'_>, hold: &Hold) -> f64 {
    run.loads[hold.samples.clone()].iter().sum::<f64>() / hold.samples.len() as f64
}

fn mean_error(run: &AxisRun<'_>, output: usize, samples: Range<usize>) -> f64 {
    let n = samples.len();
    run.errors(output, samples).sum::<f64>() / n as f64
}

fn beginning(run: &AxisRun<'_>, hold: &Hold, secs: f64) -> Range<usize> {
    let samples = hold.samples.clone();
    let times = &run.times()[samples.clone()];
    let n = times.partition_point(|time| *time <= times[0] + secs);
    samples.start..samples.start + n
}

fn end(run: &AxisRun<'_>, hold: &Hold, secs: f64) -> Range<usize> {
    let samples = hold.samples.clone();
    let times = &run.times()[samples.clone()];
    let before = times.partition_point(|time| *time < times[times.len() - 1] - secs);
    samples.start + before..samples.end
}

/// A dwell of the load. [`Drift::of`](crate::scoring::holds::Drift::of) fits the drift of an output in a dwell.
#[derive(Debug)]
pub struct Dwell {
    pub place: Place,
    /// Mean reference load of the axis in the dwell; `None` if the recording has no reference for the axis.
    pub level: Option<f64>,
    /// True if the load of every axis with a reference is near zero in the dwell.
    pub at_zero: bool,
}

/// Returns all dwells of these recordings, in the order of recordings and time. Zero return and creep are measured in these
/// dwells. `axis` is the position of the axis whose mean load [`Dwell::level`] states.
///
/// # Errors
/// See [`table_by`](crate::questions::metrology::table_by).
pub fn dwells(
    runs: &[Run<'_>],
    rules: &Rules<'_>,
    axis: usize,
) -> Result<Vec<Dwell>, MetrologyError> {
    let measured = Measured::of(runs, rules)?;
    let of_runs = measured.holds.iter().enumerate().flat_map(|(index, holds)| {
        let (measured, Columns { run, loads }) = (&measured, &measured.runs[index]);
        let before = loads[..axis].iter().flatten().count();
        holds.iter().map(move |hold| Dwell {
            place: run.place(index, hold.samples.clone()),
            level: loads[axis].as_ref().map(|_| hold.level[before]),
            at_zero: measured.is_at_zero(index, hold),
        })
    });
    Ok(of_runs.collect())
}

pub fn case_figures(view: &AxisView<'_>, output: usize) -> [(Quantity, Figure); 2] {
    [
        (Quantity::BestFitNonlinearity, nonlinearity(view, output)),
        (Quantity::Repeatability, repeatability(view, output)),
    ]
}

/// Returns the nonlinearity: the largest deviation of a load case's mean output from the best-fit straight line.
fn nonlinearity(view: &AxisView<'_>, output: usize) -> Figure {
    let cases = cases(view, output);
    let mean = |rows: &[(f64, f64)], of: fn(&(f64, f64)) -> f64| {
        rows.iter().map(of).sum::<f64>() / rows.len() as f64
    };
    let points: Vec<(f64, f64)> =
        cases.iter().map(|rows| (mean(rows, |row| row.0), mean(rows, |row| row.1))).collect();
    let mut loads: Vec<f64> = points.iter().map(|(load, _)| *load).collect();
    loads.sort_by(f64::total_cmp);
    loads.dedup();
    let few = Reason::TooFewLoads { axis: view.axis, found: loads.len() };
    let line = Line::best_fit(&points).filter(|_| loads.len() >= FEWEST_LOADS).ok_or(few)?;
    let n_rows: usize = cases.iter().map(Vec::len).sum();
    let noise = reading_noise(&cases) / (n_rows as f64 / cases.len() as f64).sqrt();
    view.above_noise(line.largest_deviation(points.iter()), noise, None)
}

/// Returns the standard deviation of repeated readings of a load case; 0 without repeated readings, because it is unknown.
fn reading_noise(cases: &[Vec<(f64, f64)>]) -> f64 {
    let (mut squares, mut freedom) = (0.0, 0.0);
    for rows in cases {
        let mean = rows.iter().map(|(_, output)| output).sum::<f64>() / rows.len() as f64;
        squares += rows.iter().map(|(_, output)| (output - mean).powi(2)).sum::<f64>();
        freedom += rows.len() as f64 - 1.0;
    }
    if freedom > 0.0 { (squares / freedom).sqrt() } else { 0.0 }
}

/// Returns the standard deviation of one reading of tables, in which a load may be reached in two directions; `None` of other
/// recordings.
pub fn table_noise(view: &AxisView<'_>) -> Option<[f64; OUTPUTS]> {
    let are_tables = view.runs.iter().all(|run| run.columns.run.is_table);
    are_tables.then(|| std::array::from_fn(|output| reading_noise(&cases(view, output))))
}

/// Returns the largest difference between the errors of repeated readings of one load case.
pub fn repeatability(view: &AxisView<'_>, output: usize) -> Figure {
    let spread = |rows: Vec<(f64, f64)>| {
        let errors = rows.iter().map(|(load, output)| output - load);
        (rows.len() > 1).then(|| errors.collect::<MinMax>().span())
    };
    let largest = cases(view, output).into_iter().filter_map(spread).reduce(f64::max);
    largest.map(Value::everywhere).ok_or(Reason::NoRepeats { axis: view.axis })
}

/// Returns the loads and outputs `(load, output)` of the readings, grouped by load case. Readings of one load case have the same
/// reference on every axis, and if their order is known, the load was reached in the same direction.
fn cases(view: &AxisView<'_>, output: usize) -> Vec<Vec<(f64, f64)>> {
    let known = |run: &AxisRun<'_>| -> Vec<bool> {
        run.columns.loads.iter().map(Option::is_some).collect()
    };
    let of_first = known(&view.runs[0]);
    let axes = view.measured.axes.iter().zip(&of_first).filter(|(_, known)| **known);
    let axes: Vec<Axis> = axes.map(|(axis, _)| *axis).collect();
    let runs: Vec<_> = view.runs.iter().filter(|run| known(run) == of_first).collect();
    let (mut loads, mut readings) = (Vec::new(), Vec::new());
    for run in runs {
        let ways = ways(run.loads, run.columns.run.is_load_case);
        for (row, way) in ways.into_iter().enumerate() {
            loads.extend(run.columns.loads.iter().flatten().map(|column| column[row]));
            readings.push((way, (run.loads[row], run.outputs[output][row])));
        }
    }
    let mut found: BTreeMap<(usize, bool), Vec<(f64, f64)>> = BTreeMap::new();
    for (case, (way, reading)) in load_cases(&loads, &axes).into_iter().zip(readings) {
        found.entry((case, way)).or_default().push(reading);
    }
    found.into_values().collect()
}

/// Returns true for each row whose load was reached from below. The first load counts as reached from below, if a higher load
/// follows. Rows without an order have one direction.
fn ways(loads: &[f64], have_no_order: bool) -> Vec<bool> {
    let next = loads.iter().find(|load| **load != loads[0]);
    let mut rising = next.is_none_or(|next| *next > loads[0]);
    let way = |row: usize| {
        if row > 0 && loads[row] != loads[row - 1] {
            rising = loads[row] > loads[row - 1];
        }
        rising || have_no_order
    };
    (0..loads.len()).map(way).collect()
}

/// Share of the samples whose absolute error must not exceed the figure "95 % error".
const COVERED: f64 = 0.95;

pub fn error_figures(view: &AxisView<'_>, output: usize) -> Vec<(Quantity, Figure)> {
    let errors = view.runs.iter().flat_map(|run| {
        let errors = run.errors(output, 0..run.loads.len()).enumerate();
        errors.map(move |(k, error)| (error.abs(), run, k))
    });
    let mut sizes: Vec<f64> = errors.clone().map(|(size, ..)| size).collect();
    let squares: f64 = sizes.iter().map(|size| size * size).sum();
    let rmse = root_mean(&[squares], sizes.len() as u64).map_or(f64::NAN, |rmse| rmse[0]);
    let covered = quantile(&mut sizes, COVERED).unwrap_or(f64::NAN);
    let largest = errors.reduce(|largest, other| if other.0 > largest.0 { other } else { largest });
    let (largest, run, k) = largest.expect("the samples of a measured axis are not empty");
    vec![
        (Quantity::Rmse, Ok(Value::everywhere(rmse))),
        (Quantity::LargestError, Ok(Value::at(largest, Some(run.place(k..k + 1))))),
        (Quantity::Error95, Ok(Value::everywhere(covered))),
    ]
}

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

/// The effects are given for this change of the temperature (°C).
const PER: f64 = 10.0;
/// Smallest range of temperatures from which their effects are computed (°C).
const LEAST: f64 = 2.0;
/// Number of parts that are left out in turn to find the uncertainty of the effects.
const PARTS: usize = 10;
/// Offset, load, temperature, and their product.
const TERMS: usize = 4;

pub fn noise_figures(view: &AxisView<'_>, output: usize) -> [(Quantity, Figure); 2] {
    let dwells = view.runs.iter().flat_map(|run| {
        let holds = view.measured.holds[run.index].iter();
        holds.map(move |hold| (run, hold))
    });
    let longest = dwells.max_by_key(|(_, hold)| hold.samples.len());
    let settings = view.measured.settings;
    let (noise, span) = match longest {
        Some((run, hold)) => {
            let outputs = &run.outputs[output][hold.samples.clone()];
            // A value minus the mean of its neighbours has 1.5 times the variance of white noise.
            let off = outputs.windows(3).map(|near| near[1] - 0.5 * (near[0] + near[2]));
            let off: Vec<f64> = off.map(|off| off / 1.5_f64.sqrt()).collect();
            let mean_square = off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64;
            let place = Some(run.place(hold.samples.clone()));
            let span = Value::at(off.into_iter().collect::<MinMax>().span(), place.clone());
            (Value::at(mean_square.sqrt(), place), Ok(span))
        }
        None => {
            let all = view.runs.iter().map(|run| white_noise(&run.outputs[output]));
            let (axis, secs) = (view.axis, settings.hold_secs);
            (
                Value::everywhere(all.fold(0.0, f64::max)),
                Err(Reason::NoHold { axis, share: 0.0, secs }),
            )
        }
    };
    [(Quantity::Noise, Ok(noise)), (Quantity::NoisePeakToPeak, span)]
}

/// Sums for the least-squares fit of errors: products of the terms, and of the terms and the error.
#[derive(Clone, Copy, Default)]
struct Sums([[f64; TERMS + 1]; TERMS]);

impl Sums {
    fn add(&mut self, terms: [f64; TERMS], error: f64) {
        for (row, term) in self.0.iter_mut().zip(terms) {
            row.iter_mut().zip(terms).for_each(|(sum, other)| *sum += term * other);
            row[TERMS] += term * error;
        }
    }

    fn plus(mut self, other: &Self) -> Self {
        let all = self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened());
        all.for_each(|(sum, other)| *sum += other);
        self
    }

    /// Returns the coefficients by elimination; `None` if the terms do not determine them.
    fn solved(self) -> Option<[f64; TERMS]> {
        let mut rows = self.0;
        for at in 0..TERMS {
            let pivot = rows[at];
            // The terms are centred and scaled, so a small pivot means that a term follows from the others.
            if pivot[at] <= 1e-6 * self.0[at][at] {
                return None;
            }
            for (other, row) in rows.iter_mut().enumerate() {
                let factor = if other == at { 0.0 } else { row[at] / pivot[at] };
                row.iter_mut().zip(pivot).for_each(|(value, pivot)| *value -= factor * pivot);
            }
        }
        Some(std::array::from_fn(|at| rows[at][TERMS] / rows[at][at]))
    }
}

pub fn temperature_figures(view: &AxisView<'_>, output: usize) -> [(Quantity, Figure); 2] {
    let effects = temperature_effects(view, output);
    [(Quantity::TemperatureZero, 0), (Quantity::TemperatureSpan, 1)].map(|(quantity, at)| {
        let figure = effects.as_ref().map_err(Clone::clone).map(|(values, errors)| Value {
            uncertainty: Some(errors[at]),
            ..Value::everywhere(values[at])
        });
        (quantity, figure)
    })
}

/// Returns the change of the error at zero and at full load by a change of the temperature, and both standard uncertainties.
fn temperature_effects(view: &AxisView<'_>, output: usize) -> Found<([f64; 2], [f64; 2])> {
    let (axis, full_scale) = (view.axis, view.full_scale);
    let none = Reason::NoTemperature { axis, least: LEAST };
    let runs: Vec<(_, Vec<f64>)> = (view.runs.iter())
        .filter_map(|run| {
            let table = run.columns.run.auxiliary?;
            let at = table.units().iter().position(|unit| unit == "°C")?;
            Some((run, (0..run.loads.len()).map(|k| table.at(k)[at]).collect()))
        })
        .collect();
    let range: MinMax = runs.iter().flat_map(|(_, temperatures)| temperatures).copied().collect();
    if range.span().is_nan() || range.span() < LEAST {
        return Err(none);
    }
    if full_scale <= 0.0 {
        return Err(Reason::NoFullScale { axis });
    }
    let (middle, half) = (0.5 * (range.min + range.max), 0.5 * range.span());
    let n: usize = runs.iter().map(|(_, temperatures)| temperatures.len()).sum();
    let mut parts = [Sums::default(); PARTS];
    let mut done = 0;
    for (run, temperatures) in &runs {
        let errors = run.errors(output, 0..run.loads.len());
        for ((error, load), warm) in errors.zip(run.loads).zip(temperatures) {
            let (load, warm) = (load / full_scale, (warm - middle) / half);
            parts[done * PARTS / n].add([1.0, load, warm, load * warm], error);
            done += 1;
        }
    }
    let all = |left_out: Option<usize>| {
        let kept = parts.iter().enumerate().filter(|(part, _)| Some(*part) != left_out);
        let sums = kept.fold(Sums::default(), |sums, (_, part)| sums.plus(part));
        let [.., zero, span] = sums.solved()?;
        Some([zero, span].map(|effect| effect * PER / half))
    };
    let values = all(None).ok_or(none)?;
    // Jackknife: the effects without each part in turn.
    let without: Vec<[f64; 2]> = (0..PARTS).filter_map(|part| all(Some(part))).collect();
    let errors = [0, 1].map(|at| {
        let mean = without.iter().map(|own| own[at]).sum::<f64>() / without.len() as f64;
        let squares = without.iter().map(|own| (own[at] - mean).powi(2)).sum::<f64>();
        (squares * (PARTS - 1) as f64 / PARTS as f64).sqrt()
    });
    Ok((values, errors))
}
