//! The look-back of the sample under the pointer: the loads and errors there, and the earlier sample that the rule found.

use egui::{Align2, Stroke, Ui};

use crate::{
    features::Thresholds,
    questions::{TraceSet, thresholds::ShownFTh},
    ui::{
        numbers::significant,
        palette,
        pane::{Cx, PaneView},
        small_plot::SmallPlot,
        trace_panes::overlay::{loads, look_back_words},
    },
};

const TEXT_SIZE: f32 = 11.0;
/// Minimum and maximum height of the plot of the rule (points).
const HEIGHTS: (f32, f32) = (60.0, 170.0);
/// Maximum number of samples that the plot reads in a frame.
const MOST_SAMPLES: usize = 50_000;
const COLUMNS: usize = 270;

#[derive(Debug, Default)]
pub struct View;

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        let Some(analysis) = cx.engine.analysis() else {
            ui.weak("No calibration is fitted yet.");
            return;
        };
        let traces = &*analysis.traces;
        let k = cx.time.last_hovered().min(traces.times.len().saturating_sub(1));
        let shown = cx.scope.axes().first();
        let axis =
            traces.axes.iter().find(|axis| Some(&axis.axis) == shown).or(traces.axes.first());
        let Some(axis) = axis.filter(|_| !traces.times.is_empty()) else { return };
        ui.take_available_width();
        egui::Grid::new("values").num_columns(3).min_col_width(100.0).show(ui, |ui| {
            ui.weak(format!("{} at {}", axis.axis.symbol(), traces.when(k, 6)));
            let unit = axis.axis.unit();
            ui.weak(format!("load [{unit}]"));
            ui.weak(format!("error [{unit}]"));
            ui.end_row();
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
            rule(ui, traces, thresholds, k);
        }
    }
}

/// Draws the look-back rule: the distance d(k, j) of the load at each sample j within the time threshold t_th from the load
/// at the present sample k, the force threshold F_th, and the earlier sample that the look-back found.
fn rule(ui: &mut Ui, traces: &TraceSet, thresholds: Thresholds, k: usize) {
    let Some(segment) = traces.segment_of(k) else {
        return;
    };
    let height = ui.available_height().clamp(HEIGHTS.0, HEIGHTS.1);
    let size = egui::vec2(ui.available_width(), height);
    let (outer, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    let plot = outer.shrink2(egui::vec2(2.0, TEXT_SIZE + 3.0));
    let past = traces.past_of(k);
    let points = going_back(traces, thresholds.t_th_secs, segment.samples.start, k);
    let reaches = points.iter().fold(0.0, |most: f64, (_, d)| most.max(*d));
    let top = 1.15 * reaches.max(thresholds.f_th).max(f64::MIN_POSITIVE);
    // If the recording began less than the time threshold t_th ago, the plot begins at the recording's first sample.
    let since_start = traces.times[k] - traces.times[segment.samples.start];
    let longest = since_start.min(thresholds.t_th_secs);
    if longest <= 0.0 {
        return; // the first sample has no past
    }
    let visuals = ui.visuals();
    let (color, text) = (palette::look_back(visuals), visuals.text_color());
    let font = egui::FontId::proportional(TEXT_SIZE);
    let small = SmallPlot::new(ui, plot, (-longest, 0.0), (0.0, top));
    small.line(points.iter().map(|(age, d)| [-age, *d]), Stroke::new(1.4, text));
    small.line([-longest, 0.0].map(|time| [time, thresholds.f_th]), Stroke::new(1.2, color));
    if past != k {
        let age = traces.times[k] - traces.times[past];
        let found = small.at([-age, traces.distance_between(k, past)]);
        small.painter.vline(found.x, plot.y_range(), Stroke::new(1.0, color));
        small.painter.circle_filled(found, 4.0, color);
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
        ui.painter().text(at, align, words, font.clone(), color);
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
    let width = n.div_ceil(COLUMNS).max(1);
    let looked_at = width.min(MOST_SAMPLES / COLUMNS);
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
