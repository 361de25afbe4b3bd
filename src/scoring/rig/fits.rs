//! Least squares from sums of products over units (parts of recordings). Loads are fitted to gauges and judged on held-out
//! units, and gauges are fitted to loads.

use std::ops::Range;

use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};

use crate::{
    recording::{Axis, Recording},
    scoring::rig::Unit,
};

/// Number added to the diagonal of the normal equations of scaled columns. With it they can be solved even if a column is
/// repeated.
const NOTHING: f64 = 1e-9;
/// Minimum residual variance that is used to weight a gauge, as a share of the variance of the gauge's signal.
const EXACT: f64 = 1e-10;
/// Minimum number of runs (recordings) for a cross-validation that holds out runs in turn. With fewer runs, it holds out
/// units (parts of recordings).
pub const FEWEST_RUNS: usize = 3;

/// Maximum ratio of the summed squared loads of one run to those of the other runs, along any combination of axes, for which
/// the run is compared with them. Above this ratio, the loads of the other runs along that combination are below a thirtieth
/// of this run's load, so they may be only noise and rounding.
const UNJUDGED: f64 = 1000.0;

/// Order of the columns in the sums of products: one, time, gauges, and loads divided by full scale.
#[derive(Clone, Debug)]
pub struct Shape {
    pub n_gauges: usize,
    pub axes: Vec<Axis>,
    pub full_scale: Vec<f64>,
}

impl Shape {
    pub fn width(&self) -> usize {
        2 + self.n_gauges + self.axes.len()
    }

    pub fn gauge(&self, gauge: usize) -> usize {
        2 + gauge
    }

    pub fn load(&self, axis: usize) -> usize {
        2 + self.n_gauges + axis
    }

    /// Returns the indices of the column of ones and of the load columns.
    pub fn inputs(&self) -> Vec<usize> {
        with_one(self.load(0)..self.width())
    }

    /// Returns the index of each axis among the axes of a recording.
    pub fn axes_in(&self, recording: &Recording) -> Vec<usize> {
        let at = |axis: &Axis| recording.axes().iter().position(|known| known == axis);
        self.axes.iter().filter_map(at).collect()
    }

    /// Returns the matrix that leaves the columns of a sample unchanged.
    pub fn unchanged(&self) -> Mat<f64> {
        Mat::identity(self.width(), self.width())
    }
}

pub fn with_one(columns: Range<usize>) -> Vec<usize> {
    [0].into_iter().chain(columns).collect()
}

impl Unit {
    pub fn changed(&self, change: &Mat<f64>) -> Self {
        Self { run: self.run, sums: changed(&self.sums, change) }
    }
}

/// Returns the sums of products after the columns were changed by a matrix. Each row of `change` makes one new column from
/// the old ones.
pub fn changed(sums: &Mat<f64>, change: &Mat<f64>) -> Mat<f64> {
    change * sums * change.transpose()
}

pub fn sum<'a>(units: impl Iterator<Item = &'a Unit>, shape: &Shape) -> Mat<f64> {
    units.fold(Mat::zeros(shape.width(), shape.width()), |all, unit| all + &unit.sums)
}

pub fn column_means(sums: &Mat<f64>) -> Vec<f64> {
    (0..sums.ncols()).map(|at| sums[(0, at)] / sums[(0, 0)].max(f64::MIN_POSITIVE)).collect()
}

/// Least-squares fit of several columns.
#[derive(Debug)]
pub struct Fit {
    /// Coefficients: one row for each fitted column, first its constant.
    pub map: Mat<f64>,
    /// For each fitted column, the weights of all columns whose sum is its residual.
    pub residual: Mat<f64>,
}

impl Fit {
    pub fn of(sums: &Mat<f64>, inputs: &[usize], outputs: Range<usize>) -> Self {
        let length = |at: usize| sums[(at, at)].max(f64::MIN_POSITIVE).sqrt();
        let lengths: Vec<f64> = inputs.iter().map(|at| length(*at)).collect();
        let n = inputs.len();
        let gram = Mat::from_fn(n, n, |i, j| {
            let product = sums[(inputs[i], inputs[j])] / (lengths[i] * lengths[j]);
            if i == j { product + NOTHING } else { product }
        });
        let right = Mat::from_fn(n, outputs.len(), |i, j| {
            sums[(inputs[i], outputs.start + j)] / lengths[i]
        });
        let found = match gram.llt(Side::Lower) {
            Ok(parts) => parts.solve(&right),
            Err(_) => gram.partial_piv_lu().solve(&right),
        };
        let map = Mat::from_fn(outputs.len(), n, |output, i| found[(i, output)] / lengths[i]);
        let mut residual = Mat::zeros(sums.ncols(), outputs.len());
        for (at, output) in outputs.enumerate() {
            residual[(output, at)] = 1.0;
            inputs.iter().enumerate().for_each(|(i, input)| residual[(*input, at)] -= map[(at, i)]);
        }
        Self { map, residual }
    }

