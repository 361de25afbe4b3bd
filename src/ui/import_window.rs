//! Saying what the columns of a file are: how its text is cut, what each column is, and at once what would be loaded.

use egui::{ComboBox, DragValue, RichText, TextEdit};
use egui_extras::{Column, TableBuilder};

use crate::app::{AppState, Command, ImportCommand, Importing};
use crate::recording::Tare;
use crate::recording::columns::{
    Angles, ColumnKey, ColumnMap, ColumnRole, ColumnRule, Decimal, Delimiter, JoinMethod,
    ReferenceFile, TableMap, TextLayout, WeightMap,
};
use crate::recording::delimited::inspect::{ColumnReport, Inspection, TableReport};
use crate::ui::numbers::significant;

/// What stands in the window's text fields.
#[derive(Debug)]
pub struct ImportFields {
    map_path: String,
}

impl Default for ImportFields {
    fn default() -> Self {
        Self {
            map_path: "columns.json".to_owned(),
        }
    }
}

/// Draws the window while a file is being imported.
pub fn import_window(
    context: &egui::Context,
    state: &AppState,
    fields: &mut ImportFields,
    out: &mut Vec<Command>,
) {
    let Some(importing) = &state.importing else {
        return;
    };
    let mut open = true;
    let screen = context.content_rect();
    let name = importing
        .path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy();
    egui::Window::new(format!("Import {name}"))
        .id(egui::Id::unique("import"))
        .open(&mut open)
        .default_size([
            screen.width().min(900.0),
            (screen.height() - 160.0).min(620.0),
        ])
        .pivot(egui::Align2::CENTER_CENTER)
        .default_pos(screen.center())
        .show(context, |ui| {
            if let Some(problem) = &importing.problem {
                ui.colored_label(ui.visuals().error_fg_color, problem);
            }
            let Some(inspection) = importing.inspection.as_deref() else {
                if importing.problem.is_none() {
                    ui.spinner();
                }
                return;
            };
            egui::Panel::bottom("import foot")
                .show(ui, |ui| foot(ui, importing, inspection, fields, out));
            egui::CentralPanel::no_frame().show(ui, |ui| {
                egui::ScrollArea::vertical()
                    .auto_shrink([false, false])
                    .show(ui, |ui| body(ui, state, importing, inspection, out));
            });
        });
    if !open {
        send(out, ImportCommand::Cancel);
    }
}

fn send(out: &mut Vec<Command>, command: ImportCommand) {
    out.push(Command::Import(command));
}

fn body(
    ui: &mut egui::Ui,
    state: &AppState,
    importing: &Importing,
    inspection: &Inspection,
    out: &mut Vec<Command>,
) {
    let table = &inspection.table;
    ui.label(format!(
        "{}: {} bytes of {} text, about {} rows",
        importing.path.display(),
        table.file_bytes,
        table.encoding.name(),
        table.about_rows
    ));
    if !importing.waiting.is_empty() {
        ui.label(format!(
            "{} more files want a map; those of the same shape take this one",
            importing.waiting.len()
        ));
    }
    for hint in &inspection.hints {
        ui.colored_label(ui.visuals().warn_fg_color, format!("To decide: {hint}"));
    }
    remembered(ui, state, importing, out);
    ui.separator();
    let mut text = importing.map.table.text.clone();
    layout(ui, &mut text);
    if text != importing.map.table.text {
        send(out, ImportCommand::SetLayout(text));
        return;
    }
    let mut map = importing.map.clone();
    clock(ui, &mut map);
    columns(ui, "columns", &table.columns, &mut map.table);
    reference(ui, inspection, &mut map);
    if map != importing.map {
        send(out, ImportCommand::SetMap(Box::new(map)));
    }
    ui.separator();
    preview(ui, table);
}

/// Maps of before that are for files of this shape.
fn remembered(ui: &mut egui::Ui, state: &AppState, importing: &Importing, out: &mut Vec<Command>) {
    let shape = &importing.map.table.shape;
    let maps = state.preferences.maps.iter().enumerate();
    let fitting: Vec<usize> = maps
        .filter(|(_, map)| map.table.shape == *shape && **map != importing.map)
        .map(|(at, _)| at)
        .collect();
    ui.horizontal_wrapped(|ui| {
        if ui
            .button("Look again")
            .on_hover_text("Take what is found by looking at the file")
            .clicked()
        {
            send(out, ImportCommand::Begin);
        }
        for at in fitting {
            let button = ui.button("As the last file of this shape");
            if button.on_hover_text("Take the remembered map").clicked() {
                send(out, ImportCommand::TakeMap(at));
            }
        }
    });
}

