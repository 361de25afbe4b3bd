//! Map of the error for pairs of force threshold F_th and time threshold t_th: one pixel of a texture for each pair, with
//! t_th on a logarithmic axis.

use std::sync::Arc;

use egui::{Color32, ColorImage, TextureHandle, TextureOptions, Ui, Vec2};
use egui_plot::{MarkerShape, PlotImage, PlotPoint, PlotPoints, Points};

use super::{pair_text, pressed};
use crate::{
    calibration::NoCrossValidation,
    engine::{Edit, Engine},
    features::Thresholds,
    questions::thresholds::{Measure, ShownFTh, ThresholdMap},
    report::figure::color::{SHADES, shade},
    scoring::score_set::ScoreSet,
    ui::{command::Out, numbers::significant, palette::rgb, plots},
};

/// The image of a map, and the inputs from which it was made: the map, the number of computed rows, the axes whose error is
/// shown, and the set of samples.
#[derive(Default)]
pub struct MapTexture {
    made: Option<(Arc<ThresholdMap>, usize, Measure, ScoreSet, bool)>,
    /// The image, and the range of errors that its shades of blue cover.
    image: Option<(TextureHandle, (f64, f64))>,
}

const SCALE_WIDTH: f32 = 14.0;
const LABELS_WIDTH: f32 = 44.0;
const LABEL_SIZE: f32 = 11.0;

pub fn map(
    ui: &mut Ui,
    engine: &Engine,
    map: &Arc<ThresholdMap>,
    (measure, set, hysteresis): (Measure, ScoreSet, Option<f64>),
    texture: &mut MapTexture,
    out: &mut Out,
) {
    texture.update(ui.ctx(), map, measure, set);
    let Some((image, (least, greatest))) = &texture.image else {
        ui.weak(match map.n_rows_done() {
            0 => "The first rows of the map are being computed.".to_owned(),
            _ => format!("No errors to show: {}", set.missing(Some(NoCrossValidation::FewSamples))),
        });
        return;
    };
    let (low, high) = corners(map);
    let present = engine.project().thresholds();
    let minimum = map.minimum(set, measure);
    let shown = ShownFTh::of(map.distance);
    let shown_as = shown.factor;
    let width = ui.available_width() - SCALE_WIDTH - 70.0;
    let height = ui.available_height().max(120.0);
    ui.horizontal_top(|ui| {
        let plot = plots::still("threshold map", [width, height]);
        let response = plots::scales(plot, Some(&shown.label()), "t_th [s]")
            .show_grid(false)
            .set_margin_fraction(Vec2::ZERO)
            .default_x_bounds(low[0] * shown_as, high[0] * shown_as)
            .default_y_bounds(low[1], high[1])
            .y_grid_spacer(move |_| decades(low[1], high[1]))
            .y_axis_formatter(|mark, _| significant(10_f64.powf(mark.value), 1))
            .show(ui, |plot| {
                let center =
                    PlotPoint::new(0.5 * shown_as * (low[0] + high[0]), 0.5 * (low[1] + high[1]));
                let size = [shown_as * (high[0] - low[0]), high[1] - low[1]];
                let size = size.map(|side| side as f32);
                plot.image(PlotImage::new("", image.id(), center, size).allow_hover(false));
                let mark = |pair: Thresholds| {
                    PlotPoints::from([pair.f_th * shown_as, log(pair.t_th_secs, map)])
                };
                let minimum = minimum.map(|(at, _)| map.thresholds(at.0, at.1));
                let hysteresis = hysteresis.map(|f_th| Thresholds { f_th, ..present });
                for (name, pair, shape, radius) in [
                    ("mean hysteresis", hysteresis, MarkerShape::Square, 5.0),
                    ("minimum", minimum, MarkerShape::Diamond, 6.0),
                    ("present", Some(present), MarkerShape::Circle, 7.0),
                ] {
                    if let Some(pair) = pair {
                        // A white mark on a black one is visible on every colour of the map.
                        for (color, more) in [(Color32::BLACK, 2.0), (Color32::WHITE, 0.0)] {
                            let points = Points::new(name, mark(pair)).shape(shape);
                            plot.points(points.radius(radius + more).filled(true).color(color));
                        }
                    }
                }
            });
        plots::finish(&response.response, "Map of F_th and t_th", None, out);
        let pointer =
            response.response.hover_pos().map(|at| response.transform.value_from_position(at));
        if let Some(at) = pointer {
            let pair =
                map.nearest(Thresholds { f_th: at.x / shown_as, t_th_secs: 10_f64.powf(at.y) });
            let thresholds = map.thresholds(pair.0, pair.1);
            let value = map.value(set, measure, pair.0, pair.1);
            let value = value.map_or_else(
                || "not computed yet".to_owned(),
                |value| format!("{} {}", significant(value, 4), measure.unit(&map.scale)),
            );
            response.response.clone().on_hover_text_at_pointer(format!(
                "{}: {value}\nclick or drag to set",
                pair_text(map.distance, thresholds)
            ));
            if pressed(&response.response) && thresholds != present {
                out.send(Edit::Thresholds(thresholds));
            }
        }
        scale_of_colors(ui, height, (*least, *greatest), measure.unit(&map.scale));
    });
}

