//! Requests for loops, cross-plots, dwells and the metrology table, with the samples that they cover and the reasons why there is
//! nothing to show.
//!
//! Data of the plots: the recordings of the analysis, with the loads that the calibration computes.

use std::ops::Range;
use std::sync::Arc;

use crate::{
    calibration::{Calibration, CalibrationError},
    column::column,
    progress::{Cancelled, Progress},
    questions::{
        dataset::applied::{Applied, OutputLag, UsedLoads, rows_of},
        errors::intervals::OnScreen,
        metrology::{Lags, MetrologyError, MetrologySettings, Reason, Rules, Run},
        question::Unanswered,
    },
    recording::{Axis, Recording, RecordingSet, Role},
    report::Trace,
    scoring::{lag::InTime, loops::Frame},
};

/// Quantity on the vertical axis of a loop plot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Up {
    /// Uncompensated and compensated load.
    Load,
    /// Errors of the uncompensated and of the compensated load.
    #[default]
    Error,
    /// A raw gauge channel.
    Gauge(usize),
}

/// Request for the loops of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopQuestion {
    /// Axis whose reference load is on the horizontal axis.
    pub axis: Axis,
    /// Quantity on the vertical axis of a loop plot.
    pub up: Up,
    /// Choice of the samples to plot.
    pub span: Span,
    /// True to remove the time lag between gauges and reference before the loops are drawn.
    pub lag_removed: bool,
    /// Visible range of the plot after zooming; `None` shows all points.
    pub frame: Option<Frame>,
    /// Width and height of the plot in pixels, which set the resolution of the drawing.
    pub pixels: [f64; 2],
}

/// Quantity with a value at every sample, which a cross-plot can show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Channel {
    /// Time on the recording's own clock (s).
    Time,
    /// A raw gauge channel, by its index.
    Gauge(usize),
    /// Reference, uncompensated or compensated load of an axis. The load by the factory calibration is not available.
    Load(Trace, Axis),
}

/// Request for a cross-plot of two channels.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossQuestion {
    /// Channel on the horizontal axis.
    pub across: Channel,
    /// Channel on the vertical axis.
    pub up: Channel,
    /// Choice of the samples to plot.
    pub span: Span,
    /// Visible range of the plot after zooming; `None` shows all points.
    pub frame: Option<Frame>,
    /// Width and height of the plot in pixels, which set the resolution of the drawing.
    pub pixels: [f64; 2],
}

#[derive(Clone, Debug, PartialEq)]
pub struct DwellQuestion {
    pub axis: Axis,
    /// Index of the dwell to draw, in the order of recordings and time. An index beyond the last dwell means the last dwell.
    /// `None` means the longest dwell under load; without a dwell under load, the longest dwell at zero.
    pub rest: Option<usize>,
    /// Visible range of the plot after zooming; `None` shows all points.
    pub frame: Option<Frame>,
    /// Width and height of the plot in pixels, which set the resolution of the drawing.
    pub pixels: [f64; 2],
}

/// Plot or table that a pane requests.
#[derive(Clone, Debug, PartialEq)]
pub enum Question {
    /// Loops of one axis.
    Loops(LoopQuestion),
    /// One channel plotted against another.
    Cross(CrossQuestion),
    /// Dwells of the load.
    Dwells(DwellQuestion),
    /// Metrology table of the chosen recordings.
    Table(TableOf),
}

impl Question {
    /// Returns true if the plot changes with the interval that the trace panes show.
    pub fn follows_screen(&self) -> bool {
        let span = match self {
            Self::Loops(question) => question.span,
            Self::Cross(question) => question.span,
            Self::Dwells(_) | Self::Table(_) => Span::All,
        };
        span == Span::Visible
    }
}

/// Request for a plot or table, and the data from which it is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct LookRequest {
    /// Recordings, calibration and traces on screen.
    pub loads: OnScreen,
    /// Settings that define reversals of the load and dwells.
    pub measuring: MetrologySettings,
    /// Plot or table that is requested.
    pub question: Question,
}

