//! Which sensor it is, how far its readings may be off, and the certificate that says both.

use crate::engine::{Action, Edit, Engine, Existing};
use crate::recording::{Identity, Item};
use crate::report::{Table, uncertainty_tables};
use crate::ui::command::{Command, Kind, Pane};
use crate::ui::pane::{Cx, PaneView};
use crate::ui::table;

/// From where the fields stand (points).
const LABEL: f32 = 160.0;
/// Width of the fields (points).
const FIELD: f32 = 230.0;

/// The pane.
pub const PANE: Pane = Pane(&Kind {
    key: "certificate",
    title: "Certificate",
    explanation: "Which sensor it is, the uncertainty of a reading, and the certificate",
});

/// What is typed.
#[derive(Debug)]
pub struct View {
    path: String,
}

impl Default for View {
    fn default() -> Self {
        Self {
            path: "certificate.html".to_owned(),
        }
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        self.draw(ui, cx.engine, cx.out);
        // Asked only where it is on screen.
        cx.engine.ask_uncertainty();
    }
}

impl View {
    fn draw(&mut self, ui: &mut egui::Ui, engine: &Engine, out: &mut Vec<Command>) {
        let found = engine.uncertainty.answer();
        let tables: Vec<Table> = found.map_or_else(Vec::new, uncertainty_tables);
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Write to");
            let field = egui::TextEdit::singleline(&mut self.path).desired_width(160.0);
            let field = ui.add(field).labelled_by(label.id);
            field.on_hover_text("Where the certificate is written: one page of HTML to read, print and sign");
            let button = egui::Button::new("Write certificate");
            let button = ui
                .add_enabled(engine.analysis().is_some(), button)
                .on_hover_text("On the first page what a laboratory hands over; then budget, matrices, loops, errors and definitions")
                .on_disabled_hover_text("There is no calibration yet");
            let path = self.path.trim();
            if button.clicked() && !path.is_empty() {
                out.push(Action::Save(engine.certificate_content(), path.into(), Existing::Ask).into());
            }
            ui.separator();
            table::copy_button(ui, &tables);
        });
        ui.separator();
        egui::ScrollArea::both()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    ui.vertical(|ui| form(ui, &engine.project().identity, out));
                    ui.separator();
                    ui.vertical(|ui| {
                        if let Some(problem) = engine.uncertainty.problem() {
                            ui.colored_label(ui.visuals().warn_fg_color, problem);
                        }
                        let Some(found) = found else {
                            ui.weak("No uncertainty yet.");
                            return;
                        };
                        if !engine.uncertainty.is_current() {
                            ui.weak("updating");
                        }
                        for note in &found.notes {
                            ui.label(format!("• {note}."));
                        }
                        for shown in &tables {
                            table::show(ui, shown);
                            ui.add_space(8.0);
                        }
                    });
                });
            });
    }
}

/// A field for each item.
fn form(ui: &mut egui::Ui, identity: &Identity, out: &mut Vec<Command>) {
    let mut edited = identity.clone();
    let mut heading = "";
    for item in Item::all() {
        if item.heading() != heading {
            heading = item.heading();
            ui.add_space(4.0);
            ui.strong(heading);
        }
        let mut text = identity.get(item).to_owned();
        ui.horizontal(|ui| {
            let left = ui.cursor().left();
            let label = ui.label(item.label());
            ui.add_space((left + LABEL - ui.cursor().left()).max(0.0));
            let field = egui::TextEdit::singleline(&mut text).desired_width(FIELD);
            let field = ui.add(field).labelled_by(label.id);
            field.on_hover_text(format!("{}: {}", item.label(), item.hint()));
        });
        if text != identity.get(item) {
            edited.set(item, text);
        }
    }
    if edited != *identity {
        out.push(Edit::Identity(edited).into());
    }
}
