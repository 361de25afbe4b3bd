//! Pane of the data check: where the error comes from, verdict on the recordings, findings about faults, and range of the loads.

use egui::{RichText, Ui};

use crate::{
    engine::Engine,
    finding::{Face, Verdict},
    questions::check::{
        independent_loads::Sufficiency, query::CheckData, rig_figures, sufficiency_tables,
    },
    report::Table,
    ui::{
        command::{Out, Pane},
        controls::Controls as _,
        pane::{Cx, PaneView},
        plots::{self, Zoom},
        table,
    },
};

const FIGURE_HEIGHT: f32 = 260.0;
const FIGURE_WIDTH: f32 = 380.0;

pub const PANE: Pane = Pane {
    key: "check",
    title: "Check",
    explanation: "Shows where the error comes from, whether the recordings determine the model, and faults of the rig",
};

#[derive(Debug, Default)]
pub struct View {
    /// Visible ranges of the plot of the gauges' zeros, and of the plot of their sensitivities.
    zooms: [Zoom; 2],
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        self.draw(ui, cx.engine, cx.out);
        let project = cx.engine.project();
        if !project.recordings.entries().is_empty() {
            cx.ask(CheckData::of(&cx.engine.request(), project.valid_range()));
        }
    }
}

impl View {
    fn draw(&mut self, ui: &mut Ui, engine: &Engine, out: &mut Out) {
        let check = engine.lane::<CheckData>();
        let found = check.answer();
        let tables: Vec<Table> = found.map_or_else(Vec::new, sufficiency_tables);
        ui.horizontal_wrapped(|ui| {
            ui.add_enabled_ui(!tables.is_empty(), |ui| {
                ui.copies("tables", || table::joined(&tables));
            });
        });
        ui.separator();
        if let Some(problem) = check.problem() {
            ui.warn(problem);
        }
        let Some(found) = found else {
            if check.problem().is_none() {
                ui.awaited("The result of the check", engine);
            }
            return;
        };
        let width = ui.available_width();
        ui.scrolled(|ui| {
            let (budget, others) = tables.split_at(usize::from(found.budget.is_ok()));
            let show = |ui: &mut Ui, shown: &[Table]| {
                for shown in shown {
                    table::show(ui, shown);
                    ui.add_space(8.0);
                }
            };
            show(ui, budget);
            ui.vertical(|ui| {
                ui.set_max_width(width);
                for remedy in found.remedies_in_words() {
                    ui.label(format!("Remedy for {remedy}"));
                }
                verdict(ui, found, check.is_current());
            });
            ui.add_space(8.0);
            show(ui, others);
            self.figures(ui, found, out);
        });
    }

    fn figures(&mut self, ui: &mut Ui, found: &Sufficiency, out: &mut Out) {
        let figures = rig_figures(&found.rig);
        for (at, (figure, zoom)) in figures.iter().zip(&mut self.zooms).enumerate() {
            ui.allocate_ui(egui::vec2(FIGURE_WIDTH, FIGURE_HEIGHT), |ui| {
                let id = if at == 0 { "zeros" } else { "sensitivities" };
                plots::plot(ui, (id, None), FIGURE_HEIGHT, |_| figure.clone(), zoom, out);
            });
        }
    }
}

fn verdict(ui: &mut Ui, found: &Sufficiency, is_current: bool) {
    let words = RichText::new(found.verdict.words()).strong();
    let words = match found.verdict {
        Verdict::Enough => words,
        Verdict::Doubtful => words.color(ui.visuals().warn_fg_color),
        Verdict::Insufficient => words.color(ui.visuals().error_fg_color),
    };
    ui.horizontal(|ui| {
        ui.label(words);
        if !is_current {
            ui.weak("updating");
        }
    });
    for sentence in found.sentences(Face::Window) {
        ui.label(format!("• {sentence}."));
    }
    ui.label(&found.holds_for);
    ui.weak(found.rank_in_words());
}
