//! Pane of the exports: the path, the button that writes all chosen files, and a description of each format.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::engine::{Action, Edit, Engine, Existing};
use crate::export::{Footprint, TARGETS, caution, target_endings};
use crate::finding::Face;
use crate::questions::check::cold_start::AskColdStart;
use crate::questions::history::AskHistory;
use crate::shown::first;
use crate::ui::command::{Command, Out, Pane};
use crate::ui::controls::Controls as _;
use crate::ui::numbers::elided;
use crate::ui::pane::{Cx, PaneView};

const BUTTONS: f32 = 118.0;
/// Maximum number of characters of the notice about the last export that the pane shows.
const RESULT_CHARS: usize = 160;

pub const PANE: Pane = Pane {
    key: "export",
    title: "Export",
    explanation: "Writes the calibration to files, as data or as code that a robot runs",
};

#[derive(Debug)]
pub struct View {
    path: String,
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
        let paths = self.paths().into_iter().map(|path| path.display().to_string());
        let paths: Vec<String> = paths.collect();
        let names_one = |text: &str| paths.iter().any(|path| text.contains(path));
        if let Some(notice) = cx.engine.notices.iter().rev().find(|own| names_one(&own.text)) {
            ui.label(elided(&notice.text, RESULT_CHARS)).on_hover_text(&notice.text);
        }
        if let Some(caution) = caution(calibration, Path::new(self.path.trim())) {
            ui.warn(caution);
        }
        if let Some((of, exact)) = cx.engine.exact().filter(|(_, exact)| exact.fitted) {
            let calibration = Arc::clone(&exact.calibration);
            let ask = AskColdStart { request: of.clone(), calibration };
            if let Some((asked, Some(found))) = cx.engine.lane::<AskColdStart>().whole()
                && *asked == ask
            {
                ui.warn(found.text(Face::Window));
            }
            cx.ask(ask);
        }
        let footprint = Footprint::of(calibration);
        let to_need_less = "To need less memory, set a history rate or a smaller time threshold t_th, or replace the look-back (earlier gauge values) by play";
        let on_controller = format!("Needed on a controller, {footprint}");
        if footprint.is_large() {
            ui.warn(&on_controller).on_hover_text(to_need_less);
        }
        if footprint.is_large()
            && let Some((of, _)) = cx.engine.exact()
        {
            let ask = AskHistory(of.clone());
            let lane = cx.engine.lane::<AskHistory>();
            if let Some((asked, Some(coarse))) = lane.whole()
                && *asked == ask
            {
                ui.horizontal_wrapped(|ui| {
                    let does = "Stores fewer earlier samples: sets this history rate and fits the model again";
                    if ui.press(format!("Set history rate to {} Hz", coarse.rate_hz), does) {
                        let mut settings = of.settings.clone();
                        settings.history_rate_hz = coarse.rate_hz;
                        cx.out.send(Edit::Settings(settings));
                    }
                    ui.label(coarse.to_string());
                });
            }
            cx.ask(ask);
        }
        ui.scrolled(|ui| {
            for target in TARGETS {
                let ending = target.endings[0];
                ui.separator();
                let mut chosen = self.also.contains(&ending);
                let name = egui::RichText::new(format!("{} (.{ending})", target.name)).strong();
                let about =
                    "Also writes the calibration in this format, to the same path with this ending";
                if ui.tick(&mut chosen, name, about) {
                    self.also.retain(|own| *own != ending);
                    self.also.extend(chosen.then_some(ending));
                }
                ui.label(format!("This format holds {}", target.holds));
                if target.on_controller {
                    ui.weak(&on_controller).on_hover_text(to_need_less);
                }
                match (target.leaves_out)(calibration) {
                    "nothing" => {}
                    left_out => drop(ui.weak(format!("This format does not contain {left_out}"))),
                }
                if let Some(caution) = (target.caution)(calibration) {
                    ui.warn(format!("This format leaves out {caution}"));
                }
            }
        });
    }
}

impl View {
    fn export_row(&mut self, ui: &mut egui::Ui, engine: &Engine, out: &mut Out) {
        ui.horizontal(|ui| {
            let label = ui.label("Export to");
            let field = egui::TextEdit::singleline(&mut self.path)
                .hint_text(format!("path ending in one of {}", target_endings()))
                .desired_width((ui.available_width() - BUTTONS).clamp(40.0, 400.0));
            let field = ui.add(field).labelled_by(label.id).on_hover_text(
                "Path of the exported calibration; its ending chooses the format. The Enter key writes the files",
            );
            let entered = ui.entered(&field);
            ui.add_enabled_ui(engine.analysis().is_some(), |ui| {
                let paths = self.paths();
                let names =
                    first(TARGETS.len(), paths.iter().map(|path| path.display().to_string()));
                let export = ui.press("Write files", format!("Writes {names}"));
                if export || entered {
                    for path in paths {
                        out.send(Action::Export(path, Existing::Ask));
                    }
                }
                if ui.press("…", "Opens a dialog in which the file to write is chosen") {
                    out.send(Command::ChooseExport);
                }
            });
        });
    }

    /// Returns the files to write: the typed path, then the same path with the ending of each ticked format.
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
