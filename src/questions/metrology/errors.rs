//! Metrology rows that summarise the errors of all samples: RMSE, largest error, 95 % error.

use crate::questions::metrology::figures::{Figure, Value};
use crate::questions::metrology::measured::AxisView;
use crate::questions::metrology::quantity::Quantity;
use crate::scoring::metrics::root_mean;
use crate::scoring::quantile::quantile;

/// Share of the samples whose absolute error must not exceed the figure "95 % error".
const COVERED: f64 = 0.95;

pub(crate) fn error_figures(view: &AxisView<'_>, output: usize) -> Vec<(Quantity, Figure)> {
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
