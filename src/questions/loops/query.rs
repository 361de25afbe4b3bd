//! One question about loops, cross-plots, dwells or the table of figures, and its answer.

use std::sync::Arc;

use crate::calibration::Calibration;
use crate::progress::Progress;
use crate::questions::errors::traces::TraceSet;
use crate::questions::loops::cross::{CrossPlot, CrossQuestion};
use crate::questions::loops::dwell::{DwellPlot, DwellQuestion};
use crate::questions::loops::error::LookError;
use crate::questions::loops::output::Span;
use crate::questions::loops::output::TableOf;
use crate::questions::loops::picture::{LoopPlot, LoopQuestion};
use crate::questions::loops::source::Source;
use crate::questions::loops::{cross, dwell, picture};
use crate::questions::metrology::{Metrology, MetrologySettings, Run, table_by};
use crate::recording::RecordingSet;
use crate::same::same_where;

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

same_where!(LookRequest:
    shared(calibration, recordings, traces)
    value(decimation, visible, measuring, question)
    besides()
);

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
            let mut before = self.source.take();
            // Taken away first: two sets of loads need not fit in memory at once.
            if let Some(before) = &mut before {
                before.forget_all();
            }
            self.source = Some(Source::of(request, before));
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

pub(crate) fn table_of(
    source: &mut Source,
    question: &TableQuestion,
    request: &LookRequest,
    progress: &Progress,
) -> Result<Look, LookError> {
    let entries = request.recordings.entries().iter().enumerate();
    let chosen: Vec<usize> =
        entries.filter(|(_, entry)| question.of.includes(entry.role)).map(|(at, _)| at).collect();
    if chosen.is_empty() {
        return Err(LookError::NoRecordings);
    }
    source.apply(chosen.iter().copied(), progress)?;
    let runs: Vec<Run<'_>> = chosen.iter().filter_map(|at| source.run(*at)).collect();
    let figures = table_by(&runs, &source.rules(&request.measuring))?;
    Ok(Look::Table(Arc::new(figures)))
}
