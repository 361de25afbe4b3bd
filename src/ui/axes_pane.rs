//! Pane with a small loop of each axis, which chooses the axis that the other panes show.

use egui::{Color32, Rect, RichText, Sense, Stroke, Ui, Vec2};

use crate::{
    questions::{Analysis, AxisTraces},
    scoring::Series,
    ui::{
        command::Command,
        controls::{named_selected, place_right},
        palette::Trace,
        pane::{Cx, PaneView},
        scope::{AxisChoice, Errors},
        small_plot::{SmallPlot, range},
    },
};

const COLUMNS: usize = 3;
const GAP: f32 = 8.0;
/// Height of the name above a loop (points).
const NAME_HEIGHT: f32 = 20.0;
/// Maximum number of samples that a loop is drawn from.
const MOST_SAMPLES: usize = 1500;

#[derive(Debug, Default)]
pub struct View;

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        let Some(analysis) = cx.engine.analysis() else { return };
        let whole = ui.available_rect_before_wrap();
        let n_rows = analysis.calibration.axes.len().div_ceil(COLUMNS).max(1);
        let size = Vec2::new(
            (whole.width() - (COLUMNS - 1) as f32 * GAP) / COLUMNS as f32,
            (whole.height() - n_rows as f32 * GAP) / n_rows as f32,
        );
        for at in 0..analysis.calibration.axes.len() {
            let step = Vec2::new((at % COLUMNS) as f32, (at / COLUMNS) as f32);
            let place = Rect::from_min_size(whole.min + step * (size + Vec2::splat(GAP)), size);
            axis_loop(ui, analysis, at, place, cx);
        }
    }
}

fn axis_loop(ui: &mut Ui, analysis: &Analysis, at: usize, place: Rect, cx: &mut Cx<'_>) {
    let axis = analysis.calibration.axes[at];
    let response = ui.interact(place, ui.scope_id().with(at), Sense::click());
    let is_shown = cx.scope.axes().first() == Some(&axis);
    named_selected(&response, egui::Role::RadioButton, is_shown, axis.symbol());
    let visuals = ui.visuals().clone();
    let inside = place.with_min_y(place.top() + NAME_HEIGHT);
    if let Some(traces) = analysis.traces.axes.iter().find(|traces| traces.axis == axis) {
        small_loop(ui, traces, inside);
    }
    let name = place.with_max_y(inside.top());
    ui.painter().text(
        name.left_center() + Vec2::new(4.0, 0.0),
        egui::Align2::LEFT_CENTER,
        axis.symbol(),
        egui::FontId::proportional(13.0),
        if is_shown { visuals.strong_text_color() } else { visuals.text_color() },
    );
    let change = Errors::of(analysis, cx.scope.on).and_then(|errors| errors.change(at));
    if let Some(change) = change {
        let text = egui::Label::new(RichText::new(change).weak()).selectable(false);
        place_right(ui, name.with_max_x(name.right() - 4.0), |ui| ui.add(text))
            .on_hover_text("Change of the RMSE by the compensation");
    }
    let frame = if is_shown || response.has_focus() {
        Stroke::new(2.0, visuals.selection.stroke.color)
    } else if response.hovered() {
        visuals.widgets.hovered.bg_stroke
    } else {
        visuals.widgets.noninteractive.bg_stroke
    };
    ui.painter().rect_stroke(place, 4.0, frame, egui::StrokeKind::Inside);
    if response.on_hover_text("Shows this axis").clicked() {
        cx.out.send(Command::Axes(AxisChoice::Only(at)));
    }
}

/// Draws the errors over the reference load, in a square of both ranges.
fn small_loop(ui: &Ui, traces: &AxisTraces, place: Rect) {
    let Some(loads) = traces.calculated.as_deref() else { return };
    let lines: Vec<(Color32, &Series)> = [Trace::Conventional, Trace::Compensated]
        .into_iter()
        .filter_map(|trace| Some((trace.color(ui.visuals()), &**traces.error(trace)?)))
        .collect();
    let (across, up) = (range([loads]), range(lines.iter().map(|(_, series)| *series)));
    let plot = SmallPlot::new(ui, place, across, up);
    if across.0 >= across.1 || up.0 >= up.1 {
        return;
    }
    let step = loads.len().div_ceil(MOST_SAMPLES).max(1);
    for (color, series) in lines {
        let samples = (0..loads.len()).step_by(step);
        let points = samples.map(|k| [loads.value(k), series.value(k)]);
        plot.line(points, Stroke::new(1.0, color));
    }
}
