//! Pane of the exports: the identity of the sensor, the path, the button that writes all chosen files, and a row for each
//! format.

use std::path::PathBuf;
use std::sync::Arc;

use egui::{Label, RichText, TextEdit, Ui};

use crate::{
    engine::{Action, Edit, Engine, Existing},
    export::{Footprint, Outline, TARGETS, Target, known_target, target_endings},
    finding::Face,
    questions::{errors::cold_start::AskColdStart, history::AskHistory},
    recording::Item,
    shown::{counted, first},
    ui::{
        command::{Command, Out, Pane},
        controls::Controls as _,
        pane::{Cx, PaneView},
    },
};

const BUTTONS: f32 = 118.0;
/// Minimum width of a field of the identity, in points.
const FIELD: f32 = 150.0;
/// Items of the identity that are always in sight.
const IN_SIGHT: [Item; 5] =
    [Item::Model, Item::Serial, Item::Operator, Item::Date, Item::Reference];

pub const PANE: Pane = Pane {
    key: "export",
    title: "Export",
    explanation: "Identity of the sensor, and the files to which the calibration is written, as data or as code for a robot",
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
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        identity(ui, cx.engine, cx.out);
        ui.separator();
        self.export_row(ui, cx.engine, cx.out);
        let Some(analysis) = cx.engine.analysis() else { return };
        let calibration = &analysis.calibration;
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
        let on_controller = format!("Needed on a controller, {footprint}");
        if !footprint.is_large() {
            ui.weak(on_controller);
        } else {
            ui.warn(on_controller).on_hover_text("To need less memory, set a history rate or a smaller time threshold t_th, or replace the look-back (earlier gauge values) by play");
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
        let outline = Outline::of(calibration);
        ui.scrolled(|ui| {
            for target in TARGETS {
                ui.separator();
                let refusal = (target.refusal)(&outline);
                let left_out = (target.leaves_out)(calibration);
                self.format_row(ui, target, (refusal.is_none(), left_out), cx.engine);
                if let Some(refusal) = refusal {
                    ui.warn(refusal);
                } else if let Some(caution) = (target.caution)(calibration) {
                    ui.warn(format!("This format leaves out {caution}"));
                }
            }
        });
    }
}

/// Draws the form of the sensor's identity, which every export and the report contain.
fn identity(ui: &mut Ui, engine: &Engine, out: &mut Out) {
    let identity = &engine.project().identity;
    let mut edited = identity.clone();
    let gap = ui.spacing().item_spacing.x;
    let columns = ((ui.available_width() + gap) / (FIELD + gap)).floor().max(1.0);
    let width = (ui.available_width() + gap) / columns - gap;
    let mut fields = |ui: &mut Ui, items: &[Item]| {
        for row in items.chunks(columns as usize) {
            ui.horizontal(|ui| {
                for item in row.iter().copied() {
                    ui.vertical(|ui| {
                        ui.set_width(width);
                        let mut text = identity.get(item).to_owned();
                        let label = if item == Item::Serial && text.is_empty() {
                            ui.warn(format!("{} is missing", item.label()))
                        } else {
                            ui.label(item.label())
                        };
                        let field = TextEdit::singleline(&mut text).desired_width(f32::INFINITY);
                        let field = ui.add(field).labelled_by(label.id);
                        field.on_hover_text(format!("{}: {}", item.label(), item.placeholder()));
                        if text != identity.get(item) {
                            edited.set(item, text);
                        }
                    });
                }
            });
        }
    };
    fields(ui, &IN_SIGHT);
    egui::CollapsingHeader::new("More about the sensor").show(ui, |ui| {
        let others = Item::all().filter(|item| !IN_SIGHT.contains(item));
        fields(ui, &others.collect::<Vec<_>>());
        ui.weak("The rated load of each axis is entered in the pane Settings, as its full scale.");
    });
    if edited != *identity {
        out.send(Edit::Identity(edited));
    }
}

