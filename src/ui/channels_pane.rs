//! Pane of the channels of one recording: a channel over time or over any other channel, its noise, drift and spectrum, and
//! the menus that give channels their roles. No calibration is needed.

use egui::Ui;

use crate::{
    engine::{Action, Asker, Engine, ImportCommand},
    import::{ChannelRole, ColumnChange, map::ColumnRole},
    questions::{View as Shown, channels::query::ChannelQuestion},
    recording::{
        Axis, Channel, Recording, units::force_in_newtons, units::moment_in_newton_metres,
    },
    report::figure::STANDS_ALONE,
    ui::{
        choice::{labelled_choice, named_choice},
        command::{Out, Pane},
        controls::{Controls as _, named, named_selected},
        numbers::elided,
        pane::{Cx, PaneView},
        plots::{self, Zoom},
        table,
    },
};

/// Width of the list of channels (points).
const LIST_WIDTH: f32 = 190.0;
/// Width of the table of figures (points).
const TABLE_WIDTH: f32 = 250.0;
/// Minimum width of the pane (points) for the table beside the plot.
const WIDTH_FOR_TABLE: f32 = 640.0;
/// Minimum height of the pane (points) for the spectrum under the plot.
const HEIGHT_FOR_SPECTRUM: f32 = 330.0;
/// Share of the height for the spectrum.
const SPECTRUM_SHARE: f32 = 0.36;
/// Maximum number of characters of a channel's name.
const CHANNEL_LENGTH: usize = 18;
/// Maximum number of characters of the chosen recording's name.
const NAME_LENGTH: usize = 26;
/// Maximum number of characters of the other recordings' names in the list.
const LIST_NAME_LENGTH: usize = 60;

/// Units of a force that can be chosen for a column without a unit.
const FORCES: [&str; 6] = ["N", "kN", "kgf", "gf", "lbf", "ozf"];
/// Units of a moment that can be chosen for a column without a unit.
const MOMENTS: [&str; 5] = ["N·m", "N·mm", "kgf·m", "lbf·in", "lbf·ft"];

#[derive(Debug)]
pub struct View {
    asker: Asker,
    across: Option<Channel>,
    up: Option<Channel>,
    /// True if the horizontal channel is at first another channel than the time.
    begins_with_loop: bool,
    /// True from the first role that the user gives to a channel until the user wants to see the error.
    pub gives_roles: bool,
    zoom: Zoom,
    spectrum_zoom: Zoom,
    pixels: [f64; 2],
}

impl Default for View {
    fn default() -> Self {
        Self::asking_as(Pane::CHANNELS.key, false)
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        let Some(at) = index_shown(cx.engine) else {
            ui.weak("No recordings. Choose File > Open, or drop files on the window");
            return;
        };
        let recording = &*cx.engine.entries()[at].recording;
        let (across, up) = self.chosen(recording);
        ui.horizontal_wrapped(|ui| {
            view_choice(ui, cx.engine, cx.out);
            if let Some(path) = recording.source().path() {
                let about = "Shows all columns of the file on one page, where several columns get their roles together";
                if ui.press("All columns…", about) {
                    cx.out.send(ImportCommand::Open(path.to_owned()));
                }
            }
            match cx.engine.project().missing() {
                Some(missing) => {
                    ui.strong(missing.to_string());
                }
                None if self.gives_roles => {
                    let layout = cx.engine.project().recordings.layout();
                    let n_gauges = layout.gauge_names.len();
                    let axes = Axis::symbols(&layout.axes).join(" ");
                    ui.strong(format!("Gauges: {n_gauges}. Reference: {axes}"));
                    let about = "Shows the load and its error in place of the channels";
                    self.gives_roles = !ui.press("Show the error", about);
                }
                None => {}
            }
        });
        ui.separator();
        let (mut chosen_across, mut chosen_up) = (across, up);
        ui.horizontal_top(|ui| {
            ui.vertical(|ui| {
                ui.set_width(LIST_WIDTH);
                across_choice(ui, recording, &mut chosen_across);
                ui.separator();
                list(ui, (cx.engine, at), &mut chosen_up, cx.out);
            });
            ui.separator();
            self.plots(ui, cx);
        });
        if (chosen_across, chosen_up) != (across, up) {
            (self.zoom, self.spectrum_zoom) = (None, None);
        }
        (self.across, self.up) = (Some(chosen_across), Some(chosen_up));
        cx.ask_as(
            self.asker,
            ChannelQuestion {
                recordings: cx.engine.project().recordings.clone(),
                at,
                across: chosen_across,
                up: chosen_up,
                frame: self.zoom,
                pixels: self.pixels,
            },
        );
    }
}

