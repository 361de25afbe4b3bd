//! The visible interval of time and the present sample, which all panes share.

mod cursors;
mod playing;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::{
    questions::{TraceSet, check::query::FaultyRecording},
    recording::Axis,
    scoring::series::Columns,
    ui::{command::TimeMove, palette::Trace},
};

pub use cursors::Cursors;
pub use playing::Playing;

/// Number of steps by the arrow keys across the visible interval of time. One step is about one pixel.
const STEPS_ACROSS: usize = 800;

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// The visible interval of time; `None` shows the whole time.
    pub time: Option<(f64, f64)>,
    pub values: BTreeMap<(Axis, Kind), (f64, f64)>,
}

/// Kind of plot: the loads of an axis, or the errors of these loads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    Load,
    Error,
}

#[derive(Debug, Default)]
pub struct TimeView {
    on: Option<Arc<Vec<f64>>>,
    pub shown: Shown,
    /// Samples that look faulty in each recording; empty until the search for faults ends.
    pub faulty: Vec<Arc<FaultyRecording>>,
    pub hovered: Option<usize>,
    /// Sample that was under the pointer last.
    last: usize,
    /// Number of the pass of egui in which the traces were last drawn.
    pub drawn_in: u64,
    /// Sample under the pointer in another pane.
    pub pointed: Option<usize>,
    pub hidden: Vec<Trace>,
    pub columns: SharedColumns,
    pub cursors: Cursors,
    pub playing: Playing,
}

/// Columns of pixels with the samples in each. All plots share them, because all plots show the same time and have the same
/// width.
#[derive(Debug, Default)]
pub struct SharedColumns {
    times: Arc<Vec<f64>>,
    shown: ((f64, f64), usize),
    columns: Arc<Vec<Columns>>,
}

impl SharedColumns {
    /// Returns the stored columns of pixels if times, interval and width are the same; otherwise makes new columns.
    pub fn take(
        &mut self,
        (times, time, n): (&Arc<Vec<f64>>, (f64, f64), usize),
        make: impl FnOnce() -> Vec<Columns>,
    ) -> Arc<Vec<Columns>> {
        let shown = (time, n);
        if !Arc::ptr_eq(&self.times, times) || self.shown != shown {
            self.columns = Arc::new(make());
            (self.times, self.shown) = (Arc::clone(times), shown);
        }
        Arc::clone(&self.columns)
    }
}

impl TimeView {
    /// Returns the visible interval of time; `None` for the whole time.
    pub fn visible_time(&self) -> Option<(f64, f64)> {
        self.shown.time
    }

    /// Returns the sample under the pointer in the traces, or at the playing position; `None` if no traces are on screen.
    pub fn looked_at(&self, context: &egui::Context) -> Option<usize> {
        let is_drawn = context.cumulative_pass_nr() <= self.drawn_in + 1;
        self.hovered.filter(|_| is_drawn)
    }

    /// Returns the sample under the pointer or at the playing position, or the last such sample.
    pub fn last_hovered(&self) -> usize {
        self.last
    }

    /// Notes the sample under the pointer or at the playing position.
    pub fn hover(&mut self, sample: Option<usize>) {
        self.hovered = sample;
        self.last = sample.unwrap_or(self.last);
    }

    /// Marks a sample in the traces, because it is under the pointer in another pane.
    pub fn point_at(&mut self, sample: usize, context: &egui::Context) {
        self.pointed = Some(sample);
        if self.hovered != Some(sample) {
            context.request_repaint();
        }
    }

    pub fn show_samples(&mut self, samples: std::ops::Range<usize>) {
        let Some(times) = self.on.as_ref().filter(|times| samples.end <= times.len()) else {
            return;
        };
        if let Some(last) = samples.end.checked_sub(1).filter(|last| *last > samples.start) {
            self.shown.time = Some((times[samples.start], times[last]));
        }
    }

    /// Discards zoom, cursors and playing position if other recordings are on screen.
    pub fn follow(&mut self, traces: &TraceSet) {
        if !self.on.as_ref().is_some_and(|on| Arc::ptr_eq(on, &traces.times)) {
            self.on = Some(Arc::clone(&traces.times));
            self.fit();
            (self.hovered, self.last) = (None, traces.times.len() / 2);
            self.cursors.clear();
            self.playing.clear();
        }
    }

    pub fn apply(&mut self, time_move: TimeMove) {
        match time_move {
            TimeMove::Fit => self.fit(),
            TimeMove::Zoom(factor) => {
                let present = self.present_time();
                self.set_time(|from, to| {
                    let at = present.filter(|at| (from..=to).contains(at));
                    let at = at.unwrap_or(0.5 * (from + to));
                    (at + (from - at) * factor, at + (to - at) * factor)
                });
            }
            TimeMove::Move(share) => self.set_time(|from, to| {
                let by = share * (to - from);
                (from + by, to + by)
            }),
            TimeMove::TogglePlay => self.playing.running = !self.playing.running,
            TimeMove::Step(samples) => self.step(samples),
            TimeMove::PutCursor(which) => {
                self.present_time().into_iter().for_each(|time| self.cursors.put(which, time));
            }
            TimeMove::ToggleTable => self.cursors.table = !self.cursors.table,
            TimeMove::ToggleCompensated => self.toggle(Trace::Compensated),
        }
    }

