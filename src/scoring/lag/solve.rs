//! Finds the lag that leaves the smallest residual in the fit of an output.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::solvers::Solve as _;
use faer::{Accum, Mat, MatRef, Par, Side};

use super::{
    grid::{AROUND_JUMP, Columns, Grids},
    kind::{LagKind, add_late_rows},
};
use crate::{
    dot::{dot, dot_of_long},
    scoring::inverse::inverse_above,
};

/// Minimum eigenvalue of the scaled normal matrix, as a share of its largest eigenvalue. Coefficients along directions with
/// smaller eigenvalues are set to zero.
const LEAST_DIRECTION: f64 = 1e-11;
/// Largest product of the number of columns and the norm of the inverse for which the inverse is computed without eigenvalues,
/// which takes much less time. Each eigenvalue is then at least a hundred-millionth of the largest one.
const WELL_DETERMINED: f64 = 1e8;
const MOST_STEPS: usize = 20;
/// Length of a Gauss-Newton step below which the search ends, in samples.
const SMALL_STEP: f64 = 1e-3;
/// Maximum lag that is searched, as a multiple of the time scale on which the load changes. A longer lag could be confused
/// with a lag behind the previous load cycle.
const LONGEST: f64 = 2.0;
/// Lag of one kind (delay or low-pass) that leaves the smallest residual of an output.
pub struct Fitted {
    pub seconds: f64,
    pub standard_error_secs: f64,
    /// True if a model with fast creep and no lag leaves a smaller residual.
    pub is_creep: bool,
    /// Share of the squared derivative of the output by the lag that no column of the fit explains.
    pub own_share: f64,
    /// Sum of squared residuals in each block of consecutive samples.
    pub block_squares: Vec<f64>,
    /// Share of a conventional (linear) calibration's squared error that disappears if the lag is removed.
    pub explained_error_share: f64,
}

/// Columns of the regression, with their systems of equations without a lag. All outputs share them.
#[derive(Debug)]
pub struct Model {
    columns: Columns,
    /// All columns without a lag, with the solver for those that are usual.
    in_time: System,
    /// Solver for all columns, also those of quick creep.
    creeping: Option<Solver>,
    /// Solver for the columns of a conventional calibration.
    linear: Option<Solver>,
}

impl Model {
    pub(crate) fn of(grids: &Grids, columns: Columns) -> Self {
        let in_time = System::of(grids, &columns, columns.n, LagKind::Delay, 0.0);
        let creeping = Solver::of(&in_time.gram, (0..columns.n).collect());
        let linear = Solver::of(&in_time.gram, linear_columns(grids, &columns));
        Self { columns, in_time, creeping, linear }
    }
}

/// Returns the columns of a conventional calibration: the loads and the constant.
fn linear_columns(grids: &Grids, columns: &Columns) -> Vec<usize> {
    (0..grids.n_axes).chain([columns.n_usual - 1]).collect()
}

/// Fit of one output.
pub struct Fit<'a> {
    pub(crate) grids: &'a Grids,
    pub(crate) model: &'a Model,
    /// Output in the used rows.
    pub(crate) output: &'a [f64],
}

