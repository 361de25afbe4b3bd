//! The recordings as rows, by group. One or more rows are selected; keys set their role or close them.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use egui::{Button, Key, Modifiers, Rect, ScrollArea, Ui, Vec2};

use super::View;
use super::row::{group_of, name_menu, role_menu, shown_name};
use crate::{
    engine::{Action, Edit, Engine},
    questions,
    recording::{Axis, Role},
    scoring::metrics::Group,
    shown::counted,
    ui::{
        command::Out,
        controls::{Controls as _, cells, place, place_right},
        numbers::significant,
        palette::Trace,
    },
};

const ROW_HEIGHT: f32 = 24.0;
const ROLE_WIDTH: f32 = 64.0;
const ERROR_WIDTH: f32 = 54.0;
const MARK_WIDTH: f32 = 18.0;
/// Width of the list (points) below which the errors are omitted.
const MIN_WIDTH_FOR_ERRORS: f32 = 260.0;
/// Number of recordings up to which all groups are open at first.
const FEW: usize = 12;
const KEYS: [(Key, Role); 3] = [(Key::T, Role::Train), (Key::E, Role::Test), (Key::O, Role::Off)];

#[derive(Debug, Default)]
pub struct List {
    filter: String,
    /// Groups that the user opened (`true`) or closed.
    open: BTreeMap<String, bool>,
    selected: BTreeSet<usize>,
    /// Row from which a press with Shift selects.
    from: usize,
}

enum Row<'a> {
    Group { name: &'a str, members: Vec<usize>, is_open: bool },
    One { at: usize, is_in_group: bool },
}

impl List {
    /// Returns the rows whose names contain the filter's text. Groups with one recording each are not drawn as groups.
    fn rows<'a>(&self, engine: &'a Engine) -> Vec<Row<'a>> {
        let entries = engine.entries();
        let filter = self.filter.trim().to_lowercase();
        let mut groups: Vec<(Option<&str>, Vec<usize>)> = Vec::new();
        let mut places = HashMap::new();
        for (at, entry) in entries.iter().enumerate() {
            let group = group_of(engine, at);
            let has_text = |text: &str| text.to_lowercase().contains(&filter);
            let is_shown = filter.is_empty()
                || has_text(&format!("{} {}", group.unwrap_or_default(), entry.recording.name()));
            if !is_shown {
                continue;
            }
            let next = groups.len();
            let place = group.map_or(next, |group| *places.entry(group).or_insert(next));
            if place == next {
                groups.push((group, Vec::new()));
            }
            groups[place].1.push(at);
        }
        let mut rows = Vec::new();
        for (name, members) in groups {
            let name = name.filter(|_| members.len() > 1);
            let is_in_group = name.is_some();
            let alone = members.iter().map(|at| Row::One { at: *at, is_in_group });
            match name {
                Some(name) => {
                    let usual = entries.len() <= FEW || !filter.is_empty();
                    let is_open = self.open.get(name).copied().unwrap_or(usual);
                    let inside: Vec<Row<'_>> = alone.filter(|_| is_open).collect();
                    rows.push(Row::Group { name, members, is_open });
                    rows.extend(inside);
                }
                None => rows.extend(alone),
            }
        }
        rows
    }

    /// Selects a row: alone, with Shift all rows up to it, with Ctrl in addition to the others.
    fn select(&mut self, at: usize, held: Modifiers, rows: &[Row<'_>]) {
        if held.command {
            if !self.selected.remove(&at) {
                self.selected.insert(at);
            }
        } else {
            let place = |wanted: usize| {
                rows.iter().position(|row| matches!(row, Row::One { at, .. } if *at == wanted))
            };
            let ends = place(at).zip(place(self.from)).filter(|_| held.shift);
            let (a, b) = ends.unwrap_or_default();
            let between = rows.iter().take(a.max(b) + 1).skip(a.min(b));
            let between = between.filter_map(|row| match row {
                Row::One { at, .. } if ends.is_some() => Some(*at),
                _ => None,
            });
            self.selected = between.chain([at]).collect();
        }
        if !held.shift {
            self.from = at;
        }
    }
}

/// What all rows need: the axes whose errors they show.
struct Shown<'a> {
    engine: &'a Engine,
    axes: &'a [Axis],
    of: Group,
}

/// Returns the places of the name, the role and both errors in a row.
fn places(row: Rect) -> [Rect; 4] {
    let error = if row.width() > MIN_WIDTH_FOR_ERRORS { ERROR_WIDTH } else { 0.0 };
    cells(row, 4.0, [f32::INFINITY, ROLE_WIDTH, error, error])
}

