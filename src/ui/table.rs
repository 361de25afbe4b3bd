//! Draws tables of the report. The hover text of a cell explains its value.

use egui::{Response, RichText, Role, Ui, WidgetInfo};

use crate::{
    engine::FileContent,
    report::{Table, Value},
    ui::{
        command::{Command, Out, PathFor},
        controls::Controls as _,
        numbers::elided,
    },
};

const NUMBER_WIDTH: f32 = 38.0;
/// Number of characters above which the words in a cell are shortened in a narrow pane.
const MAX_WORDS: usize = 34;

/// Draws a table. The title is above the first column.
pub fn show(ui: &mut Ui, table: &Table) {
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
                // The group above the columns names their unit.
                let is_grouped = column.group.is_some();
                let name = if is_grouped { column.name.clone() } else { column.title() };
                let mut name = RichText::new(name);
                if let Some(trace) = column.trace {
                    name = name.color(trace.color(ui.visuals()));
                }
                explained(ui, name, &column.about);
            }
            ui.end_row();
            for row in 0..table.rows.len() {
                for column in 0..table.columns.len() {
                    show_cell(ui, table, [row, column], false);
                }
                ui.end_row();
            }
        });
    if !table.note.is_empty() {
        ui.vertical(|ui| {
            // A wide table extends beyond the pane, but its note does not.
            ui.set_max_width(ui.clip_rect().width());
            ui.weak(&table.note);
        });
    }
}

/// Draws the buttons that copy a table and save it. `holds` is the hover text about the file; `text` returns the text for the
/// clipboard, `content` the contents of the file, or `None` while there is no table.
pub fn saving(
    ui: &mut Ui,
    holds: &str,
    text: impl FnOnce() -> String,
    content: Option<impl FnOnce() -> FileContent>,
    out: &mut Out,
) {
    ui.add_enabled_ui(content.is_some(), |ui| {
        ui.copies("table", text);
        if ui.press("Save as…", holds)
            && let Some(content) = content
        {
            out.send(Command::Choose(PathFor::Save(content())));
        }
    });
}

/// Draws a table whose `lead` draws the first `n_led` cells of each row, after one more cell without a head.
pub fn show_led(ui: &mut Ui, table: &Table, n_led: usize, lead: &mut dyn FnMut(&mut Ui, usize)) {
    egui::Grid::new(("led", &table.title))
        .striped(true)
        .min_col_width(12.0)
        .spacing([10.0, 3.0])
        .show(ui, |ui| {
            ui.label("");
            for column in &table.columns {
                explained(ui, RichText::new(column.title()).strong(), &column.about);
            }
            ui.end_row();
            for at in 0..table.rows.len() {
                lead(ui, at);
                for column in n_led..table.columns.len() {
                    show_cell(ui, table, [at, column], true);
                }
                ui.end_row();
            }
        });
}

fn show_cell(ui: &mut Ui, table: &Table, [row, at]: [usize; 2], is_narrow: bool) {
    let (column, cell) = (&table.columns[at], &table.rows[row][at]);
    let text = RichText::new(&cell.text);
    let label = match cell.value {
        Value::Number(_) if !cell.about.is_empty() => {
            let group = column.group.as_ref().map_or("", |(name, _)| name);
            explained(ui, text, &format!("{group} {}\n{}", column.name, cell.about))
        }
        Value::Missing => explained(ui, text.small().weak(), &cell.about),
        Value::Words if is_narrow && cell.text.chars().count() > MAX_WORDS => {
            let about = format!("{}\n{}", cell.text, cell.about);
            explained(ui, RichText::new(elided(&cell.text, MAX_WORDS)), about.trim())
        }
        _ => explained(ui, text, &cell.about),
    };
    if matches!(cell.value, Value::Number(_) | Value::Missing) {
        say(&label, || table.spoken(row, at));
    }
}

/// Sets the text of a cell for screen readers. A number alone would not name its row and column.
pub fn say(cell: &Response, sentence: impl Fn() -> String) {
    cell.widget_info(|| WidgetInfo::labeled(Role::Label, cell.enabled(), sentence()));
}

/// Draws the title, and the name of each group of columns above its first column.
fn groups(ui: &mut Ui, table: &Table) {
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

fn explained(ui: &mut Ui, text: RichText, about: &str) -> Response {
    let label = ui.label(text);
    if about.is_empty() { label } else { label.on_hover_text(about) }
}

pub fn joined(tables: &[Table]) -> String {
    let texts: Vec<String> = tables.iter().map(Table::tab_separated).collect();
    texts.join("\n\n")
}
