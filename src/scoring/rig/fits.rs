//! Least squares from the sums of units: loads from gauges left out by run, gauges from loads.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, MatRef, Side};

use crate::recording::Axis;
use crate::scoring::rig::Unit;

/// Added to the diagonal of sums of columns of unit length, so that repeated columns do no harm.
const NOTHING: f64 = 1e-9;
/// Variance of a gauge, over that of its whole signal, below which it is as good as exact.
const EXACT: f64 = 1e-10;
/// Fewest runs that are left out in turn; of fewer, units are.
pub(super) const FEWEST_RUNS: usize = 3;

/// The columns of the sums: one, time, gauges, loads over full scale.
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

    fn inputs(&self, with_time: bool) -> Vec<usize> {
        let time = with_time.then_some(1);
        [0].into_iter().chain(time).chain((0..self.n_gauges).map(|at| self.gauge(at))).collect()
    }

    fn outputs(&self) -> Vec<usize> {
        (0..self.axes.len()).map(|at| self.load(at)).collect()
    }
}

/// Factors of `inputs` that come nearest to `outputs`, one row for each input.
fn solved(sums: MatRef<'_, f64>, inputs: &[usize], outputs: &[usize]) -> Mat<f64> {
    let length = |at: usize| sums[(at, at)].max(f64::MIN_POSITIVE).sqrt();
    let lengths: Vec<f64> = inputs.iter().map(|at| length(*at)).collect();
    let n = inputs.len();
    let gram = Mat::from_fn(n, n, |i, j| {
        let own = sums[(inputs[i], inputs[j])] / (lengths[i] * lengths[j]);
        if i == j { own + NOTHING } else { own }
    });
    let right = Mat::from_fn(n, outputs.len(), |i, j| sums[(inputs[i], outputs[j])] / lengths[i]);
    let found = match gram.llt(Side::Lower) {
        Ok(parts) => parts.solve(&right),
        Err(_) => gram.partial_piv_lu().solve(&right),
    };
    Mat::from_fn(n, outputs.len(), |i, j| found[(i, j)] / lengths[i])
}

/// Factors of the first four columns that come nearest to the fifth.
pub(super) fn line(sums: &Mat<f64>) -> [f64; 4] {
    let found = solved(sums.as_ref(), &[0, 1, 2, 3], &[4]);
    [0, 1, 2, 3].map(|at| found[(at, 0)])
}

/// What a fit leaves of an output in some sums.
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

/// Returns the sums over some units.
pub(super) fn sum<'a>(units: impl Iterator<Item = &'a Unit>, shape: &Shape) -> Mat<f64> {
    units.fold(Mat::zeros(shape.width(), shape.width()), |all, unit| all + &unit.sums)
}

/// Sums of squared left-out errors over all axes, each over full scale, of each unit.
pub(super) fn left_out(units: &[Unit], shape: &Shape, by_run: bool, with_time: bool) -> Vec<f64> {
    let (inputs, outputs) = (shape.inputs(with_time), shape.outputs());
    let n_runs = units.last().map_or(0, |unit| unit.run + 1);
    let by_run = by_run && n_runs >= FEWEST_RUNS;
    let part = |unit: usize| if by_run { units[unit].run } else { unit };
    let n_parts = if by_run { n_runs } else { units.len() };
    let mut errors = vec![0.0; units.len()];
    for left_out in 0..n_parts {
        let others = (0..units.len()).filter(|unit| part(*unit) != left_out);
        let others = sum(others.map(|unit| &units[unit]), shape);
        let factors = solved(others.as_ref(), &inputs, &outputs);
        for unit in (0..units.len()).filter(|unit| part(*unit) == left_out) {
            let of_axes = outputs.iter().enumerate().map(|(axis, output)| {
                residual(units[unit].sums.as_ref(), &inputs, |at| factors[(at, axis)], *output)
            });
            errors[unit] = of_axes.sum::<f64>() / outputs.len() as f64;
        }
    }
    errors
}

/// Root mean square over the units of some runs.
pub(super) fn mean_error(errors: &[f64], units: &[Unit], wanted: impl Fn(usize) -> bool) -> f64 {
    let own = || units.iter().zip(errors).filter(|(unit, _)| wanted(unit.run));
    let n: f64 = own().map(|(unit, _)| unit.sums[(0, 0)]).sum();
    (own().map(|(_, error)| error).sum::<f64>() / n.max(1.0)).sqrt()
}

/// Loads from gauges, without the constant: one row for each axis.
pub(super) fn backward(sums: &Mat<f64>, shape: &Shape) -> Mat<f64> {
    let found = solved(sums.as_ref(), &shape.inputs(false), &shape.outputs());
    Mat::from_fn(shape.axes.len(), shape.n_gauges, |axis, gauge| found[(1 + gauge, axis)])
}

/// `gauge = zero + slopes · load`.
#[derive(Clone, Debug)]
pub(super) struct Forward {
    pub zero: Vec<f64>,
    /// One row for each gauge.
    pub slopes: Mat<f64>,
    /// Change of each gauge over the whole time; empty unless it was asked for.
    pub drift: Vec<f64>,
}

