//! Least squares from sums of products over units (parts of recordings). Loads are fitted to gauges and judged on held-out
//! units, and gauges are fitted to loads.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, MatRef, Side};

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

    /// Returns the indices of the columns one, time (if included) and loads.
    pub fn inputs(&self, with_time: bool) -> Vec<usize> {
        [0].into_iter().chain(with_time.then_some(1)).chain(self.loads()).collect()
    }

    fn loads(&self) -> std::ops::Range<usize> {
        self.load(0)..self.width()
    }

    fn gauges(&self) -> std::ops::Range<usize> {
        self.gauge(0)..self.load(0)
    }

    /// Returns the index of each axis among the axes of a recording.
    pub fn axes_in(&self, recording: &Recording) -> Vec<usize> {
        let at = |axis: &Axis| recording.axes().iter().position(|own| own == axis);
        self.axes.iter().filter_map(at).collect()
    }

    /// Returns the matrix that leaves the columns of a sample unchanged.
    pub fn unchanged(&self) -> Mat<f64> {
        Mat::identity(self.width(), self.width())
    }
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

/// Returns the coefficients of the least-squares fit of the columns `outputs` to the columns `inputs`, one row for each
/// input.
fn solved(sums: MatRef<'_, f64>, inputs: &[usize], outputs: std::ops::Range<usize>) -> Mat<f64> {
    let length = |at: usize| sums[(at, at)].max(f64::MIN_POSITIVE).sqrt();
    let lengths: Vec<f64> = inputs.iter().map(|at| length(*at)).collect();
    let n = inputs.len();
    let gram = Mat::from_fn(n, n, |i, j| {
        let own = sums[(inputs[i], inputs[j])] / (lengths[i] * lengths[j]);
        if i == j { own + NOTHING } else { own }
    });
    let right =
        Mat::from_fn(n, outputs.len(), |i, j| sums[(inputs[i], outputs.start + j)] / lengths[i]);
    let found = match gram.llt(Side::Lower) {
        Ok(parts) => parts.solve(&right),
        Err(_) => gram.partial_piv_lu().solve(&right),
    };
    Mat::from_fn(n, outputs.len(), |i, j| found[(i, j)] / lengths[i])
}

/// Returns the sum of squared residuals of an output column that is fitted by these coefficients of the input columns.
fn residual(
    sums: MatRef<'_, f64>,
    inputs: &[usize],
    factor: impl Fn(usize) -> f64,
    output: usize,
) -> f64 {
    let explained: f64 = (inputs.iter().enumerate())
        .map(|(i, one)| {
            let own: f64 = (inputs.iter().enumerate())
                .map(|(j, other)| factor(j) * sums[(*one, *other)])
                .sum();
            factor(i) * (own - 2.0 * sums[(*one, output)])
        })
        .sum();
    (sums[(output, output)] + explained).max(0.0)
}

/// Returns the sum of products of two columns after subtraction of their means.
pub fn product(sums: &Mat<f64>, i: usize, j: usize) -> f64 {
    sums[(i, j)] - sums[(i, 0)] * sums[(0, j)] / sums[(0, 0)]
}

pub fn sum<'a>(units: impl Iterator<Item = &'a Unit>, shape: &Shape) -> Mat<f64> {
    units.fold(Mat::zeros(shape.width(), shape.width()), |all, unit| all + &unit.sums)
}

/// Returns for each unit the sum of squared held-out errors, as shares of full scale, averaged over the axes. Runs are held
/// out as a whole, or unit by unit if there are few runs, or if a run alone loads an axis.
pub fn left_out(units: &[Unit], shape: &Shape) -> Vec<f64> {
    let (inputs, outputs) = (with_one(shape.gauges()), shape.loads());
    let n_runs = units.last().map_or(0, |unit| unit.run + 1);
    let by_run = |run: &usize| {
        let [own, others] = [true, false]
            .map(|is_own| sum(units.iter().filter(|unit| (unit.run == *run) == is_own), shape));
        n_runs >= FEWEST_RUNS && is_loaded(&own, &others, shape)
    };
    let by_run: Vec<bool> = (0..n_runs).map(|run| by_run(&run)).collect();
    let part = |unit: usize| {
        let run = units[unit].run;
        if by_run[run] { run } else { n_runs + unit }
    };
    let mut errors = vec![0.0; units.len()];
    for left_out in 0..n_runs + units.len() {
        if (0..units.len()).all(|unit| part(unit) != left_out) {
            continue;
        }
        let others = (0..units.len()).filter(|unit| part(*unit) != left_out);
        let others = sum(others.map(|unit| &units[unit]), shape);
        let factors = solved(others.as_ref(), &inputs, outputs.clone());
        for unit in (0..units.len()).filter(|unit| part(*unit) == left_out) {
            let of_axes = outputs.clone().enumerate().map(|(axis, output)| {
                residual(units[unit].sums.as_ref(), &inputs, |at| factors[(at, axis)], output)
            });
            errors[unit] = of_axes.sum::<f64>() / outputs.len() as f64;
        }
    }
    errors
}

