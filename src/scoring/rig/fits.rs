//! Least squares from the sums of units: held-out loads from gauges, and gauges from loads.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, MatRef, Side};

use crate::recording::Axis;
use crate::scoring::rig::Unit;

/// Addition to the diagonal of sums of columns of unit length, so that repeated columns do no harm.
const NOTHING: f64 = 1e-9;
/// Minimum variance of a gauge in a weighting, relative to that of its whole signal.
const EXACT: f64 = 1e-10;
/// Minimum number of runs that are held out in turn; with fewer, units are held out.
pub(super) const FEWEST_RUNS: usize = 3;

/// Columns of the sums: one, time, gauges, and loads over full scale.
#[derive(Clone, Debug)]
pub(super) struct Shape {
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

    /// Returns the columns one, time if it is included, and loads.
    pub fn inputs(&self, with_time: bool) -> Vec<usize> {
        [0].into_iter().chain(with_time.then_some(1)).chain(self.loads()).collect()
    }

    fn loads(&self) -> std::ops::Range<usize> {
        self.load(0)..self.width()
    }

    fn gauges(&self) -> std::ops::Range<usize> {
        self.gauge(0)..self.load(0)
    }

    /// Returns the change that leaves the columns as they are.
    pub fn unchanged(&self) -> Mat<f64> {
        Mat::identity(self.width(), self.width())
    }
}

impl Unit {
    pub(super) fn changed(&self, change: &Mat<f64>) -> Self {
        Self { run: self.run, sums: changed(&self.sums, change) }
    }
}

/// Returns the sums of changed columns. Each row of `change` is one changed column.
pub(super) fn changed(sums: &Mat<f64>, change: &Mat<f64>) -> Mat<f64> {
    change * sums * change.transpose()
}

/// Returns the factors of `inputs` that fit `outputs` best, one row for each input.
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

/// Returns the squared residual of an output in some sums.
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

/// Returns the sums of products of two columns around their means.
pub(super) fn product(sums: &Mat<f64>, i: usize, j: usize) -> f64 {
    sums[(i, j)] - sums[(i, 0)] * sums[(0, j)] / sums[(0, 0)]
}

pub(super) fn sum<'a>(units: impl Iterator<Item = &'a Unit>, shape: &Shape) -> Mat<f64> {
    units.fold(Mat::zeros(shape.width(), shape.width()), |all, unit| all + &unit.sums)
}

/// Returns the sums of squared held-out errors of each unit over all axes, each over full scale.
pub(super) fn left_out(units: &[Unit], shape: &Shape) -> Vec<f64> {
    let (inputs, outputs) = (with_one(shape.gauges()), shape.loads());
    let n_runs = units.last().map_or(0, |unit| unit.run + 1);
    let by_run = n_runs >= FEWEST_RUNS;
    let part = |unit: usize| if by_run { units[unit].run } else { unit };
    let n_parts = if by_run { n_runs } else { units.len() };
    let mut errors = vec![0.0; units.len()];
    for left_out in 0..n_parts {
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

fn with_one(columns: std::ops::Range<usize>) -> Vec<usize> {
    [0].into_iter().chain(columns).collect()
}

/// Returns the root mean square over the units of some runs.
pub(super) fn mean_error(errors: &[f64], units: &[Unit], wanted: impl Fn(usize) -> bool) -> f64 {
    let own = || units.iter().zip(errors).filter(|(unit, _)| wanted(unit.run));
    let n: f64 = own().map(|(unit, _)| unit.sums[(0, 0)]).sum();
    (own().map(|(_, error)| error).sum::<f64>() / n.max(1.0)).sqrt()
}

/// Returns the map from gauges to loads without the constant: one row for each axis.
pub(super) fn backward(sums: &Mat<f64>, shape: &Shape) -> Mat<f64> {
    let found = solved(sums.as_ref(), &with_one(shape.gauges()), shape.loads());
    Mat::from_fn(shape.axes.len(), shape.n_gauges, |axis, gauge| found[(1 + gauge, axis)])
}

/// Map of `gauge = map · [1, load]`.
#[derive(Clone, Debug)]
pub(super) struct Forward {
    /// One row for each gauge: its zero, then its slopes.
    pub map: Mat<f64>,
    /// Drift of each gauge over the whole time; empty if not fitted.
    pub drift: Vec<f64>,
}

impl Forward {
    pub fn of(sums: &Mat<f64>, shape: &Shape) -> Self {
        Self::fitted(sums, shape, false)
    }

    /// Fits with a drift of each gauge over the whole time.
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

    /// Returns the mean residual of each gauge in these samples.
    pub fn zeros(&self, sums: &Mat<f64>, shape: &Shape) -> Vec<f64> {
        let of_gauge = |gauge: usize| {
            let said = shape.inputs(false).into_iter().enumerate();
            let said = said.map(|(at, input)| self.map[(gauge, at)] * sums[(0, input)]);
            (sums[(0, shape.gauge(gauge))] - said.sum::<f64>()) / sums[(0, 0)]
        };
        (0..shape.n_gauges).map(of_gauge).collect()
    }

    /// Returns the sum of the prediction from the slopes, its sum of squares, and its product with the gauge.
    pub fn said(&self, sums: &Mat<f64>, shape: &Shape, gauge: usize) -> [f64; 3] {
        let axes = 0..shape.axes.len();
        let slope = |axis: usize| self.map[(gauge, 1 + axis)];
        let along = |column: usize| -> f64 {
            axes.clone().map(|axis| slope(axis) * sums[(shape.load(axis), column)]).sum()
        };
        let squares = axes.clone().map(|axis| slope(axis) * along(shape.load(axis))).sum();
        [along(0), squares, along(shape.gauge(gauge))]
    }

    /// Returns zero and sensitivity (around the run's means) of a gauge in some samples of a run, each with its weight.
    pub fn shown(
        &self,
        sums: &Mat<f64>,
        run: &Mat<f64>,
        shape: &Shape,
        gauge: usize,
    ) -> [(f64, f64); 2] {
        let (n, at) = (sums[(0, 0)], shape.gauge(gauge));
        let [sum, squares, product] = self.said(sums, shape, gauge);
        let mean = self.said(run, shape, gauge)[0] / run[(0, 0)];
        let own_mean = run[(0, at)] / run[(0, 0)];
        let information = squares - 2.0 * mean * sum + n * mean * mean;
        let product = product - mean * sums[(0, at)] - own_mean * (sum - n * mean);
        let factor = match information > 1e-6 * n {
            true => (product / information, information),
            false => (0.0, 0.0),
        };
        // Without a load, the sensitivity of the others is used.
        [((sums[(0, at)] - sum) / n - self.map[(gauge, 0)], n), factor]
    }
}
