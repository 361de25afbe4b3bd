//! Draws one recording of the list: role, name with its menu, group and errors.

use super::*;

/// Returns the group of a recording: the one set by the user, else the detected one.
pub(super) fn group_of(engine: &Engine, at: usize) -> Option<&str> {
    let entry = engine.entries().get(at)?;
    let found = || engine.result_of(at)?.group.as_deref();
    entry.group.as_deref().or_else(found)
}

pub(super) fn group_button(
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

    let field = egui::TextEdit::singleline(text).hint_text("detected; Enter sets it");
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
    let cleared = ui.press(
        "As its file says",
        "Takes the day from the file's header, from its clock, or from a date in its name",
    );
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
        false => entries[other].recording.entered_day,
    });
    out.push(Edit::Days(days.collect()).into());
    *of = usize::MAX;
    ui.close();
}

pub(super) fn role_menu(ui: &mut egui::Ui, at: usize, entry: &Entry, out: &mut Vec<Command>) {
    let roles = [
        ("Train", Role::Train, "Used by the fit"),
        ("Test", Role::Test, "Used only to score the fit"),
        ("Off", Role::Off, "Used neither by the fit nor for scores"),
    ];
    let label = (roles.iter()).find_map(|(label, role, _)| (*role == entry.role).then_some(*label));
    if !entry.recording.has_reference() {
        ui.weak("–").on_hover_text(
            "No reference load: a calibration can be applied to it, but it can be neither fitted nor scored",
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
    .on_hover_text("Role of this recording: train, test or off");
}

pub(super) fn name_button(
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
        let reference = Axis::symbols(recording.axes());
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

/// Returns a name that fits into this width.
fn shortened(ui: &egui::Ui, name: &str, room: f32) -> String {
    let font = egui::TextStyle::Button.resolve(ui.style());
    let fits = |text: &str| {
        let galley = (ui.painter()).layout_no_wrap(text.to_owned(), font.clone(), Color32::WHITE);
        galley.size().x <= room
    };
    if fits(name) {
        return name.to_owned();
    }
    // Bisection, because a name may be long and every row is drawn in every frame.
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

fn tare_menu(ui: &mut egui::Ui, at: usize, name: &str, out: &mut Vec<Command>) -> egui::Response {
    ui.strong(format!("Tare {name}"));
    let quiet = ui.button("Over its first quiet half second").on_hover_text(
        "Subtracts the mean gauges of the first quiet half second in which the reference is zero. Undo restores the values",
    );
    if quiet.clicked() {
        out.push(Action::Tare(vec![at], Tare::Auto).into());
        ui.close();
    }
    for secs in [0.5, 1.0, 2.0, 5.0] {
        if ui
            .press(format!("Over its first {secs} s"), "Subtracts the mean gauges of this interval")
        {
            out.push(Action::Tare(vec![at], Tare::Interval(0.0, secs)).into());
            ui.close();
        }
    }
    if ui.press(
        "Over the interval between the cursors",
        "Subtracts the mean gauges between cursor A and cursor B",
    ) {
        out.push(Command::TareBetweenCursors(at));
        ui.close();
    }
    quiet
}

/// Returns the sample rate after decimation by `step`, as text.
pub(super) fn rate_text(entry: &Entry, step: usize) -> String {
    let rate = entry.recording.rate_hz();
    rate.map_or_else(|| "–".to_owned(), |rate| significant(rate / step.max(1) as f64, 3))
}

pub(super) fn rmse_label(
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
