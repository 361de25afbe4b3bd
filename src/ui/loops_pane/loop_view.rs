//! Loops of one axis, the width over the load, and the table of figures.

use super::{FiguresOf, LoopsPane, for_print, rgb, trace_of};
use std::ops::Range;

use crate::analysis::loops::{LoopCurve, LoopFigures, LoopPlot, Output, Span, Up, clouds};
use crate::analysis::{AxisTraces, TraceSet};
use crate::engine::Engine;
use crate::evaluation::metrology::Reason;
use crate::recording::RecordingSet;
use crate::report::figure::{DASHED, DOTTED, Figure, Line, Scale};
use crate::report::{LoopMeasures, LoopScale, Trace, loop_figures};
use crate::ui::command::Command;
use crate::ui::numbers::significant;
use crate::ui::palette::look_back;
use crate::ui::plots::{Mark, Pointer};
use crate::ui::time_view::TimeView;
use crate::ui::{plots, table};

/// A sample this near to the pointer is pointed at (points).
const NEAR_POINTS: f64 = 14.0;
/// Among more samples than this none is searched for, since that is done in every frame.
const MOST_SEARCHED: usize = 1_000_000;
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
    let samples = Samples::of(engine, picture, time.visible_time());
    let outputs: Vec<Option<Output>> = view.shown.iter().map(|curve| curve.output).collect();
    let marks = time.hovered.into_iter().flat_map(|k| {
        let samples = samples.as_ref();
        let marks = outputs.iter().filter_map(move |output| {
            let at = samples?.place(k, *output)?;
            Some((at, *output))
        });
        marks.collect::<Vec<_>>()
    });
    let marks: Vec<Mark> = marks
        .map(|(at, output)| {
            let [r, g, b] = color(output, &visuals);
            let color = egui::Color32::from_rgb(r, g, b);
            Mark { at, color }
        })
        .collect();
    let zoom = *pane.zoom();
    let drawing = view.loops(&visuals, zoom);
    let print = view.loops(&for_print(), zoom);
    pane.lay_out(ui, [&drawing, &print], &marks, out, |ui, pane, out| {
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
            plots::plot(ui, "loop widths", WIDTHS_HEIGHT, [&widths, &print], &mut zoom, &[], out);
        }
    });
    let nearest = (pane.pointer.zip(samples.as_ref()))
        .and_then(|(pointer, samples)| samples.nearest(pointer, &outputs));
    time.pointed = nearest.map(|(k, ..)| k);
    if let Some(((k, output, at), samples)) = nearest.zip(samples.as_ref()) {
        samples.tooltip(ui, k, output, at);
        ui.request_repaint(); // the traces show it in the next frame
    }
}

/// The samples that the traces and the loops have in common.
struct Samples<'a> {
    traces: &'a TraceSet,
    axis: &'a AxisTraces,
    picture: &'a LoopPlot,
    recordings: &'a RecordingSet,
    decimation: usize,
    ranges: Vec<Range<usize>>,
}

impl<'a> Samples<'a> {
    fn of(engine: &'a Engine, picture: &'a LoopPlot, visible: Option<(f64, f64)>) -> Option<Self> {
        let analysis = engine.analysis()?;
        let (traces, question) = (&*analysis.traces, &picture.question);
        let recordings = &*engine.project().recordings;
        let is_looked_at = |recording: usize| match question.span {
            Span::Visible | Span::All => true,
            Span::One(only) => only == recording,
            Span::Of(of) => {
                let entry = recordings.entries().get(recording);
                entry.is_some_and(|entry| of.includes(entry.role))
            }
        };
        let (from, to) = match question.span {
            Span::Visible => visible.unwrap_or((f64::NEG_INFINITY, f64::INFINITY)),
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        };
        let start = traces.times.partition_point(|time| *time < from);
        let end = traces.times.partition_point(|time| *time <= to);
        let segments = traces.segments.iter();
        let looked_at = segments.filter(|segment| is_looked_at(segment.recording));
        Some(Self {
            traces,
            axis: traces.axes.iter().find(|own| own.axis == question.axis)?,
            picture,
            recordings,
            decimation: analysis.calibration.decimation.max(1),
            ranges: looked_at
                .map(|segment| segment.samples.start.max(start)..segment.samples.end.min(end))
                .filter(|range| !range.is_empty())
                .collect(),
        })
    }

