//! Requests for loops, cross-plots, dwells and the metrology table.

use crate::questions::errors::intervals::OnScreen;
use crate::questions::loops::output::{Span, TableOf};
use crate::questions::metrology::MetrologySettings;
use crate::recording::Axis;
use crate::report::Trace;
use crate::scoring::loops::Frame;

/// Quantity on the vertical axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// Uncompensated and compensated load.
    Load,
    /// Errors of both loads.
    #[default]
    Error,
    /// A raw gauge channel.
    Gauge(usize),
}

/// Request for loops.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopQuestion {
    /// Axis whose reference load is on the horizontal axis.
    pub axis: Axis,
    /// Quantity on the vertical axis.
    pub up: Up,
    /// Samples to plot.
    pub span: Span,
    /// True to remove the time lag between gauges and reference before the loops are drawn.
    pub lag_removed: bool,
    /// Visible range of the plot; `None` shows all points.
    pub frame: Option<Frame>,
    /// Width and height of the plot in pixels, which set the resolution of the drawing.
    pub pixels: [f64; 2],
}

/// A channel with a value at every sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Time on the recording's own clock (s).
    Time,
    /// A raw gauge.
    Gauge(usize),
    /// Load of an axis, except for the load by the factory calibration.
    Load(Trace, Axis),
}

/// Request for a cross-plot of two channels.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossQuestion {
    /// Channel on the horizontal axis.
    pub across: Channel,
    /// Channel on the vertical axis.
    pub up: Channel,
    /// Samples to plot.
    pub span: Span,
    /// Visible range of the plot; `None` shows all points.
    pub frame: Option<Frame>,
    /// Width and height of the plot in pixels, which set the resolution of the drawing.
    pub pixels: [f64; 2],
}

#[derive(Clone, Debug, PartialEq)]
pub struct DwellQuestion {
    pub axis: Axis,
    /// Index of the dwell to draw, in the order of recordings and time. A larger index means the last dwell. `None` means the
    /// longest dwell under load; without a dwell under load, the longest dwell at zero.
    pub rest: Option<usize>,
    /// Visible range of the plot; `None` shows all points.
    pub frame: Option<Frame>,
    /// Width and height of the plot in pixels, which set the resolution of the drawing.
    pub pixels: [f64; 2],
}

/// Loops, cross-plot, dwells or metrology table that a pane shows.
#[derive(Clone, Debug, PartialEq)]
pub enum Question {
    /// Loops of one axis.
    Loops(LoopQuestion),
    /// One channel against another.
    Cross(CrossQuestion),
    /// Dwells of the load.
    Dwells(DwellQuestion),
    /// Metrology table of these recordings.
    Table(TableOf),
}

impl Question {
    /// Returns true if the answer depends on the interval that the trace panes show.
    pub fn follows_screen(&self) -> bool {
        let span = match self {
            Self::Loops(question) => question.span,
            Self::Cross(question) => question.span,
            Self::Dwells(_) | Self::Table(_) => Span::All,
        };
        span == Span::Visible
    }
}

/// A question, and the data from which the answer is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct LookRequest {
    /// Recordings, calibration and traces on screen.
    pub loads: OnScreen,
    /// Settings that define reversals and dwells.
    pub measuring: MetrologySettings,
    /// The question.
    pub question: Question,
}
