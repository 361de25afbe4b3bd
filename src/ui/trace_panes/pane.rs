//! The two panes of one axis: traces, and errors below them.

use crate::min_max::MinMax;
use std::ops::Range;
use std::sync::Arc;

use egui_plot::{FilledArea, Plot, PlotBounds, PlotItemBase, PlotResponse, PlotUi, Span, VLine};

use crate::questions::check::faulty::FaultyRecording;
use crate::questions::{AxisTraces, TraceSet};
use crate::recording::Axis;
use crate::report::figure;
use crate::report::figure::{Figure, Scale};
use crate::scoring::Series;
use crate::scoring::series::Columns;
use crate::ui::command::Command;
use crate::ui::palette;
use crate::ui::palette::Trace;
use crate::ui::plots;
use crate::ui::plots::{Asked, VALUE_AXIS_WIDTH};
use crate::ui::time_view::{Kind, TimeView, all_of, within};
use crate::ui::trace_panes::drawn::{DrawnLines, TraceLine, piece};
use crate::ui::trace_panes::overlay;

/// Share of a cell's height for the traces; the rest is for the errors.
const TRACES_SHARE: f32 = 0.55;
/// Minimum mean distance of the marks between recordings (pixels). Closer marks would hide the traces.
const MARKS_APART: usize = 8;
/// Minimum number of columns of a saved figure.
const PRINTED_COLUMNS: usize = figure::STANDS_ALONE.0 as usize;
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub height: f32,
    pub time_axis: Option<f32>,
}

struct Visible {
    time: (f64, f64),
    samples: Range<usize>,
}

impl Visible {
    /// Returns the duration of one column, if there are this many.
    fn column_secs(&self, columns: usize) -> f64 {
        (self.time.1 - self.time.0) / columns.max(1) as f64
    }
}

/// Draws both panes of an axis. Returns the sample under the pointer.
pub fn cell(
    ui: &mut egui::Ui,
    traces: &TraceSet,
    axis: &AxisTraces,
    place: Place,
    (panes, drawn): (&mut TimeView, &DrawnLines),
    out: &mut Vec<Command>,
) -> Option<usize> {
    if axis.calculated.is_none() {
        return pane(ui, traces, (axis, Kind::Load), place, (panes, drawn), out);
    }
    let upper = Place { height: place.height * TRACES_SHARE, time_axis: None };
    let lower = Place { height: place.height - upper.height, ..place };
    let above = pane(ui, traces, (axis, Kind::Load), upper, (panes, drawn), out);
    let below = pane(ui, traces, (axis, Kind::Error), lower, (panes, drawn), out);
    above.or(below)
}

fn pane(
    ui: &mut egui::Ui,
    traces: &TraceSet,
    (axis, kind): (&AxisTraces, Kind),
    place: Place,
    (panes, drawn): (&mut TimeView, &DrawnLines),
    out: &mut Vec<Command>,
) -> Option<usize> {
    let time_axis = place.time_axis.is_some();
    let height = place.height + place.time_axis.unwrap_or(0.0);
    let visible = visible(traces, panes.shown.time)?;
    let shown = shown_series(axis, kind, panes);
    let key = (axis.axis, kind);
    let locked = panes.shown.values.get(&key).copied();
    let values = locked.unwrap_or_else(|| value_range(&shown, &visible.samples, kind));
    if panes.locks_values {
        panes.shown.values.insert(key, values);
    }
    let bounds = PlotBounds::from_min_max([visible.time.0, values.0], [visible.time.1, values.1]);
    let width = (ui.available_width() - VALUE_AXIS_WIDTH).max(1.0);
    let columns = (width * ui.pixels_per_point()) as usize + 1;
    let visuals = ui.visuals().clone();
    let title = title(axis.axis, kind);
    let plot = Plot::new(("traces", axis.axis.symbol(), kind == Kind::Error));
    let plot = plots::scales(plot, time_axis.then_some(traces.across()), &title);
    let plot = plots::moving(plot, height).allow_zoom([true, false]).allow_drag([true, false]);
    let hovered = panes.hovered;
    let lie_apart = visible.samples.len() < columns;
    let make = || columns_of(traces, &visible, columns);
    let shared = (panes.columns).take((&traces.times, visible.time, columns), make);
    let lines = shown.iter().map(|(trace, series)| TraceLine {
        base: PlotItemBase::new(trace.label().to_owned()),
        at: (axis.axis, kind, *trace),
        series,
        columns: &shared,
        times: &traces.times,
        stroke: trace.stroke(&visuals),
        // Dashes would look like noise on a line that goes up and down within a pixel.
        dash: (trace.is_dashed() && lie_apart).then_some(figure::DASHED),
        drawn,
    });
    let (cursors, faulty) = (&panes.cursors, &panes.faulty[..]);
    let response = plot.show(ui, |plot| {
        plot.set_plot_bounds(bounds);
        shade_without_past(plot, traces, &visible, columns, &visuals);
        shade_faulty(plot, traces, faulty, &visible, columns, &visuals);
        separate_segments(plot, traces, &visible, columns, &visuals);
        if kind == Kind::Load {
            overlay::thresholds(plot, traces, hovered, &visuals);
            shade_band(plot, traces, axis, &visible, columns, &visuals);
        }
        lines.for_each(|line| plot.add(line));
        overlay::samples(plot, traces, axis, kind == Kind::Load, hovered, &visuals);
        cursors.mark(plot, &visuals);
    });
    follow_gestures(ui, &response, bounds, key, traces, panes);
    put_cursor(ui, &response, panes);
    let print = || Figure {
        title: match kind {
            Kind::Load => title.clone(),
            Kind::Error => format!("{} {title}", axis.axis.symbol()),
        },
        across: Scale::new(traces.across(), visible.time),
        up: Scale::new(&title, values),
        lines: printed(
            &shown,
            traces,
            &columns_of(traces, &visible, columns.max(PRINTED_COLUMNS)),
            &egui::Visuals::light(),
        ),
        ..Figure::default()
    };
    plots::finish(&response.response, &title, Some(&print), out);
    let ranges = || {
        format!("{}, {}", plots::range(visible.time, traces.across()), plots::range(values, &title))
    };
    show_values(ui, &response, traces, (axis, kind), panes, ranges)
}

