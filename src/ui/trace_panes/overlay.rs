//! Draws the look-back of the sample under the pointer: the searched interval of time and the earlier sample that was found.

use egui::{Align2, Color32, Stroke, Ui};
use egui_plot::{Line, LineStyle, MarkerShape, PlotPoints, PlotUi, Points, Span, VLine};

use crate::{
    features::Thresholds,
    questions::{AxisTraces, TraceSet, thresholds::ShownFTh},
    ui::{
        numbers::{elided, significant},
        palette::{self, Trace},
    },
};

/// Maximum number of characters of a recording's name in the tooltip.
const NAME_LENGTH: usize = 44;
/// Size of the small plot of the look-back rule in the tooltip (points).
const STRIP: egui::Vec2 = egui::Vec2::new(270.0, 96.0);
const STRIP_TEXT: f32 = 11.0;
/// Maximum number of samples that the small plot reads in a frame.
const STRIP_SAMPLES: usize = 50_000;

/// Draws the interval of length t_th (time threshold) that the look-back searches. The force threshold F_th is a distance
/// over several axes, so [`strip`] draws it in a plot of its own.
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

pub fn tooltip(
    ui: &Ui,
    response: &egui::Response,
    traces: &TraceSet,
    axis: &AxisTraces,
    (k, beside): (usize, Option<egui::Rect>),
) {
    let anchor = match beside {
        Some(plot) => egui::PopupAnchor::Position(plot.left_top()),
        None => egui::PopupAnchor::Pointer,
    };
    egui::Tooltip::always_open(ui.ctx().clone(), ui.layer_id(), response.id.with("values"), anchor)
        .gap(18.0)
        .show(|ui| {
            let name = traces.segment_of(k).map_or("", |segment| &segment.name);
            ui.strong(format!("{} at {}", axis.axis.symbol(), traces.when(k, 6)));
            ui.weak(elided(name, NAME_LENGTH));
            egui::Grid::new("values").num_columns(3).show(ui, |ui| {
                for (trace, load, error) in loads(axis, k) {
                    ui.colored_label(trace.color(ui.visuals()), trace.label());
                    ui.label(load);
                    ui.label(error);
                    ui.end_row();
                }
            });
            if let Some(thresholds) = traces.thresholds {
                let words = look_back_words(traces, thresholds, k);
                ui.colored_label(palette::look_back(ui.visuals()), words);
                strip(ui, traces, thresholds, k);
            }
        });
}

/// Returns the loads at a sample and their errors, with units.
fn loads(axis: &AxisTraces, k: usize) -> impl Iterator<Item = (Trace, String, String)> {
    let unit = axis.axis.unit();
    Trace::LISTED.into_iter().filter_map(move |trace| {
        let load = axis.load(trace)?.value(k);
        let error =
            axis.error(trace).map(|error| format!("error {}", significant(error.value(k), 3)));
        let load = format!("{} {unit}", significant(load, 4));
        Some((trace, load, error.unwrap_or_default()))
    })
}

pub fn spoken(traces: &TraceSet, axis: &AxisTraces, k: usize) -> String {
    let loads = loads(axis, k).map(|(trace, load, error)| {
        format!("{} {load} {error}", trace.label()).trim_end().to_owned()
    });
    let look_back = traces.thresholds.map(|thresholds| look_back_words(traces, thresholds, k));
    let all: Vec<String> = loads.chain(look_back).collect();
    format!("{} at {}: {}", axis.axis.symbol(), traces.when(k, 6), all.join(", "))
}