#[derive(Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the error text of each variant says what its fields are")]
pub enum LookError {
    #[error("no samples to plot; choose a recording, or show a longer interval in Traces")]
    NoSamples,
    #[error(
        "no recording has the chosen role; assign this role to a recording, or choose all recordings"
    )]
    NoRecordings,
    #[error("the chosen recordings do not have this channel; choose another channel")]
    NoChannel,
    #[error(
        "no recording has a dwell of {secs} s or longer, in which every axis stays within its stability tolerance; record a dwell, or choose a shorter dwell"
    )]
    NoDwell { secs: f64 },
    #[error(transparent)]
    Reason(#[from] Reason),
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    #[error(transparent)]
    Metrology(#[from] MetrologyError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<LookError> for Unanswered {
    fn from(error: LookError) -> Self {
        match error {
            LookError::Cancelled(_) => Self::Cancelled,
            error => Self::Because(error.to_string()),
        }
    }
}

/// Choice of the samples to plot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Span {
    /// Samples that the trace panes show at present.
    #[default]
    Visible,
    /// All samples of the recording with this index in the recording set.
    One(usize),
    /// All samples of the recordings that the metrology table covers.
    Of(TableOf),
    /// All recordings.
    All,
}

/// Returns the position of an axis in the calibration, and the full scale of the axis.
pub fn column_of(calibration: &Calibration, axis: Axis) -> Result<(usize, f64), LookError> {
    let at = calibration.axes.iter().position(|known| *known == axis);
    let at = at.ok_or(Reason::NoReference { axis })?;
    Ok((at, calibration.full_scale[at]))
}

/// Choice of the recordings that the metrology table covers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum TableOf {
    /// Test recordings.
    Test,
    /// Training recordings.
    Train,
    /// Recordings that the fit does not use: those with the role Test or Off.
    NotFitted,
    /// All recordings.
    #[default]
    All,
}

impl TableOf {
    /// Returns true if the metrology table covers recordings with this role.
    pub fn includes(self, role: Role) -> bool {
        match self {
            Self::Test => role == Role::Test,
            Self::Train => role == Role::Train,
            Self::NotFitted => role != Role::Train,
            Self::All => true,
        }
    }

    /// Returns the default choice: the test recordings, else the training recordings, else all recordings. For the built-in
    /// simulated sensor, the default includes its bench recordings, although their role is off.
    pub fn usual(set: &RecordingSet) -> Self {
        let has = |role| set.entries().iter().any(|entry| entry.role == role);
        match () {
            () if set.is_simulated() && has(Role::Test) => Self::NotFitted,
            () if has(Role::Test) => Self::Test,
            () if has(Role::Train) => Self::Train,
            () => Self::All,
        }
    }
}

/// Part of one recording: its index, and a range of its samples.
#[derive(Clone, Debug)]
pub struct Part {
    pub recording: usize,
    pub samples: Range<usize>,
}

/// Recordings of the analysis, with the loads that one request uses.
pub struct Source {
    set: Arc<RecordingSet>,
    applied: Arc<Applied>,
    used: UsedLoads,
}

impl Source {
    pub(crate) fn of(loads: &OnScreen) -> Self {
        let OnScreen { recordings, decimation, calibration, datasets, .. } = loads;
        let applied = datasets.applied(recordings, *decimation, calibration);
        Self { set: Arc::clone(recordings), applied, used: UsedLoads::new() }
    }

    pub(crate) fn calibration(&self) -> &Calibration {
        &self.applied.calibration
    }

    pub(crate) fn recordings(&self) -> &[Arc<Recording>] {
        &self.applied.recordings
    }

    /// Returns the time lag of an output behind its reference.
    pub(crate) fn lag(
        &mut self,
        column: usize,
        output: Trace,
        reversal_threshold: f64,
        progress: &Progress,
    ) -> Result<OutputLag, LookError> {
        let Self { applied, used, .. } = self;
        applied.output_lag((column, output), reversal_threshold, used, progress)
    }

    /// Returns the time lags of the uncompensated and the compensated load on each axis, measured in these recordings.
    pub(crate) fn lags(
        &self,
        recordings: &[usize],
        progress: &Progress,
    ) -> Result<Lags, Cancelled> {
        let n_axes = self.calibration().axes.len();
        let outputs =
            Trace::OUTPUTS.into_iter().flat_map(|output| (0..n_axes).map(move |at| (at, output)));
        let outputs: Vec<_> = outputs.collect();
        let mut lags = self.applied.lags(recordings, &outputs, &self.used, progress)?;
        let compensated = lags.split_off(n_axes);
        Ok([lags, compensated])
    }