    pub fn fit(&mut self) {
        self.shown = Shown::default();
    }

    /// Returns the times of the cursors (s), counted from the first sample of a recording on screen.
    pub fn span_in(&self, recording: usize, traces: &TraceSet) -> Option<(f64, f64)> {
        let (a, b) = self.cursors.both()?;
        let mut segments = traces.segments.iter();
        let segment = segments.find(|segment| segment.recording == recording)?;
        let start = traces.times[segment.samples.start];
        let (from, to) = (a.min(b) - start, a.max(b) - start);
        (to >= 0.0).then_some((from.max(0.0), to))
    }

    /// Returns the time of the sample under the pointer, or at the playing position.
    fn present_time(&self) -> Option<f64> {
        self.on.as_ref()?.get(self.hovered?).copied()
    }

    /// Changes the visible interval of time, if recordings are on screen.
    fn set_time(&mut self, changed: impl FnOnce(f64, f64) -> (f64, f64)) {
        if let Some(times) = self.on.as_deref() {
            let (from, to) = self.shown.time.unwrap_or_else(|| all_of(times));
            self.shown.time = Some(within(times, changed(from, to)));
        }
    }

    /// Moves the present sample one step forward (1) or back (-1). A step is one sample, or one pixel if samples are denser
    /// than pixels.
    fn step(&mut self, step: i8) {
        let Some(times) = self.on.as_deref() else {
            return;
        };
        let (from, to) = self.shown.time.unwrap_or_else(|| all_of(times));
        let first = times.partition_point(|t| *t < from);
        let on_screen = times.partition_point(|t| *t <= to).saturating_sub(first);
        let samples = (on_screen / STEPS_ACROSS).max(1) as isize * isize::from(step);
        let now = self.hovered.unwrap_or(first);
        let next = now.saturating_add_signed(samples).min(times.len().saturating_sub(1));
        if let Some(time) = times.get(next).copied() {
            self.playing.stand_at(time);
            self.follow_time(time);
        }
    }

    /// Moves the visible interval so that it contains this time (s).
    fn follow_time(&mut self, time: f64) {
        if let Some((from, to)) = self.shown.time
            && !(from..=to).contains(&time)
        {
            let wide = to - from;
            let moved = if time < from { (time - wide, time) } else { (time, time + wide) };
            self.shown.time = Some(moved);
        }
    }

    /// Hides a trace, or shows it again.
    pub fn toggle(&mut self, trace: Trace) {
        let n_before = self.hidden.len();
        self.hidden.retain(|hidden| *hidden != trace);
        if self.hidden.len() == n_before {
            self.hidden.push(trace);
        }
    }

    pub fn is_shown(&self, trace: Trace) -> bool {
        !self.hidden.contains(&trace)
    }

    /// Continues playing the recording, and returns the index of the sample at the playing position. The visible interval
    /// follows this sample.
    pub fn play(&mut self, ui: &egui::Ui, traces: &TraceSet) -> Option<usize> {
        let start = traces.times.first().copied().unwrap_or(0.0);
        let on_screen = self.shown.time.map_or(start, |(from, _)| from.max(start));
        let from = self.cursors.first().unwrap_or(on_screen);
        let passed = ui.input(|input| f64::from(input.stable_dt));
        let (start, end) = self.shown.time.unwrap_or_else(|| all_of(&traces.times));
        let (sample, time) = self.playing.go_on((passed, end - start), from, traces)?;
        if self.playing.running {
            ui.ctx().request_repaint();
            self.follow_time(time);
        }
        Some(sample)
    }
}

pub fn all_of(times: &[f64]) -> (f64, f64) {
    let first = times.first().copied().unwrap_or(0.0);
    let last = times.last().copied().unwrap_or(first);
    let margin = if last > first { 0.01 * (last - first) } else { 0.5 };
    (first - margin, last + margin)
}

/// Limits an interval of time to the recordings and to a minimum width.
pub fn within(times: &[f64], (start, end): (f64, f64)) -> (f64, f64) {
    let first = times.first().copied().unwrap_or(0.0);
    let last = times.last().copied().unwrap_or(1.0);
    let all = (last - first).max(1e-3);
    let width = (end - start).clamp(1e-6 * all, 1.2 * all);
    let middle = (0.5 * (start + end)).clamp(first, last);
    (middle - 0.5 * width, middle + 0.5 * width)
}
