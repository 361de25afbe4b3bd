//! Model type, feature blocks and thresholds, at the same place in all workspaces that show loads. Each slider of a threshold
//! shows the error over its own range.

use egui::{
    Align, Button, ComboBox, DragValue, Layout, Pos2, Rect, RichText, Sense, Shape, Slider,
    SliderClamping, Stroke, Ui, Vec2,
};

use crate::{
    calibration::{FitSettings, Regressor},
    engine::{Edit, Engine},
    features::{Appends, BLOCKS, Distance, F_TH, FeatureSettings, Setting, T_TH, Thresholds},
    questions::thresholds::{
        Along, ShownFTh, ThresholdMap,
        asked::{StudyThresholds, ThresholdStudy},
    },
    report::figure::DASHED,
    scoring::numbers::round_above,
    shown::counted,
    ui::{
        blocks_panel,
        choice::choice,
        command::{Command, Out, Pane},
        controls::{named, place as place_in, place_down},
        numbers::significant,
        palette::{self, Trace},
        pane::Cx,
        regressor_panel,
        scope::Scope,
        setting::{found, switched},
        small_plot::SmallPlot,
    },
};

pub const HEIGHT: f32 = 112.0;
const MODEL_WIDTH: f32 = 400.0;
const NARROW_MODEL_WIDTH: f32 = 330.0;
const PADDING: f32 = 12.0;
const ROW_HEIGHT: f32 = 28.0;
const CURVE_HEIGHT: f32 = 34.0;
const RAIL_HEIGHT: f32 = 6.0;
const HANDLE: f32 = 18.0;
const VALUE_SIZE: f32 = 20.0;
/// Half of the width of the mark of the lowest error (points).
const MARK: f32 = 5.0;
/// Maximum of the slider of the time threshold t_th (s), for long recordings. The user can type larger values.
const LONGEST_SLIDER_SECS: f64 = 60.0;
/// Share of a slider's range by which the keys move a threshold.
const KEY_STEP: f64 = 0.01;

pub fn dock(ui: &mut Ui, cx: &mut Cx<'_>) {
    let project = cx.engine.project();
    if !project.recordings.entries().is_empty() && project.missing().is_none() {
        cx.ask(StudyThresholds::of(&cx.engine.request(), project.thresholds()));
    }
    let rect = ui.max_rect().shrink2(Vec2::new(PADDING, 6.0));
    let is_wide = ui.ctx().content_rect().width() >= 1500.0;
    let width = if is_wide { MODEL_WIDTH } else { NARROW_MODEL_WIDTH };
    let model = rect.with_max_x(rect.left() + width);
    let rest = rect.with_min_x(model.right() + 2.0 * PADDING);
    edited(ui, cx, |ui, cx, settings| {
        place_down(ui, model, "model", |ui| {
            ui.shrink_clip_rect(model.expand(2.0));
            model_choices(ui, cx.engine, settings, cx.out);
        });
        sliders(ui, cx, &mut settings.features, rest);
    });
}

/// Draws both thresholds alone.
pub fn thresholds(ui: &mut Ui, cx: &mut Cx<'_>, place: Rect) {
    edited(ui, cx, |ui, cx, settings| sliders(ui, cx, &mut settings.features, place));
}

