//! Pane of the thresholds and the other settings of the fit. Edits go to a copy, which is sent if it differs.

use egui::{DragValue, Slider, SliderClamping};

use crate::calibration::{DECIMATION, FitSettings, OFFSET, RIDGE, RidgeChoice};
use crate::engine::{Action, Edit, Engine, Preferences};
use crate::features::{
    Auxiliary, BLOCKS, Distance, F_TH, FeatureSettings, HISTORY_RATE, Setting, T_TH, Thresholds,
};
use crate::questions::thresholds::ShownFTh;
use crate::shown::printable;
use crate::ui::command::{Command, Kind, Pane};
use crate::ui::controls::Controls as _;
use crate::ui::numbers::significant;
use crate::ui::pane::{Cx, PaneView};
use crate::ui::setting::{found, number, switch};
use crate::ui::{blocks_panel, regressor_panel};

/// Upper end of the t_th slider for longer recordings (s); larger values can be typed.
const LONGEST_SLIDER_SECS: f64 = 60.0;

/// Settings that are visible without the advanced ones.
pub const IN_SIGHT: [Setting; 2] = [F_TH, T_TH];

pub const PANE: Pane = Pane(&Kind {
    key: "settings",
    title: "Settings",
    explanation: "Thresholds, features and regressor",
});

#[derive(Debug, Default)]
pub struct View;

impl PaneView for View {
    fn ui(&mut self, ui: &mut egui::Ui, cx: &mut Cx<'_>) {
        egui::ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| settings_panel(ui, cx.engine, cx.out));
    }
}

pub fn in_use(engine: &Engine) -> Vec<Setting> {
    let settings = &engine.project().settings;
    let mut all = vec![DECIMATION];
    if engine.project().applied.is_none() {
        if !settings.features.look_backs.is_empty() {
            all.extend([F_TH, T_TH]);
        }
        all.extend(BLOCKS.iter().map(|block| *block.setting()));
        all.extend(regressor_panel::in_use(settings));
        all.extend([OFFSET, HISTORY_RATE]);
    }
    all
}

fn settings_panel(ui: &mut egui::Ui, engine: &Engine, out: &mut Vec<Command>) {
    ui.add_space(4.0);
    // An applied calibration contains its settings; only decimation can still be changed.
    let mut settings = engine.project().settings.clone();
    let is_fitted = engine.project().applied.is_none();
    let is_static = engine.project().recordings.is_static();
    ui.add_enabled_ui(is_fitted, |ui| {
        if is_static {
            let text = "Recordings without times: look-back and all other features with memory are off";
            ui.warn(text).on_hover_text(
                "The recordings are load cases without an order in time. These settings apply again \
                 to recordings with times",
            );
        }
        ui.add_enabled_ui(!is_static, |ui| look_back(ui, engine, &mut settings.features));
        regressor_panel::regressor(ui, engine, &mut settings, out);
    });
    changed(ui, &settings, out);
    let preferences = &engine.preferences;
    let header = egui::CollapsingHeader::new("Advanced").open(Some(preferences.advanced));
    let header = header.show(ui, |ui| {
        ui.add_enabled_ui(is_fitted, |ui| {
            ui.add_enabled_ui(!is_static, |ui| {
                more_look_backs(ui, engine, &mut settings.features);
            });
            blocks_panel::blocks(ui, &mut settings.features, is_static);
            auxiliary_references(ui, engine, &mut settings);
            ui.horizontal_wrapped(|ui| regressor_panel::ridge(ui, &mut settings.ridge));
            switch(ui, &OFFSET, &mut settings.offset);
            ui.horizontal(|ui| {
                number(ui, &HISTORY_RATE, &mut settings.history_rate_hz);
                ui.weak(HISTORY_RATE.unit.symbol);
            });
        });
        decimation(ui, &mut settings);
        ui.add_enabled_ui(is_fitted, |ui| full_scales(ui, engine, &mut settings));
    });
    let about = "Further thresholds, features, ridge, offset, history rate, decimation, full scale";
    if header.header_response.on_hover_text(about).clicked() {
        let advanced = !preferences.advanced;
        out.push(Action::Prefer(Preferences { advanced, ..preferences.clone() }).into());
    }
    if settings != engine.project().settings {
        out.push(Edit::Settings(settings).into());
    }
    ui.add_space(2.0);
}

