//! The traces of each axis: the reference, uncompensated and compensated load, and the errors below the loads. All axes show
//! the same interval of time and the same sample under the pointer.

mod drawn;
pub mod overlay;
mod pane;

use egui::Ui;

use crate::{
    engine::{Action, Edit, Engine},
    questions::{AxisTraces, View as Shown, check::query::FindFaults},
    recording::Axis,
    report::figure,
    ui::{
        appearance::is_compact,
        channels_pane::{self, view_choice},
        choice::named_choice,
        command::{Command, Out, Pane},
        controls::Controls as _,
        numbers::{rate_in_words, significant},
        palette::Trace,
        pane::{Cx, PaneView},
        scope::{AxisChoice, Scope},
        time_view::TimeView,
    },
};
use drawn::DrawnLines;
use pane::Place;

/// Minimum height of the plots of an axis (points). If not all axes fit, the user scrolls.
const MIN_CELL_HEIGHT: f32 = 116.0;
/// Height of the time axis under the lowest plot (points).
const TIME_AXIS_HEIGHT: f32 = 34.0;
/// Space above the uppermost plot for the number at the upper end of its scale (points).
const ABOVE: i8 = 4;
/// Minimum width of a column of plots (points), if there are several columns.
const MIN_COLUMN_WIDTH: f32 = 260.0;

/// Width of a legend entry (points): a piece of line, a check box and the name of the load.
const LEGEND_ENTRY_WIDTH: f32 = 150.0;
/// Width of the head (points) from which the legend and the view in time are in it.
const WIDTH_WITH_LEGEND: f32 = 440.0;
/// Width of the head (points) from which the role and the length of the recording are in it.
const WIDTH_WITH_LENGTH: f32 = 780.0;

/// The lines that were drawn in the last frame. [`TimeView`] holds the visible interval of time.
#[derive(Debug)]
pub struct View {
    drawn: DrawnLines,
    /// Single channels, which are shown if the recordings lack something for a calibration.
    channels: channels_pane::View,
}

impl Default for View {
    fn default() -> Self {
        let channels = channels_pane::View::asking_as(Pane::TRACES.key, false);
        Self { drawn: DrawnLines::default(), channels }
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        if cx.engine.project().missing().is_some() || self.channels.gives_roles {
            let n_sent = cx.out.0.len();
            self.channels.ui(ui, cx);
            let is_role = |sent: &Command| matches!(sent, Command::Do(Action::ChangeColumns(_)));
            self.channels.gives_roles |= cx.out.0.iter().skip(n_sent).any(is_role);
            self.channels.gives_roles &= !cx.engine.entries().is_empty();
            return;
        }
        cx.ask(FindFaults::of(&cx.engine.request(), cx.engine.project().valid_range()));
        cx.time.faulty = cx.engine.all_faults().unwrap_or_default().to_vec();
        trace_panes(ui, cx, &self.drawn);
    }
}

fn trace_panes(
    ui: &mut Ui,
    Cx { engine, time: panes, scope, presents, out, .. }: &mut Cx<'_>,
    drawn: &DrawnLines,
) {
    let Some(analysis) = engine.analysis() else {
        let text = match engine.problem() {
            Some(problem) => problem,
            None if engine.entries().is_empty() => {
                "No recordings. Choose File > Open, or drop files on the window"
            }
            None => "Fitting…",
        };
        ui.centered_and_justified(|ui| ui.label(text));
        return;
    };
    let traces = &*analysis.traces;
    panes.follow(traces);
    if !*presents {
        choices(ui, engine, panes, scope, out);
    }
    let played = panes.play(ui, traces);
    if !ui.ctx().text_edit_focused() && ui.input(|input| input.key_pressed(egui::Key::Escape)) {
        panes.cursors.clear();
        panes.playing.clear();
    }
    let shown: Vec<&AxisTraces> =
        traces.axes.iter().filter(|axis| scope.axes().contains(&axis.axis)).collect();
    let room = ui.available_height() - TIME_AXIS_HEIGHT - 4.0 - f32::from(ABOVE);
    let columns = columns(&shown, ui.available_width());
    let rows = columns.iter().map(Vec::len).max().unwrap_or(1) as f32;
    let cell_height = (room / rows).max(MIN_CELL_HEIGHT);
    let hovered_before = panes.hovered;
    let mut hovered = None;
    egui::ScrollArea::vertical()
        .auto_shrink([false, false])
        // The wheel zooms the plots, so the wheel must not scroll the pane.
        .scroll_source(egui::scroll_area::ScrollSource { mouse_wheel: false, ..Default::default() })
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 2.0;
            // Margin on the left for the label of a vertical axis, which extends a little beyond the plot.
            let room = egui::Margin { left: 6, top: ABOVE, ..egui::Margin::ZERO };
            egui::Frame::NONE.inner_margin(room).show(ui, |ui| {
                ui.columns(columns.len(), |uis| {
                    for (ui, cells) in uis.iter_mut().zip(&columns) {
                        for (at, axis) in cells.iter().enumerate() {
                            let place = Place {
                                height: cell_height - 4.0,
                                time_axis: (at + 1 == cells.len()).then_some(TIME_AXIS_HEIGHT),
                            };
                            let cell = pane::cell(ui, traces, axis, place, (panes, drawn), out);
                            hovered = hovered.or(cell);
                        }
                    }
                });
            });
        });
    panes.cursors.show(ui, scope.axes(), traces);
    if ui.input(|input| input.pointer.is_moving()) {
        panes.playing.stepped = false;
    }
    let hovered = if panes.playing.stepped { played.or(hovered) } else { hovered.or(played) };
    let hovered = hovered.or(panes.pointed.take());
    panes.drawn_in = ui.ctx().cumulative_pass_nr();
    panes.hover(hovered);
    if hovered != hovered_before {
        // Plots that were drawn before the plot under the pointer mark the sample only in the next frame, so another frame is
        // requested.
        ui.request_repaint();
    }
}

