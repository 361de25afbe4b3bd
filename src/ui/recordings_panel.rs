//! The recordings: what each is for, how long it is, how well it is calibrated.

use egui::Color32;

use egui_extras::{Column, TableBuilder};

use crate::engine::{Action, Edit, Engine, Project};
use crate::questions;
use crate::questions::RecordingResult;
use crate::questions::check::faulty::FindFaults;
use crate::recording::{Axis, Day, Entry, GaugeRange, GroupPattern, Role, Source, Tare};
use crate::report;
use crate::report::{Cell, Table};
use crate::scoring::metrics::Group;
use crate::shown::{and_more, printable};
use crate::ui::command::{Command, Kind, Pane};
use crate::ui::context_menu::context_menu;
use crate::ui::controls::Controls as _;
use crate::ui::numbers::{elided, significant};
use crate::ui::palette::Trace;
use crate::ui::pane::{Cx, PaneView};

/// In a narrower list samples and rates are left out.
const MIN_WIDTH_FOR_COUNTS: f32 = 460.0;

/// The pane.
pub const PANE: Pane = Pane(&Kind {
    key: "recordings",
    title: "Recordings",
    explanation: "What was measured, and what each recording is for",
});

/// What is typed.
#[derive(Debug)]
pub struct View {
    /// The path to open.
    open: String,
    /// The share of a split that trains (%).
    split_percent: f64,
    /// The recording whose group is being said, and what is typed.
    group: (usize, String),
    /// The recording whose date is being said, and what is typed.
    day: (usize, String),
}

impl Default for View {
    fn default() -> Self {
        Self {
            open: String::new(),
            split_percent: 60.0,
            group: (usize::MAX, String::new()),
            day: (usize::MAX, String::new()),
        }
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        cx.ask(FindFaults::of(&cx.engine.request(), cx.engine.project().valid_range()));
        recordings_panel(ui, cx.engine, self, cx.out);
    }
}

/// Draws the list of recordings with a field for opening more.
fn recordings_panel(ui: &mut egui::Ui, engine: &Engine, fields: &mut View, out: &mut Vec<Command>) {
    path_field(ui, fields, out);
    split_row(ui, engine, fields, out);
    if !engine.entries().is_empty() {
        faults_row(ui, engine, out);
    }
    if engine.project().recordings.is_simulated() {
        ui.warn("simulated").on_hover_text(
            "These come from the built-in simulated sensor, not from a real one: a resin six-axis sensor under \
             a weight of 1.128 kg on a robot arm that turns",
        );
    }
    if let Some(applied) = &engine.project().applied {
        ui.horizontal_wrapped(|ui| {
            ui.warn(format!("Applying {}", applied.path.display()));
            if ui.press(
                "Fit again",
                "Stop applying the opened calibration; fit to the recordings again",
            ) {
                out.push(Edit::Apply(None).into());
            }
        });
    }
    ui.separator();
    if engine.entries().is_empty() {
        ui.weak("Open files, drop them on the window, or choose File > Built-in sensor.");
        return;
    }
    table(ui, engine, fields, out);
}

fn path_field(ui: &mut egui::Ui, fields: &mut View, out: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let label = ui.label("Open");
        let buttons = 90.0;
        let field = egui::TextEdit::singleline(&mut fields.open)
            .hint_text("path of a recording or calibration")
            .desired_width((ui.available_width() - buttons).max(60.0));
        let response = ui.add(field).labelled_by(label.id).on_hover_text(
            "A recording, a calibration (.json or .cal), a session, or a folder of them; Enter loads it",
        );
        let entered =
            ui.entered(&response);
        let pressed = ui.press("Load", "Read what the path names");
        let path = fields.open.trim();
        if (entered || pressed) && !path.is_empty() {
            out.push(Action::Open(vec![path.into()]).into());
        }
        if ui.press("…", "Choose files") {
            out.push(Command::ChooseFiles);
        }
    });
}