impl View {
    /// Returns a view whose requests do not replace those of other views.
    pub fn asking_as(asker: Asker, begins_with_loop: bool) -> Self {
        Self {
            asker,
            across: None,
            up: None,
            begins_with_loop,
            gives_roles: false,
            zoom: None,
            spectrum_zoom: None,
            pixels: STANDS_ALONE.into(),
        }
    }

    /// Returns the chosen channels. A channel that the recording does not have is replaced by one that it has.
    fn chosen(&self, recording: &Recording) -> (Channel, Channel) {
        let there = |channel: &Channel| channel.is_in(recording);
        let all: Vec<Channel> = Channel::all(recording).skip(1).collect();
        let load = all.iter().find(|channel| matches!(channel, Channel::Load(_)));
        let across = match self.begins_with_loop {
            // The load is on the horizontal axis, as in every loop.
            true if all.len() > 1 => load.or(all.last()).copied(),
            _ => None,
        };
        let across = self.across.filter(there).or(across).unwrap_or(Channel::Time);
        let others = all.iter().find(|channel| **channel != across);
        let up = self.up.filter(there).or(others.copied()).unwrap_or(Channel::Time);
        (across, up)
    }

    fn plots(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        let room = ui.available_size();
        let has_table = room.x + LIST_WIDTH > WIDTH_FOR_TABLE;
        let width = (room.x - if has_table { TABLE_WIDTH + 16.0 } else { 0.0 }).max(120.0);
        let lane = cx.engine.lane_of::<ChannelQuestion>(self.asker);
        ui.vertical(|ui| {
            ui.set_width(width);
            if let Some(problem) = lane.problem() {
                ui.weak(problem);
            }
            let Some(plot) = lane.answer() else {
                ui.awaited("The plot", cx.engine);
                return;
            };
            let has_spectrum = plot.has_spectrum() && room.y > HEIGHT_FOR_SPECTRUM;
            let below = if has_spectrum { SPECTRUM_SHARE * room.y } else { 0.0 };
            let height = (room.y - below - 30.0).max(80.0);
            let on_screen = ui.pixels_per_point() * egui::vec2(width, height);
            self.pixels = [on_screen.x.into(), on_screen.y.into()];
            let zoom = &mut self.zoom;
            let frame = *zoom;
            let figure = |inks: &_| plot.figure(inks, frame);
            plots::plot(ui, ("channel", None), height, figure, zoom, cx.out);
            if has_spectrum {
                let figure = |inks: &_| plot.spectrum_figure(inks).unwrap_or_default();
                let zoom = &mut self.spectrum_zoom;
                plots::plot(ui, ("spectrum", None), below - 24.0, figure, zoom, cx.out);
            }
        });
        if has_table {
            ui.vertical(|ui| {
                ui.set_width(TABLE_WIDTH);
                if let Some(plot) = lane.answer() {
                    ui.scrolled(|ui| table::show(ui, &plot.table()));
                }
            });
        }
    }
}

/// Returns the index of the recording on screen, or of the first if all are on screen.
fn index_shown(engine: &Engine) -> Option<usize> {
    let n = engine.entries().len();
    let at = match engine.project().view {
        Shown::One(at) => at,
        Shown::All => 0,
    };
    (n > 0).then(|| at.min(n - 1))
}

fn across_choice(ui: &mut Ui, recording: &Recording, across: &mut Channel) {
    let described = |channel: Channel| (channel.label(recording), "");
    labelled_choice(ui, ("across", 110.0), across, Channel::all(recording), described)
        .on_hover_text(
            "Channel on the horizontal axis: the time for a trace, another channel for a loop",
        );
}

/// Draws a row for each channel: its name, which puts the channel on the vertical axis, and the menu of its role.
fn list(ui: &mut Ui, (engine, at): (&Engine, usize), up: &mut Channel, out: &mut Out) {
    let recording = &*engine.entries()[at].recording;
    egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        for channel in Channel::in_file_order(recording) {
            ui.horizontal(|ui| {
                role_menu(ui, recording, channel, out);
                let label = channel.label(recording);
                let name = elided(&label, CHANNEL_LENGTH);
                let name = ui.selectable_label(*up == channel, name);
                named_selected(&name, egui::Role::Button, *up == channel, &label);
                let hover = format!("{label}: press to plot this channel on the vertical axis");
                if name.on_hover_text(hover).clicked() {
                    *up = channel;
                }
            });
        }
    });
}

