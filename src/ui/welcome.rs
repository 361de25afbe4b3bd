//! The choices in a window without recordings: open files, the built-in simulated sensor, or recent files.

use egui::{Button, RichText};

use crate::{
    engine::{Action, Engine},
    ui::{
        actions,
        command::{Command, Out, PathFor},
        controls::Controls as _,
    },
};

const SIZE: egui::Vec2 = egui::Vec2::new(300.0, 64.0);
const RECENT: usize = 5;

pub fn choices(ui: &mut egui::Ui, engine: &Engine, out: &mut Out) {
    ui.vertical_centered(|ui| {
        ui.add_space(0.18 * ui.available_height());
        ui.heading("No recordings yet");
        ui.add_space(12.0);
        for (name, about, command) in [
            (
                "Open files…",
                "Opens recordings, calibrations or a session; you can also drop files on the window",
                Command::Choose(PathFor::Open),
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
        if ui.press("Type a path…", "Opens the file or folder at a path that you type") {
            out.send(Command::TypePath(PathFor::Open));
        }
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
