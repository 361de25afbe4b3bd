//! Everything that can be asked for by name: one table for menus, keys, the palette and the sheet of keys.

use std::borrow::Cow;
use std::time::Duration;

use egui::{Key, KeyboardShortcut, Modifiers};

use crate::engine::{Action as Do, Edit, Engine, SEARCH_MINUTES};
use crate::export::{FileFormat, TRACE_FORMATS};
use crate::recording::{Role, Tare};
use crate::ui::command::{Command, ImageTo, Pane, PaneMove, TimeMove, Workspace};
use crate::ui::panes;
use crate::ui::plots;
use crate::ui::settings_panel;

/// Something to ask for.
pub struct Action {
    /// What it is called, everywhere.
    pub name: String,
    /// What it does, in a sentence.
    pub explanation: Cow<'static, str>,
    /// The keys that ask for it.
    pub keys: Option<KeyboardShortcut>,
    /// Whether it makes sense now.
    pub enabled: bool,
    /// What it asks.
    pub command: Command,
}

/// The keys of the palette, which takes what is typed after them.
pub const FIND: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::P);

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

const fn shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::SHIFT, key))
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

/// What opens and closes files.
pub fn opening(engine: &Engine) -> Vec<Action> {
    vec![
        action(
            "Open…",
            "Recordings, calibrations, sessions; several at once, or drop them on the window",
            ctrl(Key::O),
            Command::ChooseFiles,
        ),
        action(
            "Import…",
            "A recording whose columns have no names: say once what each one is",
            ctrl_shift(Key::O),
            Command::ChooseImport,
        ),
        action(
            "Follow a growing file…",
            "A log that is being written: its newest minute with Conv. and Comp., as thresholds move",
            None,
            Command::ChooseFollowed,
        ),
        action(
            "Built-in sensor (simulated)",
            "A resin six-axis sensor that nobody has, to try everything on",
            None,
            Do::OpenBuiltIn.into(),
        ),
        action(
            "Recover sessions…",
            "What windows that did not close as they should had not saved; listed until it is restored or discarded",
            None,
            Do::ShowLeft(true).into(),
        )
        .only_if(!engine.recoverable.is_empty()),
        action(
            "Close all recordings",
            "The files themselves stay as they are",
            None,
            Edit::CloseAll.into(),
        )
        .only_if(!engine.entries().is_empty()),
    ]
}

/// What writes files.
pub fn writing(engine: &Engine) -> Vec<Action> {
    let fitted = engine.analysis().is_some();
    vec![
        action(
            "Export calibration…",
            "The matrices as data, or as code that a robot runs; the ending says which",
            ctrl(Key::E),
            Command::ChooseExport,
        )
        .only_if(fitted),
        action(
            "Save report…",
            "One page of HTML with tables, loops and traces, to print or to send",
            None,
            Command::ChooseReport,
        )
        .only_if(fitted),
        action(
            "Save traces on screen…",
            format!(
                "Calculated, Conventional and Compensated over the interval on screen, as {}",
                FileFormat::listed(TRACE_FORMATS)
            ),
            None,
            Command::ChooseTraces,
        )
        .only_if(fitted),
        action(
            "Save session",
            "Which files, their roles, every setting, the notes and the panes",
            ctrl(Key::S),
            Command::SaveSession,
        ),
        action(
            "Save session as…",
            "The same, in another file",
            ctrl_shift(Key::S),
            Command::SaveSessionAs,
        ),
    ]
}

/// What leaves.
pub fn quit() -> Action {
    action("Quit", "Asks first where something is not saved", ctrl(Key::Q), Do::Close.into())
}

/// Going back and forward.
pub fn edit(can: CanGo) -> Vec<Action> {
    vec![
        action(
            "Undo",
            "Takes the last change of a setting, a role, a split, a tare, the notes, an applied calibration or the open recordings back",
            ctrl(Key::Z),
            Do::Undo.into(),
        )
        .only_if(can.undo),
        action("Redo", "Makes it again", ctrl_shift(Key::Z), Do::Redo.into()).only_if(can.redo),
    ]
}

