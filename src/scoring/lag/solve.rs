//! Finds the lag that leaves the smallest residual in the fit of an output.

use faer::{Mat, Side};

use super::grid::{AROUND_JUMP, Grid, Grids};
use super::kind::{LagKind, Late};
use crate::dot::dot;

/// Minimum eigenvalue of the scaled normal matrix, as a share of its largest eigenvalue. Coefficients along directions with
/// smaller eigenvalues are set to zero.
const LEAST_DIRECTION: f64 = 1e-11;
const MOST_STEPS: usize = 20;
/// Length of a Gauss-Newton step below which the search ends, in samples.
const SMALL_STEP: f64 = 1e-3;
/// Maximum lag that is searched, as a multiple of the time scale on which the load changes. A longer lag could be confused
/// with a lag behind the previous load cycle.
const LONGEST: f64 = 2.0;
/// Minimum number of blocks of consecutive samples into which each recording is cut.
const BLOCKS_A_RUN: usize = 4;
const BLOCKS: usize = 12;

/// Lag of one kind (delay or low-pass) that leaves the smallest residual of an output.
pub(super) struct Fitted {
    pub(super) seconds: f64,
    pub(super) standard_error_secs: f64,
    /// True if a model with fast creep and no lag leaves a smaller residual.
    pub(super) is_creep: bool,
    /// Share of the squared derivative of the output by the lag that no column of the fit explains.
    pub(super) own_share: f64,
    /// Sum of squared residuals in each block of consecutive samples.
    pub(super) block_squares: Vec<f64>,
}

/// Least-squares system for one value of the lag, with one row for each used sample.
struct System {
    x: Mat<f64>,
    y: Mat<f64>,
    blocks: Vec<usize>,
    n_blocks: usize,
}

/// Finds the lag of one kind (delay or low-pass) by Gauss-Newton steps; `None` if they do not converge.
pub(super) fn fitted(grids: &Grids, output: usize, kind: LagKind, start: f64) -> Option<Fitted> {
    let mut longest = LONGEST * grids.slow_secs;
    if grids.jumps() {
        // Samples near a jump of the load are not used. With a longer lag, the samples after them would depend on the jump.
        longest = longest.min(0.5 * AROUND_JUMP as f64 * grids.step_secs);
    }
    let shortest = if kind == LagKind::Delay { -longest } else { 0.0 };
    let all: Vec<usize> = (0..grids.n_usual).collect();
    let mut seconds = start.max(shortest);
    for _ in 0..MOST_STEPS {
        let system = System::of(grids, output, kind, seconds, &all);
        let (residual, slope, _) = system.step(grids, kind, seconds)?;
        let step = dot(&residual, &slope) / dot(&slope, &slope);
        let next = (seconds + step).clamp(shortest, longest);
        if !next.is_finite() {
            return None;
        }
        let moved = (next - seconds).abs();
        seconds = next;
        if moved < SMALL_STEP * grids.step_secs {
            let is_inside = seconds.abs() < longest;
            return is_inside.then(|| finished(grids, output, kind, seconds)).flatten();
        }
    }
    None
}

/// Computes the standard error of a fitted lag and the squared residuals of each block.
fn finished(grids: &Grids, output: usize, kind: LagKind, seconds: f64) -> Option<Fitted> {
    let all: Vec<usize> = (0..grids.n_usual).collect();
    let coarse: Vec<usize> = all.iter().copied().filter(|column| !grids.finer[*column]).collect();
    let system = System::of(grids, output, kind, seconds, &all);
    let (residual, slope, whole) = system.step(grids, kind, seconds)?;
    let squares = dot(&slope, &slope);
    let mut sums = vec![[0.0; 3]; system.n_blocks];
    for ((block, e), d) in system.blocks.iter().zip(&residual).zip(&slope) {
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
        let system = System::of(grids, output, kind, seconds, &coarse);
        let solver = Solver::new(&system.x)?;
        let (coarser, slope) = (solver.residual(&system.y), solver.residual(&column(&whole)));
        // Error of the lag due to the finite number of play radii, estimated from the residuals with all and with fewer
        // radii.
        let share = (left / dot(&coarser, &coarser)).sqrt();
        share * dot(&coarser, &slope) / dot(&slope, &slope)
    };
    let everything: Vec<usize> = (0..grids.parts[0].columns.len()).collect();
    let creeping = System::of(grids, output, LagKind::Delay, 0.0, &everything);
    let crept = Solver::new(&creeping.x)?.residual(&creeping.y);
    Some(Fitted {
        seconds,
        standard_error_secs: by_blocks.hypot(by_radii),
        is_creep: dot(&crept, &crept) < left,
        own_share: squares / dot(&whole, &whole),
        block_squares: sums.iter().map(|[.., ee]| *ee).collect(),
    })
}

impl System {
    fn of(grids: &Grids, output: usize, kind: LagKind, seconds: f64, columns: &[usize]) -> Self {
        let n_runs = grids.parts.iter().map(|part| part.run).max().map_or(1, |last| last + 1);
        let per_run = BLOCKS.div_ceil(n_runs).max(BLOCKS_A_RUN);
        let (mut y, mut blocks) = (Vec::new(), Vec::new());
        let n_rows = grids.parts.iter().flat_map(|part| &part.used).filter(|used| **used).count();
        let mut x = Mat::zeros(n_rows, columns.len());
        for part in &grids.parts {
            let first = y.len();
            y.extend(part.kept(&part.outputs[output]));
            let own = part.kept(&part.places);
            blocks.extend(own.map(|place| part.run * per_run + (place * per_run as f64) as usize));
            let lag = Late::of(kind, &part.times, seconds);
            for (at, column) in columns.iter().enumerate() {
                for (row, value) in part.kept(&lag.of_values(&part.columns[*column])).enumerate() {
                    x[(first + row, at)] = value;
                }
            }
        }
        Self { x, y: column(&y), blocks, n_blocks: n_runs * per_run }
    }

