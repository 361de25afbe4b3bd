//! Links the loops with the traces: the sample under the pointer in one pane is marked in both panes.

use std::ops::Range;

use egui::{Pos2, Sense, Stroke, Ui};

use crate::{
    engine::Engine,
    questions::{
        AxisTraces, Segment, TraceSet,
        loops::{self, LoopPlot, LoopView, Up},
    },
    recording::Recording,
    report::Trace,
    scoring::Series,
    ui::{
        controls::named,
        palette,
        plots::{Drawn, VALUE_AXIS_WIDTH},
        small_plot::{over_samples, range},
        time_view::TimeView,
    },
};

/// Maximum distance (points) from the pointer to the nearest sample. A sample further away is not marked.
const NEAR: f32 = 12.0;
/// Maximum number of samples whose distance to the pointer is computed in a frame, so that the frame does not take long.
const MAX_SAMPLES: usize = 200_000;
/// Height of the load over time below the loop (points).
pub const STRIP_HEIGHT: f32 = 84.0;

/// Samples that both the loop plot and the traces show.
pub struct Shared<'a> {
    plot: &'a LoopPlot,
    traces: &'a TraceSet,
    axis: &'a AxisTraces,
    /// Samples of each recording that both the loop plot and the traces show. Empty if a recording in the traces has no
    /// reference load.
    parts: Vec<Part<'a>>,
}

struct Part<'a> {
    segment: &'a Segment,
    /// Indices of the recording's samples among the samples of the traces.
    samples: Range<usize>,
    calculated: &'a Series,
    recording: &'a Recording,
    decimation: usize,
}

impl<'a> Shared<'a> {
    pub fn of(plot: &'a LoopPlot, engine: &'a Engine) -> Option<Self> {
        let analysis = engine.analysis()?;
        let traces = &*analysis.traces;
        let axis = traces.axes.iter().find(|traced| traced.axis == plot.question.axis)?;
        let entries = engine.entries();
        let part = |of_loop: &loops::Part| {
            let mut segments = traces.segments.iter();
            let segment = segments.find(|segment| segment.recording == of_loop.recording)?;
            let over_traces =
                |sample: usize| (segment.samples.start + sample).min(segment.samples.end);
            Some(Part {
                segment,
                samples: over_traces(of_loop.samples.start)..over_traces(of_loop.samples.end),
                calculated: axis.calculated.as_deref()?,
                recording: &entries.get(of_loop.recording)?.recording,
                decimation: analysis.calibration.decimation,
            })
        };
        Some(Self { parts: plot.parts.iter().filter_map(part).collect(), plot, traces, axis })
    }

    /// Returns the reason why some samples of the loop plot are not in the traces; `None` if all are.
    pub fn missing(&self) -> Option<String> {
        let symbol = self.axis.axis.symbol();
        match (self.parts.len(), self.plot.parts.len()) {
            (n, all) if n == all => None,
            _ if self.axis.calculated.is_none() => Some(format!(
                "Not linked with Traces: a recording in Traces has no reference load {symbol}."
            )),
            (0, _) => {
                Some("Not linked with Traces: the pane Traces shows other recordings.".to_owned())
            }
            (n, all) => Some(format!(
                "The Traces pane shows {n} of {all} recordings; only these are linked with the loops."
            )),
        }
    }

    fn part_of(&self, k: usize) -> Option<&Part<'a>> {
        self.parts.iter().find(|part| part.samples.contains(&k))
    }

    /// Returns the point of the loop plot at which sample `k` of the traces is drawn.
    fn point(&self, part: &Part<'_>, output: Option<Trace>, k: usize) -> Option<[f64; 2]> {
        let up = match (self.plot.question.up, output) {
            (Up::Gauge(gauge), _) => {
                let sample = (k - part.segment.samples.start) * part.decimation.max(1);
                let n_gauges = part.recording.n_gauges();
                let row = part.recording.gauges().chunks_exact(n_gauges).nth(sample)?;
                *row.get(gauge)?
            }
            (Up::Error, output) => self.axis.error(output?)?.value(k),
            (Up::Load, output) => self.axis.load(output?)?.value(k),
        };
        Some([part.calculated.value(k), up])
    }

    /// Returns the sample that is drawn nearest to the pointer: its index in the traces.
    fn nearest(&self, drawn: &Drawn, shown: &[Option<Trace>], pointer: Pos2) -> Option<usize> {
        let n_samples: usize = self.parts.iter().map(|part| part.samples.len()).sum();
        let stride = n_samples.div_ceil(MAX_SAMPLES).max(1);
        let all = self.parts.iter().flat_map(|part| {
            shown.iter().flat_map(move |output| {
                let samples = part.samples.clone().step_by(stride);
                samples.filter_map(move |k| {
                    let at = drawn.place(self.point(part, *output, k)?);
                    Some((at.distance_sq(pointer), k))
                })
            })
        });
        let (distance, k) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
        (distance <= NEAR * NEAR).then_some(k)
    }

    /// Returns the samples of the innermost load cycle that contains sample `k`; small cycles may lie inside larger cycles.
    fn cycle_at(&self, k: usize) -> Option<Range<usize>> {
        let segment = self.part_of(k)?.segment;
        let first = segment.samples.start;
        let around = self.plot.cycles.iter().filter(|cycle| {
            cycle.recording == segment.recording && cycle.samples.contains(&(k - first))
        });
        let samples = &around.min_by_key(|cycle| cycle.samples.len())?.samples;
        Some(first + samples.start..first + samples.end)
    }
}

