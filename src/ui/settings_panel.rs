//! Pane of the thresholds and the other settings of the fit. The controls edit a copy of the settings. The copy is sent to the
//! engine if the user changed it.

use egui::{DragValue, Slider, SliderClamping, Ui};

use crate::{
    calibration::{DECIMATION, FitSettings, OFFSET, RIDGE, RidgeChoice},
    engine::{Action, Edit, Engine, Preferences},
    features::{
        Auxiliary, BLOCKS, Distance, F_TH, FeatureSettings, HISTORY_RATE, Setting, T_TH, Thresholds,
    },
    questions::thresholds::ShownFTh,
    scoring::numbers::round_above,
    shown::printable,
    ui::{
        blocks_panel,
        command::{Command, Out, Pane},
        controls::Controls as _,
        numbers::significant,
        pane::{Cx, PaneView},
        regressor_panel,
        reversal_threshold::or_from_data,
        setting::{found, number, switch, switched},
    },
};

/// Maximum of the slider of the time threshold t_th (s), for long recordings. The user can type larger values.
const LONGEST_SLIDER_SECS: f64 = 60.0;

/// Settings that stay visible while the advanced settings are hidden: the force threshold and the time threshold.
pub const IN_SIGHT: [Setting; 2] = [F_TH, T_TH];

pub const PANE: Pane =
    Pane { key: "settings", title: "Settings", explanation: "Thresholds, features and regressor" };

#[derive(Debug, Default)]
pub struct View;

