//! Pane of the exports: the identity of the sensor, a row for each purpose of a file, and below them the path and the button
//! that writes all chosen files.

use std::path::PathBuf;
use std::sync::Arc;

use egui::{DragValue, Label, Rect, RichText, TextEdit, Ui};

use crate::{
    calibration::Calibration,
    engine::{Action, Edit, Engine, Existing},
    export::{Footprint, Held, Outline, PARTS, TARGETS, Target, known_target, target_endings},
    finding::Face,
    questions::{
        errors::cold_start::AskColdStart,
        history::{AskFileSizes, AskHistory},
    },
    recording::Item,
    shown::{counted, first},
    ui::{
        command::{Command, Out},
        controls::{Controls as _, cells, named, place, place_down, place_right},
        pane::{Cx, PaneView},
    },
};

/// Width of the buttons beside the path (points).
const BUTTONS: f32 = 190.0;
const WRITE_WIDTH: f32 = 120.0;
const FOOT_HEIGHT: f32 = 112.0;
const HEAD_HEIGHT: f32 = 32.0;
/// Heights of a row (points): in a window of at least this height, and in a lower one.
const ROW_HEIGHTS: (f32, f32, f32) = (34.0, 880.0, 28.0);
/// Widths of the columns (points). The purpose takes the rest.
const FILE_WIDTH: f32 = 46.0;
const PART_WIDTH: f32 = 78.0;
const SIZE_WIDTH: f32 = 46.0;
const REMARK_WIDTH: f32 = 110.0;
/// Width below which the list scrolls sideways (points).
const LEAST_WIDTH: f32 = 700.0;
/// File name ending of the report.
const REPORT: &str = "html";
/// Explanation of the fields of the sensor frame.
const FRAME: &str = "Frame in which the calibration gives loads, such as a robot's flange. The gauge frame, in which the reference was measured, is turned about the fixed axes x, y, z of this frame, in this order, and its origin lies at the given point. The reference loads are turned and shifted before the fit";
/// Minimum width of a field of the identity, in points.
const FIELD: f32 = 138.0;
/// Items of the identity that are always in sight.
const IN_SIGHT: [Item; 5] =
    [Item::Model, Item::Serial, Item::Operator, Item::Date, Item::Reference];

#[derive(Debug)]
pub struct View {
    path: String,
    /// File name endings of the formats that are written beside the typed path.
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
        let whole = ui.available_rect_before_wrap();
        let top = (whole.bottom() - FOOT_HEIGHT).max(whole.top());
        let foot = whole.with_min_y(top);
        if let Some(analysis) = cx.engine.analysis() {
            let sizes = AskFileSizes(Arc::clone(&analysis.calibration));
            place_down(ui, whole.with_max_y(top), "formats", |ui| {
                ui.scrolled(|ui| self.checklist(ui, cx.engine, &analysis.calibration));
            });
            if cx.engine.is_current() {
                cx.ask(sizes);
            }
        }
        let line = ui.visuals().widgets.noninteractive.bg_stroke;
        ui.painter().hline(foot.x_range(), foot.top(), line);
        place_down(ui, foot.with_min_y(top + 8.0), "foot", |ui| {
            self.export_row(ui, cx.engine, cx.out);
            self.outcome(ui, cx.engine);
            controller(ui, cx);
        });
    }
}

