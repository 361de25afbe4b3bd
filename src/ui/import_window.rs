//! Saying what the columns of a file are: how its text is cut, what each column is, and at once what would be loaded.

use egui::{ComboBox, DragValue, RichText, TextEdit};
use egui_extras::{Column, TableBuilder};

use crate::engine::{Engine, ImportCommand, Importing};
use crate::formats::text::{Decimal, Delimiter, TextLayout};
use crate::import::inspect::{ColumnReport, Inspection, TableReport};
use crate::import::map::{
    Angles, ColumnKey, ColumnMap, ColumnRole, ColumnRule, Header, JoinMethod, Mount, ReferenceFile,
    TableMap, WeightMap,
};
use crate::recording::Tare;
use crate::ui::command::Command;
use crate::ui::context_menu::item;
use crate::ui::numbers::significant;

const NAME: &str = "What a gauge is called; empty: as in the header, or S1, S2, …";
const UNIT: &str =
    "Of a load: N, lbf, N·mm, …; of a time: s, ms, us, ns, samples, iso8601; of a gauge a label";
const TIMES: &str = "Values are multiplied with this; -1 turns the sign";
const NO_VALUE: &str = "A number that means that there is none";

/// What stands in the window's text fields.
#[derive(Debug)]
pub struct ImportFields {
    map_path: String,
    /// Whether a key went into a text field before this frame: Escape has taken the focus away by then.
    is_typing: bool,
}

impl Default for ImportFields {
    fn default() -> Self {
        Self {
            map_path: "columns.json".to_owned(),
            is_typing: false,
        }
    }
}

/// Draws the window while a file is being imported.
pub fn import_window(
    context: &egui::Context,
    engine: &Engine,
    fields: &mut ImportFields,
    out: &mut Vec<Command>,
) {
    let Some(importing) = &engine.importing else {
        return;
    };
    // Whatever is open within the window, or is being typed, ends first.
    let ends_by_key = !egui::Popup::is_any_open(context)
        && !fields.is_typing
        && context.input(|input| input.key_pressed(egui::Key::Escape));
    let mut open = !ends_by_key;
    let screen = context.content_rect();
    let name = importing
        .path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy();
    let size = egui::vec2(
        screen.width().min(900.0),
        (screen.height() - 160.0).min(620.0),
    );
    egui::Window::new(format!("Import {name}"))
        .id(egui::Id::unique("import"))
        .open(&mut open)
        .default_size(size)
        // Its corner stays where it is, whatever comes and goes within.
        .default_pos(screen.center() - 0.5 * size)
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
                    .show(ui, |ui| body(ui, engine, importing, inspection, out));
            });
        });
    fields.is_typing = context.text_edit_focused();
    if !open {
        send(out, ImportCommand::CancelAll);
    }
}

fn send(out: &mut Vec<Command>, command: ImportCommand) {
    out.push(command.into());
}

fn body(
    ui: &mut egui::Ui,
    engine: &Engine,
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
            "{} more files want a map; those like this one take the same",
            importing.waiting.len()
        ));
    }
    questions(ui, importing, inspection, out);
    remembered(ui, engine, importing, out);
    ui.separator();
    let mut text = importing.map.table.text.clone();
    layout(ui, &mut text);
    if text != importing.map.table.text {
        send(out, ImportCommand::SetLayout(text));
        return;
    }
    let mut map = importing.map.clone();
    clock(ui, &mut map, out);
    columns(ui, "columns", &table.columns, &mut map.table);
    reference(ui, inspection, &mut map);
    if map != importing.map {
        send(out, ImportCommand::SetMap(Box::new(map)));
    }
    ui.separator();
    preview(ui, table);
}

/// What is to be decided. A line stays where it is when it is decided, so that nothing below it moves.
fn questions(
    ui: &mut egui::Ui,
    importing: &Importing,
    inspection: &Inspection,
    out: &mut Vec<Command>,
) {
    for (at, (question, said)) in importing.questions.iter().enumerate() {
        let open = question.still_open(&importing.map, &inspection.table.columns);
        let is_answered = open.is_none();
        let color = if is_answered || *said {
            ui.visuals().text_color()
        } else {
            ui.visuals().warn_fg_color
        };
        let text = format!("To decide: {}", open.as_ref().unwrap_or(question));
        let mut decided = is_answered || *said;
        let tick = egui::Checkbox::new(&mut decided, RichText::new(text).color(color));
        let tick = ui.add_enabled(!is_answered, tick);
        let explanation =
            "Ticked by itself once the columns below say it, or by you: it is as you want it";
        if tick.on_hover_text(explanation).changed() {
            send(out, ImportCommand::Decide(at, decided));
        }
    }
}

