//! Computes the loops, cross-plot, dwells or metrology table that a part of the window requests.

use std::sync::Arc;

use crate::{
    progress::Progress,
    questions::{
        loops::{
            cross::{self, CrossPlot, DwellPlot},
            picture::{self, LoopPlot},
            request::{
                LookError, LookRequest, LoopQuestion, Question, Span, TableOf, parts, rules, run,
                source_of,
            },
        },
        metrology::{Metrology, Run, table_by},
        question::{Answered, Query, Work},
    },
    report::Trace,
};

/// Plot or table that a [`Question`] requests.
#[derive(Debug)]
pub enum Look {
    /// Loops of one axis.
    Loops(LoopPlot),
    /// One channel plotted against another.
    Cross(CrossPlot),
    /// Dwells of the load, and the drift in one dwell.
    Dwells(DwellPlot),
    /// Metrology table.
    Table(Arc<Metrology>),
}

/// Computes the requested plot or table. The loads that it needs are kept for the next request about the same calibration.
///
/// # Errors
/// [`LookError`] if there is nothing to show. The kept loads stay valid after an error.
pub fn look(request: &LookRequest, progress: &Progress) -> Result<Look, LookError> {
    let source = || source_of(&request.loads);
    match &request.question {
        Question::Loops(question) => loops_of(request, question, progress).map(Look::Loops),
        Question::Cross(question) => {
            let source = &mut source();
            let parts = parts(source, question.span, request, progress)?;
            cross::cross_plot(source, &parts, question, progress).map(Look::Cross)
        }
        Question::Dwells(question) => {
            let source = &mut source();
            parts(source, Span::All, request, progress)?;
            cross::dwell_plot(source, question, &request.measuring).map(Look::Dwells)
        }
        Question::Table(of) => table_of(request, *of, progress).map(Look::Table),
    }
}

/// Computes loops of one axis, whatever the question of the request is.
pub(crate) fn loops_of(
    request: &LookRequest,
    question: &LoopQuestion,
    progress: &Progress,
) -> Result<LoopPlot, LookError> {
    let source = &mut source_of(&request.loads);
    let parts = parts(source, question.span, request, progress)?;
    picture::picture(source, parts, question, &request.measuring, progress)
}

/// Computes the metrology table of these recordings, whatever the question of the request is.
pub(crate) fn table_of(
    request: &LookRequest,
    of: TableOf,
    progress: &Progress,
) -> Result<Arc<Metrology>, LookError> {
    let source = &mut source_of(&request.loads);
    let entries = request.loads.recordings.entries().iter().enumerate();
    let chosen: Vec<usize> =
        entries.filter(|(_, entry)| of.includes(entry.role)).map(|(at, _)| at).collect();
    if chosen.is_empty() {
        return Err(LookError::NoRecordings);
    }
    source.apply::<LookError>(chosen.iter().copied(), progress)?;
    let runs: Vec<Run<'_>> = chosen.iter().map(|at| run(source, *at)).collect();
    let n_axes = source.calibration.axes.len();
    let outputs =
        Trace::OUTPUTS.into_iter().flat_map(|output| (0..n_axes).map(move |at| (at, output)));
    let mut lags = source.lags(&chosen, &outputs.collect::<Vec<_>>(), progress)?;
    let compensated = lags.split_off(n_axes);
    let lags = [lags, compensated];
    let figures = table_by(&runs, &rules(source, &request.measuring), lags)?;
    Ok(Arc::new(figures))
}

/// Request of one pane. Each pane asks as itself, so that the answers to different panes do not replace each other.
#[derive(Clone, Debug, PartialEq)]
pub struct LookAt(pub LookRequest);

impl Query for LookAt {
    type Answer = Look;
    type Cache = ();
    const ON_ANALYSIS: bool = true;

    fn title(&self) -> String {
        "Drawing loops".to_owned()
    }

    fn is_akin(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0.loads.recordings, &other.0.loads.recordings)
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        Ok(look(&self.0, work.progress)?)
    }
}
