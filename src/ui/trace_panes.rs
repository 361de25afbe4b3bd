//! The middle of the window: per axis a pane with Calc., Conv. and Comp., and under it one with their errors.
//!
//! All panes share one stretch of time, and the sample under the pointer.

mod cursors;
mod overlay;
mod pane;
mod playing;

use std::collections::BTreeMap;
use std::sync::Arc;

use egui::util::undoer::{Settings, Undoer};

use crate::analysis::{AxisTraces, TraceSet, View};
use crate::app::{AppState, Command};
use crate::recording::Axis;
use crate::ui::palette::Trace;
use cursors::Cursors;
use pane::{Kind, Place};
use playing::Playing;

/// Panes are at least this high; what does not fit is scrolled to.
const LEAST_CELL_HEIGHT: f32 = 112.0;
/// Room for the time axis under the lowest pane.
const TIME_AXIS_HEIGHT: f32 = 34.0;
/// Narrower than this, all axes stand in one column.
const LEAST_TWO_COLUMN_WIDTH: f32 = 620.0;

/// Room for a piece of line and the name of its trace.
const LEGEND_ENTRY_WIDTH: f32 = 110.0;

/// A zoom that stood for so long can be gone back to (s).
const SETTLED_SECS: f32 = 0.4;
/// A step by a key is at least this part of what is on screen: about one pixel.
const STEPS_ACROSS: usize = 800;
/// So many zooms are remembered.
const MOST_ZOOMS: usize = 50;

/// What part of the traces is on screen.
#[derive(Clone, Debug, Default, PartialEq)]
struct Shown {
    /// The stretch of time; `None` shows all of it.
    time: Option<(f64, f64)>,
    /// Value ranges that were chosen by hand.
    values: BTreeMap<(Axis, Kind), (f64, f64)>,
}

/// What the panes remember between frames.
#[derive(Debug)]
pub struct TracePanes {
    /// The time axis that the rest was chosen on.
    on: Option<Arc<[f64]>>,
    shown: Shown,
    /// What was shown before, and after.
    zooms: Undoer<Shown>,
    /// The sample under the pointer, or where it plays, in the last frame.
    hovered: Option<usize>,
    hidden: Vec<Trace>,
    cursors: Cursors,
    playing: Playing,
}

impl Default for TracePanes {
    fn default() -> Self {
        Self {
            on: None,
            shown: Shown::default(),
            zooms: no_zooms(),
            hovered: None,
            hidden: Vec::new(),
            cursors: Cursors::default(),
            playing: Playing::default(),
        }
    }
}

fn no_zooms() -> Undoer<Shown> {
    Undoer::with_settings(Settings {
        max_undos: MOST_ZOOMS,
        stable_time: SETTLED_SECS,
        ..Settings::default()
    })
}

impl TracePanes {
    /// The stretch of time on screen; `None` where it is all of it.
    pub fn visible_time(&self) -> Option<(f64, f64)> {
        self.shown.time
    }

    /// Forgets what was chosen for other recordings.
    fn follow(&mut self, traces: &TraceSet) {
        let same = self
            .on
            .as_ref()
            .is_some_and(|on| Arc::ptr_eq(on, &traces.times));
        if !same {
            self.on = Some(Arc::clone(&traces.times));
            self.fit();
            self.zooms = no_zooms();
            self.hovered = None;
            self.cursors.clear();
            self.playing.clear();
        }
    }

    /// Shows everything.
    pub fn fit(&mut self) {
        self.shown = Shown::default();
    }

    /// Whether something else was shown before.
    pub fn can_go_back(&self) -> bool {
        self.zooms.has_undo(&self.shown)
    }

    /// Whether something else was shown after.
    pub fn can_go_forward(&self) -> bool {
        self.zooms.has_redo(&self.shown)
    }

    /// Shows what was shown before.
    pub fn go_back(&mut self) {
        if let Some(before) = self.zooms.undo(&self.shown) {
            self.shown = before.clone();
        }
    }

    /// Shows what was shown after.
    pub fn go_forward(&mut self) {
        if let Some(after) = self.zooms.redo(&self.shown) {
            self.shown = after.clone();
        }
    }

    /// The span between the cursors, counted from the first sample of a recording that is on screen (s).
    pub fn span_in(&self, recording: usize, traces: &TraceSet) -> Option<(f64, f64)> {
        let (a, b) = self.cursors.both()?;
        let mut segments = traces.segments.iter();
        let segment = segments.find(|segment| segment.recording == recording)?;
        let start = traces.times[segment.samples.start];
        let (from, to) = (a.min(b) - start, a.max(b) - start);
        (to >= 0.0).then_some((from.max(0.0), to))
    }

    /// Puts cursor A (0) or B (1) at the sample under the pointer, or where it plays.
    pub fn put_cursor(&mut self, which: usize) {
        let times = self.on.as_ref();
        let time = self.hovered.and_then(|k| times?.get(k).copied());
        if let Some(time) = time {
            self.cursors.put(which, time);
        }
    }

