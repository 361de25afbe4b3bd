//! A table of the report in the window: what one points at explains itself.

use egui::RichText;

use crate::report::{Column, Table, Value};

/// Columns of numbers are at least this wide.
const NUMBER_WIDTH: f32 = 38.0;

/// Draws a table, its title in place of the first column's group.
pub fn show(ui: &mut egui::Ui, table: &Table) {
    egui::Grid::new(&table.title)
        .striped(true)
        .min_col_width(NUMBER_WIDTH)
        .spacing([10.0, 3.0])
        .show(ui, |ui| {
            if !table.title.is_empty() || table.columns.iter().any(|column| column.group.is_some())
            {
                groups(ui, table);
            }
            for column in &table.columns {
                let name = RichText::new(&column.name);
                let name = match column.trace {
                    Some(trace) => name.color(trace.color(ui.visuals())),
                    None => name,
                };
                explained(ui, name, &column.about);
            }
            ui.end_row();
            for row in &table.rows {
                for (column, cell) in table.columns.iter().zip(row) {
                    match cell.value {
                        Value::Number(_) => {
                            explained(ui, RichText::new(&cell.text), &whole(column, &cell.about))
                        }
                        Value::Missing => {
                            explained(ui, RichText::new(&cell.text).small().weak(), &cell.about)
                        }
                        Value::Words | Value::Continued => {
                            explained(ui, RichText::new(&cell.text), &cell.about)
                        }
                    }
                }
                ui.end_row();
            }
        });
    if !table.note.is_empty() {
        ui.weak(&table.note);
    }
}

/// The title, then each group over its first column.
fn groups(ui: &mut egui::Ui, table: &Table) {
    ui.strong(&table.title);
    let mut before = None;
    for column in table.columns.iter().skip(1) {
        let group = column.group.as_ref();
        let (name, about) = group
            .filter(|group| before != Some(*group))
            .map_or(("", ""), |(name, about)| (name, about));
        before = group;
        explained(ui, RichText::new(name).strong(), about);
    }
    ui.end_row();
}

/// What there is to know about a number, below which column it is of.
fn whole(column: &Column, about: &str) -> String {
    match about {
        "" => String::new(),
        about => {
            let group = column.group.as_ref().map_or("", |(name, _)| name);
            format!("{group} {}\n{about}", column.name)
        }
    }
}

fn explained(ui: &mut egui::Ui, text: RichText, about: &str) {
    let label = ui.label(text);
    if !about.is_empty() {
        label.on_hover_text(about);
    }
}
