//! What a projector shows: one sentence, the map or the loops beside one axis over time, and the two thresholds.

use egui::{Rect, RichText, Ui, UiBuilder, Vec2};

use crate::ui::{
    command::Pane,
    controls::place_down,
    dock,
    numbers::significant,
    palette::Trace,
    pane::Cx,
    panes::Views,
    scope::{Errors, scale_of},
};

/// Heights of the sentence and of the sliders (points).
const HEAD_HEIGHT: f32 = 76.0;
const FOOT_HEIGHT: f32 = 100.0;
const SENTENCE_SIZE: f32 = 27.0;
const SCOPE_SIZE: f32 = 14.0;
const PADDING: f32 = 16.0;
/// Size of the screen (points of the display) at which everything is this much larger than in the window.
const SCREEN: Vec2 = Vec2::new(1600.0, 900.0);
const LARGER: f32 = 1.5;

/// State of presenter mode.
#[derive(Debug, Default)]
pub struct Presenter {
    pub is_on: bool,
    /// Shows the loops in place of the map.
    pub shows_loops: bool,
}

impl Presenter {
    /// Returns the factor by which everything is larger than in the window, so that each screen shows the same picture.
    pub fn scale(&self, context: &egui::Context) -> f32 {
        if !self.is_on {
            return 1.0;
        }
        let inside = context.input(|input| input.viewport().inner_rect);
        let size = inside.map_or(SCREEN, |inside| context.zoom_factor() * inside.size());
        LARGER * (size.x / SCREEN.x).min(size.y / SCREEN.y).max(0.1)
    }

    pub fn draw(&self, ui: &mut Ui, views: &mut Views, cx: &mut Cx<'_>) {
        let whole = ui.max_rect();
        let head = whole.with_max_y(whole.top() + HEAD_HEIGHT);
        let foot = whole.with_min_y(whole.bottom() - FOOT_HEIGHT);
        let middle = whole.with_min_y(head.bottom()).with_max_y(foot.top());
        sentence(ui, cx, head.shrink2(Vec2::new(PADDING, 8.0)));
        let left = if self.shows_loops { Pane::LOOPS } else { Pane::THRESHOLDS };
        let parts = [
            (left, middle.with_max_x(middle.center().x)),
            (Pane::TRACES, middle.with_min_x(middle.center().x)),
        ];
        for (pane, place) in parts {
            part(ui, pane, place, views, cx);
        }
        dock::thresholds(ui, cx, foot.shrink2(Vec2::new(PADDING, 4.0)));
    }
}

fn part(ui: &mut Ui, pane: Pane, place: Rect, views: &mut Views, cx: &mut Cx<'_>) {
    let inside = place.shrink2(Vec2::new(PADDING, 4.0));
    let mut ui = ui.new_child(UiBuilder::new().max_rect(inside).id_salt(pane.key));
    ui.shrink_clip_rect(place);
    if let Some(view) = views.of(pane) {
        view.ui(&mut ui, cx);
    }
}

/// Draws the error with and without compensation in large letters, and the names of the lines.
fn sentence(ui: &mut Ui, cx: &Cx<'_>, place: Rect) {
    let Some(analysis) = cx.engine.analysis() else { return };
    let scale = scale_of(analysis);
    let measure = cx.scope.measure(&scale);
    let errors = Errors::of(analysis, cx.scope.on);
    let both = errors.as_ref().and_then(|errors| {
        let of = |rmse: &[f64]| measure.of_rmse(&scale, rmse);
        Some((errors.on, of(errors.before)?, of(errors.after)?))
    });
    let Some((on, before, after)) = both else { return };
    let unit = measure.unit(&scale);
    let [before, after] = [before, after].map(|error| format!("{} {unit}", significant(error, 3)));
    let visuals = ui.visuals().clone();
    let [orange, blue] =
        [Trace::Conventional, Trace::Compensated].map(|trace| trace.color(&visuals));
    let is_compensated = cx.time.is_shown(Trace::Compensated);
    let words = if is_compensated {
        vec![(after, blue), (" instead of ".to_owned(), visuals.text_color()), (before, orange)]
    } else {
        vec![(before, orange), (" without compensation".to_owned(), visuals.text_color())]
    };
    place_down(ui, place, "sentence", |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 0.0;
            for (text, color) in words {
                ui.label(RichText::new(text).size(SENTENCE_SIZE).color(color));
            }
        });
        ui.horizontal(|ui| {
            let scope = format!("{}, {}", measure.title(&scale), on.label());
            ui.label(RichText::new(scope).size(SCOPE_SIZE).weak());
            for trace in Trace::LISTED.into_iter().filter(|trace| *trace != Trace::Factory) {
                let name = RichText::new(format!("— {}", trace.label())).size(SCOPE_SIZE);
                ui.label(name.color(trace.color(&visuals)));
            }
        });
    });
}
