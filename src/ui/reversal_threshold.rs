//! Controls of the reversal threshold and of the shortest dwell.

use egui::{DragValue, Ui};

use crate::questions::metrology::MetrologySettings;
use crate::recording::Axis;
use crate::ui::controls::Controls as _;

const EXPLANATION: &str = "A reversal counts once the load has come back by more than this, in the loops, the table of figures \
                           and the report alike; from data: ten times the noise of the load, and at least 5 % of its range, over \
                           all recordings that train or test. Large cycles hardly depend on it";

const LONGEST_DWELL_SECS: f64 = 1e5;

/// Draws the label, the value and the switch "from data" of the reversal threshold of the axis at this position. `used` is
/// the value of the present answer.
pub fn reversal_threshold(
    ui: &mut Ui,
    name: &str,
    (axes, at): (&[Axis], usize),
    measuring: &mut MetrologySettings,
    used: Option<f64>,
) {
    let mut chosen = measuring.reversal_thresholds.get(at).copied().flatten();
    let before = chosen;
    let mut value = chosen.or(used).unwrap_or_default();
    let field = DragValue::new(&mut value)
        .range(0.0..=f64::MAX)
        .speed(0.01)
        .max_decimals(4)
        .suffix(format!(" {}", axes[at].unit()));
    if ui.explained_field(name, field, EXPLANATION).changed() {
        chosen = Some(value);
    }
    let mut from_data = chosen.is_none();
    // The word "auto" is used for the ridge alone.
    if ui.tick(&mut from_data, "from data", EXPLANATION) {
        chosen = (!from_data).then_some(value);
    }
    if chosen != before {
        measuring.reversal_thresholds.resize(axes.len(), None);
        measuring.reversal_thresholds[at] = chosen;
    }
}

pub fn dwell_secs(ui: &mut Ui, name: &str, measuring: &mut MetrologySettings) {
    let explanation = "A load that stays constant for at least this time is a dwell; dwells show creep and zero return. Constant: every axis \
                       stays within 1 % of its full scale or ten times its noise, whichever is larger. \"Definitions…\" changes this";
    let field = DragValue::new(&mut measuring.hold_secs)
        .range(0.1..=LONGEST_DWELL_SECS)
        .speed(0.1)
        .suffix(" s");
    ui.explained_field(name, field, explanation);
}
