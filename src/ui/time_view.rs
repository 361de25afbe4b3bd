//! The part of time that is on screen and the sample that is looked at, which all panes share.

mod cursors;
mod playing;

use std::collections::BTreeMap;
use std::sync::Arc;

use egui::util::undoer::{Settings, Undoer};

use crate::questions::TraceSet;
use crate::questions::check::faulty::FaultyRecording;
use crate::recording::Axis;
use crate::scoring::series::Columns;
use crate::ui::command::TimeMove;
use crate::ui::palette::Trace;

pub use cursors::Cursors;
pub use playing::Playing;

/// A zoom that stood for so long can be gone back to (s).
const SETTLED_SECS: f32 = 0.4;
/// A step by a key is at least this part of what is on screen: about one pixel.
const STEPS_ACROSS: usize = 800;
/// So many zooms are remembered.
const MAX_ZOOMS: usize = 50;

/// What part of the traces is on screen.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Shown {
    /// The interval of time; `None` shows all of it.
    pub(super) time: Option<(f64, f64)>,
    /// Value ranges that were chosen by hand.
    pub(super) values: BTreeMap<(Axis, Kind), (f64, f64)>,
}

/// Which of an axis' two panes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    Load,
    Error,
}

/// What the panes of traces remember between frames.
#[derive(Debug)]
pub struct TimeView {
    /// The time axis that the rest was chosen on.
    on: Option<Arc<Vec<f64>>>,
    pub(super) shown: Shown,
    /// What was shown before, and after.
    zooms: Undoer<Shown>,
    /// The sample under the pointer, or where it plays, in the last frame.
    /// What looks faulty in each recording, once it is known.
    pub(super) faulty: Vec<Arc<FaultyRecording>>,
    pub(super) hovered: Option<usize>,
    /// Whether the scales of values stay as they are.
    pub(super) locks_values: bool,
    /// The pass in which the panes were drawn last.
    pub(super) drawn_in: u64,
    /// The sample that is pointed at elsewhere.
    pub(super) pointed: Option<usize>,
    pub(super) hidden: Vec<Trace>,
    pub(super) columns: SharedColumns,
    pub(super) cursors: Cursors,
    pub(super) playing: Playing,
}

impl Default for TimeView {
    fn default() -> Self {
        Self {
            on: None,
            shown: Shown::default(),
            zooms: no_zooms(),
            faulty: Vec::new(),
            hovered: None,
            locks_values: false,
            drawn_in: 0,
            pointed: None,
            hidden: Vec::new(),
            columns: SharedColumns::default(),
            cursors: Cursors::default(),
            playing: Playing::default(),
        }
    }
}

/// The columns that all panes draw in: they show the same time, and are as wide as each other.
#[derive(Debug, Default)]
pub(super) struct SharedColumns {
    /// The time axis that they are of.
    times: Arc<Vec<f64>>,
    /// What is shown of it, and in how many columns.
    shown: ((f64, f64), usize),
    columns: Arc<Vec<Columns>>,
}