/// Draws the look-back rule: the distance d(k, j) of the load at each sample j within the time threshold t_th from the load
/// at the present sample k, the force threshold F_th, and the earlier sample that the look-back found.
fn strip(ui: &mut Ui, traces: &TraceSet, thresholds: Thresholds, k: usize) {
    let Some(segment) = traces.segment_of(k) else {
        return;
    };
    let (outer, _) = ui.allocate_exact_size(STRIP, egui::Sense::hover());
    let plot = outer.shrink2(egui::vec2(2.0, STRIP_TEXT + 3.0));
    let past = traces.past_of(k);
    let points = going_back(traces, thresholds.t_th_secs, segment.samples.start, k);
    let reaches = points.iter().fold(0.0, |most: f64, (_, d)| most.max(*d));
    let top = 1.15 * reaches.max(thresholds.f_th).max(f64::MIN_POSITIVE);
    // If the recording began less than the time threshold t_th ago, the plot begins at the recording's first sample.
    let since_start = traces.times[k] - traces.times[segment.samples.start];
    let longest = since_start.min(thresholds.t_th_secs).max(f64::MIN_POSITIVE);
    let at = |age: f64, d: f64| {
        let across = egui::lerp(plot.right()..=plot.left(), (age / longest) as f32);
        egui::pos2(across, egui::lerp(plot.bottom()..=plot.top(), (d / top) as f32))
    };
    let visuals = ui.visuals();
    let (color, text) = (palette::look_back(visuals), visuals.text_color());
    let font = egui::FontId::proportional(STRIP_TEXT);
    let painter = ui.painter();
    painter.rect_filled(plot, 0.0, visuals.extreme_bg_color);
    let line: Vec<egui::Pos2> = points.iter().map(|(age, d)| at(*age, *d)).collect();
    painter.add(egui::Shape::line(line, Stroke::new(1.4, text)));
    let threshold = [at(longest, thresholds.f_th), at(0.0, thresholds.f_th)];
    painter.line_segment(threshold, Stroke::new(1.2, color));
    if past != k {
        let (age, d) = (traces.times[k] - traces.times[past], traces.distance_between(k, past));
        let found = at(age, d);
        painter.vline(found.x, plot.y_range(), Stroke::new(1.0, color));
        painter.circle_filled(found, 4.0, color);
    }
    let shown = ShownFTh::of(traces.distance);
    let around = plot.expand(1.0);
    let what = format!("distance d(k, j) from the present load [{}]", shown.unit);
    let f_th = format!("F_th {}", significant(shown.factor * thresholds.f_th, 3));
    let oldest = format!("{} s earlier", significant(longest, 3));
    for (at, align, words, color) in [
        (around.left_top(), Align2::LEFT_BOTTOM, what, text),
        (around.right_top(), Align2::RIGHT_BOTTOM, f_th, color),
        (around.left_bottom(), Align2::LEFT_TOP, oldest, text),
        (around.right_bottom(), Align2::RIGHT_TOP, "now".to_owned(), text),
    ] {
        painter.text(at, align, words, font.clone(), color);
    }
}

/// Returns the age (s) of the samples before `k`, and the distance of their load from the load at `k`, back to `t_th_secs` or
/// to the first sample. Returns only the largest distance in each column of the plot.
fn going_back(traces: &TraceSet, t_th_secs: f64, first: usize, k: usize) -> Vec<(f64, f64)> {
    let now = traces.times[k];
    let oldest = first + traces.times[first..=k].partition_point(|time| now - time > t_th_secs);
    let n = k - oldest + 1;
    // If there are very many samples, only the newest samples of each pixel column are read, to save time. Samples that are
    // close in time have similar loads, so the largest distance hardly differs.
    let width = n.div_ceil(STRIP.x as usize).max(1);
    let looked_at = width.min(STRIP_SAMPLES / STRIP.x as usize);
    let mut points = Vec::new();
    let mut end = k + 1;
    while end > oldest {
        let start = end.saturating_sub(width).max(oldest);
        let newest = end - looked_at.min(end - start);
        let distances = traces.distances(k, newest..end);
        let all = (newest..end).zip(distances).map(|(j, d)| (now - traces.times[j], d));
        points.extend(all.max_by(|a, b| a.1.total_cmp(&b.1)));
        end = start;
    }
    points
}

fn look_back_words(traces: &TraceSet, thresholds: Thresholds, k: usize) -> String {
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
