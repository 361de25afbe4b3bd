//! Find an action by typing a part of its name.

use egui::{Key, Modifiers};

use crate::engine::Engine;
use crate::ui::actions::{self, Action, CanGo};
use crate::ui::command::Command;

/// What the palette remembers while it is open.
#[derive(Debug, Default)]
pub struct CommandPalette {
    open: bool,
    text: String,
    chosen: usize,
}

impl CommandPalette {
    /// Opens it, empty.
    pub fn open(&mut self) {
        *self = Self {
            open: true,
            ..Self::default()
        };
    }

    /// Draws it while it is open.
    pub fn show(
        &mut self,
        context: &egui::Context,
        engine: &Engine,
        can: CanGo,
        out: &mut Vec<Command>,
    ) {
        if !self.open {
            return;
        }
        let found: Vec<Action> = (actions::all(engine, can).into_iter())
            .filter(|action| action.enabled && matches(&action.name, &self.text))
            .collect();
        self.chosen = self.chosen.min(found.len().saturating_sub(1));
        let press = |key| context.input_mut(|input| input.consume_key(Modifiers::NONE, key));
        if press(Key::ArrowDown) {
            self.chosen = (self.chosen + 1).min(found.len().saturating_sub(1));
        }
        if press(Key::ArrowUp) {
            self.chosen = self.chosen.saturating_sub(1);
        }
        let entered = press(Key::Enter);
        let mut taken = None;
        let modal = egui::Modal::new(egui::Id::unique("command palette")).show(context, |ui| {
            ui.set_width(420.0);
            let label = ui.strong("Find an action");
            let field = egui::TextEdit::singleline(&mut self.text)
                .hint_text("a part of its name")
                .desired_width(f32::INFINITY);
            let field = ui.add(field).labelled_by(label.id);
            field.request_focus();
            if field.changed() {
                self.chosen = 0;
            }
            ui.separator();
            egui::ScrollArea::vertical()
                .max_height(320.0)
                .show(ui, |ui| {
                    if found.is_empty() {
                        ui.weak("Nothing is called so");
                    }
                    for (at, action) in found.iter().enumerate() {
                        let keys = action.keys.map(|keys| ui.ctx().format_shortcut(&keys));
                        let button = egui::Button::selectable(at == self.chosen, &*action.name)
                            .shortcut_text(keys.unwrap_or_default())
                            .min_size(egui::vec2(ui.available_width(), 0.0));
                        let button = ui.add(button);
                        if at == self.chosen {
                            button.scroll_to_me(None);
                        }
                        if button.on_hover_text(&*action.explanation).clicked() {
                            taken = Some(at);
                        }
                    }
                });
        });
        if entered {
            taken = Some(self.chosen);
        }
        if let Some(action) = taken.and_then(|at| found.into_iter().nth(at)) {
            out.push(action.command);
            self.open = false;
        }
        if modal.should_close() {
            self.open = false;
        }
    }
}

/// Whether every word that was typed stands in the name.
fn matches(name: &str, typed: &str) -> bool {
    let name = name.to_lowercase();
    typed
        .to_lowercase()
        .split_whitespace()
        .all(|word| name.contains(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_in_any_order_and_case() {
        assert!(matches("Export calibration…", "CALIB exp"));
        assert!(matches("Undo", ""));
        assert!(!matches("Undo", "re"));
    }
}
