//! Context menus of widgets, for mouse and keyboard.

use egui::{Key, Modifiers, Popup, PopupCloseBehavior, Response, SetOpenCommand, Ui};

/// Number of frames after its opening in which a menu takes the keyboard focus; it is invisible in its first frame.
const FRAMES_TO_FOCUS: u32 = 2;

/// Opens a menu by the right mouse button or, for a focused widget, by the menu key or Shift+F10. `contents` returns the
/// first item, which gets the focus.
pub fn context_menu(response: &Response, contents: impl FnOnce(&mut Ui) -> Response) {
    let context = &response.ctx;
    let by_key = response.has_focus()
        && context.input_mut(|input| {
            input.consume_key(Modifiers::NONE, Key::Menu)
                || input.consume_key(Modifiers::SHIFT, Key::F10)
        });
    // A click on a text field in the menu must not close the menu, so each item closes the menu itself.
    let mut popup =
        Popup::context_menu(response).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let id = popup.get_id();
    if by_key {
        popup = popup.open_memory(SetOpenCommand::Bool(true));
        context.data_mut(|data| data.insert_temp(id, FRAMES_TO_FOCUS));
    }
    // A menu that was opened by a key appears at the centre of its widget.
    if by_key || Popup::position_of_id(context, id).is_none() {
        popup = popup.at_position(response.rect.center());
    }
    popup.show(|ui| {
        let first = contents(ui);
        let frames = ui.data(|data| data.get_temp::<u32>(id)).unwrap_or_default();
        if frames > 0 {
            first.request_focus();
            ui.data_mut(|data| data.insert_temp(id, frames - 1));
        }
    });
}