/// Draws controls that edit a copy of the settings, and sends the copy if they changed it. An applied calibration fixes the
/// settings.
fn edited(
    ui: &mut Ui,
    cx: &mut Cx<'_>,
    controls: impl FnOnce(&mut Ui, &mut Cx<'_>, &mut FitSettings),
) {
    let project = cx.engine.project();
    let mut settings = project.settings.clone();
    ui.add_enabled_ui(project.applied.is_none(), |ui| controls(ui, cx, &mut settings));
    if settings != project.settings {
        cx.out.send(Edit::Settings(settings));
    }
}

fn sliders(ui: &mut Ui, cx: &Cx<'_>, features: &mut FeatureSettings, place: Rect) {
    let study = cx.engine.lane::<StudyThresholds>().answer();
    let half = 0.5 * (place.width() - 2.0 * PADDING);
    let places = [place.with_max_x(place.left() + half), place.with_min_x(place.right() - half)];
    for (along, place) in [Along::F, Along::T].into_iter().zip(places) {
        threshold(ui, cx.engine, along, features, (cx.scope, study), place);
    }
}

fn model_choices(ui: &mut Ui, engine: &Engine, settings: &mut FitSettings, out: &mut Out) {
    let is_static = engine.project().recordings.is_static();
    ui.spacing_mut().item_spacing.y = 4.0;
    ui.horizontal(|ui| {
        ui.set_height(ROW_HEIGHT);
        let label = ui.label("Model type");
        let button = ComboBox::from_id_salt("regressor");
        let described = |one: Regressor| (one.label(), one.explanation());
        choice(ui, button, &mut settings.regressor, Regressor::ALL, described)
            .labelled_by(label.id)
            .on_hover_text(settings.regressor.explanation());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let more =
                ui.button("More…").on_hover_text("Shows all settings of the fit (Ctrl+comma)");
            if more.clicked() {
                out.send(Command::ToggleDrawer(Pane::SETTINGS));
            }
        });
    });
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        ui.set_height(ROW_HEIGHT);
        ui.add_enabled_ui(!is_static, |ui| look_back_switch(ui, engine, &mut settings.features));
        for block in [2, 1, 0, 3].map(|at| BLOCKS[at]) {
            let has_past = matches!(block.appends(), Appends::Past(_));
            ui.add_enabled_ui(!(is_static && has_past), |ui| {
                let blocks = &mut settings.features.blocks;
                let is_on = blocks.used().any(|(used, _)| used.name() == block.name());
                let button = Button::selectable(is_on, block.name()).frame_when_inactive(true);
                if ui.add(button).on_hover_text(block.setting().help()).clicked() {
                    let mut values = blocks.of(block).to_vec();
                    blocks_panel::switch(ui, block, is_on, &mut values);
                    blocks.set(block, values);
                }
            });
        }
    });
    ui.horizontal(|ui| {
        ui.set_height(ROW_HEIGHT - 6.0);
        match settings.regressor.learner() {
            Some(learner) => regressor_panel::training(ui, engine, settings, learner, out),
            None => {
                let words = engine.analysis().map(|analysis| {
                    let calibration = &analysis.calibration;
                    let n = calibration.quality.rank;
                    let samples = calibration.quality.n_train as usize;
                    format!(
                        "{} per axis · fitted to {}",
                        counted(n, "coefficient"),
                        counted(samples, "sample")
                    )
                });
                ui.weak(words.unwrap_or_default());
            }
        }
    });
}

fn look_back_switch(ui: &mut Ui, engine: &Engine, features: &mut FeatureSettings) {
    let is_on = !features.look_backs.is_empty();
    let button = Button::selectable(is_on, "Look-back").frame_when_inactive(true);
    if ui.add(button).on_hover_text(blocks_panel::LOOK_BACK).clicked() {
        let default = engine.project().default_thresholds();
        switched(ui, blocks_panel::look_back_id(), &mut features.look_backs, &[default]);
    }
}

/// A threshold as its slider shows it.
struct Shown {
    setting: Setting,
    title: &'static str,
    keys: &'static str,
    unit: &'static str,
    /// Factor of the shown value.
    factor: f64,
    largest: f64,
    decimals: usize,
}

fn shown(engine: &Engine, along: Along, features: &FeatureSettings) -> Shown {
    match along {
        Along::F => {
            let distance = blocks_panel::distance(engine, features);
            let ShownFTh { factor, unit } = ShownFTh::of(distance);
            let largest = match distance {
                Distance::Force => force_range(engine),
                Distance::FullScale => 200.0,
            };
            let (title, keys) = ("Force threshold", "Ctrl ← →");
            Shown { setting: F_TH, title, keys, unit, factor, largest, decimals: 3 }
        }
        Along::T => {
            let (title, keys) = ("Time threshold", "Ctrl ↑ ↓");
            let largest = t_range(engine);
            Shown { setting: T_TH, title, keys, unit: "s", factor: 1.0, largest, decimals: 2 }
        }
    }
}

/// Returns the thresholds after `steps` steps of the keys along this axis.
pub fn stepped(engine: &Engine, along: Along, steps: i32) -> Thresholds {
    let settings = &engine.project().settings.features;
    let present = engine.project().thresholds();
    let Shown { factor, largest, .. } = shown(engine, along, settings);
    let moved = along.of(present) * factor + f64::from(steps) * KEY_STEP * largest;
    let moved = (moved.max(0.0) / (KEY_STEP * largest)).round() * KEY_STEP * largest / factor;
    along.with(present, moved)
}