/// What part of time is shown, and going through it.
pub fn time(can: CanGo) -> Vec<Action> {
    vec![
        action(
            "Show all of the time",
            "From the first sample on screen to the last",
            alone(Key::Home),
            Command::Time(TimeMove::Fit),
        ),
        action(
            "Zoom in",
            "Half of the time, about the sample shown",
            shift(Key::ArrowUp),
            Command::Time(TimeMove::Zoom(0.5)),
        ),
        action(
            "Zoom out",
            "Twice the time, about the sample shown",
            shift(Key::ArrowDown),
            Command::Time(TimeMove::Zoom(2.0)),
        ),
        action(
            "Earlier",
            "A quarter of what is on screen to the left",
            shift(Key::ArrowLeft),
            Command::Time(TimeMove::Move(-0.25)),
        ),
        action(
            "Later",
            "A quarter of what is on screen to the right",
            shift(Key::ArrowRight),
            Command::Time(TimeMove::Move(0.25)),
        ),
        action(
            "Zoom back",
            "To the part of time that was on screen before",
            alt(Key::ArrowLeft),
            Command::Time(TimeMove::Back),
        )
        .only_if(can.zoom_back),
        action(
            "Zoom forward",
            "To the part of time that was on screen after",
            alt(Key::ArrowRight),
            Command::Time(TimeMove::Forward),
        )
        .only_if(can.zoom_forward),
        action(
            "Play through time, or stop",
            "As if it were measured now, with the look-back drawn at each sample (Eq. 9-12)",
            alone(Key::Space),
            Command::Time(TimeMove::TogglePlay),
        ),
        action(
            "Step back",
            "One sample; where more are on screen than can be told apart, one pixel",
            alone(Key::Comma),
            Command::Time(TimeMove::Step(-1)),
        ),
        action(
            "Step forward",
            "One sample; where more are on screen than can be told apart, one pixel",
            alone(Key::Period),
            Command::Time(TimeMove::Step(1)),
        ),
        action(
            "Put cursor A at the sample shown",
            "The sample under the pointer, or where it plays",
            alone(Key::A),
            Command::Time(TimeMove::PutCursor(0)),
        ),
        action(
            "Put cursor B at the sample shown",
            "Between A and B the span's mean, deviation and range are shown",
            alone(Key::B),
            Command::Time(TimeMove::PutCursor(1)),
        ),
        action(
            "Show or hide the table of the cursors",
            "What lies at A, at B and between them",
            alone(Key::T),
            Command::Time(TimeMove::ToggleTable),
        ),
    ]
}

/// Images of the window; those of one plot are in its own menu.
pub fn pictures() -> Vec<Action> {
    vec![
        action(
            "Copy the window as an image",
            "To the clipboard; a plot's own menu (right click) copies that plot alone",
            ctrl_shift(Key::C),
            Command::ImageOfAll(ImageTo::Clipboard),
        ),
        action(
            "Save the window as an image…",
            "As PNG; a plot's own menu (right click) saves that plot alone",
            None,
            Command::ImageOfAll(ImageTo::File),
        ),
    ]
}

/// What all recordings are for, and taring them.
pub fn roles(engine: &Engine) -> Vec<Action> {
    let entries = 0..engine.entries().len();
    let any = !entries.is_empty();
    let all =
        |name, explanation, role| action(name, explanation, None, Edit::AllRoles(role).into());
    vec![
        all("All train", "The fit uses every recording", Role::Train),
        all("All test", "Every recording only scores the fit", Role::Test),
        all("All off", "No recording takes part", Role::Off),
        action(
            "Tare all over their first quiet half second",
            "Takes the mean of the gauges there as their zero",
            None,
            Do::Tare(entries.collect(), Tare::Auto).into(),
        )
        .only_if(any),
    ]
}

/// Files that were opened before, by their names.
pub fn recent(engine: &Engine) -> Vec<Action> {
    let files = engine.preferences.recent.iter();
    let open = files.map(|path| {
        let name = path.file_name().unwrap_or(path.as_os_str());
        let path_text = path.display().to_string();
        let command = Do::Open(vec![path.clone()]).into();
        action(name.to_string_lossy(), path_text, None, command)
    });
    open.collect()
}