    /// Returns the residual of the fit, the part of the model's derivative by the lag that no column explains, and the whole
    /// derivative.
    fn step(
        &self,
        grids: &Grids,
        kind: LagKind,
        seconds: f64,
    ) -> Option<(Vec<f64>, Vec<f64>, Vec<f64>)> {
        let solver = Solver::new(&self.x)?;
        let gains = solver.solve(&self.y);
        let nudge = 0.05 * grids.step_secs;
        let (from, to) = match kind {
            LagKind::Delay => (seconds - nudge, seconds + nudge),
            LagKind::FirstOrder => ((seconds - nudge).max(0.0), seconds + nudge),
        };
        let mut whole = Vec::with_capacity(self.y.nrows());
        for part in &grids.parts {
            let mut model = vec![0.0; part.times.len()];
            for (at, column) in part.columns.iter().take(grids.n_usual).enumerate() {
                let gain = gains[(at, 0)];
                model.iter_mut().zip(column).for_each(|(model, own)| *model += gain * own);
            }
            let [before, after] = [from, to].map(|lag| kind.late(&part.times, &model, lag));
            let slopes = before.iter().zip(&after);
            let slopes: Vec<f64> = slopes.map(|(a, b)| (b - a) / (to - from)).collect();
            whole.extend(part.kept(&slopes));
        }
        Some((solver.residual(&self.y), solver.residual(&column(&whole)), whole))
    }
}

impl Grid {
    fn kept<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let rows = values.iter().zip(&self.used);
        rows.filter(|(_, used)| **used).map(|(value, _)| *value)
    }
}

/// Returns the share of a conventional (linear) calibration's squared error that disappears if the lag is removed.
pub(super) fn explained_error_share(
    grids: &Grids,
    output: usize,
    kind: LagKind,
    seconds: f64,
) -> f64 {
    let constant = grids.n_usual - 1;
    let columns: Vec<usize> = (0..grids.n_axes).chain([constant]).collect();
    saved_share([0.0, seconds].map(|seconds| {
        let system = System::of(grids, output, kind, seconds, &columns);
        Solver::new(&system.x).map_or(0.0, |solver| {
            let residual = solver.residual(&system.y);
            dot(&residual, &residual)
        })
    }))
}

/// Returns the decrease from the first value to the second as a share of the first, limited to 0 to 1.
pub(super) fn saved_share([before, after]: [f64; 2]) -> f64 {
    if before > 0.0 { (1.0 - after / before).clamp(0.0, 1.0) } else { 0.0 }
}

/// Least squares with fixed columns for several outputs. Coefficients along directions that the columns do not determine are
/// zero.
struct Solver<'a> {
    x: &'a Mat<f64>,
    inverse: Mat<f64>,
}

impl<'a> Solver<'a> {
    fn new(x: &'a Mat<f64>) -> Option<Self> {
        let n = x.ncols();
        let gram = x.transpose() * x;
        let size: Vec<f64> = (0..n).map(|at| gram[(at, at)].sqrt()).collect();
        let scale = |at: usize| if size[at] > 0.0 { 1.0 / size[at] } else { 0.0 };
        let scaled =
            Mat::from_fn(n, n, |row, column| gram[(row, column)] * scale(row) * scale(column));
        let parts = scaled.self_adjoint_eigen(Side::Lower).ok()?;
        let (vectors, values) = (parts.U(), parts.S());
        let largest = (0..n).map(|at| values[at]).fold(0.0, f64::max);
        let kept = |at: usize| values[at] > LEAST_DIRECTION * largest;
        let weighted = Mat::from_fn(n, n, |row, at| match kept(at) {
            true => vectors[(row, at)] / values[at],
            false => 0.0,
        });
        let inverse = weighted * vectors.transpose();
        let inverse =
            Mat::from_fn(n, n, |row, column| inverse[(row, column)] * scale(row) * scale(column));
        let is_finite = (0..n).all(|row| (0..n).all(|column| inverse[(row, column)].is_finite()));
        is_finite.then_some(Self { x, inverse })
    }

    fn solve(&self, y: &Mat<f64>) -> Mat<f64> {
        &self.inverse * (self.x.transpose() * y)
    }

    fn residual(&self, y: &Mat<f64>) -> Vec<f64> {
        let left = y - self.x * self.solve(y);
        (0..left.nrows()).map(|row| left[(row, 0)]).collect()
    }
}

/// Solves by least squares; see [`Solver`].
pub(super) fn solved(x: &Mat<f64>, y: &Mat<f64>) -> Option<Mat<f64>> {
    Solver::new(x).map(|solver| solver.solve(y))
}

fn column(values: &[f64]) -> Mat<f64> {
    Mat::from_fn(values.len(), 1, |row, _| values[row])
}

/// Returns the mean of the nonzero differences `a − b`, divided by the standard error of this mean.
pub(super) fn paired_t(a: &[f64], b: &[f64]) -> f64 {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).filter(|d| *d != 0.0).collect();
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let scatter: f64 = differences.iter().map(|d| (d - mean).powi(2)).sum();
    let t = mean * (n * (n - 1.0) / scatter).sqrt();
    if t.is_finite() { t } else { 0.0 }
}
