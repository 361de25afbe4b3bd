//! All actions that a user can find by name. Menus, shortcut keys, the command palette and the list of shortcuts use this
//! table.

use std::borrow::Cow;
use std::path::PathBuf;
use std::time::Duration;

use egui::{Key, KeyboardShortcut, Modifiers};

use crate::{
    engine::{Action as Do, Edit, Engine, Preferences, SEARCH_MINUTES, Theme},
    export::{FileFormat, TRACE_FORMATS},
    questions::{Candidates, thresholds::Along},
    recording::{Role, Tare, simulated::Late},
    shown::file_name,
    ui::{
        command::{Command, Out, Pane, PathFor, TimeMove, Workspace},
        panes, plots, recordings_panel,
        scope::AxisChoice,
        settings_panel,
    },
};

pub struct Action {
    pub name: String,
    pub explanation: Cow<'static, str>,
    pub keys: Option<KeyboardShortcut>,
    pub enabled: bool,
    pub command: Command,
}

pub const FIND: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::P);

/// Keys that a text field uses with Ctrl or Alt too: undo, and moves by words.
const FOR_TEXT: [Key; 5] = [Key::Z, Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown];

const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// Returns the shortcut of Ctrl (⌘ on a Mac) and this key.
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

#[derive(Clone, Copy, Debug, Default)]
pub struct CanGo {
    pub undo: bool,
    pub redo: bool,
}

pub fn opening(engine: &Engine) -> Vec<Action> {
    let built_in = [
        (
            "Built-in sensor (simulated)",
            "Opens simulated recordings of a six-axis sensor, to try the program without own data",
            None,
        ),
        (
            "Simulated sensor with time lag",
            "Opens simulated recordings of one force, whose two gauges are delayed by a low-pass of 30 ms",
            Some(Late::Lag),
        ),
        (
            "Simulated sensor with hysteresis",
            "Opens simulated recordings of one force, whose two gauges have a hysteresis (play) of 5 % of full scale",
            Some(Late::Hysteresis),
        ),
        (
            "Simulated sensor with time lag and hysteresis",
            "Opens simulated recordings of one force, whose two gauges have both",
            Some(Late::Both),
        ),
    ];
    let built_in =
        built_in.map(|(name, about, late)| action(name, about, None, Do::OpenBuiltIn(late)));
    let files = [
        action(
            "New",
            "Closes all recordings, and begins with default settings, for another sensor. Their files are kept",
            ctrl(Key::N),
            Do::New,
        ),
        action(
            "Open…",
            "Opens recordings, calibrations or sessions; files can also be dropped on the window",
            ctrl(Key::O),
            Command::Choose(PathFor::Open),
        ),
        action(
            "Open a typed path…",
            "Opens the file or folder at a path that you type",
            None,
            Command::TypePath(PathFor::Open),
        ),
        action(
            "Import…",
            "Opens a recording whose columns have no names, and asks for the role of each column",
            ctrl_shift(Key::O),
            Command::Choose(PathFor::Import),
        ),
        action(
            "Follow a growing file…",
            "Shows the newest minute of a log file that is still being written, with the loads computed from its gauges",
            None,
            Command::Choose(PathFor::Follow),
        ),
    ];
    let recover = action(
        "Recover sessions…",
        "Lists unsaved sessions of windows that did not close properly, to restore or discard them",
        None,
        Do::ShowLeft(true),
    );
    let recover = recover.only_if(!engine.recoverable.is_empty());
    files.into_iter().chain(built_in).chain([recover]).collect()
}

pub fn writing(engine: &Engine) -> Vec<Action> {
    let traces = format!(
        "Writes the visible traces of the reference, uncompensated and compensated loads to a file: {}",
        FileFormat::listed(TRACE_FORMATS)
    );
    let results = [
        action(
            "Export calibration…",
            "Writes the calibration to a file, as data or as code for a robot; the ending of its name chooses the format",
            ctrl(Key::E),
            Command::ChooseExport,
        ),
        action(
            "Save report…",
            "Writes the results to one HTML page with tables, loops and traces, to print or to send",
            None,
            Command::ChooseReport,
        ),
        action("Save traces on screen…", traces, None, Command::ChooseTraces),
    ];
    let session = [
        action(
            "Save session",
            "Saves the list of recordings, their roles, all settings and the notes",
            ctrl(Key::S),
            Command::SaveSession,
        ),
        action(
            "Save session as…",
            "Saves recordings, settings and notes to another session file",
            ctrl_shift(Key::S),
            Command::SaveSessionAs,
        ),
    ];
    let fitted = engine.analysis().is_some();
    results.map(|action| action.only_if(fitted)).into_iter().chain(session).collect()
}

