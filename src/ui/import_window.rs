//! Import page: a row for each channel of a file with its values over time, its role, name and unit, and the questions about
//! it. The page edits a column map, and shows how the file is read with this map.

mod columns;
mod foot;
mod reference;
mod settings;
mod weight;

use egui::Ui;

use crate::{
    engine::{Engine, ImportCommand, Importing},
    formats,
    import::{
        inspect::{Inspection, Question, TableReport},
        map::ColumnMap,
    },
    shown::counted,
    ui::{command::Out, controls::Controls as _, status_line::busy},
};

/// Width of the settings of the text (points).
const READ_AS_WIDTH: f32 = 760.0;

/// Draws the import page in the place of the panes. `was_typing` is true if a text field had the focus in the previous frame,
/// because Escape removes the focus before this frame is drawn.
pub fn import_page(
    ui: &mut Ui,
    engine: &Engine,
    was_typing: &mut bool,
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
        && !*was_typing
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
            .show(ui, |ui| foot::foot(ui, importing, inspection, out));
        egui::CentralPanel::no_frame().show(ui, |ui| {
            egui::ScrollArea::vertical()
                .auto_shrink([false, false])
                .show(ui, |ui| body(ui, importing, inspection, out));
        });
    });
    *was_typing = context.text_edit_focused();
    if ends_by_key {
        out.send(ImportCommand::CancelAll);
    }
}

fn body(ui: &mut Ui, importing: &Importing, inspection: &Inspection, out: &mut Out) {
    let table = &inspection.table;
    let read = format!("Formats that can be read: {}", formats::listed());
    ui.horizontal(|ui| {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            read_as(ui, importing, inspection, out);
            let about =
                "Detects the roles of the columns from the file again, and replaces the column map";
            if ui.press("Detect again", about) {
                out.send(ImportCommand::Begin);
            }
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                let path = format!("{}: {table}", importing.path.display());
                ui.add(egui::Label::new(&path).truncate()).on_hover_text(format!("{path}\n{read}"));
            });
        });
    });
    if !importing.waiting.is_empty() {
        let n = importing.waiting.len();
        let needs = if n == 1 { "needs" } else { "need" };
        ui.label(format!(
            "{} {needs} a column map. Files with the same columns are loaded with this map",
            counted(n, "more file"),
        ));
    }
    let mut map = importing.map.clone();
    let questions = Open { questions: &importing.questions, map: &importing.map };
    columns::columns(ui, "columns", &table.columns, &mut map.table, Some(questions));
    reference::reference(ui, inspection, &mut map);
    weight::weight(ui, &mut map, out);
    if map != importing.map {
        out.send(ImportCommand::SetMap(Box::new(map)));
    }
}

/// Questions about the columns, and the column map that answers some of them.
#[derive(Clone, Copy)]
struct Open<'a> {
    questions: &'a [Question],
    map: &'a ColumnMap,
}

/// Draws the button that opens the settings of the text, of the clock and of the pauses, and the first rows of the file.
fn read_as(ui: &mut Ui, importing: &Importing, inspection: &Inspection, out: &mut Out) {
    let text = &importing.map.table.text;
    let header = if text.header { "header" } else { "no header" };
    let label = match inspection.table.kind {
        Some(kind) => format!("Read as: {kind}…"),
        None => format!("Read as: {}, {header}…", text.delimiter.name()),
    };
    let button = ui.menu_of_fields(egui::Button::new(label), |ui| {
        ui.reset_style(); // fields, not menu items
        ui.set_max_width(READ_AS_WIDTH);
        let mut text = text.clone();
        settings::layout(ui, &mut text);
        settings::parts(ui, &inspection.table.parts, &mut text);
        if text != importing.map.table.text {
            out.send(ImportCommand::SetLayout(text));
            return;
        }
        let mut map = importing.map.clone();
        settings::clock(ui, &mut map);
        if map != importing.map {
            out.send(ImportCommand::SetMap(Box::new(map)));
        }
        ui.separator();
        preview(ui, &inspection.table);
    });
    button.on_hover_text(
        "How the text is divided, its times and pauses, the tare, and the first rows",
    );
}

fn preview(ui: &mut Ui, table: &TableReport) {
    ui.strong("First rows");
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
