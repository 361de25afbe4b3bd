//! The curves through the present pair of thresholds: forces and moments apart, over F_th and over t_th.

use egui_plot::{Line, PlotPoints, VLine};

use super::pressed;
use crate::engine::{Edit, Engine};
use crate::evaluation::threshold_study::{Measure, ScoreSet, ThresholdMap};
use crate::features::{Distance, Thresholds};
use crate::ui::command::Command;
use crate::ui::numbers::significant;
use crate::ui::{palette, picture, plots};

/// The threshold that runs along the axis of a curve.
#[derive(Clone, Copy, PartialEq)]
enum Along {
    F,
    T,
}

/// Draws two curves for each unit.
pub fn curves(
    ui: &mut egui::Ui,
    engine: &Engine,
    map: &ThresholdMap,
    height: f32,
    out: &mut Vec<Command>,
) {
    let groups = [Measure::Forces, Measure::Moments]
        .into_iter()
        .filter(|group| group.weights(&map.scale).is_some())
        .collect::<Vec<_>>();
    let height = (height - 26.0) / groups.len().max(1) as f32 - 6.0;
    let width = 0.5 * ui.available_width() - 6.0;
    ui.horizontal(|ui| {
        for set in ScoreSet::ALL {
            let (color, _) = palette::score(set, ui.visuals());
            let (name, about) = match set {
                ScoreSet::LeftOut => ("solid", "Choose by this one"),
                ScoreSet::Train => ("dotted", "On what was fitted, which flatters"),
                ScoreSet::Test => ("dashed", "To look at, not to choose by"),
            };
            ui.colored_label(color, format!("{} ({name})", set.label()))
                .on_hover_text(about);
        }
        ui.weak("press or drag to set");
    });
    for group in groups {
        ui.horizontal(|ui| {
            for along in [Along::F, Along::T] {
                curve(
                    ui,
                    engine,
                    map,
                    group,
                    along,
                    [width, height.max(70.0)],
                    out,
                );
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
    out: &mut Vec<Command>,
) {
    let present = engine.project().thresholds();
    let at = map.nearest(present);
    let shown_as = match (along, map.distance) {
        (Along::F, Distance::FullScale) => 100.0,
        _ => 1.0,
    };
    let label = match (along, map.distance) {
        (Along::F, Distance::Force) => "F_th [N]",
        (Along::F, Distance::FullScale) => "F_th [% FS]",
        (Along::T, _) => "t_th [s]",
    };
    let longest = match along {
        Along::F => map.grid.f_ths().last(),
        Along::T => map.grid.t_ths_secs().last(),
    };
    let title = format!("{} [{}]", group.label(&map.scale), group.unit(&map.scale));
    let visuals = ui.visuals().clone();
    let id = (
        "threshold curve",
        group.label(&map.scale),
        along == Along::F,
    );
    let response = plots::scales(plots::still(id, size), Some(label), &title)
        .include_x(0.0)
        .include_x(longest.copied().unwrap_or(1.0) * shown_as)
        .show(ui, |plot| {
            for set in ScoreSet::ALL {
                let points = match along {
                    Along::F => map.curve_over_f_th(set, group, at.1),
                    Along::T => map.curve_over_t_th(set, group, at.0),
                };
                let (color, style) = palette::score(set, &visuals);
                let points: PlotPoints<'_> =
                    points.into_iter().map(|(x, y)| [x * shown_as, y]).collect();
                plot.line(
                    Line::new(set.label(), points)
                        .color(color)
                        .style(style)
                        .width(1.6),
                );
            }
            let own = match along {
                Along::F => present.f_th,
                Along::T => present.t_th_secs,
            };
            plot.vline(
                VLine::new("present", own * shown_as)
                    .color(palette::present(&visuals))
                    .width(1.2),
            );
        });
    let name = format!("{title} over {label}");
    response
        .response
        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::GraphicsObject, true, name.clone()));
    let part = plots::with_labels(response.response.rect);
    picture::menu(&response.response, part, None, out);
    if pressed(&response.response)
        && let Some(pointer) = response.response.interact_pointer_pos()
    {
        let x = response.transform.value_from_position(pointer).x / shown_as;
        // As fine as one can point: three digits.
        let value = significant(x.max(0.0), 3).parse().unwrap_or(0.0);
        let wanted = match along {
            Along::F => Thresholds {
                f_th: value,
                ..present
            },
            Along::T => Thresholds {
                t_th_secs: value,
                ..present
            },
        };
        if wanted != present {
            out.push(Edit::Thresholds(wanted).into());
        }
    }
}
