//! Finds zeros of the gauges that change over the rows of a table of load cases: steadily, or between blocks of consecutive
//! rows, because the sensor was mounted anew.
//!
//! Loads, their squares, and the direction of each load explain the gauges first. Then steps of the zeros are added one after
//! the other, or a drift in the order of the rows is, whichever leaves less.

use faer::Mat;
use serde_json::json;

use crate::{
    finding::{Finding, Id, Verdict},
    min_max::MinMax,
    recording::Recording,
    scoring::{
        faults::are_of_one_table,
        numbers::{percent, significant},
        rig::{
            Rig,
            fits::{Fit, Shape},
            steps::{Row, Steps, step_at},
        },
    },
    shown::counted,
};

/// Minimum number of rows of a mounting, and maximum number of steps.
const FEWEST_ROWS: usize = 3;
const MOST_STEPS: usize = 11;
/// Minimum part of a step that the other columns do not explain.
const INDEPENDENT: f64 = 0.3;
/// Minimum F statistic of each step as a mean over the gauges, and maximum ratio of the residuals with and without all steps.
const CERTAIN: f64 = 15.0;
const LEFT: f64 = 0.33;
/// Maximum ratio of the residuals with and without a drift.
const LEFT_BY_DRIFT: f64 = 0.5;
/// Maximum ratio of the residuals with a drift and with steps, for which the change counts as a drift.
const NO_CLEARER: f64 = 1.2;
/// Smallest standard deviation of a gauge's residual, as a share of the gauge's deviation.
const EXACT: f64 = 1e-5;
/// Smallest difference of a zero that is reported (full scale), and that in a table whose rows do not show the hysteresis that
/// an unloaded axis keeps.
const SMALLEST: f64 = 0.002;
const UNPAIRED: f64 = 0.05;

impl Rig {
    /// Returns findings of tables whose zeros differ between blocks of rows.
    pub fn mountings(&self, recordings: &[&Recording]) -> Vec<Finding> {
        let tables = recordings.chunk_by(|a, b| are_of_one_table(a, b));
        tables.filter_map(|cases| self.mountings_of(cases)).collect()
    }

    /// Returns the rows of a table in the order of its file. Rows in succession with one load are one row.
    pub fn rows(&self, cases: &[&Recording]) -> Vec<Row> {
        let places = cases.iter().enumerate();
        let places = places.flat_map(|(case, own)| (0..own.n_samples()).map(move |k| (case, k)));
        let mut places: Vec<(usize, usize)> = places.collect();
        places.sort_by(|a, b| cases[a.0].times()[a.1].total_cmp(&cases[b.0].times()[b.1]));
        let axes = self.shape.axes_in(cases[0]);
        let mut rows: Vec<Row> = Vec::new();
        for (case, k) in places {
            let own = cases[case];
            let loads = axes.iter().zip(&self.shape.full_scale);
            let loads = loads.map(|(axis, full)| own.loads()[k * own.axes().len() + axis] / full);
            if rows.last().is_none_or(|row| row.group != case) {
                rows.push(Row::new(case, self.shape.width() - 2));
            }
            let values = self.standard(own.gauges_at(k)).chain(loads);
            rows.last_mut().expect("there is a row").add(own.times()[k], values);
        }
        rows
    }

