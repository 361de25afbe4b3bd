//! Pane of the thresholds and the other settings of the fit. The controls edit a copy of the settings. The copy is sent to the
//! engine if the user changed it.

use egui::{DragValue, Ui};

use crate::{
    calibration::{DECIMATION, FitSettings, OFFSET},
    engine::{Edit, Engine},
    features::{
        Auxiliary, BLOCKS, Distance, F_TH, FeatureSettings, HISTORY_RATE, Setting, T_TH, Thresholds,
    },
    min_max::MinMax,
    questions::thresholds::ShownFTh,
    recording::{Entry, GaugeRange, ValidRange},
    shown::printable,
    ui::{
        blocks_panel::{self, LOOK_BACK, distance, look_back_id},
        command::Out,
        controls::Controls as _,
        numbers::significant,
        pane::{Cx, PaneView},
        regressor_panel,
        reversal_threshold::or_from_data,
        setting::{number, switch, switched},
    },
};

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
        ui.add_enabled_ui(!is_static, |ui| {
            look_back(ui, engine, &mut settings.features);
            more_look_backs(ui, engine, &mut settings.features);
        });
        ui.separator();
        blocks_panel::blocks(ui, &mut settings.features, is_static);
        blocks_panel::choosing(ui, engine, out);
        auxiliary_references(ui, engine, &mut settings);
        ui.separator();
        regressor_panel::learner(ui, &mut settings);
        ui.horizontal_wrapped(|ui| regressor_panel::ridge(ui, &mut settings.ridge));
        switch(ui, &OFFSET, &mut settings.offset);
        ui.horizontal(|ui| {
            let before = settings.history_rate_hz.unwrap_or_default();
            let (mut rate_hz, mut is_chosen) = (before, settings.history_rate_hz.is_none());
            number(ui, &HISTORY_RATE, &mut rate_hz);
            ui.weak(HISTORY_RATE.unit.symbol);
            let what = "The fit chooses the highest rate that fits into 64 kB on a controller";
            if ui.tick(&mut is_chosen, "automatic", what) || rate_hz != before {
                let is_set = rate_hz != before || !is_chosen;
                settings.history_rate_hz = is_set.then_some(rate_hz);
            }
        });
    });
    decimation(ui, &mut settings);
    gauge_limits(ui, engine, out);
    ui.add_enabled_ui(is_fitted, |ui| full_scales(ui, engine, &mut settings));
    if settings != engine.project().settings {
        out.send(Edit::Settings(settings));
    }
    ui.add_space(2.0);
}

fn look_back(ui: &mut Ui, engine: &Engine, features: &mut FeatureSettings) {
    let distance = distance(engine, features);
    let default = engine.project().default_thresholds();
    ui.horizontal_wrapped(|ui| {
        let mut used = !features.look_backs.is_empty();
        let title = "Look-back";
        if ui.tick(&mut used, title, LOOK_BACK) {
            switched(ui, look_back_id(), &mut features.look_backs, &[default]);
        }
        let shown = ShownFTh::of(distance);
        let f_th = shown.number(default.f_th);
        let label = format!("Reset to {f_th} {}, {} s", shown.unit, default.t_th_secs);
        if ui.press_if(
            used,
            label,
            "Replaces all look-backs by one look-back with the default thresholds",
        ) {
            features.look_backs = vec![default];
        }
    });
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
            "Each further force threshold adds the gauges of one more earlier sample, for loops of different sizes",
        );
        let about = "Numbers above zero, separated by commas";
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
    let explanation = "Value of this channel at which its effect is zero, such as the nominal temperature. From data: the mean of the channel in the training recordings";
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

/// Draws the gauge limits and the overload tolerance.
fn gauge_limits(ui: &mut Ui, engine: &Engine, out: &mut Out) {
    let project = engine.project();
    ui.horizontal_wrapped(|ui| {
        let mut entered = project.gauge_range.clone();
        let mut knows = entered.is_some();
        if ui.tick(
            &mut knows,
            "Gauge limits",
            "Minimum and maximum that the logger can write, such as -32768 and 32767. Without limits, a gauge counts as clipped if it stays at its extreme value while the load changes",
        ) {
            let extremes = || gauge_extremes(project.recordings.entries());
            entered = knows.then(|| GaugeRange::All(extremes()));
        }
        match &mut entered {
            Some(GaugeRange::All((low, high))) => {
                for (value, what) in [(low, "Smallest"), (high, "Largest")] {
                    let speed = (0.001 * value.abs()).max(1e-6);
                    let field = DragValue::new(value).speed(speed);
                    ui.add(field).on_hover_text(format!("{what} possible value of a gauge"));
                }
            }
            Some(GaugeRange::Each(_)) => drop(ui.weak("separate for each gauge")),
            None => {}
        }
        if entered != project.gauge_range {
            out.send(Edit::GaugeRange(entered.filter(GaugeRange::rises)));
        }
        if project.settings.full_scale.iter().any(Option::is_some) {
            let tolerance = project.overload_tolerance.unwrap_or(ValidRange::RATED_TOLERANCE);
            let mut percent = 100.0 * tolerance;
            ui.label("Overload above rated by");
            let field = DragValue::new(&mut percent).range(0.0..=100.0).speed(0.1).suffix(" %");
            let field = ui.add(field);
            if field.on_hover_text("A load counts as overload if it exceeds the rated load by more than this share").changed() {
                out.send(Edit::OverloadTolerance(percent / 100.0));
            }
        }
    });
}

/// Returns the minimum and maximum value of all gauges, including zero.
fn gauge_extremes(entries: &[Entry]) -> (f64, f64) {
    let ranges = entries.iter().flat_map(|entry| entry.recording.gauge_ranges());
    let range = ranges.copied().collect::<MinMax>().with(0.0);
    (range.min, range.max)
}
