//! One card a format: what its files hold, what they leave out, and writing several at once.

use std::path::{Path, PathBuf};

use crate::engine::{Action, Engine, Existing};
use crate::export::{Footprint, TARGETS, caution, target_endings};
use crate::shown::first;
use crate::ui::command::{Command, Kind, Pane};
use crate::ui::controls::Controls as _;
use crate::ui::numbers::elided;
use crate::ui::pane::{Cx, PaneView};

/// Room for the two buttons behind the path (points).
const BUTTONS: f32 = 118.0;
/// Characters of the result that have room beside the button.
const RESULT_CHARS: usize = 160;

/// The pane.
pub const PANE: Pane = Pane(&Kind {
    key: "export",
    title: "Export",
    explanation: "Writes the calibration as data, or as code that a robot runs",
});

/// What is typed and ticked.
#[derive(Debug)]
pub struct View {
    /// The path to export to.
    path: String,
    /// Endings of the formats that are written beside it.
    also: Vec<&'static str>,
}

impl Default for View {
    fn default() -> Self {
        Self { path: "calibration.json".to_owned(), also: Vec::new() }
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        self.export_row(ui, cx.engine, cx.out);
        let Some(analysis) = cx.engine.analysis() else { return };
        let calibration = &analysis.calibration;
        if let Some(notice) = cx.engine.notices.last() {
            ui.label(elided(&notice.text, RESULT_CHARS)).on_hover_text(&notice.text);
        }
        if let Some(caution) = caution(calibration, Path::new(self.path.trim())) {
            ui.warn(caution);
        }
        let footprint = Footprint::of(calibration);
        let about = "A history rate in the settings, a smaller t_th, or play in place of a look-back takes less memory";
        let text = format!("On a controller: {footprint}");
        let label = if footprint.is_large() { ui.warn(text) } else { ui.weak(text) };
        label.on_hover_text(about);
        ui.scrolled(|ui| {
            for target in TARGETS {
                let ending = target.endings[0];
                ui.separator();
                let mut chosen = self.also.contains(&ending);
                let name = egui::RichText::new(format!("{} (.{ending})", target.name)).strong();
                let about = "Written beside the file above, under the same name with this ending";
                if ui.tick(&mut chosen, name, about) {
                    self.also.retain(|own| *own != ending);
                    self.also.extend(chosen.then_some(ending));
                }
                ui.label(format!("Holds {}", target.holds));
                match (target.leaves_out)(calibration) {
                    "nothing" => {}
                    left_out => drop(ui.weak(format!("Leaves out {left_out}"))),
                }
                if let Some(caution) = (target.caution)(calibration) {
                    ui.warn(caution);
                }
            }
        });
    }
}

impl View {
    fn export_row(&mut self, ui: &mut egui::Ui, engine: &Engine, out: &mut Vec<Command>) {
        ui.horizontal(|ui| {
            let label = ui.label("Export to");
            let field = egui::TextEdit::singleline(&mut self.path)
                .hint_text(format!("path ending in one of {}", target_endings()))
                .desired_width((ui.available_width() - BUTTONS).clamp(40.0, 400.0));
            let field = ui.add(field).labelled_by(label.id).on_hover_text(
                "Where the calibration is written; its ending says as what, Enter writes it",
            );
            let entered = ui.entered(&field);
            ui.add_enabled_ui(engine.analysis().is_some(), |ui| {
                let paths = self.paths();
                let names =
                    first(TARGETS.len(), paths.iter().map(|path| path.display().to_string()));
                let export = ui.press("Export", format!("Writes {names}"));
                if export || entered {
                    out.extend(
                        paths.into_iter().map(|path| Action::Export(path, Existing::Ask).into()),
                    );
                }
                if ui.press("…", "Choose a file") {
                    out.push(Command::ChooseExport);
                }
            });
        });
    }

    /// Returns the files to write: the typed one, then those of the ticked formats.
    fn paths(&self) -> Vec<PathBuf> {
        let typed = PathBuf::from(self.path.trim());
        if typed.as_os_str().is_empty() {
            return Vec::new();
        }
        let beside = self.also.iter().map(|ending| typed.with_extension(ending));
        let mut paths = vec![typed.clone()];
        paths.extend(beside.filter(|path| *path != typed));
        paths
    }
}
