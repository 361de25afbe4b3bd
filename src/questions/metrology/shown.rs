//! Metrology figures as tables.

use crate::questions::errors::trace::{Shown, Trace};
use crate::questions::loops::shown::{MOVES, moves};
use crate::questions::metrology;
use crate::questions::metrology::figures::{Basis, Figure, Metrology, Row, Value};
use crate::questions::metrology::quantity::Quantity;
use crate::questions::metrology::reason::Reason;
use crate::report::table;
use crate::report::table::{Cell, Column, Table};
use crate::scoring::numbers::significant;

/// The figures of the axis at this place, one row each, but those of crosstalk.
pub fn axis_figures(metrology: &Metrology, at: usize, shown: Shown) -> Table {
    let axis = metrology.axes[at];
    let mut columns = vec![Column::words("Figure")];
    columns.extend(shown.columns(axis.unit()));
    if shown == Shown::All {
        columns.push(Column::change());
        columns.push(Column {
            about: "How many cycles the figure rests on, and which share of all loads they have in common".to_owned(),
            ..Column::words("cycles")
        });
        columns.extend([Trace::Conventional, Trace::Compensated].map(|trace| Column {
            about: MOVES.to_owned(),
            ..Column::words(format!("{} at ½, 2 × dead band", trace.label()))
        }));
    }
    Table {
        title: format!(
            "{} [{}], full scale {}, dead band {}",
            axis.symbol(),
            axis.unit(),
            significant(metrology.full_scale[at], 4),
            significant(metrology.dead_bands[at], 3)
        ),
        rows: metrology.own_rows().map(|row| axis_row(row, at, shown, columns.len())).collect(),
        columns,
        ..Table::default()
    }
}

fn axis_row(row: &Row, at: usize, shown: Shown, n_columns: usize) -> Vec<Cell> {
    let cell = &row.cells[at];
    let name = match row.quantity.is_time() {
        true => format!("{} [{}]", row.definition.name, cell.unit),
        false => row.definition.name.clone(),
    };
    let mut cells = vec![defined(row, name)];
    match (&cell.conventional, &cell.compensated) {
        (Err(before), Err(after)) if before == after => {
            cells.push(missing(before));
            cells.resize(n_columns, Cell::continued());
        }
        (before, after) => {
            for figure in [before, after] {
                cells.extend(figure_cells(cell, figure, shown));
            }
            if shown == Shown::All {
                cells.push(match (before, after) {
                    (Ok(before), Ok(after)) if !row.quantity.is_time() => {
                        Cell::change(before.value.abs(), after.value.abs())
                    }
                    _ => Cell::none(),
                });
                cells.extend(basis_cells([before, after]));
            }
        }
    }
    cells
}

/// How many cycles the figures rest on, and how far each depends on the dead band; empty for what does not come of loops.
fn basis_cells(figures: [&Figure; 2]) -> [Cell; 3] {
    let known = figures.map(|figure| {
        let value = figure.as_ref().ok()?;
        Some((value.value, value.basis?))
    });
    let cycles = known.iter().flatten().next().map(|(_, basis)| cycles(basis));
    let moves =
        known.map(|one| one.map_or_else(String::new, |(value, basis)| moves(value, &basis)));
    let [before, after] = moves;
    [cycles.unwrap_or_default(), before, after].map(Cell::words)
}

/// How many, and over how much.
fn cycles(basis: &Basis) -> String {
    let share = significant(100.0 * basis.range_share, 2);
    format!("{} over {share} %", basis.n_cycles)
}

/// The cells of one output.
fn figure_cells(cell: &metrology::Cell, figure: &Figure, shown: Shown) -> Vec<Cell> {
    let value = match figure {
        Ok(value) => value,
        Err(reason) if shown == Shown::All => return vec![missing(reason), Cell::continued()],
        Err(reason) => return vec![missing(reason)],
    };
    let is_time = cell.unit == "s";
    let in_units = Cell::digits(Some(value.value), 4);
    let in_percent = match value.percent_fs {
        None if is_time && shown == Shown::PercentFs => in_units.clone(),
        None if is_time => Cell::none(),
        None => missing(&Reason::NoFullScale { axis: cell.axis }),
        percent => Cell::digits(percent, 3),
    };
    let about = told(cell, value);
    shown
        .both(in_units, in_percent)
        .into_iter()
        .map(|cell| match cell.value {
            table::Value::Number(_) => cell.about(&about),
            _ => cell,
        })
        .collect()
}

