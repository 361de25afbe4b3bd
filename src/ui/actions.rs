//! Everything that can be asked for by name: one table for menus, keys, the palette and the sheet of keys.

use egui::{Key, KeyboardShortcut, Modifiers};

use crate::app::{AppState, Command, ImportCommand, Pane, PictureTo, Preset, SessionCommand, Wish};
use crate::recording::{Role, Tare};

/// Something to ask for.
pub struct Action {
    /// What it is called, everywhere.
    pub name: String,
    /// The keys that ask for it.
    pub keys: Option<KeyboardShortcut>,
    /// Whether it makes sense now.
    pub enabled: bool,
    /// What it asks.
    pub command: Command,
}

const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// Keys with Ctrl (⌘ on a Mac).
pub const fn ctrl(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND, key))
}

const fn ctrl_shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(CTRL_SHIFT, key))
}

const fn alone(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::NONE, key))
}

const fn alt(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::ALT, key))
}

/// What can be gone back and forward to.
#[derive(Clone, Copy, Debug, Default)]
pub struct CanGo {
    /// Whether a choice can be undone.
    pub undo: bool,
    /// Whether one can be made again.
    pub redo: bool,
    /// Whether there was another part of time before.
    pub zoom_back: bool,
    /// Whether there was one after.
    pub zoom_forward: bool,
}

/// The files group.
pub fn files(state: &AppState) -> Vec<Action> {
    vec![
        always("Open…", ctrl(Key::O), Command::ChooseFiles),
        always(
            "Import…",
            ctrl_shift(Key::O),
            Command::Import(ImportCommand::Choose),
        ),
        always("Built-in sensor (simulated)", None, Command::OpenBuiltIn),
        action(
            "Close all recordings",
            None,
            !state.recordings.entries().is_empty(),
            Command::CloseRecordings,
        ),
        action(
            "Export calibration…",
            ctrl(Key::E),
            state.analysis.is_some(),
            Command::ChooseExport,
        ),
        action(
            "Save report…",
            None,
            state.analysis.is_some(),
            Command::ChooseReport,
        ),
        action(
            "Save traces on screen…",
            None,
            state.analysis.is_some(),
            Command::Wish(Wish::SaveTraces),
        ),
        always(
            "Save session",
            ctrl(Key::S),
            Command::Session(SessionCommand::Save),
        ),
        always(
            "Save session as…",
            ctrl_shift(Key::S),
            Command::Session(SessionCommand::SaveAs),
        ),
        always(
            "Quit",
            ctrl(Key::Q),
            Command::Session(SessionCommand::Close),
        ),
    ]
}

/// Going back and forward.
pub fn edit(can: CanGo) -> Vec<Action> {
    [
        ("Undo", ctrl(Key::Z), can.undo, Wish::Undo),
        ("Redo", ctrl_shift(Key::Z), can.redo, Wish::Redo),
        (
            "Zoom back",
            alt(Key::ArrowLeft),
            can.zoom_back,
            Wish::ZoomBack,
        ),
        (
            "Zoom forward",
            alt(Key::ArrowRight),
            can.zoom_forward,
            Wish::ZoomForward,
        ),
        (
            "Show all of the time",
            alone(Key::Home),
            true,
            Wish::FitView,
        ),
        (
            "Play through time, or stop",
            alone(Key::Space),
            true,
            Wish::TogglePlay,
        ),
        (
            "Put cursor A at the sample shown",
            alone(Key::A),
            true,
            Wish::PutCursor(0),
        ),
        (
            "Put cursor B at the sample shown",
            alone(Key::B),
            true,
            Wish::PutCursor(1),
        ),
        (
            "Copy the window as a picture",
            ctrl_shift(Key::C),
            true,
            Wish::PictureOfAll(PictureTo::Clipboard),
        ),
        (
            "Save the window as a picture…",
            None,
            true,
            Wish::PictureOfAll(PictureTo::File),
        ),
    ]
    .into_iter()
    .map(|(name, keys, enabled, wish)| action(name, keys, enabled, Command::Wish(wish)))
    .collect()
}