/// Lists the advanced settings that differ from their defaults; a press shows the control.
fn changed(ui: &mut egui::Ui, settings: &FitSettings, out: &mut Vec<Command>) {
    let default = FitSettings::default();
    let features = &settings.features;
    let blocks = features.blocks.used().map(|(block, values)| {
        (*block.setting(), format!("{} {}", block.name(), block.setting().in_words(values)))
    });
    let mut all: Vec<(Setting, String)> = blocks.collect();
    if features.look_backs.len() > 1 {
        all.push((F_TH, format!("{} look-backs", features.look_backs.len())));
    }
    if settings.ridge != default.ridge {
        let text = match settings.ridge {
            RidgeChoice::Strength(strength) => format!("ridge {strength}"),
            RidgeChoice::Auto => "ridge auto".to_owned(),
            RidgeChoice::ByBlock => "ridge by block".to_owned(),
        };
        all.push((RIDGE, text));
    }
    if settings.offset != default.offset {
        all.push((OFFSET, "no offset".to_owned()));
    }
    if settings.decimation != default.decimation {
        all.push((DECIMATION, format!("decimation {}", settings.decimation)));
    }
    if settings.history_rate_hz != default.history_rate_hz {
        all.push((HISTORY_RATE, format!("history rate {} Hz", settings.history_rate_hz)));
    }
    if all.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.weak("Also set:");
        for (setting, text) in all {
            if ui.press_small(
                text,
                "Advanced setting that differs from its default; press to show its control",
            ) {
                out.push(Command::FindSetting(setting));
            }
        }
    });
}

fn look_back(ui: &mut egui::Ui, engine: &Engine, features: &mut FeatureSettings) {
    let axes = engine.project().axes();
    // Before recordings are loaded, the distance over the forces is assumed.
    let distance = match axes {
        [] => features.distance,
        axes => features.distance.effective(axes),
    };
    let default = engine.project().default_thresholds();
    ui.horizontal_wrapped(|ui| {
        let mut used = !features.look_backs.is_empty();
        let id = ui.scope_id().with("look-backs that were turned off");
        let title = egui::RichText::new("Look-back").heading();
        if ui.tick(
            &mut used,
            title,
            "Appends the gauges of the past sample: the last one within t_th whose conventional load differed by F_th (Eq. \
             9-12)",
        ) {
            features.look_backs = if used {
                let kept = ui.data(|data| data.get_temp::<Vec<Thresholds>>(id));
                kept.unwrap_or_else(|| vec![default])
            } else {
                ui.data_mut(|data| data.insert_temp(id, features.look_backs.clone()));
                Vec::new()
            };
        }
        let label = match distance {
            Distance::Force => format!("Reset to {} N, {} s", default.f_th, default.t_th_secs),
            Distance::FullScale => {
                format!(
                    "Reset to {} %, {} s",
                    100.0 * default.f_th,
                    default.t_th_secs
                )
            }
        };
        if ui.press_if(used, label, "Sets one look-back with the default thresholds") {
            features.look_backs = vec![default];
        }
    });
    let Some((first, others)) = features.look_backs.split_first_mut() else {
        return;
    };
    ui.spacing_mut().slider_width = (ui.available_width() - 150.0).clamp(80.0, 400.0);
    ui.weak("Force threshold");
    f_th_slider(ui, engine, distance, &mut first.f_th);
    ui.weak("Maximum look-back time");
    let t_th = Slider::new(&mut first.t_th_secs, 0.0..=t_range(engine))
        .text(T_TH.label)
        .suffix(" s")
        .max_decimals(2)
        .clamping(SliderClamping::Never);
    let t_th = ui.add(t_th);
    explain(&t_th, egui::RectAlign::BOTTOM_START, &T_TH.help());
    found(&T_TH, &t_th);
    for value in [&mut first.f_th, &mut first.t_th_secs] {
        // Typed values may exceed the slider's range, but are neither negative nor NaN.
        *value = if value.is_finite() { value.max(0.0) } else { 0.0 };
    }
    let t_th_secs = first.t_th_secs;
    for other in others {
        other.t_th_secs = t_th_secs;
    }
}