/// The controls of settings.
fn settings(engine: &Engine) -> Vec<Action> {
    let all = settings_panel::in_use(engine).into_iter();
    all.map(|setting| {
        let name = format!("Set {}", setting.label);
        action(name, setting.help(), None, Command::FindSetting(setting))
    })
    .collect()
}

/// Trying models.
pub fn models(engine: &Engine) -> Vec<Action> {
    let any = !engine.entries().is_empty();
    let limit = Duration::from_secs_f64(60.0 * SEARCH_MINUTES);
    vec![
        action(
            "Find the best model",
            "Tries sensible models for two minutes and proposes one; they are listed in the pane Models",
            None,
            Do::FindBest(limit).into(),
        )
        .only_if(any && !engine.is_trying()),
        action(
            "Keep this model",
            "Puts the settings of now with their errors on the list in the pane Models",
            None,
            Do::KeepModel.into(),
        )
        .only_if(engine.can_keep()),
    ]
}

/// Workspaces, and what is done with the one on screen.
pub fn workspaces() -> Vec<Action> {
    let keys = [Key::F2, Key::F3, Key::F4, Key::F5, Key::F6, Key::F7, Key::F8].map(alone);
    let show = |((workspace, title, explanation), keys)| {
        let name = format!("Workspace {title}");
        action(name, explanation, keys, Command::Show(workspace))
    };
    let own = [
        action(
            "Maximise a pane, or show all panes",
            "The pane under the pointer fills the window; a double click on a tab does the same",
            alone(Key::F9),
            Command::ToggleMaximized(None),
        ),
        action(
            "Presenter mode, full screen",
            "No menus, and everything larger, for a projector; the same key ends it",
            alone(Key::F11),
            Command::TogglePresenter,
        ),
        action(
            "Reset this workspace",
            "Gives the panes of the workspace on screen their first places",
            None,
            Command::ResetWorkspace,
        ),
    ];
    Workspace::ALL.into_iter().zip(keys).map(show).chain(own).collect()
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
    let keys = DIGITS.into_iter().map(ctrl).chain(std::iter::repeat(None));
    let show = |(pane, keys): (Pane, _)| {
        let name = format!("Show {}", pane.title());
        action(name, pane.explanation(), keys, Command::ShowPane(pane))
    };
    panes::all().zip(keys).map(show).collect()
}

/// What can be done with the place of one pane.
pub fn places(pane: Pane) -> Vec<Action> {
    let title = pane.title();
    let moves = PaneMove::ALL.into_iter().map(|(to, place, explanation)| {
        let name = format!("{title}: {place}");
        action(name, explanation, None, Command::MovePane(pane, to))
    });
    let close = action(
        format!("{title}: close"),
        "The View menu brings it back",
        None,
        Command::ClosePane(pane),
    );
    moves.chain([close]).collect()
}

/// How large everything is.
pub fn text_scales() -> Vec<Action> {
    [
        ("Larger", "Text and everything with it", ctrl(Key::Plus), 1),
        ("Smaller", "Text and everything with it", ctrl(Key::Minus), -1),
        ("Usual size", "What the screen asks for", ctrl(Key::Num0), 0),
    ]
    .into_iter()
    .map(|(name, explanation, keys, step)| {
        action(name, explanation, keys, Command::TextScale(step))
    })
    .collect()
}

/// Help.
pub fn help(engine: &Engine) -> Vec<Action> {
    vec![
        action(
            "Help",
            "The guide, what can be pressed, what the abbreviations mean, and the paper's equations",
            alone(Key::F1),
            Command::ToggleHelp,
        ),
        action("Find an action…", "By a part of its name", Some(FIND), Command::ShowPalette),
        action(
            "Tour",
            "Six steps through the main job, on the built-in sensor",
            None,
            Command::Tour(true),
        )
        .only_if(engine.project().recordings.is_simulated()),
        action(
            "About LoopScope",
            "Its version, what it was built from, and the licences of it and of what is in it",
            None,
            Command::ShowAbout,
        ),
    ]
}