fn split_row(ui: &mut egui::Ui, engine: &Engine, fields: &mut View, out: &mut Vec<Command>) {
    ui.horizontal_wrapped(|ui| {
        let field = egui::DragValue::new(&mut fields.split_percent)
            .range(1.0..=99.0)
            .max_decimals(1)
            .suffix(" %");
        ui.field("Train/test split: train on the first", field, "The share of each recording's time that trains");
        if ui.press(
            "Split",
            "Splits each recording in time: the first segment trains, the rest tests. History does not cross the split",
        ) {
            out.push(Edit::Split(fields.split_percent / 100.0).into());
        }
        if ui.press_small("Copy list", "Roles, names, samples and errors as tab-separated text") {
            ui.copy_text(as_table(engine).tab_separated());
        }
        if engine.project().split.is_some()
            && ui.press("Undo split", "Puts the recordings together again") {
                out.push(Edit::Unsplit.into());
            }
    });
}

/// What a gauge can show, how many samples look faulty, and the way to leave them out.
fn faults_row(ui: &mut egui::Ui, engine: &Engine, out: &mut Vec<Command>) {
    let project = engine.project();
    ui.horizontal_wrapped(|ui| {
        let mut entered = project.gauge_range.clone();
        let mut knows = entered.is_some();
        if ui.tick(
            &mut knows,
            "Gauge limits",
            "What the logger can write at least and at most, such as -32768 and 32767: a gauge that reaches it is clipped. \
             Without them limits are found where a gauge stands at its extreme while the load goes on",
        ) {
            let extremes = || gauge_extremes(project.recordings.entries(), None);
            entered = knows.then(|| GaugeRange::All(extremes()));
        }
        gauge_range(ui, project, &mut entered);
        if entered != project.gauge_range {
            out.push(Edit::GaugeRange(entered.filter(GaugeRange::rises)).into());
        }
        let entries = project.recordings.entries();
        let faults = (0..entries.len()).filter_map(|at| Some((at, engine.faults_of(at)?)));
        let faults: Vec<_> = faults.filter(|(_, faults)| !faults.words.is_empty()).collect();
        let n_faulty: usize = faults.iter().map(|(_, faults)| faults.n_samples).sum();
        if !faults.is_empty() {
            let n: usize = entries.iter().map(|entry| entry.recording.n_samples()).sum();
            let text = match n_faulty {
                0 => "A channel looks dead".to_owned(),
                _ => format!("{n_faulty} of {n} samples look faulty"),
            };
            let label = ui.warn(text);
            label.on_hover_ui(|ui| {
                for (at, faults) in faults.iter().take(12) {
                    let recording = &entries[*at].recording;
                    let words = faults.words.join(", ");
                    ui.label(format!("{}: {words}", printable(recording.name())));
                }
                if let Some(more) = and_more(faults.len(), 12) {
                    ui.label(format!("{more} recordings"));
                }
            });
        }
        if (n_faulty > 0 || project.gauge_range.is_some())
            && ui.press(
                "Leave out",
                "Takes the faulty samples out of the recordings; history does not cross what is missing for longer than a \
                 gap. Exported code then says where a gauge is clipped. Undo takes it back",
            ) {
                out.push(Action::LeaveOutFaulty.into());
            }
    });
}

/// The ends of what gauges can show: of all, or of each.
fn gauge_range(ui: &mut egui::Ui, project: &Project, entered: &mut Option<GaugeRange>) {
    let Some(range) = entered else { return };
    let names = &project.recordings.layout().gauge_names;
    let ends = |ui: &mut egui::Ui, (low, high): &mut (f64, f64), of: &str| {
        for (value, what) in [(low, "Least value"), (high, "Greatest value")] {
            let speed = (0.001 * value.abs()).max(1e-6);
            let field = egui::DragValue::new(value).speed(speed);
            ui.add(field).on_hover_text(format!("{what} of {of}"));
        }
    };
    if let GaugeRange::All(range) = range {
        ends(ui, range, "a gauge");
    }
    let mut by_gauge = matches!(range, GaugeRange::Each(_));
    if ui.tick(
        &mut by_gauge,
        "by gauge",
        "Limits of its own for each gauge, where they are wired to other amplifiers",
    ) {
        let own = |gauge: usize| range.of(gauge);
        *range = match by_gauge {
            true => GaugeRange::Each((0..names.len()).map(own).collect()),
            false => GaugeRange::All(
                (0..names.len())
                    .filter_map(own)
                    .reduce(|all, own| (all.0.min(own.0), all.1.max(own.1)))
                    .unwrap_or_else(|| gauge_extremes(project.recordings.entries(), None)),
            ),
        };
    }
    let GaugeRange::Each(ranges) = range else {
        return;
    };
    ranges.resize(names.len(), None);
    let known = ranges.iter().flatten().count();
    let button = egui::Button::new(format!("{known} of {}", names.len()));
    let response = ui.menu_of_fields(button, |ui| {
        egui::ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
            egui::Grid::new("limits of gauges").show(ui, |ui| {
                for (gauge, (name, own)) in names.iter().zip(ranges).enumerate() {
                    let mut knows = own.is_some();
                    if ui.tick(&mut knows, printable(name), "Whether its limits are known") {
                        let entries = project.recordings.entries();
                        *own = knows.then(|| gauge_extremes(entries, Some(gauge)));
                    }
                    if let Some(own) = own {
                        ends(ui, own, name);
                    }
                    ui.end_row();
                }
            });
        });
    });
    response.on_hover_text("The limits of each gauge; those without are found");
}

