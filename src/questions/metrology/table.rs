//! Computes the table of all metrology figures.

use std::collections::HashMap;

use rayon::prelude::*;

use crate::{
    finding::{Finding, Id, Verdict},
    min_max::MinMax,
    questions::metrology::{
        dwell_rows::{
            Response, case_figures, crosstalk_figures, dwell_figures, error_figures, noise_figures,
            responses, sensitivity, temperature_figures, zero_return,
        },
        figures::{
            Cell, Figure, Found, Metrology, MetrologyError, OUTPUTS, Quantity, Reason, Row, Rules,
            Run, Value,
        },
        loop_rows::{LoopRows, lag_figures},
        measured::{Columns, Lags, Measured},
    },
    recording::Axis,
    scoring::{MANY_SAMPLES, lag::WORTH_REMOVING, numbers::significant},
};

/// Ratio of the largest load to full scale, above which a finding warns that the loads exceed full scale.
const BEYOND: f64 = 1.2;

/// Span of the largest cycle, as a share of the load range, below which a finding warns of a small cycle.
const SMALL: f64 = 0.6;

/// Returns the metrology table of these recordings. `lags` are their time lags, see
/// [`lags_of`](crate::questions::metrology::lags_of).
///
/// # Errors
/// [`MetrologyError`] if a setting is out of range, or if the lengths of the inputs do not match. A
/// figure that the data do not determine is no error: its cell has a [`Reason`].
pub fn table_by(
    runs: &[Run<'_>],
    rules: &Rules<'_>,
    lags: Lags,
) -> Result<Metrology, MetrologyError> {
    let cases = joined_cases(runs);
    let measured = match &cases {
        None => Measured::of(runs, rules)?,
        Some((reference_axes, [times, gauges, reference, conventional, compensated])) => {
            let name = "all load cases";
            let (is_static, is_load_case, is_table, auxiliary) = (true, true, true, None);
            let all = Run {
                name,
                times,
                gauges,
                reference_axes,
                reference,
                conventional,
                compensated,
                auxiliary,
                is_static,
                is_load_case,
                is_table,
            };
            Measured::of(&[all], rules)?
        }
    };
    let (axes, full_scale) = (rules.axes, rules.full_scale);
    let responses = responses(&measured);
    let n_samples = runs.iter().map(|run| run.times.len()).sum();
    let of_axis = |axis| AxisFigures::of(&measured, &responses, &lags, axis);
    // With many samples, the columns of several axes would fill the memory, so the axes are measured one after another.
    let by_axis: Vec<AxisFigures> = if n_samples > MANY_SAMPLES {
        (0..axes.len()).map(of_axis).collect()
    } else {
        (0..axes.len()).into_par_iter().map(of_axis).collect()
    };
    let rows = (Quantity::all(axes).into_iter())
        .map(|quantity| {
            let cells = (0..axes.len()).map(|axis| {
                let figures = by_axis[axis].figures(quantity);
                let scale = full_scale[axis];
                let [conventional, compensated] =
                    figures.map(|found| finished(found, quantity, axes[axis], scale));
                Cell {
                    axis: axes[axis],
                    unit: quantity.unit(axes[axis]),
                    conventional,
                    compensated,
                }
            });
            Row { quantity, definition: quantity.definition(), cells: cells.collect() }
        })
        .collect();
    Ok(Metrology {
        axes: axes.to_vec(),
        full_scale: full_scale.to_vec(),
        findings: findings(&measured, &lags, &by_axis),
        reversal_thresholds: measured.reversal_thresholds,
        n_recordings: runs.len(),
        n_samples,
        rows,
    })
}

#[derive(Default)]
struct AxisFigures {
    outputs: [HashMap<Quantity, Figure>; OUTPUTS],
    /// Reason why all quantities without a figure in `outputs` are missing; `None` if no quantity is missing.
    missing: Option<Reason>,
    /// Span of the largest load cycle, as a share of the load range of all recordings.
    cycle_share: Option<f64>,
    /// Share of the mean width of the uncompensated loop that the time lag explains.
    lag_share: Option<f64>,
}

impl AxisFigures {
    fn of(
        measured: &Measured<'_>,
        responses: &[Found<Response>],
        lags: &Lags,
        axis: usize,
    ) -> Self {
        let view = match measured.axis(axis) {
            Ok(view) => view,
            Err(missing) => return Self { missing: Some(missing), ..Self::default() },
        };
        let common = |output| {
            let crosstalk = crosstalk_figures(measured, responses, axis, output);
            let errors = error_figures(&view, output);
            let sensitivity = (Quantity::Sensitivity, sensitivity(&view));
            crosstalk.into_iter().chain(errors).chain([sensitivity])
        };
        if measured.runs.iter().any(|columns| columns.run.is_static) {
            let have_order = measured.runs.iter().all(|columns| !columns.run.is_load_case);
            let loops = have_order.then(|| LoopRows::of(&view));
            // A place in a recording is an interval of time.
            let of_rows = |(quantity, figure): (Quantity, Figure)| {
                (quantity, figure.map(|found| Value { place: None, ..found }))
            };
            let figures = |output| {
                let of_order = match &loops {
                    Some(loops) => {
                        let zero_return = (Quantity::ZeroReturn, zero_return(&view, output));
                        loops.figures(output).into_iter().chain([zero_return]).collect()
                    }
                    None => case_figures(&view, output).to_vec(),
                };
                common(output).chain(of_order).map(of_rows).collect()
            };
            return Self {
                outputs: std::array::from_fn(figures),
                missing: Some(Reason::NoTimes { axis: view.axis }),
                cycle_share: loops.as_ref().and_then(LoopRows::share_of_range),
                ..Self::default()
            };
        }
        let loops = LoopRows::of(&view);
        let of_lag: [_; OUTPUTS] =
            std::array::from_fn(|output| lag_figures(&view, lags, axis, output));
        let figures = |output: usize| {
            (loops.figures(output).into_iter().chain(of_lag[output].0.clone()))
                .chain(dwell_figures(&view, output))
                .chain(noise_figures(&view, output))
                .chain(temperature_figures(&view, output))
                .chain(common(output))
                .collect()
        };
        Self {
            outputs: std::array::from_fn(figures),
            missing: None,
            cycle_share: loops.share_of_range(),
            lag_share: of_lag[0].1,
        }
    }

    fn figures(&self, quantity: Quantity) -> [Figure; OUTPUTS] {
        self.outputs.each_ref().map(|all| match all.get(&quantity) {
            Some(found) => found.clone(),
            None => Err(self.missing.clone().expect("each missing figure states its reason")),
        })
    }
}

/// Joined columns of several recordings: times, gauges, reference, uncompensated and compensated load.
type Joined = [Vec<f64>; 5];

/// Joins the load cases of all recordings into one table, because load cases have no order in time. Also returns the axes of
/// the reference load. Returns `None` if the samples have an order.
fn joined_cases<'a>(runs: &[Run<'a>]) -> Option<(&'a [Axis], Joined)> {
    let are_cases = runs.iter().any(|run| run.is_load_case);
    let first = runs.iter().find(|run| !run.reference_axes.is_empty())?;
    let axes = are_cases.then_some(first.reference_axes)?;
    let joined = |values: fn(&Run<'a>) -> &'a [f64]| -> Vec<f64> {
        let joined_runs = runs.iter().filter(|run| run.reference_axes == axes);
        joined_runs.flat_map(values).copied().collect()
    };
    let n_rows = joined(|run| run.times).len();
    let columns = [
        (0..n_rows).map(|row| row as f64).collect(),
        joined(|run| run.gauges),
        joined(|run| run.reference),
        joined(|run| run.conventional),
        joined(|run| run.compensated),
    ];
    Some((axes, columns))
}

/// Returns the figure with its percentage of full scale added. A figure that is too large for a number is replaced by the
/// reason.
fn finished(figure: Figure, quantity: Quantity, axis: Axis, full_scale: f64) -> Figure {
    let found = figure?;
    let value = found.value;
    let whole = if quantity == Quantity::LoopArea { full_scale * full_scale } else { full_scale };
    let percent_fs = (quantity.is_load() && whole > 0.0).then(|| 100.0 * value / whole);
    if !value.is_finite() || percent_fs.is_some_and(|percent| !percent.is_finite()) {
        return Err(Reason::Overflow { axis });
    }
    Ok(Value { percent_fs, ..found })
}

fn findings(measured: &Measured<'_>, lags: &Lags, by_axis: &[AxisFigures]) -> Vec<Finding> {
    let found = |id, seen: String| Finding::new(id, Verdict::Doubtful, seen);
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let bare = |run: &&Columns<'_>| run.loads.iter().all(Option::is_none);
    let (count, all) = (measured.runs.iter().filter(bare).count(), measured.runs.len());
    let missing = format!("{count} of {all} recordings have no reference load");
    let missing = (count > 0).then(|| found(Id::WithoutReference, missing));
    let of_axes = (by_axis.iter().enumerate()).flat_map(|(at, figures)| {
        let axis = measured.axes[at].symbol();
        let small = figures.cycle_share.filter(|share| *share < SMALL).map(|share| {
            let share = percent(share);
            found(
                Id::SmallCycle,
                format!("the largest cycle of {axis} spans only {share} of its load range"),
            )
        });
        let lag = figures.lag_share.filter(|share| *share > WORTH_REMOVING);
        let lag = lag.zip(lags[0][at].as_ref().ok()).map(|(share, lag)| {
            let secs = significant(lag.seconds, 3);
            let seen =
                format!("the uncompensated load of {axis} lags {secs} s behind the reference");
            found(Id::LagInLoop, seen).with(format!(
                "{} of the mean width of the hysteresis loop come from this lag",
                percent(share)
            ))
        });
        full_scale_finding(measured, at).into_iter().chain(small).chain(lag)
    });
    missing.into_iter().chain(of_axes).collect()
}

fn full_scale_finding(measured: &Measured<'_>, at: usize) -> Option<Finding> {
    let (axis, full_scale) = (measured.axes[at], measured.full_scale[at]);
    let (symbol, unit) = (axis.symbol(), axis.unit());
    if full_scale == 0.0 {
        let seen = format!("{symbol} has no full scale");
        return Some(Finding::new(Id::NoFullScale, Verdict::Doubtful, seen));
    }
    let loads = measured.runs.iter().filter_map(|run| run.loads[at].as_ref());
    let reaches = loads.flat_map(|load| load.iter()).collect::<MinMax>().magnitude();
    let [reached, full] = [reaches, full_scale].map(|load| significant(load, 4));
    let seen = format!("{symbol} reaches {reached} {unit}, beyond its full scale of {full} {unit}");
    (reaches.is_finite() && reaches > BEYOND * full_scale)
        .then(|| Finding::new(Id::BeyondFullScale, Verdict::Doubtful, seen))
}
