//! A question: a pure function of what it carries, which is answered off the window's thread or on the command line.

use std::time::Duration;

use crate::progress::{Cancelled, Progress};
use crate::questions::error::AnalysisError;
use crate::questions::loops::LookError;

/// A run this young is allowed to finish when a newer question arrives, so that a slider on the move shows something.
pub const PATIENCE: Duration = Duration::from_millis(150);

/// Why a question has no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unanswered {
    /// Somebody asked to stop.
    Cancelled,
    /// In a sentence.
    Because(String),
}

impl From<Cancelled> for Unanswered {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Something that takes its time to find out or to do. Two questions that are equal have the same answer.
pub trait Query: Clone + PartialEq + Send + Sync + 'static {
    /// What comes of it.
    type Answer: Send + 'static;
    /// What the next question may find ready.
    type Cache: Default;

    /// How long one that has shown a part is allowed to go on when a newer question arrives, see [`PATIENCE`].
    const PATIENCE_ONCE_SHOWN: Duration = PATIENCE;

    /// Parts of an answer, but for the first, are told of no oftener than this: the window looks now and then while something runs.
    const PARTS_INTERVAL: Duration = Duration::from_secs(1);

    /// Set for work that the user begins and waits for: the status line shows it while it runs, and a notice that begins with this text
    /// says why it failed. Any other question is asked by a pane, which shows the reason itself.
    const BEGUN_BY_USER: Option<&'static str> = None;

    /// What people see while it runs.
    fn title(&self) -> String;

    /// Returns true if an answer to the other question may stay on screen until this one is answered.
    fn is_akin(&self, _other: &Self) -> bool {
        true
    }

    /// Finds the answer.
    ///
    /// # Errors
    /// [`Unanswered`] if there is none.
    fn compute(&self, work: Work<'_, Self>) -> Answered<Self>;
}

/// The answer to a question, or why there is none.
pub type Answered<Q> = Result<<Q as Query>::Answer, Unanswered>;

/// What a question is answered with.
pub struct Work<'a, Q: Query> {
    /// What the questions before have left.
    pub cache: &'a mut Q::Cache,
    /// How far it is.
    pub progress: &'a Progress,
    /// Takes what can be shown before the answer.
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
