//! Pane with the list of tried models. The user can search for models, sort the list, keep models and apply them.

use std::time::Duration;

use egui::{RichText, Ui};

use crate::{
    engine::{Action, Engine, FileContent, ModelChange, Row, SEARCH_MINUTES},
    questions::{Candidates, RELATIVE},
    report::Table,
    scoring::score_set::ScoreSet,
    ui::{
        command::{Command, Out, Pane},
        controls::Controls as _,
        numbers::elided,
        pane::{Cx, PaneView},
        table::{self, Sort},
    },
};

const MOST_MINUTES: f64 = 10_000.0;
/// Columns that only the saved list has; the hover text of a model's name describes its features and its regressor.
const SAVED_ONLY: [&str; 5] = ["features", "regressor", "cross-validation", "data", "trial time"];
/// Maximum number of characters of a model's name in the list.
const NAME_LENGTH: usize = 42;

pub const PANE: Pane = Pane {
    key: "compare",
    title: "Models",
    explanation: "Search for the best model, and the list of all tried models with their errors",
};

#[derive(Debug)]
pub struct View {
    minutes: f64,
    sort: Sort,
}

impl Default for View {
    fn default() -> Self {
        Self { minutes: SEARCH_MINUTES, sort: Sort::by(RELATIVE) }
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        let engine = cx.engine;
        let (out, on) = (&mut *cx.out, cx.scope.on);
        ui.horizontal_wrapped(|ui| {
            self.trying(ui, engine, out);
            ui.separator();
            let whole = || whole(engine, &self.sort, on);
            let holds =
                "Saves all rows of the list in the present order, with training, test and cross-validated errors";
            let any = !engine.models.rows.is_empty();
            let content = any.then_some(|| FileContent::Table("models.csv", Box::new(whole())));
            table::saving(ui, holds, || whole().tab_separated(), content, out);
        });
        ui.separator();
        if engine.models.rows.is_empty() {
            ui.weak(
                "\"Find the best\" tries models, the fastest first, and proposes one. The list shows all tried models; a click on the name of a model applies its settings.",
            );
            return;
        }
        for remark in &engine.models.remarks {
            ui.label(remark);
        }
        ui.weak("→ proposed: the most accurate model · = the smallest model that is nearly as accurate · italic: model fitted to other recordings");
        ui.scrolled(|ui| self.list(ui, engine, on, out));
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
                    "Tries models, the fastest first. Chooses their parameters from the training recordings, scores each \
                     by nested cross-validation, and proposes the most accurate model and the smallest that is nearly as accurate",
                ) {
                    out.send(Action::FindBest(Candidates::All, limit));
                }
                let field = egui::DragValue::new(&mut self.minutes)
                    .range(0.0..=MOST_MINUTES)
                    .speed(0.1)
                    .suffix(" min");
                let about = "Time limit of the search; afterwards no further model is started";
                ui.explained_field("within", field, about);
                if ui.press(
                    "Models of Koike et al. (2019)",
                    "Tries only the models of Koike et al. (2019): linear, kernel, network and both in two stages, without and with look-back. \
                     Use every tenth sample (Settings) for their pattern B",
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

    fn list(&mut self, ui: &mut Ui, engine: &Engine, errors_on: ScoreSet, out: &mut Out) {
        let project = engine.project();
        let mut table = engine.models.table(project, &[errors_on]);
        table.keep_columns(|_, column| {
            !SAVED_ONLY.contains(&&*column.name) && !column.name.starts_with("± ")
        });
        table::show_sorted(ui, &table, &mut self.sort, 2, &mut |ui, at| {
            let row = &engine.models.rows[at];
            ui.push_id(row.id, |ui| more(ui, row, out));
            ui.label(&table.rows[at][0].text);
            let name = elided(&row.name, NAME_LENGTH);
            let mut name = RichText::new(name);
            if row.is_stale(project) {
                name = name.weak().italics();
            }
            let name = ui.selectable_label(row.is_present(project), name);
            let settings = &row.model.settings;
            let name = name.on_hover_text(format!(
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
}

/// Returns the table of models with training, test and cross-validated errors, in the order on screen.
fn whole(engine: &Engine, sort: &Sort, errors_on: ScoreSet) -> Table {
    let table = |sets: &[ScoreSet]| engine.models.table(engine.project(), sets);
    let order = sort.order(&table(&[errors_on]));
    table(&ScoreSet::ALL).in_order(&order)
}

/// Draws the check box that keeps a model in the list, the button that applies the model, and the menu of the model's row.
fn more(ui: &mut Ui, row: &Row, out: &mut Out) {
    ui.horizontal(|ui| {
        let mut say = |change| out.send(Action::Model(row.id, change));
        let mut is_pinned = row.is_pinned;
        let pin = ui.checkbox(&mut is_pinned, "");
        let label = format!("Pin {}", row.name);
        pin.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::CheckBox, true, is_pinned, &label)
        });
        if pin.on_hover_text("Keeps this row in the list when further models are tried").changed() {
            say(ModelChange::Pin(is_pinned));
        }
        let about = "Applies the settings and the trained network or kernel of this model; undo restores the present ones";
        let is_used = ui.press_small("Use", about);
        let mut compared = false;
        let response = ui.menu_of_fields(egui::Button::new("…"), |ui| {
            ui.reset_style(); // a field, not menu items
            let mut name = row.name.clone();
            let field = egui::TextEdit::singleline(&mut name).desired_width(180.0);
            let field = ui.field("Name", field, "Name of the model in this list");
            if field.changed() {
                say(ModelChange::Name(name));
            }
            let about = "Shows the loads of this model in Calibrate; Escape restores the present model";
            if ui.press("Compare in Calibrate", about) {
                compared = true;
                ui.close();
            }
            if ui.press("Remove", "Removes the model from this list") {
                say(ModelChange::Remove);
                ui.close();
            }
        });
        response.on_hover_text("Renames or removes this model");
        if is_used {
            out.send(Action::BringBack(row.id));
        }
        if compared {
            out.send(Command::Compare(row.id));
        }
    });
}
