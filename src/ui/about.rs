//! The About page: version, build, and the licences of the program and of its crates.

use egui::{RichText, ScrollArea, TextStyle};

use crate::{
    about::{LICENCES_OF_CRATES, OWN_LICENCES, built},
    ui::controls::Controls as _,
};

#[derive(Debug, Default)]
pub struct About {
    shown: usize,
}

impl About {
    pub fn ui(&mut self, ui: &mut egui::Ui) {
        ui.heading("LoopScope");
        ui.label("Calibrates force/torque sensors and compensates their hysteresis");
        ui.add_space(6.0);
        egui::Grid::new("built").num_columns(2).spacing([16.0, 4.0]).show(ui, |ui| {
            for (name, value) in built() {
                ui.label(RichText::new(name).strong());
                ui.label(value);
                ui.end_row();
            }
        });
        if ui.press(
            "Copy version",
            "Copies the version and the build of the program, to be pasted into a fault report",
        ) {
            let lines = built().map(|(name, value)| format!("{name}: {value}"));
            ui.ctx().copy_text(lines.join("\n"));
        }
        ui.separator();
        let crates = "Lists the Rust crates in this program, with their authors and licences";
        let of_program = OWN_LICENCES
            .map(|(name, text)| (name, text, "Shows the text of this licence of the program"));
        let texts = [of_program[0], of_program[1], ("Crates", LICENCES_OF_CRATES, crates)];
        ui.horizontal(|ui| {
            ui.label("Licence: MIT or Apache-2.0, at your choice");
            for (at, (name, _, explanation)) in texts.iter().enumerate() {
                ui.select(&mut self.shown, at, name, explanation);
            }
        });
        let (name, text, _) = texts[self.shown];
        let lines: Vec<&str> = text.lines().collect();
        let height = ui.text_style_height(&TextStyle::Monospace);
        ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
        ScrollArea::both().id_salt(name).auto_shrink([false, false]).show_rows(
            ui,
            height,
            lines.len(),
            |ui, rows| {
                for line in &lines[rows] {
                    ui.monospace(*line);
                }
            },
        );
    }
}