fn threshold(
    ui: &mut Ui,
    engine: &Engine,
    along: Along,
    features: &mut FeatureSettings,
    (scope, study): (&Scope, Option<&ThresholdStudy>),
    place: Rect,
) {
    let is_on = !features.look_backs.is_empty() && !engine.project().recordings.is_static();
    let present = engine.project().thresholds();
    let shown = shown(engine, along, features);
    let before = along.of(present) * shown.factor;
    let mut value = before;
    let head = place.with_max_y(place.top() + ROW_HEIGHT);
    let curve = Rect::from_min_size(
        head.left_bottom() + Vec2::new(0.0, 2.0),
        Vec2::new(place.width(), CURVE_HEIGHT),
    );
    let rail = Rect::from_min_size(curve.left_bottom(), Vec2::new(place.width(), HANDLE));
    let mut label = None;
    place_in(ui, head, |ui| {
        ui.label(shown.title);
        label = Some(ui.label(RichText::new(shown.setting.label).strong()).id);
        if ui.ctx().content_rect().width() >= 1500.0 {
            ui.small(shown.keys);
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if !is_on {
                ui.weak("switched off");
                return;
            }
            ui.weak(shown.unit);
            let font = egui::FontId::proportional(VALUE_SIZE);
            ui.style_mut().override_font_id = Some(font);
            let field =
                DragValue::new(&mut value).speed(0.01 * shown.largest).max_decimals(shown.decimals);
            let field = ui.add(field).on_hover_text(shown.setting.help());
            found(&shown.setting, &field);
            label.into_iter().for_each(|label| drop(field.clone().labelled_by(label)));
        });
    });
    let reach = HANDLE / 2.0;
    let ends = (rail.left() + reach, rail.right() - reach);
    let x_of =
        |value: f64| egui::lerp(ends.0..=ends.1, (value / shown.largest).clamp(0.0, 1.0) as f32);
    let map = study.and_then(|study| study.map.as_ref());
    let mut lowest = None;
    if let Some(map) = map {
        let over_rail = curve.with_min_x(ends.0).with_max_x(ends.1);
        let most = shown.largest / shown.factor;
        lowest = draw_curve(ui, map, along, present, scope, (over_rail, most));
    }
    place_down(ui, rail, shown.setting.label, |ui| {
        ui.spacing_mut().slider_width = rail.width();
        ui.spacing_mut().slider_rail_height = RAIL_HEIGHT;
        ui.spacing_mut().interact_size.y = HANDLE;
        ui.multiply_opacity(if is_on { 1.0 } else { 0.5 });
        let slider = Slider::new(&mut value, 0.0..=shown.largest)
            .show_value(false)
            .trailing_fill(true)
            .clamping(SliderClamping::Never)
            .max_decimals(shown.decimals);
        let slider = ui.add(slider);
        label.into_iter().for_each(|label| drop(slider.clone().labelled_by(label)));
        if !slider.dragged() {
            slider.on_hover_text(shown.setting.help());
        }
    });
    if let Some(lowest) = lowest.filter(|_| is_on) {
        let at = Pos2::new(x_of(lowest * shown.factor), rail.bottom() + 2.0);
        let corners = [at, at + Vec2::new(-MARK, 7.0), at + Vec2::new(MARK, 7.0)];
        let color = palette::look_back(ui.visuals());
        ui.painter().add(Shape::convex_polygon(corners.to_vec(), color, Stroke::NONE));
        let around = Rect::from_center_size(at + Vec2::new(0.0, 4.0), Vec2::splat(14.0));
        let about = format!(
            "Lowest error along this slider: {} {}",
            significant(lowest * shown.factor, 3),
            shown.unit
        );
        let mark = ui.interact(
            around,
            ui.scope_id().with(("lowest", shown.setting.label)),
            Sense::click(),
        );
        named(&mark, egui::Role::Button, &about);
        if mark.on_hover_text(&about).clicked() {
            value = lowest * shown.factor;
        }
    }
    if value != before {
        // A typed value may exceed the slider's range, but a negative value, infinity or NaN becomes zero.
        let value = if value.is_finite() { value.max(0.0) / shown.factor } else { 0.0 };
        if features.look_backs.is_empty() {
            features.look_backs = vec![engine.project().default_thresholds()];
        }
        let first = along.with(features.look_backs[0], value);
        features.look_backs[0] = first;
        features.look_backs.iter_mut().for_each(|other| other.t_th_secs = first.t_th_secs);
    }
}

/// Draws the error over the range of a threshold, through the present pair. Returns the threshold with the lowest error.
fn draw_curve(
    ui: &Ui,
    map: &ThresholdMap,
    along: Along,
    present: Thresholds,
    scope: &Scope,
    (place, most): (Rect, f64),
) -> Option<f64> {
    let measure = scope.measure(&map.scale);
    let through = map.nearest(present);
    let errors = map.curve(along, scope.on, measure, through);
    let without = map.conventional_value(scope.on, measure)?;
    let all = || errors.iter().map(|(_, error)| *error).chain([without]);
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    let visuals = ui.visuals();
    let plot = SmallPlot::new(ui, place, (0.0, most), (low, high));
    let ends = [0.0, most].map(|x| plot.at([x, without]));
    let before = Stroke::new(1.0, Trace::Conventional.color(visuals));
    plot.painter.extend(Shape::dashed_line(&ends, before, DASHED[0], DASHED[1]));
    let after = Stroke::new(1.6, Trace::Compensated.color(visuals));
    plot.line(errors.iter().map(|(value, error)| [*value, *error]), after);
    let now = along.of(present);
    let near = errors.iter().min_by(|a, b| (a.0 - now).abs().total_cmp(&(b.0 - now).abs()))?;
    let dot = plot.at([now.min(most), near.1]);
    plot.painter.circle_filled(dot, 3.0, palette::present(visuals));
    errors.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(value, _)| *value)
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