/// What all recordings are for, and taring them.
pub fn roles(state: &AppState) -> Vec<Action> {
    let entries = 0..state.recordings.entries().len();
    let tare = action(
        "Tare all over their first quiet half second",
        None,
        !entries.is_empty(),
        Command::Tare(entries.collect(), Tare::Auto),
    );
    [
        ("All train", Role::Train),
        ("All test", Role::Test),
        ("All off", Role::Off),
    ]
    .into_iter()
    .map(|(name, role)| always(name, None, Command::SetAllRoles(role)))
    .chain([tare])
    .collect()
}

/// Arrangements of panes.
pub fn arrangements() -> Vec<Action> {
    let keys = [Key::F5, Key::F6, Key::F7].map(alone);
    (Preset::ALL.into_iter().zip(keys))
        .map(|(preset, keys)| always(preset.title(), keys, Command::Wish(Wish::Arrange(preset))))
        .collect()
}

/// Panes by number.
pub fn panes() -> Vec<Action> {
    const DIGITS: [Key; 9] = [
        Key::Num1,
        Key::Num2,
        Key::Num3,
        Key::Num4,
        Key::Num5,
        Key::Num6,
        Key::Num7,
        Key::Num8,
        Key::Num9,
    ];
    (Pane::ALL.into_iter().zip(DIGITS))
        .map(|(pane, key)| {
            let name = format!("Show {}", pane.title());
            let command = Command::Wish(Wish::ShowPane(pane));
            Action {
                name,
                keys: ctrl(key),
                enabled: true,
                command,
            }
        })
        .collect()
}

/// How large everything is.
pub fn text_scales() -> Vec<Action> {
    [
        ("Larger", ctrl(Key::Plus), 1),
        ("Smaller", ctrl(Key::Minus), -1),
        ("Usual size", ctrl(Key::Num0), 0),
    ]
    .into_iter()
    .map(|(name, keys, step)| always(name, keys, Command::Wish(Wish::TextScale(step))))
    .collect()
}

/// Help.
pub fn help() -> Vec<Action> {
    vec![
        always(
            "Keys and words",
            alone(Key::F1),
            Command::Wish(Wish::ToggleHelp),
        ),
        always(
            "Find an action…",
            ctrl(Key::P),
            Command::Wish(Wish::ShowPalette),
        ),
        always("Tour", None, Command::Wish(Wish::Tour(true))),
    ]
}

/// All of them.
pub fn all(state: &AppState, can: CanGo) -> Vec<Action> {
    let groups = [
        files(state),
        edit(can),
        roles(state),
        arrangements(),
        panes(),
        text_scales(),
        help(),
    ];
    groups.into_iter().flatten().collect()
}

/// Pushes what the keys that were pressed ask for. Keys alone are left to a text field that has the focus, and so are those
/// for undo and redo, which it has of its own.
pub fn listen(context: &egui::Context, state: &AppState, can: CanGo, out: &mut Vec<Command>) {
    let is_press = |event: &egui::Event| matches!(event, egui::Event::Key { pressed: true, .. });
    if !context.input(|input| input.events.iter().any(is_press)) {
        return;
    }
    let typing = context.text_edit_focused();
    // Space presses the button that has the focus.
    let focused = context.memory(|memory| memory.focused().is_some());
    for action in all(state, can) {
        let Some(keys) = action.keys else { continue };
        let own = keys.modifiers == Modifiers::NONE || keys.logical_key == Key::Z;
        let taken = (typing && own) || (focused && keys.logical_key == Key::Space);
        let is_function_key = matches!(keys.logical_key, Key::F1 | Key::F5 | Key::F6 | Key::F7);
        if taken && !is_function_key {
            continue;
        }
        if context.input_mut(|input| input.consume_shortcut(&keys)) && action.enabled {
            out.push(action.command);
        }
    }
}

fn always(name: &str, keys: Option<KeyboardShortcut>, command: Command) -> Action {
    action(name, keys, true, command)
}

fn action(name: &str, keys: Option<KeyboardShortcut>, enabled: bool, command: Command) -> Action {
    Action {
        name: name.to_owned(),
        keys,
        enabled,
        command,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_actions_have_the_same_name_or_keys() {
        let actions = all(&AppState::default(), CanGo::default());
        for (at, one) in actions.iter().enumerate() {
            for other in &actions[at + 1..] {
                assert_ne!(one.name, other.name);
                assert!(one.keys.is_none() || one.keys != other.keys, "{}", one.name);
            }
        }
    }
}