/// Shows the values of the sample under the pointer, or of the sample that plays, in a tooltip. Returns the sample under the pointer.
fn show_values(
    ui: &egui::Ui,
    response: &PlotResponse<()>,
    traces: &TraceSet,
    (axis, kind): (&AxisTraces, Kind),
    panes: &TimeView,
    ranges: impl Fn() -> String,
) -> Option<usize> {
    let hovered = panes.hovered;
    let at_cursor = || traces.sample_at(panes.cursors.first()?);
    plots::say(&response.response, || match hovered.or_else(at_cursor) {
        Some(k) => overlay::spoken(traces, axis, k),
        None => ranges(),
    });
    let sample = sample_under_pointer(response, traces);
    // While playing, the first pane shows the values.
    let is_first =
        kind == Kind::Load && traces.axes.first().is_some_and(|own| own.axis == axis.axis);
    let shown = match (sample, is_first && panes.playing.leads()) {
        (Some(k), _) => Some((k, None)),
        (None, true) => hovered.map(|k| (k, Some(response.response.rect))),
        (None, false) => None,
    };
    // The tooltip would cover the menu.
    if let Some((k, beside)) = shown.filter(|_| !response.response.context_menu_opened()) {
        overlay::tooltip(ui, &response.response, traces, axis, (k, beside));
    }
    sample
}

fn title(axis: Axis, kind: Kind) -> String {
    match kind {
        Kind::Load => axis.label(),
        Kind::Error => format!("error [{}]", axis.unit()),
    }
}

/// Returns the whole time axis or the chosen interval, with its samples and one more on each side.
fn visible(traces: &TraceSet, chosen: Option<(f64, f64)>) -> Option<Visible> {
    traces.times.first()?;
    let time = chosen.unwrap_or_else(|| all_of(&traces.times));
    let start = traces.times.partition_point(|t| *t < time.0).saturating_sub(1);
    let end = traces.times.partition_point(|t| *t <= time.1) + 1;
    let end = end.min(traces.times.len());
    let samples = start.min(end)..end;
    Some(Visible { time, samples })
}

fn shown_series<'a>(
    axis: &'a AxisTraces,
    kind: Kind,
    panes: &TimeView,
) -> Vec<(Trace, &'a Arc<Series>)> {
    let of = |trace: Trace| match kind {
        Kind::Load => axis.load(trace),
        Kind::Error => axis.error(trace),
    };
    Trace::ALL
        .into_iter()
        .filter(|trace| panes.is_shown(*trace))
        .filter_map(|trace| Some((trace, of(trace)?)))
        .collect()
}