fn layout(ui: &mut egui::Ui, text: &mut TextLayout) {
    ui.horizontal_wrapped(|ui| {
        ComboBox::from_label("between cells")
            .selected_text(text.delimiter.name())
            .width(90.0)
            .show_ui(ui, |ui| {
                for delimiter in Delimiter::ALL {
                    ui.selectable_value(&mut text.delimiter, delimiter, delimiter.name());
                }
            });
        let mut comma = text.decimal == Decimal::Comma;
        if ui.checkbox(&mut comma, "decimal comma").changed() {
            text.decimal = if comma {
                Decimal::Comma
            } else {
                Decimal::Point
            };
        }
        let label = ui.label("skip lines");
        ui.add(DragValue::new(&mut text.skip_rows).range(0..=100_000))
            .labelled_by(label.id);
        ui.checkbox(&mut text.header, "a line of names");
        ui.checkbox(&mut text.units_row, "a line of units below");
    });
}

fn clock(ui: &mut egui::Ui, map: &mut ColumnMap) {
    ui.horizontal_wrapped(|ui| {
        optional(
            ui,
            "sample rate",
            " Hz",
            100.0,
            &mut map.table.sample_rate_hz,
        )
        .on_hover_text("Where no column is the time, or where the time counts samples");
        optional(
            ui,
            "average bursts within",
            " s",
            0.001,
            &mut map.average_bursts_secs,
        )
        .on_hover_text("Successive gauge samples no further apart become one, their mean");
        tare(ui, &mut map.tare);
    });
    weight(ui, map);
}

fn tare(ui: &mut egui::Ui, tare: &mut Option<Tare>) {
    let text = match tare {
        None => "none",
        Some(Tare::Auto) => "first quiet half second",
        Some(Tare::Stretch(..)) => "a stretch",
    };
    ComboBox::from_label("tare")
        .selected_text(text)
        .width(150.0)
        .show_ui(ui, |ui| {
            ui.selectable_value(tare, None, "none");
            ui.selectable_value(tare, Some(Tare::Auto), "first quiet half second");
            let is_stretch = matches!(tare, Some(Tare::Stretch(..)));
            if ui.selectable_label(is_stretch, "a stretch").clicked() && !is_stretch {
                *tare = Some(Tare::Stretch(0.0, 1.0));
            }
        });
    if let Some(Tare::Stretch(from, to)) = tare {
        for (name, value) in [("from", from), ("to", to)] {
            let label = ui.label(name);
            let field = DragValue::new(value)
                .range(0.0..=1e9)
                .speed(0.01)
                .suffix(" s");
            ui.add(field).labelled_by(label.id);
        }
    }
}

/// A load that is computed from the sensor's pose and a known weight.
fn weight(ui: &mut egui::Ui, map: &mut ColumnMap) {
    let mut used = map.weight.is_some();
    let tick = ui
        .checkbox(&mut used, "The load is that of a known weight, by the pose columns")
        .on_hover_text(
            "Say which columns are the pose: pose_qw to pose_qz, pose_roll, pose_pitch, pose_yaw, pose_rx to pose_rz or \
             pose_r11 to pose_r33; several weights (\"mounts\") are said in the map's file",
        );
    if tick.changed() {
        map.weight = used.then(|| WeightMap {
            mass_kg: Some(1.0),
            centre_m: Some([0.0; 3]),
            ..WeightMap::default()
        });
    }
    let Some(weight) = &mut map.weight else {
        return;
    };
    ui.horizontal_wrapped(|ui| {
        let number = |ui: &mut egui::Ui, name: &str, suffix: &str, value: &mut f64| {
            let label = ui.label(name);
            let field = DragValue::new(value)
                .speed(0.001)
                .max_decimals(6)
                .suffix(suffix);
            ui.add(field).labelled_by(label.id);
        };
        if let Some(mass) = &mut weight.mass_kg {
            number(ui, "mass", " kg", mass);
        }
        if let Some(centre) = &mut weight.centre_m {
            for (name, value) in ["centre x", "y", "z"].into_iter().zip(centre) {
                number(ui, name, " m", value);
            }
        }
        for (name, value) in ["gravity x", "y", "z"].into_iter().zip(&mut weight.gravity) {
            number(ui, name, " m/s²", value);
        }
        ui.radio_value(&mut weight.angles, Angles::FixedXyz, "fixed axes");
        ui.radio_value(&mut weight.angles, Angles::IntrinsicXyz, "turned axes");
        ui.checkbox(&mut weight.inertia, "inertia");
        number(ui, "smoothed over", " s", &mut weight.smoothing_secs);
    });
}

