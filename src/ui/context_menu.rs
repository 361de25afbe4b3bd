//! Menus of a widget that work by mouse and keyboard alike.

use egui::{Key, Modifiers, Popup, PopupCloseBehavior, Response, SetOpenCommand, Ui};

/// A menu is invisible in its first frame, in which nothing in it can take the focus.
const FRAMES_TO_FOCUS: u32 = 2;

/// Opens for the right button, and where the widget has the focus for the menu key and Shift+F10; `contents` returns the
/// first item, to which the keyboard goes on.
pub fn context_menu(response: &Response, contents: impl FnOnce(&mut Ui) -> Response) {
    let context = &response.ctx;
    let by_key = response.has_focus()
        && context.input_mut(|input| {
            input.consume_key(Modifiers::NONE, Key::Menu)
                || input.consume_key(Modifiers::SHIFT, Key::F10)
        });
    // Text fields may be clicked; items close it themselves.
    let mut popup =
        Popup::context_menu(response).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let id = popup.get_id();
    if by_key {
        popup = popup.open_memory(SetOpenCommand::Bool(true));
        context.data_mut(|data| data.insert_temp(id, FRAMES_TO_FOCUS));
    }
    // Opened by a key, it stands where no pointer was.
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