impl Fit<'_> {
    /// Finds the lag of one kind (delay or low-pass) by Gauss-Newton steps; `None` if they do not converge.
    pub(crate) fn fitted(&self, kind: LagKind, start: f64) -> Option<Fitted> {
        let grids = self.grids;
        let mut longest = LONGEST * grids.slow_secs;
        if grids.jumps() {
            // Samples near a jump of the load are not used. With a longer lag, the samples after them would depend on the
            // jump.
            longest = longest.min(0.5 * AROUND_JUMP as f64 * grids.step_secs);
        }
        let shortest = if kind == LagKind::Delay { -longest } else { 0.0 };
        let mut seconds = start.max(shortest);
        for _ in 0..MOST_STEPS {
            let late;
            let system = if seconds == 0.0 {
                &self.model.in_time
            } else {
                late = self.system(kind, seconds);
                &late
            };
            let (residual, slope, _) = self.step(system, kind, seconds)?;
            let step = dot(&residual, &slope) / dot(&slope, &slope);
            let next = (seconds + step).clamp(shortest, longest);
            if !next.is_finite() {
                return None;
            }
            let moved = (next - seconds).abs();
            seconds = next;
            if moved < SMALL_STEP * grids.step_secs {
                let is_inside = seconds.abs() < longest;
                return is_inside.then(|| self.finished(kind, seconds)).flatten();
            }
        }
        None
    }

    fn system(&self, kind: LagKind, seconds: f64) -> System {
        let columns = &self.model.columns;
        System::of(self.grids, columns, columns.n_usual, kind, seconds)
    }

    /// Computes the standard error of a fitted lag and the squared residuals of each block.
    fn finished(&self, kind: LagKind, seconds: f64) -> Option<Fitted> {
        let (grids, columns) = (self.grids, &self.model.columns);
        let system = self.system(kind, seconds);
        let (residual, slope, whole) = self.step(&system, kind, seconds)?;
        let squares = dot(&slope, &slope);
        let mut sums = vec![[0.0; 3]; grids.n_blocks];
        for ((block, e), d) in grids.blocks.iter().zip(&residual).zip(&slope) {
            let [ed, dd, ee] = &mut sums[*block];
            *ed += e * d;
            *dd += d * d;
            *ee += e * e;
        }
        let few = |n: f64| if n > 1.0 { n / (n - 1.0) } else { f64::INFINITY };
        let full = sums.iter().filter(|sums| sums[1] > 0.0).count() as f64;
        let scatter: f64 = sums.iter().map(|[ed, ..]| ed * ed).sum();
        let by_blocks = (scatter * few(full)).sqrt() / squares;
        let left = dot(&residual, &residual);
        let by_radii = {
            let solver = Solver::of(&system.gram, columns.coarse.clone())?;
            let (coarser, slope) =
                (system.residual(&solver, self.output), system.residual(&solver, &whole));
            // Error of the lag due to the finite number of play radii, estimated from the residuals with all and with fewer
            // radii.
            let share = (left / dot(&coarser, &coarser)).sqrt();
            share * dot(&coarser, &slope) / dot(&slope, &slope)
        };
        let Model { in_time, creeping, .. } = self.model;
        let crept = in_time.residual(creeping.as_ref()?, self.output);
        let linear = Solver::of(&system.gram, linear_columns(grids, columns));
        let linear = [(in_time, &self.model.linear), (&system, &linear)];
        let linear_squares = linear.map(|(system, solver)| {
            solver.as_ref().map_or(0.0, |solver| {
                let residual = system.residual(solver, self.output);
                dot(&residual, &residual)
            })
        });
        Some(Fitted {
            seconds,
            standard_error_secs: by_blocks.hypot(by_radii),
            is_creep: dot(&crept, &crept) < left,
            own_share: squares / dot(&whole, &whole),
            block_squares: sums.iter().map(|[.., ee]| *ee).collect(),
            explained_error_share: saved_share(linear_squares),
        })
    }

    /// Returns the residual of the fit, the part of the model's derivative by the lag that no column explains, and the whole
    /// derivative.
    fn step(
        &self,
        system: &System,
        kind: LagKind,
        seconds: f64,
    ) -> Option<(Vec<f64>, Vec<f64>, Vec<f64>)> {
        let (grids, columns) = (self.grids, &self.model.columns);
        let solver = system.solver.as_ref()?;
        let gains = system.solve(solver, self.output);
        let nudge = 0.05 * grids.step_secs;
        let (from, to) = match kind {
            LagKind::Delay => (seconds - nudge, seconds + nudge),
            LagKind::FirstOrder => ((seconds - nudge).max(0.0), seconds + nudge),
        };
        let mut whole = Vec::with_capacity(self.output.len());
        for (part, rows) in grids.parts.iter().zip(&columns.rows) {
            let model: Vec<f64> = rows
                .chunks_exact(columns.n)
                .map(|row| dot_of_long(&row[..gains.len()], &gains))
                .collect();
            let [before, after] = [from, to].map(|lag| kind.late(&part.times, &model, lag));
            let slopes = before.iter().zip(&after);
            let slopes: Vec<f64> = slopes.map(|(a, b)| (b - a) / (to - from)).collect();
            whole.extend(part.kept(slopes));
        }
        Some((system.residual(solver, self.output), system.residual(solver, &whole), whole))
    }
}

/// Least-squares system for one value of the lag, with one row for each used sample.
#[derive(Debug)]
struct System {
    /// Number of columns.
    width: usize,
    /// Late columns, row-major.
    rows: Vec<f64>,
    /// Products of all pairs of columns, summed over the rows. Only the lower triangle is valid.
    gram: Mat<f64>,
    /// Solver for the usual columns; `None` if the columns are not finite.
    solver: Option<Solver>,
}