/// A tick with a number beside it.
fn optional(
    ui: &mut egui::Ui,
    name: &str,
    suffix: &str,
    default: f64,
    value: &mut Option<f64>,
) -> egui::Response {
    let mut on = value.is_some();
    let tick = ui.checkbox(&mut on, name);
    if tick.changed() {
        *value = on.then_some(default);
    }
    if let Some(value) = value {
        let speed = 0.01 * *value;
        let field = DragValue::new(value)
            .range(1e-9..=1e9)
            .max_decimals(6)
            .speed(speed)
            .suffix(suffix);
        ui.add(field).labelled_by(tick.id);
    }
    tick
}

/// One row a column: what it is, its name and unit, its sign and scale, what it holds.
fn columns(ui: &mut egui::Ui, id: &str, reports: &[ColumnReport], table: &mut TableMap) {
    let height = 24.0 * (reports.len() as f32 + 1.0) + 14.0;
    egui::ScrollArea::horizontal().id_salt(id).max_height(height).show(ui, |ui| {
        TableBuilder::new(ui)
            .id_salt(id)
            .striped(true)
            .vscroll(false)
            .column(Column::exact(28.0))
            .column(Column::initial(130.0).clip(true).resizable(true))
            .column(Column::exact(130.0))
            .columns(Column::exact(76.0), 2)
            .column(Column::exact(64.0))
            .column(Column::exact(80.0))
            .column(Column::remainder().at_least(160.0).clip(true))
            .header(20.0, |mut header| {
                for (title, explanation) in [
                    ("", "The number of the column"),
                    ("Header", "As the file writes it"),
                    ("Is", "What it is; what nobody looks at is ignored"),
                    ("Name", "What a gauge is called; empty: as in the header, or S1, S2, …"),
                    ("Unit", "Of a load: N, lbf, N·mm, …; of a time: s, ms, us, ns, samples, iso8601; of a gauge a label"),
                    ("Times", "Values are multiplied with this; -1 turns the sign"),
                    ("No value", "A number that means that there is none"),
                    ("First values, range", "By the first rows"),
                ] {
                    header.col(|ui| {
                        ui.strong(title).on_hover_text(explanation);
                    });
                }
            })
            .body(|body| {
                body.rows(24.0, reports.len(), |mut row| {
                    let report = &reports[row.index()];
                    let mut rule = rule_of(table, report);
                    let before = rule.clone();
                    column_row(&mut row, id, report, &mut rule);
                    if rule != before {
                        set_rule(table, report, rule);
                    }
                });
            });
    });
}

fn column_row(
    row: &mut egui_extras::TableRow<'_, '_>,
    id: &str,
    report: &ColumnReport,
    rule: &mut ColumnRule,
) {
    let number = report.number;
    row.col(|ui| {
        ui.weak(number.to_string());
    });
    row.col(|ui| {
        ui.label(&report.name);
    });
    row.col(|ui| {
        ComboBox::from_id_salt((id, number))
            .selected_text(rule.is.name())
            .width(112.0)
            .show_ui(ui, |ui| {
                for role in ColumnRole::ALL {
                    ui.selectable_value(&mut rule.is, role, role.name());
                }
            })
            .response
            .widget_info(|| {
                let name = format!("Column {number} is {}", rule.is.name());
                egui::WidgetInfo::labeled(egui::Role::ComboBox, true, name)
            });
    });
    let used = rule.is != ColumnRole::Ignore;
    for (what, text, hint) in [
        ("name", &mut rule.name, ""),
        ("unit", &mut rule.unit, report.unit.as_deref().unwrap_or("")),
    ] {
        row.col(|ui| text_cell(ui, used, &format!("{what} of column {number}"), text, hint));
    }
    row.col(|ui| {
        ui.add_enabled(
            used,
            DragValue::new(&mut rule.scale).speed(0.01).max_decimals(9),
        )
        .widget_info(|| label(&format!("scale of column {number}")));
    });
    row.col(|ui| {
        let mut text = rule.dropouts.first().map(f64::to_string);
        text_cell(
            ui,
            used,
            &format!("no value in column {number}"),
            &mut text,
            "none",
        );
        let written = text.unwrap_or_default();
        if written.trim().is_empty() {
            rule.dropouts.clear();
        } else if let Ok(value) = written.trim().parse::<f64>() {
            rule.dropouts = vec![value];
        }
    });
    row.col(|ui| {
        let range = match (report.min, report.max) {
            (Some(min), Some(max)) => format!("{} to {}", significant(min, 4), significant(max, 4)),
            _ => report.content.name().to_owned(),
        };
        let first: Vec<String> = report.first.iter().map(|cell| shortened(cell)).collect();
        ui.label(format!("{}   {range}", first.join("  ")));
    });
}

