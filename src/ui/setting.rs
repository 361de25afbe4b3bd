//! A field for a number, as its setting says.

use egui::DragValue;
use egui::emath::Numeric;

use crate::features::Setting;

/// Draws the label and the field.
pub fn number<N: Numeric>(ui: &mut egui::Ui, setting: &Setting, value: &mut N) {
    let label = ui.label(setting.label);
    let (min, max) = setting.range.ends();
    let mut field = DragValue::new(value).range(min..=max).speed(setting.step);
    if !N::INTEGRAL {
        field = field.max_decimals(6);
    }
    let field = ui.add(field).labelled_by(label.id);
    field.on_hover_text(setting.help());
}

/// Draws a switch.
pub fn switch(ui: &mut egui::Ui, setting: &Setting, on: &mut bool) {
    ui.checkbox(on, setting.label).on_hover_text(setting.help());
}
