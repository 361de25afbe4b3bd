//! Makes the table of all metrology figures.

use rayon::prelude::*;

use crate::finding::{Finding, Id, Verdict};
use crate::min_max::MinMax;
use crate::questions::metrology::case_rows::case_figures;
use crate::questions::metrology::crosstalk::{Alone, crosstalk_figures, intervals_alone};
use crate::questions::metrology::dwell_rows::DwellRows;
use crate::questions::metrology::errors::error_figures;
use crate::questions::metrology::figures::Value;
use crate::questions::metrology::figures::{Cell, Figure, Metrology, Row, Run};
use crate::questions::metrology::figures::{Found, Result};
use crate::questions::metrology::lag_rows;
use crate::questions::metrology::loop_rows::LoopRows;
use crate::questions::metrology::measured;
use crate::questions::metrology::measured::{Measured, OUTPUTS};
use crate::questions::metrology::quantity::Quantity;
use crate::questions::metrology::reason::Reason;
use crate::questions::metrology::settings::{MetrologyError, Rules};
use crate::recording::Axis;
use crate::scoring::MANY_SAMPLES;
use crate::scoring::lag::WORTH_REMOVING;
use crate::scoring::numbers::significant;

/// Ratio of the largest load to full scale above which the table has a note.
pub(crate) const BEYOND: f64 = 1.2;

/// Minimum share of the load's range that the largest cycle spans without a note.
pub(crate) const SMALL: f64 = 0.6;

/// Returns the table of these runs by given rules.
///
/// # Errors
/// [`MetrologyError`] if a setting is out of range or numbers do not match. A figure that the data do not determine is no
/// error: its cell holds a [`Reason`].
pub fn table_by(
    runs: &[Run<'_>],
    rules: &Rules<'_>,
) -> std::result::Result<Metrology, MetrologyError> {
    let merged = LoadCases::of(runs);
    let measured = match &merged {
        Some(cases) => Measured::of(&[cases.run()], rules)?,
        None => Measured::of(runs, rules)?,
    };
    let (axes, full_scale) = (rules.axes, rules.full_scale);
    let alone = intervals_alone(&measured);
    measured.lags(); // measured here by all threads, before the axes need them
    let n_samples = runs.iter().map(|run| run.times.len()).sum();
    let of_axis = |axis| AxisFigures::of(&measured, &alone, axis);
    // With many samples, the columns of several axes would fill the memory, so the axes are measured one after the other.
    let by_axis: Vec<AxisFigures> = match n_samples > MANY_SAMPLES {
        true => (0..axes.len()).map(of_axis).collect(),
        false => (0..axes.len()).into_par_iter().map(of_axis).collect(),
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
                    unit: if quantity.is_time() { "s" } else { axes[axis].unit() },
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
        findings: findings(&measured, &by_axis),
        reversal_thresholds: measured.reversal_thresholds,
        n_recordings: runs.len(),
        n_samples,
        rows,
    })
}

pub(crate) struct AxisFigures {
    outputs: [Vec<(Quantity, Result<Found>)>; OUTPUTS],
    /// Reason why the other quantities are missing.
    missing: Reason,
    /// Span of the largest cycle, as a share of the range.
    cycle_share: Option<f64>,
    /// Share of the conventional loop's mean width that the lag explains.
    lag_share: Option<f64>,
}

impl AxisFigures {
    pub(crate) fn of(measured: &Measured<'_>, alone: &[Alone], axis: usize) -> Self {
        let view = match measured.axis(axis) {
            Ok(view) => view,
            Err(missing) => {
                return Self {
                    outputs: Default::default(),
                    missing,
                    cycle_share: None,
                    lag_share: None,
                };
            }
        };
        let missing = Reason::NoTimes { axis: view.axis };
        let common = |output| {
            let crosstalk = crosstalk_figures(measured, alone, axis, output);
            crosstalk.into_iter().chain(error_figures(&view, output))
        };
        if measured.runs.iter().any(|run| run.is_static) {
            let figures = |output| common(output).chain(case_figures(&view, output)).collect();
            let outputs = std::array::from_fn(figures);
            return Self { outputs, missing, cycle_share: None, lag_share: None };
        }
        let [loops, halved, doubled] =
            [1.0, 0.5, 2.0].map(|factor| LoopRows::of(&view, factor * view.reversal_threshold));
        let dwells = DwellRows::of(&view);
        let of_lag: [_; OUTPUTS] =
            std::array::from_fn(|output| lag_rows::figures(&view, axis, output));
        let figures = |output: usize| {
            let others = [&halved, &doubled].map(|other| other.figures(output));
            let mut of_loops = loops.figures(output);
            for (quantity, found) in &mut of_loops {
                if let Ok(Found { basis: Some(basis), .. }) = found {
                    let size = |all: &Vec<_>| Some(figure(all, *quantity)?.as_ref().ok()?.size);
                    [basis.reversal_threshold_halved, basis.reversal_threshold_doubled] =
                        others.each_ref().map(size);
                }
            }
            let of_lag = [Quantity::TimeLag, Quantity::HysteresisWithoutLag]
                .into_iter()
                .zip(of_lag[output].0.clone());
            (of_loops.into_iter().chain(of_lag))
                .chain(dwells.figures(output))
                .chain(common(output))
                .collect()
        };
        let outputs = std::array::from_fn(figures);
        Self { outputs, missing, cycle_share: loops.share_of_range(), lag_share: of_lag[0].1 }
    }

