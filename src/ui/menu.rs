//! The menu bar.

use egui::Button;

use crate::app::{AppState, Command, Pane, Preferences, Theme, Wish};
use crate::ui::actions::{self, Action, CanGo};
use crate::ui::workspace::Workspace;

/// Draws the menus.
pub fn menu_bar(
    ui: &mut egui::Ui,
    state: &AppState,
    workspace: &Workspace,
    can: CanGo,
    out: &mut Vec<Command>,
) {
    egui::MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| {
            items(ui, actions::opening(state), out);
            recent(ui, state, out);
            ui.separator();
            items(ui, actions::writing(state), out);
            ui.separator();
            items(ui, [actions::quit()], out);
        });
        ui.menu_button("Edit", |ui| items(ui, actions::edit(can), out));
        ui.menu_button("Roles", |ui| items(ui, actions::roles(state), out));
        ui.menu_button("Go", |ui| items(ui, actions::time(can), out));
        ui.menu_button("View", |ui| view(ui, state, workspace, out));
        ui.menu_button("Help", |ui| items(ui, actions::help(), out));
    });
}

fn items(ui: &mut egui::Ui, actions: impl IntoIterator<Item = Action>, out: &mut Vec<Command>) {
    for action in actions {
        let mut button = Button::new(action.name);
        if let Some(keys) = action.keys {
            button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
        }
        let button = ui.add_enabled(action.enabled, button);
        let button = button.on_hover_text(action.explanation);
        if button.on_disabled_hover_text(action.explanation).clicked() {
            out.push(action.command);
            ui.close(); // by a key it would stay
        }
    }
}

fn recent(ui: &mut egui::Ui, state: &AppState, out: &mut Vec<Command>) {
    let recent = &state.preferences.recent;
    ui.add_enabled_ui(!recent.is_empty(), |ui| {
        ui.menu_button("Recent", |ui| {
            for path in recent {
                let name = path.file_name().unwrap_or(path.as_os_str());
                let button = ui.button(name.to_string_lossy());
                if button.on_hover_text(path.display().to_string()).clicked() {
                    out.push(Command::OpenFiles(vec![path.clone()]));
                    ui.close();
                }
            }
            ui.separator();
            let forget = ui.button("Forget all of these");
            let forget = forget.on_hover_text("Empties this list; the files stay");
            if forget.clicked() {
                ui.close();
                out.push(Command::SetPreferences(Preferences {
                    recent: Vec::new(),
                    ..state.preferences.clone()
                }));
            }
        });
    });
}

fn view(ui: &mut egui::Ui, state: &AppState, workspace: &Workspace, out: &mut Vec<Command>) {
    items(ui, actions::arrangements(), out);
    ui.separator();
    for pane in Pane::ALL {
        let mut open = workspace.is_open(pane);
        if ui
            .checkbox(&mut open, pane.title())
            .on_hover_text(pane.explanation())
            .changed()
        {
            out.push(Command::Wish(match open {
                true => Wish::ShowPane(pane),
                false => Wish::ClosePane(pane),
            }));
        }
    }
    ui.menu_button("Move a pane", |ui| {
        for pane in Pane::ALL {
            ui.menu_button(pane.title(), |ui| items(ui, actions::places(pane), out));
        }
    })
    .response
    .on_hover_text("To another place, or to another size; tabs can be dragged too");
    ui.separator();
    items(ui, actions::pictures(), out);
    ui.separator();
    for (label, theme, explanation) in [
        ("Dark", Theme::Dark, "Light on dark"),
        (
            "Light",
            Theme::Light,
            "Dark on light, as pictures for print are",
        ),
        (
            "As the system",
            Theme::System,
            "Dark or light as the desktop is",
        ),
    ] {
        let radio = ui.radio(state.preferences.theme == theme, label);
        if radio.on_hover_text(explanation).clicked() {
            out.push(Command::SetPreferences(Preferences {
                theme,
                ..state.preferences.clone()
            }));
        }
    }
    ui.separator();
    items(ui, actions::text_scales(), out);
}