/// Draws further F_th, and the choice of the distance that F_th applies to.
fn more_look_backs(ui: &mut egui::Ui, engine: &Engine, features: &mut FeatureSettings) {
    if features.look_backs.is_empty() {
        return;
    }
    let axes = engine.project().axes();
    let distance = match axes {
        [] => features.distance,
        axes => features.distance.effective(axes),
    };
    further_f_th(ui, distance, features);
    if axes.iter().any(|axis| axis.is_force()) {
        ui.horizontal_wrapped(|ui| {
            ui.label("F_th is measured over");
            for kind in Distance::ALL {
                let radio = ui.radio(distance == kind, kind.label());
                if radio.on_hover_text(kind.explanation()).clicked() && distance != kind {
                    features.distance = kind;
                    features.look_backs = vec![Thresholds::default_for(kind)];
                }
            }
        });
    }
}

/// Draws the field of further F_th; each adds a set of past gauges.
fn further_f_th(ui: &mut egui::Ui, distance: Distance, features: &mut FeatureSettings) {
    let ShownFTh { factor, unit } = ShownFTh::of(distance);
    let t_th_secs = features.look_backs[0].t_th_secs;
    let more = features.look_backs[1..].iter();
    let mut values: Vec<f64> = more.map(|other| other.f_th * factor).collect();
    ui.horizontal(|ui| {
        let label = ui.label("and F_th of").on_hover_text(
            "Further thresholds, separated by commas. Each adds a set of past gauges; several thresholds cover \
             loops of different sizes",
        );
        let explanation = "Numbers above zero, separated by commas; each is one more F_th (Eq. 9-12)";
        if blocks_panel::list_field(ui, label.id, ("none", f64::MIN_POSITIVE), explanation, &mut values) {
            features.look_backs.truncate(1);
            features
                .look_backs
                .extend(values.iter().map(|value| Thresholds {
                    f_th: value / factor,
                    t_th_secs,
                }));
        }
        ui.label(unit);
    });
}

fn f_th_slider(ui: &mut egui::Ui, engine: &Engine, distance: Distance, f_th: &mut f64) {
    let ShownFTh { factor, unit } = ShownFTh::of(distance);
    let largest = match distance {
        Distance::Force => force_range(engine),
        Distance::FullScale => 200.0,
    };
    let mut shown = *f_th * factor;
    let slider = Slider::new(&mut shown, 0.0..=largest)
        .text(F_TH.label)
        .suffix(format!(" {unit}"))
        .max_decimals(3)
        .clamping(SliderClamping::Never);
    let response = ui.add(slider);
    explain(&response, egui::RectAlign::TOP_START, &F_TH.help());
    found(&F_TH, &response);
    if response.changed() {
        *f_th = shown / factor;
    }
}

/// Shows the explanation of a slider on the side away from other sliders, and hides it while the slider moves.
fn explain(slider: &egui::Response, side: egui::RectAlign, text: &str) {
    if slider.dragged() {
        return;
    }
    let mut tooltip = egui::Tooltip::for_enabled(slider);
    tooltip.popup = tooltip.popup.align(side).align_alternatives(&[]);
    tooltip.show(|ui| ui.label(text));
}

/// Returns twice the largest force, rounded up: the largest possible difference of two samples on one axis.
fn force_range(engine: &Engine) -> f64 {
    let largest = engine.analysis().map_or(0.0, |analysis| {
        let calibration = &analysis.calibration;
        calibration
            .axes
            .iter()
            .zip(&calibration.full_scale)
            .filter(|(axis, _)| axis.is_force())
            .fold(0.0, |largest: f64, (_, scale)| largest.max(*scale))
    });
    if largest > 0.0 { rounded_up(2.0 * largest) } else { 10.0 }
}

fn t_range(engine: &Engine) -> f64 {
    let longest =
        engine.entries().iter().map(|entry| entry.recording.duration_secs()).fold(0.0, f64::max);
    if longest > 0.0 { rounded_up(longest.min(LONGEST_SLIDER_SECS)) } else { LONGEST_SLIDER_SECS }
}

