//! The blocks beside the look-back: a switch, a list of numbers and a sentence each.

use egui::{Id, TextEdit};

use crate::features::FeatureSettings;

/// Draws the switches.
pub fn blocks(ui: &mut egui::Ui, features: &mut FeatureSettings) {
    let lag = [FeatureSettings::DEFAULT_LAG_SECS];
    for (name, unit, explanation, values, default) in [
        (
            "Fixed lag",
            "s",
            "Appends the gauges so many seconds ago: the plainest history (references 23 and 24 of the paper)",
            &mut features.fixed_lags_secs,
            &lag[..],
        ),
        (
            "Creep",
            "s",
            "Appends low-passes of each gauge with these time constants: what follows a load only slowly (reference 22)",
            &mut features.creep_secs,
            &FeatureSettings::DEFAULT_CREEP_SECS[..],
        ),
        (
            "Play",
            "SD",
            "Appends play operators: each gauge dragged through a clearance of ± these radii, in standard deviations of the \
             gauge. They remember the last reversals, as hysteresis does (Prandtl-Ishlinskii)",
            &mut features.play_radii,
            &FeatureSettings::DEFAULT_PLAY_RADII[..],
        ),
    ] {
        ui.horizontal(|ui| {
            let mut used = !values.is_empty();
            let id = Id::unique((name, "while it is off"));
            let switch = ui.checkbox(&mut used, name).on_hover_text(explanation);
            if switch.changed() {
                *values = if used {
                    let kept = ui.data(|data| data.get_temp::<Vec<f64>>(id));
                    kept.unwrap_or_else(|| default.to_vec())
                } else {
                    ui.data_mut(|data| data.insert_temp(id, values.clone()));
                    Vec::new()
                };
            }
            ui.add_enabled_ui(used, |ui| {
                list_field(ui, switch.id, "", explanation, values);
                ui.label(unit);
            });
        });
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Polynomial");
        for (degree, label, explanation) in [
            (1, "none", "The gauges as they are"),
            (2, "squares", "Squares and products of the gauges: no past, only nonlinearity. What they take away was no hysteresis"),
            (3, "cubes", "Squares, products and cubes of the gauges"),
        ] {
            let selected = features.polynomial == degree;
            if ui.selectable_label(selected, label).on_hover_text(explanation).clicked() {
                features.polynomial = degree;
            }
        }
    });
}

/// A field with numbers above zero and commas between them; true once they changed. What cannot be read is marked and
/// changes nothing.
pub fn list_field(
    ui: &mut egui::Ui,
    label: Id,
    hint: &str,
    explanation: &str,
    values: &mut Vec<f64>,
) -> bool {
    let id = label.with("numbers");
    let shown = values
        .iter()
        // Percentages come from shares; their last digits are rounding.
        .map(|value| ((value * 1e9).round() / 1e9).to_string())
        .collect::<Vec<_>>()
        .join(", ");
    let typed = ui.data(|data| data.get_temp::<String>(id));
    let mut text = typed.unwrap_or_else(|| shown.clone());
    let read = parse(&text);
    let mut field = TextEdit::singleline(&mut text)
        .id(id.with("field"))
        .hint_text(hint)
        .desired_width((ui.available_width() - 30.0).clamp(60.0, 260.0));
    if read.is_none() {
        field = field.text_color(ui.visuals().error_fg_color);
    }
    let response = ui.add(field).labelled_by(label);
    let response = response.on_hover_text(match read {
        Some(_) => explanation,
        None => "Write numbers above zero with commas between them",
    });
    if !response.has_focus() {
        ui.data_mut(|data| data.remove::<String>(id));
        return false;
    }
    let read = parse(&text);
    ui.data_mut(|data| data.insert_temp(id, text));
    match read {
        Some(read) if read != *values && response.changed() => {
            *values = read;
            true
        }
        _ => false,
    }
}

fn parse(text: &str) -> Option<Vec<f64>> {
    text.split(',')
        .map(str::trim)
        .filter(|cell| !cell.is_empty())
        .map(|cell| {
            cell.parse()
                .ok()
                .filter(|value: &f64| *value > 0.0 && value.is_finite())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_while_they_are_typed() {
        assert_eq!(parse("0.1, 0.2,"), Some(vec![0.1, 0.2]));
        assert_eq!(parse(""), Some(vec![]));
        assert_eq!(parse("0.1, x"), None);
        assert_eq!(parse("-1"), None);
        assert_eq!(parse("0"), None);
    }
}