/// A number with as many digits as one looks at; other text as it is.
fn shortened(cell: &str) -> String {
    let number = cell.parse::<f64>().ok().filter(|_| cell.len() > 8);
    number.map_or_else(|| cell.to_owned(), |number| significant(number, 5))
}

fn label(text: &str) -> egui::WidgetInfo {
    egui::WidgetInfo::labeled(egui::Role::SpinButton, true, text)
}

fn text_cell(ui: &mut egui::Ui, used: bool, name: &str, text: &mut Option<String>, hint: &str) {
    let mut written = text.clone().unwrap_or_default();
    let field = TextEdit::singleline(&mut written)
        .hint_text(hint)
        .desired_width(f32::INFINITY);
    let response = ui.add_enabled(used, field);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, used, name));
    if response.changed() {
        *text = (!written.trim().is_empty()).then_some(written);
    }
}

fn is_of(rule: &ColumnRule, report: &ColumnReport) -> bool {
    match &rule.column {
        ColumnKey::Number(number) => *number == report.number,
        ColumnKey::Name(name) => *name == report.name,
    }
}

fn rule_of(table: &TableMap, report: &ColumnReport) -> ColumnRule {
    let rule = table
        .columns
        .iter()
        .find(|rule| is_of(rule, report))
        .cloned();
    rule.unwrap_or_else(|| ColumnRule::new(ColumnKey::Number(report.number), ColumnRole::Ignore))
}

/// Puts a column's rule in its place, in the order of the columns.
fn set_rule(table: &mut TableMap, report: &ColumnReport, rule: ColumnRule) {
    match table.columns.iter().position(|rule| is_of(rule, report)) {
        Some(at) if rule.is == ColumnRole::Ignore => {
            table.columns.remove(at);
        }
        Some(at) => table.columns[at] = rule,
        None => {
            let after = table.columns.iter().position(
                |other| matches!(other.column, ColumnKey::Number(number) if number > report.number),
            );
            table
                .columns
                .insert(after.unwrap_or(table.columns.len()), rule);
        }
    }
}

/// A reference on its own clock: in a file of its own, and how it is joined.
fn reference(ui: &mut egui::Ui, inspection: &Inspection, map: &mut ColumnMap) {
    let mut own_file = map.reference.is_some();
    let tick = ui.checkbox(
        &mut own_file,
        "The reference load stands in a file of its own",
    );
    if tick.changed() {
        map.reference = own_file.then(|| ReferenceFile {
            file: String::new(),
            table: TableMap::default(),
        });
    }
    if let Some(reference) = &mut map.reference {
        ui.horizontal(|ui| {
            let label = ui.label("File").on_hover_text(
                "Seen from the folder of the file with the gauges; {stem} stands for that file's name without its ending",
            );
            let field = TextEdit::singleline(&mut reference.file)
                .hint_text("states.csv")
                .desired_width(260.0);
            ui.add(field).labelled_by(label.id);
        });
        if let Some(table) = &inspection.reference {
            if reference.table == TableMap::default() {
                // Begin with how the file itself is cut.
                reference.table.text = table.text.clone();
                reference.table.shape.columns = table.columns.len();
            }
            ui.push_id("reference layout", |ui| {
                layout(ui, &mut reference.table.text)
            });
            columns(
                ui,
                "reference columns",
                &table.columns,
                &mut reference.table,
            );
        }
    }
    if !map.has_two_clocks() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Between reference samples");
        for (method, label) in [
            (JoinMethod::Interpolate, "interpolate"),
            (JoinMethod::Nearest, "take the nearest"),
            (JoinMethod::Hold, "hold the last"),
        ] {
            ui.radio_value(&mut map.join.method, method, label);
        }
        let label = ui.label("add to the reference's times");
        let field = DragValue::new(&mut map.join.clock_offset_secs)
            .speed(0.001)
            .max_decimals(6)
            .suffix(" s");
        ui.add(field).labelled_by(label.id);
    });
    if let Some(offset) = inspection.check.clock_offset {
        ui.horizontal_wrapped(|ui| {
            ui.label(format!(
                "By cross-correlation the reference seems to need {} s; it is added only if you take it.",
                significant(offset.offset_secs, 4)
            ));
            if ui.button("Take it").clicked() {
                map.join.clock_offset_secs = offset.offset_secs;
            }
        });
    }
}

