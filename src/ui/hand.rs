//! What a person's hand is at: a drag of a slider is one step of undo, and each tick is one of its own.

use egui::Event;

/// Counts gestures: a button or key from its press until it is let go, or the text that is typed into one field.
#[derive(Debug, Default)]
pub struct Hand {
    count: u64,
    going_on: bool,
    /// The text field that is typed into.
    field: Option<egui::Id>,
}

impl Hand {
    /// The number of the gesture that went on in the last frame, if there was one.
    pub fn gesture(&self) -> Option<u64> {
        self.going_on.then_some(self.count)
    }

    /// Looks at the input of a frame that was drawn.
    pub fn follow(&mut self, context: &egui::Context) {
        let typing = context.text_edit_focused();
        let field = context.memory(|memory| memory.focused().filter(|_| typing));
        let (pressed, held) = context.input(|input| {
            let pressed = input.events.iter().any(|event| match event {
                Event::PointerButton { pressed, .. } => *pressed,
                Event::Key { pressed, repeat, .. } => *pressed && !repeat && !typing,
                _ => false,
            });
            let held = input.pointer.any_down()
                || input.pointer.any_released()
                || !input.keys_down.is_empty()
                || pressed;
            (pressed, held)
        });
        if pressed || field != self.field {
            self.count += 1;
            self.field = field;
        }
        self.going_on = held || typing;
    }
}