    /// Fits the gauges to the loads.
    pub fn forward(sums: &Mat<f64>, shape: &Shape) -> Self {
        Self::of(sums, &shape.inputs(), shape.gauge(0)..shape.load(0))
    }

    /// Fits the gauges to the loads and the time, whose coefficients are the last ones.
    pub fn with_drift(sums: &Mat<f64>, shape: &Shape) -> Self {
        Self::of(sums, &[shape.inputs(), vec![1]].concat(), shape.gauge(0)..shape.load(0))
    }

    /// Fits the loads to the gauges.
    pub fn backward(sums: &Mat<f64>, shape: &Shape) -> Self {
        Self::of(sums, &with_one(shape.gauge(0)..shape.load(0)), shape.load(0)..shape.width())
    }

    /// Returns the sum of squared residuals of each fitted column over these sums.
    pub fn squares(&self, sums: &Mat<f64>) -> Vec<f64> {
        let products = sums * &self.residual;
        let pairs = self.residual.col_iter().zip(products.col_iter());
        pairs.map(|(weights, products)| (weights.transpose() * products).max(0.0)).collect()
    }

    /// Returns the mean squared residual of each gauge, by which it is weighted.
    pub fn variances(&self, sums: &Mat<f64>) -> Vec<f64> {
        self.squares(sums).into_iter().map(|square| (square / sums[(0, 0)]).max(EXACT)).collect()
    }

    /// Returns the mean residual of each fitted column over these sums.
    pub fn means(&self, sums: &Mat<f64>) -> Vec<f64> {
        self.residual.col_iter().map(|weights| sums.row(0) * weights / sums[(0, 0)]).collect()
    }

    /// Returns the matrix that gives the loads of gauges minus their zeros, one row for each axis: the least squares of the
    /// gauges.
    pub fn inverse(&self, shape: &Shape) -> Mat<f64> {
        let n = shape.axes.len();
        let slopes = self.map.subcols(1, n);
        let squares = slopes.transpose() * slopes;
        let largest = (0..n).map(|axis| squares[(axis, axis)]).fold(f64::MIN_POSITIVE, f64::max);
        let nearly = squares + faer::Scale(NOTHING * largest) * Mat::<f64>::identity(n, n);
        nearly.partial_piv_lu().solve(slopes.transpose())
    }
}

/// Maximum share of the squared changes of zeros that lies outside what loads can cause, if the zero of the reference changed
/// instead. It is a share of what it would be if the zeros of the gauges changed at random.
const OUTSIDE: f64 = 0.003;

/// Returns true if changes of the gauges' zeros look like loads, as if the zero of the reference had changed. With no more gauges
/// than axes, all changes look like loads, and it returns false.
pub fn look_like_loads(zeros: &[Vec<f64>], forward: &Fit, shape: &Shape) -> bool {
    let (n_gauges, n_axes) = (shape.n_gauges, shape.axes.len());
    let inverse = forward.inverse(shape);
    let (mut outside, mut all) = (0.0, 0.0);
    for zeros in zeros {
        let zeros = Mat::from_fn(n_gauges, 1, |gauge, _| zeros[gauge]);
        let loads = forward.map.subcols(1, n_axes) * (&inverse * &zeros);
        outside += (&zeros - loads).squared_norm_l2();
        all += zeros.squared_norm_l2();
    }
    let by_chance = n_gauges.saturating_sub(n_axes) as f64 / n_gauges as f64;
    outside < OUTSIDE * by_chance * all
}

/// Returns for each unit the sum of squared held-out errors, as shares of full scale, averaged over the axes. Runs are held
/// out as a whole, or unit by unit if there are few runs, or if a run alone loads an axis.
pub fn left_out(units: &[Unit], shape: &Shape) -> Vec<f64> {
    let n_runs = units.last().map_or(0, |unit| unit.run + 1);
    let by_run = |run: usize| {
        let [own, others] = [true, false]
            .map(|is_own| sum(units.iter().filter(|unit| (unit.run == run) == is_own), shape));
        n_runs >= FEWEST_RUNS && is_loaded(&own, &others, shape)
    };
    let by_run: Vec<bool> = (0..n_runs).map(by_run).collect();
    let parts = units.iter().enumerate();
    let parts = parts.map(|(at, unit)| if by_run[unit.run] { unit.run } else { n_runs + at });
    let parts: Vec<usize> = parts.collect();
    let mut fits: Vec<(usize, Fit)> = Vec::new();
    let mut errors = Vec::with_capacity(units.len());
    for (unit, part) in units.iter().zip(&parts) {
        // Units of one run follow each other.
        if fits.last().is_none_or(|(known, _)| known != part) {
            let others = units.iter().zip(&parts).filter(|(_, other)| *other != part);
            fits.push((*part, Fit::backward(&sum(others.map(|(other, _)| other), shape), shape)));
        }
        let squares = fits.last().map(|(_, fit)| fit.squares(&unit.sums)).unwrap_or_default();
        errors.push(squares.iter().sum::<f64>() / shape.axes.len() as f64);
    }
    errors
}