/// The least and the greatest value of all gauges, or of one, and nought.
fn gauge_extremes(entries: &[Entry], gauge: Option<usize>) -> (f64, f64) {
    let ranges = entries.iter().flat_map(|entry| {
        let ranges = entry.recording.gauge_ranges();
        match gauge {
            Some(gauge) => &ranges[gauge..=gauge],
            None => ranges,
        }
    });
    ranges.fold((0.0, 0.0), |all: (f64, f64), own| (all.0.min(own.0), all.1.max(own.1)))
}

fn table(ui: &mut egui::Ui, engine: &Engine, fields: &mut View, out: &mut Vec<Command>) {
    let axes = engine.project().axes();
    let group = if axes.iter().any(|axis| axis.is_force()) { Group::Force } else { Group::Moment };
    let unit = axes.first().map_or("", |axis| axis.unit());
    // Where there is little room the name, whose hover tells both, needs it more.
    let counted = ui.available_width() > MIN_WIDTH_FOR_COUNTS;
    let counts = [Column::exact(54.0).clip(true), Column::exact(50.0), Column::exact(34.0)];
    let mut builder = TableBuilder::new(ui)
        .striped(true)
        .auto_shrink([false, false])
        .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
        .column(Column::exact(46.0))
        .column(Column::remainder().at_least(70.0).clip(true));
    for count in counts.into_iter().filter(|_| counted) {
        builder = builder.column(count);
    }
    builder
        .columns(Column::exact(44.0), 2)
        .column(Column::exact(18.0))
        .header(18.0, |mut header| {
            let rmse = format!("RMSE over the force axes (without any: the moments) [{unit}]");
            let titles = [
                ("Role", "What the recording is for; press to change"),
                (
                    "Name",
                    "Press to put it on screen; the right button or Shift+F10 tares it or sets its group",
                ),
                (
                    "Group",
                    "Recordings of one group repeat a programme, a day or a mounting, and are left out together; press to change",
                ),
                ("Samples", "After decimation"),
                ("Hz", "One over the median time step"),
            ];
            let n = if counted { 5 } else { 2 };
            for (title, explanation) in titles.into_iter().take(n) {
                header.col(|ui| {
                    ui.strong(title).on_hover_text(explanation);
                });
            }
            for trace in [Trace::Conventional, Trace::Compensated] {
                header.col(|ui| {
                    ui.colored_label(trace.color(ui.visuals()), trace.label())
                        .on_hover_text(format!("{}: {rmse}", trace.explanation()));
                });
            }
            header.col(|_| {});
        })
        .body(|body| {
            body.rows(
                20.0,
                engine.entries().len(),
                |mut row| {
                    let at = row.index();
                    let entry = &engine.entries()[at];
                    row.set_selected(engine.project().view == questions::View::One(at));
                    row.col(|ui| role_menu(ui, at, entry, out));
                    row.col(|ui| name_button(ui, engine, at, fields, out));
                    let result = engine.result_of(at);
                    if counted {
                        row.col(|ui| group_button(ui, engine, at, &mut fields.group, out));
                        row.col(|ui| {
                            let samples =
                                result.map_or(entry.recording.n_samples(), |r| r.n_samples);
                            ui.label(samples.to_string());
                        });
                        row.col(|ui| {
                            let rate = rate_text(entry, engine.project().settings.decimation);
                            ui.label(rate);
                        });
                    }
                    let rmse =
                        result.map(|result| [&result.conventional_rmse, &result.compensated_rmse]);
                    for at in 0..2 {
                        let rmse = rmse.and_then(|rmse| rmse[at].as_deref());
                        row.col(|ui| rmse_label(ui, group, axes, rmse, result));
                    }
                    row.col(|ui| {
                        if ui.press_small("×", "Close this recording")
                        {
                            out.push(Edit::Remove(at).into());
                        }
                    });
                },
            );
        });
}

