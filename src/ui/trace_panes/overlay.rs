//! The look-back at the sample under the pointer: what the thresholds search, and what they find.

use egui::{Color32, Stroke};
use egui_plot::{Line, LineStyle, MarkerShape, PlotPoints, PlotUi, Points, Polygon, Span, VLine};

use crate::analysis::{AxisTraces, TraceSet};
use crate::features::{Distance, Thresholds};
use crate::ui::numbers::significant;
use crate::ui::palette::{self, Trace};

/// Draws what is searched: t_th as a interval of time, and in it F_th around the present load.
pub fn thresholds(
    plot: &mut PlotUi<'_>,
    traces: &TraceSet,
    axis: &AxisTraces,
    hovered: Option<usize>,
    visuals: &egui::Visuals,
) {
    let at_pointer = hovered.and_then(|k| Some((k, traces.segment_of(k)?, traces.thresholds?)));
    let Some((k, segment, thresholds)) = at_pointer else {
        return;
    };
    let color = palette::look_back(visuals);
    let now = traces.times[k];
    let oldest = (now - thresholds.t_th_secs).max(traces.times[segment.samples.start]);
    let searched = Span::new("", oldest..=now)
        .fill(color.gamma_multiply(0.10))
        .border_color(color.gamma_multiply(0.5))
        .border_width(1.0);
    plot.span(searched);
    let weight = traces
        .axes
        .iter()
        .position(|other| other.axis == axis.axis)
        .map_or(0.0, |at| traces.weights[at]);
    if weight > 0.0 {
        let load = axis.conventional.value(k);
        let reach = thresholds.f_th / weight;
        let corners = [
            (oldest, -reach),
            (now, -reach),
            (now, reach),
            (oldest, reach),
        ];
        let corners: PlotPoints<'_> = corners
            .iter()
            .map(|(time, offset)| [*time, load + offset])
            .collect();
        let near = Polygon::new("", corners)
            .fill_color(color.gamma_multiply(0.16))
            .stroke(Stroke::new(1.0, color.gamma_multiply(0.8)))
            .allow_hover(false);
        plot.polygon(near);
    }
}

/// Marks the present sample and the past one that was found for it.
pub fn samples(
    plot: &mut PlotUi<'_>,
    traces: &TraceSet,
    axis: &AxisTraces,
    is_load: bool,
    hovered: Option<usize>,
    visuals: &egui::Visuals,
) {
    let Some(k) = hovered.filter(|k| *k < traces.times.len()) else {
        return;
    };
    let color = palette::look_back(visuals);
    let past = traces.past[k] as usize;
    let line = |at: usize, color: Color32, style: LineStyle| {
        VLine::new("", traces.times[at])
            .color(color)
            .width(1.0)
            .style(style)
            .allow_hover(false)
    };
    plot.vline(line(k, visuals.text_color(), LineStyle::Solid));
    if past == k {
        return;
    }
    plot.vline(line(past, color, LineStyle::dashed_dense()));
    if is_load {
        let ends = [past, k].map(|at| [traces.times[at], axis.conventional.value(at)]);
        let link = Line::new("", PlotPoints::from(ends.to_vec()))
            .color(color)
            .width(1.5)
            .allow_hover(false);
        plot.line(link);
        for (end, shape) in ends
            .into_iter()
            .zip([MarkerShape::Diamond, MarkerShape::Circle])
        {
            let marker = Points::new("", PlotPoints::from(end))
                .shape(shape)
                .radius(4.5)
                .color(color)
                .allow_hover(false);
            plot.points(marker);
        }
    }
}

/// Shows the values at sample `k` beside the pointer.
pub fn tooltip(
    ui: &egui::Ui,
    response: &egui::Response,
    traces: &TraceSet,
    axis: &AxisTraces,
    k: usize,
) {
    egui::Tooltip::always_open(
        ui.ctx().clone(),
        ui.layer_id(),
        response.id.with("values"),
        egui::PopupAnchor::Pointer,
    )
    .gap(18.0)
    .show(|ui| {
        let unit = axis.axis.unit();
        let name = traces.segment_of(k).map_or("", |segment| &segment.name);
        ui.strong(format!(
            "{} at {} s",
            axis.axis.symbol(),
            significant(traces.times[k], 6)
        ));
        ui.weak(name);
        egui::Grid::new("values").num_columns(3).show(ui, |ui| {
            let rows = [
                (Trace::Calculated, axis.calculated.as_deref(), None),
                (
                    Trace::Conventional,
                    Some(&*axis.conventional),
                    axis.conventional_error.as_deref(),
                ),
                (
                    Trace::Compensated,
                    Some(&*axis.compensated),
                    axis.compensated_error.as_deref(),
                ),
            ];
            let factory = axis.factory.as_deref().map(|factory| {
                let error = axis.factory_error.as_deref();
                (Trace::Factory, Some(factory), error)
            });
            for (trace, series, error) in rows.into_iter().chain(factory) {
                let Some(series) = series else {
                    continue;
                };
                ui.colored_label(trace.color(ui.visuals()), trace.label());
                ui.label(format!("{} {unit}", significant(series.value(k), 4)));
                ui.label(error.map_or_else(String::new, |error| {
                    format!("error {}", significant(error.value(k), 3))
                }));
                ui.end_row();
            }
        });
        if let Some(thresholds) = traces.thresholds {
            let words = look_back_words(traces, thresholds, k);
            ui.colored_label(palette::look_back(ui.visuals()), words);
        }
    });
}

/// What the look-back found, in words.
fn look_back_words(traces: &TraceSet, thresholds: Thresholds, k: usize) -> String {
    let amount = |d: f64| match traces.distance {
        Distance::Force => format!("{} N", significant(d, 3)),
        Distance::FullScale => format!("{} % of full scale", significant(100.0 * d, 3)),
    };
    let past = traces.past[k] as usize;
    if past == k {
        return format!(
            "no past: nothing differs by {} within {} s",
            amount(thresholds.f_th),
            significant(thresholds.t_th_secs, 3),
        );
    }
    format!(
        "past: {} s earlier, {} away",
        significant(traces.times[k] - traces.times[past], 3),
        amount(traces.distance_between(k, past)),
    )
}