impl PaneView for View {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
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

fn settings_panel(ui: &mut Ui, engine: &Engine, out: &mut Out) {
    ui.add_space(4.0);
    // An applied calibration contains its settings, so the user can change only the decimation.
    let mut settings = engine.project().settings.clone();
    let is_fitted = engine.project().applied.is_none();
    let is_static = engine.project().recordings.is_static();
    ui.add_enabled_ui(is_fitted, |ui| {
        if is_static {
            let text = "The recordings have no times, so look-back and all other features with memory are off";
            ui.warn(text).on_hover_text(
                "These samples have no order in time. The settings are kept, and apply again to recordings with times",
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
    let about = "Shows further settings: thresholds, features, ridge, offset, history rate, decimation and full scale";
    if header.header_response.on_hover_text(about).clicked() {
        let advanced = !preferences.advanced;
        out.send(Action::Prefer(Preferences { advanced, ..preferences.clone() }));
    }
    if settings != engine.project().settings {
        out.send(Edit::Settings(settings));
    }
    ui.add_space(2.0);
}

/// Lists the advanced settings that differ from their defaults. A press on a setting shows its control.
fn changed(ui: &mut Ui, settings: &FitSettings, out: &mut Out) {
    let FitSettings { features, ridge, offset, decimation, history_rate_hz, .. } = settings;
    let default = FitSettings::default();
    let blocks = features.blocks.used().map(|(block, values)| {
        (*block.setting(), format!("{} {}", block.name(), block.setting().in_words(values)))
    });
    let ridge = match ridge {
        RidgeChoice::Strength(strength) => format!("ridge {strength}"),
        RidgeChoice::Auto => "ridge auto".to_owned(),
        RidgeChoice::ByBlock => "ridge for each feature".to_owned(),
    };
    let n = features.look_backs.len();
    let others = [
        (n > 1, F_TH, format!("{n} look-backs")),
        (settings.ridge != default.ridge, RIDGE, ridge),
        (*offset != default.offset, OFFSET, "no offset".to_owned()),
        (*decimation != default.decimation, DECIMATION, format!("decimation {decimation}")),
        (
            *history_rate_hz != default.history_rate_hz,
            HISTORY_RATE,
            format!("history rate {history_rate_hz} Hz"),
        ),
    ];
    let others =
        others.into_iter().filter(|other| other.0).map(|(_, setting, text)| (setting, text));
    let all: Vec<(Setting, String)> = blocks.chain(others).collect();
    if all.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.weak("Advanced settings changed:");
        for (setting, text) in all {
            if ui.press_small(
                text,
                "Advanced setting that differs from its default; press to show its control",
            ) {
                out.send(Command::FindSetting(setting));
            }
        }
    });
}

/// Returns the distance between two loads that is compared with the force threshold F_th: a norm over the force axes or over
/// all axes. Before recordings are loaded, the chosen distance is returned.
fn distance(engine: &Engine, features: &FeatureSettings) -> Distance {
    match engine.project().axes() {
        [] => features.distance,
        axes => features.distance.effective(axes),
    }
}

fn look_back(ui: &mut Ui, engine: &Engine, features: &mut FeatureSettings) {
    let distance = distance(engine, features);
    let default = engine.project().default_thresholds();
    ui.horizontal_wrapped(|ui| {
        let mut used = !features.look_backs.is_empty();
        let id = ui.scope_id().with("look-backs that were turned off");
        let title = egui::RichText::new("Look-back").heading();
        if ui.tick(
            &mut used,
            title,
            "Adds the gauges of an earlier sample to the fit: the last sample within the time threshold t_th whose conventional load differed by the force threshold F_th (Eq. 9-12 of Koike et al. 2019)",
        ) {
            switched(ui, id, &mut features.look_backs, &[default]);
        }
        let shown = ShownFTh::of(distance);
        let f_th = shown.number(default.f_th);
        let label = format!("Reset to {f_th} {}, {} s", shown.unit, default.t_th_secs);
        if ui.press_if(used, label, "Replaces all look-backs by one look-back with the default thresholds") {
            features.look_backs = vec![default];
        }
    });
    let Some((first, others)) = features.look_backs.split_first_mut() else {
        return;
    };
    ui.spacing_mut().slider_width = (ui.available_width() - 150.0).clamp(80.0, 400.0);
    ui.weak("Force threshold F_th");
    let ShownFTh { factor, unit } = ShownFTh::of(distance);
    let largest = match distance {
        Distance::Force => force_range(engine),
        Distance::FullScale => 200.0,
    };
    let above = egui::RectAlign::TOP_START;
    threshold_slider(ui, &F_TH, (&mut first.f_th, factor), (largest, unit, 3), above);
    ui.weak("Time threshold t_th (maximum look-back time)");
    let below = egui::RectAlign::BOTTOM_START;
    threshold_slider(ui, &T_TH, (&mut first.t_th_secs, 1.0), (t_range(engine), "s", 2), below);
    others.iter_mut().for_each(|other| other.t_th_secs = first.t_th_secs);
}

/// Draws a slider of a threshold, which shows `value` multiplied by `factor`. The hover text is on the side away from other
/// sliders, and is hidden while the slider moves.
fn threshold_slider(
    ui: &mut Ui,
    setting: &Setting,
    (value, factor): (&mut f64, f64),
    (largest, unit, max_decimals): (f64, &str, usize),
    side: egui::RectAlign,
) {
    let mut shown = *value * factor;
    let slider = Slider::new(&mut shown, 0.0..=largest)
        .text(setting.label)
        .suffix(format!(" {unit}"))
        .max_decimals(max_decimals)
        .clamping(SliderClamping::Never);
    let slider = ui.add(slider);
    found(setting, &slider);
    if slider.changed() {
        // A typed value may exceed the slider's range, but a negative value, infinity or NaN becomes zero.
        *value = if shown.is_finite() { shown.max(0.0) / factor } else { 0.0 };
    }
    if !slider.dragged() {
        let mut tooltip = egui::Tooltip::for_enabled(&slider);
        tooltip.popup = tooltip.popup.align(side).align_alternatives(&[]);
        tooltip.show(|ui| ui.label(setting.help()));
    }
}

/// Draws the field of further force thresholds F_th, and the choice of the distance between loads to which F_th applies.
fn more_look_backs(ui: &mut Ui, engine: &Engine, features: &mut FeatureSettings) {
    if features.look_backs.is_empty() {
        return;
    }
    let distance = distance(engine, features);
    let ShownFTh { factor, unit } = ShownFTh::of(distance);
    let t_th_secs = features.look_backs[0].t_th_secs;
    let more = features.look_backs[1..].iter();
    let mut values: Vec<f64> = more.map(|other| other.f_th * factor).collect();
    ui.horizontal(|ui| {
        let label = ui.label("Further F_th").on_hover_text(
            "Further force thresholds, separated by commas. Each threshold adds the gauges of one more earlier sample; several thresholds cover loops of different sizes",
        );
        let about = "Numbers above zero, separated by commas. Each number is one more force threshold F_th (Eq. 9-12 of Koike et al. 2019)";
        let hint = ("none", f64::MIN_POSITIVE);
        if blocks_panel::list_field(ui, label.id, hint, about, &mut values) {
            let more = values.iter().map(|value| Thresholds { f_th: value / factor, t_th_secs });
            features.look_backs.truncate(1);
            features.look_backs.extend(more);
        }
        ui.label(unit);
    });
    if engine.project().axes().iter().any(|axis| axis.is_force()) {
        ui.horizontal_wrapped(|ui| {
            ui.label("F_th is a distance over");
            let mut chosen = distance;
            for kind in Distance::ALL {
                ui.select_radio(&mut chosen, kind, kind.label(), kind.explanation());
            }
            if chosen != distance {
                features.distance = chosen;
                features.look_backs = vec![Thresholds::default_for(chosen)];
            }
        });
    }
}

/// Returns twice the largest force (N), rounded up. The forces of two samples on one axis cannot differ by more.
fn force_range(engine: &Engine) -> f64 {
    let largest = engine.analysis().map_or(0.0, |analysis| {
        let calibration = &analysis.calibration;
        let scales = calibration.axes.iter().zip(&calibration.full_scale);
        let forces = scales.filter(|(axis, _)| axis.is_force());
        forces.map(|(_, scale)| *scale).fold(0.0, f64::max)
    });
    if largest > 0.0 { rounded_up(2.0 * largest) } else { 10.0 }
}

fn t_range(engine: &Engine) -> f64 {
    let longest =
        engine.entries().iter().map(|entry| entry.recording.duration_secs()).fold(0.0, f64::max);
    if longest > 0.0 { rounded_up(longest.min(LONGEST_SLIDER_SECS)) } else { LONGEST_SLIDER_SECS }
}

fn rounded_up(value: f64) -> f64 {
    round_above(value, &[1.0, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0])
}

fn decimation(ui: &mut Ui, settings: &mut FitSettings) {
    ui.horizontal_wrapped(|ui| {
        number(ui, &DECIMATION, &mut settings.decimation);
        let chosen = &mut settings.decimation;
        ui.select(chosen, 1, "A", "Uses all samples (pattern A of Koike et al. 2019)");
        ui.select(chosen, 10, "B", "Uses every tenth sample (pattern B of Koike et al. 2019)");
    });
}

/// Draws the reference values of the auxiliary channels, at which their effects are zero.
fn auxiliary_references(ui: &mut Ui, engine: &Engine, settings: &mut FitSettings) {
    let explanation = "Value of this channel at which its effect is zero, such as the nominal temperature of the calibration. The calibration matrix of the gauges and the offset hold at this value. From data: the mean of the channel in the training recordings";
    let Some(analysis) = engine.analysis().filter(|analysis| analysis.fitted) else {
        return;
    };
    if settings.features.blocks.of(&Auxiliary).is_empty() {
        return;
    }
    for channel in &analysis.calibration.features.auxiliary {
        ui.horizontal_wrapped(|ui| {
            let references = &mut settings.auxiliary_references;
            let entered = references.get(&channel.name).copied();
            let label = format!("{}: zero effect at", printable(&channel.name));
            let unit = printable(&channel.unit);
            let values = (entered, channel.reference);
            let chosen = or_from_data(ui, label, explanation, values, |field| {
                field.speed(0.1).max_decimals(3).suffix(format!(" {unit}"))
            });
            match chosen {
                Some(value) => drop(references.insert(channel.name.clone(), value)),
                None => drop(references.remove(&channel.name)),
            }
        });
    }
}

fn full_scales(ui: &mut Ui, engine: &Engine, settings: &mut FitSettings) {
    let Some(analysis) = engine.analysis() else {
        return;
    };
    let calibration = &analysis.calibration;
    ui.collapsing("Full scale", |ui| {
        ui.label(
            "Rated load of each axis, saved with the calibration and the session. Default: half the peak-to-peak reference load of the training recordings, or the largest magnitude if the load has only one direction.",
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
                    "Full scale of this axis, for errors in % FS and for the force threshold F_th in % FS",
                );
                if field.changed() {
                    settings.full_scale.resize(calibration.axes.len(), None);
                    settings.full_scale[at] = Some(value);
                }
                let about = "Replaces the entered full scale by the full scale from the data";
                if ui.press_if(entered.is_some(), "Measure", about) {
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
