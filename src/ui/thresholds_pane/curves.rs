//! Curves of the error through the present pair of thresholds, against the force threshold F_th and against the time
//! threshold t_th, separately for forces and moments.

use super::{measure_text, pressed};
use crate::{
    engine::{Edit, Engine},
    features::Thresholds,
    questions::thresholds::{Along, Measure, ShownFTh, ThresholdMap, threshold_curve},
    report::figure::{Figure, color},
    scoring::score_set::ScoreSet,
    ui::{command::Out, numbers::significant, palette, plots},
};

pub fn curves(ui: &mut egui::Ui, engine: &Engine, map: &ThresholdMap, height: f32, out: &mut Out) {
    let groups = [Measure::Forces, Measure::Moments].into_iter();
    let groups: Vec<_> = groups.filter(|group| group.weights(&map.scale).is_some()).collect();
    let height = (height - 26.0) / groups.len().max(1) as f32 - 6.0;
    let width = 0.5 * ui.available_width() - 6.0;
    ui.horizontal(|ui| {
        for set in ScoreSet::ALL {
            let color = palette::score(set, ui.visuals());
            let (name, about) = match set {
                ScoreSet::LeftOut => {
                    ("solid", "Held-out errors: choose the thresholds by this curve")
                }
                ScoreSet::Train => (
                    "dotted",
                    "Errors on the fitted samples, which are smaller than errors on new samples",
                ),
                ScoreSet::Test => {
                    ("dashed", "Errors on the test recordings: do not choose by this curve")
                }
            };
            ui.colored_label(color, format!("{} ({name})", set.label())).on_hover_text(about);
        }
        ui.weak("Click or drag in a plot to set the threshold");
    });
    for group in groups {
        ui.horizontal(|ui| {
            for along in [Along::F, Along::T] {
                curve(ui, engine, map, group, along, [width, height.max(70.0)], out);
            }
        });
    }
}

fn curve(
    ui: &mut egui::Ui,
    engine: &Engine,
    map: &ThresholdMap,
    group: Measure,
    along: Along,
    size: [f32; 2],
    out: &mut Out,
) {
    let present = engine.project().thresholds();
    let (factor, all) = match along {
        Along::F => (ShownFTh::of(map.distance).factor, &map.grid.f_ths),
        Along::T => (1.0, &map.grid.t_ths_secs),
    };
    let threshold = along.of(present);
    let curve = |ink: &dyn Fn(ScoreSet) -> [u8; 3]| Figure {
        marked: Some(threshold * factor),
        ..threshold_curve(map, group, along, map.nearest(present), None, ink)
    };
    let visuals = ui.visuals().clone();
    let mut figure = curve(&|set| palette::bytes(palette::score(set, &visuals)));
    figure.across.range = (0.0, factor * all.iter().copied().fold(threshold, f64::max));
    let title = measure_text(map, group);
    let label = &figure.across.label;
    let id = ("threshold curve", group.label(&map.scale), label);
    let response = plots::scales(plots::still(id, size), Some(label), &title)
        .set_margin_fraction(egui::Vec2::ZERO)
        .show(ui, |plot| plots::draw(plot, &figure, &visuals));
    let name = format!("{title} over {label}");
    let print = || curve(&|_| color::SCORE);
    plots::finish(&response.response, &name, Some(&print), out);
    if pressed(&response.response)
        && let Some(pointer) = response.response.interact_pointer_pos()
    {
        let x = response.transform.value_from_position(pointer).x / factor;
        // The value under the pointer is rounded to three significant digits.
        let value = significant(x.max(0.0), 3).parse().unwrap_or(0.0);
        let wanted = match along {
            Along::F => Thresholds { f_th: value, ..present },
            Along::T => Thresholds { t_th_secs: value, ..present },
        };
        if wanted != present {
            out.send(Edit::Thresholds(wanted));
        }
    }
}
