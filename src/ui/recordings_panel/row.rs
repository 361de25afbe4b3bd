//! The cells of one recording: role, name with its menu, and errors.

use egui::{Response, Ui};

use super::Typed;
use crate::{
    engine::{Action, Edit, Engine},
    questions,
    recording::{Axis, Entry, GroupPattern, Role, Tare},
    shown::printable,
    ui::{
        command::{Command, Out, Pane},
        context_menu::context_menu,
        controls::{Controls as _, named_selected},
        numbers::{elided, significant},
    },
};

/// Mean width of a letter (points).
const LETTER_WIDTH: f32 = 6.5;

/// Returns the group of a recording that the user set, or else the detected group.
pub fn group_of(engine: &Engine, at: usize) -> Option<&str> {
    let entry = engine.entries().get(at)?;
    let found = || engine.result_of(at)?.group.as_deref();
    entry.group.as_deref().or_else(found)
}

fn group_menu(ui: &mut Ui, engine: &Engine, at: usize, typed: &mut Typed, out: &mut Out) {
    let entries = engine.entries();
    let text = text_of(typed, at, || group_of(engine, at).unwrap_or_default().to_owned());
    let field = egui::TextEdit::singleline(text).hint_text("empty: group as detected");
    let field =
        ui.field("Group", field, "Recordings with the same load programme, day or mounting");
    let text = text.trim().to_owned();
    let entered = ui.entered(&field).then_some((!text.is_empty()).then_some(text));
    let cleared = ui.button("Group as detected").clicked().then_some(None);
    let mut chosen = cleared.or(entered).map(|group: Option<String>| {
        let mut groups: Vec<_> = entries.iter().map(|entry| entry.group.clone()).collect();
        groups[at] = group;
        groups
    });
    ui.separator();
    ui.label("Groups of all recordings");
    let by = |text: &'static str| {
        let pattern = text.parse::<GroupPattern>().ok();
        move |(_, entry): (usize, &Entry)| pattern.as_ref()?.group_of(&entry.recording)
    };
    let alone =
        |(at, entry): (usize, &Entry)| Some(format!("{} {}", at + 1, entry.recording.name()));
    type GroupOf<'a> = &'a dyn Fn((usize, &Entry)) -> Option<String>;
    let all: [(&str, GroupOf<'_>); 4] = [
        ("Groups as detected", &|_| None),
        ("One group for each file", &by("{file}")),
        ("One group for each folder", &by("{folder}")),
        ("One group for each recording", &alone),
    ];
    for (label, group) in all {
        if ui.button(label).clicked() {
            chosen = Some(entries.iter().enumerate().map(group).collect());
        }
    }
    if let Some(groups) = chosen {
        out.send(Edit::Groups(groups));
        *typed = None;
        ui.close();
    }
}

/// Returns the text that the user types into a field about a recording. Before the user types, the text is `first`.
fn text_of(typed: &mut Typed, at: usize, first: impl FnOnce() -> String) -> &mut String {
    if typed.as_ref().is_none_or(|(of, _)| *of != at) {
        *typed = Some((at, first()));
    }
    &mut typed.get_or_insert_default().1
}

/// Draws the role of these recordings, and the menu that changes the role of all of them.
pub fn role_menu(ui: &mut Ui, at: &[usize], entries: &[&Entry], out: &mut Out) {
    let roles = [
        ("Train", Role::Train, "Used by the fit"),
        ("Test", Role::Test, "Used only to score the fit"),
        ("Off", Role::Off, "Used neither by the fit nor for scores"),
    ];
    if let Some(missing) = entries.iter().find_map(|entry| entry.recording.missing()) {
        ui.weak("–").on_hover_text(format!(
            "Neither fitted nor scored: {missing} The roles of the channels are in the pane Channels"
        ));
        return;
    }
    let has = |role: Role| entries.iter().all(|entry| entry.role == role);
    let label = roles.iter().find(|(_, role, _)| has(*role)).map_or("Mixed", |role| role.0);
    ui.menu_button(label, |ui| {
        for (label, role, explanation) in roles {
            if ui.radio(has(role), label).on_hover_text(explanation).clicked() {
                out.send(Edit::Roles(at.to_vec(), role));
                ui.close();
            }
        }
    })
    .response
    .on_hover_text("Role: train, test or off");
}

/// Draws the name of a recording, which describes the recording under the pointer.
pub fn shown_name(ui: &mut Ui, engine: &Engine, at: usize) -> Response {
    let recording = &engine.entries()[at].recording;
    let room = ui.available_width() - 2.0 * ui.spacing().button_padding.x;
    let name = elided(recording.name(), (room / LETTER_WIDTH) as usize);
    let is_shown = engine.project().view == questions::View::One(at);
    let button = egui::Button::selectable(is_shown, name).truncate();
    let response = ui.add(button);
    named_selected(&response, egui::Role::Button, is_shown, recording.name());
    response.on_hover_ui(|ui| {
        ui.strong(recording.name());
        if let Some(path) = recording.source().path() {
            ui.label(path.display().to_string());
        }
        if let Some(group) = group_of(engine, at) {
            ui.label(format!("group: {group}"));
        }
        if let Some(tare) = recording.tare() {
            ui.label(format!("tared over {tare}"));
        }
        if let Some(left_out) = recording.left_out() {
            let (n, of) = (left_out.n_samples, printable(&left_out.of));
            ui.label(format!("{n} of {of} samples left out as faulty"));
        }
        if let Some(faults) = engine.faults_of(at) {
            for words in &faults.words {
                ui.warn(words);
            }
        }
        let reference = Axis::symbols(recording.axes());
        ui.label(format!(
            "{} samples over {} s, {} gauges, reference: {}",
            recording.n_samples(),
            significant(recording.duration_secs(), 4),
            recording.n_gauges(),
            if reference.is_empty() { "none".to_owned() } else { reference.join(" ") },
        ));
    })
}

/// Opens the menu of a recording by the right mouse button or Shift+F10.
pub fn name_menu(
    response: &Response,
    engine: &Engine,
    at: usize,
    typed: &mut Typed,
    out: &mut Out,
) {
    let recording = &engine.entries()[at].recording;
    context_menu(response, |ui| {
        let first = tare_menu(ui, at, recording.name(), out);
        let about = "Shows the channels of this recording with their roles, noise and drift";
        if ui.press("Show its channels", about) {
            out.send(Action::Show(questions::View::One(at)));
            out.send(Command::ShowPane(Pane::CHANNELS));
            ui.close();
        }
        if ui.press("Close this recording", "Removes the recording from the list; its file stays") {
            out.send(Edit::Remove(vec![at]));
            ui.close();
        }
        ui.separator();
        group_menu(ui, engine, at, typed, out);
        first
    });
}

fn tare_menu(ui: &mut Ui, at: usize, name: &str, out: &mut Out) -> egui::Response {
    ui.strong(format!("Tare {name}"));
    let quiet = ui.button("Tare over the first quiet half second").on_hover_text(
        "Subtracts the mean gauge values of the first quiet half second without load",
    );
    let tare = |tare| Action::Tare(vec![at], tare).into();
    let mut chosen: Option<Command> = quiet.clicked().then(|| tare(Tare::Auto));
    let about = "Subtracts the mean gauge values between cursor A and cursor B";
    if ui.press("Tare over the interval between the cursors", about) {
        chosen = Some(Command::TareBetweenCursors(at));
    }
    if let Some(chosen) = chosen {
        out.send(chosen);
        ui.close();
    }
    quiet
}
