//! Two cursors in time, and the table of the values at both cursors, their differences and the statistics between the cursors.

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
        status_line::busy,
    },
};

/// Maximum number of values that are summed in one frame, so that no frame waits for millions of values.
const VALUES_PER_FRAME: usize = 400_000;

/// Times of the two cursors (s), and the statistics between the cursors.
#[derive(Debug, Default)]
pub struct Cursors {
    at: [Option<f64>; 2],
    span: Option<Span>,
    pub table: bool,
}

/// Statistics of one series, over the values that have been added so far.
#[derive(Clone, Copy, Debug, Default)]
struct Figures {
    n: usize,
    mean: f64,
    /// Sum of squared differences from the mean (Welford 1962).
    squares: f64,
    min: f64,
    max: f64,
}

impl Figures {
    fn add(&mut self, value: f64) {
        if !value.is_finite() {
            return;
        }
        if self.n == 0 {
            (self.min, self.max) = (value, value);
        }
        self.n += 1;
        let difference = value - self.mean;
        self.mean += difference / self.n as f64;
        self.squares += difference * (value - self.mean);
        self.min = self.min.min(value);
        self.max = self.max.max(value);
    }

    fn deviation(&self) -> f64 {
        (self.squares / self.n.max(1) as f64).sqrt()
    }
}

#[derive(Clone, Debug)]
struct Row {
    name: String,
    unit: &'static str,
    series: Arc<Series>,
    figures: Figures,
}

#[derive(Debug)]
struct Span {
    samples: Range<usize>,
    next: usize,
    rows: Vec<Row>,
}

impl Span {
    /// Adds the next values to the statistics. Returns true once all values between the cursors are added.
    fn go_on(&mut self) -> bool {
        let n = (VALUES_PER_FRAME / self.rows.len().max(1)).max(1);
        let end = (self.next + n).min(self.samples.end);
        for row in &mut self.rows {
            let Row { series, figures, .. } = row;
            series.each(self.next..end, |value| figures.add(value));
        }
        self.next = end;
        end == self.samples.end
    }
}

fn rows(axis: &AxisTraces) -> Vec<Row> {
    let loads = Trace::LISTED.map(|trace| (trace.label().to_owned(), axis.load(trace)));
    let errors = Trace::LISTED.map(|trace| (format!("{} error", trace.label()), axis.error(trace)));
    let row = |(label, series): (String, Option<&Arc<Series>>)| {
        Some(Row {
            name: format!("{} {label}", axis.axis.symbol()),
            unit: axis.axis.unit(),
            series: Arc::clone(series?),
            figures: Figures::default(),
        })
    };
    loads.into_iter().chain(errors).filter_map(row).collect()
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
        let rows: Vec<Row> = shown.flat_map(rows).collect();
        let is_of_these = |span: &Span| {
            let series =
                |rows: &[Row]| rows.iter().map(|row| Arc::as_ptr(&row.series)).collect::<Vec<_>>();
            span.samples == samples && series(&span.rows) == series(&rows)
        };
        let span = match self.span.take().filter(is_of_these) {
            Some(known) => self.span.insert(known),
            None => self.span.insert(Span { next: samples.start, samples, rows }),
        };
        let complete = span.go_on();
        if !complete {
            ui.ctx().request_repaint();
        }
        let mut open = true;
        egui::Window::new("Cursors")
            .open(&mut open)
            .default_size([640.0, 260.0])
            // If there is room, the table is beside the plots.
            .default_pos(ui.ctx().content_rect().left_bottom() + egui::vec2(8.0, -330.0))
            .show(ui.ctx(), |ui| {
                let figures = table(span, a, b);
                let time = |k: usize| traces.when(k, 7);
                ui.horizontal_wrapped(|ui| {
                    ui.label(match b {
                        Some(b) if traces.is_static => {
                            format!("A {}, B {}, {} rows", time(a), time(b), span.samples.len())
                        }
                        Some(b) => format!(
                            "A {}, B {}, Δt {} s, {} samples",
                            time(a),
                            time(b),
                            significant(traces.times[b] - traces.times[a], 6),
                            span.samples.len()
                        ),
                        None => format!("A {}; Shift+click sets cursor B", time(a)),
                    });
                    ui.copies("table", || figures.tab_separated());
                    if !complete {
                        busy(ui);
                    }
                });
                ui.separator();
                ui.scrolled(|ui| crate::ui::table::show(ui, &figures));
            });
        self.table = open;
    }
}

/// Returns the table of the values at A and B, their differences and the statistics. Without cursor B, only the values at A are
/// filled in.
fn table(span: &Span, a: usize, b: Option<usize>) -> Table {
    let number = |number: Option<f64>| {
        number.map_or_else(|| Cell::words(""), |number| Cell::digits(Some(number), 4))
    };
    let at_b = |row: &Row| b.map(|b| row.series.value(b));
    type OfSpan = fn(&Figures) -> f64;
    let of_span: [(&str, OfSpan); 4] = [
        ("mean", |figures| figures.mean),
        ("SD", |figures| figures.deviation()),
        ("min", |figures| figures.min),
        ("max", |figures| figures.max),
    ];
    Table::of(&span.rows)
        .words("", |row| &row.name)
        .words("unit", |row| row.unit)
        .column(Column::numbers("A"), |row| number(Some(row.series.value(a))))
        .column(Column::numbers("B"), |row| number(at_b(row)))
        .column(Column::numbers("Δ"), |row| number(at_b(row).map(|b| b - row.series.value(a))))
        .columns(
            of_span,
            |(name, _)| Column::numbers(*name),
            |row, (_, of)| number(b.map(|_| of(&row.figures))),
        )
        .table("", "")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values 1, 2, 4, 9: mean 4, squared differences 9 + 4 + 0 + 25, variance 38/4.
    #[test]
    fn figures_are_those_of_the_finite_values() {
        let mut figures = Figures::default();
        for value in [1.0, 2.0, f64::NAN, 4.0, 9.0] {
            figures.add(value);
        }
        assert_eq!((figures.n, figures.min, figures.max), (4, 1.0, 9.0));
        assert!((figures.mean - 4.0).abs() < 1e-12);
        assert!((figures.deviation() - 9.5_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_long_span_is_added_up_over_several_frames() {
        let values: Arc<[f64]> = (0..1_000_000).map(|k| f64::from(k % 10)).collect();
        let row = Row {
            name: "Fx".to_owned(),
            unit: "N",
            series: Arc::new(Series::new(values)),
            figures: Figures::default(),
        };
        let mut span = Span { samples: 0..1_000_000, next: 0, rows: vec![row] };
        let mut frames = 1;
        while !span.go_on() {
            frames += 1;
        }
        assert_eq!(frames, 3);
        assert_eq!(span.rows[0].figures.n, 1_000_000);
        assert!((span.rows[0].figures.mean - 4.5).abs() < 1e-9);
    }
}