/// Returns true if the others have loads in all directions in which one run has loads; see [`UNJUDGED`].
pub fn is_loaded(own: &Mat<f64>, others: &Mat<f64>, shape: &Shape) -> bool {
    let first = shape.load(0);
    let loads = |sums: &Mat<f64>| -> Mat<f64> {
        let n = shape.axes.len();
        Mat::from_fn(n, n, |i, j| sums[(first + i, first + j)])
    };
    let left = faer::Scale(UNJUDGED) * loads(others) - loads(own);
    let ends = left.self_adjoint_eigenvalues(Side::Lower);
    // An axis without any load gives a zero, which is rounded.
    ends.is_ok_and(|ends| ends[0] >= -1e-12 * ends[ends.len() - 1].abs())
}

fn with_one(columns: std::ops::Range<usize>) -> Vec<usize> {
    [0].into_iter().chain(columns).collect()
}

/// Returns the root mean square of the held-out errors over the units of the wanted runs.
pub fn mean_error(errors: &[f64], units: &[Unit], wanted: impl Fn(usize) -> bool) -> f64 {
    let own = || units.iter().zip(errors).filter(|(unit, _)| wanted(unit.run));
    let n: f64 = own().map(|(unit, _)| unit.sums[(0, 0)]).sum();
    (own().map(|(_, error)| error).sum::<f64>() / n.max(1.0)).sqrt()
}

/// Returns the RMS error over all axes of the least-squares fit from gauges to loads with this number of constants.
pub fn fit_error(sums: &Mat<f64>, n_constants: usize, shape: &Shape) -> f64 {
    let (inputs, outputs) = (with_one(shape.gauges()), shape.loads());
    let found = solved(sums.as_ref(), &inputs, outputs.clone());
    let squares = outputs
        .clone()
        .enumerate()
        .map(|(axis, output)| residual(sums.as_ref(), &inputs, |at| found[(at, axis)], output));
    let freedom = (sums[(0, 0)] - (shape.n_gauges + n_constants) as f64).max(1.0);
    (squares.sum::<f64>() / freedom / outputs.len() as f64).sqrt()
}

/// Returns the matrix of the least-squares fit from gauges to loads, without its constant: one row for each axis.
pub fn backward(sums: &Mat<f64>, shape: &Shape) -> Mat<f64> {
    let found = solved(sums.as_ref(), &with_one(shape.gauges()), shape.loads());
    Mat::from_fn(shape.axes.len(), shape.n_gauges, |axis, gauge| found[(1 + gauge, axis)])
}

/// Returns the mean excess of the predicted over the recorded load of an axis in `samples`, and the RMS error of the fit to
/// `others`, by which the load is predicted. With too few samples for a prediction, the error is infinite.
pub fn excess(others: &Mat<f64>, samples: &Mat<f64>, axis: usize, shape: &Shape) -> (f64, f64) {
    let (inputs, output) = (with_one(shape.gauges()), shape.load(axis));
    let found = solved(others.as_ref(), &inputs, output..output + 1);
    let freedom = others[(0, 0)] - inputs.len() as f64;
    if freedom < inputs.len() as f64 {
        return (0.0, f64::INFINITY);
    }
    let squares = residual(others.as_ref(), &inputs, |at| found[(at, 0)], output);
    let predicted =
        inputs.iter().enumerate().map(|(at, input)| found[(at, 0)] * samples[(0, *input)]);
    let excess = predicted.sum::<f64>() - samples[(0, output)];
    (excess / samples[(0, 0)], (squares / freedom).sqrt())
}

/// Least-squares fit of the gauges to the loads: `gauge = map · [1, load]`.
#[derive(Debug)]
pub struct Forward {
    /// One row for each gauge: its zero, then its slope along each load axis.
    pub map: Mat<f64>,
    /// Drift of each gauge's zero from the first to the last sample; empty if no drift is fitted.
    pub drift: Vec<f64>,
}

impl Forward {
    pub fn of(sums: &Mat<f64>, shape: &Shape) -> Self {
        Self::fitted(sums, shape, false)
    }

    /// Fits the gauges to the loads, and for each gauge also a drift in proportion to time.
    pub fn with_drift(sums: &Mat<f64>, shape: &Shape) -> Self {
        Self::fitted(sums, shape, true)
    }

