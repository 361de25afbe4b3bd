//! Requests for loops, cross-plots, dwells and the metrology table.

use crate::questions::errors::intervals::OnScreen;
use crate::questions::loops::output::{Span, TableOf};
use crate::questions::metrology::MetrologySettings;
use crate::recording::Axis;
use crate::report::Trace;
use crate::scoring::loops::Frame;

/// Quantity on the vertical axis of a loop plot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
