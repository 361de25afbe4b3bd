//! The menu bar.

use egui::{Button, Ui};

use crate::{
    engine::Engine,
    recording::Item,
    ui::{
        actions::{self, Action, CanGo},
        appearance::is_compact,
        command::{Command, Out, Workspace},
        controls::{Controls as _, named_selected},
        recordings_panel::SIMULATED,
        workspace::Workspaces,
    },
};

pub const HEIGHT: f32 = 40.0;
/// Widths of the window (points) from which the keys of the workspaces and the name of the sensor are shown.
const WIDTH_WITH_KEYS: f32 = 1500.0;

pub fn menu_bar(ui: &mut Ui, engine: &Engine, workspaces: &Workspaces, can: CanGo, out: &mut Out) {
    let is_wide = ui.ctx().content_rect().width() >= WIDTH_WITH_KEYS;
    ui.horizontal_centered(|ui| {
        egui::MenuBar::new().ui(ui, |ui| {
            ui.menu_button("File", |ui| {
                items(ui, actions::opening(engine), out);
                recent(ui, engine, out);
                ui.separator();
                items(ui, actions::writing(engine), out);
                ui.separator();
                items(ui, [actions::quit()], out);
            });
            ui.menu_button("Edit", |ui| {
                items(ui, actions::edit(can), out);
                ui.separator();
                items(ui, actions::roles(engine), out);
            });
            ui.menu_button("View", |ui| view(ui, engine, out));
            ui.menu_button("Help", |ui| items(ui, actions::help(), out));
            ui.separator();
            for (at, (workspace, title, explanation)) in Workspace::ALL.into_iter().enumerate() {
                let is_shown = workspaces.shown() == workspace;
                let mut button = Button::selectable(is_shown, egui::RichText::new(title).strong());
                if is_wide {
                    button = button.shortcut_text(format!("F{}", at + 2));
                }
                let button = ui.add(button);
                named_selected(&button, egui::Role::Button, is_shown, title);
                if button.on_hover_text(explanation).clicked() {
                    out.send(Command::Show(workspace));
                }
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let find = Button::new("Find an action").shortcut_text("Ctrl P");
                let about =
                    "Opens a field in which a part of an action's name is typed to find the action";
                if ui.add(find).on_hover_text(about).clicked() {
                    out.send(Command::ShowPalette);
                }
                if is_wide {
                    sensor(ui, engine);
                } else if is_compact(ui) && workspaces.shown() != Workspace::Check {
                    let about = "Opens or closes the right column (Ctrl+D)";
                    if ui.press("Right column", about) {
                        out.send(Command::ToggleRight);
                    }
                }
            });
        });
    });
}

/// Draws the name of the sensor.
fn sensor(ui: &mut Ui, engine: &Engine) {
    let project = engine.project();
    let identity = &project.identity;
    if project.recordings.is_simulated() {
        ui.label("Simulated sensor").on_hover_text(SIMULATED);
    } else if identity.get(Item::Serial).is_empty() {
        return;
    } else {
        ui.label(identity.get(Item::Serial));
    }
    ui.weak("Sensor");
}

fn items(ui: &mut Ui, actions: impl IntoIterator<Item = Action>, out: &mut Out) {
    for action in actions {
        let mut button = Button::new(action.name);
        if let Some(keys) = action.keys {
            button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
        }
        let button = ui.add_enabled(action.enabled, button);
        let button = button.on_hover_text(&*action.explanation);
        if button.on_disabled_hover_text(&*action.explanation).clicked() {
            out.send(action.command);
            ui.close(); // a press by a key does not close the menu
        }
    }
}

fn recent(ui: &mut Ui, engine: &Engine, out: &mut Out) {
    let any = !engine.preferences.recent.is_empty();
    ui.add_enabled_ui(any, |ui| {
        ui.menu_button("Recent", |ui| items(ui, actions::recent(engine), out));
    });
}

fn view(ui: &mut Ui, engine: &Engine, out: &mut Out) {
    items(ui, actions::workspaces(), out);
    ui.separator();
    items(ui, actions::themes(engine), out);
    ui.separator();
    items(ui, actions::text_scales(), out);
}