/// A figure with all that is known of it.
fn told(cell: &metrology::Cell, value: &Value) -> String {
    let mut about = format!("{} {}", significant(value.value, 4), cell.unit);
    if let Some(percent) = value.percent_fs {
        about.push_str(&format!(" = {} % of full scale", significant(percent, 4)));
    }
    if let Some(place) = &value.place {
        let [from, to] = [place.from_secs, place.to_secs].map(|secs| significant(secs, 5));
        about.push_str(&format!("\n{}, {from} s to {to} s", place.name));
    }
    if let Some(basis) = &value.basis {
        about.push_str(&format!(
            "\nCycles: {} of all loads. With ½ and 2 × the dead band: {}",
            cycles(basis),
            moves(value.value, basis)
        ));
    }
    about
}

fn missing(reason: &Reason) -> Cell {
    Cell::missing(reason.word(), reason.to_string())
}

/// A row's name, with what it means.
fn defined(row: &Row, name: String) -> Cell {
    Cell::words(name).about(row.definition.sentences().join("\n"))
}

/// All axes beside each other.
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

/// Two rows per loaded axis, one column per axis that reads it; or one row with the reason why there is nothing to read.
/// `None` for a single axis.
pub fn crosstalk(metrology: &Metrology) -> Option<Table> {
    let axes = &metrology.axes;
    let mut columns = vec![Column::words("Loaded alone"), Column::words("Output")];
    columns.extend(axes.iter().map(|axis| Column::numbers(axis.symbol())));
    let mut rows = Vec::new();
    for (from, row) in metrology.crosstalk_rows() {
        let largest = match row.quantity {
            Quantity::CrosstalkDeviation(_) => ", largest",
            _ => "",
        };
        let name = defined(row, format!("from {}{largest}", from.symbol()));
        if let Some(reason) = shared_reason(row) {
            let mut cells = vec![name, missing(reason)];
            cells.resize(columns.len(), Cell::continued());
            rows.push(cells);
            continue;
        }
        type Pick = fn(&metrology::Cell) -> &Figure;
        let outputs: [(Trace, Pick); 2] = [
            (Trace::Conventional, |cell| &cell.conventional),
            (Trace::Compensated, |cell| &cell.compensated),
        ];
        for (trace, figure) in outputs {
            let mut cells =
                vec![name.clone(), Cell::words(trace.label()).about(trace.explanation())];
            cells.extend(row.cells.iter().flat_map(|cell| match figure(cell) {
                // That the loaded axis is the loaded one is no news.
                Err(reason @ Reason::LoadedAxis { .. }) => {
                    vec![Cell::words(reason.word()).about(reason.to_string())]
                }
                figure => figure_cells(cell, figure, Shown::PercentFs),
            }));
            rows.push(cells);
        }
    }
    (axes.len() > 1).then(|| Table {
        title: "Crosstalk, % of full scale".to_owned(),
        columns,
        rows,
        ..Table::default()
    })
}

/// Why no axis but the loaded one has a figure, if it is the same for all.
fn shared_reason(row: &Row) -> Option<&Reason> {
    let figures = row.cells.iter().flat_map(|cell| [&cell.conventional, &cell.compensated]);
    let mut others = figures.filter(|figure| !matches!(figure, Err(Reason::LoadedAxis { .. })));
    let reason = others.next()?.as_ref().err()?;
    others.all(|other| other.as_ref().err() == Some(reason)).then_some(reason)
}

/// One row per quantity and axis, for a file: conventional beside compensated, each in the axis' unit and in % of full
/// scale, with where it comes from, or with the reason why there is no figure; then what the quantity means.
///
/// Full scale and dead band are in the axis' load unit.
pub fn figure_records(metrology: &Metrology) -> Table {
    let rows = metrology.rows.iter();
    let records = rows.flat_map(|row| {
        let cells = row.cells.iter().enumerate();
        cells.map(|(at, cell)| figure_record(metrology, row, at, cell))
    });
    let records: Vec<Vec<(String, Cell)>> = records.collect();
    let names = records.first().into_iter().flatten();
    Table {
        columns: names.map(|(name, _)| Column::words(name)).collect(),
        rows: records
            .into_iter()
            .map(|record| record.into_iter().map(|(_, cell)| cell).collect())
            .collect(),
        ..Table::default()
    }
}