/// Returns the next number of the form 1, 2, 2.5, 3, 4, 5, 6 or 8 times a power of ten.
fn rounded_up(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    let steps = [1.0, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];
    let found = steps.into_iter().find(|step| step * power >= value * (1.0 - 1e-9));
    found.unwrap_or(10.0) * power
}

fn decimation(ui: &mut egui::Ui, settings: &mut FitSettings) {
    ui.horizontal_wrapped(|ui| {
        number(ui, &DECIMATION, &mut settings.decimation);
        for (name, step, explanation) in [
            ("A", 1, "Pattern A of the paper: all samples"),
            ("B", 10, "Pattern B of the paper: every tenth sample"),
        ] {
            let selected = settings.decimation == step;
            let button = ui.selectable_label(selected, name).on_hover_text(explanation);
            if button.clicked() {
                settings.decimation = step;
            }
        }
    });
}

/// Draws the reference values of the auxiliary channels, at which their effects are zero.
fn auxiliary_references(ui: &mut egui::Ui, engine: &Engine, settings: &mut FitSettings) {
    let explanation = "What the effect of this channel counts from: the gauges' matrix and the offset are those at this value, such \
                       as the temperature that a calibration is stated at. From data: its mean over the training recordings";
    let Some(analysis) = engine.analysis().filter(|own| own.fitted) else {
        return;
    };
    if settings.features.blocks.of(&Auxiliary).is_empty() {
        return;
    }
    for channel in &analysis.calibration.features.auxiliary {
        ui.horizontal_wrapped(|ui| {
            let entered = settings.auxiliary_references.get(&channel.name).copied();
            let mut value = entered.unwrap_or(channel.reference);
            let field = egui::DragValue::new(&mut value)
                .speed(0.1)
                .max_decimals(3)
                .suffix(format!(" {}", printable(&channel.unit)));
            let label = format!("{}: zero effect at", printable(&channel.name));
            let typed = ui.explained_field(label, field, explanation).changed();
            let mut from_data = entered.is_none() && !typed;
            let ticked = ui.tick(&mut from_data, "from data", explanation);
            let references = &mut settings.auxiliary_references;
            match (ticked && from_data, typed || ticked) {
                (true, _) => drop(references.remove(&channel.name)),
                (false, true) => drop(references.insert(channel.name.clone(), value)),
                (false, false) => {}
            }
        });
    }
}

fn full_scales(ui: &mut egui::Ui, engine: &Engine, settings: &mut FitSettings) {
    let Some(analysis) = engine.analysis() else {
        return;
    };
    let calibration = &analysis.calibration;
    ui.collapsing("Full scale", |ui| {
        ui.label(
            "Rated load of each axis, saved with the calibration and the session. Default: half the peak-to-peak training \
             reference, or its largest magnitude if the load has one direction.",
        );
        egui::Grid::new("full scale").num_columns(3).show(ui, |ui| {
            for (at, (axis, current)) in calibration
                .axes
                .iter()
                .zip(&calibration.full_scale)
                .enumerate()
            {
                let entered = settings.full_scale.get(at).copied().flatten();
                let mut value = entered.unwrap_or(*current);
                let field = DragValue::new(&mut value)
                    .range(1e-9..=1e9)
                    .speed(0.01 * current.max(1e-6))
                    .custom_formatter(|value, _| significant(value, 4));
                let field = ui.field(
                    axis.label(),
                    field,
                    "Full scale for errors in % FS and for the distance over all axes",
                );
                if field.changed() {
                    settings.full_scale.resize(calibration.axes.len(), None);
                    settings.full_scale[at] = Some(value);
                }
                let measure = egui::Button::new("Measure").small();
                let measure = ui.add_enabled(entered.is_some(), measure);
                if measure.on_hover_text("Takes the value from the data again").clicked() {
                    settings.full_scale[at] = None;
                }
                ui.end_row();
            }
        });
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_end_at_a_round_number_not_below_the_data() {
        for (value, expected) in
            [(22.1, 25.0), (20.0, 20.0), (0.13, 0.2), (9.1, 10.0), (60.0, 60.0)]
        {
            assert!((rounded_up(value) - expected).abs() < 1e-12, "{value}");
        }
    }
}