/// The group of a recording: as it was set, else as it was found.
fn group_of(engine: &Engine, at: usize) -> Option<&str> {
    let entry = engine.entries().get(at)?;
    let found = || engine.result_of(at)?.group.as_deref();
    entry.group.as_deref().or_else(found)
}

fn group_button(
    ui: &mut egui::Ui,
    engine: &Engine,
    at: usize,
    typed: &mut (usize, String),
    out: &mut Vec<Command>,
) {
    let group = group_of(engine, at);
    let button = egui::Button::new(group.unwrap_or("–")).truncate();
    let response = ui.menu_of_fields(button, |ui| group_menu(ui, engine, at, typed, out));
    response.on_hover_text(match group {
        Some(group) => format!("{group}: left out together with the others of this group"),
        None => "Left out on its own in cross-validation".to_owned(),
    });
}

/// Says what group one recording is in, or all.
fn group_menu(
    ui: &mut egui::Ui,
    engine: &Engine,
    at: usize,
    (of, text): &mut (usize, String),
    out: &mut Vec<Command>,
) {
    let entries = engine.entries();
    if *of != at {
        *of = at;
        *text = group_of(engine, at).unwrap_or_default().to_owned();
    }

    let field = egui::TextEdit::singleline(text).hint_text("as found; Enter sets it");
    let field =
        ui.labelled("Group: recordings that repeat a programme, a day or a mounting", field);
    let set = |group: Option<String>| {
        let mut groups: Vec<_> = entries.iter().map(|entry| entry.group.clone()).collect();
        groups[at] = group;
        groups
    };
    let entered = ui.entered(&field);
    let mut chosen = entered.then(|| {
        let text = text.trim();
        set((!text.is_empty()).then(|| text.to_owned()))
    });
    if ui.button("As found").clicked() {
        chosen = Some(set(None));
    }
    ui.separator();
    ui.label("All recordings");
    let pattern = |text: &str| text.parse::<GroupPattern>().ok();
    for (label, pattern) in
        [("As found", None), ("By file", pattern("{file}")), ("By folder", pattern("{folder}"))]
    {
        if ui.button(label).clicked() {
            let group = |entry: &Entry| pattern.as_ref()?.group_of(&entry.recording);
            chosen = Some(entries.iter().map(group).collect());
        }
    }
    if ui.button("Each on its own").clicked() {
        let own =
            |(at, entry): (usize, &Entry)| Some(format!("{} {}", at + 1, entry.recording.name()));
        chosen = Some(entries.iter().enumerate().map(own).collect());
    }
    if let Some(groups) = chosen {
        out.push(Edit::Groups(groups).into());
        *of = usize::MAX;
        ui.close();
    }
}

/// Says on which day the recordings of one file were recorded.
fn day_menu(
    ui: &mut egui::Ui,
    engine: &Engine,
    at: usize,
    (of, text): &mut (usize, String),
    out: &mut Vec<Command>,
) {
    let entries = engine.entries();
    let recording = &entries[at].recording;
    if *of != at {
        *of = at;
        *text = recording.dated().map_or_else(String::new, |dated| dated.day.to_string());
    }

    let field = egui::TextEdit::singleline(text).hint_text("2024-05-03; Enter sets it");
    let field = ui.labelled("Date of its file's recordings: days are compared by it", field);
    let entered = ui.entered(&field);
    let day = text.trim().parse::<Day>();
    if let (false, Err(error)) = (text.trim().is_empty(), &day) {
        ui.warn(error.to_string());
    }
    let cleared =
        ui.press("As its file says", "By the file's header, its clock, or a date in its name");
    let chosen = match (cleared || (entered && text.trim().is_empty()), day) {
        (true, _) => None,
        (false, Ok(day)) if entered => Some(day),
        _ => return,
    };
    let is_of_file = |other: usize| match recording.source() {
        Source::File(_) => entries[other].recording.source() == recording.source(),
        Source::Simulated => other == at,
    };
    let days = (0..entries.len()).map(|other| match is_of_file(other) {
        true => chosen,
        false => entries[other].recording.entered_day(),
    });
    out.push(Edit::Days(days.collect()).into());
    *of = usize::MAX;
    ui.close();
}

