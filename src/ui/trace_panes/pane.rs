//! Draws the two plots of one axis: the loads, and the errors below the loads.

use std::ops::Range;
use std::sync::Arc;

use egui::{Color32, Ui};
use egui_plot::{FilledArea, Plot, PlotBounds, PlotResponse, PlotUi, Span, VLine};

use crate::{
    min_max::MinMax,
    questions::{AxisTraces, Segment, TraceSet, check::query::FaultyRecording},
    recording::Axis,
    report::figure::{self, Figure, Scale},
    scoring::{Series, series::Columns},
    ui::{
        command::Out,
        palette::{self, Trace},
        plots::{self, Asked, Drawn, VALUE_AXIS_WIDTH},
        time_view::{Kind, TimeView, all_of, within},
        trace_panes::{
            drawn::{DrawnLines, piece, trace_line},
            overlay,
        },
    },
};

/// Share of the height for the loads; the errors get the remaining height.
const TRACES_SHARE: f32 = 0.56;
/// Minimum mean distance (pixels) of the marks at which recordings begin. If the marks are closer, none is drawn.
const MARKS_APART: usize = 8;
/// Minimum horizontal resolution of a saved figure (pixels).
const PRINTED_COLUMNS: usize = figure::STANDS_ALONE.0 as usize;

#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub height: f32,
    /// Height of the time axis under the plot; `None` without a time axis.
    pub time_axis: Option<f32>,
}

struct Visible<'a> {
    traces: &'a TraceSet,
    time: (f64, f64),
    samples: Range<usize>,
    /// Width of the plot in pixels.
    columns: usize,
}

/// Draws both plots of an axis. Returns the index of the sample under the pointer.
pub fn cell(
    ui: &mut Ui,
    traces: &TraceSet,
    axis: &AxisTraces,
    place: Place,
    (panes, drawn): (&mut TimeView, &DrawnLines),
    out: &mut Out,
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
    ui: &mut Ui,
    traces: &TraceSet,
    (axis, kind): (&AxisTraces, Kind),
    place: Place,
    (panes, drawn): (&mut TimeView, &DrawnLines),
    out: &mut Out,
) -> Option<usize> {
    let time_axis = place.time_axis.is_some();
    let height = place.height + place.time_axis.unwrap_or(0.0);
    let width = (ui.available_width() - VALUE_AXIS_WIDTH).max(1.0);
    let columns = (width * ui.pixels_per_point()) as usize + 1;
    let visible = Visible::of(traces, panes.shown.time, columns)?;
    let shown = shown_series(axis, kind, panes);
    let key = (axis.axis, kind);
    let locked = panes.shown.values.get(&key).copied();
    let values = locked.unwrap_or_else(|| value_range(&shown, &visible.samples, kind));
    let bounds = PlotBounds::from_min_max([visible.time.0, values.0], [visible.time.1, values.1]);
    let visuals = ui.visuals().clone();
    let title = match kind {
        Kind::Load => axis.axis.label(),
        Kind::Error => format!("error [{}]", axis.axis.unit()),
    };
    let plot = Plot::new(("traces", axis.axis.symbol(), kind == Kind::Error));
    let plot = plots::scales(plot, time_axis.then_some(traces.across()), &title);
    let plot = plots::moving(plot, height).allow_zoom([true, false]).allow_drag([true, false]);
    let hovered = panes.hovered;
    let lie_apart = visible.samples.len() < columns;
    let key_of_columns = (&traces.times, visible.time, columns);
    let shared = panes.columns.take(key_of_columns, || visible.columns_of(columns));
    let lines = shown.iter().map(|(trace, series)| {
        // If a line has several samples per pixel, it is drawn solid, because dashes would look like noise.
        let dash = (trace.is_dashed() && lie_apart).then_some(figure::DASHED);
        let style = (trace.stroke(&visuals), dash);
        trace_line((axis.axis, kind, *trace), (series, &shared, &traces.times), style, drawn)
    });
    let (cursors, faulty) = (&panes.cursors, &panes.faulty[..]);
    let PlotResponse { response, transform, .. } = plot.show(ui, |plot| {
        plot.set_plot_bounds(bounds);
        visible.shade_faulty(plot, faulty, palette::faulty(&visuals));
        visible.separate_segments(plot, visuals.widgets.noninteractive.bg_stroke);
        if kind == Kind::Load {
            overlay::thresholds(plot, traces, hovered, &visuals);
            let color = Trace::Compensated.color(&visuals).gamma_multiply(0.22);
            visible.shade_band(plot, axis, color);
        }
        lines.for_each(|line| plot.add(line));
        overlay::samples(plot, traces, axis, kind == Kind::Load, hovered, &visuals);
        cursors.mark(plot, &visuals);
    });
    let plot = Drawn { response, transform };
    follow_gestures(ui, &plot, bounds, key, traces, panes);
    put_cursor(ui, &plot, panes);
    let print = || Figure {
        title: match kind {
            Kind::Load => title.clone(),
            Kind::Error => format!("{} {title}", axis.axis.symbol()),
        },
        across: Scale::new(traces.across(), visible.time),
        up: Scale::new(&title, values),
        lines: printed(&shown, traces, &visible.columns_of(columns.max(PRINTED_COLUMNS))),
        ..Figure::default()
    };
    plots::finish(&plot.response, &title, Some(&print), out);
    let ranges = || {
        format!("{}, {}", plots::range(visible.time, traces.across()), plots::range(values, &title))
    };
    sample_at_pointer(&plot, traces, axis, panes, ranges)
}