pub fn list(ui: &mut Ui, engine: &Engine, fields: &mut View, out: &mut Out) {
    let axes = engine.project().axes();
    let of = if axes.iter().any(|axis| axis.is_force()) { Group::Force } else { Group::Moment };
    let shown = Shown { engine, axes, of };
    let list = &mut fields.list;
    list.selected.retain(|at| *at < engine.entries().len());
    ui.horizontal(|ui| {
        let width = (ui.available_width() - 250.0).max(60.0);
        let filter = egui::TextEdit::singleline(&mut list.filter).desired_width(width);
        ui.field("Filter", filter, "Shows the recordings whose name or group contains this text");
        let keys = "A press shows a recording; with Ctrl or Shift it selects further ones. Keys: T train, E test, O off, Delete closes them. A right click or Shift+F10 opens a menu";
        let words = match list.selected.len() {
            0 | 1 => counted(engine.entries().len(), "recording"),
            n => format!("{n} selected"),
        };
        ui.weak(words).on_hover_text(keys);
    });
    header(ui, &shown);
    let rows = list.rows(engine);
    let area = ScrollArea::vertical().auto_shrink([false, false]);
    let mut focused = None;
    area.show_rows(ui, ROW_HEIGHT, rows.len(), |ui, visible| {
        for row in rows.iter().take(visible.end).skip(visible.start) {
            let (_, rect) = ui.allocate_space(Vec2::new(ui.available_width(), ROW_HEIGHT));
            let places @ [name_place, role_place, ..] = places(rect);
            match row {
                Row::Group { name, members, is_open } => {
                    group_row(ui, &shown, list, (name, members, *is_open), places, out);
                }
                Row::One { at, is_in_group } => {
                    let indent = if *is_in_group { MARK_WIDTH } else { 0.0 };
                    let name_place = name_place.with_min_x(name_place.left() + indent);
                    if list.selected.contains(at) {
                        let color = ui.visuals().selection.bg_fill;
                        ui.painter().rect_filled(rect, 2.0, color.gamma_multiply(0.5));
                    }
                    let response = place(ui, name_place, |ui| shown_name(ui, engine, *at));
                    if response.has_focus() {
                        focused = Some(response.id);
                    }
                    if response.clicked() {
                        response.request_focus();
                        let held = ui.input(|input| input.modifiers);
                        list.select(*at, held, &rows);
                        if !held.command && !held.shift {
                            out.send(Action::Show(questions::View::One(*at)));
                        }
                    }
                    name_menu(&response, engine, *at, &mut fields.group, out);
                    let entry = &engine.entries()[*at];
                    place(ui, role_place, |ui| role_menu(ui, &[*at], &[entry], out));
                    errors(ui, &shown, places, &[*at]);
                }
            }
        }
    });
    ui.data_mut(|data| data.insert_temp(focused_id(), focused));
    if focused.is_some() {
        keys(ui, list, out);
    }
}

fn group_row(
    ui: &mut Ui,
    shown: &Shown<'_>,
    list: &mut List,
    (name, members, is_open): (&str, &[usize], bool),
    places: [Rect; 4],
    out: &mut Out,
) {
    let mark = if is_open { "▾" } else { "▸" };
    let press = place(ui, places[0], |ui| {
        let text = format!("{mark} {name} ({})", members.len());
        ui.add(Button::new(text).frame(false).truncate())
    });
    let about = "Opens or closes this group. Cross-validation leaves out all recordings of a group together";
    if press.on_hover_text(about).clicked() {
        list.open.insert(name.to_owned(), !is_open);
    }
    let entries = shown.engine.entries();
    let group: Vec<_> = members.iter().map(|at| &entries[*at]).collect();
    place(ui, places[1], |ui| role_menu(ui, members, &group, out));
    errors(ui, shown, places, members);
}

/// Draws the pooled errors of these recordings: those of the uncompensated and those of the compensated load.
fn errors(ui: &mut Ui, shown: &Shown<'_>, places: [Rect; 4], members: &[usize]) {
    for (output, rect) in places[2..].iter().enumerate().filter(|(_, rect)| rect.is_positive()) {
        let results = members.iter().filter_map(|at| shown.engine.result_of(*at));
        let known = results.filter_map(|result| {
            let rmse = [&result.conventional_rmse, &result.compensated_rmse][output];
            let rmse = shown.of.rmse(shown.axes, rmse.as_deref()?)?;
            Some((result.n_samples as f64, rmse))
        });
        let (n, squares) =
            known.fold((0.0, 0.0), |(n, sum), (of, rmse)| (n + of, sum + of * rmse * rmse));
        place_right(ui, *rect, |ui| match n {
            0.0 => ui.weak("–"),
            n => ui.label(significant((squares / n).sqrt(), 3)),
        });
    }
}

fn header(ui: &mut Ui, shown: &Shown<'_>) {
    let (_, rect) = ui.allocate_space(Vec2::new(ui.available_width(), 18.0));
    let [name, role, errors @ ..] = places(rect);
    let unit = shown.axes.first().map_or("", |axis| axis.unit());
    let what = match shown.of {
        Group::Force => "forces",
        Group::Moment => "moments",
    };
    let head = match unit {
        "" => "Name".to_owned(), // there is no load
        unit => format!("Name; {what} [{unit}]"),
    };
    place(ui, name, |ui| ui.weak(head));
    place(ui, role, |ui| ui.weak("Role"));
    let traces = [(Trace::Conventional, "Uncomp."), (Trace::Compensated, "Comp.")];
    for ((trace, head), rect) in traces.into_iter().zip(errors) {
        if rect.is_positive() {
            let about = format!("{}: RMSE of the {what} [{unit}]", trace.explanation());
            place_right(ui, rect, |ui| ui.colored_label(trace.color(ui.visuals()), head))
                .on_hover_text(about);
        }
    }
}

/// Sets the role of the selected recordings, or closes them.
fn keys(ui: &Ui, list: &mut List, out: &mut Out) {
    if list.selected.is_empty() {
        return;
    }
    let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    let selected = || list.selected.iter().copied().collect();
    for (key, role) in KEYS {
        if pressed(key) {
            out.send(Edit::Roles(selected(), role));
        }
    }
    if pressed(Key::Delete) {
        out.send(Edit::Remove(selected()));
        list.selected.clear();
    }
}

/// Returns true if a row of the list has the keyboard focus. The list then takes letters.
pub fn has_focus(context: &egui::Context) -> bool {
    let last = context.data(|data| data.get_temp::<Option<egui::Id>>(focused_id())).flatten();
    last.is_some() && last == context.memory(|memory| memory.focused())
}

fn focused_id() -> egui::Id {
    egui::Id::unique("the recording that has the focus")
}