/// The list as a table, with the errors of every axis.
fn as_table(engine: &Engine) -> Table {
    let axes = engine.project().axes();
    let errors = [Trace::Conventional, Trace::Compensated].into_iter().enumerate();
    let errors = errors.flat_map(|(output, trace)| {
        axes.iter().enumerate().map(move |(at, axis)| (output, trace, at, axis))
    });
    Table::of(engine.entries().iter().enumerate())
        .words("role", |(_, entry)| entry.role.label())
        .words("name", |(_, entry)| entry.recording.name())
        .words("group", |(at, _)| group_of(engine, *at).unwrap_or_default())
        .column(report::Column::numbers("samples"), |(_, entry)| {
            Cell::whole(entry.recording.n_samples())
        })
        .columns(
            errors,
            |(_, trace, _, axis)| {
                let name = format!("{} RMSE {}", trace.label(), axis.symbol());
                report::Column::numbers(name).unit(axis.unit())
            },
            |(row, _), (output, _, at, _)| {
                let result = engine.result_of(*row);
                let rmse = result.map(|own| [&own.conventional_rmse, &own.compensated_rmse]);
                let rmse = rmse.and_then(|rmse| rmse[*output].as_ref());
                Cell::digits(rmse.and_then(|rmse| rmse.get(*at)).copied(), 5)
            },
        )
        .table("", "")
}

fn role_menu(ui: &mut egui::Ui, at: usize, entry: &Entry, out: &mut Vec<Command>) {
    let roles = [
        ("Train", Role::Train, "The fit uses it"),
        ("Test", Role::Test, "It only scores the fit"),
        ("Off", Role::Off, "It takes no part"),
    ];
    let label = (roles.iter()).find_map(|(label, role, _)| (*role == entry.role).then_some(*label));
    if !entry.recording.has_reference() {
        ui.weak("–").on_hover_text(
            "No reference load: it can be shown with a calibration, but neither fitted nor scored",
        );
        return;
    }
    ui.menu_button(label.unwrap_or_default(), |ui| {
        for (label, role, explanation) in roles {
            let radio = ui.radio(entry.role == role, label);
            if radio.on_hover_text(explanation).clicked() {
                out.push(Edit::Role(at, role).into());
                ui.close();
            }
        }
    })
    .response
    .on_hover_text("What this recording is for: it trains, it tests, or it is off");
}