    fn mountings_of(&self, cases: &[&Recording]) -> Option<Finding> {
        if !cases[0].is_load_case() {
            return None;
        }
        let (rows, shape) = (self.rows(cases), &self.shape);
        let (known, smallest) = explained(&rows, shape);
        let (starts, left) = starts(&known);
        let before = residual(&known);
        let drift = drifted(&known, &rows).filter(|drifted| *drifted < NO_CLEARER * left);
        if drift.is_some_and(|left| left < LEFT_BY_DRIFT * before) {
            return self.drift_of(&rows, smallest);
        }
        if starts.len() < 2 || left >= LEFT * before {
            return None;
        }
        let ends = starts.iter().skip(1).copied().chain([rows.len()]);
        let blocks: Vec<&[Row]> =
            starts.iter().zip(ends).map(|(from, to)| &rows[*from..to]).collect();
        let inverse = Fit::forward(&sums(&blocks, shape), shape).inverse(shape);
        // Loads that the zeros of a block look like, apart from a constant.
        let zeros = blocks.iter().map(|block| -> Vec<f64> {
            let means = means(block);
            let (gauges, loads) = means.split_at(shape.n_gauges);
            shown(&inverse, gauges).zip(loads).map(|(shown, load)| shown - load).collect()
        });
        let zeros: Vec<Vec<f64>> = zeros.collect();
        let spreads = (0..shape.axes.len())
            .map(|axis| zeros.iter().map(|own| own[axis]).collect::<MinMax>().span());
        let largest = self.largest(spreads, smallest)?;
        let ranges: Vec<[usize; 2]> = blocks
            .iter()
            .map(|block| [block[0].first + 1, block[block.len() - 1].last + 1])
            .collect();
        let words: Vec<String> = ranges.iter().map(|[from, to]| format!("{from}–{to}")).collect();
        let seen = format!(
            "the table has {}: the zeros of the gauges differ between the rows {}",
            counted(blocks.len(), "mounting"),
            words.join(", ")
        );
        let axes: Vec<&str> = shape.axes.iter().map(|axis| axis.symbol()).collect();
        let facts = ranges.iter().zip(&zeros).map(|(rows, own)| {
            let change = |axis: usize| (own[axis] - zeros[0][axis]) * shape.full_scale[axis];
            let changes: Vec<f64> = (0..shape.axes.len()).map(change).collect();
            json!({ "rows": rows, "axes": axes, "zero_compared_with_first": changes })
        });
        let found = Finding::new(Id::Mountings, Verdict::Doubtful, seen).with(largest.1);
        Some(found.costing(largest.0).facts(facts.collect()))
    }

    fn drift_of(&self, rows: &[Row], smallest: f64) -> Option<Finding> {
        let shape = &self.shape;
        let fit = Fit::with_drift(&sums(&[rows], shape), shape);
        let n_rows = rows[rows.len() - 1].time - rows[0].time;
        let drift = fit.map.col(1 + shape.axes.len());
        let drift: Vec<f64> = drift.iter().map(|own| own * n_rows).collect();
        let shown = shown(&fit.inverse(shape), &drift).map(f64::abs).collect::<Vec<f64>>();
        let (most, figures) = self.largest(shown.into_iter(), smallest)?;
        let seen = "the zeros of the gauges drift over the rows of the table";
        let found = Finding::new(Id::ZerosDrift, Verdict::Doubtful, seen);
        Some(found.with(figures).costing(most))
    }

    /// Returns the largest of these changes, one for each axis, also in words, if it is large enough to be reported.
    fn largest(&self, changes: impl Iterator<Item = f64>, smallest: f64) -> Option<(f64, String)> {
        let (axis, most) = changes.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let load = self.shape.axes[axis];
        let change = significant(most * self.shape.full_scale[axis], 3);
        let (unit, symbol, share) = (load.unit(), load.symbol(), percent(most));
        let words = format!("by up to {change} {unit} of {symbol}, {share} of full scale");
        (most >= smallest).then_some((most, words))
    }
}

/// Returns the loads that gauges look like.
fn shown(inverse: &Mat<f64>, gauges: &[f64]) -> impl Iterator<Item = f64> {
    inverse.row_iter().map(|row| gauges.iter().zip(row.iter()).map(|(own, by)| own * by).sum())
}

/// Returns the sums of products over blocks of rows, each after subtraction of the block's means. The number of the row is the
/// time.
fn sums(blocks: &[&[Row]], shape: &Shape) -> Mat<f64> {
    let mut sums = Mat::<f64>::zeros(shape.width(), shape.width());
    for block in blocks {
        let means = means(block);
        let middle = block.iter().map(|row| row.time).sum::<f64>() / block.len() as f64;
        for row in *block {
            let values = row.values.iter().zip(&means).map(|(value, mean)| value - mean);
            let values: Vec<f64> = [1.0, row.time - middle].into_iter().chain(values).collect();
            sums += Mat::from_fn(values.len(), values.len(), |i, j| values[i] * values[j]);
        }
    }
    sums
}

