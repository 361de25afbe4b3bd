//! Groups the user's input into steps of undo. A drag of a slider is one step, and each tick of a check box is one step.

use egui::Event;

/// Counts gestures. A gesture is a button or key from press to release, or the text typed into one field.
#[derive(Debug, Default)]
pub struct Hand {
    count: u64,
    going_on: bool,
    field: Option<egui::Id>,
}

impl Hand {
    /// Returns the number of the gesture that was going on in the last frame; `None` without a gesture.
    pub fn gesture(&self) -> Option<u64> {
        self.going_on.then_some(self.count)
    }

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