fn preview(ui: &mut egui::Ui, table: &TableReport) {
    ui.strong("First rows");
    egui::ScrollArea::horizontal()
        .id_salt("preview")
        .show(ui, |ui| {
            egui::Grid::new("preview").striped(true).show(ui, |ui| {
                for row in &table.preview {
                    for cell in row {
                        ui.monospace(cell);
                    }
                    ui.end_row();
                }
            });
        });
}

/// What would be loaded, what is wrong, and the buttons.
fn foot(
    ui: &mut egui::Ui,
    importing: &Importing,
    inspection: &Inspection,
    fields: &mut ImportFields,
    out: &mut Vec<Command>,
) {
    let check = &inspection.check;
    ui.add_space(4.0);
    egui::ScrollArea::vertical()
        .id_salt("check")
        .max_height(96.0)
        .show(ui, |ui| {
            match &check.error {
                Some(error) => {
                    ui.colored_label(ui.visuals().error_fg_color, error);
                }
                None => {
                    ui.label(RichText::new(would_load(inspection)).strong());
                }
            }
            for warning in &check.warnings {
                ui.colored_label(ui.visuals().warn_fg_color, warning);
            }
        });
    ui.horizontal(|ui| {
        let can_load = check.error.is_none() && !importing.looking;
        if ui
            .add_enabled(can_load, egui::Button::new("Load it"))
            .clicked()
        {
            send(out, ImportCommand::Load);
        }
        if ui.button("Cancel import").clicked() {
            send(out, ImportCommand::Cancel);
        }
        ui.separator();
        let label = ui.label("Column map");
        let field = TextEdit::singleline(&mut fields.map_path).desired_width(160.0);
        ui.add(field).labelled_by(label.id);
        let path = fields.map_path.trim().to_owned();
        let write = ui
            .button("Write map")
            .on_hover_text("For --columns on the command line");
        if write.clicked() && !path.is_empty() {
            send(out, ImportCommand::WriteMap(path.clone().into()));
        }
        if ui.button("Read map").clicked() && !path.is_empty() {
            send(out, ImportCommand::ReadMap(path.into()));
        }
        if importing.looking {
            ui.spinner();
        }
    });
    ui.add_space(4.0);
}

fn would_load(inspection: &Inspection) -> String {
    let check = &inspection.check;
    let samples: usize = check
        .recordings
        .iter()
        .map(|recording| recording.n_samples)
        .sum();
    let rate = check
        .recordings
        .first()
        .and_then(|recording| recording.rate_hz);
    let axes: Vec<&str> = check.axes.iter().map(|axis| axis.symbol()).collect();
    format!(
        "Would load {}{} recording{}, {samples} samples{}, gauges {}, {}",
        if check.is_sample {
            "from the start of the file "
        } else {
            ""
        },
        check.recordings.len(),
        if check.recordings.len() == 1 { "" } else { "s" },
        rate.map_or_else(String::new, |rate| format!(
            " at {} Hz",
            significant(rate, 3)
        )),
        check.gauges.join(" "),
        if axes.is_empty() {
            "no reference".to_owned()
        } else {
            format!("reference {}", axes.join(" "))
        },
    )
}
