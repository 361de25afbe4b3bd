//! A drop-down list for mouse and keyboard. The list opens at the chosen item; Up and Down move, Enter chooses, Escape closes,
//! and the focus returns to the button.

use egui::{ComboBox, Event, FocusDirection, Key, Response, Ui, WidgetInfo};

#[derive(Clone, Default)]
struct Keys {
    pass: u64,
    focused: Option<usize>,
    /// List item that gets the keyboard focus in a later frame. In its first frame a list is invisible, so no item can take
    /// the focus.
    target: Option<usize>,
}

/// Draws the button and, if it is open, the list. `described` returns the name of a value and its explanation.
pub fn choice<T: PartialEq + Copy, N: Into<String>>(
    ui: &mut Ui,
    button: ComboBox,
    chosen: &mut T,
    values: impl IntoIterator<Item = T>,
    described: impl Fn(T) -> (N, &'static str),
) -> Response {
    let button = button.selected_text(described(*chosen).0.into());
    let shown = button.show_ui(ui, |ui| list(ui, chosen, values.into_iter().collect(), described));
    if shown.inner == Some(true) {
        shown.response.request_focus();
    }
    shown.response
}

/// Draws a label, and after it the button with its list. Screen readers read the label as the name of the button.
pub fn labelled_choice<T: PartialEq + Copy, N: Into<String>>(
    ui: &mut Ui,
    (label, width): (&str, f32),
    chosen: &mut T,
    values: impl IntoIterator<Item = T>,
    described: impl Fn(T) -> (N, &'static str),
) -> Response {
    ui.label(label);
    let button = ComboBox::from_id_salt(label).width(width).truncate();
    named_choice(ui, (button, label), chosen, values, described)
}

/// Draws the button with its list, and gives it a name for screen readers.
pub fn named_choice<T: PartialEq + Copy, N: Into<String>>(
    ui: &mut Ui,
    (button, name): (ComboBox, &str),
    chosen: &mut T,
    values: impl IntoIterator<Item = T>,
    described: impl Fn(T) -> (N, &'static str),
) -> Response {
    let response = choice(ui, button, chosen, values, &described);
    let shown: String = described(*chosen).0.into();
    response.widget_info(|| WidgetInfo {
        current_text_value: Some(shown.clone()),
        ..WidgetInfo::labeled(egui::Role::ComboBox, true, name)
    });
    response
}

/// Draws the list. Returns true if a key closes it.
fn list<T: PartialEq + Copy, N: Into<String>>(
    ui: &mut Ui,
    chosen: &mut T,
    items: Vec<T>,
    described: impl Fn(T) -> (N, &'static str),
) -> bool {
    let id = ui.layer_id().id.with("keys");
    let pass = ui.ctx().cumulative_pass_nr();
    let mut keys: Keys = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    let is_new = keys.pass + 1 < pass;
    let mut takes = false;
    let at_first = items.iter().position(|value| value == chosen);
    if is_new {
        // A list that was opened with the pointer takes the keyboard focus only after an arrow key.
        let by_pointer = ui.input(|input| input.pointer.any_click());
        keys = Keys { target: at_first.filter(|_| !by_pointer), ..Keys::default() };
    } else {
        let (steps, entered) = pressed(ui);
        if steps != 0 {
            let from = keys.target.or(keys.focused).or(at_first);
            let n = items.len() as isize;
            let from = from.map_or(if steps > 0 { -1 } else { 0 }, |from| from as isize);
            keys.target = (n > 0).then(|| (from + steps).rem_euclid(n) as usize);
        }
        takes = entered && keys.target.is_some();
    }
    keys.pass = pass;
    keys.focused = None;
    let mut is_taken = false;
    for (at, value) in items.into_iter().enumerate() {
        let (name, about) = described(value);
        let mut item = ui.selectable_label(*chosen == value, name.into());
        if item.has_focus() {
            keys.focused = Some(at);
        }
        if keys.target == Some(at) {
            item.scroll_to_me(None);
            item.request_focus();
        }
        if !about.is_empty() {
            item = item.on_hover_text(about);
        }
        if item.clicked() || (takes && keys.target == Some(at)) {
            *chosen = value;
            is_taken = true;
            ui.close(); // egui closes the list only after a click with the mouse
        }
    }
    if keys.focused == keys.target {
        keys.target = None;
    }
    ui.data_mut(|data| data.insert_temp(id, keys));
    let by_pointer = ui.input(|input| input.pointer.any_click());
    (is_taken && !by_pointer) || ui.input(|input| input.key_pressed(Key::Escape))
}

/// Returns the number of items by which the arrow keys of this frame move, and whether Enter followed. On a slow machine
/// several keys arrive in one frame.
fn pressed(ui: &Ui) -> (isize, bool) {
    let (mut steps, mut entered) = (0, false);
    ui.input_mut(|input| {
        input.events.retain(|event| {
            let Event::Key { key, pressed: true, modifiers, .. } = event else {
                return true;
            };
            match key {
                _ if modifiers.any() || entered => return true,
                Key::ArrowDown => steps += 1,
                Key::ArrowUp => steps -= 1,
                Key::Enter if steps != 0 => entered = true,
                _ => return true,
            }
            false
        });
    });
    if steps != 0 {
        ui.memory_mut(|memory| memory.move_focus(FocusDirection::None));
    }
    (steps, entered)
}