/// Returns true if the others have loads in all directions in which one run has loads; see [`UNJUDGED`].
pub fn is_loaded(own: &Mat<f64>, others: &Mat<f64>, shape: &Shape) -> bool {
    let (first, n) = (shape.load(0), shape.axes.len());
    let loads = |sums: &Mat<f64>| sums.submatrix(first, first, n, n).to_owned();
    let left = faer::Scale(UNJUDGED) * loads(others) - loads(own);
    let ends = left.self_adjoint_eigenvalues(Side::Lower);
    // An axis without any load gives a zero, which is rounded.
    ends.is_ok_and(|ends| ends[0] >= -1e-12 * ends[ends.len() - 1].abs())
}

/// Returns the root mean square of the held-out errors over the units of the wanted runs.
pub fn mean_error(errors: &[f64], units: &[Unit], wanted: impl Fn(usize) -> bool) -> f64 {
    let own = || units.iter().zip(errors).filter(|(unit, _)| wanted(unit.run));
    let n: f64 = own().map(|(unit, _)| unit.sums[(0, 0)]).sum();
    (own().map(|(_, error)| error).sum::<f64>() / n.max(1.0)).sqrt()
}

/// Sums of products of columns minus a given mean: of the columns one and loads with each other, and of the gauges' residuals
/// with these columns.
pub struct Moments {
    loads: Mat<f64>,
    rest: Mat<f64>,
}

impl Moments {
    pub fn about(sums: &Mat<f64>, mean: &[f64], fit: &Fit, shape: &Shape) -> Self {
        let centred = Mat::from_fn(sums.nrows(), sums.ncols(), |i, j| {
            sums[(i, j)] - sums[(i, 0)] * mean[j] - mean[i] * sums[(0, j)]
                + sums[(0, 0)] * mean[i] * mean[j]
        });
        let inputs = shape.inputs();
        let products = &centred * &fit.residual;
        let n = inputs.len();
        Self {
            loads: Mat::from_fn(n, n, |i, j| centred[(inputs[i], inputs[j])]),
            rest: Mat::from_fn(shape.n_gauges, n, |gauge, j| products[(inputs[j], gauge)]),
        }
    }

    /// Returns the least-squares sizes of these changes of the gauges, the reduction of the squared residuals divided by the
    /// variances, and the weight of the sizes. Returns `None` if the data do not determine the sizes.
    pub fn step(&self, ways: &[Mat<f64>], variances: &[f64]) -> Option<(Vec<f64>, f64, f64)> {
        let n = ways.len();
        let product =
            |i: usize, j: usize| over_variances(&ways[i], &(&ways[j] * &self.loads), variances);
        let products = Mat::from_fn(n, n, product);
        let right = Mat::from_fn(n, 1, |i, _| over_variances(&ways[i], &self.rest, variances));
        let diagonal = || (0..n).map(|i| products[(i, i)]);
        let largest = diagonal().fold(0.0, f64::max);
        if n == 0 || largest.is_nan() || largest <= 1e-9 {
            return None;
        }
        let nearly =
            Mat::from_fn(n, n, |i, j| products[(i, j)] + if i == j { 1e-6 * largest } else { 0.0 });
        let step = nearly.llt(Side::Lower).ok()?.solve(&right);
        let gain = (0..n).map(|i| step[(i, 0)] * right[(i, 0)]).sum();
        Some(((0..n).map(|i| step[(i, 0)]).collect(), gain, diagonal().sum()))
    }

    /// Returns the ratio of a gauge's sensitivity to that of a fit, and its weight: the sum of squares of the predicted
    /// signal.
    pub fn sensitivity(&self, gauge: usize, fit: &Fit) -> (f64, f64) {
        let slopes = fit.map.row(gauge);
        let weight = slopes * &self.loads * slopes.transpose();
        (1.0 + self.rest.row(gauge) * slopes.transpose() / weight, weight)
    }
}

/// Returns the sum of the products of the entries of two matrices, each row divided by the variance of its gauge.
fn over_variances(one: &Mat<f64>, other: &Mat<f64>, variances: &[f64]) -> f64 {
    let rows = one.row_iter().zip(other.row_iter()).zip(variances);
    rows.map(|((one, other), variance)| one * other.transpose() / variance).sum()
}
