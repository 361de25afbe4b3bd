//! Controls of all features of the model except the look-back (earlier gauge values). Each feature has a switch and a list
//! of numbers, or a menu.

use egui::{Id, TextEdit, Ui};

use crate::{
    engine::{Action, Engine, query::Background as _},
    features::{Appends, BLOCKS, Block, Choice, Distance, FeatureSettings, Range},
    questions::thresholds::asked::ChooseBlock,
    ui::{
        command::Out,
        controls::Controls as _,
        numbers::significant,
        setting::{found, switched},
        status_line::busy,
    },
};

/// Explanation of the look-back.
pub const LOOK_BACK: &str = "Adds the gauges of an earlier sample to the fit: the last sample within the time threshold t_th whose conventional load differed by the force threshold F_th (Eq. 9-12 of Koike et al. 2019)";

/// Key of the look-backs that were switched off.
pub fn look_back_id() -> egui::Id {
    egui::Id::unique("look-backs that were turned off")
}

/// Returns the distance between two loads that is compared with the force threshold F_th: a norm over the force axes or over
/// all axes. Before recordings are loaded, the chosen distance is returned.
pub fn distance(engine: &Engine, features: &FeatureSettings) -> Distance {
    match engine.project().axes() {
        [] => features.distance,
        axes => features.distance.effective(axes),
    }
}

/// Draws the controls of these features. Features with memory are disabled for recordings without times.
pub fn blocks(ui: &mut Ui, features: &mut FeatureSettings, is_static: bool) {
    for &block in BLOCKS {
        let values = features.blocks.of(block).to_vec();
        let has_past = matches!(block.appends(), Appends::Past(_));
        let shown =
            ui.add_enabled_ui(!(is_static && has_past), |ui| match block.setting().choices() {
                Some(choices) => one_of(ui, block, choices, values),
                None => list(ui, block, values),
            });
        features.blocks.set(block, shown.inner);
    }
}

/// Draws the buttons that choose the values of a feature by cross-validation, and the last result.
pub fn choosing(ui: &mut Ui, engine: &Engine, out: &mut Out) {
    let choice = engine.lane::<ChooseBlock>();
    let choosing = !choice.is_idle();
    ui.horizontal_wrapped(|ui| {
        for block in BLOCKS.iter().copied().filter(|block| block.search().is_some()) {
            let label = format!("Choose {}", block.setting().label.to_lowercase());
            if ui.press_if(
                !choosing,
                label,
                "Chooses the shortest list of values whose cross-validated error is within 1 % of the smallest",
            ) {
                out.send(Action::ChooseBlock(block, None));
            }
        }
    });
    if choosing {
        busy(ui);
    } else if let Some(chosen) = choice.answer() {
        ui.label(format!(
            "{}: {}; cross-validated error {}, without this feature {} ({} lists of values were tried)",
            chosen.block.setting().label,
            chosen.block.setting().in_words(&chosen.values),
            significant(chosen.left_out, 4),
            significant(chosen.left_out_without, 4),
            chosen.n_tried
        ));
    }
}

/// Switches a feature off or on, with its last values or else the usual ones.
pub fn switch(ui: &Ui, block: &dyn Block, is_on: bool, values: &mut Vec<f64>) {
    let setting = block.setting();
    let chosen: Vec<f64> = match setting.choices() {
        Some(choices) => choices.get(1).map(|choice| f64::from(choice.value)).into_iter().collect(),
        None => setting.default.to_vec(),
    };
    if !is_on {
        values.clear();
    }
    switched(ui, Id::unique((block.name(), "while it is off")), values, &chosen);
}

fn list(ui: &mut Ui, block: &dyn Block, mut values: Vec<f64>) -> Vec<f64> {
    let (name, setting) = (block.name(), block.setting());
    let explanation = setting.help();
    ui.horizontal(|ui| {
        let mut used = !values.is_empty();
        let was_used = used;
        let switch = ui.checkbox(&mut used, name).on_hover_text(&explanation);
        found(setting, &switch);
        if switch.changed() {
            self::switch(ui, block, was_used, &mut values);
        }
        ui.add_enabled_ui(used, |ui| {
            // Zero is allowed in the list if the range of the setting includes zero.
            let least = if setting.range == Range::NotNegative { 0.0 } else { f64::MIN_POSITIVE };
            list_field(ui, switch.id, ("", least), &explanation, &mut values);
            ui.label(setting.unit.symbol);
        });
    });
    values
}

fn one_of(ui: &mut Ui, block: &dyn Block, choices: &[Choice], mut values: Vec<f64>) -> Vec<f64> {
    ui.horizontal_wrapped(|ui| {
        ui.label(block.name()).on_hover_text(block.setting().help());
        let none = f64::from(choices[0].value);
        for choice in choices {
            let value = f64::from(choice.value);
            let selected = *values.first().unwrap_or(&none) == value;
            let button = ui.selectable_label(selected, choice.label);
            if selected {
                found(block.setting(), &button);
            }
            if button.on_hover_text(choice.explanation).clicked() {
                values = vec![value];
            }
        }
    });
    values
}

/// Draws a field of numbers of at least `least`, separated by commas. Returns true if the numbers changed. Invalid text is red.
pub fn list_field(
    ui: &mut Ui,
    label: Id,
    (hint, least): (&str, f64),
    explanation: &str,
    values: &mut Vec<f64>,
) -> bool {
    let id = label.with("numbers");
    let shown = values
        .iter()
        // Rounds away the errors of the conversion from shares to percentages.
        .map(|value| ((value * 1e9).round() / 1e9).to_string())
        .collect::<Vec<_>>()
        .join(", ");
    let typed = ui.data(|data| data.get_temp::<String>(id));
    let mut text = typed.unwrap_or_else(|| shown.clone());
    let read = parse(&text, least);
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
        None if least > 0.0 => {
            "This is no valid list. Enter numbers above zero, separated by commas"
        }
        None => "This is no valid list. Enter numbers from zero on, separated by commas",
    });
    if !response.has_focus() {
        ui.data_mut(|data| data.remove::<String>(id));
        return false;
    }
    let read = parse(&text, least);
    ui.data_mut(|data| data.insert_temp(id, text));
    match read {
        Some(read) if read != *values && response.changed() => {
            *values = read;
            true
        }
        _ => false,
    }
}

fn parse(text: &str, least: f64) -> Option<Vec<f64>> {
    text.split(',')
        .map(str::trim)
        .filter(|cell| !cell.is_empty())
        .map(|cell| cell.parse().ok().filter(|value: &f64| *value >= least && value.is_finite()))
        .collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn lists_are_read_while_they_are_typed() {
        let parse = |text| super::parse(text, f64::MIN_POSITIVE);
        assert_eq!(parse("0.1, 0.2,"), Some(vec![0.1, 0.2]));
        assert_eq!(parse(""), Some(vec![]));
        assert_eq!(parse("0.1, x"), None);
        assert_eq!(parse("-1"), None);
        assert_eq!(parse("0"), None);
        assert_eq!(super::parse("0, 60", 0.0), Some(vec![0.0, 60.0]));
    }
}