impl System {
    fn of(grids: &Grids, columns: &Columns, width: usize, kind: LagKind, seconds: f64) -> Self {
        let mut rows = Vec::with_capacity(grids.blocks.len() * width);
        for (part, values) in grids.parts.iter().zip(&columns.rows) {
            let which = (&part.times[..], &part.used[..]);
            add_late_rows(kind, seconds, which, (values, width), &mut rows);
        }
        let x = MatRef::from_row_major_slice(&rows, grids.blocks.len(), width);
        let gram = gram(x);
        Self { width, solver: Solver::of(&gram, (0..columns.n_usual).collect()), gram, rows }
    }

    /// Returns the coefficient of each column. Columns that the solver leaves out have the coefficient zero.
    fn solve(&self, solver: &Solver, y: &[f64]) -> Vec<f64> {
        let mut products = vec![0.0; self.width];
        for (row, y) in self.rows.chunks_exact(self.width).zip(y) {
            products.iter_mut().zip(row).for_each(|(sum, x)| *sum += x * y);
        }
        let n = solver.columns.len();
        let mut gains = vec![0.0; self.width];
        for (at, column) in solver.columns.iter().enumerate() {
            let products = (0..n).map(|other| (other, products[solver.columns[other]]));
            gains[*column] =
                products.map(|(other, product)| solver.inverse[(at, other)] * product).sum();
        }
        gains
    }

    fn residual(&self, solver: &Solver, y: &[f64]) -> Vec<f64> {
        let gains = self.solve(solver, y);
        self.rows
            .chunks_exact(self.width)
            .zip(y)
            .map(|(row, y)| y - dot_of_long(row, &gains))
            .collect()
    }
}

/// Returns the decrease from the first value to the second as a share of the first, limited to 0 to 1.
pub fn saved_share([before, after]: [f64; 2]) -> f64 {
    if before > 0.0 { (1.0 - after / before).clamp(0.0, 1.0) } else { 0.0 }
}

/// Least squares with fixed columns for several outputs. Coefficients along directions that the columns do not determine are
/// zero.
#[derive(Debug)]
struct Solver {
    columns: Vec<usize>,
    inverse: Mat<f64>,
}

impl Solver {
    /// `gram` contains the products of all pairs of columns in its lower triangle; `columns` are those that are used.
    fn of(gram: &Mat<f64>, columns: Vec<usize>) -> Option<Self> {
        let n = columns.len();
        let product = |a: usize, b: usize| {
            let (a, b) = (columns[a], columns[b]);
            gram[(a.max(b), a.min(b))]
        };
        let size: Vec<f64> = (0..n).map(|at| product(at, at).sqrt()).collect();
        let scale = |at: usize| if size[at] > 0.0 { 1.0 / size[at] } else { 0.0 };
        let scaled =
            Mat::from_fn(n, n, |row, column| product(row, column) * scale(row) * scale(column));
        let factor = scaled.llt(Side::Lower);
        let inverse = match factor.map(|factor| factor.solve(Mat::<f64>::identity(n, n))) {
            Ok(inverse) if inverse.norm_l2() * (n as f64) < WELL_DETERMINED => inverse,
            _ => inverse_above(&scaled, LEAST_DIRECTION)?,
        };
        let inverse =
            Mat::from_fn(n, n, |row, column| inverse[(row, column)] * scale(row) * scale(column));
        let is_finite = (0..n).all(|row| (0..n).all(|column| inverse[(row, column)].is_finite()));
        is_finite.then_some(Self { columns, inverse })
    }
}

/// Returns the products of all pairs of columns, summed over the rows, in the lower triangle.
fn gram(x: MatRef<'_, f64>) -> Mat<f64> {
    let mut gram = Mat::zeros(x.ncols(), x.ncols());
    let (lower, whole) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
    matmul(&mut gram, lower, Accum::Replace, x.transpose(), whole, x, whole, 1.0, Par::Seq);
    gram
}

/// Solves by least squares; see [`Solver`].
pub fn solved(x: &Mat<f64>, y: &Mat<f64>) -> Option<Mat<f64>> {
    let solver = Solver::of(&gram(x.as_ref()), (0..x.ncols()).collect())?;
    Some(solver.inverse * (x.transpose() * y))
}

/// Returns the mean of the nonzero differences `a − b`, divided by the standard error of this mean.
pub fn paired_t(a: &[f64], b: &[f64]) -> f64 {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).filter(|d| *d != 0.0).collect();
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let scatter: f64 = differences.iter().map(|d| (d - mean).powi(2)).sum();
    let t = mean * (n * (n - 1.0) / scatter).sqrt();
    if t.is_finite() { t } else { 0.0 }
}
