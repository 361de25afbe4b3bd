//! Two cursors in time, and the table of the values at both cursors, their differences and the ranges between the cursors.

use std::ops::Range;
use std::sync::Arc;

use egui_plot::{LineStyle, PlotUi, VLine};

use crate::{
    questions::{AxisTraces, TraceSet},
    recording::Axis,
    report::{Cell, Column, Table},
    scoring::Series,
    ui::{
        controls::Controls as _,
        numbers::significant,
        palette::{self, Trace},
    },
};

/// Times of the two cursors (s).
#[derive(Debug, Default)]
pub struct Cursors {
    at: [Option<f64>; 2],
    pub table: bool,
}

struct Row<'a> {
    name: String,
    unit: &'static str,
    series: &'a Series,
}

fn rows<'a>(axis: &'a AxisTraces) -> impl Iterator<Item = Row<'a>> {
    let loads = Trace::LISTED.map(|trace| (trace.label().to_owned(), axis.load(trace)));
    let errors = Trace::LISTED.map(|trace| (format!("{} error", trace.label()), axis.error(trace)));
    let row = move |(label, series): (String, Option<&'a Arc<Series>>)| {
        Some(Row {
            name: format!("{} {label}", axis.axis.symbol()),
            unit: axis.axis.unit(),
            series: series?,
        })
    };
    loads.into_iter().chain(errors).filter_map(row)
}

impl Cursors {
    pub fn put(&mut self, which: usize, time: f64) {
        self.at[which] = Some(time);
    }

    pub fn clear(&mut self) {
        *self = Self { table: self.table, ..Self::default() };
    }

    pub fn both(&self) -> Option<(f64, f64)> {
        self.at[0].zip(self.at[1])
    }

    pub fn first(&self) -> Option<f64> {
        self.at[0]
    }

    pub fn mark(&self, plot: &mut PlotUi<'_>, visuals: &egui::Visuals) {
        for time in self.at.into_iter().flatten() {
            let line = VLine::new("", time)
                .color(palette::present(visuals))
                .style(LineStyle::dashed_dense())
                .width(1.3)
                .allow_hover(false);
            plot.vline(line);
        }
    }

    pub fn show(&mut self, ui: &egui::Ui, axes: &[Axis], traces: &TraceSet) {
        if !self.table {
            return;
        }
        let ends = self.at.map(|time| time.and_then(|time| traces.sample_at(time)));
        let (Some(a), b) = (ends[0].or(ends[1]), ends[1]) else {
            return;
        };
        let samples = a.min(b.unwrap_or(a))..a.max(b.unwrap_or(a)) + 1;
        let shown = traces.axes.iter().filter(|axis| axes.contains(&axis.axis));
        let rows: Vec<Row<'_>> = shown.flat_map(rows).collect();
        let mut open = true;
        egui::Window::new("Cursors")
            .open(&mut open)
            .default_size([640.0, 260.0])
            // If there is room, the table is beside the plots.
            .default_pos(ui.ctx().content_rect().left_bottom() + egui::vec2(8.0, -330.0))
            .show(ui.ctx(), |ui| {
                let n_samples = samples.len();
                let figures = table(&rows, (a, b), samples);
                let time = |k: usize| traces.when(k, 7);
                ui.horizontal_wrapped(|ui| {
                    ui.label(match b {
                        Some(b) if traces.is_static => {
                            format!("A {}, B {}, {n_samples} rows", time(a), time(b))
                        }
                        Some(b) => format!(
                            "A {}, B {}, Δt {} s, {n_samples} samples",
                            time(a),
                            time(b),
                            significant(traces.times[b] - traces.times[a], 6),
                        ),
                        None => format!("A {}; Shift+click sets cursor B", time(a)),
                    });
                    ui.copies("table", || figures.tab_separated());
                });
                ui.separator();
                ui.scrolled(|ui| crate::ui::table::show(ui, &figures));
            });
        self.table = open;
    }
}

/// Returns the table of the values at A and B, their differences and the ranges between them. Without cursor B, only the values
/// at A are filled in.
fn table(rows: &[Row<'_>], (a, b): (usize, Option<usize>), samples: Range<usize>) -> Table {
    let number = |number: Option<f64>| {
        number.map_or_else(|| Cell::words(""), |number| Cell::digits(Some(number), 4))
    };
    let at_b = |row: &Row<'_>| b.map(|b| row.series.value(b));
    let range = |row: &Row<'_>| b.and_then(|_| row.series.min_max(samples.clone()));
    Table::of(rows)
        .words("", |row| &row.name)
        .words("unit", |row| row.unit)
        .column(Column::numbers("A"), |row| number(Some(row.series.value(a))))
        .column(Column::numbers("B"), |row| number(at_b(row)))
        .column(Column::numbers("Δ"), |row| number(at_b(row).map(|b| b - row.series.value(a))))
        .column(Column::numbers("min"), |row| number(range(row).map(|(min, _)| min)))
        .column(Column::numbers("max"), |row| number(range(row).map(|(_, max)| max)))
        .table("", "")
}