/// Maps of before that are for files of this shape.
fn remembered(ui: &mut egui::Ui, engine: &Engine, importing: &Importing, out: &mut Vec<Command>) {
    let shape = &importing.map.table.shape;
    let maps = engine.preferences.maps.iter().enumerate();
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
                    item(ui, &mut text.delimiter, delimiter, delimiter.name());
                }
            })
            .response
            .on_hover_text("What stands between the cells of a line");
        let mut comma = text.decimal == Decimal::Comma;
        let tick = ui.checkbox(&mut comma, "decimal comma");
        if tick.on_hover_text("1,5 is one and a half").changed() {
            text.decimal = if comma {
                Decimal::Comma
            } else {
                Decimal::Point
            };
        }
        let label = ui.label("skip lines");
        ui.add(DragValue::new(&mut text.skip_rows).range(0..=100_000))
            .labelled_by(label.id)
            .on_hover_text("Lines before the table, which a logger writes about itself");
        ui.checkbox(&mut text.header, "a line of names")
            .on_hover_text("The first line of the table names its columns");
        ui.checkbox(&mut text.units_row, "a line of units below")
            .on_hover_text("The next line says their units");
    });
}

fn clock(ui: &mut egui::Ui, map: &mut ColumnMap, out: &mut Vec<Command>) {
    ui.horizontal_wrapped(|ui| {
        optional(
            ui,
            [
                "sample rate",
                " Hz",
                "Where no column is the time, or where the time counts samples",
            ],
            100.0,
            &mut map.table.sample_rate_hz,
        );
        optional(
            ui,
            [
                "average bursts within",
                " s",
                "Successive gauge samples no further apart become one, their mean",
            ],
            0.001,
            &mut map.average_bursts_secs,
        );
        optional(
            ui,
            [
                "new recording after a pause of",
                " s",
                "A longer step in time starts a new recording; without a number that is told by the steps themselves",
            ],
            2.0,
            &mut map.gap_secs,
        );
        tare(ui, &mut map.tare);
    });
    weight(ui, map, out);
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
            item(ui, tare, None, "none");
            item(ui, tare, Some(Tare::Auto), "first quiet half second");
            let is_stretch = matches!(tare, Some(Tare::Stretch(..)));
            if ui.selectable_label(is_stretch, "a stretch").clicked() && !is_stretch {
                *tare = Some(Tare::Stretch(0.0, 1.0));
                ui.close();
            }
        })
        .response
        .on_hover_text(
            "The mean gauges there are taken off; whether the sensor was unloaded then, you must know",
        );
    if let Some(Tare::Stretch(from, to)) = tare {
        for (name, value) in [("from", from), ("to", to)] {
            let label = ui.label(name);
            let field = DragValue::new(value)
                .range(0.0..=1e9)
                .speed(0.01)
                .suffix(" s");
            ui.add(field)
                .labelled_by(label.id)
                .on_hover_text("Counted from the recording's first sample");
        }
    }
}