/// Gives screen readers the values of the present sample. Returns the index of the sample under the pointer.
fn sample_at_pointer(
    plot: &Drawn,
    traces: &TraceSet,
    axis: &AxisTraces,
    panes: &TimeView,
    ranges: impl Fn() -> String,
) -> Option<usize> {
    let hovered = panes.hovered;
    let at_cursor = || traces.sample_at(panes.cursors.first()?);
    plots::say(&plot.response, || match hovered.or_else(at_cursor) {
        Some(k) => overlay::spoken(traces, axis, k),
        None => ranges(),
    });
    let pointer = plot.response.hover_pos()?;
    traces.sample_at(plot.transform.value_from_position(pointer).x)
}

impl<'a> Visible<'a> {
    /// Returns the chosen interval, or the whole time, with the range of the samples inside and one more sample on each side.
    fn of(traces: &'a TraceSet, chosen: Option<(f64, f64)>, columns: usize) -> Option<Self> {
        traces.times.first()?;
        let time = chosen.unwrap_or_else(|| all_of(&traces.times));
        let start = traces.times.partition_point(|t| *t < time.0).saturating_sub(1);
        let end = traces.times.partition_point(|t| *t <= time.1) + 1;
        let end = end.min(traces.times.len());
        Some(Self { traces, time, samples: start.min(end)..end, columns })
    }

    /// Returns the duration of one column of pixels (s) if the plot has this number of columns.
    fn column_secs(&self, columns: usize) -> f64 {
        (self.time.1 - self.time.0) / columns.max(1) as f64
    }

