//! Metrology rows on the errors over all samples.

use crate::questions::metrology::figures::{Found, Result};
use crate::questions::metrology::measured::AxisView;
use crate::questions::metrology::quantity::Quantity;
use crate::scoring::metrics::root_mean;
use crate::scoring::quantile::quantile;

/// Share of the samples that the 95 % error covers.
const COVERED: f64 = 0.95;

pub(crate) fn error_figures(view: &AxisView<'_>, output: usize) -> Vec<(Quantity, Result<Found>)> {
    let n = view.runs.iter().map(|run| run.loads.len()).sum();
    let mut sizes: Vec<f64> = Vec::with_capacity(n);
    let (mut squares, mut largest, mut place) = (0.0, -1.0, None);
    for run in &view.runs {
        for (k, error) in run.errors(output, 0..run.loads.len()).enumerate() {
            let size = error.abs();
            squares += error * error;
            sizes.push(size);
            if size > largest {
                largest = size;
                place = Some((run, k));
            }
        }
    }
    let rmse = root_mean(&[squares], n as u64).map_or(f64::NAN, |rmse| rmse[0]);
    let covered = quantile(&mut sizes, COVERED).unwrap_or(f64::NAN);
    let place = place.map(|(run, k)| run.place(k..k + 1));
    vec![
        (Quantity::Rmse, Ok(Found::everywhere(rmse))),
        (Quantity::LargestError, Ok(Found::at(largest, place))),
        (Quantity::Error95, Ok(Found::everywhere(covered))),
    ]
}