/// A load that is computed from the sensor's pose and a known weight.
fn weight(ui: &mut egui::Ui, map: &mut ColumnMap, out: &mut Vec<Command>) {
    let mut used = map.weight.is_some();
    let tick = ui
        .checkbox(&mut used, "The load is that of a known weight, by the pose columns")
        .on_hover_text(
            "Say which columns are the pose: pose_qw to pose_qz, pose_roll, pose_pitch, pose_yaw, pose_rx to pose_rz or \
             pose_r11 to pose_r33",
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
        if let Some(mass) = &mut weight.mass_kg {
            number(ui, ["mass", " kg", "Of all that hangs on the sensor"], mass);
        }
        if let Some(centre) = &mut weight.centre_m {
            for (name, value) in ["centre x", "centre y", "centre z"].into_iter().zip(centre) {
                let explanation = "The centre of mass, in the sensor's frame";
                number(ui, [name, " m", explanation], value);
            }
        }
        let names = ["gravity x", "gravity y", "gravity z"];
        for (name, value) in names.into_iter().zip(&mut weight.gravity) {
            let explanation = "In the frame that the pose is measured in";
            number(ui, [name, " m/s²", explanation], value);
        }
        ui.radio_value(&mut weight.angles, Angles::FixedXyz, "fixed axes")
            .on_hover_text("Roll, pitch and yaw turn about the axes of the base, in this order");
        ui.radio_value(&mut weight.angles, Angles::IntrinsicXyz, "turned axes")
            .on_hover_text("Each angle turns about an axis that the ones before have turned");
        ui.checkbox(&mut weight.inertia, "inertia").on_hover_text(
            "Adds what accelerating the weight takes, from the pose columns of its position",
        );
        let explanation = "The window over which accelerations are estimated";
        number(
            ui,
            ["smoothed over", " s", explanation],
            &mut weight.smoothing_secs,
        );
        let estimate = ui.button("Find the weight");
        let estimate = estimate.on_hover_text(
            "By least squares, from a recording with its pose and a measured load Fx, Fy, Fz (Mx, My, Mz for the centre)",
        );
        if estimate.clicked() {
            send(out, ImportCommand::FindWeight);
        }
        let add = ui.button("Add a mount");
        let add = add.on_hover_text(
            "One of several weights or places, chosen by the column \"mount\", or by a part of the file's name",
        );
        if add.clicked() {
            weight.mounts.push(Mount {
                name: format!("mount{}", weight.mounts.len() + 1),
                mass_kg: weight.mass_kg,
                centre_m: weight.centre_m,
            });
        }
    });
    let mut at = 0;
    while at < weight.mounts.len() {
        let kept = ui
            .push_id(at, |ui| mount(ui, at + 1, &mut weight.mounts[at]))
            .inner;
        if kept {
            at += 1;
        } else {
            weight.mounts.remove(at);
        }
    }
}

/// A field for a number, with its label.
fn number(ui: &mut egui::Ui, [name, suffix, explanation]: [&str; 3], value: &mut f64) {
    let label = ui.label(name);
    let field = DragValue::new(value)
        .speed(0.001)
        .max_decimals(6)
        .suffix(suffix);
    ui.add(field)
        .labelled_by(label.id)
        .on_hover_text(explanation);
}

/// One of several weights; whether it stays.
fn mount(ui: &mut egui::Ui, nth: usize, mount: &mut Mount) -> bool {
    let mut kept = true;
    ui.horizontal_wrapped(|ui| {
        let label = ui.label(format!("Mount {nth}"));
        let name = TextEdit::singleline(&mut mount.name).desired_width(110.0);
        ui.add(name).labelled_by(label.id).on_hover_text(
            "As the column \"mount\" says it, or as it stands in the names of files",
        );
        let mass = [("mass", " kg", mount.mass_kg.get_or_insert(1.0))];
        let centre = mount.centre_m.get_or_insert([0.0; 3]);
        let centre = ["x", "y", "z"].into_iter().zip(centre);
        let centre = centre.map(|(axis, value)| (axis, " m", value));
        for (what, suffix, value) in mass.into_iter().chain(centre) {
            let explanation = "Of this mount: its mass, and its centre in the sensor's frame";
            number(ui, [what, suffix, explanation], value);
        }
        let close = ui.small_button("×");
        kept = !close.on_hover_text("Takes this mount away").clicked();
    });
    kept
}

/// A tick with a number beside it.
fn optional(
    ui: &mut egui::Ui,
    [name, suffix, explanation]: [&str; 3],
    default: f64,
    value: &mut Option<f64>,
) {
    let mut on = value.is_some();
    let tick = ui.checkbox(&mut on, name).on_hover_text(explanation);
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
        ui.add(field)
            .labelled_by(tick.id)
            .on_hover_text(explanation);
    }
}

