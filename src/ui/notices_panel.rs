//! Errors and warnings, kept until they are dismissed.

use egui::{Color32, RichText};

use crate::engine::{Action, Engine, Level};
use crate::ui::command::Command;

/// Draws the notices, newest first, with ways to copy and dismiss them.
pub fn notices_panel(ui: &mut egui::Ui, engine: &Engine, out: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let count = engine.notices.len();
        ui.strong(if count == 1 {
            "1 notice".to_owned()
        } else {
            format!("{count} notices")
        });
        let copy = ui.button("Copy all");
        let copy = copy.on_hover_text("Every notice, a line each");
        if copy.clicked() {
            let texts: Vec<_> = engine.notices.iter().map(|notice| &*notice.text).collect();
            ui.copy_text(texts.join("\n"));
        }
        let dismiss = ui.button("Dismiss all");
        let dismiss = dismiss.on_hover_text("They were read; this list goes");
        if dismiss.clicked() {
            out.push(Action::DismissAll.into());
        }
    });
    egui::ScrollArea::vertical()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            for (at, notice) in engine.notices.iter().enumerate().rev() {
                ui.horizontal_top(|ui| {
                    if ui
                        .small_button("×")
                        .on_hover_text("Dismiss this notice")
                        .clicked()
                    {
                        out.push(Action::Dismiss(at).into());
                    }
                    let (label, color) = kind(notice.level, ui.visuals());
                    ui.label(RichText::new(label).color(color));
                    ui.add(egui::Label::new(&notice.text).wrap());
                });
            }
        });
}

fn kind(level: Level, visuals: &egui::Visuals) -> (&'static str, Color32) {
    match level {
        Level::Info => ("Done", visuals.text_color()),
        Level::Warning => ("Warning", visuals.warn_fg_color),
        Level::Error => ("Error", visuals.error_fg_color),
    }
}
