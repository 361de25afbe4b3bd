//! The menu bar.

use egui::{Button, Ui};

use crate::{
    engine::{Action as Do, Engine, Preferences},
    ui::{
        actions::{self, Action, CanGo},
        command::{Command, Out, Workspace},
        controls::Controls as _,
        workspace::Workspaces,
    },
};

pub fn menu_bar(ui: &mut Ui, engine: &Engine, workspaces: &Workspaces, can: CanGo, out: &mut Out) {
    egui::MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| {
            items(ui, actions::opening(engine), out);
            recent(ui, engine, out);
            ui.separator();
            items(ui, actions::writing(engine), out);
            ui.separator();
            items(ui, [actions::quit()], out);
        });
        ui.menu_button("Edit", |ui| items(ui, actions::edit(can), out));
        ui.menu_button("Roles", |ui| items(ui, actions::roles(engine), out));
        ui.menu_button("Navigate", |ui| items(ui, actions::time(can), out));
        ui.menu_button("View", |ui| view(ui, engine, out));
        ui.menu_button("Help", |ui| items(ui, actions::help(), out));
        ui.separator();
        for (workspace, title, explanation) in Workspace::ALL {
            let is_shown = workspaces.shown() == workspace;
            let label = egui::RichText::new(title).strong();
            if ui.selectable_label(is_shown, label).on_hover_text(explanation).clicked() {
                out.send(Command::Show(workspace));
            }
        }
    });
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
        ui.menu_button("Recent", |ui| {
            items(ui, actions::recent(engine), out);
            ui.separator();
            if ui.press(
                "Clear list",
                "Removes all files from this list of recent files; the files stay on disk",
            ) {
                ui.close();
                out.send(prefer(Preferences { recent: Vec::new(), ..engine.preferences.clone() }));
            }
        });
    });
}

fn view(ui: &mut Ui, engine: &Engine, out: &mut Out) {
    items(ui, actions::workspaces(), out);
    ui.separator();
    items(ui, actions::panes(), out);
    ui.separator();
    items(ui, actions::pictures(), out);
    ui.separator();
    for (label, theme, explanation) in actions::THEMES {
        let radio = ui.radio(engine.preferences.theme == theme, label);
        if radio.on_hover_text(explanation).clicked() {
            out.send(prefer(Preferences { theme, ..engine.preferences.clone() }));
        }
    }
    ui.separator();
    items(ui, actions::text_scales(), out);
}

fn prefer(preferences: Preferences) -> Command {
    Do::Prefer(preferences).into()
}
