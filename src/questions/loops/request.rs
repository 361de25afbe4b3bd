//! Requests about loops, cross-plots, dwells and the table of figures.

use crate::questions::errors::intervals::OnScreen;
use crate::questions::loops::output::{Output, Span, TableOf};
use crate::questions::metrology::MetrologySettings;
use crate::recording::Axis;
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
    /// True to remove the time lag between gauges and reference first.
    pub lag_removed: bool,
    /// Visible range; `None` shows everything.
    pub frame: Option<Frame>,
    /// Width and height of the plot in pixels, which set the resolution of the drawing.
    pub pixels: [f64; 2],
}

/// A reference or computed load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadKind {
    /// Reference load.
    Calculated,
    /// Uncompensated or compensated load.
    Output(Output),
}

/// A channel with a value at every sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Time on the recording's own clock (s).
    Time,
    /// A raw gauge.
    Gauge(usize),
    /// A load of an axis.
    Load(LoadKind, Axis),
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
    /// Visible range; `None` shows everything.
    pub frame: Option<Frame>,
    /// Width and height of the plot in pixels, which set the resolution of the drawing.
    pub pixels: [f64; 2],
}

#[derive(Clone, Debug, PartialEq)]
pub struct DwellQuestion {
    pub axis: Axis,
    /// Index of the dwell, in the order of recordings and time; a larger index means the last dwell. `None` takes the longest
    /// dwell under load, or else the longest.
    pub rest: Option<usize>,
    /// Visible range; `None` shows everything.
    pub frame: Option<Frame>,
    /// Width and height of the plot in pixels, which set the resolution of the drawing.
    pub pixels: [f64; 2],
}

/// Request for the table of figures.
#[derive(Clone, Debug, PartialEq)]
pub struct TableQuestion {
    /// Recordings that the table covers.
    pub of: TableOf,
}

/// Requested view.
#[derive(Clone, Debug, PartialEq)]
pub enum Question {
    /// Loops of one axis.
    Loops(LoopQuestion),
    /// Any channel over any other.
    Cross(CrossQuestion),
    /// Dwells of the load.
    Dwells(DwellQuestion),
    /// Table of figures.
    Table(TableQuestion),
}

impl Question {
    /// Returns true if the answer depends on the view of the trace panes.
    pub fn follows_screen(&self) -> bool {
        let span = match self {
            Self::Loops(question) => question.span,
            Self::Cross(question) => question.span,
            Self::Dwells(_) | Self::Table(_) => Span::All,
        };
        span == Span::Visible
    }
}

/// A question with its inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct LookRequest {
    /// Loads on screen.
    pub loads: OnScreen,
    /// Settings of reversals and dwells, the same for all questions.
    pub measuring: MetrologySettings,
    /// The question.
    pub question: Question,
}