pub fn quit() -> Action {
    action(
        "Quit",
        "Ends the program; asks first if something is not saved",
        ctrl(Key::Q),
        Do::Close,
    )
}

pub fn edit(can: CanGo) -> Vec<Action> {
    vec![
        action(
            "Undo",
            "Undoes the last change of a setting, role, split, tare, note, applied calibration or list of recordings",
            ctrl(Key::Z),
            Do::Undo,
        )
        .only_if(can.undo),
        action("Redo", "Repeats the change that was undone last", ctrl_shift(Key::Z), Do::Redo)
            .only_if(can.redo),
    ]
}

/// Returns the actions that change the visible interval of time, or play through it.
fn time() -> Vec<Action> {
    let all = [
        (
            "Show the whole time axis",
            "Shows the traces from the first to the last sample",
            alone(Key::Home),
            TimeMove::Fit,
        ),
        (
            "Zoom in",
            "Halves the visible interval of time, around the current sample",
            shift(Key::ArrowUp),
            TimeMove::Zoom(0.5),
        ),
        (
            "Zoom out",
            "Doubles the visible interval of time, around the current sample",
            shift(Key::ArrowDown),
            TimeMove::Zoom(2.0),
        ),
        (
            "Earlier",
            "Moves the visible interval to earlier times, by a quarter of its length",
            shift(Key::ArrowLeft),
            TimeMove::Move(-0.25),
        ),
        (
            "Later",
            "Moves the visible interval to later times, by a quarter of its length",
            shift(Key::ArrowRight),
            TimeMove::Move(0.25),
        ),
        (
            "Play through time, or stop",
            "Plays the recordings, and marks the earlier sample that the look-back uses at each time",
            alone(Key::Space),
            TimeMove::TogglePlay,
        ),
        (
            "Step back",
            "Goes one sample back, or one pixel if a pixel holds several samples",
            alone(Key::Comma),
            TimeMove::Step(-1),
        ),
        (
            "Step forward",
            "Goes one sample forward, or one pixel if a pixel holds several samples",
            alone(Key::Period),
            TimeMove::Step(1),
        ),
        (
            "Put cursor A at the current sample",
            "Puts cursor A at the sample under the pointer, or at the playing position",
            shift(Key::A),
            TimeMove::PutCursor(0),
        ),
        (
            "Put cursor B at the current sample",
            "Puts cursor B at the sample under the pointer, or at the playing position",
            shift(Key::B),
            TimeMove::PutCursor(1),
        ),
        (
            "Show or hide the table of the cursors",
            "Table of each trace at cursors A and B, with the range between them",
            alone(Key::T),
            TimeMove::ToggleTable,
        ),
        (
            "Compensation off and on",
            "Hides the compensated load and its error in the traces, or shows them again: before and after",
            alone(Key::B),
            TimeMove::ToggleCompensated,
        ),
    ];
    let action = |(name, about, keys, to)| action(name, about, keys, Command::Time(to));
    all.into_iter().map(action).collect()
}

/// Returns the actions that choose what is on screen: axes, recordings and drawers.
fn shown(engine: &Engine) -> Vec<Action> {
    let axes = engine.project().axes().iter().enumerate().flat_map(|(at, axis)| {
        let key = Key::from_name(&(at + 1).to_string());
        let only = action(
            format!("Show the axis {axis}"),
            "Shows the load and the error of this axis",
            key.and_then(alone),
            Command::Axes(AxisChoice::Only(at)),
        );
        let toggle = action(
            format!("Add or remove the axis {axis}"),
            "Shows the traces of this axis beside the others, or hides them",
            key.and_then(shift),
            Command::Axes(AxisChoice::Toggle(at)),
        );
        [only, toggle]
    });
    let steps = [
        ("force", Along::F, Key::ArrowRight, Key::ArrowLeft),
        ("time", Along::T, Key::ArrowUp, Key::ArrowDown),
    ];
    let steps = steps.into_iter().flat_map(|(name, along, up, down)| {
        let step = |words: &str, keys, by| {
            let about = "Moves the slider of this threshold by hundredths of its range: one, or ten with Shift";
            let name = format!("{words} {name} threshold");
            action(name, about, keys, Command::StepThreshold(along, by))
        };
        [
            step("Larger", ctrl(up), 1),
            step("Smaller", ctrl(down), -1),
            step("Much larger", ctrl_shift(up), 10),
            step("Much smaller", ctrl_shift(down), -10),
        ]
    });
    let others = [
        action(
            "Show all axes",
            "Shows the loads and the errors of all axes",
            alone(Key::Num0),
            Command::Axes(AxisChoice::All),
        ),
        action(
            "Previous recording",
            "Shows the traces of the previous recording",
            alone(Key::PageUp),
            Command::OtherRecording(-1),
        ),
        action(
            "Next recording",
            "Shows the traces of the next recording",
            alone(Key::PageDown),
            Command::OtherRecording(1),
        ),
        action(
            "Recordings",
            "Opens or closes the list of recordings with their roles",
            ctrl(Key::B),
            Command::ToggleDrawer(Pane::RECORDINGS),
        ),
        action(
            "Settings",
            "Opens or closes all settings of the fit",
            ctrl(Key::Comma),
            Command::ToggleDrawer(Pane::SETTINGS),
        ),
        action(
            "Right column",
            "Opens or closes the right column of a narrow window: errors, axes, models or matrices",
            ctrl(Key::D),
            Command::ToggleRight,
        ),
        action(
            "Apply the remedy",
            "Does what the button at the right end of the strip says",
            alone(Key::R),
            Command::Remedy,
        ),
    ];
    axes.chain(others).chain(steps).collect()
}