/// Draws the history rate that the fit chose, with the memory that a controller needs; then what the calibration does after a cold
/// start.
fn controller(ui: &mut Ui, cx: &mut Cx<'_>) {
    let Some(analysis) = cx.engine.analysis() else { return };
    if analysis.calibration.features.has_history()
        && let Some((of, _)) = cx.engine.exact()
    {
        let ask = AskHistory(of.clone());
        if let Some((asked, Some(coarse))) = cx.engine.lane::<AskHistory>().whole()
            && *asked == ask
        {
            let text = coarse.to_string();
            ui.add(Label::new(RichText::new(&text).weak()).truncate()).on_hover_text(text);
        }
        cx.ask(ask);
    }
    if let Some((of, exact)) = cx.engine.exact().filter(|(_, exact)| exact.fitted) {
        let calibration = Arc::clone(&exact.calibration);
        let ask = AskColdStart { request: of.clone(), calibration };
        if let Some((asked, Some(found))) = cx.engine.lane::<AskColdStart>().whole()
            && *asked == ask
        {
            let text = RichText::new(found.text(Face::Window)).color(ui.visuals().warn_fg_color);
            ui.add(Label::new(text).truncate());
        }
        cx.ask(ask);
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
        let mut frame = engine.project().frame.unwrap_or_default();
        for (label, values, unit, speed) in [
            ("Turn of the gauge frame about x, y, z", &mut frame.turn_degrees, "°", 1.0),
            ("Origin of the gauge frame x, y, z", &mut frame.shift_metres, " m", 1e-3),
        ] {
            ui.horizontal_wrapped(|ui| {
                let label = ui.label(label).on_hover_text(FRAME);
                for value in values {
                    let field = DragValue::new(value).speed(speed).suffix(unit);
                    ui.add(field.update_while_editing(false)).labelled_by(label.id);
                }
            });
        }
        if let Ok(frame) = frame.checked()
            && frame != engine.project().frame
        {
            out.send(Edit::Frame(frame));
        }
        ui.weak("The rated load of each axis is entered in the pane Settings, as its full scale.");
    });
    if edited != *identity {
        out.send(Edit::Identity(edited));
    }
}

impl View {
    /// Draws a row for each purpose: the file, whether it holds each part of the calibration, its size, and a remark.
    fn checklist(&mut self, ui: &mut Ui, engine: &Engine, calibration: &Calibration) {
        ui.spacing_mut().item_spacing.y = 0.0;
        let outline = Outline::of(calibration);
        let sizes = engine.lane::<AskFileSizes>().whole();
        let sizes = sizes.filter(|(asked, _)| std::ptr::eq(&*asked.0, calibration));
        let (purpose, file, parts, size, _) = next_row(ui, HEAD_HEIGHT);
        place(ui, purpose, |ui| ui.label(RichText::new("What do you need it for?").size(15.0)));
        place(ui, file, |ui| ui.weak("file"));
        for (part, place) in PARTS.into_iter().zip(parts) {
            centred(ui, place, RichText::new(part).weak())
                .on_hover_text("A tick: contained. A cross: left out. A dash: the calibration or the kind of file has none");
        }
        place_right(ui, size, |ui| ui.weak("[kB]"));
        for (at, target) in TARGETS.iter().enumerate() {
            let refusal = (target.refusal)(&outline);
            let size = sizes.and_then(|(_, sizes)| *sizes.get(at)?);
            self.format_row(ui, target, (refusal, size), calibration, engine);
        }
        let (purpose, file, .., remark) = next_row(ui, row_height(ui));
        place(ui, purpose, |ui| {
            let about = "Writes the results to one HTML page with tables, loops and traces, to print or to send";
            self.tick(ui, (REPORT, false), "Report for people", about);
        });
        place(ui, file, |ui| ui.weak(".html"));
        result(ui, remark, self.path_of(&[REPORT]), engine);
    }

