//! The figures of a report, with what each means.

use super::ReportData;
use super::markup::{Cell, Markup};
use super::tables::change;
use crate::evaluation::metrology::{Figure, Metrology, Reason, Row};
use crate::evaluation::numbers::significant;

pub(super) fn section(report: &ReportData, page: &mut Markup) {
    page.section("metrology", "page", "Figures", |page| {
        let table = match &report.metrology {
            Ok(table) => table,
            Err(reason) => return page.element("p", reason),
        };
        page.element(
            "p",
            &format!(
                "Of {}: {} recordings, {} samples. How each figure is computed stands below.",
                report.measured, table.n_recordings, table.n_samples
            ),
        );
        for note in &table.notes {
            page.element("p", &format!("Note: {note}"));
        }
        for at in 0..table.axes.len() {
            axis(table, at, page);
        }
        if table.axes.len() > 1 {
            crosstalk(table, page);
        }
        definitions(table, page);
    });
}

fn axis(table: &Metrology, at: usize, page: &mut Markup) {
    let axis = table.axes[at];
    let title = format!(
        "{} [{}], full scale {}, dead band {}",
        axis.symbol(),
        axis.unit(),
        significant(table.full_scale[at], 4),
        significant(table.dead_bands[at], 3)
    );
    page.element("h3", &title);
    let mut head = vec![Cell::text("Figure")];
    head.extend(["Conv.", "% FS", "Comp.", "% FS", "change"].map(|name| Cell::Number(name.into())));
    page.table(&head, table.own_rows().map(|row| figure_row(row, at)));
}

fn figure_row(row: &Row, at: usize) -> Vec<Cell> {
    let cell = &row.cells[at];
    let name = match row.quantity.is_time() {
        true => format!("{} [{}]", row.definition.name, cell.unit),
        false => row.definition.name.clone(),
    };
    let mut cells = vec![Cell::text(name)];
    match (&cell.conventional, &cell.compensated) {
        (Err(first), Err(second)) if first == second => {
            cells.push(Cell::Reason(first.to_string(), 5));
        }
        (before, after) => {
            cells.extend(shown(before));
            cells.extend(shown(after));
            let change = match (before, after) {
                (Ok(before), Ok(after)) if !row.quantity.is_time() => {
                    change(before.value.abs(), after.value.abs())
                }
                _ => None,
            };
            cells.push(Cell::Number(change.unwrap_or_default()));
        }
    }
    cells
}

/// Value and percent, or the reason over both columns.
fn shown(figure: &Figure) -> Vec<Cell> {
    match figure {
        Ok(value) => vec![
            Cell::Number(significant(value.value, 4)),
            Cell::Number(
                value
                    .percent_fs
                    .map_or_else(String::new, |percent| significant(percent, 3)),
            ),
        ],
        Err(reason) => vec![Cell::Reason(reason.to_string(), 2)],
    }
}

/// Two rows per loaded axis, one column per axis that reads it.
fn crosstalk(table: &Metrology, page: &mut Markup) {
    page.element("h3", "Crosstalk [% FS]");
    let mut head = vec![Cell::text("Loaded alone"), Cell::text("Output")];
    head.extend(
        table
            .axes
            .iter()
            .map(|axis| Cell::Number(axis.symbol().to_owned())),
    );
    let mut rows = Vec::new();
    for (from, row) in table.crosstalk_rows() {
        let from = from.symbol();
        let figures = row
            .cells
            .iter()
            .flat_map(|cell| [&cell.conventional, &cell.compensated]);
        if figures.clone().all(Result::is_err) {
            let mut reasons = figures.filter_map(|figure| figure.as_ref().err());
            // That the loaded axis is the loaded one says nothing.
            let reason = reasons.find(|reason| !matches!(reason, Reason::LoadedAxis { .. }));
            let reason = reason.map_or_else(String::new, Reason::to_string);
            rows.push(vec![
                Cell::text(from),
                Cell::Reason(reason, table.axes.len() + 1),
            ]);
            continue;
        }
        for (at, output) in ["Conv.", "Comp."].into_iter().enumerate() {
            let mut cells = vec![
                Cell::text(if at == 0 { from } else { "" }),
                Cell::text(output),
            ];
            cells.extend(row.cells.iter().map(|cell| {
                let figure = [&cell.conventional, &cell.compensated][at];
                let percent = figure.as_ref().ok().and_then(|value| value.percent_fs);
                Cell::number(percent.map(|percent| significant(percent, 3)))
            }));
            rows.push(cells);
        }
    }
    page.table(&head, rows);
}

fn definitions(table: &Metrology, page: &mut Markup) {
    page.element("h3", "Definitions");
    page.within("dl", "class=\"definitions\"", |page| {
        for (name, about) in table.definitions() {
            page.element("dt", name);
            page.element(
                "dd",
                &format!("{}. Source: {}.", about.definition, about.source),
            );
            if !about.free_running.is_empty() {
                page.element("dd", &format!("Free-running: {}.", about.free_running));
            }
        }
    });
}
