//! Controls of the reversal threshold and of the shortest dwell.

use egui::{DragValue, Ui, WidgetText};

use crate::{
    questions::metrology::MetrologySettings, recording::Axis, ui::controls::Controls as _,
};

const EXPLANATION: &str = "A reversal counts once the load has turned back by more than this threshold. From data: ten times the noise of the load, and at least 5 % of its range";

const LONGEST_DWELL_SECS: f64 = 1e5;

/// Draws the label and the value of the reversal threshold of one axis, and the switch "from data". `used` is the threshold
/// with which the loops on screen were found.
pub fn reversal_threshold(
    ui: &mut Ui,
    name: &str,
    (axes, at): (&[Axis], usize),
    measuring: &mut MetrologySettings,
    used: Option<f64>,
) {
    let entered = measuring.reversal_thresholds.get(at).copied().flatten();
    let unit = axes[at].unit();
    let chosen =
        or_from_data(ui, name, EXPLANATION, (entered, used.unwrap_or_default()), |field| {
            field.range(0.0..=f64::MAX).speed(0.01).max_decimals(4).suffix(format!(" {unit}"))
        });
    if chosen != entered {
        measuring.reversal_thresholds.resize(axes.len(), None);
        measuring.reversal_thresholds[at] = chosen;
    }
}

/// Draws a label, a value and the switch "from data". The switch removes the entered value, so that the value follows from
/// the data. Returns the entered value.
pub fn or_from_data(
    ui: &mut Ui,
    name: impl Into<WidgetText>,
    explanation: &str,
    (mut entered, used): (Option<f64>, f64),
    style: impl FnOnce(DragValue<'_>) -> DragValue<'_>,
) -> Option<f64> {
    let mut value = entered.unwrap_or(used);
    if ui.field(name, style(DragValue::new(&mut value)), explanation).changed() {
        entered = Some(value);
    }
    let mut from_data = entered.is_none();
    // The switch is not labelled "auto", because the switch of the ridge has this label.
    if ui.tick(&mut from_data, "from data", explanation) {
        entered = (!from_data).then_some(value);
    }
    entered
}

pub fn dwell_secs(ui: &mut Ui, name: &str, measuring: &mut MetrologySettings) {
    let explanation = "A dwell is an interval of at least this time with a constant load. Constant means that every axis stays within 1 % of its full scale (see \"Definitions…\") or ten times its noise";
    let field = DragValue::new(&mut measuring.hold_secs)
        .range(0.1..=LONGEST_DWELL_SECS)
        .speed(0.1)
        .suffix(" s");
    ui.field(name, field, explanation);
}
