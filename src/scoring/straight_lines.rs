//! Linear fit of one channel by other channels, and deviation of samples from a straight line in time.

use faer::Mat;
use faer::linalg::solvers::SolveLstsq as _;

/// Returns the least-squares coefficients of the columns. A ridge shrinks those of the first `ridged` columns, because
/// channels may be collinear.
pub fn factors(
    n: usize,
    columns: usize,
    (ridged, ridge): (usize, f64),
    value: impl Fn(usize, usize) -> f64,
    target: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let rows = Mat::from_fn(n + ridged, columns, |row, column| match row.checked_sub(n) {
        None => value(row, column),
        Some(of) if of == column => ridge,
        Some(_) => 0.0,
    });
    let targets = Mat::from_fn(n + ridged, 1, |row, _| match row < n {
        true => target(row),
        false => 0.0,
    });
    let solved = rows.qr().solve_lstsq(targets);
    (0..columns).map(|column| solved[(column, 0)]).collect()
}

/// Returns the deviation of three successive samples from a straight line. It is divided by √6, so that it has the noise of
/// one sample.
pub fn bend([a, b, c]: [f64; 3]) -> f64 {
    (a - 2.0 * b + c).abs() / 6_f64.sqrt()
}
