//! Pane of the recordings, by group, with the role and errors of each recording.

mod list;
mod row;

use egui::Ui;

use crate::{
    engine::{Action, Edit, Engine},
    questions::check::query::FindFaults,
    ui::{
        command::Out,
        controls::{Controls as _, place_down},
        pane::{Cx, PaneView},
    },
};

pub use list::has_focus;

/// Height of the part below the list (points).
const FOOT_HEIGHT: f32 = 60.0;

/// Explanation of the simulated sensor.
pub const SIMULATED: &str = "The recordings come from the built-in simulated sensor, not from a real sensor. The simulation is of a six-axis resin sensor on a robot arm, which turns a weight of 1.128 kg";

#[derive(Debug)]
pub struct View {
    /// Share of each recording's time that the button Split assigns to training (%).
    split_percent: f64,
    /// Recording whose group is being edited.
    group: Typed,
    list: list::List,
}

/// Index of a recording, and the text that the user types into a field about the recording.
type Typed = Option<(usize, String)>;

impl Default for View {
    fn default() -> Self {
        let list = list::List::default();
        Self { split_percent: 60.0, group: None, list }
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        cx.ask(FindFaults::of(&cx.engine.request(), cx.engine.project().valid_range()));
        recordings_panel(ui, cx.engine, self, cx.out);
    }
}

fn recordings_panel(ui: &mut Ui, engine: &Engine, fields: &mut View, out: &mut Out) {
    if let Some(applied) = &engine.project().applied {
        ui.horizontal_wrapped(|ui| {
            ui.warn(format!("Applying {}", applied.path.display()));
            if ui.press(
                "Fit again",
                "Closes the applied calibration, and fits a calibration to the recordings again",
            ) {
                out.send(Edit::Apply(None));
            }
        });
    }
    if engine.entries().is_empty() {
        ui.weak(
            "Open files, drop them on the window, or choose File > Built-in sensor (simulated).",
        );
        return;
    }
    let rest = ui.available_rect_before_wrap();
    let foot = rest.bottom() - FOOT_HEIGHT;
    place_down(ui, rest.with_max_y(foot), "list", |ui| list::list(ui, engine, fields, out));
    place_down(ui, rest.with_min_y(foot), "foot", |ui| {
        ui.separator();
        split_row(ui, engine, fields, out);
        faults_row(ui, engine, out);
    });
}

fn split_row(ui: &mut Ui, engine: &Engine, fields: &mut View, out: &mut Out) {
    ui.horizontal(|ui| {
        let field = egui::DragValue::new(&mut fields.split_percent)
            .range(1.0..=99.0)
            .max_decimals(1)
            .suffix(" %");
        ui.field("Train on the first", field, "Share of each recording's time that is used for training");
        ui.label("of each");
        if ui.press(
            "Split",
            "Splits each recording in time: the first segment is for training, the second for testing. Each test segment starts cold",
        ) {
            out.send(Edit::Split(fields.split_percent / 100.0));
        }
        if engine.project().split.is_some()
            && ui.press("Undo split", "Joins the training and the test segment of each recording again") {
                out.send(Edit::Unsplit);
            }
    });
}

/// Draws the number of samples that look faulty, and the button that leaves them out.
fn faults_row(ui: &mut Ui, engine: &Engine, out: &mut Out) {
    let project = engine.project();
    let entries = project.recordings.entries();
    let faults = (0..entries.len()).filter_map(|at| engine.faults_of(at));
    let n_faulty: usize = faults.map(|faults| faults.n_samples).sum();
    ui.horizontal(|ui| {
        if project.recordings.is_simulated() {
            ui.warn("simulated").on_hover_text(SIMULATED);
        }
        if n_faulty > 0 {
            let n: usize = entries.iter().map(|entry| entry.recording.n_samples()).sum();
            ui.warn(format!("{n_faulty} of {n} samples look faulty"))
                .on_hover_text("The hover text of each recording names its faults");
        }
        if (n_faulty > 0 || project.gauge_range.is_some())
            && ui.press(
                "Leave out faulty samples",
                "Removes the faulty samples from the recordings. Afterwards, exported code reports clipped gauges. Undo restores the samples",
            ) {
                out.send(Action::LeaveOutFaulty);
            }
    });
}
