//! Four cards below the loop: its largest and mean width, the nonlinearity of the axis, and the time lag, each without and with
//! compensation.

use egui::{Color32, Label, Rect, RichText, Sense, Ui, Vec2, WidgetInfo};

use crate::{
    engine::Engine,
    questions::{
        loops::{Look, LoopView, lag_in_words, query::LookAt},
        metrology::Quantity,
    },
    report::Trace,
    ui::{command::Pane, controls::place_down, numbers::significant},
};

pub const HEIGHT: f32 = 64.0;
/// Width of the place beside the cards (points).
const BESIDE_WIDTH: f32 = 112.0;
const GAP: f32 = 8.0;
const TITLE_SIZE: f32 = 12.0;
const VALUE_SIZE: f32 = 20.0;

struct Card {
    title: &'static str,
    /// Values without and with compensation, each in the colour of its load; one value for a gauge, none if not known.
    values: Vec<(String, Color32)>,
    unit: String,
    /// Definition, or the reason why the value is not known.
    about: String,
}

/// Draws the cards, and returns the free place at their right.
pub fn show(ui: &mut Ui, engine: &Engine, view: &LoopView<'_>) -> Rect {
    let cards = [
        width(ui, view, 0, "Largest width"),
        width(ui, view, 1, "Mean width"),
        nonlinearity(ui, engine, view),
        lag(ui, view),
    ];
    ui.add_space(GAP);
    let (whole, _) =
        ui.allocate_exact_size(Vec2::new(ui.available_width(), HEIGHT), Sense::hover());
    let beside = whole.with_min_x((whole.right() - BESIDE_WIDTH).max(whole.left()));
    let step = (beside.left() - whole.left()) / cards.len() as f32;
    for (at, card) in cards.iter().enumerate() {
        let left = whole.left() + at as f32 * step;
        card.draw(ui, whole.with_min_x(left).with_max_x(left + step - GAP));
    }
    beside
}

impl Card {
    fn draw(&self, ui: &mut Ui, place: Rect) {
        ui.painter().rect_filled(place, 4.0, ui.visuals().faint_bg_color);
        let text = |text: &str, size: f32| RichText::new(text).size(size);
        place_down(ui, place.shrink2(Vec2::new(12.0, 6.0)), self.title, |ui| {
            ui.shrink_clip_rect(place);
            ui.spacing_mut().item_spacing = Vec2::new(6.0, 0.0);
            ui.add(Label::new(text(self.title, TITLE_SIZE).weak()).selectable(false));
            let arrow = text("→", VALUE_SIZE).weak();
            let unit = if self.values.is_empty() { "" } else { &self.unit };
            let unit = text(unit, TITLE_SIZE).weak();
            let values = self.values.iter();
            let mut parts: Vec<RichText> =
                values.map(|(value, color)| text(value, VALUE_SIZE).color(*color)).collect();
            match parts.len() {
                0 => parts.push(text("not known", VALUE_SIZE).weak()),
                2 => parts.insert(1, arrow),
                _ => {}
            }
            ui.horizontal(|ui| {
                for part in parts.into_iter().chain([unit]) {
                    ui.add(Label::new(part).selectable(false));
                }
            });
        });
        let response = ui.interact(place, ui.scope_id().with(self.title), Sense::hover());
        response.widget_info(|| {
            let values = self.values.iter().map(|(value, _)| &**value).collect::<Vec<_>>();
            let text = if values.is_empty() {
                format!("{}: not known, {}", self.title, self.about)
            } else {
                format!("{}: {} {}", self.title, values.join(" → "), self.unit)
            };
            WidgetInfo::labeled(egui::Role::Label, true, text)
        });
        response.on_hover_text(&self.about);
    }
}

/// Returns the card of one of the measures of the loop.
fn width(ui: &Ui, view: &LoopView<'_>, measure: usize, title: &'static str) -> Card {
    let found = view.found();
    let values = found.iter().map(|(output, figures)| {
        let color = output.map_or(ui.visuals().text_color(), |trace| trace.color(ui.visuals()));
        (significant(figures.measures[measure], 3), color)
    });
    let reason = view.shown.iter().find_map(|curve| view.figures(curve).err());
    let about = match reason {
        Some(reason) => reason.to_string(),
        None => "Distance of the rising and the falling branch at equal load, on the thick loop"
            .to_owned(),
    };
    Card { title, values: values.collect(), unit: view.unit().to_owned(), about }
}

/// Returns the card of the nonlinearity, which the table of metrology figures holds.
fn nonlinearity(ui: &Ui, engine: &Engine, view: &LoopView<'_>) -> Card {
    let axis = view.plot.question.axis;
    let table = match engine.lane_of::<LookAt>(Pane::METROLOGY.key).answer() {
        Some(Look::Table(table)) => Some(table),
        _ => None,
    };
    let cell = table.and_then(|table| {
        let at = table.axes.iter().position(|known| *known == axis)?;
        let row = table.rows.iter().find(|row| row.quantity == Quantity::BestFitNonlinearity)?;
        row.cells.get(at)
    });
    let mut values = Vec::new();
    let mut about =
        "Largest distance of the mean of both branches from the best straight line".to_owned();
    if let Some(cell) = cell {
        for (trace, figure) in
            [(Trace::Conventional, &cell.conventional), (Trace::Compensated, &cell.compensated)]
        {
            match figure {
                Ok(value) => {
                    values.push((significant(value.value, 3), trace.color(ui.visuals())));
                }
                Err(reason) => about = reason.to_string(),
            }
        }
    }
    Card { title: "Nonlinearity", values, unit: axis.unit().to_owned(), about }
}

fn lag(ui: &Ui, view: &LoopView<'_>) -> Card {
    let about = lag_in_words(&view.plot.lag);
    let color = Trace::Conventional.color(ui.visuals());
    let (values, unit) = match &view.plot.lag.lag {
        Err(_) => (Vec::new(), String::new()),
        Ok(lag) => {
            let error = significant(2.0 * lag.standard_error_secs, 2);
            let value =
                if lag.is_significant() { significant(lag.seconds, 3) } else { "none".to_owned() };
            (vec![(value, color)], format!("± {error} s"))
        }
    };
    Card { title: "Time lag", values, unit, about }
}
