//! Import page: the text layout of a file, the role of each column, and a preview of the rows. The page edits a column map,
//! and shows how the file is read with this map.

mod columns;
mod foot;
mod reference;
mod settings;
mod weight;

use egui::Ui;

use crate::{
    engine::{Engine, ImportCommand, Importing},
    formats,
    import::inspect::{Inspection, TableReport},
    ui::{command::Out, controls::Controls as _, status_line::busy},
};

#[derive(Debug)]
pub struct ImportFields {
    map_path: String,
    /// True if a text field had the focus in the previous frame. Escape removes the focus before this frame is drawn.
    is_typing: bool,
}

impl Default for ImportFields {
    fn default() -> Self {
        Self { map_path: "columns.json".to_owned(), is_typing: false }
    }
}

/// Draws the import page in the place of the panes.
pub fn import_page(
    ui: &mut Ui,
    engine: &Engine,
    fields: &mut ImportFields,
    is_covered: bool,
    out: &mut Out,
) {
    let Some(importing) = &engine.importing else {
        return;
    };
    let context = &ui.ctx().clone();
    // Escape first closes an open list or the help, or ends typing, and only then closes the import page.
    let ends_by_key = !is_covered
        && !egui::Popup::is_any_open(context)
        && context.memory(|memory| memory.top_modal_layer().is_none())
        && !fields.is_typing
        && context.input(|input| input.key_pressed(egui::Key::Escape));
    let name = importing.path.file_name().unwrap_or_default().to_string_lossy();
    egui::Frame::NONE.inner_margin(egui::Margin::symmetric(12, 8)).show(ui, |ui| {
        ui.label(egui::RichText::new(format!("Import {name}")).strong().size(15.0));
        if let Some(problem) = &importing.problem {
            ui.fail(problem);
        }
        let Some(inspection) = importing.inspection.as_deref() else {
            if importing.problem.is_none() {
                busy(ui);
            }
            return;
        };
        egui::Panel::bottom("import foot")
            .show(ui, |ui| foot::foot(ui, importing, inspection, fields, out));
        egui::CentralPanel::no_frame().show(ui, |ui| {
            egui::ScrollArea::vertical()
                .auto_shrink([false, false])
                .show(ui, |ui| body(ui, engine, importing, inspection, out));
        });
    });
    fields.is_typing = context.text_edit_focused();
    if ends_by_key {
        out.send(ImportCommand::CancelAll);
    }
}

fn body(
    ui: &mut Ui,
    engine: &Engine,
    importing: &Importing,
    inspection: &Inspection,
    out: &mut Out,
) {
    let table = &inspection.table;
    let read = format!("Formats that can be read: {}", formats::listed());
    ui.label(format!("{}: {table}", importing.path.display())).on_hover_text(read);
    match importing.waiting.len() {
        0 => {}
        1 => drop(
            ui.label("1 more file needs a column map. If it has the same columns, it is loaded with this map"),
        ),
        n => drop(ui.label(format!(
            "{n} more files need a column map. Files with the same columns are loaded with this map"
        ))),
    }
    questions(ui, importing, inspection);
    remembered(ui, engine, importing, out);
    ui.separator();
    let mut text = importing.map.table.text.clone();
    settings::layout(ui, &mut text);
    settings::parts(ui, &table.parts, &mut text);
    if text != importing.map.table.text {
        out.send(ImportCommand::SetLayout(text));
        return;
    }
    let mut map = importing.map.clone();
    settings::clock(ui, &mut map);
    weight::weight(ui, &mut map, out);
    columns::columns(ui, "columns", &table.columns, &mut map.table);
    reference::reference(ui, inspection, &mut map);
    if map != importing.map {
        out.send(ImportCommand::SetMap(Box::new(map)));
    }
    ui.separator();
    preview(ui, table);
}

/// Draws the questions about the columns that the present roles leave open. Answered questions stay visible, so that the
/// controls below do not move.
fn questions(ui: &mut Ui, importing: &Importing, inspection: &Inspection) {
    let columns = &inspection.table.columns;
    for question in &importing.questions {
        let mut is_answered = !question.is_open(&importing.map, columns);
        let text = format!("Question: {}", question.text(columns));
        let tick = egui::Checkbox::new(&mut is_answered, text);
        ui.add_enabled(false, tick).on_disabled_hover_text(
            "Ticked once the roles of the columns below answer the question. The file can be loaded without an answer",
        );
    }
}

fn remembered(ui: &mut Ui, engine: &Engine, importing: &Importing, out: &mut Out) {
    let shape = &importing.map.table.shape;
    let maps = engine.preferences.maps.iter().enumerate();
    let fitting = maps.filter(|(_, map)| map.table.shape == *shape && **map != importing.map);
    ui.horizontal_wrapped(|ui| {
        if ui.press(
            "Detect again",
            "Detects the roles of the columns from the file again, and replaces the column map",
        ) {
            out.send(ImportCommand::Begin);
        }
        for (at, _) in fitting {
            if ui.press(
                "Map of the last similar file",
                "Uses the column map of the last file with the same columns",
            ) {
                out.send(ImportCommand::TakeMap(at));
            }
        }
    });
}

fn preview(ui: &mut Ui, table: &TableReport) {
    ui.horizontal(|ui| {
        ui.strong("First rows");
        if ui.press_small("Copy rows", "Copies the rows as tab-separated text") {
            let rows = table.preview.iter().map(|row| row.join("\t"));
            ui.copy_text(rows.collect::<Vec<_>>().join("\n"));
        }
    });
    egui::ScrollArea::horizontal().id_salt("preview").show(ui, |ui| {
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
