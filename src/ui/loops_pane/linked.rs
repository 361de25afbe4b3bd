//! The loop and the traces show the same sample: what one points at in one of them is marked and told in both.

use std::ops::Range;

use egui::{Pos2, Stroke};

use super::{LoopsPane, trace_of};
use crate::analysis::loops::{LoopPlot, Output, Up};
use crate::analysis::{AxisTraces, TraceSet};
use crate::evaluation::Series;
use crate::ui::numbers::{elided, significant};
use crate::ui::palette;
use crate::ui::plots::Drawn;
use crate::ui::time_view::TimeView;

/// The pointer means a line that is no farther away than this.
const NEAR: f32 = 12.0;
/// No more samples than this are looked at in a frame.
const MAX_SAMPLES: usize = 200_000;
/// Characters of a recording's name that have room.
const NAME_LENGTH: usize = 44;

/// Draws the line on which a load stands over itself.
pub(super) fn one_to_one(ui: &egui::Ui, drawn: &Drawn) {
    let (low, high) = drawn.across();
    let ends = [drawn.place([low, low]), drawn.place([high, high])];
    let stroke = Stroke::new(1.0, ui.visuals().weak_text_color());
    drawn
        .painter(ui)
        .extend(egui::Shape::dashed_line(&ends, stroke, 3.0, 4.0));
}

/// What goes up of one axis' traces; `None` where they have it not.
fn up_of(axis: &AxisTraces, up: Up, output: Output) -> Option<&Series> {
    match (up, output) {
        (Up::Error, Output::Conventional) => axis.conventional_error.as_deref(),
        (Up::Error, Output::Compensated) => axis.compensated_error.as_deref(),
        (Up::Load, Output::Conventional) => Some(&axis.conventional),
        (Up::Load, Output::Compensated) => Some(&axis.compensated),
        (Up::Gauge(_), _) => None,
    }
}

/// Marks in the loop what the traces look at; where the loop is of the same samples, tells of what the pointer is near, marks it in
/// the traces, and shows its cycle alone at a press.
pub(super) fn link(
    ui: &egui::Ui,
    drawn: &Drawn,
    picture: &LoopPlot,
    traces: &TraceSet,
    (pane, follows): (&LoopsPane, bool),
    time: &mut TimeView,
) {
    let question = &picture.question;
    let axis = traces.axes.iter().find(|own| own.axis == question.axis);
    let Some((axis, calculated)) = axis.and_then(|own| Some((own, own.calculated.as_deref()?)))
    else {
        return;
    };
    let shown = Output::ALL
        .into_iter()
        .filter(|output| pane.is_shown(*output));
    let series: Vec<(Output, &Series)> = shown
        .filter_map(|output| Some((output, up_of(axis, question.up, output)?)))
        .collect();
    let pointer = drawn.response.hover_pos().filter(|_| follows);
    let near = pointer.and_then(|pointer| {
        let samples = on_screen(traces, time.visible_time());
        nearest(drawn, calculated, &series, samples, pointer)
    });
    let marked = near.map(|(k, _)| k).or(time.looked_at(ui.ctx()));
    if let Some(k) = marked.filter(|k| *k < traces.times.len()) {
        let painter = drawn.painter(ui);
        for (output, values) in &series {
            let at = drawn.place([calculated.value(k), values.value(k)]);
            let color = trace_of(*output).color(ui.visuals());
            painter.circle_filled(at, 4.5, color);
            painter.circle_stroke(at, 6.0, Stroke::new(1.2, palette::present(ui.visuals())));
        }
    }
    let Some((k, output)) = near else {
        return;
    };
    time.point_at(k, ui.ctx());
    let cycle = cycle_at(picture, traces, k);
    if !drawn.response.context_menu_opened() {
        tell(
            ui,
            drawn,
            picture,
            traces,
            (axis, output, k),
            cycle.as_ref(),
        );
    }
    if let Some((_, samples)) = cycle.filter(|_| drawn.response.clicked()) {
        time.show_samples(samples);
    }
}

/// The samples of the interval of time that the traces show.
fn on_screen(traces: &TraceSet, visible: Option<(f64, f64)>) -> Range<usize> {
    match visible {
        None => 0..traces.times.len(),
        Some((from, to)) => {
            let start = traces.times.partition_point(|time| *time < from);
            start..traces.times.partition_point(|time| *time <= to).max(start)
        }
    }
}

/// The sample that is drawn nearest to the pointer, and of which output.
fn nearest(
    drawn: &Drawn,
    calculated: &Series,
    series: &[(Output, &Series)],
    samples: Range<usize>,
    pointer: Pos2,
) -> Option<(usize, Output)> {
    let stride = samples.len().div_ceil(MAX_SAMPLES).max(1);
    let all = series.iter().flat_map(|(output, values)| {
        samples.clone().step_by(stride).map(move |k| {
            let at = drawn.place([calculated.value(k), values.value(k)]);
            (at.distance_sq(pointer), k, *output)
        })
    });
    let found = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (found.0 <= NEAR * NEAR).then_some((found.1, found.2))
}

/// The innermost cycle that holds a sample: its number, and its samples counted over the traces.
fn cycle_at(picture: &LoopPlot, traces: &TraceSet, k: usize) -> Option<(usize, Range<usize>)> {
    let segment = traces.segment_of(k)?;
    let own = k - segment.samples.start;
    let holds = |(recording, samples): &(usize, Range<usize>)| {
        *recording == segment.recording && samples.contains(&own)
    };
    let cycles = picture.cycles.iter().enumerate();
    let (at, (_, samples)) = cycles
        .filter(|(_, cycle)| holds(cycle))
        .min_by_key(|(_, (_, samples))| samples.len())?;
    let over_traces = |sample: usize| segment.samples.start + sample;
    Some((at, over_traces(samples.start)..over_traces(samples.end)))
}

fn tell(
    ui: &egui::Ui,
    drawn: &Drawn,
    picture: &LoopPlot,
    traces: &TraceSet,
    (axis, output, k): (&AxisTraces, Output, usize),
    cycle: Option<&(usize, Range<usize>)>,
) {
    egui::Tooltip::always_open(
        ui.ctx().clone(),
        ui.layer_id(),
        drawn.response.id.with("sample"),
        egui::PopupAnchor::Pointer,
    )
    .gap(18.0)
    .show(|ui| {
        let (symbol, unit) = (axis.axis.symbol(), axis.axis.unit());
        let trace = trace_of(output);
        let name = traces.segment_of(k).map_or("", |segment| &segment.name);
        ui.colored_label(trace.color(ui.visuals()), trace.label());
        ui.weak(elided(name, NAME_LENGTH));
        let mut lines = vec![format!("at {} s", significant(traces.times[k], 6))];
        if let Some((at, _)) = cycle {
            lines.push(format!(
                "cycle {} of {}; a press shows it alone",
                at + 1,
                picture.n_cycles
            ));
        }
        if let Some(load) = &axis.calculated {
            lines.push(format!(
                "{symbol} Calc. {} {unit}",
                significant(load.value(k), 4)
            ));
        }
        let what = match picture.question.up {
            Up::Error => "error",
            _ => trace.label(),
        };
        if let Some(values) = up_of(axis, picture.question.up, output) {
            lines.push(format!(
                "{symbol} {what} {} {unit}",
                significant(values.value(k), 4)
            ));
        }
        for line in lines {
            ui.label(line);
        }
    });
}