    fn figures(&self, quantity: Quantity) -> [Result<Found>; OUTPUTS] {
        let found = |all: &Vec<_>| figure(all, quantity).cloned();
        let missing = || Err(self.missing.clone());
        self.outputs.each_ref().map(|all| found(all).unwrap_or_else(missing))
    }
}

fn figure(all: &[(Quantity, Result<Found>)], quantity: Quantity) -> Option<&Result<Found>> {
    all.iter().find(|(own, _)| *own == quantity).map(|(_, found)| found)
}

/// Joins the rows of all load cases into one run without an order in time.
pub(crate) struct LoadCases<'a> {
    axes: &'a [Axis],
    times: Vec<f64>,
    reference: Vec<f64>,
    conventional: Vec<f64>,
    compensated: Vec<f64>,
}

impl<'a> LoadCases<'a> {
    /// Returns the rows of load cases; `None` if samples have times.
    fn of(runs: &[Run<'a>]) -> Option<Self> {
        let with_reference = || runs.iter().filter(|run| !run.reference_axes.is_empty());
        let is_static = runs.iter().any(|run| run.is_static);
        let axes = with_reference().next().filter(|_| is_static)?.reference_axes;
        let joined = |values: fn(&Run<'a>) -> &'a [f64]| -> Vec<f64> {
            let own = with_reference().filter(|run| run.reference_axes == axes);
            own.flat_map(values).copied().collect()
        };
        let n_rows = joined(|run| run.times).len();
        Some(Self {
            axes,
            times: (0..n_rows).map(|row| row as f64).collect(),
            reference: joined(|run| run.reference),
            conventional: joined(|run| run.conventional),
            compensated: joined(|run| run.compensated),
        })
    }

    fn run(&self) -> Run<'_> {
        Run {
            name: "all load cases",
            times: &self.times,
            gauges: &[],
            reference_axes: self.axes,
            reference: &self.reference,
            conventional: &self.conventional,
            compensated: &self.compensated,
            is_static: true,
        }
    }
}

pub(crate) fn finished(
    found: Result<Found>,
    quantity: Quantity,
    axis: Axis,
    full_scale: f64,
) -> Figure {
    let Found { size, place, mut basis } = found?;
    let percent_fs = (!quantity.is_time() && full_scale > 0.0).then(|| 100.0 * size / full_scale);
    if !size.is_finite() || percent_fs.is_some_and(|percent| !percent.is_finite()) {
        return Err(Reason::Overflow { axis });
    }
    if let Some(basis) = &mut basis {
        for other in [&mut basis.reversal_threshold_halved, &mut basis.reversal_threshold_doubled] {
            *other = other.filter(|size| size.is_finite());
        }
    }
    Ok(Value { value: size, percent_fs, place, basis })
}

fn findings(measured: &Measured<'_>, by_axis: &[AxisFigures]) -> Vec<Finding> {
    let found = |id, seen: String| Finding::new(id, Verdict::Doubtful, seen);
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let bare = |run: &&measured::Columns<'_>| run.loads.iter().all(Option::is_none);
    let (count, all) = (measured.runs.iter().filter(bare).count(), measured.runs.len());
    let missing = format!("{count} of {all} recordings have no reference load");
    let missing = (count > 0).then(|| found(Id::WithoutReference, missing));
    let of_axes = (by_axis.iter().enumerate()).flat_map(|(at, figures)| {
        let axis = measured.axes[at].symbol();
        let small = figures.cycle_share.filter(|share| *share < SMALL).map(|share| {
            let share = percent(share);
            found(
                Id::SmallCycle,
                format!("the largest cycle of {axis} spans only {share} of its loads"),
            )
        });
        let lag = figures.lag_share.filter(|share| *share > WORTH_REMOVING);
        let lag = lag.zip(measured.lags()[0][at].as_ref().ok()).map(|(share, lag)| {
            let secs = significant(lag.seconds, 3);
            let seen =
                format!("the uncompensated load of {axis} comes {secs} s after the reference");
            found(Id::LagInLoop, seen)
                .with(format!("{} of the mean width of its loop", percent(share)))
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
