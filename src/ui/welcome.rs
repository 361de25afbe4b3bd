//! The choices in a window without recordings: open files, the built-in simulated sensor, or recent files.

use egui::{Button, RichText};

use crate::{
    engine::{Action, Engine},
    ui::{
        actions,
        command::{Command, Out},
        controls::Controls as _,
    },
};

const SIZE: egui::Vec2 = egui::Vec2::new(300.0, 64.0);
const RECENT: usize = 5;
/// Width of the field for a path (points).
const FIELD_WIDTH: f32 = 280.0;

pub fn choices(ui: &mut egui::Ui, engine: &Engine, out: &mut Out) {
    ui.vertical_centered(|ui| {
        ui.add_space(0.18 * ui.available_height());
        ui.heading("No recordings yet");
        ui.add_space(12.0);
        for (name, about, command) in [
            (
                "Open files…",
                "Opens recordings, calibrations or a session; you can also drop files on the window",
                Command::ChooseFiles,
            ),
            (
                "Built-in sensor",
                "Opens recordings of a simulated six-axis sensor, to try the program",
                Action::OpenBuiltIn(None).into(),
            ),
        ] {
            let button = Button::new(RichText::new(name).size(18.0)).min_size(SIZE);
            if ui.add(button).on_hover_text(about).clicked() {
                out.send(command);
            }
            ui.weak(about);
            ui.add_space(10.0);
        }
        path_field(ui, out);
        ui.add_space(10.0);
        let recent = actions::recent(engine);
        if recent.is_empty() {
            ui.weak("Recently opened files will be listed here.");
        } else {
            ui.strong("Recent");
        }
        for action in recent.into_iter().take(RECENT) {
            if ui.button(action.name).on_hover_text(&*action.explanation).clicked() {
                out.send(action.command);
            }
        }
    });
}

/// Draws the field for the path of a file, for computers without a file dialog.
fn path_field(ui: &mut egui::Ui, out: &mut Out) {
    let id = egui::Id::unique("typed path");
    let mut path: String = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    ui.allocate_ui(egui::Vec2::new(FIELD_WIDTH + 110.0, 28.0), |ui| {
        ui.horizontal(|ui| {
            let about = [
                "A recording, a calibration (.json or .cal), a session, or a folder of them",
                "Load",
                "Opens the file or folder at this path",
            ];
            let hint = "or type a path";
            if let Some(path) = ui.path_field("Open", &mut path, (FIELD_WIDTH, hint), about) {
                out.send(Action::Open(vec![path]));
            }
        });
    });
    ui.data_mut(|data| data.insert_temp(id, path));
}
