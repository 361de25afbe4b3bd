//! Loops of one axis, the width over the load, and the table of figures.

use super::{FiguresOf, LoopsPane, for_print, linked, rgb, trace_of};
use crate::analysis::loops::{LoopCurve, LoopFigures, LoopPlot, Output, Span, Up, clouds};
use crate::engine::Engine;
use crate::evaluation::metrology::Reason;
use crate::report::figure::{DASHED, Figure, Line, Scale};
use crate::report::{LoopMeasures, LoopScale, Trace, loop_figures};
use crate::ui::command::Command;
use crate::ui::numbers::significant;
use crate::ui::palette::{self, look_back};
use crate::ui::time_view::TimeView;
use crate::ui::{plots, table};

/// Height of the plot of widths.
const WIDTHS_HEIGHT: f32 = 150.0;

pub(super) fn show(
    ui: &mut egui::Ui,
    pane: &mut LoopsPane,
    engine: &Engine,
    picture: &LoopPlot,
    time: &mut TimeView,
    out: &mut Vec<Command>,
) {
    let gauges = &engine.project().recordings.layout().gauge_names;
    let has_mean = picture.curves.iter().any(|curve| curve.mean.is_ok());
    let view = View {
        picture,
        up: up_label(picture, gauges),
        // A few cycles have no mean loop: what is shown then is the largest of them, and called so.
        figures_of: if has_mean {
            pane.figures_of
        } else {
            FiguresOf::Largest
        },
        shown: (picture.curves.iter())
            .filter(|curve| curve.output.is_none_or(|output| pane.is_shown(output)))
            .collect(),
    };
    let visuals = ui.visuals().clone();
    let zoom = *pane.zoom();
    let drawing = view.loops(&visuals, zoom);
    let print = view.loops(&for_print(), zoom);
    let drawn = pane.lay_out(ui, &drawing, &print, out, |ui, pane, out| {
        ui.horizontal(|ui| {
            for (of, label, explanation) in [
                (
                    FiguresOf::Mean,
                    "Mean loop",
                    "Of the cycles that cover at least 80 % of the largest one's range, over the loads that all of them have: three or \
                     more, over more than half of all loads",
                ),
                (
                    FiguresOf::Largest,
                    "Largest cycle",
                    "The one cycle whose branches share the widest range of loads",
                ),
            ] {
                let can = has_mean || of == FiguresOf::Largest;
                let button = egui::Button::selectable(of == view.figures_of, label);
                let button = ui.add_enabled(can, button).on_hover_text(explanation);
                if button.clicked() {
                    pane.figures_of = of;
                }
            }
        });
        if let Some(Err(reason @ Reason::FewCycles { .. })) = picture.curves.first().map(|curve| &curve.mean) {
            ui.weak(format!("No mean loop: {reason}."));
        }
        view.counts(ui);
        view.figures(ui);
        if view.shown.iter().any(|curve| view.of(curve).is_ok()) {
            let widths = view.widths(&visuals);
            let print = view.widths(&for_print());
            let mut zoom = None; // always all of it
            plots::plot(ui, "loop widths", WIDTHS_HEIGHT, [&widths, &print], &mut zoom, out);
        }
    });
    view.directions(ui, &drawn);
    if picture.question.up == Up::Load {
        linked::one_to_one(ui, &drawn);
    }
    if let Some(analysis) = engine.analysis() {
        let follows = picture.question.span == Span::Visible;
        linked::link(ui, &drawn, picture, &analysis.traces, (pane, follows), time);
    }
}

/// A picture as it is looked at.
struct View<'a> {
    picture: &'a LoopPlot,
    up: String,
    figures_of: FiguresOf,
    shown: Vec<&'a LoopCurve>,
}

impl<'a> View<'a> {
    fn of(&self, curve: &'a LoopCurve) -> Result<&'a LoopFigures, &'a Reason> {
        match self.figures_of {
            FiguresOf::Mean => curve.mean.as_ref(),
            FiguresOf::Largest => curve.largest.as_ref(),
        }
    }