    fn segments(&self) -> &'a [Segment] {
        let (segments, samples) = (&self.traces.segments, &self.samples);
        let first = segments.partition_point(|segment| segment.samples.end <= samples.start);
        let end = segments.partition_point(|segment| segment.samples.start < samples.end);
        &segments[first..end.max(first)]
    }

    /// Returns the columns of pixels for each line. Each recording has its own line, unless there are more recordings than
    /// columns.
    fn columns_of(&self, columns: usize) -> Vec<Columns> {
        let column_secs = self.column_secs(columns);
        let of = |samples: Range<usize>| Columns::of(&self.traces.times, samples, column_secs);
        let (samples, segments) = (&self.samples, self.segments());
        if segments.len() > columns {
            return vec![of(samples.clone())];
        }
        let ranges = segments.iter().map(|segment| &segment.samples);
        ranges.map(|part| of(part.start.max(samples.start)..part.end.min(samples.end))).collect()
    }

    /// Shades the band that contains the load with a probability of about 95 %, if the regressor computes such a band.
    fn shade_band(&self, plot: &mut PlotUi<'_>, axis: &AxisTraces, color: Color32) {
        let Some([low, high]) = &axis.band else {
            return;
        };
        let column_secs = self.column_secs(self.columns);
        let times_of = &self.traces.times;
        let (mut times, mut lows, mut highs) = (Vec::new(), Vec::new(), Vec::new());
        let mut start = self.samples.start;
        while start < self.samples.end {
            let from = times_of[start];
            let left = &times_of[start..self.samples.end];
            let n = left.partition_point(|time| *time < from + column_secs);
            let column = start..start + n.max(1);
            start = column.end;
            let band = low.min_max(column.clone()).zip(high.min_max(column));
            if let Some(((low, _), (_, high))) = band {
                times.push(0.5 * (from + times_of[start - 1]));
                lows.push(low);
                highs.push(high);
            }
        }
        plot.add(FilledArea::new("", &times, &lows, &highs).fill_color(color));
    }

    fn shade_faulty(&self, plot: &mut PlotUi<'_>, faulty: &[Arc<FaultyRecording>], color: Color32) {
        let pixel = self.column_secs(self.columns);
        for segment in self.segments() {
            let Some(found) = faulty.get(segment.recording) else {
                return;
            };
            let (intervals, offset) = (&found.intervals, segment.clock_offset_secs);
            let (from, to) = (self.time.0 + offset, self.time.1 + offset);
            let mut at = intervals.partition_point(|(_, end)| *end < from);
            while at < intervals.len() && intervals[at].0 <= to {
                let (start, end) = intervals[at];
                // Intervals less than a pixel apart are drawn as one interval.
                let next = at + intervals[at..].partition_point(|(later, _)| *later <= end + pixel);
                let end = intervals[next - 1].1.max(start + pixel);
                let span = Span::new("", start - offset..=end - offset);
                plot.span(span.fill(color).border_width(0.0));
                at = next;
            }
        }
    }

    fn separate_segments(&self, plot: &mut PlotUi<'_>, stroke: egui::Stroke) {
        let segments = self.segments();
        if segments.len() > self.columns / MARKS_APART {
            return;
        }
        for segment in segments.iter().skip(1) {
            let start = self.traces.times[segment.samples.start];
            plot.vline(VLine::new("", start).stroke(stroke).allow_hover(false));
        }
    }
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

/// Returns the range of the visible values with a margin. The range of errors includes zero.
fn value_range(shown: &[(Trace, &Arc<Series>)], samples: &Range<usize>, kind: Kind) -> (f64, f64) {
    let zero = (kind == Kind::Error).then_some((0.0, 0.0));
    let all = shown.iter().filter_map(|(_, series)| series.min_max(samples.clone())).chain(zero);
    let range: MinMax = all.flat_map(|(low, high)| [low, high]).collect();
    let (low, high) = range.ends().unwrap_or((-1.0, 1.0));
    let margin = if high > low { 0.06 * (high - low) } else { 0.1 * high.abs().max(1e-3) };
    (low - margin, high + margin)
}

fn printed(
    shown: &[(Trace, &Arc<Series>)],
    traces: &TraceSet,
    columns: &[Columns],
) -> Vec<figure::Line<'static>> {
    let visuals = &egui::Visuals::light();
    let line = |(trace, series): &(Trace, &Arc<Series>)| {
        let pieces = columns.iter().map(|columns| piece(series, &traces.times, columns));
        figure::Line {
            width: trace.stroke(visuals).width,
            dash: trace.is_dashed().then_some(figure::DASHED),
            ..figure::Line::new(trace.label(), palette::bytes(trace.color(visuals)), pieces)
        }
    };
    shown.iter().map(line).collect()
}

/// Applies the user's zoom and drag: the time range to all plots, and the value range to this plot.
fn follow_gestures(
    ui: &Ui,
    plot: &Drawn,
    set: PlotBounds,
    key: (Axis, Kind),
    traces: &TraceSet,
    panes: &mut TimeView,
) {
    match plots::gestures(ui, plot, set, false) {
        Some(Asked::All) => {
            panes.shown.time = None;
            panes.shown.values.remove(&key);
        }
        Some(Asked::Part(min, max)) => {
            if (min[0], max[0]) != (set.min()[0], set.max()[0]) {
                panes.shown.time = Some(within(&traces.times, (min[0], max[0])));
            }
            if (min[1], max[1]) != (set.min()[1], set.max()[1]) {
                panes.shown.values.insert(key, (min[1], max[1]));
            }
        }
        None => {}
    }
}

/// Puts cursor A at a click, or cursor B at a click with Shift.
fn put_cursor(ui: &Ui, plot: &Drawn, panes: &mut TimeView) {
    if plot.response.clicked()
        && let Some(pointer) = plot.response.interact_pointer_pos()
    {
        let which = usize::from(ui.input(|input| input.modifiers.shift));
        panes.cursors.put(which, plot.transform.value_from_position(pointer).x);
    }
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