    fn fitted(sums: &Mat<f64>, shape: &Shape, with_time: bool) -> Self {
        let found = solved(sums.as_ref(), &shape.inputs(with_time), shape.gauges());
        let at = |input: usize| if input > 0 { input + usize::from(with_time) } else { 0 };
        let times = if with_time { 1..2 } else { 0..0 };
        Self {
            map: Mat::from_fn(shape.n_gauges, 1 + shape.axes.len(), |gauge, input| {
                found[(at(input), gauge)]
            }),
            drift: times.flat_map(|at| found.row(at).iter().copied().collect::<Vec<_>>()).collect(),
        }
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

    /// Returns the mean squared residual of each gauge.
    pub fn variances(&self, sums: &Mat<f64>, shape: &Shape) -> Vec<f64> {
        let inputs = shape.inputs(false);
        let of_gauge = |gauge: usize| {
            let factor = |at: usize| self.map[(gauge, at)];
            let left = residual(sums.as_ref(), &inputs, factor, shape.gauge(gauge));
            (left / sums[(0, 0)]).max(EXACT)
        };
        (0..shape.n_gauges).map(of_gauge).collect()
    }

    /// Returns the mean residual of each gauge over these sums.
    pub fn zeros(&self, sums: &Mat<f64>, shape: &Shape) -> Vec<f64> {
        let of_gauge = |gauge: usize| {
            let said = shape.inputs(false).into_iter().enumerate();
            let said = said.map(|(at, input)| self.map[(gauge, at)] * sums[(0, input)]);
            (sums[(0, shape.gauge(gauge))] - said.sum::<f64>()) / sums[(0, 0)]
        };
        (0..shape.n_gauges).map(of_gauge).collect()
    }
}

/// Sums of products of columns minus a given mean: of the columns one and loads with each other, and of the gauges' residuals
/// with these columns.
pub struct Moments {
    loads: Mat<f64>,
    rest: Mat<f64>,
}

impl Moments {
    pub fn about(sums: &Mat<f64>, mean: &[f64], fit: &Forward, shape: &Shape) -> Self {
        let centred = |i: usize, j: usize| {
            sums[(i, j)] - sums[(i, 0)] * mean[j] - mean[i] * sums[(0, j)]
                + sums[(0, 0)] * mean[i] * mean[j]
        };
        let inputs = shape.inputs(false);
        let n = inputs.len();
        let loads = Mat::from_fn(n, n, |i, j| centred(inputs[i], inputs[j]));
        let own = Mat::from_fn(shape.n_gauges, n, |i, j| centred(shape.gauge(i), inputs[j]));
        let rest = own - &fit.map * &loads;
        Self { loads, rest }
    }

    /// Returns the sum over the samples of the product of two changes of the gauges, divided by the residual variances of the
    /// gauges.
    pub fn square(&self, one: &Mat<f64>, other: &Mat<f64>, variances: &[f64]) -> f64 {
        over_variances(one, &(other * &self.loads), variances)
    }

    /// Returns the least-squares sizes of these changes of the gauges, and the reduction of the squared residuals divided by
    /// the variances. Returns `None` if the data do not determine the sizes.
    pub fn step(&self, ways: &[Mat<f64>], variances: &[f64]) -> Option<(Vec<f64>, f64)> {
        let n = ways.len();
        let products = Mat::from_fn(n, n, |i, j| self.square(&ways[i], &ways[j], variances));
        let right = Mat::from_fn(n, 1, |i, _| over_variances(&ways[i], &self.rest, variances));
        let largest = (0..n).map(|i| products[(i, i)]).fold(0.0, f64::max);
        if n == 0 || largest.is_nan() || largest <= 1e-9 {
            return None;
        }
        let nearly =
            Mat::from_fn(n, n, |i, j| products[(i, j)] + if i == j { 1e-6 * largest } else { 0.0 });
        let step = nearly.llt(faer::Side::Lower).ok()?.solve(&right);
        let gain = (0..n).map(|i| step[(i, 0)] * right[(i, 0)]).sum();
        Some(((0..n).map(|i| step[(i, 0)]).collect(), gain))
    }

    /// Returns the ratio of a gauge's sensitivity to that of a fit, and its weight: the sum of squares of the predicted
    /// signal.
    pub fn sensitivity(&self, gauge: usize, fit: &Forward) -> (f64, f64) {
        let slopes = fit.map.row(gauge);
        let weight = slopes * &self.loads * slopes.transpose();
        (1.0 + self.rest.row(gauge) * slopes.transpose() / weight, weight)
    }
}

/// Returns the sum of the products of the entries of two matrices, each row divided by the variance of its gauge.
fn over_variances(one: &Mat<f64>, other: &Mat<f64>, variances: &[f64]) -> f64 {
    let of_gauge = |gauge: usize| {
        let row = (0..one.ncols()).map(|axis| one[(gauge, axis)] * other[(gauge, axis)]);
        row.sum::<f64>() / variances[gauge]
    };
    (0..one.nrows()).map(of_gauge).sum()
}

pub fn column_means(sums: &Mat<f64>) -> Vec<f64> {
    (0..sums.ncols()).map(|at| sums[(0, at)] / sums[(0, 0)].max(f64::MIN_POSITIVE)).collect()
}
