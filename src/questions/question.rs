//! Questions are pure functions of their inputs. The window answers them in the background, the command line waits for the
//! answer.

use std::time::Duration;

use crate::progress::{Cancelled, Progress};
use crate::questions::error::AnalysisError;
use crate::questions::loops::LookError;

/// Maximum age of a computation that continues after a newer question has arrived, so that a moving slider shows results.
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
    /// Data that a question keeps for the next question of its kind.
    type Cache: Default;

    /// Value of [`PATIENCE`] for a computation that has shown a partial answer.
    const PATIENCE_ONCE_SHOWN: Duration = PATIENCE;

    /// Shortest interval between partial answers after the first.
    const PARTS_INTERVAL: Duration = Duration::from_secs(1);

    /// First words of the notice about a failure, for work that the user starts. The status line shows this work. `None` if a
    /// pane shows the failure.
    const BEGUN_BY_USER: Option<&'static str> = None;

    /// True if the question is about the newest analysis. The answer is then removed when there is no analysis any more.
    const ON_ANALYSIS: bool = false;

    fn title(&self) -> String;

    /// Returns true if the answer to `other` may stay on screen until this question is answered.
    fn is_akin(&self, _other: &Self) -> bool {
        true
    }

    /// Computes the answer, or returns the reason why there is none.
    fn compute(&self, work: Work<'_, Self>) -> Answered<Self>;
}

pub type Answered<Q> = Result<<Q as Query>::Answer, Unanswered>;

pub struct Work<'a, Q: Query> {
    /// Data that earlier questions of this kind have kept.
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
