//! Finds blocks of consecutive rows of a table of load cases between which the zeros of the gauges differ, because the sensor
//! was mounted anew.
//!
//! Loads, their squares, and the direction of each load explain the gauges first. Then steps of the zeros
//! are added one after the other.

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
    fn rows(&self, cases: &[&Recording]) -> Vec<Row> {
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
        let (starts, smallest) = starts(&rows, shape)?;
        let ends = starts.iter().skip(1).copied().chain([rows.len()]);
        let blocks: Vec<&[Row]> =
            starts.iter().zip(ends).map(|(from, to)| &rows[*from..to]).collect();
        let inverse = Fit::forward(&sums(&blocks, shape), shape).inverse(shape);
        // Loads that the zeros of a block look like, apart from a constant.
        let zeros = blocks.iter().map(|block| -> Vec<f64> {
            let means = means(block);
            let (gauges, loads) = means.split_at(shape.n_gauges);
            let shown = |(axis, load): (usize, &f64)| {
                gauges.iter().enumerate().map(|(at, own)| inverse[(axis, at)] * own).sum::<f64>()
                    - load
            };
            loads.iter().enumerate().map(shown).collect()
        });
        let zeros: Vec<Vec<f64>> = zeros.collect();
        let spread = |axis: usize| zeros.iter().map(|own| own[axis]).collect::<MinMax>().span();
        let most = (0..shape.axes.len()).max_by(|a, b| spread(*a).total_cmp(&spread(*b)))?;
        if spread(most) < smallest {
            return None;
        }
        let ranges: Vec<[usize; 2]> = blocks
            .iter()
            .map(|block| [block[0].first + 1, block[block.len() - 1].last + 1])
            .collect();
        let words: Vec<String> = ranges.iter().map(|[from, to]| format!("{from}–{to}")).collect();
        let axis = shape.axes[most];
        let seen = format!(
            "the table has {}: the zeros of the gauges differ between the rows {}",
            counted(blocks.len(), "mounting"),
            words.join(", ")
        );
        let figures = format!(
            "by up to {} {} of {}, {} of full scale",
            significant(spread(most) * shape.full_scale[most], 3),
            axis.unit(),
            axis.symbol(),
            percent(spread(most)),
        );
        let axes: Vec<&str> = shape.axes.iter().map(|axis| axis.symbol()).collect();
        let facts = ranges.iter().zip(&zeros).map(|(rows, own)| {
            let change = |axis: usize| (own[axis] - zeros[0][axis]) * shape.full_scale[axis];
            let changes: Vec<f64> = (0..shape.axes.len()).map(change).collect();
            json!({ "rows": rows, "axes": axes, "zero_compared_with_first": changes })
        });
        let found = Finding::new(Id::Mountings, Verdict::Doubtful, seen).with(figures);
        Some(found.costing(spread(most)).facts(facts.collect()))
    }
}

/// Returns the sums of products over blocks of rows, each after subtraction of the block's means.
fn sums(blocks: &[&[Row]], shape: &Shape) -> Mat<f64> {
    let mut sums = Mat::<f64>::zeros(shape.width(), shape.width());
    for block in blocks {
        let means = means(block);
        for row in *block {
            let values = row.values.iter().zip(&means).map(|(value, mean)| value - mean);
            let values: Vec<f64> = [1.0, 0.0].into_iter().chain(values).collect();
            sums += Mat::from_fn(values.len(), values.len(), |i, j| values[i] * values[j]);
        }
    }
    sums
}

fn means(block: &[Row]) -> Vec<f64> {
    let mean = |at: usize| block.iter().map(|row| row.values[at]).sum::<f64>() / block.len() as f64;
    (0..block[0].values.len()).map(mean).collect()
}

/// Returns the first row of each mounting, if there are several, and the smallest difference of zeros to report.
fn starts(rows: &[Row], shape: &Shape) -> Option<(Vec<usize>, f64)> {
    let n = rows.len();
    let (n_axes, n_gauges) = (shape.axes.len(), shape.n_gauges);
    let column = |at: usize| -> Vec<f64> { rows.iter().map(|row| row.values[at]).collect() };
    let mut known = Steps::new(vec![0; n], &(0..n_gauges).map(column).collect::<Vec<_>>());
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
    let per_freedom =
        |known: &Steps| known.squares().iter().sum::<f64>() / known.freedom().max(1) as f64;
    let before = per_freedom(&known);
    let floor = n as f64 * EXACT * EXACT;
    let mut starts = vec![0];
    while starts.len() <= MOST_STEPS && known.freedom() > 2 {
        let (left, freedom) = (known.squares(), (known.freedom() - 1) as f64);
        let mut best = (CERTAIN, 0);
        known.steps(INDEPENDENT, |row, gains| {
            let is_free = |start: &usize| row.abs_diff(*start) >= FEWEST_ROWS;
            if n - row >= FEWEST_ROWS && starts.iter().all(is_free) {
                let certainty = |(gain, left): (&f64, &f64)| gain / (left - gain).max(floor);
                let sum: f64 = gains.iter().zip(&left).map(certainty).sum();
                let certainty = sum * freedom / n_gauges as f64;
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
    let ratio = (per_freedom(&known) / before).sqrt();
    (starts.len() > 1 && ratio < LEFT).then_some((starts, smallest))
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