    fn across(&self) -> String {
        self.picture
            .question
            .axis
            .label_of(Trace::Calculated.label())
    }

    /// All branches thin, the loop that the figures are of above them.
    fn loops(&self, visuals: &egui::Visuals, zoom: plots::Zoom) -> Figure<'a> {
        let frame = zoom.unwrap_or(self.picture.whole);
        let points =
            |curve: &&LoopCurve| curve.drawn.strokes.iter().map(|one| one.points.len()).sum();
        let opacity = thin_opacity(self.shown.iter().map(points).max().unwrap_or(0));
        let branches = self.shown.iter().flat_map(|curve| {
            [(true, opacity), (false, 0.5 * opacity)].map(|(rising, opacity)| {
                let strokes = curve
                    .drawn
                    .strokes
                    .iter()
                    .filter(|stroke| stroke.rising == rising);
                let pieces = strokes.map(|stroke| &stroke.points[..]);
                Line {
                    opacity,
                    width: 1.0,
                    ..Line::new("", color(curve.output, visuals), pieces)
                }
            })
        });
        let loops = self.shown.iter().flat_map(|curve| {
            let figures = self.of(curve).into_iter();
            figures.flat_map(|figures| {
                let ways = [("rising", None), ("falling", Some(DASHED))];
                let ways = figures.branches.iter().zip(ways);
                ways.map(|(branch, (way, dash))| {
                    let name = format!("{} {way}", name(curve.output));
                    Line {
                        width: 2.4,
                        dash,
                        ..Line::new(name, color(curve.output, visuals), [&branch[..]])
                    }
                })
            })
        });
        Figure {
            title: format!("{} over {}", self.up, self.across()),
            across: Scale::new(self.across(), frame.loads),
            up: Scale::new(&self.up, frame.outputs),
            clouds: (self.shown.iter())
                .flat_map(|curve| {
                    let ink = rgb(visuals.strong_text_color());
                    clouds(&curve.drawn, color(curve.output, visuals), ink)
                })
                .collect(),
            lines: branches.chain(loops).collect(),
            ..Figure::default()
        }
    }

    /// Marks which way the load goes along the loop that the figures are of.
    fn directions(&self, ui: &egui::Ui, drawn: &plots::Drawn) {
        let painter = drawn.painter(ui);
        for curve in &self.shown {
            let Ok(figures) = self.of(curve) else {
                continue;
            };
            let color = palette::rgb(color(curve.output, ui.visuals()));
            let ways = figures.branches.iter().zip([true, false]);
            for (branch, is_rising) in ways.filter(|(branch, _)| branch.len() > 2) {
                let middle = branch.len() / 2;
                let [before, after] =
                    [branch[middle - 1], branch[middle]].map(|at| drawn.place(at));
                let way = (after - before).normalized() * if is_rising { 1.0 } else { -1.0 };
                let tip = before + 7.0 * way;
                let side = 5.0 * way.rot90();
                let corners = vec![tip, tip - 11.0 * way + side, tip - 11.0 * way - side];
                painter.add(egui::Shape::convex_polygon(
                    corners,
                    color,
                    egui::Stroke::NONE,
                ));
            }
        }
    }

    /// The width over the load.
    fn widths(&self, visuals: &egui::Visuals) -> Figure<'a> {
        let found: Vec<_> = (self.shown.iter())
            .filter_map(|curve| Some((curve.output, self.of(curve).ok()?)))
            .collect();
        let widths = found.iter().flat_map(|(_, figures)| &figures.widths);
        let heights = widths.map(|point| point[1]).chain([0.0]);
        Figure {
            title: "Width over load".to_owned(),
            across: Scale::new(self.across(), self.picture.whole.loads),
            up: Scale::spanning(format!("width [{}]", self.unit()), heights, 0.06),
            lines: (found.iter())
                .map(|(output, figures)| Line {
                    width: 1.6,
                    ..Line::new("", color(*output, visuals), [&figures.widths[..]])
                })
                .collect(),
            ..Figure::default()
        }
    }

    fn unit(&self) -> &'static str {
        match self.picture.question.up {
            Up::Gauge(_) => "raw",
            Up::Load | Up::Error => self.picture.question.axis.unit(),
        }
    }

    fn counts(&self, ui: &mut egui::Ui) {
        let picture = self.picture;
        let unit = picture.question.axis.unit();
        let found = self.shown.iter().find_map(|curve| self.of(curve).ok());
        let of = found.map_or_else(String::new, |figures| {
            let basis = &figures.basis[0];
            let what = match self.figures_of {
                FiguresOf::Mean => format!("Mean of {} cycles", basis.n_cycles),
                FiguresOf::Largest => "One cycle".to_owned(),
            };
            let share = significant(100.0 * basis.range_share, 2);
            format!("{what} over {share} % of the loads\n")
        });
        let words = format!(
            "{of}{} cycles, {} full · {} samples of {} recording{}",
            picture.n_cycles,
            picture.n_full_cycles,
            picture.n_samples,
            picture.n_recordings,
            if picture.n_recordings == 1 { "" } else { "s" },
        );
        ui.weak(words).on_hover_text(format!(
            "Dead band {} {unit}; full scale {} {unit}. Thin lines: all branches, the falling ones paler; where \
             they are too many, their density: the stronger, the more samples, rising in the colour of the load, falling in one \
             towards that of the text. Thick lines: the loop that the figures are of, its falling branch dashed",
            significant(picture.dead_band, 3),
            significant(picture.full_scale, 4),
        ));
    }

    fn figures(&self, ui: &mut egui::Ui) {
        let mut reasons: Vec<&Reason> = Vec::new();
        for curve in &self.shown {
            if let Err(reason) = self.of(curve)
                && !reasons.contains(&reason)
            {
                reasons.push(reason);
            }
        }
        for reason in reasons {
            ui.label(reason.to_string());
        }
        let found: Vec<_> = (self.shown.iter())
            .filter_map(|curve| Some((curve.output, self.of(curve).ok()?)))
            .collect();
        if found.is_empty() {
            return;
        }
        let picture = self.picture;
        let scale = LoopScale {
            axis: picture.question.axis,
            full_scale: picture.full_scale,
            is_gauge: matches!(picture.question.up, Up::Gauge(_)),
            output_scale: picture.output_scale,
        };
        let figures: Vec<_> = (found.iter())
            .map(|(output, one)| {
                let [largest, mean, area] = one.basis;
                LoopMeasures {
                    trace: output.map(trace_of),
                    figures: [
                        (one.largest_width, largest),
                        (one.mean_width, mean),
                        (one.area, area),
                    ],
                }
            })
            .collect();
        let figures = loop_figures(&figures, scale);
        table::show(ui, &figures);
        if ui
            .button("Copy figures")
            .on_hover_text("As tab-separated text")
            .clicked()
        {
            ui.copy_text(figures.tab_separated());
        }
        ui.add_space(4.0);
    }
}

/// The more lines lie over each other, the fainter each is, so that the thick ones stand out; one alone is seen all the same.
fn thin_opacity(n_points: usize) -> f32 {
    (0.6 * (1000.0 / n_points.max(1) as f32).sqrt()).clamp(0.2, 0.6)
}

fn name(output: Option<Output>) -> &'static str {
    output.map_or("Gauge", |output| trace_of(output).label())
}

fn color(output: Option<Output>, visuals: &egui::Visuals) -> [u8; 3] {
    rgb(match output {
        Some(output) => trace_of(output).color(visuals),
        None => look_back(visuals),
    })
}

fn up_label(picture: &LoopPlot, gauges: &[String]) -> String {
    let axis = picture.question.axis;
    match picture.question.up {
        Up::Load => axis.label(),
        Up::Error => axis.label_of("error"),
        Up::Gauge(gauge) => format!("{} [raw]", gauges.get(gauge).map_or("gauge", |name| name)),
    }
}