/// The figures of one quantity and the axis at this place, each with the name of its column.
fn figure_record(
    metrology: &Metrology,
    row: &Row,
    at: usize,
    cell: &metrology::Cell,
) -> Vec<(String, Cell)> {
    let number = |value: f64| Cell::number(value, value.to_string());
    let known = |value: Option<f64>| value.map_or_else(Cell::none, number);
    let named = |(name, cell): (&str, Cell)| (name.to_owned(), cell);
    let words = |(name, text): (&str, &str)| (name.to_owned(), Cell::words(text));
    let outputs = [("conventional", &cell.conventional), ("compensated", &cell.compensated)];
    let about = &row.definition;
    let mut record = Vec::new();
    record.extend(
        [
            ("id", &*about.id),
            ("quantity", &*about.name),
            ("axis", cell.axis.symbol()),
            ("unit", cell.unit),
        ]
        .map(words),
    );
    record.push(named(("full_scale", number(metrology.full_scale[at]))));
    for (output, figure) in outputs {
        let value = figure.as_ref().ok();
        let place = value.and_then(|value| value.place.as_ref());
        let place =
            place.map(|own| format!("{} {} s to {} s", own.name, own.from_secs, own.to_secs));
        let reason = figure.as_ref().err().map(Reason::to_string);
        let of_output = [
            ("", known(value.map(|value| value.value))),
            ("_percent_fs", known(value.and_then(|value| value.percent_fs))),
            ("_place", Cell::words(place.unwrap_or_default())),
            ("_reason", Cell::words(reason.unwrap_or_default())),
        ];
        record.extend(of_output.map(|(what, cell)| (format!("{output}{what}"), cell)));
    }
    record.push(named(("dead_band", number(metrology.dead_bands[at]))));
    record.extend(
        [
            ("definition", about.definition),
            ("source", about.source),
            ("free_running", about.free_running),
        ]
        .map(words),
    );
    for (output, figure) in outputs {
        let basis = figure.as_ref().ok().and_then(|value| value.basis);
        let of_output = [
            ("cycles", basis.map(|own| own.n_cycles as f64)),
            ("range_share", basis.map(|own| own.range_share)),
            ("dead_band_halved", basis.and_then(|own| own.dead_band_halved)),
            ("dead_band_doubled", basis.and_then(|own| own.dead_band_doubled)),
        ];
        record.extend(of_output.map(|(what, value)| (format!("{output}_{what}"), known(value))));
    }
    record
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::questions::metrology::figures::Run;
    use crate::questions::metrology::tests::table_of;
    use crate::recording::Axis;

    /// Fx of 10 N full scale and Mx of none; Conv. is 1 off and Comp. 0.5, everywhere.
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
            reference_axes: &axes,
            reference: &reference,
            conventional: &off(1.0),
            compensated: &off(0.5),
            is_static: false,
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
            (Shown::PercentFs, ["RMSE", "10.0", "5.00", "no FS", "no FS"]),
            (Shown::Units, ["RMSE", "1.000", "0.5000", "1.000", "0.5000"]),
        ] {
            assert_eq!(texts(&overview(&measured, shown), "RMSE"), expected);
        }
        let of_axis = axis_figures(&measured, 0, Shown::All);
        let expected = ["RMSE", "1.000", "10.0", "0.5000", "5.00", "-50.0 %"];
        assert_eq!(texts(&of_axis, "RMSE")[..6], expected);
        assert_eq!(texts(&of_axis, "RMSE")[6..], ["", "", ""]);
        let hysteresis = texts(&of_axis, "Hysteresis");
        assert_eq!(hysteresis[6], "1 over 100 %");
    }

    #[test]
    fn every_row_has_a_cell_for_each_column() {
        let measured = measured();
        let mut tables = vec![figure_records(&measured), crosstalk(&measured).unwrap()];
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
