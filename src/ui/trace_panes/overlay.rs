//! Draws the look-back of the sample under the pointer: the searched interval of time and the earlier sample that was found.

use egui::Color32;
use egui_plot::{Line, LineStyle, MarkerShape, PlotPoints, PlotUi, Points, Span, VLine};

use crate::{
    features::Thresholds,
    questions::{AxisTraces, TraceSet, thresholds::ShownFTh},
    ui::{
        numbers::significant,
        palette::{self, Trace},
    },
};

/// Draws the interval of length t_th (time threshold) that the look-back searches. The force threshold F_th is a distance
/// over several axes, so the pane Look-back draws it in a plot of its own.
pub fn thresholds(
    plot: &mut PlotUi<'_>,
    traces: &TraceSet,
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
}

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
    let past = traces.past_of(k);
    let line = |at: usize, color: Color32, style: LineStyle| {
        VLine::new("", traces.times[at]).color(color).width(1.0).style(style).allow_hover(false)
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
        for (end, shape) in ends.into_iter().zip([MarkerShape::Diamond, MarkerShape::Circle]) {
            let marker = Points::new("", PlotPoints::from(end))
                .shape(shape)
                .radius(4.5)
                .color(color)
                .allow_hover(false);
            plot.points(marker);
        }
    }
}

/// Returns the loads at a sample and their errors, in the unit of the axis.
pub fn loads(axis: &AxisTraces, k: usize) -> impl Iterator<Item = (Trace, String, String)> {
    let number = |value: f64, digits| significant(value, digits).replace('-', "−");
    Trace::LISTED.into_iter().filter_map(move |trace| {
        let load = number(axis.load(trace)?.value(k), 4);
        let error = axis.error(trace).map(|error| number(error.value(k), 3));
        Some((trace, load, error.unwrap_or_default()))
    })
}

pub fn spoken(traces: &TraceSet, axis: &AxisTraces, k: usize) -> String {
    let unit = axis.axis.unit();
    let loads = loads(axis, k).map(|(trace, load, error)| {
        let error = if error.is_empty() { error } else { format!(", error {error}") };
        format!("{} {load} {unit}{error}", trace.label())
    });
    let look_back = traces.thresholds.map(|thresholds| look_back_words(traces, thresholds, k));
    let all: Vec<String> = loads.chain(look_back).collect();
    format!("{} at {}: {}", axis.axis.symbol(), traces.when(k, 6), all.join(", "))
}

pub fn look_back_words(traces: &TraceSet, thresholds: Thresholds, k: usize) -> String {
    let shown = ShownFTh::of(traces.distance);
    let amount = |d: f64| format!("{} {}", significant(shown.factor * d, 3), shown.unit);
    let past = traces.past_of(k);
    if past == k {
        return format!(
            "look-back finds no earlier sample: no load differs by {} within {} s",
            amount(thresholds.f_th),
            significant(thresholds.t_th_secs, 3),
        );
    }
    format!(
        "look-back to the sample {} s earlier, whose load differs by {}",
        significant(traces.times[k] - traces.times[past], 3),
        amount(traces.distance_between(k, past)),
    )
}