/// Draws the load over the time of the traces, with the load cycle under the pointer or else the visible time shaded. Returns
/// the sample under the pointer. A press shows only the cycle, and a press outside the visible time shows the whole time.
pub fn strip(ui: &mut Ui, shared: &Shared<'_>, time: &mut TimeView) -> Option<usize> {
    let size = egui::vec2(ui.available_width(), STRIP_HEIGHT);
    let (whole, response) = ui.allocate_exact_size(size, Sense::click());
    let axis = shared.axis;
    let place = whole.with_min_x(whole.left() + VALUE_AXIS_WIDTH).shrink2(egui::vec2(0.0, 4.0));
    let loads = [Trace::Calculated, Trace::Conventional, Trace::Compensated];
    let lines = loads.into_iter().filter_map(|trace| {
        let series = axis.load(trace).filter(|_| time.is_shown(trace))?;
        Some((trace.color(ui.visuals()), &**series))
    });
    let lines: Vec<_> = lines.collect();
    over_samples(ui, place, range(lines.iter().map(|(_, series)| *series)), &lines);
    let missing = shared.missing();
    let name = format!("{} over time", axis.axis.label());
    let name = missing.iter().fold(name, |name, missing| format!("{name}. {missing}"));
    named(&response, egui::Role::Button, &name);
    if let Some(missing) = &missing {
        let (at, font) =
            (place.left_top() + egui::vec2(4.0, 2.0), egui::FontId::proportional(12.0));
        let color = ui.visuals().weak_text_color();
        ui.painter_at(place).text(at, egui::Align2::LEFT_TOP, missing, font, color);
    }
    let times = &shared.traces.times;
    let n = times.len();
    let x_of = |k: usize| place.left() + k as f32 / n.max(1) as f32 * place.width();
    let pointer = response.hover_pos().filter(|at| place.contains(*at));
    let sample = pointer.map(|at| {
        let share = ((at.x - place.left()) / place.width()).clamp(0.0, 1.0);
        ((share * n as f32) as usize).min(n.saturating_sub(1))
    });
    let cycle = sample.and_then(|k| shared.cycle_at(k));
    let visible = time.visible_time().map(|(from, to)| {
        times.partition_point(|time| *time < from)..times.partition_point(|time| *time <= to)
    });
    let painter = ui.painter_at(place);
    if let Some(shaded) = cycle.as_ref().or(visible.as_ref()) {
        let part = place.with_min_x(x_of(shaded.start)).with_max_x(x_of(shaded.end));
        painter.rect_filled(part, 0.0, ui.visuals().strong_text_color().gamma_multiply(0.16));
    }
    if let Some(k) = sample.or(time.looked_at(ui.ctx())) {
        painter.vline(x_of(k), place.y_range(), Stroke::new(1.0, palette::present(ui.visuals())));
    }
    let about = "The load in the recording of the traces. A press shows the load cycle alone; a press outside the shaded time shows all cycles again";
    if response.on_hover_text(about).clicked() {
        match (cycle, visible) {
            (_, Some(visible)) if sample.is_some_and(|k| !visible.contains(&k)) => time.fit(),
            (Some(cycle), _) => time.show_samples(cycle),
            _ => {}
        }
    }
    sample
}

/// Marks one sample in the loops and in the traces: the sample under the pointer in either pane. After a click, returns the
/// samples of the load cycle that contains the sample.
pub fn link(
    ui: &Ui,
    drawn: &Drawn,
    view: &LoopView<'_>,
    shared: &Shared<'_>,
    time: &mut TimeView,
    in_strip: Option<usize>,
) -> Option<Range<usize>> {
    let shown: Vec<_> = view.shown.iter().map(|curve| curve.output).collect();
    let pointer = drawn.response.hover_pos();
    let near = pointer.and_then(|pointer| shared.nearest(drawn, &shown, pointer));
    let marked = near.or(in_strip).or(time.looked_at(ui.ctx()));
    if let Some((part, k)) = marked.and_then(|k| Some((shared.part_of(k)?, k))) {
        let painter = drawn.painter(ui);
        for output in &shown {
            if let Some(point) = shared.point(part, *output, k) {
                let at = drawn.place(point);
                painter.circle_filled(at, 4.5, color(*output, ui.visuals()));
                painter.circle_stroke(at, 6.0, Stroke::new(1.2, palette::present(ui.visuals())));
            }
        }
    }
    let k = near?;
    time.point_at(k, ui.ctx());
    let cycle = shared.cycle_at(k);
    if cycle.is_some() && !drawn.response.context_menu_opened() {
        let (layer, id) = (ui.layer_id(), drawn.response.id.with("cycle"));
        let pointer = egui::PopupAnchor::Pointer;
        let hint = egui::Tooltip::always_open(ui.ctx().clone(), layer, id, pointer).gap(18.0);
        hint.show(|ui| ui.label("Load cycle: click to show only this cycle"));
    }
    cycle.filter(|_| drawn.response.clicked())
}

fn color(output: Option<Trace>, visuals: &egui::Visuals) -> egui::Color32 {
    match output {
        Some(output) => output.color(visuals),
        None => palette::look_back(visuals),
    }
}
