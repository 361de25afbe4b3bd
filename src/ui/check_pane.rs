//! Whether the data carry the model: the verdict with its reasons, what the loads reach, and which to record next.

use egui::{ComboBox, RichText};

use crate::engine::Engine;
use crate::finding::{Face, Verdict};
use crate::questions::HangingMass;
use crate::questions::check::independent_loads::Sufficiency;
use crate::questions::check::query::CheckData;
use crate::questions::check::{pair_figure, sufficiency_tables};
use crate::recording::Axis;
use crate::report::Table;
use crate::report::figure::color;
use crate::ui::choice::choice;
use crate::ui::command::{Command, Kind, Pane};
use crate::ui::controls::Controls as _;
use crate::ui::palette::{Trace, bytes};
use crate::ui::pane::{Cx, PaneView};
use crate::ui::plots;
use crate::ui::plots::Zoom;
use crate::ui::table;

/// Height of the figure.
const FIGURE_HEIGHT: f32 = 260.0;
/// Its width.
const FIGURE_WIDTH: f32 = 380.0;

/// The pane.
pub const PANE: Pane = Pane(&Kind {
    key: "check",
    title: "Enough data?",
    explanation: "Whether the recordings carry the model, and which loads to record next",
});

/// What is chosen.
#[derive(Debug)]
pub struct View {
    /// Whether only what a hanging mass makes is proposed.
    hangs: bool,
    mass_kg: f64,
    arm_m: f64,
    /// The axes of the figure; `None` takes the pair of which least is enclosed.
    pair: Option<[Axis; 2]>,
    zoom: Zoom,
}

impl Default for View {
    fn default() -> Self {
        Self { hangs: false, mass_kg: 1.0, arm_m: 0.1, pair: None, zoom: None }
    }
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        self.draw(ui, cx.engine, cx.out);
        let hanging =
            self.hangs.then(|| HangingMass { masses: vec![self.mass_kg], arms: vec![self.arm_m] });
        let project = cx.engine.project();
        if !project.recordings.entries().is_empty() {
            cx.ask(CheckData::of(&cx.engine.request(), project.gauge_range.clone(), hanging));
        }
    }
}

impl View {
    fn draw(&mut self, ui: &mut egui::Ui, engine: &Engine, out: &mut Vec<Command>) {
        let check = engine.lane::<CheckData>();
        let found = check.answer();
        let tables: Vec<Table> = found.map_or_else(Vec::new, sufficiency_tables);
        ui.horizontal_wrapped(|ui| {
            let hangs = ui.checkbox(&mut self.hangs, "Hanging mass");
            hangs.on_hover_text(
                "Propose only loads that a mass makes, the sensor turned any way: F = m g n, M = r × F",
            );
            ui.add_enabled_ui(self.hangs, |ui| {
                let fields = [
                    (&mut self.mass_kg, " kg", 0.05, "The mass that hangs on the sensor"),
                    (&mut self.arm_m, " m", 0.005, "How far from the sensor's origin it can hang, along any of its axes"),
                ];
                for (value, unit, speed, about) in fields {
                    let field = egui::DragValue::new(value).range(0.001..=10_000.0).speed(speed).suffix(unit);
                    ui.add(field).on_hover_text(about);
                }
            });
            ui.separator();
            table::copy_button(ui, &tables);
        });
        ui.separator();
        if let Some(problem) = check.problem() {
            ui.warn(problem);
        }
        let Some(found) = found else {
            ui.weak("Nothing to check yet.");
            return;
        };
        let width = ui.available_width();
        ui.scrolled(|ui| {
            ui.vertical(|ui| {
                ui.set_max_width(width);
                verdict(ui, found, check.is_current());
            });
            ui.add_space(8.0);
            for shown in &tables {
                table::show(ui, shown);
                ui.add_space(8.0);
            }
            self.figure(ui, found, out);
        });
    }

    /// The loads of two axes.
    fn figure(&mut self, ui: &mut egui::Ui, found: &Sufficiency, out: &mut Vec<Command>) {
        let covered = |axes: &[Axis; 2]| {
            let pair = found.pairs.iter().find(|own| own.axes == *axes);
            pair.and_then(|own| own.covered)
        };
        let least = found.pairs.iter().filter(|own| own.covered.is_some());
        let least =
            least.min_by(|a, b| a.covered.unwrap_or(1.0).total_cmp(&b.covered.unwrap_or(1.0)));
        let chosen = self.pair.filter(|axes| covered(axes).is_some()).or(least.map(|own| own.axes));
        let Some(mut pair) = chosen else {
            return;
        };
        let name = |[a, b]: [Axis; 2]| format!("{}, {}", a.symbol(), b.symbol());
        ui.horizontal(|ui| {
            let label = ui.label("Axes");
            let button = ComboBox::from_id_salt("pair of axes").selected_text(name(pair));
            let items = found.pairs.iter().filter(|own| own.covered.is_some());
            let items = items
                .map(|own| (own.axes, name(own.axes).into(), "The training loads on these two"));
            let response = choice(ui, button, &mut pair, items.collect::<Vec<_>>());
            response
                .labelled_by(label.id)
                .on_hover_text("Whose loads are drawn; at first those of which least is enclosed");
        });
        if Some(pair) != chosen {
            (self.pair, self.zoom) = (Some(pair), None);
        }
        let at = pair.map(|axis| found.axes.iter().position(|own| own.axis == axis).unwrap_or(0));
        let ink = bytes(Trace::Compensated.color(ui.visuals()));
        let guide = bytes(ui.visuals().weak_text_color());
        let figures = [(ink, guide), (color::COMPENSATED, color::GUIDE)]
            .map(|inks| pair_figure(found, at, inks));
        if let [Some(mut drawing), Some(print)] = figures {
            if let Some(zoom) = self.zoom {
                (drawing.across.range, drawing.up.range) = (zoom.loads, zoom.outputs);
            }
            ui.allocate_ui(egui::vec2(FIGURE_WIDTH, FIGURE_HEIGHT), |ui| {
                plots::plot(
                    ui,
                    "pair of loads",
                    FIGURE_HEIGHT,
                    [&drawing, &print],
                    &mut self.zoom,
                    out,
                );
            });
        }
    }
}

/// The verdict, its reasons, and what is known of rank and condition.
fn verdict(ui: &mut egui::Ui, found: &Sufficiency, is_current: bool) {
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
    ui.weak(found.rank_in_words());
    for direction in &found.undetermined {
        ui.weak(format!("    {direction}"));
    }
}