/// Returns the axes in columns of this width: forces left and moments right if both columns fit, else one column.
fn columns<'a>(shown: &[&'a AxisTraces], width: f32) -> Vec<Vec<&'a AxisTraces>> {
    let (forces, moments): (Vec<_>, Vec<_>) =
        shown.iter().copied().partition(|axis| axis.axis.is_force());
    let has_both = !forces.is_empty() && !moments.is_empty();
    if has_both && width >= 2.0 * MIN_COLUMN_WIDTH {
        vec![forces, moments]
    } else {
        vec![shown.to_vec()]
    }
}

/// Draws the choice of the axis, which the table of errors offers in a wider window.
fn axis_choice(ui: &mut Ui, axes: &[Axis], scope: &Scope, out: &mut Out) {
    let of = |shown: &[Axis]| match shown {
        [one] => axes.iter().position(|axis| axis == one),
        _ => None,
    };
    let present = of(scope.axes());
    let mut chosen = present;
    let described = |at: Option<usize>| (at.map_or("all axes", |at| axes[at].symbol()), "");
    let all = (0..axes.len()).map(Some).chain([None]);
    let button = egui::ComboBox::from_id_salt("axis").width(60.0);
    named_choice(ui, (button, "Axis"), &mut chosen, all, described)
        .on_hover_text("Axis whose load and error are shown (keys 1 to 6, 0 for all)");
    if chosen != present {
        out.send(Command::Axes(chosen.map_or(AxisChoice::All, AxisChoice::Only)));
    }
}

/// Draws the head of the traces: the recording, the legend and the view in time.
fn choices(ui: &mut Ui, engine: &Engine, panes: &mut TimeView, scope: &Scope, out: &mut Out) {
    ui.horizontal_wrapped(|ui| {
        for (label, step, about) in [
            ("◂", -1, "Shows the previous recording (Page up)"),
            ("▸", 1, "Shows the next recording (Page down)"),
        ] {
            if ui.press(label, about) {
                out.send(Command::OtherRecording(step));
            }
        }
        view_choice(ui, engine, out);
        let is_narrow = ui.available_width() < WIDTH_WITH_LEGEND;
        if is_narrow || is_compact(ui) {
            axis_choice(ui, engine.project().axes(), scope, out);
        }
        if is_narrow {
            return;
        }
        if ui.available_size_before_wrap().x > WIDTH_WITH_LENGTH
            && let Shown::One(at) = engine.project().view
            && let Some(entry) = engine.entries().get(at)
        {
            let recording = &entry.recording;
            let secs = recording.duration_secs();
            let rate = rate_in_words(recording.rate_hz(), recording.n_samples(), secs);
            let rate = rate.map(|rate| format!(" at {rate}"));
            let length = significant(secs, 3);
            let role = entry.role.label();
            ui.weak(format!("{role}, {length} s{}", rate.unwrap_or_default()));
        }
        ui.separator();
        let traces = Trace::ALL.into_iter();
        let factory = &engine.project().factory;
        for trace in traces.filter(|trace| *trace != Trace::Factory || factory.is_some()) {
            let mut shown = panes.is_shown(trace);
            if ui.available_size_before_wrap().x < LEGEND_ENTRY_WIDTH {
                ui.end_row(); // starts a new row, so that line and name stay together
            }
            line_sample(ui, trace);
            if trace_tick(ui, &mut shown, trace) {
                panes.toggle(trace);
            }
        }
        if let Some(factory) = factory {
            let path = factory.path.display();
            if ui.press_small("×", format!("Ends the comparison with {path}")) {
                out.send(Edit::Compare(None));
            }
        }
        ui.separator();
        if ui.press(
            "Fit view",
            "Shows the whole time, as a double click in a plot does. In a plot, the wheel zooms and a drag moves",
        ) {
            panes.fit();
        }
        panes.playing.controls(ui);
    });
}

/// Draws the check box that shows or hides a load. Returns true if the user changed it.
pub fn trace_tick(ui: &mut Ui, shown: &mut bool, trace: Trace) -> bool {
    let color = trace.color(ui.visuals());
    let text = egui::RichText::new(trace.label()).color(color).strong();
    ui.tick(shown, text, trace.explanation())
}

/// Draws a short piece of line in the style of a trace.
fn line_sample(ui: &mut Ui, trace: Trace) {
    let (place, _) = ui.allocate_exact_size(egui::vec2(22.0, 10.0), egui::Sense::hover());
    let ends = [place.left_center(), place.right_center()];
    let stroke = trace.stroke(ui.visuals());
    if trace.is_dashed() {
        let [dash, gap] = figure::DASHED;
        let dashes = egui::Shape::dashed_line(&ends, stroke, dash, gap);
        ui.painter().extend(dashes);
    } else {
        ui.painter().line_segment(ends, stroke);
    }
}