/// Returns grid lines at 1, 2 and 5 times powers of ten. `low` and `high` are logarithms to base 10.
fn decades(low: f64, high: f64) -> Vec<egui_plot::GridMark> {
    (-3..5)
        .flat_map(|power| [1.0, 2.0, 5.0].map(|digit: f64| digit.log10() + f64::from(power)))
        .filter(|value| (low..=high).contains(value))
        .map(|value| egui_plot::GridMark { value, step_size: 1.0 })
        .collect()
}

/// Returns the place of a time threshold t_th on the logarithmic axis of the map. A t_th of zero is at the lower end of the
/// axis.
fn log(t_th_secs: f64, map: &ThresholdMap) -> f64 {
    let lowest = corners(map).0[1];
    if t_th_secs > 0.0 { t_th_secs.log10().max(lowest) } else { lowest }
}

/// Returns the lower left and the upper right corner of the map, each as force threshold F_th and logarithm (base 10) of the
/// time threshold t_th.
fn corners(map: &ThresholdMap) -> ([f64; 2], [f64; 2]) {
    let ends = |values: &[f64], place: fn(f64) -> f64| {
        let n = values.len();
        let (first, last) = (place(values[0]), place(values[n - 1]));
        let half = if n > 1 { 0.5 * (last - first) / (n - 1) as f64 } else { 0.5 };
        (first - half, last + half)
    };
    let (left, right) = ends(&map.grid.f_ths, |f_th| f_th);
    let (low, high) = ends(&map.grid.t_ths_secs, |t_th| t_th.max(1e-3).log10());
    ([left, low], [right, high])
}

impl MapTexture {
    fn update(
        &mut self,
        context: &egui::Context,
        map: &Arc<ThresholdMap>,
        measure: Measure,
        set: ScoreSet,
    ) {
        let n_rows = map.n_rows_done();
        let is_dark = context.global_style().visuals.dark_mode;
        let same = self.made.as_ref().is_some_and(|(known, rows, m, s, dark)| {
            Arc::ptr_eq(known, map) && (*rows, *m, *s, *dark) == (n_rows, measure, set, is_dark)
        });
        if same {
            return;
        }
        let values = map.values(set, measure);
        self.image = map.shades(set, measure).map(|range| {
            let image = picture(map, &values, range, is_dark);
            let image = context.load_texture("threshold map", image, TextureOptions::NEAREST);
            (image, range)
        });
        self.made = Some((Arc::clone(map), n_rows, measure, set, is_dark));
    }
}

/// Returns the image with one pixel for each pair of thresholds: F_th increases to the right, t_th upwards. A row that is not
/// computed yet shows the nearest computed row.
fn picture(
    map: &ThresholdMap,
    values: &[Option<f64>],
    (low, high): (f64, f64),
    is_dark: bool,
) -> ColorImage {
    let (n_f, n_t) = (map.grid.f_ths.len(), map.grid.t_ths_secs.len());
    let has_row = |f_at: usize| values[f_at * n_t].is_some();
    let near = |f_at: usize| {
        (0..n_f).filter(|at| has_row(*at)).min_by_key(|at| at.abs_diff(f_at)).unwrap_or(f_at)
    };
    let near: Vec<usize> = (0..n_f).map(near).collect();
    let color =
        |value: f64| rgb(shade((value - low) / (high - low).max(f64::MIN_POSITIVE), is_dark));
    let row = |t_at: usize| near.iter().map(move |f_at| values[f_at * n_t + t_at]);
    let pixels = (0..n_t).rev().flat_map(row);
    let pixels = pixels.map(|value| value.map_or(Color32::TRANSPARENT, color));
    ColorImage::new([n_f, n_t], pixels.collect())
}

/// Draws the colour scale, with the error at which each step begins.
fn scale_of_colors(ui: &mut Ui, height: f32, (least, greatest): (f64, f64), unit: &str) {
    ui.vertical(|ui| {
        ui.small(format!("[{unit}]"));
        let is_dark = ui.visuals().dark_mode;
        let size = Vec2::new(SCALE_WIDTH + LABELS_WIDTH, (height - 60.0).max(20.0));
        let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
        let bar = rect.with_max_x(rect.left() + SCALE_WIDTH);
        // The uppermost step is that of errors larger than those without compensation.
        let n = SHADES + 1;
        let step_height = bar.height() / n as f32;
        let font = egui::FontId::proportional(LABEL_SIZE);
        for step in 0..n {
            let bottom = bar.bottom() - step as f32 * step_height;
            let slice = bar.with_max_y(bottom).with_min_y(bottom - step_height);
            let share = (step as f64 + 0.5) / SHADES as f64;
            ui.painter().rect_filled(slice, 0.0, rgb(shade(share, is_dark)));
            let value = least + (greatest - least) * step as f64 / SHADES as f64;
            let at = slice.right_bottom() + Vec2::new(4.0, 0.0);
            let color = ui.visuals().text_color();
            let align = egui::Align2::LEFT_CENTER;
            ui.painter().text(at, align, significant(value, 3), font.clone(), color);
            if step == SHADES {
                let at = slice.right_center() + Vec2::new(4.0, 0.0);
                ui.painter().text(at, align, "worse", font.clone(), color);
            }
        }
    });
}