    /// All times, and the stretch of them on screen.
    fn on_screen(&self) -> Option<(&[f64], (f64, f64))> {
        let times = self.on.as_deref()?;
        Some((
            times,
            self.shown.time.unwrap_or_else(|| pane::all_of(times)),
        ))
    }

    /// Shows so many times as much of the time axis, about the sample shown or the middle.
    pub fn zoom_time(&mut self, factor: f64) {
        let Some((times, (from, to))) = self.on_screen() else {
            return;
        };
        let sample = self.hovered.and_then(|k| times.get(k).copied());
        let at = sample.filter(|at| (from..=to).contains(at));
        let at = at.unwrap_or(0.5 * (from + to));
        let zoomed = (at + (from - at) * factor, at + (to - at) * factor);
        self.shown.time = Some(pane::within(times, zoomed));
    }

    /// Shows what lies earlier or later, in shares of what is on screen.
    pub fn move_time(&mut self, share: f64) {
        let Some((times, (from, to))) = self.on_screen() else {
            return;
        };
        let by = share * (to - from);
        self.shown.time = Some(pane::within(times, (from + by, to + by)));
    }

    /// Goes one sample forward (1) or back (-1), or as many as fall on one pixel.
    pub fn step(&mut self, step: i8) {
        let Some((times, (from, to))) = self.on_screen() else {
            return;
        };
        let first = times.partition_point(|t| *t < from);
        let on_screen = times.partition_point(|t| *t <= to).saturating_sub(first);
        let samples = (on_screen / STEPS_ACROSS).max(1) as isize * isize::from(step);
        let now = self.hovered.unwrap_or(first);
        let next = now
            .saturating_add_signed(samples)
            .min(times.len().saturating_sub(1));
        if let Some(time) = times.get(next).copied() {
            self.playing.stand_at(time);
            self.follow_time(time);
        }
    }

    /// Moves what is on screen where this time would not be.
    fn follow_time(&mut self, time: f64) {
        if let Some((from, to)) = self.shown.time
            && !(from..=to).contains(&time)
        {
            self.shown.time = Some(match time < from {
                true => (time - (to - from), time),
                false => (time, time + to - from),
            });
        }
    }

    /// Goes through time, or stops.
    pub fn toggle_play(&mut self) {
        self.playing.toggle();
    }

    fn is_shown(&self, trace: Trace) -> bool {
        !self.hidden.contains(&trace)
    }

    /// Goes on playing; the sample that it is at. What is on screen follows.
    fn play(&mut self, ui: &egui::Ui, traces: &TraceSet) -> Option<usize> {
        let start = traces.times.first().copied().unwrap_or(0.0);
        let on_screen = self.shown.time.map_or(start, |(from, _)| from.max(start));
        let from = self.cursors.first().unwrap_or(on_screen);
        let passed = ui.input(|input| f64::from(input.stable_dt));
        let (sample, time) = self.playing.go_on(passed, from, traces)?;
        if self.playing.is_running() {
            ui.ctx().request_repaint();
            self.follow_time(time);
        }
        Some(sample)
    }
}

/// Draws the row of choices and the panes.
pub fn trace_panes(
    ui: &mut egui::Ui,
    state: &AppState,
    panes: &mut TracePanes,
    out: &mut Vec<Command>,
) {
    let Some(analysis) = &state.analysis else {
        ui.centered_and_justified(|ui| match &state.problem {
            Some(problem) => ui.label(problem),
            None if state.recordings.entries().is_empty() => ui.label(
                "Open recordings to see them here: File > Open, or drop files on the window",
            ),
            None => ui.label("Fitting…"),
        });
        return;
    };
    let traces = &*analysis.traces;
    panes.follow(traces);
    choices(ui, state, panes, out);
    let played = panes.play(ui, traces);
    if !ui.ctx().text_edit_focused() && ui.input(|input| input.key_pressed(egui::Key::Escape)) {
        panes.cursors.clear();
        panes.playing.clear();
    }
    let shown: Vec<&AxisTraces> = traces
        .axes
        .iter()
        .filter(|axis| state.is_shown(axis.axis))
        .collect();
    if shown.is_empty() {
        ui.centered_and_justified(|ui| ui.label("No axis is shown; choose some above"));
        return;
    }
    let columns = columns(&shown, ui.available_width());
    let rows = columns.iter().map(Vec::len).max().unwrap_or(1) as f32;
    let room = ui.available_height() - TIME_AXIS_HEIGHT - 4.0;
    let cell_height = (room / rows).max(LEAST_CELL_HEIGHT);
    let hovered_before = panes.hovered;
    let mut hovered = None;
    egui::ScrollArea::vertical()
        .auto_shrink([false, false])
        // The wheel zooms.
        .scroll_source(egui::scroll_area::ScrollSource {
            mouse_wheel: false,
            ..Default::default()
        })
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 2.0;
            ui.columns(columns.len(), |uis| {
                for (ui, cells) in uis.iter_mut().zip(&columns) {
                    for (at, axis) in cells.iter().enumerate() {
                        let place = Place {
                            height: cell_height - 4.0,
                            time_axis: (at + 1 == cells.len()).then_some(TIME_AXIS_HEIGHT),
                        };
                        hovered = hovered.or(pane::cell(ui, traces, axis, place, panes, out));
                    }
                }
            });
        });
    panes.cursors.show(ui, state, traces);
    panes
        .zooms
        .feed_state(ui.input(|input| input.time), &panes.shown);
    if ui.input(|input| input.pointer.is_moving()) {
        panes.playing.let_pointer_lead();
    }
    let hovered = match panes.playing.leads() {
        true => played.or(hovered),
        false => hovered.or(played),
    };
    panes.hovered = hovered;
    if hovered != hovered_before {
        // The panes drawn before the hovered one show the sample in the next frame.
        ui.request_repaint();
    }
}