impl SharedColumns {
    /// Those that were made last, if they are of the same, else new ones.
    pub(super) fn take(
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

fn no_zooms() -> Undoer<Shown> {
    Undoer::with_settings(Settings {
        max_undos: MAX_ZOOMS,
        stable_time: SETTLED_SECS,
        ..Settings::default()
    })
}

impl TimeView {
    /// The interval of time on screen; `None` where it is all of it.
    pub fn visible_time(&self) -> Option<(f64, f64)> {
        self.shown.time
    }

    /// The sample under the pointer in the traces, or where they play, while they are on screen.
    pub fn looked_at(&self, context: &egui::Context) -> Option<usize> {
        let is_drawn = context.cumulative_pass_nr() <= self.drawn_in + 1;
        self.hovered.filter(|_| is_drawn)
    }

    /// Marks a sample in the traces that is pointed at elsewhere.
    pub fn point_at(&mut self, sample: usize, context: &egui::Context) {
        self.pointed = Some(sample);
        if self.hovered != Some(sample) {
            context.request_repaint();
        }
    }

    /// Shows these samples and little else.
    pub fn show_samples(&mut self, samples: std::ops::Range<usize>) {
        let Some(times) = self.on.as_ref().filter(|times| samples.end <= times.len()) else {
            return;
        };
        if let Some(last) = samples.end.checked_sub(1).filter(|last| *last > samples.start) {
            self.shown.time = Some((times[samples.start], times[last]));
        }
    }

    /// Forgets what was chosen for other recordings.
    pub(super) fn follow(&mut self, traces: &TraceSet) {
        let same = self.on.as_ref().is_some_and(|on| Arc::ptr_eq(on, &traces.times));
        if !same {
            self.on = Some(Arc::clone(&traces.times));
            self.fit();
            self.zooms = no_zooms();
            self.hovered = None;
            self.cursors.clear();
            self.playing.clear();
        }
    }

    /// Does what somebody asks for.
    pub fn apply(&mut self, time_move: TimeMove) {
        match time_move {
            TimeMove::Fit => self.fit(),
            TimeMove::Back => self.go_back(),
            TimeMove::Forward => self.go_forward(),
            TimeMove::Zoom(factor) => self.zoom_time(factor),
            TimeMove::Move(share) => self.move_time(share),
            TimeMove::TogglePlay => self.playing.toggle(),
            TimeMove::Step(samples) => self.step(samples),
            TimeMove::PutCursor(which) => self.put_cursor(which),
            TimeMove::ToggleTable => self.cursors.toggle_table(),
        }
    }

    /// Keeps what is shown, so that it can be gone back to.
    pub(super) fn keep_zoom(&mut self, time_secs: f64) {
        self.zooms.feed_state(time_secs, &self.shown);
    }

    /// Shows everything.
    pub(super) fn fit(&mut self) {
        self.shown = Shown::default();
    }

    /// Whether something else was shown before.
    pub fn can_go_back(&self) -> bool {
        self.zooms.has_undo(&self.shown)
    }

    /// Whether something else was shown after.
    pub fn can_go_forward(&self) -> bool {
        self.zooms.has_redo(&self.shown)
    }

    /// Shows what was shown before.
    fn go_back(&mut self) {
        if let Some(before) = self.zooms.undo(&self.shown) {
            self.shown = before.clone();
        }
    }

    /// Shows what was shown after.
    fn go_forward(&mut self) {
        if let Some(after) = self.zooms.redo(&self.shown) {
            self.shown = after.clone();
        }
    }

    /// The span between the cursors, counted from the first sample of a recording that is on screen (s).
    pub fn span_in(&self, recording: usize, traces: &TraceSet) -> Option<(f64, f64)> {
        let (a, b) = self.cursors.both()?;
        let mut segments = traces.segments.iter();
        let segment = segments.find(|segment| segment.recording == recording)?;
        let start = traces.times[segment.samples.start];
        let (from, to) = (a.min(b) - start, a.max(b) - start);
        (to >= 0.0).then_some((from.max(0.0), to))
    }

    /// Puts cursor A (0) or B (1) at the sample under the pointer, or where it plays.
    fn put_cursor(&mut self, which: usize) {
        let times = self.on.as_ref();
        let time = self.hovered.and_then(|k| times?.get(k).copied());
        if let Some(time) = time {
            self.cursors.put(which, time);
        }
    }

    /// All times, and the interval of them on screen.
    fn on_screen(&self) -> Option<(&[f64], (f64, f64))> {
        let times = self.on.as_deref()?;
        Some((times, self.shown.time.unwrap_or_else(|| all_of(times))))
    }

    /// Shows so many times as much of the time axis, about the sample shown or the middle.
    fn zoom_time(&mut self, factor: f64) {
        let Some((times, (from, to))) = self.on_screen() else {
            return;
        };
        let sample = self.hovered.and_then(|k| times.get(k).copied());
        let at = sample.filter(|at| (from..=to).contains(at));
        let at = at.unwrap_or(0.5 * (from + to));
        let zoomed = (at + (from - at) * factor, at + (to - at) * factor);
        self.shown.time = Some(within(times, zoomed));
    }

    /// Shows what lies earlier or later, in shares of what is on screen.
    fn move_time(&mut self, share: f64) {
        let Some((times, (from, to))) = self.on_screen() else {
            return;
        };
        let by = share * (to - from);
        self.shown.time = Some(within(times, (from + by, to + by)));
    }

    /// Goes one sample forward (1) or back (-1), or as many as fall on one pixel.
    fn step(&mut self, step: i8) {
        let Some((times, (from, to))) = self.on_screen() else {
            return;
        };
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

    /// Moves what is on screen where this time would not be.
    fn follow_time(&mut self, time: f64) {
        if let Some((from, to)) = self.shown.time
            && !(from..=to).contains(&time)
        {
            self.shown.time = Some(match time < from {
                true => (time - (to - from), time),
                false => (time, time + to - from),
            });
        }
    }

    pub(super) fn is_shown(&self, trace: Trace) -> bool {
        !self.hidden.contains(&trace)
    }

    /// Goes on playing; the sample that it is at. What is on screen follows.
    pub(super) fn play(&mut self, ui: &egui::Ui, traces: &TraceSet) -> Option<usize> {
        let start = traces.times.first().copied().unwrap_or(0.0);
        let on_screen = self.shown.time.map_or(start, |(from, _)| from.max(start));
        let from = self.cursors.first().unwrap_or(on_screen);
        let passed = ui.input(|input| f64::from(input.stable_dt));
        let (sample, time) = self.playing.go_on(passed, from, traces)?;
        if self.playing.is_running() {
            ui.ctx().request_repaint();
            self.follow_time(time);
        }
        Some(sample)
    }
}

/// From the first time to the last, with a margin.
pub fn all_of(times: &[f64]) -> (f64, f64) {
    let first = times.first().copied().unwrap_or(0.0);
    let last = times.last().copied().unwrap_or(first);
    let margin = if last > first { 0.01 * (last - first) } else { 0.5 };
    (first - margin, last + margin)
}

/// Keeps an interval of time on the recordings and wide enough to be drawn.
pub fn within(times: &[f64], (start, end): (f64, f64)) -> (f64, f64) {
    let first = times.first().copied().unwrap_or(0.0);
    let last = times.last().copied().unwrap_or(1.0);
    let all = (last - first).max(1e-3);
    let width = (end - start).clamp(1e-6 * all, 1.2 * all);
    let middle = (0.5 * (start + end)).clamp(first, last);
    (middle - 0.5 * width, middle + 0.5 * width)
}
