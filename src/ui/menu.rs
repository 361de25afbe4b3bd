//! The menu bar.

use egui::{Button, Key, KeyboardShortcut, Modifiers};

use crate::app::{AppState, Command};
use crate::recording::Role;

const OPEN: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::O);
const EXPORT: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::E);

/// Draws the menus and listens to their shortcuts.
pub fn menu_bar(ui: &mut egui::Ui, state: &AppState, out: &mut Vec<Command>) {
    for (shortcut, command) in [
        (OPEN, Command::ChooseFiles),
        (EXPORT, Command::ChooseExport),
    ] {
        if ui.input_mut(|input| input.consume_shortcut(&shortcut)) {
            out.push(command);
        }
    }
    egui::MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| {
            let open = ui.ctx().format_shortcut(&OPEN);
            if ui.add(Button::new("Open…").shortcut_text(open)).clicked() {
                out.push(Command::ChooseFiles);
            }
            if ui.button("Built-in sensor (simulated)").clicked() {
                out.push(Command::OpenBuiltIn);
            }
            if ui.button("Close all recordings").clicked() {
                out.push(Command::CloseRecordings);
            }
            ui.separator();
            let export = ui.ctx().format_shortcut(&EXPORT);
            let can_export = state.analysis.is_some();
            let button = Button::new("Export calibration…").shortcut_text(export);
            if ui.add_enabled(can_export, button).clicked() {
                out.push(Command::ChooseExport);
            }
            ui.separator();
            if ui.button("Quit").clicked() {
                ui.send_viewport_cmd(egui::ViewportCommand::Close);
            }
        });
        ui.menu_button("Recordings", |ui| {
            for (label, role) in [
                ("All train", Role::Train),
                ("All test", Role::Test),
                ("All off", Role::Off),
            ] {
                if ui.button(label).clicked() {
                    out.push(Command::SetAllRoles(role));
                }
            }
        });
        ui.menu_button("View", |ui| {
            use egui::ThemePreference::{Dark, Light, System};
            for (label, theme) in [("Dark", Dark), ("Light", Light), ("As the system", System)] {
                let current = ui.ctx().options(|options| options.theme_preference);
                if ui.radio(current == theme, label).clicked() {
                    ui.ctx().set_theme(theme);
                }
            }
        });
    });
}
