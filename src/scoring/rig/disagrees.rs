//! Finds the one recording, or the one row of a table, that disagrees with all others.
//!
//! Each part is left out in turn. A part with a large error bends the fit and so the errors of all others. So the part is
//! named without which the others agree best, not the part with the largest error.

use faer::{Mat, prelude::Solve};

use crate::{
    finding::{Finding, Id, Verdict},
    recording::Recording,
    scoring::{
        faults::are_of_one_table,
        numbers::significant,
        rig::{
            Rig,
            chance::beyond_f,
            fits::{Fit, Shape, with_one},
        },
    },
};

/// Minimum number of recordings or rows, and maximum number of rows.
const FEWEST: usize = 4;
const MOST: usize = 2048;
/// Minimum ratio of the error of the part to that of any other part, when the fit leaves it out.
const DISAGREES: f64 = 3.0;
/// Maximum probability that one of the parts differs so much by chance, if each sample is independent.
const BY_CHANCE: f64 = 0.005;
/// Maximum mean square of a part's gauges, in the mean squares of the others along their principal directions.
const FARTHEST: f64 = 4.0;
/// Smallest error of a part that disagrees, as a share of full scale.
const LEAST: f64 = 0.005;

impl Rig {
    /// Returns the finding that one of these recordings, or one row of a table, disagrees with all others, and the indices of the
    /// recordings, if it is no row. The names of the runs are given.
    pub fn one_disagrees(
        &self,
        recordings: &[&Recording],
        names: &[String],
    ) -> Option<(Finding, Vec<usize>)> {
        let shape = &self.shape;
        let is_table = recordings.windows(2).all(|own| are_of_one_table(own[0], own[1]));
        let rows = if is_table { self.rows(recordings) } else { Vec::new() };
        let of_row = |values: &[f64]| {
            let values: Vec<f64> = [1.0, 0.0].iter().chain(values).copied().collect();
            Mat::from_fn(values.len(), values.len(), |i, j| values[i] * values[j])
        };
        if !(FEWEST..=MOST).contains(&rows.len().max(self.n_runs())) {
            return None;
        }
        let parts: Vec<Mat<f64>> = if is_table {
            rows.iter().map(|row| of_row(&row.values)).collect()
        } else {
            (0..self.n_runs()).map(|run| self.total(|own| own == run)).collect()
        };
        let all = parts.iter().fold(Mat::zeros(shape.width(), shape.width()), |sum, own| sum + own);
        let fit_without = |part: usize| {
            let others = &all - &parts[part];
            let fit = Fit::backward(&others, shape);
            let freedom = (others[(0, 0)] - (shape.n_gauges + 1) as f64).max(1.0);
            let squares = fit.squares(&others).into_iter();
            let squares: Vec<f64> =
                squares.map(|own| (own / freedom).max(f64::MIN_POSITIVE)).collect();
            (fit, squares)
        };
        let fits: Vec<(Fit, Vec<f64>)> = (0..parts.len()).map(fit_without).collect();
        // The squared error per sample that a part adds, as a multiple of the mean square on each axis.
        let squares = Fit::backward(&all, shape).squares(&all);
        let n_axes = shape.axes.len() as f64;
        let adds = |part: &usize| {
            let left = all[(0, 0)] - parts[*part][(0, 0)] - (shape.n_gauges + 1) as f64;
            let ratios =
                squares.iter().zip(&fits[*part].1).map(|(all, own)| all / own - left.max(1.0));
            ratios.sum::<f64>() / (n_axes * parts[*part][(0, 0)])
        };
        let worst = (0..parts.len()).max_by(|a, b| adds(a).total_cmp(&adds(b)))?;
        let ((fit, others), own) = (&fits[worst], &parts[worst]);
        let means = |part: &Mat<f64>| {
            let n = part[(0, 0)];
            fit.squares(part).into_iter().map(move |sum| sum / n)
        };
        let ratio = |part: &Mat<f64>| {
            means(part).zip(others).map(|(own, of)| own / of).sum::<f64>() / n_axes
        };
        let next = (0..parts.len()).filter(|part| *part != worst).map(|part| ratio(&parts[part]));
        let is_clear = adds(&worst) > DISAGREES.powi(2) * next.fold(1.0, f64::max);
        let freedom = n_axes * (all[(0, 0)] - (shape.n_gauges + 2) as f64);
        let chance = beyond_f(adds(&worst), n_axes, freedom.max(1.0)) * parts.len() as f64;
        let root = |squares: &mut dyn Iterator<Item = f64>| (squares.sum::<f64>() / n_axes).sqrt();
        let (error, rest) = (root(&mut means(own)), root(&mut others.iter().copied()));
        if !is_clear
            || chance > BY_CHANCE
            || error < LEAST
            || !is_covered(own, &(&all - own), shape)
        {
            return None;
        }
        let [shown, at_most] = [error, rest].map(|own| significant(100.0 * own, 2));
        let (name, kind) = match rows.get(worst) {
            Some(row) => (format!("row {} of the table", row.first + 1), "rows"),
            None => (names[worst].clone(), "recordings"),
        };
        let seen = format!(
            "{name} disagrees with the other {kind}: its held-out error is {shown} % of full scale, theirs without it {at_most} %"
        );
        let shares: Vec<f64> = means(own).zip(others).map(|(own, of)| own / of).collect();
        let axis = (0..shares.len()).max_by(|a, b| shares[*a].total_cmp(&shares[*b]))?;
        let recorded = own[(0, shape.load(axis))] / own[(0, 0)];
        let [recorded, gauges] = [recorded, recorded - fit.means(own)[axis]]
            .map(|load| significant(load * shape.full_scale[axis], 4));
        let (symbol, unit) = (shape.axes[axis].symbol(), shape.axes[axis].unit());
        let figures = if is_table {
            format!("{symbol} is {recorded} {unit}, and the gauges show {gauges} {unit}")
        } else {
            format!("most of it on {symbol}")
        };
        let found = Finding::new(Id::OneDisagrees, Verdict::Doubtful, seen).with(figures);
        let own = if is_table { Vec::new() } else { self.runs[worst].clone() };
        Some((found.costing(error - rest), own))
    }
}

/// Returns true if the gauges of a part lie among those of the others. Elsewhere, the fit to the others extrapolates, such as
/// where one recording alone loads an axis.
fn is_covered(part: &Mat<f64>, others: &Mat<f64>, shape: &Shape) -> bool {
    let columns = with_one(shape.gauge(0)..shape.load(0));
    let n = columns.len();
    let mean =
        |sums: &Mat<f64>| Mat::from_fn(n, n, |i, j| sums[(columns[i], columns[j])] / sums[(0, 0)]);
    let distances = mean(others).partial_piv_lu().solve(mean(part));
    (0..n).map(|i| distances[(i, i)]).sum::<f64>() <= FARTHEST * n as f64
}