fn means(block: &[Row]) -> Vec<f64> {
    let mean = |at: usize| block.iter().map(|row| row.values[at]).sum::<f64>() / block.len() as f64;
    (0..block[0].values.len()).map(mean).collect()
}

/// Returns what the loads do not explain in the gauges, and the smallest change of a zero to report.
fn explained(rows: &[Row], shape: &Shape) -> (Steps, f64) {
    let (n_axes, n_gauges) = (shape.axes.len(), shape.n_gauges);
    let column = |at: usize| -> Vec<f64> { rows.iter().map(|row| row.values[at]).collect() };
    let gauges: Vec<Vec<f64>> = (0..n_gauges).map(column).collect();
    let mut known = Steps::new(vec![0; rows.len()], &gauges);
    let loads: Vec<Vec<f64>> = (n_gauges..n_gauges + n_axes).map(column).collect();
    let powers = if n_axes == 1 { 3 } else { 2 };
    for load in &loads {
        for power in 1..=powers {
            known.explain(&load.iter().map(|load| load.powi(power)).collect::<Vec<_>>());
        }
    }
    let mut smallest = SMALLEST;
    for load in &loads {
        let [up, down] = [1.0, -1.0]
            .map(|way| load.windows(2).filter(|pair| way * (pair[1] - pair[0]) > 0.0).count());
        if up.min(down) >= FEWEST_ROWS {
            known.explain(&directions(load));
        } else if up.min(down) > 0 {
            smallest = UNPAIRED;
        }
    }
    (known, smallest)
}

/// Returns the root mean square that is left of the gauges, per degree of freedom.
fn residual(known: &Steps) -> f64 {
    (known.squares().iter().sum::<f64>() / known.freedom().max(1) as f64).sqrt()
}

/// Returns a function of the reductions of the gauges' squares by a further column: its F statistic as a mean over the gauges.
fn certainty(known: &Steps) -> impl Fn(&[f64]) -> f64 + use<> {
    let (left, floor) = (known.squares(), known.n_rows() as f64 * EXACT * EXACT);
    let freedom = (known.freedom().max(1) - 1) as f64;
    move |gains| {
        let of_gauge = |(gain, left): (&f64, &f64)| gain / (left - gain).max(floor);
        gains.iter().zip(&left).map(of_gauge).sum::<f64>() * freedom / left.len() as f64
    }
}

/// Returns what a drift of the zeros in the order of the rows leaves of the gauges, if it is certain.
fn drifted(known: &Steps, rows: &[Row]) -> Option<f64> {
    let times: Vec<f64> = rows.iter().map(|row| row.time).collect();
    let gains = known.gains(&times, INDEPENDENT)?;
    let mut with = known.clone();
    with.explain(&times);
    (certainty(known)(&gains) > CERTAIN && with.freedom() > 2).then(|| residual(&with))
}

/// Returns the first row of each mounting, and what is left of the gauges.
fn starts(known: &Steps) -> (Vec<usize>, f64) {
    let (n, mut known) = (known.n_rows(), known.clone());
    let mut starts = vec![0];
    while starts.len() <= MOST_STEPS && known.freedom() > 2 {
        let (mut best, certainty) = ((CERTAIN, 0), certainty(&known));
        known.steps(INDEPENDENT, |row, gains| {
            let is_free = |start: &usize| row.abs_diff(*start) >= FEWEST_ROWS;
            if n - row >= FEWEST_ROWS && starts.iter().all(is_free) {
                let certainty = certainty(gains);
                if certainty > best.0 {
                    best = (certainty, row);
                }
            }
        });
        if best.1 == 0 || !known.explain(&step_at(best.1, n)) {
            break;
        }
        starts.push(best.1);
    }
    starts.sort_unstable();
    (starts, residual(&known))
}

/// Returns 1 for rows that a load reaches from below, −1 for rows that it reaches from above.
fn directions(load: &[f64]) -> Vec<f64> {
    let mut direction = 0.0;
    let changes = load.windows(2).map(|pair| pair[1] - pair[0]);
    let along = changes.map(|change| {
        direction = if change == 0.0 { direction } else { change.signum() };
        direction
    });
    [0.0].into_iter().chain(along).collect()
}