    /// Draws the tick of a format. A format whose ending is typed loses it with its tick.
    fn tick(
        &mut self,
        ui: &mut Ui,
        (ending, is_typed): (&'static str, bool),
        name: &str,
        about: &str,
    ) {
        let mut chosen = is_typed || self.also.contains(&ending);
        if ui.tick(&mut chosen, name, about) {
            if is_typed {
                self.path =
                    PathBuf::from(self.path.trim()).with_extension("").display().to_string();
            }
            self.also.retain(|other| *other != ending);
            self.also.extend(chosen.then_some(ending));
        }
    }

    fn format_row(
        &mut self,
        ui: &mut Ui,
        target: &Target,
        (refusal, size): (Option<String>, Option<u64>),
        calibration: &Calibration,
        engine: &Engine,
    ) {
        let (purpose, file, parts, size_place, remark) = next_row(ui, row_height(ui));
        let ending = target.endings[0];
        let left_out = (target.leaves_out)(calibration);
        let about =
            format!("{} (.{ending}): holds {}; leaves out {left_out}", target.name, target.holds);
        let is_typed = self.is_typed(target.endings);
        place(ui, purpose, |ui| {
            ui.add_enabled_ui(refusal.is_none(), |ui| {
                self.tick(ui, (ending, is_typed), target.purpose, &about);
            });
        });
        place(ui, file, |ui| ui.weak(format!(".{ending}")));
        if let Some(refusal) = refusal {
            let text = Label::new(RichText::new(&refusal).weak().size(12.0)).wrap();
            let rest = remark.with_min_x(parts[0].left());
            place(ui, rest, |ui| ui.add(text)).on_hover_text(refusal);
            return;
        }
        let parts = (target.parts)(calibration).into_iter().zip(PARTS).zip(parts);
        for ((held, part), place) in parts {
            mark(ui, place, held, part, ending);
        }
        if let Some(bytes) = size {
            place_right(ui, size_place, |ui| {
                ui.label(format!("{:.0}", (bytes as f64 / 1e3).ceil()))
            });
        }
        if result(ui, remark, self.path_of(target.endings), engine) {
            return;
        }
        if let Some(caution) = (target.caution)(calibration) {
            let text = if calibration.offset { "tare first" } else { "uncompensated" };
            place(ui, remark, |ui| ui.warn(text))
                .on_hover_text(format!("This format leaves out {caution}"));
        } else if ending == "h" {
            let footprint = Footprint::of(calibration);
            let text = format!("{:.1} kB of RAM", footprint.memory as f64 / 1e3);
            let label =
                place(
                    ui,
                    remark,
                    |ui| {
                        if footprint.is_large() { ui.warn(text) } else { ui.weak(text) }
                    },
                );
            label.on_hover_text(format!("Needed on a controller, {footprint}. A history rate, a smaller t_th, or play in place of the look-back need less"));
        }
    }

    fn export_row(&mut self, ui: &mut Ui, engine: &Engine, out: &mut Out) {
        ui.horizontal(|ui| {
            let label = ui.label("Export to");
            let field = TextEdit::singleline(&mut self.path)
                .hint_text(format!("path ending in one of {}", target_endings()))
                .desired_width((ui.available_width() - BUTTONS).clamp(40.0, 480.0));
            let field = ui.add(field).labelled_by(label.id).on_hover_text(
                "Folder and name of the files; an ending chooses a format, as a tick does. The Enter key writes the files",
            );
            let entered = ui.entered(&field);
            let about = "Opens a dialog in which the file to write is chosen";
            if ui.press_if(engine.analysis().is_some(), "…", about) {
                out.send(Command::ChooseExport);
            }
            let paths = self.paths(engine);
            let report = self.path_of(&[REPORT]);
            let all = paths.iter().chain(&report);
            let names = first(TARGETS.len(), all.map(|path| path.display().to_string()));
            let n_files = paths.len() + usize::from(report.is_some());
            let about = match n_files {
                0 => "Select a purpose above, or type a path whose ending names a format".to_owned(),
                _ => format!("Writes {names}"),
            };
            let is_possible = engine.analysis().is_some() && n_files > 0;
            let text = RichText::new(format!("Write {}", counted(n_files, "file")));
            let write = egui::Button::new(text).min_size(egui::vec2(WRITE_WIDTH, 28.0));
            let write = ui.add_enabled(is_possible, write);
            let write = write.on_hover_text(&about).on_disabled_hover_text(about);
            if write.clicked() || entered && is_possible {
                if !paths.is_empty() {
                    out.send(Action::Export(paths, Existing::Ask));
                }
                if let Some(path) = report {
                    out.send(Action::Save(engine.report_content(), path, Existing::Ask));
                }
            }
        });
    }

    /// Says in one line what was written, or what is missing. The line is always there, so that nothing moves.
    fn outcome(&self, ui: &mut Ui, engine: &Engine) {
        let paths: Vec<PathBuf> =
            self.paths(engine).into_iter().chain(self.path_of(&[REPORT])).collect();
        let results = paths.iter().filter_map(|path| engine.exported(path));
        let (written, failed): (Vec<_>, Vec<_>) = results.partition(|result| result.is_ok());
        let text = format!("{} of {} written", written.len(), counted(paths.len(), "file"));
        let typed = PathBuf::from(self.path.trim());
        let unknown = typed.extension().and_then(|_| known_target(&typed).err());
        if let Some(unknown) = unknown {
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

    fn is_typed(&self, endings: &[&str]) -> bool {
        let typed = known_target(self.path.trim().as_ref());
        typed.is_ok_and(|typed| typed.endings == endings)
    }

    /// Returns the file to write in a format with these endings: the typed path, or the same path with the ending of a ticked
    /// format.
    fn path_of(&self, endings: &[&'static str]) -> Option<PathBuf> {
        let typed = PathBuf::from(self.path.trim());
        if self.is_typed(endings) {
            return Some(typed);
        }
        let is_chosen = self.also.contains(&endings[0]) && !typed.as_os_str().is_empty();
        is_chosen.then(|| typed.with_extension(endings[0]))
    }

    /// Returns the files to write. Files whose format cannot hold the present calibration are omitted.
    fn paths(&self, engine: &Engine) -> Vec<PathBuf> {
        let Some(analysis) = engine.analysis() else { return Vec::new() };
        let outline = Outline::of(&analysis.calibration);
        let typed = PathBuf::from(self.path.trim());
        let is_unknown = known_target(&typed).is_err() && typed.extension().is_some();
        let possible = TARGETS.iter().filter(|target| (target.refusal)(&outline).is_none());
        let paths = possible.filter_map(|target| self.path_of(target.endings));
        is_unknown.then_some(typed.clone()).into_iter().chain(paths).collect()
    }
}

/// Takes the place of the next row, and divides it: the purpose, the file, each part of the calibration, size and remark.
fn next_row(ui: &mut Ui, height: f32) -> (Rect, Rect, [Rect; PARTS.len()], Rect, Rect) {
    let width = ui.available_width().max(LEAST_WIDTH);
    let (_, row) = ui.allocate_space(egui::vec2(width, height));
    if (row.top() / height) as i32 % 2 == 0 {
        ui.painter().rect_filled(row, 0.0, ui.visuals().faint_bg_color);
    }
    let mut widths = [PART_WIDTH; PARTS.len() + 4];
    let last = widths.len() - 1;
    (widths[0], widths[1], widths[last - 1], widths[last]) =
        (f32::INFINITY, FILE_WIDTH, SIZE_WIDTH, REMARK_WIDTH);
    let [purpose, file, parts @ .., size, remark] = cells(row, 0.0, widths);
    (purpose, file, parts, size, remark.shrink2(egui::vec2(8.0, 0.0)))
}

fn row_height(ui: &Ui) -> f32 {
    let (tall, least, low) = ROW_HEIGHTS;
    if ui.ctx().content_rect().height() >= least { tall } else { low }
}

fn centred(ui: &mut Ui, rect: Rect, text: RichText) -> egui::Response {
    ui.put(rect, Label::new(text).extend())
}

/// Draws a tick, a cross or a dash: whether a file holds a part of the calibration.
fn mark(ui: &mut Ui, place: Rect, held: Held, part: &str, ending: &str) {
    let visuals = ui.visuals();
    let at = |x: f32, y: f32| place.center() + 4.0 * egui::vec2(x, y);
    let (words, color, lines) = match held {
        Held::Whole => {
            let tick = vec![at(-1.0, 0.0), at(-0.3, 0.9), at(1.2, -1.1)];
            ("contained", visuals.strong_text_color(), vec![tick])
        }
        Held::LeftOut => {
            let cross =
                vec![vec![at(-1.0, -1.0), at(1.0, 1.0)], vec![at(-1.0, 1.0), at(1.0, -1.0)]];
            ("left out", visuals.warn_fg_color, cross)
        }
        Held::NoPart => {
            ("not part of it", visuals.weak_text_color(), vec![vec![at(-0.7, 0.0), at(0.7, 0.0)]])
        }
    };
    for line in lines {
        ui.painter().add(egui::Shape::line(line, egui::Stroke::new(1.8, color)));
    }
    let response = ui.interact(place, ui.scope_id().with((ending, part)), egui::Sense::hover());
    named(&response, egui::Role::Label, &format!(".{ending}, {part}: {words}"));
    response.on_hover_text(words);
}

/// Draws the result of the last export to this file. Returns false if there was none.
fn result(ui: &mut Ui, rect: Rect, path: Option<PathBuf>, engine: &Engine) -> bool {
    let found = path.as_ref().and_then(|path| engine.exported(path));
    match found {
        None => {}
        Some(Ok(())) => drop(place(ui, rect, |ui| ui.label("Written"))),
        Some(Err(reason)) => {
            let text = RichText::new(reason).color(ui.visuals().error_fg_color);
            place(ui, rect, |ui| ui.add(Label::new(text).truncate()));
        }
    }
    found.is_some()
}
