//! Metrology rows that need no order in time: errors of all samples, and nonlinearity and repeatability of load cases.

use crate::{
    min_max::MinMax,
    questions::metrology::{
        figures::{Figure, Value},
        loop_rows::FEWEST_LOADS,
        measured::AxisView,
        quantity::Quantity,
        reason::Reason,
    },
    recording::load_cases,
    scoring::{metrics::root_mean, quantile::quantile, straight_lines::Line},
};

pub fn case_figures(view: &AxisView<'_>, output: usize) -> [(Quantity, Figure); 2] {
    [
        (Quantity::BestFitNonlinearity, nonlinearity(view, output)),
        (Quantity::Repeatability, repeatability(view, output)),
    ]
}

/// Returns the nonlinearity: the largest deviation of a load case's mean output from the best-fit straight line.
fn nonlinearity(view: &AxisView<'_>, output: usize) -> Figure {
    let cases = cases(view);
    let mean = |rows: &[usize], values: &[f64]| {
        rows.iter().map(|row| values[*row]).sum::<f64>() / rows.len() as f64
    };
    let run = &view.runs[0];
    let points: Vec<(f64, f64)> = cases
        .iter()
        .map(|rows| (mean(rows, run.loads), mean(rows, &run.outputs[output])))
        .collect();
    let mut loads: Vec<f64> = points.iter().map(|(load, _)| *load).collect();
    loads.sort_by(f64::total_cmp);
    loads.dedup();
    let few = Reason::TooFewLoads { axis: view.axis, found: loads.len() };
    let line = Line::best_fit(&points).filter(|_| loads.len() >= FEWEST_LOADS).ok_or(few)?;
    // Noise of a mean, from the repeated rows; without repeated rows it is unknown.
    let (mut squares, mut freedom) = (0.0, 0.0);
    for (rows, (_, mean)) in cases.iter().zip(&points) {
        let off = rows.iter().map(|row| run.outputs[output][*row] - mean);
        squares += off.map(|off| off * off).sum::<f64>();
        freedom += rows.len() as f64 - 1.0;
    }
    let rows_per_case = run.loads.len() as f64 / cases.len() as f64;
    let noise = if freedom > 0.0 { (squares / freedom / rows_per_case).sqrt() } else { 0.0 };
    view.above_noise(line.largest_deviation(points.iter()), noise, None)
}

/// Returns the largest difference between the errors of repeated measurements of one load case.
fn repeatability(view: &AxisView<'_>, output: usize) -> Figure {
    let run = &view.runs[0];
    let error = |row: &usize| run.outputs[output][*row] - run.loads[*row];
    let spread = |rows: Vec<usize>| {
        (rows.len() > 1).then(|| rows.iter().map(error).collect::<MinMax>().span())
    };
    let spreads = cases(view).into_iter().filter_map(spread);
    let largest = spreads.reduce(f64::max);
    let largest = largest.ok_or(Reason::NoRepeats { axis: view.axis })?;
    Ok(Value::everywhere(largest))
}

/// Groups the rows by load case. Rows of one load case have the same reference on every axis.
fn cases(view: &AxisView<'_>) -> Vec<Vec<usize>> {
    let measured = view.measured;
    let columns = &measured.runs[0].loads;
    let known = || columns.iter().filter_map(Option::as_deref);
    let axes = columns.iter().zip(measured.axes).filter(|(loads, _)| loads.is_some());
    let axes: Vec<_> = axes.map(|(_, axis)| *axis).collect();
    let n_rows = known().next().map_or(0, <[f64]>::len);
    let loads: Vec<f64> =
        (0..n_rows).flat_map(|row| known().map(move |column| column[row])).collect();
    let of = load_cases(&loads, &axes);
    let mut rows = vec![Vec::new(); of.iter().max().map_or(0, |last| last + 1)];
    for (row, case) in of.into_iter().enumerate() {
        rows[case].push(row);
    }
    rows
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