/// Returns the range of the visible values with a margin; for errors it includes zero.
fn value_range(shown: &[(Trace, &Arc<Series>)], samples: &Range<usize>, kind: Kind) -> (f64, f64) {
    let zero = (kind == Kind::Error).then_some((0.0, 0.0));
    let all = shown.iter().filter_map(|(_, series)| series.min_max(samples.clone())).chain(zero);
    let range: MinMax = all.flat_map(|(low, high)| [low, high]).collect();
    let (low, high) = range.ends().unwrap_or((-1.0, 1.0));
    let margin = if high > low { 0.06 * (high - low) } else { 0.1 * high.abs().max(1e-3) };
    (low - margin, high + margin)
}

fn visible_segments<'a>(
    traces: &'a TraceSet,
    samples: &Range<usize>,
) -> &'a [crate::questions::Segment] {
    let segments = &traces.segments;
    let first = segments.partition_point(|segment| segment.samples.end <= samples.start);
    let end = segments.partition_point(|segment| segment.samples.start < samples.end);
    &segments[first..end.max(first)]
}

/// Returns the columns of each line: one line for each recording, so that recordings are not joined, as long as recordings
/// are wide enough to be visible.
fn columns_of(traces: &TraceSet, visible: &Visible, columns: usize) -> Vec<Columns> {
    let column_secs = visible.column_secs(columns);
    let of = |samples: Range<usize>| Columns::of(&traces.times, samples, column_secs);
    let samples = &visible.samples;
    let segments = visible_segments(traces, samples);
    if segments.len() > columns {
        return vec![of(samples.clone())];
    }
    segments
        .iter()
        .map(|segment| {
            let own = &segment.samples;
            of(own.start.max(samples.start)..own.end.min(samples.end))
        })
        .collect()
}

fn printed(
    shown: &[(Trace, &Arc<Series>)],
    traces: &TraceSet,
    columns: &[Columns],
    visuals: &egui::Visuals,
) -> Vec<figure::Line<'static>> {
    let line = |(trace, series): &(Trace, &Arc<Series>)| {
        let pieces = columns.iter().map(|columns| piece(series, &traces.times, columns));
        let pieces: Vec<_> = pieces.collect();
        figure::Line {
            width: trace.stroke(visuals).width,
            dash: trace.is_dashed().then_some(figure::DASHED),
            ..figure::Line::new(trace.label(), palette::bytes(trace.color(visuals)), pieces)
        }
    };
    shown.iter().map(line).collect()
}

/// Shades the interval that contains the load with about 95 % probability, if the regressor computes one.
fn shade_band(
    plot: &mut PlotUi<'_>,
    traces: &TraceSet,
    axis: &AxisTraces,
    visible: &Visible,
    columns: usize,
    visuals: &egui::Visuals,
) {
    let Some([low, high]) = &axis.band else {
        return;
    };
    let column_secs = visible.column_secs(columns);
    let (mut times, mut lows, mut highs) = (Vec::new(), Vec::new(), Vec::new());
    let mut start = visible.samples.start;
    while start < visible.samples.end {
        let from = traces.times[start];
        let left = &traces.times[start..visible.samples.end];
        let n = left.partition_point(|time| *time < from + column_secs);
        let column = start..start + n.max(1);
        if let Some(((low, _), (_, high))) =
            low.min_max(column.clone()).zip(high.min_max(column.clone()))
        {
            times.push(0.5 * (from + traces.times[column.end - 1]));
            lows.push(low);
            highs.push(high);
        }
        start = column.end;
    }
    let color = Trace::Compensated.color(visuals).gamma_multiply(0.22);
    plot.add(FilledArea::new("", &times, &lows, &highs).fill_color(color));
}

fn shade_without_past(
    plot: &mut PlotUi<'_>,
    traces: &TraceSet,
    visible: &Visible,
    columns: usize,
    visuals: &egui::Visuals,
) {
    let time_of = |k: usize| traces.times[k.min(traces.times.len() - 1)];
    let pixel = visible.column_secs(columns);
    let intervals = &traces.without_past;
    let last = intervals.partition_point(|interval| interval.start < visible.samples.end);
    let mut at = intervals.partition_point(|interval| interval.end <= visible.samples.start);
    while at < last {
        let start = time_of(intervals[at].start);
        let mut end = time_of(intervals[at].end);
        at += 1;
        // Intervals less than a pixel apart are drawn as one. Bisection finds them, since there may be millions.
        loop {
            let near = at
                + intervals[at..last]
                    .partition_point(|interval| time_of(interval.start) - end < pixel);
            if near == at {
                break;
            }
            end = time_of(intervals[near - 1].end);
            at = near;
        }
        let span =
            Span::new("", start..=end).fill(palette::without_past(visuals)).border_width(0.0);
        plot.span(span);
    }
}