fn name_button(
    ui: &mut egui::Ui,
    engine: &Engine,
    at: usize,
    fields: &mut View,
    out: &mut Vec<Command>,
) {
    let recording = &engine.entries()[at].recording;
    let room = ui.available_width() - 2.0 * ui.spacing().button_padding.x;
    let name = shortened(ui, recording.name(), room);
    let button = egui::Button::selectable(engine.project().view == questions::View::One(at), name)
        .truncate();
    let response = ui.add(button);
    response.widget_info(|| {
        let (role, name) = (egui::Role::Button, recording.name());
        egui::WidgetInfo::selected(
            role,
            true,
            engine.project().view == questions::View::One(at),
            name,
        )
    });
    let response = response.on_hover_ui(|ui| {
        ui.strong(recording.name());
        let source = match recording.source() {
            Source::File(path) => path.display().to_string(),
            Source::Simulated => "built-in simulated sensor".to_owned(),
        };
        ui.label(source);
        if let Some(group) = group_of(engine, at) {
            ui.label(format!("group: {group}"));
        }
        if let Some(dated) = recording.dated() {
            ui.label(format!("recorded on {} ({})", dated.day, dated.from.words()));
        }
        if let Some(tare) = recording.tare() {
            ui.label(format!("tared over {tare}"));
        }
        if let Some(left_out) = recording.left_out() {
            let (n, of) = (left_out.n_samples, printable(&left_out.of));
            ui.label(format!("{n} faulty samples left out of {of}"));
        }
        if let Some(faults) = engine.faults_of(at) {
            for words in &faults.words {
                ui.warn(words);
            }
        }
        let reference: Vec<_> = recording.axes().iter().map(|axis| axis.symbol()).collect();
        ui.label(format!(
            "{} samples over {} s, {} gauges, reference: {}",
            recording.n_samples(),
            significant(recording.duration_secs(), 4),
            recording.n_gauges(),
            if reference.is_empty() { "none".to_owned() } else { reference.join(" ") },
        ));
        for channel in recording.auxiliary().in_words() {
            ui.label(format!("auxiliary: {channel}"));
        }
    });
    if response.clicked() {
        out.push(Action::Show(questions::View::One(at)).into());
    }
    context_menu(&response, |ui| {
        let first = tare_menu(ui, at, recording.name(), out);
        ui.separator();
        group_menu(ui, engine, at, &mut fields.group, out);
        ui.separator();
        day_menu(ui, engine, at, &mut fields.day, out);
        first
    });
}

/// A name that fits the room.
fn shortened(ui: &egui::Ui, name: &str, room: f32) -> String {
    let font = egui::TextStyle::Button.resolve(ui.style());
    let fits = |text: &str| {
        let galley = (ui.painter()).layout_no_wrap(text.to_owned(), font.clone(), Color32::WHITE);
        galley.size().x <= room
    };
    if fits(name) {
        return name.to_owned();
    }
    // By bisection: a name may be long, and every row is drawn in every frame.
    let (mut most, mut too_many) = (1, name.chars().count());
    while too_many - most > 1 {
        let middle = most.midpoint(too_many);
        match fits(&elided(name, middle)) {
            true => most = middle,
            false => too_many = middle,
        }
    }
    elided(name, most)
}

/// Ways to tare one recording.
fn tare_menu(ui: &mut egui::Ui, at: usize, name: &str, out: &mut Vec<Command>) -> egui::Response {
    ui.strong(format!("Tare {name}"));
    let quiet = ui.button("Over its first quiet half second").on_hover_text(
        "The mean gauges of the first quiet half second in which the reference shows no load are taken off. Undo takes it back",
    );
    if quiet.clicked() {
        out.push(Action::Tare(vec![at], Tare::Auto).into());
        ui.close();
    }
    for secs in [0.5, 1.0, 2.0, 5.0] {
        if ui.press(
            format!("Over its first {secs} s"),
            "The mean gauges of this interval are taken off",
        ) {
            out.push(Action::Tare(vec![at], Tare::Interval(0.0, secs)).into());
            ui.close();
        }
    }
    if ui.press(
        "Over the span between the cursors",
        "The mean gauges between cursor A and cursor B are taken off",
    ) {
        out.push(Command::TareBetweenCursors(at));
        ui.close();
    }
    quiet
}

/// The rate with every `step`-th sample used.
fn rate_text(entry: &Entry, step: usize) -> String {
    let rate = entry.recording.rate_hz();
    rate.map_or_else(|| "–".to_owned(), |rate| significant(rate / step.max(1) as f64, 3))
}

fn rmse_label(
    ui: &mut egui::Ui,
    group: Group,
    axes: &[Axis],
    rmse: Option<&[f64]>,
    result: Option<&RecordingResult>,
) {
    let (Some(rmse), Some(result)) = (rmse, result) else {
        ui.weak("–");
        return;
    };
    let over_group = group.rmse(axes, rmse).unwrap_or_default();
    ui.label(significant(over_group, 3)).on_hover_ui(|ui| {
        for (axis, rmse) in axes.iter().zip(rmse) {
            let rmse = significant(*rmse, 4);
            ui.label(format!("{}: {rmse} {}", axis.symbol(), axis.unit()));
        }
        if let Some(share) = result.share_with_past {
            ui.label(format!("{:.0} % of the samples have a past sample", 100.0 * share));
        }
    });
}