impl View {
    fn export_row(&mut self, ui: &mut Ui, engine: &Engine, out: &mut Out) {
        let paths = ui.horizontal(|ui| {
            let label = ui.label("Export to");
            let field = TextEdit::singleline(&mut self.path)
                .hint_text(format!("path ending in one of {}", target_endings()))
                .desired_width((ui.available_width() - BUTTONS).clamp(40.0, 400.0));
            let field = ui.add(field).labelled_by(label.id).on_hover_text(
                "Path of the exported calibration; its ending chooses the format. The Enter key writes the files",
            );
            let entered = ui.entered(&field);
            let paths = self.paths(engine);
            let names = first(TARGETS.len(), paths.iter().map(|path| path.display().to_string()));
            let about = if paths.is_empty() {
                "No file can be written: type a path whose format can hold this calibration, or select a format below"
                    .to_owned()
            } else {
                format!("Writes {names}")
            };
            let is_possible = engine.analysis().is_some() && !paths.is_empty();
            let write = ui.add_enabled(is_possible, egui::Button::new("Write files"));
            let write = write.on_hover_text(&about).on_disabled_hover_text(about);
            if write.clicked() || entered && is_possible {
                out.send(Action::Export(paths.clone(), Existing::Ask));
            }
            let about = "Opens a dialog in which the file to write is chosen";
            if ui.press_if(engine.analysis().is_some(), "…", about) {
                out.send(Command::ChooseExport);
            }
            paths
        });
        let paths = paths.inner;
        let results = paths.iter().filter_map(|path| engine.exported(path));
        let (written, failed): (Vec<_>, Vec<_>) = results.partition(|result| result.is_ok());
        let text = format!("{} of {} written", written.len(), counted(paths.len(), "file"));
        let unknown = known_target(self.path.trim().as_ref()).err();
        // One line is always there, so that nothing below moves.
        if let Some(unknown) = unknown.filter(|_| !self.path.trim().is_empty()) {
            ui.warn(unknown);
        } else if !failed.is_empty() {
            ui.fail(text);
        } else if !written.is_empty() {
            ui.label(text);
        } else if engine.project().identity.get(Item::Serial).is_empty() {
            ui.warn("The files will contain no serial number");
        } else {
            ui.weak("Nothing written yet");
        }
    }

    /// Draws the name of a format with its tick, and beside it the result of the last export in this format.
    fn format_row(
        &mut self,
        ui: &mut Ui,
        target: &Target,
        (is_possible, left_out): (bool, &str),
        engine: &Engine,
    ) {
        let ending = target.endings[0];
        let is_typed = self.is_typed(target);
        let mut chosen = is_typed || self.also.contains(&ending);
        ui.horizontal(|ui| {
            let name = RichText::new(format!("{} (.{ending})", target.name)).strong();
            let about = format!(
                "Writes this format, to the path above with this ending. It holds {}; it leaves out {left_out}",
                target.holds
            );
            ui.add_enabled_ui(is_possible && !is_typed, |ui| {
                if ui.tick(&mut chosen, name, about) {
                    self.also.retain(|other| *other != ending);
                    self.also.extend(chosen.then_some(ending));
                }
            });
            let path = self.path_of(target);
            match path.as_ref().and_then(|path| engine.exported(path)) {
                None => {}
                Some(Ok(())) => drop(ui.label("Written")),
                Some(Err(reason)) => {
                    let color = ui.visuals().error_fg_color;
                    ui.add(Label::new(RichText::new(reason).color(color)).truncate());
                }
            }
        });
    }

    fn is_typed(&self, target: &Target) -> bool {
        let typed = known_target(self.path.trim().as_ref());
        typed.is_ok_and(|typed| typed.endings == target.endings)
    }

    /// Returns the file to write in a format: the typed path, or the same path with the ending of a ticked format.
    fn path_of(&self, target: &Target) -> Option<PathBuf> {
        let typed = PathBuf::from(self.path.trim());
        if self.is_typed(target) {
            return Some(typed);
        }
        let is_chosen = self.also.contains(&target.endings[0]) && !typed.as_os_str().is_empty();
        is_chosen.then(|| typed.with_extension(target.endings[0]))
    }

    /// Returns the files to write. Files whose format cannot hold the present calibration are omitted.
    fn paths(&self, engine: &Engine) -> Vec<PathBuf> {
        let Some(analysis) = engine.analysis() else { return Vec::new() };
        let outline = Outline::of(&analysis.calibration);
        let typed = PathBuf::from(self.path.trim());
        let is_unknown = known_target(&typed).is_err() && !typed.as_os_str().is_empty();
        let possible = TARGETS.iter().filter(|target| (target.refusal)(&outline).is_none());
        let paths = possible.filter_map(|target| self.path_of(target));
        is_unknown.then_some(typed.clone()).into_iter().chain(paths).collect()
    }
}
