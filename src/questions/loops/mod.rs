//! What the loop pane and the metrology pane draw: loops, cross-plots, dwells, the table of figures.
//!
//! A [`Viewer`] answers one [`Question`] at a time. Between questions it remembers only the loads that the calibration
//! gives, so that another axis, a zoom or another dead band costs a pass over what is drawn and nothing more.
//!
//! Guarantees: every number in an answer is finite; loops and cross-plots are drawn to the pixel, whatever the number of
//! samples; what the data cannot give is a sentence.

mod cross;
mod dwell;
mod figure;
mod picture;
pub(crate) mod shown;
mod source;

use std::sync::Arc;

use crate::calibration::{Calibration, CalibrationError};
use crate::progress::{Cancelled, Progress};
use crate::questions::errors::traces::TraceSet;
use crate::questions::metrology::{
    Metrology, MetrologyError, MetrologySettings, Reason, Run, table_by,
};
use crate::recording::{Axis, RecordingSet, Role};
use crate::scoring::loops::Frame;

use source::Source;

pub use cross::{Channel, CrossPlot, CrossQuestion, LoadKind};
pub(crate) use dwell::{DwellCurve, DwellPlot, DwellQuestion};
pub(crate) use figure::{FiguresOf, Inks, LoopView};
pub(crate) use picture::LoopPlot;
pub use picture::{LoopQuestion, Up};
pub(crate) use shown::{LoopMeasures, LoopScale, drifts, loop_figures};

/// More points than this of rising or of falling branches are drawn as their density, even where a larger picture could show them
/// as lines: those of both outputs are about as many as the traces of six axes have, and a frame costs no more than theirs.
const MAX_POINTS: usize = 8000;
/// What a picture leaves free around its points, as a share of its width and height.
const MARGIN: f64 = 0.04;

/// Conventional or compensated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Conv.
    Conventional,
    /// Comp.
    Compensated,
}

impl Output {
    /// Both, in this order everywhere.
    pub const ALL: [Self; 2] = [Self::Conventional, Self::Compensated];
}

/// Which samples are looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Span {
    /// What the trace panes show: their recordings, and the interval of time on screen.
    #[default]
    Visible,
    /// All of this recording.
    One(usize),
    /// All recordings that the table of figures is of.
    Of(TableOf),
    /// All recordings.
    All,
}

/// Which recordings the table of figures is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableOf {
    /// The test recordings.
    Test,
    /// The training recordings.
    Train,
    /// Those that nothing is fitted to: the test recordings, and those that are off.
    NotFitted,
    /// All.
    #[default]
    All,
}

impl TableOf {
    /// Whether recordings in this role are among them.
    pub fn includes(self, role: Role) -> bool {
        match self {
            Self::Test => role == Role::Test,
            Self::Train => role == Role::Train,
            Self::NotFitted => role != Role::Train,
            Self::All => true,
        }
    }

