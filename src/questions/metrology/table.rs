//! Computes all metrology figures, and shows them in tables.

use std::collections::HashMap;

use rayon::prelude::*;

use crate::{
    finding::{Finding, Id, Verdict},
    min_max::MinMax,
    questions::metrology::{
        self,
        dwell_rows::{
            Response, case_figures, crosstalk_figures, dwell_figures, error_figures, noise_figures,
            responses, sensitivity, temperature_figures, zero_return,
        },
        figures::{
            Basis, Figure, Found, Metrology, MetrologyError, OUTPUTS, Quantity, Reason, Row, Rules,
            Run, Value,
        },
        loop_rows::{LoopRows, lag_figures},
        measured::{Columns, Lags, Measured},
    },
    recording::Axis,
    report::{
        table::{self, Cell, Column, Table},
        trace::{Shown, Trace},
    },
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
                metrology::Cell {
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

type Output = fn(&metrology::Cell) -> &Figure;

const OUTPUT_FIGURES: [(Trace, Output); 2] = [
    (Trace::Conventional, |cell| &cell.conventional),
    (Trace::Compensated, |cell| &cell.compensated),
];

/// Returns a table of one axis (the axis at this index) with all figures but crosstalk, one row for each figure.
pub fn axis_figures(metrology: &Metrology, at: usize, shown: Shown) -> Table {
    let axis = metrology.axes[at];
    let title = format!(
        "{axis} [{}], full scale {}, reversal threshold {}",
        axis.unit(),
        significant(metrology.full_scale[at], 4),
        significant(metrology.reversal_thresholds[at], 3)
    );
    let outputs = OUTPUT_FIGURES.into_iter().flat_map(|output| {
        let units = shown.both((false, axis.unit()), (true, "% FS"));
        units.into_iter().map(move |(in_percent, unit)| (output, in_percent, unit))
    });
    let shown_rows = metrology.shown_rows().filter(|row| row.quantity.crosstalk_from().is_none());
    let rows = Table::of(shown_rows.map(|row| (row, &row.cells[at])))
        .column(Column::words("Figure"), move |(row, cell)| {
            let name = &row.definition.name;
            defined(
                row,
                match row.quantity {
                    Quantity::LoopArea if shown == Shown::PercentFs => format!("{name} [% FS²]"),
                    _ if cell.unit == axis.unit() => name.clone(),
                    _ => format!("{name} [{}]", cell.unit),
                },
            )
        })
        .instead(|(_, cell)| match (&cell.conventional, &cell.compensated) {
            (Err(before), Err(after)) if before == after => {
                Some(missing(before, shown == Shown::PercentFs))
            }
            _ => None,
        })
        .columns(
            outputs,
            |((trace, _), _, unit)| Column::of(*trace, unit),
            |(_, cell), ((_, output), in_percent, _)| match output(cell) {
                Ok(value) => figure_cell(cell, value, *in_percent, shown),
                Err(_) if shown == Shown::All && *in_percent => Cell::continued(),
                Err(reason) => missing(reason, *in_percent),
            },
        );
    let is_comparable = |row: &Row, before: &Value, after: &Value| {
        row.quantity.is_load() && before.value.is_sign_positive() == after.value.is_sign_positive()
    };
    let rows = rows.column(Column::change(), |(row, cell)| {
        match (&cell.conventional, &cell.compensated) {
            (Ok(before), Ok(after)) if is_comparable(row, before, after) => {
                Cell::change(before.value.abs(), after.value.abs())
            }
            _ => Cell::none(),
        }
    });
    if shown != Shown::All {
        return rows.table(title, "");
    }
    rows.words("cycles, load range", |(_, cell)| {
        let basis = OUTPUT_FIGURES.iter().find_map(|(_, output)| output(cell).as_ref().ok()?.basis);
        basis.map_or_else(String::new, |basis| cycles(&basis))
    })
    .about("Number of load cycles from which the figure is computed, and the share of the load range that all these cycles have in common")
    .table(title, "")
}

fn cycles(basis: &Basis) -> String {
    let share = significant(100.0 * basis.range_share, 2);
    format!("{}, {share} %", basis.n_cycles)
}

fn figure_cell(cell: &metrology::Cell, value: &Value, in_percent: bool, shown: Shown) -> Cell {
    let is_load = !(cell.unit == "s" || cell.unit.starts_with("reading"));
    let shown = match value.percent_fs {
        _ if !in_percent => Cell::digits(Some(value.value), 4),
        None if !is_load && shown == Shown::PercentFs => Cell::digits(Some(value.value), 4),
        None if !is_load => Cell::none(),
        None => missing(&Reason::NoFullScale { axis: cell.axis }, in_percent),
        percent => Cell::digits(percent, 3),
    };
    match shown.value {
        table::Value::Number(_) => shown.about(hover_text(cell, value)),
        _ => shown,
    }
}

fn hover_text(cell: &metrology::Cell, value: &Value) -> String {
    let mut about = format!("{} {}", significant(value.value, 4), cell.unit);
    if let Some(percent) = value.percent_fs {
        about.push_str(&format!(" = {} % of full scale", significant(percent, 4)));
    }
    if let Some(uncertainty) = value.uncertainty {
        let uncertainty = significant(uncertainty, 2);
        about.push_str(&format!(", standard uncertainty {uncertainty} {}", cell.unit));
    }
    if let Some(place) = &value.place {
        let [from, to] = [place.from_secs, place.to_secs].map(|secs| significant(secs, 5));
        about.push_str(&format!("\n{}, {from} s to {to} s", place.name));
    }
    if let Some(basis) = &value.basis {
        about.push_str(&format!(
            "\nNumber of cycles, and the share of the load range that all have in common: {}",
            cycles(basis)
        ));
    }
    about
}

fn missing(reason: &Reason, in_percent: bool) -> Cell {
    Cell::missing(reason.word(in_percent), reason.to_string())
}

fn defined(row: &Row, name: String) -> Cell {
    Cell::words(name).about(row.definition.sentences().join("\n"))
}

pub fn overview(metrology: &Metrology, shown: Shown) -> Table {
    let title = match shown {
        Shown::PercentFs => "% of full scale",
        Shown::Units => "N and N·m",
        Shown::All => "N and N·m, and % of full scale",
    };
    let axes = metrology.axes.iter().enumerate();
    let tables =
        axes.map(|(at, axis)| (axis.symbol().to_owned(), axis_figures(metrology, at, shown)));
    Table::beside(title, tables)
}

/// Returns the crosstalk table: two rows per loaded axis, with one column for each axis that responds. If the figures of a
/// loaded axis are missing, one row gives the reason. Returns `None` without any figure of crosstalk.
pub fn crosstalk(metrology: &Metrology) -> Option<Table> {
    let axes = &metrology.axes;
    let rows = metrology.shown_rows();
    let rows = rows.filter_map(|row| Some((row.quantity.crosstalk_from()?, row)));
    let rows = rows.flat_map(|(from, row)| {
        let outputs = match shared_reason(row) {
            Some(reason) => vec![Err(reason)],
            None => OUTPUT_FIGURES.map(Ok).to_vec(),
        };
        outputs.into_iter().map(move |output| (from, row, output))
    });
    let table = Table::of(rows)
        .column(Column::words("Axis loaded alone"), |(from, row, _)| {
            defined(row, format!("from {}", from.symbol()))
        })
        .instead(|(.., output)| output.err().map(|reason| missing(reason, true)))
        .column(Column::words("Output"), |(.., output)| match output {
            Ok((trace, _)) => Cell::words(trace.label()).about(trace.explanation()),
            Err(_) => Cell::none(),
        })
        .columns(
            axes.iter().enumerate(),
            |(_, axis)| Column::numbers(axis.symbol()),
            |(_, row, output), (at, _)| {
                let cell = &row.cells[*at];
                match output.and_then(|(_, output)| output(cell).as_ref()) {
                    Ok(value) => figure_cell(cell, value, true, Shown::PercentFs),
                    // An axis has no crosstalk onto itself, so this cell is text, not a missing number.
                    Err(reason @ Reason::LoadedAxis { .. }) => {
                        Cell::words(reason.word(true)).about(reason.to_string())
                    }
                    Err(reason) => missing(reason, true),
                }
            },
        )
        .table("Crosstalk, % of full scale", "");
    (axes.len() > 1 && !table.rows.is_empty()).then_some(table)
}

/// Returns the reason why the crosstalk figures of a row are missing, if the reason is the same for all axes but the loaded
/// axis.
fn shared_reason(row: &Row) -> Option<&Reason> {
    let figures = row.cells.iter().flat_map(|cell| [&cell.conventional, &cell.compensated]);
    let mut others = figures.filter(|figure| !matches!(figure, Err(Reason::LoadedAxis { .. })));
    let reason = others.next()?.as_ref().err()?;
    others.all(|other| other.as_ref().err() == Some(reason)).then_some(reason)
}

/// Returns a table for a file, with one row per quantity and axis. A row has the uncompensated and the compensated figure, in
/// the unit of the axis and in % of full scale. Each figure has the place in a recording that it comes from, or a reason why
/// it is missing.
///
/// Full scale and reversal threshold are in the axis' load unit.
pub fn figure_records(metrology: &Metrology) -> Table {
    let number = |value: f64| Cell::number(value, value.to_string());
    let known = |value: Option<f64>| value.map_or_else(Cell::none, number);
    let rows = metrology.rows.iter().flat_map(|row| {
        let cells = row.cells.iter().enumerate();
        cells.map(move |(at, cell)| (at, &row.definition, cell))
    });
    let mut rows = Table::of(rows)
        .words("id", |(_, about, _)| &about.id)
        .words("quantity", |(_, about, _)| &about.name)
        .words("axis", |(.., cell)| cell.axis.symbol())
        .words("unit", |(.., cell)| cell.unit)
        .column(Column::words("full_scale"), |(at, ..)| number(metrology.full_scale[*at]));
    type Numbers = [(&'static str, fn(&Value) -> Option<f64>)];
    let sizes: &Numbers = &[
        ("", |value| Some(value.value)),
        ("_percent_fs", |value| value.percent_fs),
        ("_uncertainty", |value| value.uncertainty),
    ];
    let basis: &Numbers = &[
        ("_cycles", |value| Some(value.basis?.n_cycles as f64)),
        ("_range_share", |value| Some(value.basis?.range_share)),
    ];
    let outputs = [("conventional", OUTPUT_FIGURES[0].1), ("compensated", OUTPUT_FIGURES[1].1)];
    for (name, output) in outputs {
        rows = rows
            .columns(
                sizes,
                |(what, _)| Column::words(format!("{name}{what}")),
                |(.., cell), (_, of)| known(output(cell).as_ref().ok().and_then(of)),
            )
            .words(format!("{name}_place"), |(.., cell)| {
                let place = output(cell).as_ref().ok().and_then(|value| value.place.as_ref());
                place.map_or_else(String::new, |place| {
                    format!("{} {} s to {} s", place.name, place.from_secs, place.to_secs)
                })
            })
            .words(format!("{name}_reason"), |(.., cell)| {
                output(cell).as_ref().map_or_else(Reason::to_string, |_| String::new())
            });
    }
    rows = rows
        .column(Column::words("reversal_threshold"), |(at, ..)| {
            number(metrology.reversal_thresholds[*at])
        })
        .words("definition", |(_, about, _)| about.definition)
        .words("source", |(_, about, _)| about.source)
        .words("free_running", |(_, about, _)| about.free_running);
    for (name, output) in outputs {
        rows = rows.columns(
            basis,
            |(what, _)| Column::words(format!("{name}{what}")),
            |(.., cell), (_, of)| known(output(cell).as_ref().ok().and_then(of)),
        );
    }
    rows.table("", "")
}

#[cfg(test)]
mod tests {
    use crate::questions::metrology::figures::Run;
    use crate::questions::metrology::table::*;
    use crate::questions::metrology::tests::{bench, table_of};
    use crate::recording::Axis;

    /// Fx with 10 N full scale and Mx without one. The error is 1 for Uncompensated and 0.5 for Compensated at all samples.
    fn measured() -> Metrology {
        let times: Vec<f64> = (0..200).map(|k| f64::from(k) / 10.0).collect();
        let loads =
            times.iter().flat_map(|time| [(10.0 * time.sin()).round(), (8.0 * time.cos()).round()]);
        let reference: Vec<f64> = loads.collect();
        let off = |by: f64| reference.iter().map(|load| load + by).collect::<Vec<_>>();
        let axes = [Axis::Fx, Axis::Mx];
        let run = Run {
            name: "a",
            times: &times,
            gauges: &[],
            reference_axes: &axes,
            reference: &reference,
            conventional: &off(1.0),
            compensated: &off(0.5),
            auxiliary: None,
            is_static: false,
            is_load_case: false,
            is_table: false,
        };
        table_of(&[run], &axes, &[10.0, 0.0])
    }

    fn texts(table: &Table, name: &str) -> Vec<String> {
        let row = table.rows.iter().find(|row| row[0].text == name).unwrap();
        row.iter().map(|cell| cell.text.clone()).collect()
    }

    #[test]
    fn a_figure_is_the_same_in_every_table_and_newtons_are_never_percent() {
        let measured = measured();
        for (shown, expected) in [
            (Shown::PercentFs, ["RMSE", "10.0", "5.00", "-50.0 %", "no FS", "no FS", "-50.0 %"]),
            (Shown::Units, ["RMSE", "1.000", "0.5000", "-50.0 %", "1.000", "0.5000", "-50.0 %"]),
        ] {
            assert_eq!(texts(&overview(&measured, shown), "RMSE"), expected);
        }
        let of_axis = axis_figures(&measured, 0, Shown::All);
        let expected = ["RMSE", "1.000", "10.0", "0.5000", "5.00", "-50.0 %"];
        assert_eq!(texts(&of_axis, "RMSE")[..6], expected);
        assert_eq!(texts(&of_axis, "RMSE")[6..], [""]);
        let hysteresis = texts(&of_axis, "Hysteresis");
        assert_eq!(hysteresis[6], "1, 100 %");
    }

    #[test]
    fn every_row_has_a_cell_for_each_column() {
        let measured = measured();
        assert_eq!(crosstalk(&measured), None, "no axis is loaded alone");
        let crosstalk = crosstalk(&bench(3e-4, [0.01, 0.02])).unwrap();
        let mut tables = vec![figure_records(&measured), crosstalk];
        for shown in [Shown::PercentFs, Shown::Units, Shown::All] {
            tables.push(overview(&measured, shown));
        }
        for table in tables {
            let n_columns = table.columns.len();
            assert!(table.rows.iter().all(|row| row.len() == n_columns));
            assert!(!table.rows.is_empty());
        }
    }
}