/// Forces to the left, moments to the right, where there is room for both; else one column.
fn columns<'a>(shown: &[&'a AxisTraces], width: f32) -> Vec<Vec<&'a AxisTraces>> {
    let (forces, moments): (Vec<_>, Vec<_>) =
        shown.iter().copied().partition(|axis| axis.axis.is_force());
    if width < LEAST_TWO_COLUMN_WIDTH || forces.is_empty() || moments.is_empty() {
        vec![shown.to_vec()]
    } else {
        vec![forces, moments]
    }
}

fn choices(ui: &mut egui::Ui, state: &AppState, panes: &mut TracePanes, out: &mut Vec<Command>) {
    ui.horizontal_wrapped(|ui| {
        view_choice(ui, state, out);
        ui.separator();
        for axis in state.axes() {
            let shown = state.is_shown(*axis);
            let toggle = ui
                .selectable_label(shown, axis.symbol())
                .on_hover_text("Show or hide this axis");
            if toggle.clicked() {
                out.push(Command::ShowAxis(*axis, !shown));
            }
        }
        ui.separator();
        let traces = Trace::ALL.into_iter();
        for trace in traces.filter(|trace| *trace != Trace::Factory || state.factory.is_some()) {
            let mut shown = panes.is_shown(trace);
            if ui.available_size_before_wrap().x < LEGEND_ENTRY_WIDTH {
                ui.end_row(); // the line stands beside its name
            }
            line_sample(ui, trace);
            let color = trace.color(ui.visuals());
            let text = egui::RichText::new(trace.label()).color(color).strong();
            if ui
                .checkbox(&mut shown, text)
                .on_hover_text(trace.explanation())
                .changed()
            {
                panes.hidden.retain(|hidden| *hidden != trace);
                if !shown {
                    panes.hidden.push(trace);
                }
            }
        }
        if let Some(factory) = &state.factory {
            let drop = ui.small_button("×");
            let path = factory.path.display();
            if drop.on_hover_text(format!("Compare no longer with {path}")).clicked() {
                out.push(Command::DropFactory);
            }
        }
        ui.separator();
        let fit = ui.button("Fit view").on_hover_text(
            "Show all of it (or double-click in a pane). Wheel: zoom in time; drag: move; right drag: zoom into a box",
        );
        if fit.clicked() {
            panes.fit();
        }
        ui.separator();
        panes.playing.controls(ui);
    });
}

/// A short piece of line as the panes draw it where samples lie apart.
fn line_sample(ui: &mut egui::Ui, trace: Trace) {
    let (place, _) = ui.allocate_exact_size(egui::vec2(22.0, 10.0), egui::Sense::hover());
    let ends = [place.left_center(), place.right_center()];
    let stroke = trace.stroke(ui.visuals());
    if trace.is_dashed() {
        let dashes = egui::Shape::dashed_line(&ends, stroke, pane::DASH, pane::DASH_GAP);
        ui.painter().extend(dashes);
    } else {
        ui.painter().line_segment(ends, stroke);
    }
}

fn view_choice(ui: &mut egui::Ui, state: &AppState, out: &mut Vec<Command>) {
    let entries = state.recordings.entries();
    let name = |view: View| match view {
        View::One(at) => entries
            .get(at)
            .map_or_else(|| "–".to_owned(), |entry| entry.recording.name().to_owned()),
        View::All => "All, end to end".to_owned(),
    };
    let explanation = "The recording that is drawn; all of them stand one after the other";
    egui::ComboBox::from_label("on screen")
        .selected_text(name(state.view))
        .width(180.0)
        .truncate()
        .show_ui(ui, |ui| {
            let views = (0..entries.len()).map(View::One);
            for view in std::iter::once(View::All).chain(views) {
                if ui
                    .selectable_label(state.view == view, name(view))
                    .clicked()
                {
                    out.push(Command::SetView(view));
                    ui.close(); // by a key it would stay
                }
            }
        })
        .response
        .on_hover_text(explanation);
}