/// Shades samples that look faulty, at least a pixel wide.
fn shade_faulty(
    plot: &mut PlotUi<'_>,
    traces: &TraceSet,
    faulty: &[Arc<FaultyRecording>],
    visible: &Visible,
    columns: usize,
    visuals: &egui::Visuals,
) {
    let pixel = visible.column_secs(columns);
    for segment in visible_segments(traces, &visible.samples) {
        let Some(FaultyRecording { intervals, .. }) =
            faulty.get(segment.recording).map(|own| &**own)
        else {
            return;
        };
        let offset = segment.clock_offset_secs;
        let (from, to) = (visible.time.0 + offset, visible.time.1 + offset);
        let mut at = intervals.partition_point(|(_, end)| *end < from);
        while at < intervals.len() && intervals[at].0 <= to {
            let (start, end) = intervals[at];
            // Intervals less than a pixel apart are drawn as one.
            let next = at + intervals[at..].partition_point(|(later, _)| *later <= end + pixel);
            let end = intervals[next - 1].1.max(start + pixel);
            let span = Span::new("", start - offset..=end - offset)
                .fill(palette::faulty(visuals))
                .border_width(0.0);
            plot.span(span);
            at = next;
        }
    }
}

fn separate_segments(
    plot: &mut PlotUi<'_>,
    traces: &TraceSet,
    visible: &Visible,
    columns: usize,
    visuals: &egui::Visuals,
) {
    let segments = visible_segments(traces, &visible.samples);
    if segments.len() > columns / MARKS_APART {
        return;
    }
    for segment in segments.iter().skip(1) {
        let start = traces.times[segment.samples.start];
        let stroke = visuals.widgets.noninteractive.bg_stroke;
        plot.vline(VLine::new("", start).stroke(stroke).allow_hover(false));
    }
}

/// Applies the user's zoom and drag: time for all panes, values for this pane.
fn follow_gestures(
    ui: &egui::Ui,
    response: &PlotResponse<()>,
    set: PlotBounds,
    key: (Axis, Kind),
    traces: &TraceSet,
    panes: &mut TimeView,
) {
    let asked = plots::keys(ui, &response.response, set, false);
    if response.response.double_clicked() || asked == Some(Asked::All) {
        panes.shown.time = None;
        panes.shown.values.remove(&key);
        return;
    }
    let now = match asked {
        Some(Asked::Part(min, max)) => PlotBounds::from_min_max(min, max),
        _ => *response.transform.bounds(),
    };
    if (now.min()[0], now.max()[0]) != (set.min()[0], set.max()[0]) {
        panes.shown.time = Some(within(&traces.times, (now.min()[0], now.max()[0])));
    }
    if (now.min()[1], now.max()[1]) != (set.min()[1], set.max()[1]) {
        panes.shown.values.insert(key, (now.min()[1], now.max()[1]));
    }
    if let Some(([at, _], factor)) = plots::wheel_zoom(ui, response) {
        let zoomed = (at + (now.min()[0] - at) * factor, at + (now.max()[0] - at) * factor);
        panes.shown.time = Some(within(&traces.times, zoomed));
    }
}

/// A click puts cursor A, with Shift cursor B.
fn put_cursor(ui: &egui::Ui, response: &PlotResponse<()>, panes: &mut TimeView) {
    if response.response.clicked()
        && let Some(pointer) = response.response.interact_pointer_pos()
    {
        let which = usize::from(ui.input(|input| input.modifiers.shift));
        panes.cursors.put(which, response.transform.value_from_position(pointer).x);
    }
}

fn sample_under_pointer(response: &PlotResponse<()>, traces: &TraceSet) -> Option<usize> {
    let pointer = response.response.hover_pos()?;
    let time = response.transform.value_from_position(pointer).x;
    traces.sample_at(time)
}

#[cfg(test)]
mod tests {
    use egui_plot::GridMark;

    use crate::ui::plots::tick_label;

    #[test]
    fn tick_labels_tell_neighbours_apart() {
        let labels = |step_size: f64| {
            let label =
                |at: i32| tick_label(GridMark { value: f64::from(at) * step_size, step_size });
            [label(-1), label(0), label(3)]
        };
        assert_eq!(labels(0.5), ["-0.5", "0.0", "1.5"]);
        assert_eq!(labels(0.02), ["-0.02", "0.00", "0.06"]);
        assert_eq!(labels(50.0), ["-50", "0", "150"]);
    }
}