pub fn roles(engine: &Engine) -> Vec<Action> {
    let entries = 0..engine.entries().len();
    let any = !entries.is_empty();
    let roles = [
        ("Use all for training", "Uses all recordings for training (fitting)", Role::Train),
        ("Use all for testing", "Uses all recordings for testing the fit", Role::Test),
        (
            "Exclude all",
            "Excludes all recordings from the fit and from the computed errors",
            Role::Off,
        ),
    ];
    let roles = roles.map(|(name, about, role)| action(name, about, None, Edit::AllRoles(role)));
    let tare = action(
        "Tare each recording at its first quiet half second",
        "Subtracts the mean gauge values of the first half second that is unloaded and quiet",
        None,
        Do::Tare(entries.collect(), Tare::Auto),
    );
    roles.into_iter().chain([tare.only_if(any)]).collect()
}

pub fn recent(engine: &Engine) -> Vec<Action> {
    let files = engine.preferences.recent.iter();
    let open = |path: &PathBuf| {
        let about = path.display().to_string();
        action(file_name(path), about, None, Do::Open(vec![path.clone()]))
    };
    files.map(open).collect()
}

/// Returns one action for each setting, which shows the control of the setting.
fn settings(engine: &Engine) -> Vec<Action> {
    let all = settings_panel::in_use(engine).into_iter();
    all.map(|setting| {
        let name = format!("Set {}", setting.label);
        action(name, setting.help(), None, Command::FindSetting(setting))
    })
    .collect()
}

fn models(engine: &Engine) -> Vec<Action> {
    let any = !engine.entries().is_empty();
    let limit = Duration::from_secs_f64(60.0 * SEARCH_MINUTES);
    vec![
        action(
            "Find the best model",
            "Tries models and proposes the most accurate one; the pane Models lists all tried models",
            None,
            Do::FindBest(Candidates::All, limit),
        )
        .only_if(any && !engine.is_trying()),
        action(
            "Keep this model",
            "Adds the present settings with their errors to the list in the pane Models",
            None,
            Do::KeepModel,
        )
        .only_if(engine.can_keep()),
    ]
}

pub fn workspaces() -> Vec<Action> {
    let keys = (2..).map(|n: u8| Key::from_name(&format!("F{n}")).and_then(alone));
    let show = |((workspace, title, explanation), keys)| {
        let name = format!("Workspace {title}");
        action(name, explanation, keys, Command::Show(workspace))
    };
    let of_window = [
        action(
            "Maximise a pane, or show all panes",
            "The pane under the pointer fills the window; a double click on its title does the same",
            alone(Key::F9),
            Command::ToggleMaximized(None),
        ),
        action(
            "Presenter mode, full screen",
            "Shows the result in large letters, for a projector; F11 or Escape ends it",
            alone(Key::F11),
            Command::TogglePresenter,
        ),
        action(
            "Loops or map in presenter mode",
            "Shows the loops in place of the map of the thresholds, or the map again",
            alone(Key::L),
            Command::TogglePresentedLoops,
        ),
    ];
    Workspace::ALL.into_iter().zip(keys).map(show).chain(of_window).collect()
}

/// Returns one action for each pane, which shows the pane.
fn panes() -> Vec<Action> {
    let show = |pane: Pane| {
        let about = "Shows this pane in its workspace, as a drawer, or alone";
        action(format!("Show {}", pane.title), about, None, Command::ShowPane(pane))
    };
    panes::all().map(show).collect()
}

const THEMES: [(&str, Theme, &str); 3] = [
    ("Dark", Theme::Dark, "Light text on a dark background"),
    ("Light", Theme::Light, "Dark text on a light background, as in printed figures"),
    ("Follow system", Theme::System, "Dark or light, as the settings of the desktop say"),
];

