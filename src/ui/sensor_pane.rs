//! Pane with a form for the sensor's identity. Every export and the report contain the identity.

use crate::engine::{Edit, Engine};
use crate::recording::Item;
use crate::ui::command::{Out, Pane};
use crate::ui::controls::Controls as _;
use crate::ui::pane::{Cx, PaneView};

const LABEL: f32 = 160.0;
const FIELD: f32 = 230.0;

pub const PANE: Pane = Pane {
    key: "sensor",
    title: "Sensor",
    explanation: "Identity of the sensor, and date and reference of its calibration, for exports and the report",
};

#[derive(Debug, Default)]
pub struct View;

impl PaneView for View {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        ui.scrolled(|ui| form(ui, cx.engine, cx.out));
    }
}

fn form(ui: &mut egui::Ui, engine: &Engine, out: &mut Out) {
    let identity = &engine.project().identity;
    let mut edited = identity.clone();
    for item in Item::all() {
        let mut text = identity.get(item).to_owned();
        ui.horizontal(|ui| {
            let left = ui.cursor().left();
            let label = ui.label(item.label());
            ui.add_space((left + LABEL - ui.cursor().left()).max(0.0));
            let field = egui::TextEdit::singleline(&mut text).desired_width(FIELD);
            let field = ui.add(field).labelled_by(label.id);
            field.on_hover_text(format!("{}: {}", item.label(), item.placeholder()));
        });
        if text != identity.get(item) {
            edited.set(item, text);
        }
    }
    ui.weak("The rated load of each axis is entered in the pane Settings, as its full scale.");
    if edited != *identity {
        out.send(Edit::Identity(edited));
    }
}