/// All of them.
pub fn all(engine: &Engine, can: CanGo) -> Vec<Action> {
    let mut recent = recent(engine);
    for file in &mut recent {
        file.name = format!("Open {}", file.name);
    }
    let groups = [
        opening(engine),
        recent,
        writing(engine),
        vec![quit()],
        edit(can),
        time(can),
        roles(engine),
        settings(engine),
        models(engine),
        workspaces(),
        panes(),
        panes::all().flat_map(places).collect(),
        text_scales(),
        pictures(),
        help(engine),
    ];
    groups.into_iter().flatten().collect()
}

/// Pushes what the keys that were pressed ask for. Keys alone are left to a text field that has the focus, and so are those
/// for undo and redo, which it has of its own.
pub fn listen(context: &egui::Context, engine: &Engine, can: CanGo, out: &mut Vec<Command>) {
    let is_press = |event: &egui::Event| matches!(event, egui::Event::Key { pressed: true, .. });
    if !context.input(|input| input.events.iter().any(is_press)) {
        return;
    }
    let typing = context.text_edit_focused();
    // Space presses the button that has the focus.
    let focused = context.memory(|memory| memory.focused());
    let focused = focused.and_then(|id| context.read_response(id));
    let focused =
        focused.is_some_and(|widget| widget.sense.senses_click()) && !plots::have_focus(context);
    // Plus stands on the key of the equals sign, and is meant without Shift too.
    let larger = context.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::Equals));
    out.extend(larger.then_some(Command::TextScale(1)));
    let mut actions = all(engine, can);
    // Ctrl+Z lets more keys be held, so that Ctrl+Shift+Z must be asked about before it.
    actions.sort_by_key(|action| {
        let held = action.keys.map(|keys| keys.modifiers);
        std::cmp::Reverse(held.is_some_and(|held| held.shift || held.alt))
    });
    for action in actions {
        let Some(keys) = action.keys else { continue };
        let own = [Modifiers::NONE, Modifiers::SHIFT].contains(&keys.modifiers)
            || keys.logical_key == Key::Z;
        let taken = (typing && own) || (focused && keys.logical_key == Key::Space);
        let is_function_key = (Key::F1..=Key::F12).contains(&keys.logical_key);
        if taken && !is_function_key {
            continue;
        }
        if context.input_mut(|input| input.consume_shortcut(&keys)) && action.enabled {
            out.push(action.command);
        }
    }
}

fn action(
    name: impl Into<String>,
    explanation: impl Into<Cow<'static, str>>,
    keys: Option<KeyboardShortcut>,
    command: Command,
) -> Action {
    Action { name: name.into(), explanation: explanation.into(), keys, enabled: true, command }
}

impl Action {
    fn only_if(mut self, makes_sense: bool) -> Self {
        self.enabled = makes_sense;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_actions_have_the_same_name_or_keys() {
        let actions = all(&Engine::new(std::sync::Arc::new(|| {})), CanGo::default());
        for (at, one) in actions.iter().enumerate() {
            for other in &actions[at + 1..] {
                assert_ne!(one.name, other.name);
                assert!(one.keys.is_none() || one.keys != other.keys, "{}", one.name);
            }
        }
    }

    #[test]
    fn keys_ask_for_their_own_action_and_for_nothing_else() {
        let can = CanGo { undo: true, redo: true, zoom_back: true, zoom_forward: true };
        let engine = Engine::new(std::sync::Arc::new(|| {}));
        for action in all(&engine, can).into_iter().filter(|action| action.enabled) {
            let Some(keys) = action.keys else { continue };
            let mut asked = Vec::new();
            let press = egui::Event::Key {
                key: keys.logical_key,
                physical_key: None,
                pressed: true,
                repeat: false,
                modifiers: keys.modifiers,
            };
            let input = egui::RawInput { events: vec![press], ..Default::default() };
            let context = egui::Context::default();
            let mut output = context.run_ui(input, |ui| listen(ui.ctx(), &engine, can, &mut asked));
            output.textures_delta.clear();
            let (asked, own) = (format!("{asked:?}"), format!("{:?}", [&action.command]));
            assert_eq!(asked, own, "{}", action.name);
        }
    }
}