fn role_of(channel: Channel, recording: &Recording) -> &'static str {
    match channel {
        Channel::Time if recording.is_static() => "Rows",
        Channel::Time => "Time",
        Channel::Gauge(_) => "Gauge",
        Channel::Load(at) => recording.axes()[at].symbol(),
        Channel::Auxiliary(_) => "Aux",
        Channel::Other(_) => "–",
    }
}

/// Draws the button with the role of a channel, and the menu that changes it.
fn role_menu(ui: &mut Ui, recording: &Recording, channel: Channel, out: &mut Out) {
    let role = role_of(channel, recording);
    let name = channel.name(recording);
    let can_change = can_change(channel, recording);
    let button = egui::Button::new(role).min_size(egui::vec2(46.0, 0.0));
    let response = ui
        .add_enabled_ui(can_change, |ui| {
            egui::containers::menu::MenuButton::from_button(button)
                .ui(ui, |ui| roles(ui, recording, channel, out))
                .0
        })
        .inner;
    let label = format!("Role of {name}: {role}");
    named(&response, egui::Role::Button, &label);
    response.on_hover_text(
        "Role of this channel. Another role reads the file again; undo restores the present role",
    );
}

/// Returns true if the channel is a column of a file, so that it may have another role.
fn can_change(channel: Channel, recording: &Recording) -> bool {
    let is_row = channel == Channel::Time && recording.is_static();
    recording.source().path().is_some() && !is_row
}

/// Draws the menu that gives a channel another role.
fn roles(ui: &mut Ui, recording: &Recording, channel: Channel, out: &mut Out) {
    let mut chosen: Option<(ColumnRole, Option<String>)> = None;
    let mut plain = |ui: &mut Ui, role: ColumnRole, about: &str| {
        if ui.press(role.label(), about) {
            chosen = Some((role, None));
        }
    };
    plain(ui, ColumnRole::Gauge, "The calibration computes the load from the gauges");
    plain(ui, ColumnRole::Time, "Time of the samples");
    plain(ui, ColumnRole::Auxiliary, "Influences the gauges, such as a temperature");
    plain(ui, ColumnRole::Group, "Names the group, day or mounting of the samples");
    plain(ui, ColumnRole::Ignore, "The column is not used");
    ui.separator();
    ui.weak("Reference load");
    let unit = channel.unit(recording);
    for axis in Axis::ALL {
        let (is_known, units): (bool, &[&str]) = if axis.is_force() {
            (force_in_newtons(unit).is_some(), &FORCES)
        } else {
            (moment_in_newton_metres(unit).is_some(), &MOMENTS)
        };
        let role = ColumnRole::Load(axis);
        if is_known && !matches!(channel, Channel::Load(_)) {
            if ui.press(axis.symbol(), format!("Reference load in {unit}")) {
                chosen = Some((role, Some(unit.to_owned())));
            }
            continue;
        }
        ui.menu_button(axis.symbol(), |ui| {
            for unit in units {
                if ui.press(*unit, "Unit of the values in the file") {
                    chosen = Some((role, Some((*unit).to_owned())));
                }
            }
        });
    }
    if let Some((role, unit)) = chosen {
        out.send(Action::ChangeColumns(ColumnChange::Role(ChannelRole {
            channel,
            name: channel.name(recording).to_owned(),
            axes: recording.axes().to_vec(),
            role,
            unit,
        })));
        ui.close();
    }
}

pub fn view_choice(ui: &mut Ui, engine: &Engine, out: &mut Out) {
    let entries = engine.entries();
    let name = |view: Shown| match view {
        Shown::One(at) => entries.get(at).map_or("–", |entry| entry.recording.name()),
        Shown::All => "All, one after the other",
    };
    let button = egui::ComboBox::from_id_salt("recording").width(180.0).truncate();
    let views = std::iter::once(Shown::All).chain((0..entries.len()).map(Shown::One));
    let mut view = engine.project().view;
    let described = |view| {
        let is_chosen = view == engine.project().view;
        (elided(name(view), if is_chosen { NAME_LENGTH } else { LIST_NAME_LENGTH }), "")
    };
    named_choice(ui, (button, "Recording"), &mut view, views, described)
        .on_hover_text("Recording in the traces. All shows the recordings one after the other");
    if view != engine.project().view {
        out.send(Action::Show(view));
    }
}
