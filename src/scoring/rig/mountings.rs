//! Finds blocks of consecutive rows of a table of load cases between which the zeros of the gauges differ, because the sensor
//! was mounted anew.
//!
//! Loads, their squares, and for an ordered table the direction of each load explain the gauges first. Then steps of the zeros
//! are added one after the other.

use faer::Mat;
use serde_json::json;

use crate::{
    finding::{Finding, Id, Verdict},
    recording::Recording,
    scoring::{
        faults::are_of_one_table,
        numbers::{percent, significant},
        rig::{
            Rig,
            fits::{self, Forward},
            steps::{Steps, step_at},
        },
    },
    shown::counted,
};

/// Minimum number of rows of a mounting, and maximum number of steps.
const FEWEST_ROWS: usize = 3;
const MOST_STEPS: usize = 11;
/// Minimum part of a step that the other columns do not explain.
const INDEPENDENT: f64 = 0.3;
/// Change of the load from one row to the next, in its variance, below which a table is ordered.
const ORDERED: f64 = 0.5;
/// Weight of each step in the criterion by which their number is chosen. The criterion of Bayes has 1.
const WEIGHT: f64 = 3.0;
/// Minimum F statistic of the steps as a mean over the gauges, and maximum ratio of the residuals with and without them.
const CERTAIN: f64 = 60.0;
const LEFT: f64 = 0.4;
/// Smallest standard deviation of a gauge's residual, as a share of the gauge's deviation.
const EXACT: f64 = 1e-5;
/// Smallest difference of a zero that is reported (full scale).
const SMALLEST: f64 = 0.002;

/// Row of a table, or several rows in succession with one load: the rows of the file, counted from 0, and mean values.
struct Row {
    first: usize,
    last: usize,
    case: usize,
    n: f64,
    gauges: Vec<f64>,
    loads: Vec<f64>,
}

impl Rig {
    /// Returns findings of tables whose zeros differ between blocks of rows.
    pub(super) fn mountings(&self, recordings: &[&Recording]) -> Vec<Finding> {
        let tables = recordings.chunk_by(|a, b| are_of_one_table(a, b));
        tables
            .filter(|cases| cases.len() > 1)
            .filter_map(|cases| self.mountings_of(cases))
            .collect()
    }

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
            let gauges = self.standard(own.gauges_at(k));
            let number = own.times()[k] as usize;
            match rows.last_mut().filter(|row| row.case == case) {
                Some(row) => {
                    row.last = number;
                    row.n += 1.0;
                    let add = |(mean, value): (&mut f64, f64)| *mean += (value - *mean) / row.n;
                    row.gauges.iter_mut().zip(gauges).for_each(add);
                    row.loads.iter_mut().zip(loads).for_each(add);
                }
                None => rows.push(Row {
                    first: number,
                    last: number,
                    case,
                    n: 1.0,
                    gauges: gauges.collect(),
                    loads: loads.collect(),
                }),
            }
        }
        rows
    }

    fn mountings_of(&self, cases: &[&Recording]) -> Option<Finding> {
        let rows = self.rows(cases);
        let starts = starts(&rows)?;
        let blocks: Vec<&[Row]> = starts
            .iter()
            .zip(starts.iter().skip(1).chain([&rows.len()]))
            .map(|(from, to)| &rows[*from..*to])
            .collect();
        let shape = &self.shape;
        let sums = |blocks: &[&[Row]]| {
            let mut all = Mat::<f64>::zeros(shape.width(), shape.width());
            for block in blocks {
                let wide: Vec<Vec<f64>> = block
                    .iter()
                    .map(|row| [&[0.0, 0.0], &*row.gauges, &row.loads].concat())
                    .collect();
                let mean =
                    |at: usize| wide.iter().map(|row| row[at]).sum::<f64>() / wide.len() as f64;
                let means: Vec<f64> = (0..shape.width()).map(mean).collect();
                for row in &wide {
                    let value = |at: usize| if at == 0 { 1.0 } else { row[at] - means[at] };
                    all += Mat::from_fn(shape.width(), shape.width(), |i, j| value(i) * value(j));
                }
            }
            all
        };
        let (one, each) = (sums(&[&rows]), sums(&blocks));
        let fit = Forward::of(&each, shape);
        let inverse = fit.inverse(shape);
        // Loads that the zeros of a block look like, with an unknown constant.
        let zeros = |block: &&[Row]| -> Vec<f64> {
            let of_axis = |axis: usize| {
                let shown = |row: &Row| {
                    let gauges = row.gauges.iter().enumerate();
                    let shown = gauges.map(|(at, gauge)| inverse[(axis, at)] * gauge);
                    shown.sum::<f64>() - row.loads[axis]
                };
                block.iter().map(shown).sum::<f64>() / block.len() as f64
            };
            (0..shape.axes.len()).map(of_axis).collect()
        };
        let zeros: Vec<Vec<f64>> = blocks.iter().map(zeros).collect();
        let spread = |axis: usize| {
            let all = || zeros.iter().map(|own| own[axis]);
            all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
        };
        let most = (0..shape.axes.len()).max_by(|a, b| spread(*a).total_cmp(&spread(*b)))?;
        if spread(most) < SMALLEST {
            return None;
        }
        let ranges: Vec<[usize; 2]> = blocks
            .iter()
            .map(|block| [block[0].first + 1, block[block.len() - 1].last + 1])
            .collect();
        let words: Vec<String> = ranges.iter().map(|[from, to]| format!("{from}–{to}")).collect();
        let seen = format!(
            "the table has {}: between the rows {}, the zeros of the gauges differ",
            counted(blocks.len(), "mounting"),
            words.join(", ")
        );
        let (axis, full_scale) = (shape.axes[most], shape.full_scale[most]);
        let [with, without] =
            [(&one, 1), (&each, blocks.len())].map(|(sums, n)| fits::fit_error(sums, n, shape));
        let [shown_with, shown_without] =
            [with, without].map(|error| significant(100.0 * error, 2));
        let figures = format!(
            "by up to {} {} of {}, {} of full scale; the error of a conventional fit is {shown_with} % of full scale, and {shown_without} % with a zero for each mounting",
            significant(spread(most) * full_scale, 3),
            axis.unit(),
            axis.symbol(),
            percent(spread(most)),
        );
        let facts = ranges.iter().zip(&zeros).map(|(rows, own)| {
            let change = |axis: usize| (own[axis] - zeros[0][axis]) * shape.full_scale[axis];
            let changes: Vec<f64> = (0..shape.axes.len()).map(change).collect();
            let axes: Vec<&str> = shape.axes.iter().map(|axis| axis.symbol()).collect();
            json!({ "rows": rows, "axes": axes, "zero_compared_with_first": changes })
        });
        let found = Finding::new(Id::Mountings, Verdict::Doubtful, seen).with(figures);
        Some(found.costing((with - without).max(0.0)).facts(facts.collect()))
    }
}

