//! Map of the errors over F_th and t_th: one texture pixel for each pair, t_th on a logarithmic axis.

use std::sync::Arc;

use egui::{Color32, ColorImage, TextureHandle, TextureOptions, Vec2};
use egui_plot::{MarkerShape, PlotImage, PlotPoint, PlotPoints, Points};

use super::{pair_text, pressed};
use crate::calibration::NoCrossValidation;
use crate::engine::{Edit, Engine};
use crate::features::Thresholds;
use crate::questions::thresholds::ShownFTh;
use crate::questions::thresholds::{Measure, ScoreSet, ThresholdMap};
use crate::report::figure::color::shade;
use crate::ui::command::Command;
use crate::ui::numbers::significant;
use crate::ui::palette::rgb;
use crate::ui::plots;

#[derive(Default)]
pub struct MapTexture {
    made: Option<(Arc<ThresholdMap>, usize, Measure, ScoreSet)>,
    texture: Option<TextureHandle>,
    range: Option<(f64, f64)>,
    is_cut_off: bool,
}

const SCALE_WIDTH: f32 = 14.0;

pub fn map(
    ui: &mut egui::Ui,
    engine: &Engine,
    map: &Arc<ThresholdMap>,
    measure: Measure,
    set: ScoreSet,
    texture: &mut MapTexture,
    out: &mut Vec<Command>,
) {
    texture.update(ui.ctx(), map, measure, set);
    let (Some(image), Some((least, greatest))) = (&texture.texture, texture.range) else {
        ui.weak(match map.n_rows_done() {
            0 => "The first rows are being computed.".to_owned(),
            _ => format!("No errors: {}", set.missing(Some(NoCrossValidation::FewSamples))),
        });
        return;
    };
    let (low, high) = corners(map);
    let size = Vec2::new((high[0] - low[0]) as f32, (high[1] - low[1]) as f32);
    let center = PlotPoint::new(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]));
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
                let center = PlotPoint::new(center.x * shown_as, center.y);
                let size = Vec2::new(size.x * shown_as as f32, size.y);
                plot.image(PlotImage::new("", image.id(), center, size).allow_hover(false));
                let mark = |pair: Thresholds| {
                    PlotPoints::from([pair.f_th * shown_as, log(pair.t_th_secs, map)])
                };
                if let Some((at, _)) = minimum {
                    plot.points(
                        Points::new("minimum", mark(map.thresholds(at.0, at.1)))
                            .shape(MarkerShape::Diamond)
                            .radius(6.0)
                            .color(Color32::WHITE),
                    );
                }
                plot.points(
                    Points::new("present", mark(present))
                        .shape(MarkerShape::Circle)
                        .filled(false)
                        .radius(7.0)
                        .color(Color32::WHITE),
                );
            });
        plots::finish(&response.response, "Map of F_th and t_th", None, out);
        let pointer =
            response.response.hover_pos().map(|at| response.transform.value_from_position(at));
        if let Some(at) = pointer {
            let pair =
                map.nearest(Thresholds { f_th: at.x / shown_as, t_th_secs: 10_f64.powf(at.y) });
            let thresholds = map.thresholds(pair.0, pair.1);
            let value = map.value(set, measure, pair.0, pair.1);
            let value = value.map_or_else(|| "not yet".to_owned(), |value| significant(value, 4));
            let unit = measure.unit(&map.scale);
            response.response.clone().on_hover_text_at_pointer(format!(
                "{}: {value} {unit}\nclick to set; ◆ minimum, ○ present pair",
                pair_text(map.distance, thresholds)
            ));
            if pressed(&response.response) && thresholds != present {
                out.push(Edit::Thresholds(thresholds).into());
            }
        }
        let unit = measure.unit(&map.scale);
        let least = format!("{} {unit}", significant(least, 3));
        let above = if texture.is_cut_off { "≥ " } else { "" };
        let greatest = format!("{above}{} {unit}", significant(greatest, 3));
        scale_of_colors(ui, height, &least, &greatest);
    });
}

