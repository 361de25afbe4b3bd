//! The command palette: a field in which the user types a part of an action's name to find and run the action. It also finds the
//! pages of the guide that contain the typed text.

use egui::{Context, text_edit::TextEditState};
use egui::{Event, Id, Key, Modifiers};

use crate::{
    engine::Engine,
    ui::{
        actions::{self, Action, CanGo, FIND},
        command::Out,
        help,
    },
};

#[derive(Debug, Default)]
pub struct CommandPalette {
    open: bool,
    text: String,
    chosen: usize,
    /// Number of list items by which the arrow keys moved the choice since the last frame.
    steps: isize,
    entered: bool,
    /// True once the text field has the focus, which takes a few frames.
    is_typed_into: bool,
}

impl CommandPalette {
    pub fn open(&mut self) {
        *self = Self { open: true, ..Self::default() };
    }

    /// Opens the palette by its shortcut, and takes over the text that is typed after the shortcut. On a slow machine, this
    /// text arrives in the same frame or before the text field has the focus.
    pub fn listen(&mut self, context: &Context) {
        let mut events = context.input_mut(|input| std::mem::take(&mut input.events));
        events.retain(|event| {
            if !self.open && is_press(event, FIND.logical_key, FIND.modifiers) {
                self.open();
                return false;
            }
            !(self.open && self.takes(event, context))
        });
        context.input_mut(|input| input.events = events);
    }

    fn takes(&mut self, event: &Event, context: &Context) -> bool {
        let press = |key| is_press(event, key, Modifiers::NONE);
        if self.entered {
            return false;
        } else if press(Key::ArrowDown) {
            self.steps += 1;
        } else if press(Key::ArrowUp) {
            self.steps -= 1;
        } else if press(Key::Enter) {
            self.entered = true;
        } else if self.is_typed_into {
            return false;
        } else {
            match event {
                Event::Text(text) | Event::Paste(text) => self.text.push_str(text),
                _ if press(Key::Backspace) => {
                    self.text.pop();
                }
                // The key is taken out of the input, because otherwise a letter without modifiers would run a shortcut.
                Event::Key { modifiers, .. } => return !modifiers.any() && !press(Key::Escape),
                _ => return false,
            }
            TextEditState::default().store(context, field_id());
        }
        true
    }

    pub fn show(&mut self, context: &Context, engine: &Engine, can: CanGo, out: &mut Out) {
        if !self.open {
            return;
        }
        let mut found: Vec<Action> = (actions::all(engine, can).into_iter())
            .filter(|action| matches(&action.name, &self.text))
            .collect();
        found.sort_by_key(|action| !action.enabled);
        found.extend(help::pages_with(&self.text));
        let last = found.len().saturating_sub(1);
        let steps = std::mem::take(&mut self.steps);
        self.chosen = self.chosen.min(last).saturating_add_signed(steps).min(last);
        let entered = std::mem::take(&mut self.entered);
        let mut taken = None;
        let modal = egui::Modal::new(egui::Id::unique("command palette")).show(context, |ui| {
            ui.set_width(420.0);
            let label = ui.strong("Find an action");
            let field = egui::TextEdit::singleline(&mut self.text)
                .id(field_id())
                .hint_text("type a part of the action's name")
                .desired_width(f32::INFINITY);
            let field = ui.add(field).labelled_by(label.id);
            self.is_typed_into = field.has_focus() && field.enabled() && !ui.is_sizing_pass();
            field.request_focus();
            if field.changed() {
                self.chosen = 0;
            }
            ui.separator();
            egui::ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
                if found.is_empty() {
                    ui.weak("No action has all typed words in its name, and no page of the guide has this text");
                }
                for (at, action) in found.iter().enumerate() {
                    let keys = action.keys.map(|keys| ui.ctx().format_shortcut(&keys));
                    let button = egui::Button::selectable(at == self.chosen, &*action.name)
                        .shortcut_text(keys.unwrap_or_default())
                        .min_size(egui::vec2(ui.available_width(), 0.0));
                    let button = ui.add_enabled(action.enabled, button);
                    if at == self.chosen {
                        button.scroll_to_me(None);
                    }
                    let button = button.on_hover_text(&*action.explanation);
                    let button = button.on_disabled_hover_text("This action is not possible now");
                    if button.clicked() {
                        taken = Some(at);
                    }
                }
            });
        });
        let taken = if entered { Some(self.chosen) } else { taken };
        let taken = taken.and_then(|at| found.into_iter().nth(at));
        let taken = taken.filter(|action| action.enabled);
        self.open = taken.is_none() && !modal.should_close();
        if let Some(action) = taken {
            out.send(action.command);
        }
    }
}

fn field_id() -> Id {
    Id::unique("command palette search")
}

fn is_press(event: &Event, key: Key, held: Modifiers) -> bool {
    matches!(event, Event::Key { key: typed, pressed: true, modifiers, .. }
        if *typed == key && modifiers.matches_exact(held))
}

/// Returns true if every typed word occurs in the name of an action.
fn matches(name: &str, typed: &str) -> bool {
    let name = name.to_lowercase();
    typed.to_lowercase().split_whitespace().all(|word| name.contains(word))
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