    /// What is measured where nobody says: the test recordings, else the training recordings, else all; of the built-in
    /// sensor also its bench recordings, which are off.
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

/// What is asked for the metrology pane.
#[derive(Clone, Debug, PartialEq)]
pub struct TableQuestion {
    /// Which recordings.
    pub of: TableOf,
}

/// What is to be looked at.
#[derive(Clone, Debug, PartialEq)]
pub enum Question {
    /// Loops of one axis.
    Loops(LoopQuestion),
    /// Any channel over any other.
    Cross(CrossQuestion),
    /// Where the load dwells.
    Dwells(DwellQuestion),
    /// The table of figures.
    Table(TableQuestion),
}

impl Question {
    /// Whether the answer depends on what the trace panes show.
    pub fn follows_screen(&self) -> bool {
        let span = match self {
            Self::Loops(question) => question.span,
            Self::Cross(question) => question.span,
            Self::Dwells(_) | Self::Table(_) => Span::All,
        };
        span == Span::Visible
    }
}

/// A question with what it is about.
#[derive(Clone, Debug)]
pub struct LookRequest {
    /// What gives the loads.
    pub calibration: Arc<Calibration>,
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// Every so many-th sample is used, as in the analysis.
    pub decimation: usize,
    /// What the trace panes draw.
    pub traces: Arc<TraceSet>,
    /// The interval of their time on screen; `None` for all of it.
    pub visible: Option<(f64, f64)>,
    /// Dead bands, what a dwell is: the same for all questions.
    pub measuring: MetrologySettings,
    /// The question.
    pub question: Question,
}

/// An answer.
#[derive(Clone, Debug)]
pub enum Look {
    /// Loops of one axis.
    Loops(LoopPlot),
    /// Any channel over any other.
    Cross(CrossPlot),
    /// Where the load dwells.
    Dwells(DwellPlot),
    /// The table of figures.
    Table(Arc<Metrology>),
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum LookError {
    #[error("no sample is chosen; choose a recording, or show more of the traces")]
    NoSamples,
    #[error("no recording has that role; give one a role, or choose all recordings")]
    NoRecordings,
    #[error("there is no channel of that name in these recordings; choose another")]
    NoChannel,
    #[error(
        "no recording holds its load still for {secs} s (every axis within 1 % of full scale, or ten times its noise); record one that does, or choose a shorter time"
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

/// Answers questions one after another, keeping the loads of the last calibration.
#[derive(Debug, Default)]
pub struct Viewer {
    source: Option<Source>,
}

impl Viewer {
    /// Answers one question.
    ///
    /// # Errors
    /// [`LookError`] where there is nothing to show; what was remembered stays good.
    pub fn look(&mut self, request: &LookRequest, progress: &Progress) -> Result<Look, LookError> {
        if !self.source.as_ref().is_some_and(|own| own.holds(request)) {
            // Taken away first: two sets of loads need not fit in memory at once.
            let before = self.source.take();
            let extents = before.and_then(|own| own.into_extents_of(request));
            self.source = Some(Source::of(request, extents));
        }
        let source = self.source.as_mut().expect("was just made");
        let answer = Self::answer(source, request, progress);
        source.forget_many();
        answer
    }

    fn answer(
        source: &mut Source,
        request: &LookRequest,
        progress: &Progress,
    ) -> Result<Look, LookError> {
        match &request.question {
            Question::Loops(question) => {
                let parts = source.parts(question.span, request, progress)?;
                picture::picture(source, &parts, question, &request.measuring, progress)
                    .map(Look::Loops)
            }
            Question::Cross(question) => {
                let parts = source.parts(question.span, request, progress)?;
                cross::picture(source, &parts, question, progress).map(Look::Cross)
            }
            Question::Dwells(question) => {
                source.parts(Span::All, request, progress)?;
                dwell::picture(source, question, &request.measuring).map(Look::Dwells)
            }
            Question::Table(question) => table_of(source, question, request, progress),
        }
    }
}

fn table_of(
    source: &mut Source,
    question: &TableQuestion,
    request: &LookRequest,
    progress: &Progress,
) -> Result<Look, LookError> {
    let entries = request.recordings.entries().iter().enumerate();
    let chosen: Vec<usize> = entries
        .filter(|(_, entry)| question.of.includes(entry.role))
        .map(|(at, _)| at)
        .collect();
    if chosen.is_empty() {
        return Err(LookError::NoRecordings);
    }
    source.apply(chosen.iter().copied(), progress)?;
    let runs: Vec<Run<'_>> = chosen.iter().filter_map(|at| source.run(*at)).collect();
    let figures = table_by(&runs, &source.rules(&request.measuring))?;
    Ok(Look::Table(Arc::new(figures)))
}

/// The place of an axis in the calibration, with its full scale.
fn column_of(calibration: &Calibration, axis: Axis) -> Result<(usize, f64), LookError> {
    let at = calibration.axes.iter().position(|own| *own == axis);
    let at = at.ok_or(Reason::NoReference { axis })?;
    let full_scale = calibration.full_scale.get(at).copied().unwrap_or(0.0);
    Ok((at, full_scale))
}

/// A frame around these ranges with a margin; never empty.
fn frame_around(loads: (f64, f64), outputs: (f64, f64)) -> Frame {
    let wider = |(low, high): (f64, f64)| {
        let margin = if high > low {
            MARGIN * (high - low)
        } else {
            0.1 * f64::max(high.abs(), 1e-3)
        };
        (low - margin, high + margin)
    };
    Frame {
        loads: wider(loads),
        outputs: wider(outputs),
    }
}

#[cfg(test)]
mod tests;
