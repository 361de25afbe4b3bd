//! How far a load must come back before a reversal counts: typed, or from the noise.

use egui::{DragValue, Ui};

use crate::recording::Axis;

const EXPLANATION: &str = "A reversal counts once the load has come back by more than this; from noise: ten times the noise \
                           of the load, and at least 2 % of its range";

/// Draws a label, the value and whether it comes from the noise. `chosen` is `None` where it does, and then `automatic` is
/// shown.
pub fn dead_band(
    ui: &mut Ui,
    name: &str,
    axis: Axis,
    chosen: &mut Option<f64>,
    automatic: Option<f64>,
) {
    let label = ui.label(name).on_hover_text(EXPLANATION);
    let mut value = chosen.or(automatic).unwrap_or_default();
    let field = DragValue::new(&mut value)
        .range(0.0..=f64::MAX)
        .speed(0.01)
        .max_decimals(4)
        .suffix(format!(" {}", axis.unit()));
    let field = ui.add(field).labelled_by(label.id);
    if field.on_hover_text(EXPLANATION).changed() {
        *chosen = Some(value);
    }
    let mut from_noise = chosen.is_none();
    // "auto" alone is the ridge's.
    let tick = ui.checkbox(&mut from_noise, "from noise");
    if tick.on_hover_text(EXPLANATION).changed() {
        *chosen = (!from_noise).then_some(value);
    }
}
