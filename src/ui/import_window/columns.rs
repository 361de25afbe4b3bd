//! Rows of the import table, one for each column of the file: its values over time, role, name, unit, range and question.

use std::collections::BTreeSet;

use egui::{ComboBox, DragValue, Key, Modifiers, Role, TextEdit, Ui};
use egui_extras::{Column, TableBuilder};

use super::Open;
use crate::{
    formats::text::times::TIME_SPELLINGS,
    import::{
        inspect::{ColumnReport, Question},
        map::{ColumnRole, ColumnRule, Header, TableMap},
    },
    min_max::MinMax,
    recording::{
        Axis,
        units::{FORCE_UNITS, MOMENT_UNITS},
    },
    ui::{
        choice::named_choice,
        controls::{Controls as _, named},
        numbers::significant,
        small_plot::SmallPlot,
    },
};

const NAME: &str = "Name of a gauge or an auxiliary channel. Without an entry, the name is taken from the header, or is S1, S2, …";
const SCALE: &str =
    "Factor by which the values of the column are multiplied; -1 changes their sign";
const SELECT: &str = "Name of the column in the header of the file. A click selects a row, with Ctrl or Shift further rows; a role chosen for one of them applies to all";
const MISSING: &str = "A number in the column that stands for a missing value";

/// Height of the list of roles (points). The most frequent roles are visible without scrolling.
const LIST_HEIGHT: f32 = 320.0;
const ROW_HEIGHT: f32 = 40.0;
/// Widths of the plot of a channel (points): in a window at least as wide as the second number, and in a narrower one.
const PLOT_WIDTHS: (f32, f32, f32) = (320.0, 1400.0, 200.0);

/// Draws one row for each channel of the file: name, values over the whole file, role, name, unit, range, question.
pub fn columns(
    ui: &mut Ui,
    id: &str,
    reports: &[ColumnReport],
    table: &mut TableMap,
    open: Option<Open<'_>>,
) {
    let header = Header::new(reports.iter().map(|report| report.header.as_str()));
    // If no column has a name in the header, the column with the names is narrow.
    let has_names = reports.iter().any(|report| !report.header.is_empty());
    let header_width = if has_names { 150.0 } else { 60.0 };
    let mut selection: Selection =
        ui.data(|data| data.get_temp(selection_id(id))).unwrap_or_default();
    selection.rows.retain(|row| *row < reports.len());
    let before_frame = selection.clone();
    role_by_key(ui, (table, &header), reports, &selection);
    let (wide, least, narrow) = PLOT_WIDTHS;
    let plot_width = if ui.available_width() >= least { wide } else { narrow };
    let height = ROW_HEIGHT * (reports.len() as f32 + 1.0) + 14.0;
    egui::ScrollArea::horizontal()
        .id_salt(id)
        .max_height(height)
        .show(ui, |ui| {
            TableBuilder::new(ui)
                .id_salt(id)
                .striped(true)
                .vscroll(false)
                .sense(egui::Sense::click())
                .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
                .column(Column::exact(26.0))
                .column(Column::initial(header_width).clip(true).resizable(true))
                .column(Column::exact(plot_width))
                .column(Column::exact(130.0))
                .columns(Column::exact(84.0), 2)
                .column(Column::exact(28.0))
                .column(Column::exact(160.0).clip(true))
                .column(Column::remainder().at_least(160.0).clip(true))
                .header(20.0, |mut titles| {
                    for (title, explanation) in [
                        ("", "Number of the column in the file"),
                        ("Channel", SELECT),
                        ("Values over time", "Values in rows from the whole file"),
                        ("Role", "Role of the channel. Ignored channels are not loaded. A change applies to all selected rows"),
                        ("As", NAME),
                        ("Unit", &units()),
                        ("", ""),
                        ("Range", "Smallest and largest value in rows from the whole file"),
                        ("Question", "What neither the name nor the values say. The file can be loaded without an answer"),
                    ] {
                        titles.col(|ui| {
                            ui.weak(title).on_hover_text(explanation);
                        });
                    }
                })
                .body(|body| {
                    body.rows(ROW_HEIGHT, reports.len(), |mut row| {
                        let report = &reports[row.index()];
                        let mut rule = table.rule(&header, report.number - 1);
                        let before = rule.clone();
                        row.set_selected(selection.rows.contains(&row.index()));
                        let alike = reports.iter().filter(|other| other.header == report.header);
                        let name = match (report.header.as_str(), alike.count()) {
                            ("", _) => format!("column {}", report.number),
                            (header, 1) => format!("column {header}"),
                            (header, _) => format!("column {}, {header}", report.number),
                        };
                        let at = row.index();
                        column_row(&mut row, id, (&name, report), &mut rule);
                        row.col(|ui| question(ui, (report, reports), open, &mut rule));
                        let response = row.response();
                        if response.clicked() {
                            selection.click(at, response.ctx.input(|input| input.modifiers));
                        }
                        if rule.is != before.is && selection.rows.contains(&at) {
                            let numbers = selection.rows.iter().map(|&row| reports[row].number);
                            set_all(table, &header, numbers, rule.is);
                        } else if rule != before {
                            table.set_rule(&header, report.number - 1, rule);
                        }
                    });
                });
        });
    if selection != before_frame {
        ui.data_mut(|data| data.insert_temp(selection_id(id), selection));
    }
}

