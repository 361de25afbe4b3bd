//! Tables of metrology figures.

use crate::{
    questions::metrology::{
        self,
        figures::{Basis, Figure, Metrology, Quantity, Reason, Row, Value},
    },
    report::{
        table::{self, Cell, Column, Table},
        trace::{Shown, Trace},
    },
    scoring::numbers::significant,
};

type Output = fn(&metrology::Cell) -> &Figure;

const OUTPUTS: [(Trace, Output); 2] = [
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
    let outputs = OUTPUTS.into_iter().flat_map(|output| {
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
        let basis = OUTPUTS.iter().find_map(|(_, output)| output(cell).as_ref().ok()?.basis);
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
            None => OUTPUTS.map(Ok).to_vec(),
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
    let outputs = [("conventional", OUTPUTS[0].1), ("compensated", OUTPUTS[1].1)];
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
    use super::*;
    use crate::questions::metrology::figures::Run;
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