/// Returns the first row of each mounting, if there are several.
fn starts(rows: &[Row]) -> Option<Vec<usize>> {
    let n = rows.len();
    let (n_axes, n_gauges) = (rows.first()?.loads.len(), rows[0].gauges.len());
    let gauges: Vec<Vec<f64>> =
        (0..n_gauges).map(|at| rows.iter().map(|row| row.gauges[at]).collect()).collect();
    let mut known = Steps::new(vec![0; n], &gauges);
    let loads: Vec<Vec<f64>> =
        (0..n_axes).map(|at| rows.iter().map(|row| row.loads[at]).collect()).collect();
    let powers = if n_axes == 1 { 3 } else { 2 };
    for load in &loads {
        for power in 1..=powers {
            known.explain(&load.iter().map(|load| load.powi(power)).collect::<Vec<_>>());
        }
    }
    let mut changes: Vec<f64> = loads.iter().filter_map(|own| change_by_row(own)).collect();
    changes.sort_by(f64::total_cmp);
    if changes.get(changes.len() / 2).is_some_and(|change| *change < ORDERED) {
        for load in &loads {
            known.explain(&directions(load));
        }
    }
    let floor = n as f64 * EXACT * EXACT;
    let squares = |known: &Steps| -> Vec<f64> {
        known.squares().into_iter().map(|own| own.max(floor)).collect()
    };
    let (before, freedom) = (squares(&known), known.freedom());
    let score = |squares: &[f64], n_steps: usize| {
        let logarithms = squares.iter().map(|own| own.ln()).sum::<f64>();
        n as f64 * logarithms + WEIGHT * (n as f64).ln() * ((n_gauges + 1) * n_steps) as f64
    };
    let mut starts = vec![0];
    let mut best = (score(&before, 0), starts.clone(), before.clone(), freedom);
    while starts.len() <= MOST_STEPS && known.freedom() > 2 {
        let left = squares(&known);
        let mut most = (0.0, 0);
        known.steps(INDEPENDENT, |row, gains| {
            let is_free = |start: &usize| row.abs_diff(*start) >= FEWEST_ROWS;
            if n - row >= FEWEST_ROWS && starts.iter().all(is_free) {
                let fall = |(gain, left): (&f64, &f64)| -(1.0 - gain / left).max(1e-6).ln();
                let falls: f64 = gains.iter().zip(&left).map(fall).sum();
                if falls > most.0 {
                    most = (falls, row);
                }
            }
        });
        if most.0 <= 0.0 || !known.explain(&step_at(most.1, n)) {
            break;
        }
        starts.push(most.1);
        let left = squares(&known);
        let score = score(&left, starts.len() - 1);
        if score < best.0 {
            best = (score, starts.clone(), left, known.freedom());
        }
    }
    let (_, mut starts, after, free) = best;
    let (n_steps, free) = ((starts.len() - 1) as f64, free as f64);
    let certainty = |(before, after): (&f64, &f64)| (before - after) / n_steps / (after / free);
    let certainty = before.iter().zip(&after).map(certainty).sum::<f64>() / n_gauges as f64;
    let per_freedom = |squares: &[f64], freedom: f64| squares.iter().sum::<f64>() / freedom;
    let ratio = (per_freedom(&after, free) / per_freedom(&before, freedom as f64)).sqrt();
    starts.sort_unstable();
    (n_steps > 0.0 && certainty > CERTAIN && ratio < LEFT).then_some(starts)
}

/// Returns half the mean squared change of a load from row to row, divided by its variance.
fn change_by_row(load: &[f64]) -> Option<f64> {
    let n = load.len() as f64;
    let mean = load.iter().sum::<f64>() / n;
    let variance = load.iter().map(|load| (load - mean).powi(2)).sum::<f64>() / n;
    let changes = load.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>() / (n - 1.0);
    (variance > 0.0).then(|| changes / (2.0 * variance))
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
