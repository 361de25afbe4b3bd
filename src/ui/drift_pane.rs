//! The same sensor on other days: what moved, and how much of the calibration has to be fitted again.

use std::sync::Arc;

use crate::engine::{Action, Engine, Existing, FileContent};
use crate::evaluation::sessions::Refit;
use crate::report::{Table, drift_figures, drift_tables};
use crate::ui::command::{Command, Kind, Pane};
use crate::ui::numbers::duration;
use crate::ui::pane::{Cx, PaneView};
use crate::ui::plots::{self, Zoom};
use crate::ui::status_line::busy;
use crate::ui::table;

/// Height of a figure.
const FIGURE_HEIGHT: f32 = 220.0;
/// Its width.
const FIGURE_WIDTH: f32 = 420.0;

/// The pane.
pub const PANE: Pane = Pane(&Kind {
    key: "drift",
    title: "Between days",
    explanation: "What moved between days, and how much of the calibration to fit again",
});

/// What is typed and zoomed.
#[derive(Debug)]
pub struct View {
    path: String,
    zooms: [Zoom; 2],
}

impl Default for View {
    fn default() -> Self {
        Self {
            path: "refitted.json".to_owned(),
            zooms: [None; 2],
        }
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        self.draw(ui, cx.engine, cx.out);
        // Asked only where it is on screen.
        cx.engine.ask_drift();
    }
}

/// Trains again what was learned, or says how far it is.
fn train_button(ui: &mut egui::Ui, engine: &Engine, out: &mut Vec<Command>) {
    let trains = engine.drift.asked().is_some_and(|asked| asked.trains);
    let Some(running) = engine.drift.running().filter(|_| trains) else {
        let button = ui.add_enabled(!trains, egui::Button::new("Train again"));
        let button = button
            .on_hover_text(
                "Trains the network or kernel again on the new recordings, with the settings of now, and scores it on parts that it has \
                 not seen. It can be stopped at any time",
            )
            .on_disabled_hover_text("It was trained again on these recordings");
        if button.clicked() {
            out.push(Action::TrainDays(true).into());
        }
        return;
    };
    busy(ui);
    let done = running.progress.fraction().unwrap_or(0.0);
    let left = running.time_left();
    let left = left.map_or_else(String::new, |left| format!(", {} left", duration(left)));
    ui.label(format!("training again: {:.0} %{left}", 100.0 * done));
    let stop = ui.add_enabled(
        !running.progress.is_cancelled(),
        egui::Button::new("Stop training"),
    );
    if stop
        .on_hover_text("Goes back to what is there without it")
        .clicked()
    {
        out.push(Action::TrainDays(false).into());
    }
}

impl View {
    fn draw(&mut self, ui: &mut egui::Ui, engine: &Engine, out: &mut Vec<Command>) {
        let drifted = engine.drift.answer();
        let tables: Vec<Table> = drifted.map_or_else(Vec::new, |own| drift_tables(&own.found));
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Export to");
            let field = egui::TextEdit::singleline(&mut self.path).desired_width(140.0);
            let field = ui.add(field).labelled_by(label.id);
            field.on_hover_text("Where a refitted calibration is written; the ending says how");
            for refit in Refit::ALL {
                let made = drifted.and_then(|own| {
                    own.calibrations
                        .iter()
                        .find(|(of, _)| *of == refit)
                        .map(|found| (own, found))
                });
                let problem = drifted.and_then(|own| {
                    own.found
                        .refits
                        .iter()
                        .find(|of| of.refit == refit)?
                        .problem
                        .clone()
                });
                let button = ui.add_enabled(made.is_some(), egui::Button::new(refit.label()));
                let button = button
                    .on_hover_text(format!(
                        "Exports the calibration with this fitted again: {}",
                        refit.explanation().to_lowercase()
                    ))
                    .on_disabled_hover_text(
                        problem.unwrap_or_else(|| "There is nothing new to fit to".to_owned()),
                    );
                if button.clicked()
                    && let Some((own, (_, calibration))) = made
                {
                    let content = FileContent::Calibration(
                        Arc::clone(calibration),
                        Some(Arc::clone(&own.fitted_to)),
                    );
                    out.push(Action::Save(content, self.path.trim().into(), Existing::Ask).into());
                }
            }
            if drifted.is_some_and(|own| own.is_learned) {
                train_button(ui, engine, out);
            }
            ui.separator();
            table::copy_button(ui, &tables);
        });
        ui.separator();
        if let Some(problem) = engine.drift.problem() {
            ui.colored_label(ui.visuals().warn_fg_color, problem);
        }
        let Some(drifted) = drifted else {
            ui.weak("Nothing to compare yet.");
            return;
        };
        let width = ui.available_width();
        egui::ScrollArea::both()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                ui.vertical(|ui| {
                    ui.set_max_width(width);
                    if !engine.drift.is_current() {
                        ui.weak("updating");
                    }
                    for sentence in &drifted.found.sentences {
                        ui.label(format!("• {sentence}."));
                    }
                });
                ui.add_space(8.0);
                for shown in &tables {
                    table::show(ui, shown);
                    ui.add_space(8.0);
                }
                let figures = drift_figures(&drifted.found);
                ui.horizontal_top(|ui| {
                    for (at, print) in figures.iter().enumerate() {
                        let mut drawing = print.clone();
                        if let Some(zoom) = self.zooms[at] {
                            (drawing.across.range, drawing.up.range) = (zoom.loads, zoom.outputs);
                        }
                        ui.vertical(|ui| {
                            ui.set_width(FIGURE_WIDTH);
                            ui.label(&print.title);
                            plots::plot(
                                ui,
                                &print.title,
                                FIGURE_HEIGHT,
                                [&drawing, print],
                                &mut self.zooms[at],
                                out,
                            );
                        });
                    }
                });
            });
    }
}
