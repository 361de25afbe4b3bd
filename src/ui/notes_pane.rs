//! Pane of free text that is saved with the session.

use crate::{
    engine::Edit,
    ui::{
        controls::named,
        pane::{Cx, PaneView},
    },
};

/// The pane has no state of its own, because the text is stored in the project.
#[derive(Debug, Default)]
pub struct View;

impl PaneView for View {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        let notes = &cx.engine.project().notes;
        let mut text = notes.clone();
        let field = egui::TextEdit::multiline(&mut text)
            .hint_text("Notes on this calibration, saved with the session")
            .desired_width(f32::INFINITY);
        let response = ui.add_sized(ui.available_size(), field);
        let response = response.on_hover_text("Free text, saved with the session");
        named(&response, egui::Role::MultilineTextInput, "Notes");
        if text != *notes {
            cx.out.send(Edit::Notes(text));
        }
    }
}