/// What a gauge shows of what the fit says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer {
    pub zero: f64,
    pub factor: f64,
    /// Mean of what the fit says, which the zero is not of.
    mean: f64,
    /// Samples, and their sum of squares of what the fit says about its mean.
    pub weight: f64,
    pub information: f64,
}

impl Forward {
    pub fn of(sums: &Mat<f64>, shape: &Shape) -> Self {
        Self::fitted(sums, shape, false)
    }

    /// With a drift of each gauge over the whole time.
    pub fn with_drift(sums: &Mat<f64>, shape: &Shape) -> Self {
        Self::fitted(sums, shape, true)
    }

    fn fitted(sums: &Mat<f64>, shape: &Shape, with_time: bool) -> Self {
        let time = with_time.then_some(1);
        let inputs: Vec<usize> = [0].into_iter().chain(time).chain(shape.outputs()).collect();
        let gauges: Vec<usize> = (0..shape.n_gauges).map(|at| shape.gauge(at)).collect();
        let found = solved(sums.as_ref(), &inputs, &gauges);
        let first = inputs.len() - shape.axes.len();
        Self {
            zero: (0..shape.n_gauges).map(|gauge| found[(0, gauge)]).collect(),
            slopes: Mat::from_fn(shape.n_gauges, shape.axes.len(), |gauge, axis| {
                found[(first + axis, gauge)]
            }),
            drift: time.iter().flat_map(|_| (0..shape.n_gauges).map(|at| found[(1, at)])).collect(),
        }
    }

    /// Mean squares that the fit leaves of each gauge.
    pub fn variances(&self, sums: &Mat<f64>, shape: &Shape) -> Vec<f64> {
        let inputs: Vec<usize> = [0].into_iter().chain(shape.outputs()).collect();
        let of_gauge = |gauge: usize| {
            let factor = |at: usize| match at {
                0 => self.zero[gauge],
                _ => self.slopes[(gauge, at - 1)],
            };
            let left = residual(sums.as_ref(), &inputs, factor, shape.gauge(gauge));
            (left / sums[(0, 0)]).max(EXACT)
        };
        (0..shape.n_gauges).map(of_gauge).collect()
    }

    /// What each gauge shows beyond the fit in the mean of these samples.
    pub fn zeros(&self, sums: &Mat<f64>, shape: &Shape) -> Vec<f64> {
        let of_gauge = |gauge: usize| {
            let loads = (0..shape.axes.len())
                .map(|axis| self.slopes[(gauge, axis)] * sums[(0, shape.load(axis))]);
            (sums[(0, shape.gauge(gauge))] - loads.sum::<f64>()) / sums[(0, 0)] - self.zero[gauge]
        };
        (0..shape.n_gauges).map(of_gauge).collect()
    }

    /// Sum, sum of squares, and product with the gauge of what the slopes say of it.
    fn said(&self, sums: &Mat<f64>, shape: &Shape, gauge: usize) -> [f64; 3] {
        let axes = 0..shape.axes.len();
        let slope = |axis: usize| self.slopes[(gauge, axis)];
        let along = |column: usize| -> f64 {
            axes.clone().map(|axis| slope(axis) * sums[(shape.load(axis), column)]).sum()
        };
        let squares = axes.clone().map(|axis| slope(axis) * along(shape.load(axis))).sum();
        [along(0), squares, along(shape.gauge(gauge))]
    }

    /// A straight line of a gauge over what the fit says of it.
    pub fn answer(&self, sums: &Mat<f64>, shape: &Shape, gauge: usize) -> Answer {
        let n = sums[(0, 0)];
        let [sum, squares, product] = self.said(sums, shape, gauge);
        let own = sums[(0, shape.gauge(gauge))];
        let information = squares - sum * sum / n;
        let is_known = information > 1e-6 * n;
        let factor = if is_known { (product - sum * own / n) / information } else { 1.0 };
        Answer {
            // Without a load, by the sensitivity that the others have.
            zero: (own - sum) / n - self.zero[gauge],
            factor,
            mean: sum / n,
            weight: n,
            information: if is_known { information } else { 0.0 },
        }
    }

    /// How far a unit is from the line of its run: zero and factor, each with its weight.
    pub fn about(
        &self,
        sums: &Mat<f64>,
        shape: &Shape,
        gauge: usize,
        line: &Answer,
    ) -> [(f64, f64); 2] {
        let n = sums[(0, 0)];
        let [sum, squares, product] = self.said(sums, shape, gauge);
        let own = sums[(0, shape.gauge(gauge))];
        let zero = (own - sum) / n - self.zero[gauge] - line.zero;
        let information = squares - 2.0 * line.mean * sum + n * line.mean * line.mean;
        // The line goes through the mean of its run.
        let at_mean = line.zero + self.zero[gauge] + line.mean;
        let rest = product - line.mean * own - at_mean * (sum - n * line.mean);
        let factor = if information > 0.0 { rest / information - line.factor } else { 0.0 };
        [(zero, n), (factor, information.max(0.0))]
    }
}