pub fn themes(engine: &Engine) -> Vec<Action> {
    let choose = |(name, theme, explanation): (&str, Theme, &'static str)| {
        let preferences = Preferences { theme, ..engine.preferences.clone() };
        let is_other = engine.preferences.theme != theme;
        action(format!("Theme: {name}"), explanation, None, Do::Prefer(preferences))
            .only_if(is_other)
    };
    THEMES.into_iter().map(choose).collect()
}

pub fn text_scales() -> Vec<Action> {
    [
        ("Larger", "Enlarges text and controls", ctrl(Key::Plus), 1),
        ("Smaller", "Shrinks text and controls", ctrl(Key::Minus), -1),
        ("Usual size", "Shows text and controls at their usual size again", ctrl(Key::Num0), 0),
    ]
    .into_iter()
    .map(|(name, explanation, keys, step)| {
        action(name, explanation, keys, Command::TextScale(step))
    })
    .collect()
}

pub fn help() -> Vec<Action> {
    vec![
        action(
            "Help",
            "Opens the guide and the list of shortcuts",
            alone(Key::F1),
            Command::ToggleHelp,
        ),
        action(
            "Find an action…",
            "Opens a field in which a part of an action's name is typed to find the action",
            Some(FIND),
            Command::ShowPalette,
        ),
        action(
            "First steps",
            "Shows the page of the guide that leads from recordings to an exported calibration",
            None,
            Command::ShowGuide(0),
        ),
        action(
            "About LoopScope",
            "Shows the version, the build and the licences of the program",
            None,
            Command::ShowAbout,
        ),
    ]
}

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
        time(),
        shown(engine),
        roles(engine),
        settings(engine),
        models(engine),
        workspaces(),
        panes(),
        themes(engine),
        text_scales(),
        help(),
    ];
    groups.into_iter().flatten().collect()
}

/// Sends the commands of the pressed keys. While a text field has the focus, the field gets undo, redo and all keys without
/// modifiers.
pub fn listen(context: &egui::Context, engine: &Engine, can: CanGo, out: &mut Out) {
    let is_press = |event: &egui::Event| matches!(event, egui::Event::Key { pressed: true, .. });
    if !context.input(|input| input.events.iter().any(is_press)) {
        return;
    }
    // The import page and the list of recordings take letters as roles of the selected rows.
    let typing = context.text_edit_focused() || engine.importing.is_some();
    let in_list = recordings_panel::has_focus(context);
    // The space bar is left to the button that has the focus, which it presses.
    let focused = context.memory(|memory| memory.focused());
    let focused = focused.and_then(|id| context.read_response(id));
    let focused =
        focused.is_some_and(|widget| widget.sense.senses_click()) && !plots::have_focus(context);
    // The plus sign is often on the key of the equals sign, so Ctrl with the equals sign counts as Ctrl with plus.
    let larger = context.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::Equals));
    if larger {
        out.send(Command::TextScale(1));
    }
    let mut actions = all(engine, can);
    // Shortcuts with Shift or Alt are tested first, because egui accepts Ctrl+Shift+Z as Ctrl+Z.
    actions.sort_by_key(|action| {
        let held = action.keys.map(|keys| keys.modifiers);
        std::cmp::Reverse(held.is_some_and(|held| held.shift || held.alt))
    });
    for action in actions {
        let Some(keys) = action.keys else { continue };
        let is_for_text = [Modifiers::NONE, Modifiers::SHIFT].contains(&keys.modifiers)
            || FOR_TEXT.contains(&keys.logical_key);
        let taken = (typing && is_for_text)
            || (in_list && keys.modifiers.is_none())
            || (focused && keys.logical_key == Key::Space);
        let is_function_key = (Key::F1..=Key::F12).contains(&keys.logical_key);
        if taken && !is_function_key {
            continue;
        }
        if context.input_mut(|input| input.consume_shortcut(&keys)) && action.enabled {
            out.send(action.command);
        }
    }
}

fn action(
    name: impl Into<String>,
    explanation: impl Into<Cow<'static, str>>,
    keys: Option<KeyboardShortcut>,
    command: impl Into<Command>,
) -> Action {
    let (name, explanation, command) = (name.into(), explanation.into(), command.into());
    Action { name, explanation, keys, enabled: true, command }
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
        let can = CanGo { undo: true, redo: true };
        let engine = Engine::new(std::sync::Arc::new(|| {}));
        for action in all(&engine, can).into_iter().filter(|action| action.enabled) {
            let Some(keys) = action.keys else { continue };
            let mut asked = Out::default();
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
            let (asked, expected) = (format!("{:?}", asked.0), format!("{:?}", [&action.command]));
            assert_eq!(asked, expected, "{}", action.name);
        }
    }
}
