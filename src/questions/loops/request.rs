//! Requests for loops, cross-plots, dwells and the metrology table, with the samples that they cover and the reasons why there is
//! nothing to show.

use crate::{
    calibration::{Calibration, CalibrationError},
    progress::{Cancelled, Progress},
    questions::{
        dataset::applied::{Part, Source},
        errors::intervals::OnScreen,
        metrology::{MetrologyError, MetrologySettings, Reason, Rules, Run},
        question::Unanswered,
    },
    recording::{Axis, RecordingSet, Role},
    report::Trace,
    scoring::loops::Frame,
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

/// Returns the loads of the calibration in all recordings.
pub fn source_of(loads: &OnScreen) -> Source {
    let OnScreen { recordings, decimation, calibration, datasets, .. } = loads;
    Source::new(datasets.applied(recordings, *decimation, calibration))
}

pub fn rules<'a>(source: &'a Source, measuring: &'a MetrologySettings) -> Rules<'a> {
    Rules {
        axes: &source.calibration.axes,
        full_scale: &source.calibration.full_scale,
        settings: measuring,
        extents: source.extents(),
    }
}

pub fn run(source: &Source, at: usize) -> Run<'_> {
    Run::new(&source.recordings[at], source.loads_of(at))
}

/// Returns the parts of recordings that `span` selects, and computes their loads.
pub fn parts(
    source: &mut Source,
    span: Span,
    request: &LookRequest,
    progress: &Progress,
) -> Result<Vec<Part>, LookError> {
    let whole = |recording: usize| Part { recording, samples: 0..usize::MAX };
    let wanted = match span {
        Span::All => (0..source.recordings.len()).map(whole).collect(),
        Span::One(recording) => vec![whole(recording)],
        Span::Of(of) => {
            let entries = source.set.entries().iter().enumerate();
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
        let n = source.recordings.get(part.recording)?.n_samples();
        let samples = part.samples.start.min(n)..part.samples.end.min(n);
        (!samples.is_empty()).then_some(Part { samples, ..part })
    });
    let parts: Vec<Part> = there.collect();
    if parts.is_empty() {
        return Err(LookError::NoSamples);
    }
    source.apply::<LookError>(parts.iter().map(|part| part.recording), progress)?;
    Ok(parts)
}