/// Gives the selected rows the role whose letter was pressed.
fn role_by_key(
    ui: &mut Ui,
    (table, header): (&mut TableMap, &Header<'_>),
    reports: &[ColumnReport],
    selection: &Selection,
) {
    if selection.rows.is_empty() || ui.ctx().text_edit_focused() {
        return;
    }
    let first_load = if selection.rows.len() > 1 { Axis::Fx } else { Axis::Fz };
    let roles = [
        (Key::T, ColumnRole::Time),
        (Key::G, ColumnRole::Gauge),
        (Key::L, ColumnRole::Load(first_load)),
        (Key::C, ColumnRole::Auxiliary),
        (Key::I, ColumnRole::Ignore),
    ];
    for (key, role) in roles {
        if ui.input_mut(|input| input.consume_key(Modifiers::NONE, key)) {
            let numbers = selection.rows.iter().map(|&row| reports[row].number);
            set_all(table, header, numbers, role);
        }
    }
}

/// Draws the first open question about a channel, with a button for each answer.
fn question(
    ui: &mut Ui,
    (report, reports): (&ColumnReport, &[ColumnReport]),
    open: Option<Open<'_>>,
    rule: &mut ColumnRule,
) {
    let Some(Open { questions, map }) = open else { return };
    let is_asked = |question: &&Question| {
        question.columns.contains(&report.number) && question.is_open(map, reports)
    };
    let Some(question) = questions.iter().find(is_asked) else { return };
    ui.warn(question.short()).on_hover_text(question.text(reports));
    for (label, role, unit) in question.choices(report) {
        let about = format!("{}: {}", question.short(), role.label());
        if ui.press_small(label, about) {
            rule.is = role;
            rule.unit = unit.or(rule.unit.take());
        }
    }
}

fn selection_id(table: &str) -> egui::Id {
    egui::Id::unique(("selected columns", table))
}

#[derive(Clone, Debug, Default, PartialEq)]
struct Selection {
    rows: BTreeSet<usize>,
    anchor: usize,
}

impl Selection {
    /// Changes the selection after a click on a row. Without a modifier the click selects one row. With Ctrl the click adds
    /// or removes the row, with Shift it selects all rows from the previous click to this one.
    fn click(&mut self, row: usize, modifiers: egui::Modifiers) {
        if modifiers.shift {
            let (first, last) = (self.anchor.min(row), self.anchor.max(row));
            self.rows = (first..=last).collect();
            return;
        }
        self.anchor = row;
        if modifiers.command {
            if !self.rows.remove(&row) {
                self.rows.insert(row);
            }
        } else {
            let one = BTreeSet::from([row]);
            self.rows = if self.rows == one { BTreeSet::new() } else { one };
        }
    }
}

/// Gives all columns in `numbers` the same role. If the role is a load axis, the first column gets this axis and the
/// following columns get the following axes.
fn set_all(
    table: &mut TableMap,
    header: &Header<'_>,
    numbers: impl Iterator<Item = usize>,
    role: ColumnRole,
) {
    let following: Vec<ColumnRole> = match role {
        ColumnRole::Load(first) => {
            let axes = Axis::ALL.into_iter().skip_while(|axis| *axis != first);
            axes.map(ColumnRole::Load).collect()
        }
        _ => Vec::new(),
    };
    for (at, number) in numbers.enumerate() {
        let mut rule = table.rule(header, number - 1);
        rule.is = following.get(at).copied().unwrap_or(role);
        table.set_rule(header, number - 1, rule);
    }
}

fn units() -> String {
    format!(
        "Unit of the column. For loads {FORCE_UNITS}, {MOMENT_UNITS}; for times {TIME_SPELLINGS}; for gauges any text"
    )
}

fn column_row(
    row: &mut egui_extras::TableRow<'_, '_>,
    id: &str,
    (column, report): (&str, &ColumnReport),
    rule: &mut ColumnRule,
) {
    let number = report.number;
    row.col(|ui| {
        ui.weak(number.to_string());
    });
    row.col(|ui| {
        // The text of the header is not selectable, so that a click on it selects the row.
        let name = egui::Label::new(&report.header).selectable(false).truncate();
        let first = report.first.join("  ");
        ui.add(name).on_hover_text(format!("{}\nFirst values: {first}", report.header));
    });
    row.col(|ui| outline(ui, &report.outline, rule.is != ColumnRole::Ignore));
    row.col(|ui| {
        let button = ComboBox::from_id_salt((id, number)).width(112.0).height(LIST_HEIGHT);
        let described = |role: ColumnRole| (role.label(), "");
        let name = format!("Role of {column}");
        named_choice(ui, (button, &name), &mut rule.is, ColumnRole::all(), described)
            .on_hover_text("Role of the column");
    });
    let used = rule.is != ColumnRole::Ignore;
    let unit = report.unit.as_deref().unwrap_or("");
    for (what, text, hint, explanation) in
        [("name", &mut rule.name, "", NAME), ("unit", &mut rule.unit, unit, &units())]
    {
        row.col(|ui| {
            let name = format!("{what} of {column}");
            text_cell(ui, used, [&name, hint, explanation], text);
        });
    }
    row.col(|ui| {
        let button = ui.menu_of_fields(egui::Button::new("…"), |ui| {
            ui.reset_style(); // fields, not menu items
            more(ui, column, used, rule);
        });
        let button = button.on_hover_text("Scale factor and missing value");
        named(&button, Role::Button, &format!("more about {column}"));
    });
    row.col(|ui| {
        let range = match (report.min, report.max) {
            (Some(min), Some(max)) => range(min, max),
            _ => report.content.name().to_owned(),
        };
        ui.weak(range);
    });
}

/// Returns the range of a channel, with as many digits as tell its ends apart: time stamps differ in their last digits.
fn range(min: f64, max: f64) -> String {
    let alike = (min.abs().max(max.abs()) / (max - min)).log10();
    let digits = if alike.is_finite() { 4 + alike.max(0.0) as usize } else { 4 };
    format!("{} … {}", significant(min, digits), significant(max, digits)).replace('-', "−")
}

/// Draws the rarely used settings of a channel.
fn more(ui: &mut Ui, column: &str, used: bool, rule: &mut ColumnRule) {
    ui.horizontal(|ui| {
        ui.label("Scale factor").on_hover_text(SCALE);
        let scale = DragValue::new(&mut rule.scale).speed(0.01).max_decimals(9);
        let scale = ui.add_enabled(used, scale).on_hover_text(SCALE);
        named(&scale, Role::SpinButton, &format!("scale factor of {column}"));
    });
    ui.horizontal(|ui| {
        ui.label("Missing value").on_hover_text(MISSING);
        let mut text = rule.dropouts.first().map(f64::to_string);
        let name = format!("missing value of {column}");
        text_cell(ui, used, [&name, "none", MISSING], &mut text);
        let written = text.unwrap_or_default();
        if written.trim().is_empty() {
            rule.dropouts.clear();
        } else if let Ok(value) = written.trim().parse::<f64>() {
            rule.dropouts = vec![value];
        }
    });
}

/// Draws values at evenly spaced rows of the file as a line.
fn outline(ui: &mut Ui, values: &[f32], is_used: bool) {
    let size = egui::vec2(ui.available_width(), ROW_HEIGHT - 8.0);
    let (place, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    let values = || values.iter().map(|value| f64::from(*value));
    let range: MinMax = values().filter(|value| value.is_finite()).collect();
    let up = range.ends().unwrap_or_default();
    let plot = SmallPlot::new(ui, place, (0.0, values().len() as f64), up);
    let color = if is_used { ui.visuals().text_color() } else { ui.visuals().weak_text_color() };
    let points = values().enumerate().map(|(at, value)| [at as f64 + 0.5, value]);
    plot.line(points, egui::Stroke::new(1.0, color));
}

fn text_cell(
    ui: &mut Ui,
    used: bool,
    [name, hint, explanation]: [&str; 3],
    text: &mut Option<String>,
) {
    let mut written = text.clone().unwrap_or_default();
    let field = TextEdit::singleline(&mut written).hint_text(hint).desired_width(f32::INFINITY);
    let response = ui.add_enabled(used, field).on_hover_text(explanation);
    named(&response, Role::TextInput, name);
    if response.changed() {
        *text = (!written.trim().is_empty()).then_some(written);
    }
}