/// Returns grid lines at 1, 2 and 5 times powers of ten between two powers.
fn decades(low: f64, high: f64) -> Vec<egui_plot::GridMark> {
    (-3..5)
        .flat_map(|power| [1.0, 2.0, 5.0].map(|digit: f64| digit.log10() + f64::from(power)))
        .filter(|value| (low..=high).contains(value))
        .map(|value| egui_plot::GridMark { value, step_size: 1.0 })
        .collect()
}

/// Returns the place of t_th on the logarithmic axis; zero is at its lower end.
fn log(t_th_secs: f64, map: &ThresholdMap) -> f64 {
    let lowest = corners(map).0[1];
    if t_th_secs > 0.0 { t_th_secs.log10().max(lowest) } else { lowest }
}

/// Returns the outer corners of the cells of the first and the last pair: F_th, log₁₀ t_th.
fn corners(map: &ThresholdMap) -> ([f64; 2], [f64; 2]) {
    let ends = |values: &[f64], place: fn(f64) -> f64| {
        let (first, last) = (place(values[0]), place(values[values.len() - 1]));
        let half = match values.len() {
            0 | 1 => 0.5,
            n => 0.5 * (last - first) / (n - 1) as f64,
        };
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
        let key = (Arc::clone(map), map.n_rows_done(), measure, set);
        let same = self.made.as_ref().is_some_and(|(own, rows, m, s)| {
            Arc::ptr_eq(own, &key.0) && (*rows, *m, *s) == (key.1, key.2, key.3)
        });
        if same {
            return;
        }
        let values = map.values(set, measure);
        let range = map.shades(set, measure);
        let greatest = values.iter().flatten().copied().reduce(f64::max);
        self.is_cut_off = range.zip(greatest).is_some_and(|((_, high), most)| most > high);
        self.range = range;
        self.texture = range.map(|range| {
            let image = picture(map, &values, range);
            context.load_texture("threshold map", image, TextureOptions::NEAREST)
        });
        self.made = Some(key);
    }
}

/// Returns the image: one pixel for each pair, F_th to the right, t_th upwards. A missing row shows its nearest neighbour.
fn picture(map: &ThresholdMap, values: &[Option<f64>], (low, high): (f64, f64)) -> ColorImage {
    let (n_f, n_t) = (map.grid.f_ths.len(), map.grid.t_ths_secs.len());
    let has_row = |f_at: usize| values[f_at * n_t].is_some();
    let mut pixels = vec![Color32::TRANSPARENT; n_f * n_t];
    for f_at in 0..n_f {
        let near = (0..n_f).filter(|at| has_row(*at)).min_by_key(|at| at.abs_diff(f_at));
        let Some(near) = near else {
            continue;
        };
        for t_at in 0..n_t {
            if let Some(value) = values[near * n_t + t_at] {
                let share = (value - low) / (high - low).max(f64::MIN_POSITIVE);
                pixels[(n_t - 1 - t_at) * n_f + f_at] = rgb(shade(share));
            }
        }
    }
    ColorImage::new([n_f, n_t], pixels)
}

fn scale_of_colors(ui: &mut egui::Ui, height: f32, least: &str, greatest: &str) {
    ui.vertical(|ui| {
        ui.small(greatest);
        let size = Vec2::new(SCALE_WIDTH, (height - 60.0).max(20.0));
        let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
        let steps = 64;
        for step in 0..steps {
            let from = step as f32 / steps as f32;
            let slice = egui::Rect::from_min_size(
                rect.min + Vec2::new(0.0, from * rect.height()),
                Vec2::new(rect.width(), rect.height() / steps as f32 + 0.5),
            );
            let share = 1.0 - f64::from(from);
            ui.painter().rect_filled(slice, 0.0, rgb(shade(share)));
        }
        ui.small(least);
    });
}