    pub(crate) fn rules<'a>(&'a self, measuring: &'a MetrologySettings) -> Rules<'a> {
        Rules {
            axes: &self.calibration().axes,
            full_scale: &self.calibration().full_scale,
            settings: measuring,
            extents: self.applied.extents(),
        }
    }

    /// Returns the parts of recordings that `span` selects, and computes their loads.
    pub(crate) fn parts(
        &mut self,
        span: Span,
        request: &LookRequest,
        progress: &Progress,
    ) -> Result<Vec<Part>, LookError> {
        let whole = |recording: usize| Part { recording, samples: 0..usize::MAX };
        let wanted = match span {
            Span::All => (0..self.recordings().len()).map(whole).collect(),
            Span::One(recording) => vec![whole(recording)],
            Span::Of(of) => {
                let entries = self.set.entries().iter().enumerate();
                let chosen = entries.filter(|(_, entry)| of.includes(entry.role));
                chosen.map(|(at, _)| whole(at)).collect()
            }
            Span::Visible => {
                let shown = request.loads.traces.on_screen(request.loads.visible).into_iter();
                let parts = shown.map(|(recording, samples)| Part { recording, samples });
                parts.collect()
            }
        };
        let there = wanted.into_iter().filter_map(|part| {
            let n = self.recordings().get(part.recording)?.n_samples();
            let samples = part.samples.start.min(n)..part.samples.end.min(n);
            (!samples.is_empty()).then_some(Part { samples, ..part })
        });
        let parts: Vec<Part> = there.collect();
        if parts.is_empty() {
            return Err(LookError::NoSamples);
        }
        self.apply(parts.iter().map(|part| part.recording), progress)?;
        Ok(parts)
    }

    pub(crate) fn apply(
        &mut self,
        recordings: impl Iterator<Item = usize>,
        progress: &Progress,
    ) -> Result<(), LookError> {
        self.applied.apply(recordings, &mut self.used, progress)
    }

    pub(crate) fn run(&self, at: usize) -> Run<'_> {
        let applied = self.used[at].as_ref();
        let applied = applied.expect("the loads of a recording are computed before its plot");
        Run::new(&self.recordings()[at], applied)
    }

    /// Returns the reference load of an axis; `None` if the recording has no reference load for this axis.
    pub(crate) fn loads(&self, part: &Part, axis: Axis) -> Option<Vec<f64>> {
        let loads = self.recordings()[part.recording].load(axis)?;
        Some(loads.skip(part.samples.start).take(part.samples.len()).collect())
    }

    /// Returns the reference load of an axis, delayed by the time lag of an output; `None` if the recording has no reference
    /// load.
    pub(crate) fn late_loads(&self, part: &Part, axis: Axis, lag: &InTime) -> Option<Vec<f64>> {
        let whole = Part { samples: 0..usize::MAX, ..part.clone() };
        let loads = self.loads(&whole, axis)?;
        let late = lag.reference(self.recordings()[part.recording].times(), &loads);
        Some(late[part.samples.clone()].to_vec())
    }

    /// Returns the values of a gauge channel; `None` if there is no gauge with this index.
    pub(crate) fn gauge(&self, part: &Part, gauge: usize) -> Option<Vec<f64>> {
        let recording = &self.recordings()[part.recording];
        let width = recording.n_gauges();
        (gauge < width).then(|| part_of(recording.gauges(), width, gauge, &part.samples))
    }

    pub(crate) fn output(&self, part: &Part, at: usize, output: Trace) -> Vec<f64> {
        let rows = rows_of(&self.used, part.recording, output);
        part_of(rows, self.calibration().axes.len(), at, &part.samples)
    }

    /// Returns a load (`output`) after its gains are fitted again to the delayed reference load.
    pub(crate) fn refitted(&self, part: &Part, output: Trace, lag: &InTime) -> Vec<f64> {
        let rows = rows_of(&self.used, part.recording, output);
        let width = self.calibration().axes.len();
        let rows = &rows[part.samples.start * width..part.samples.end * width];
        (0..part.samples.len()).map(|k| lag.output(rows, k)).collect()
    }
}

fn part_of(rows: &[f64], width: usize, at: usize, samples: &Range<usize>) -> Vec<f64> {
    let rows = &rows[(samples.start * width).min(rows.len())..];
    column(rows, width, at).take(samples.len()).collect()
}

impl Drop for Source {
    fn drop(&mut self) {
        self.applied.forget_many();
    }
}
