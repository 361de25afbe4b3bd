//! Questions: pure functions of their inputs, answered in the background of the window or on the command line.

use std::time::Duration;

use crate::progress::{Cancelled, Progress};
use crate::questions::error::AnalysisError;
use crate::questions::loops::LookError;

/// Age up to which a run may continue after a newer question arrives, so that a moving slider shows results.
pub const PATIENCE: Duration = Duration::from_millis(150);

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unanswered {
    /// The user stopped the work.
    Cancelled,
    Because(String),
}

impl From<Cancelled> for Unanswered {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// A question whose answer takes time to compute. Equal questions have equal answers.
pub trait Query: Clone + PartialEq + Send + Sync + 'static {
    type Answer: Send + 'static;
    /// Data that are kept for the next question.
    type Cache: Default;

    /// Age up to which a run that has shown a partial answer may continue after a newer question arrives; see [`PATIENCE`].
    const PATIENCE_ONCE_SHOWN: Duration = PATIENCE;

    /// Shortest interval between partial answers after the first.
    const PARTS_INTERVAL: Duration = Duration::from_secs(1);

    /// Name of work that the user starts and waits for. The status line shows the work, and a notice with this name reports a
    /// failure. `None` for questions of a pane, which shows the reason itself.
    const BEGUN_BY_USER: Option<&'static str> = None;

    /// True if the question is about the newest analysis. The answer is then removed when there is no analysis any more.
    const ON_ANALYSIS: bool = false;

    fn title(&self) -> String;

    /// Returns true if an answer to the other question may stay on screen until this one is answered.
    fn is_akin(&self, _other: &Self) -> bool {
        true
    }

    /// Computes the answer, or returns the reason why there is none.
    fn compute(&self, work: Work<'_, Self>) -> Answered<Self>;
}

pub type Answered<Q> = Result<<Q as Query>::Answer, Unanswered>;

pub struct Work<'a, Q: Query> {
    /// Data that earlier questions have left.
    pub cache: &'a mut Q::Cache,
    pub progress: &'a Progress,
    pub show: &'a (dyn Fn(Q::Answer) + Sync),
}

impl From<AnalysisError> for Unanswered {
    fn from(error: AnalysisError) -> Self {
        match error {
            AnalysisError::Cancelled(_) => Self::Cancelled,
            error => Self::Because(error.to_string()),
        }
    }
}

impl From<LookError> for Unanswered {
    fn from(error: LookError) -> Self {
        match error {
            LookError::Cancelled(_) => Self::Cancelled,
            error => Self::Because(error.to_string()),
        }
    }
}