    /// Where a sample stands over the load; `None` where it is not among them.
    fn place(&self, k: usize, output: Option<Output>) -> Option<[f64; 2]> {
        let is_there = self.ranges.iter().any(|range| range.contains(&k));
        is_there.then(|| self.value(k, output)).flatten()
    }

    fn value(&self, k: usize, output: Option<Output>) -> Option<[f64; 2]> {
        let axis = self.axis;
        let up = match (self.picture.question.up, output) {
            (Up::Load, Some(Output::Conventional)) => axis.conventional.value(k),
            (Up::Load, Some(Output::Compensated)) => axis.compensated.value(k),
            (Up::Error, Some(Output::Conventional)) => axis.conventional_error.as_ref()?.value(k),
            (Up::Error, Some(Output::Compensated)) => axis.compensated_error.as_ref()?.value(k),
            (Up::Gauge(gauge), _) => {
                let segment = self.traces.segment_of(k)?;
                let recording = &self.recordings.entries().get(segment.recording)?.recording;
                let row = (k - segment.samples.start) * self.decimation;
                *recording.gauges().get(row * recording.n_gauges() + gauge)?
            }
            (_, None) => return None,
        };
        Some([axis.calculated.as_ref()?.value(k), up])
    }

    /// The sample nearest to the pointer, if it is near.
    fn nearest(
        &self,
        pointer: Pointer,
        outputs: &[Option<Output>],
    ) -> Option<(usize, Option<Output>, [f64; 2])> {
        let n: usize = self.ranges.iter().map(Range::len).sum();
        if n > MOST_SEARCHED {
            return None;
        }
        let distance = |at: [f64; 2]| {
            let off = [0, 1].map(|i| (at[i] - pointer.at[i]) / pointer.per_point[i]);
            off[0].hypot(off[1])
        };
        let samples = self.ranges.iter().cloned().flatten();
        let all = samples.flat_map(|k| outputs.iter().map(move |output| (k, *output)));
        let near = all.filter_map(|(k, output)| {
            let at = self.value(k, output)?;
            let distance = distance(at);
            (distance < NEAR_POINTS).then_some((distance, (k, output, at)))
        });
        let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, found)| found)
    }

    /// What, where and when it is, with units.
    fn tooltip(&self, ui: &egui::Ui, k: usize, output: Option<Output>, at: [f64; 2]) {
        let axis = self.picture.question.axis;
        let (what, unit) = match self.picture.question.up {
            Up::Load => ("load", axis.unit()),
            Up::Error => ("error", axis.unit()),
            Up::Gauge(_) => ("reading", "raw"),
        };
        egui::Tooltip::always_open(
            ui.ctx().clone(),
            ui.layer_id(),
            ui.scope_id().with("loop sample"),
            egui::PopupAnchor::Pointer,
        )
        .gap(18.0)
        .show(|ui| {
            let [load, up] = at.map(|value| significant(value, 4));
            ui.strong(format!("{} {what} {up} {unit}", name(output)));
            ui.label(format!("at {} {load} {}", axis.symbol(), axis.unit()));
            let recording = self
                .traces
                .segment_of(k)
                .map_or("", |segment| &segment.name);
            ui.weak(format!(
                "{} s, {recording}",
                significant(self.traces.times[k], 6)
            ));
        });
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
            lines: self
                .no_error(visuals)
                .into_iter()
                .chain(branches)
                .chain(loops)
                .collect(),
            ..Figure::default()
        }
    }

    /// Where the load stands over the load: the line of a sensor without errors.
    fn no_error(&self, visuals: &egui::Visuals) -> Option<Line<'a>> {
        let (low, high) = self.picture.whole.loads;
        (self.picture.question.up == Up::Load).then(|| Line {
            width: 1.0,
            dash: Some(DOTTED),
            ..Line::new(
                "1 : 1",
                rgb(visuals.weak_text_color()),
                [vec![[low, low], [high, high]]],
            )
        })
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