/// One row a column: what it is, its name and unit, its sign and scale, what it holds.
fn columns(ui: &mut egui::Ui, id: &str, reports: &[ColumnReport], table: &mut TableMap) {
    let header = Header::new(reports.iter().map(|report| report.header.as_str()));
    let height = 24.0 * (reports.len() as f32 + 1.0) + 14.0;
    egui::ScrollArea::horizontal()
        .id_salt(id)
        .max_height(height)
        .show(ui, |ui| {
            TableBuilder::new(ui)
                .id_salt(id)
                .striped(true)
                .vscroll(false)
                .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
                .column(Column::exact(28.0))
                .column(Column::initial(130.0).clip(true).resizable(true))
                .column(Column::exact(130.0))
                .columns(Column::exact(76.0), 2)
                .column(Column::exact(64.0))
                .column(Column::exact(80.0))
                .column(Column::remainder().at_least(160.0).clip(true))
                .header(20.0, |mut titles| {
                    for (title, explanation) in [
                        ("", "The number of the column"),
                        ("Header", "As the file writes it"),
                        ("Is", "What it is; what nobody looks at is ignored"),
                        ("Name", NAME),
                        ("Unit", UNIT),
                        ("Times", TIMES),
                        ("No value", NO_VALUE),
                        ("First values, range", "By the first rows"),
                    ] {
                        titles.col(|ui| {
                            ui.strong(title).on_hover_text(explanation);
                        });
                    }
                })
                .body(|body| {
                    body.rows(24.0, reports.len(), |mut row| {
                        let report = &reports[row.index()];
                        let mut rule = rule_of(table, &header, report);
                        let before = rule.clone();
                        column_row(&mut row, id, report, &mut rule);
                        if rule != before {
                            set_rule(table, &header, report, rule);
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
        ui.label(&report.header);
    });
    row.col(|ui| {
        let choice = ComboBox::from_id_salt((id, number))
            .selected_text(rule.is.name())
            .width(112.0)
            .show_ui(ui, |ui| {
                for role in ColumnRole::ALL {
                    item(ui, &mut rule.is, role, role.name());
                }
            });
        (choice.response.on_hover_text("What the column holds")).widget_info(|| {
            let name = format!("Column {number} is {}", rule.is.name());
            egui::WidgetInfo::labeled(egui::Role::ComboBox, true, name)
        });
    });
    let used = rule.is != ColumnRole::Ignore;
    let unit = report.unit.as_deref().unwrap_or("");
    for (what, text, hint, explanation) in [
        ("name", &mut rule.name, "", NAME),
        ("unit", &mut rule.unit, unit, UNIT),
    ] {
        row.col(|ui| {
            let name = format!("{what} of column {number}");
            text_cell(ui, used, [&name, hint, explanation], text);
        });
    }
    row.col(|ui| {
        ui.add_enabled(
            used,
            DragValue::new(&mut rule.scale).speed(0.01).max_decimals(9),
        )
        .on_hover_text(TIMES)
        .widget_info(|| label(&format!("scale of column {number}")));
    });
    row.col(|ui| {
        let mut text = rule.dropouts.first().map(f64::to_string);
        let name = format!("no value in column {number}");
        text_cell(ui, used, [&name, "none", NO_VALUE], &mut text);
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

fn text_cell(
    ui: &mut egui::Ui,
    used: bool,
    [name, hint, explanation]: [&str; 3],
    text: &mut Option<String>,
) {
    let mut written = text.clone().unwrap_or_default();
    let field = TextEdit::singleline(&mut written)
        .hint_text(hint)
        .desired_width(f32::INFINITY);
    let response = ui.add_enabled(used, field).on_hover_text(explanation);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, used, name));
    if response.changed() {
        *text = (!written.trim().is_empty()).then_some(written);
    }
}

/// Whether a rule speaks of a column of the file.
fn is_of(rule: &ColumnRule, header: &Header, report: &ColumnReport) -> bool {
    header.index(&rule.column) == Ok(report.number - 1)
}

fn rule_of(table: &TableMap, header: &Header, report: &ColumnReport) -> ColumnRule {
    let rule = table
        .columns
        .iter()
        .find(|rule| is_of(rule, header, report))
        .cloned();
    rule.unwrap_or_else(|| ColumnRule::new(ColumnKey::Number(report.number), ColumnRole::Ignore))
}

/// Makes this the only rule of its column, in its place or in the order of the columns.
fn set_rule(table: &mut TableMap, header: &Header, report: &ColumnReport, rule: ColumnRule) {
    let is_it = |rule: &ColumnRule| is_of(rule, header, report);
    let is_after = |rule: &ColumnRule| {
        let index = header.index(&rule.column);
        index.is_ok_and(|index| index >= report.number)
    };
    let rules = &mut table.columns;
    let at = rules.iter().position(is_it);
    rules.retain(|rule| !is_it(rule));
    if rule.is != ColumnRole::Ignore {
        let at = at.or_else(|| rules.iter().position(is_after));
        rules.insert(at.unwrap_or(rules.len()), rule);
    }
}

/// A reference on its own clock: in a file of its own, and how it is joined.
fn reference(ui: &mut egui::Ui, inspection: &Inspection, map: &mut ColumnMap) {
    let mut own_file = map.reference.is_some();
    let tick = ui.checkbox(
        &mut own_file,
        "The reference load stands in a file of its own",
    );
    let tick = tick.on_hover_text("Two loggers, two clocks: the times of both files are joined");
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
            ui.add(field).labelled_by(label.id).on_hover_text(
                "Seen from the folder of the file with the gauges; {stem} is that file's name without its ending",
            );
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
        for (method, label, explanation) in [
            (
                JoinMethod::Interpolate,
                "interpolate",
                "On the straight line between two samples",
            ),
            (
                JoinMethod::Nearest,
                "take the nearest",
                "The sample whose time is nearest",
            ),
            (
                JoinMethod::Hold,
                "hold the last",
                "The last sample, until the next one comes",
            ),
        ] {
            ui.radio_value(&mut map.join.method, method, label)
                .on_hover_text(explanation);
        }
        let explanation = "By how much the reference's clock is behind that of the gauges";
        number(
            ui,
            ["add to the reference's times", " s", explanation],
            &mut map.join.clock_offset_secs,
        );
    });
    if let Some(offset) = inspection.check.clock_offset {
        ui.horizontal_wrapped(|ui| {
            ui.label(format!(
                "By cross-correlation the reference seems to need {} s; it is added only if you take it.",
                significant(offset.offset_secs, 4)
            ));
            let take = ui.button("Take it");
            let take = take.on_hover_text("Adds it to the reference's times");
            if take.clicked() {
                map.join.clock_offset_secs = offset.offset_secs;
            }
        });
    }
}

fn preview(ui: &mut egui::Ui, table: &TableReport) {
    ui.horizontal(|ui| {
        ui.strong("First rows");
        let copy = ui.small_button("Copy rows");
        if copy.on_hover_text("As tab-separated text").clicked() {
            let rows = table.preview.iter().map(|row| row.join("\t"));
            ui.copy_text(rows.collect::<Vec<_>>().join("\n"));
        }
    });
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
        let load = ui.add_enabled(can_load, egui::Button::new("Load it"));
        let load =
            load.on_hover_text("Reads the whole file so, and remembers it for files of this shape");
        if load.clicked() {
            send(out, ImportCommand::Load);
        }
        let cancel = ui.button("Cancel import");
        let cancel = cancel.on_hover_text("Nothing is loaded, nothing is lost");
        if cancel.clicked() {
            send(out, ImportCommand::Cancel);
        }
        if !importing.waiting.is_empty() {
            let cancel = ui.button("Cancel all");
            let explanation = "None of the files that want a map is loaded";
            if cancel.on_hover_text(explanation).clicked() {
                send(out, ImportCommand::CancelAll);
            }
        }
        ui.separator();
        let label = ui.label("Column map");
        let field = TextEdit::singleline(&mut fields.map_path).desired_width(160.0);
        ui.add(field)
            .labelled_by(label.id)
            .on_hover_text("A JSON file that says all of this for files of this shape");
        let path = fields.map_path.trim().to_owned();
        let write = ui
            .button("Write map")
            .on_hover_text("For --columns on the command line");
        if write.clicked() && !path.is_empty() {
            send(out, ImportCommand::WriteMap(path.clone().into()));
        }
        let read = ui.button("Read map");
        let read = read.on_hover_text("Takes what the file says");
        if read.clicked() && !path.is_empty() {
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
