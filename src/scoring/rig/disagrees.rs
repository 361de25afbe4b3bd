//! Finds the one recording, or the one row of a table, that disagrees with all others.
//!
//! Each part is left out in turn. A part with a large error bends the fit and so the errors of all others. So the part is
//! named without which the others agree best, not the part with the largest error.

use faer::Mat;

use crate::{
    finding::{Finding, Id, Verdict},
    recording::Recording,
    scoring::{
        faults::are_of_one_table,
        numbers::significant,
        rig::{Rig, chance::beyond_f, fits::Fit},
    },
};

/// Minimum number of recordings.
const FEWEST: usize = 4;
/// Minimum ratio of the error that a part adds to that of the others, and to that which any other part adds.
const DISAGREES: f64 = 3.0;
/// Maximum probability that one of the parts differs so much by chance, if each sample is independent.
const BY_CHANCE: f64 = 0.005;
/// Smallest error of a part that disagrees, as a share of full scale.
const LEAST: f64 = 0.005;

/// What becomes of the fit without one part.
struct Without {
    part: usize,
    fit: Fit,
    /// Mean square of the errors of the other parts per degree of freedom, on each axis.
    others: Vec<f64>,
    /// Squared error per sample that the part adds, divided by that of the others.
    adds: f64,
}

impl Rig {
    /// Returns the finding that one of these recordings, or one row of a table, disagrees with all others, and the indices of the
    /// recordings. The names of the runs are given.
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
        let parts: Vec<Mat<f64>> = if is_table {
            rows.iter().map(|row| of_row(&row.values)).collect()
        } else {
            (0..self.n_runs()).map(|run| self.total(|own| own == run)).collect()
        };
        if parts.len() < FEWEST {
            return None;
        }
        let all = parts.iter().fold(Mat::zeros(shape.width(), shape.width()), |sum, own| sum + own);
        let squares = Fit::backward(&all, shape).squares(&all);
        let n_axes = shape.axes.len() as f64;
        let without = |part: usize| {
            let others = &all - &parts[part];
            let fit = Fit::backward(&others, shape);
            let freedom = (others[(0, 0)] - (shape.n_gauges + 1) as f64).max(1.0);
            let others: Vec<f64> = fit
                .squares(&others)
                .iter()
                .map(|own| (own / freedom).max(f64::MIN_POSITIVE))
                .collect();
            let added = squares.iter().zip(&others).map(|(all, own)| all / own - freedom);
            let adds = added.sum::<f64>() / (n_axes * parts[part][(0, 0)]);
            Without { part, fit, others, adds }
        };
        let mut found: Vec<Without> = (0..parts.len()).map(without).collect();
        found.sort_by(|a, b| b.adds.total_cmp(&a.adds));
        let (worst, next) = (&found[0], &found[1]);
        let own = &parts[worst.part];
        let n = own[(0, 0)];
        let root = |squares: &[f64]| (squares.iter().sum::<f64>() / n_axes).sqrt();
        let own_squares: Vec<f64> = worst.fit.squares(own).iter().map(|own| own / n).collect();
        let (error, others) = (root(&own_squares), root(&worst.others));
        let freedom = n_axes * (all[(0, 0)] - (shape.n_gauges + 2) as f64);
        let chance = beyond_f(worst.adds, n_axes, freedom.max(1.0)) * parts.len() as f64;
        if worst.adds < DISAGREES.powi(2) * next.adds.max(1.0)
            || chance > BY_CHANCE
            || error < LEAST
        {
            return None;
        }
        let [shown, at_most] = [error, others].map(|own| significant(100.0 * own, 2));
        let name =
            if is_table { recordings[rows[worst.part].group].name() } else { &names[worst.part] };
        let kind = if is_table { "rows" } else { "recordings" };
        let seen = format!(
            "{name} disagrees with the other {kind}: its held-out error is {shown} % of full scale, theirs without it {at_most} %"
        );
        let share = |axis: &usize| own_squares[*axis] / worst.others[*axis];
        let axis = (0..shape.axes.len()).max_by(|a, b| share(a).total_cmp(&share(b)))?;
        let at = shape.load(axis);
        let recorded = own[(0, at)] / n;
        let [recorded, gauges] = [recorded, recorded - worst.fit.means(own)[axis]]
            .map(|load| significant(load * shape.full_scale[axis], 4));
        let (symbol, unit) = (shape.axes[axis].symbol(), shape.axes[axis].unit());
        let figures = if is_table {
            format!("{symbol} is {recorded} {unit}, and the gauges show {gauges} {unit}")
        } else {
            format!("most of it on {symbol}")
        };
        let found = Finding::new(Id::OneDisagrees, Verdict::Doubtful, seen).with(figures);
        let own =
            if is_table { vec![rows[worst.part].group] } else { self.runs[worst.part].clone() };
        Some((found.costing(error - others), own))
    }
}
