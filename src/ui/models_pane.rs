//! Pane with the list of tried models. The user can search for models, sort the list, keep models and apply them.

use std::time::Duration;

use egui::{RichText, Ui};

use crate::{
    engine::{Action, Engine, FileContent, Row, SEARCH_MINUTES},
    questions::{Candidates, RELATIVE},
    report::Table,
    scoring::score_set::ScoreSet,
    ui::{
        command::{Command, Out},
        controls::Controls as _,
        numbers::elided,
        pane::{Cx, PaneView},
        table,
    },
};

const MOST_MINUTES: f64 = 10_000.0;
/// Columns that only the saved list has; the hover text of a model's name describes its features and its regressor.
const SAVED_ONLY: [&str; 5] = ["features", "regressor", "cross-validation", "data", "trial time"];
/// Maximum number of characters of a model's name in the list.
const NAME_LENGTH: usize = 42;

#[derive(Debug)]
pub struct View {
    minutes: f64,
}

impl Default for View {
    fn default() -> Self {
        Self { minutes: SEARCH_MINUTES }
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        let engine = cx.engine;
        let (out, on) = (&mut *cx.out, cx.scope.on);
        ui.horizontal_wrapped(|ui| {
            self.trying(ui, engine, out);
            ui.separator();
            let whole = || listed(engine, &[on], &ScoreSet::ALL).1;
            let holds =
                "Saves all rows of the list in the present order, with training, test and cross-validated errors";
            let any = !engine.models.rows.is_empty();
            let content = any.then_some(|| FileContent::Table("models.csv", Box::new(whole())));
            table::saving(ui, holds, || whole().tab_separated(), content, out);
        });
        ui.separator();
        if engine.models.rows.is_empty() {
            ui.weak(
                "\"Find the best\" tries models and proposes one. A click on a name applies the settings of the model.",
            );
            return;
        }
        for remark in &engine.models.remarks {
            ui.label(remark);
        }
        ui.weak("→ proposed: the most accurate model · = the smallest model that is nearly as accurate · italic: model fitted to other recordings");
        ui.scrolled(|ui| list(ui, engine, on, out));
    }
}

impl View {
    fn trying(&mut self, ui: &mut Ui, engine: &Engine, out: &mut Out) {
        if engine.is_trying() {
            if ui.press("Stop", "Stops the search; the listed models stay") {
                out.send(Action::StopTrying);
            }
        } else {
            let ready = !engine.entries().is_empty();
            ui.add_enabled_ui(ready, |ui| {
                let limit = Duration::from_secs_f64(60.0 * self.minutes);
                if ui.press(
                    "Find the best",
                    "Tries models, the fastest first, scores each by nested cross-validation, and proposes the most accurate and the smallest that is nearly as accurate",
                ) {
                    out.send(Action::FindBest(Candidates::All, limit));
                }
                let field = egui::DragValue::new(&mut self.minutes)
                    .range(0.0..=MOST_MINUTES)
                    .speed(0.1)
                    .suffix(" min");
                let about = "Limit of the processor time, summed over all threads; afterwards no further model is started";
                ui.field("within", field, about);
                if ui.press(
                    "Models of Koike et al. (2019)",
                    "Tries only linear, kernel, network and both in two stages, without and with look-back, as Koike et al. (2019) did",
                ) {
                    out.send(Action::FindBest(Candidates::Paper, limit));
                }
            });
        }
        let keep = ui.add_enabled(engine.can_keep(), egui::Button::new("Keep this model"));
        let keep = keep
            .on_hover_text(
                "Adds the present settings to the list of models, with their errors and the trained network or kernel",
            )
            .on_disabled_hover_text(
                "Possible once the loads shown are fitted or trained with the present settings",
            );
        if keep.clicked() {
            out.send(Action::KeepModel);
        }
    }
}

/// Returns the rows of the list by their errors on these samples, and the table with their errors on the samples `shown`.
fn listed(engine: &Engine, by: &[ScoreSet], shown: &[ScoreSet]) -> (Vec<usize>, Table) {
    let table = |sets: &[ScoreSet]| engine.models.table(engine.project(), sets);
    let ranked = table(by);
    let column = ranked.columns.iter().position(|column| column.name == RELATIVE);
    let order = match column {
        Some(column) => ranked.order(column, false),
        None => (0..ranked.rows.len()).collect(),
    };
    let table = table(shown).in_order(&order);
    (order, table)
}

fn list(ui: &mut Ui, engine: &Engine, errors_on: ScoreSet, out: &mut Out) {
    let project = engine.project();
    let (order, mut table) = listed(engine, &[errors_on], &[errors_on]);
    table.keep_columns(|_, column| {
        !SAVED_ONLY.contains(&&*column.name) && !column.name.starts_with("± ")
    });
    table::show_led(ui, &table, 2, &mut |ui, at| {
        let row = &engine.models.rows[order[at]];
        ui.push_id(row.id, |ui| more(ui, row, out));
        ui.label(&table.rows[at][0].text);
        let mut name = RichText::new(elided(&row.name, NAME_LENGTH));
        if row.is_stale(project) {
            name = name.weak().italics();
        }
        let settings = &row.model.settings;
        let name = ui.selectable_label(row.is_present(project), name).on_hover_text(format!(
            "{}: {}, {}\nClick to apply the settings of this model; undo restores the present settings",
            row.name,
            settings.features.describe(),
            settings.regressor.label(),
        ));
        if name.clicked() {
            out.send(Action::BringBack(row.id));
        }
    });
}

/// Draws the button that applies the model, and the menu of the model's row.
fn more(ui: &mut Ui, row: &Row, out: &mut Out) {
    ui.horizontal(|ui| {
        let about = "Applies the settings and the trained network or kernel of this model; undo restores the present ones";
        if ui.press_small("Use", about) {
            out.send(Action::BringBack(row.id));
        }
        let menu = ui.menu_button("…", |ui| {
            let about = "Shows the loads of this model in Calibrate; Escape restores the present model";
            if ui.press("Compare in Calibrate", about) {
                out.send(Command::Compare(row.id));
                ui.close();
            }
            if ui.press("Remove", "Removes the model from this list") {
                out.send(Action::RemoveModel(row.id));
                ui.close();
            }
        });
        menu.response.on_hover_text("Compares or removes this model");
    });
}
