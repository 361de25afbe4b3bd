//! Pane with the error of each tried model against the memory that it needs on a controller.

use egui::{FontId, RichText, Sense, Ui, Vec2};
use egui_plot::{Line, Points};

use crate::{
    engine::{Action, Row},
    questions::Mark,
    scoring::{numbers::significant, score_set::ScoreSet},
    ui::{
        numbers::elided,
        palette::Trace,
        pane::{Cx, PaneView},
        plots,
    },
};

/// Maximum distance of the pointer from a model that it names (points).
const NEAR: f32 = 14.0;
const NAME_LENGTH: usize = 44;

#[derive(Debug, Default)]
pub struct View;

/// A model in the plot.
struct Tried<'a> {
    row: &'a Row,
    /// Logarithm of the memory (kB) and error (% of conventional).
    at: [f64; 2],
    is_present: bool,
}

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        let project = cx.engine.project();
        let rows = cx.engine.models.rows.iter().filter(|row| !row.is_stale(project));
        let models: Vec<Tried<'_>> = rows
            .filter_map(|row| {
                let percent = 100.0 * row.model.relative(ScoreSet::LeftOut)?;
                let kilobytes = row.model.cost.bytes.max(1) as f64 / 1e3;
                let at = [kilobytes.log10(), percent];
                Some(Tried { row, at, is_present: row.is_present(project) })
            })
            .collect();
        if models.is_empty() {
            ui.weak("Each model that is tried or kept becomes a point here: its cross-validated error against its memory.");
            return;
        }
        let visuals = ui.visuals().clone();
        let [orange, blue] =
            [Trace::Conventional, Trace::Compensated].map(|trace| trace.color(&visuals));
        let plot = plots::still("trade", ui.available_size().into());
        let plot = plots::scales(plot, Some("memory [kB]"), "error [% of conventional]")
            .include_y(0.0)
            .include_y(100.0)
            .x_grid_spacer(|input| {
                let (from, to) = input.bounds;
                let decades = from.floor() as i32..=to.ceil() as i32;
                let mark =
                    |decade| egui_plot::GridMark { value: f64::from(decade), step_size: 1.0 };
                decades.map(mark).collect()
            })
            .x_axis_formatter(|mark, _| significant(10.0_f64.powf(mark.value), 1))
            .set_margin_fraction(Vec2::new(0.08, 0.06))
            .sense(Sense::click());
        let shown = plot.show(ui, |plot| {
            plot.line(
                Line::new("", best_line(&models)).color(visuals.weak_text_color()).width(1.0),
            );
            for model in &models {
                let is_large = model.is_present || model.row.mark != Mark::None;
                let is_conventional = !model.row.model.settings.features.adds_columns();
                let color = if is_conventional { orange } else { blue };
                let points = Points::new(&*model.row.name, vec![model.at]);
                plot.points(points.color(color).radius(if is_large { 6.0 } else { 3.5 }));
            }
        });
        let place = |model: &Tried<'_>| {
            shown.transform.position_from_point(&egui_plot::PlotPoint::from(model.at))
        };
        let painter = ui.painter_at(shown.response.rect);
        let mut names: Vec<(&Tried<'_>, &str)> = Vec::new();
        names.extend(models.iter().filter(|model| model.is_present).map(|model| (model, "in use")));
        for (mark, name) in [(Mark::Proposed, "proposed"), (Mark::Smallest, "smallest as good")] {
            let marked = models.iter().filter(|model| model.row.mark == mark && !model.is_present);
            names.extend(marked.map(|model| (model, name)));
        }
        for (model, name) in names {
            let (font, color) = (FontId::proportional(12.0), visuals.text_color());
            let text = painter.layout_no_wrap(name.to_owned(), font, color);
            let above = place(model) - Vec2::new(0.5 * text.size().x, text.size().y + 8.0);
            // A name stays inside the plot.
            let most = shown.response.rect.right() - text.size().x - 2.0;
            painter.galley(egui::pos2(above.x.min(most), above.y), text, color);
        }
        let pointer = shown.response.hover_pos();
        let distance = |model: &Tried<'_>| pointer.map_or(f32::MAX, |at| at.distance(place(model)));
        let nearest = models.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(model) = nearest.filter(|model| distance(model) < NEAR) {
            let [_, percent] = model.at;
            let kilobytes = significant(model.row.model.cost.bytes as f64 / 1e3, 3);
            shown.response.clone().on_hover_ui_at_pointer(|ui| {
                ui.label(RichText::new(elided(&model.row.name, NAME_LENGTH)).strong());
                let percent = significant(percent, 3);
                ui.label(format!("{percent} % of the conventional error, {kilobytes} kB"));
                ui.weak("A press applies this model; undo restores the present one");
            });
            if shown.response.clicked() {
                cx.out.send(Action::BringBack(model.row.id));
            }
        }
        plots::finish(&shown.response, "Error of the models against their memory", None, cx.out);
    }
}

/// Returns the points of the models than which no smaller model is as good, from the smallest to the best.
fn best_line(models: &[Tried<'_>]) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = models.iter().map(|model| model.at).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut least = f64::INFINITY;
    points.retain(|[_, percent]| {
        let is_better = *percent < least;
        least = least.min(*percent);
        is_better
    });
    points
}
