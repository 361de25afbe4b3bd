//! A question is a request for a result that takes time to compute, such as an analysis. The answer depends on nothing but
//! the question. The window computes answers in the background, the command line waits for them.

use std::time::Duration;

use crate::{
    progress::{Cancelled, Progress},
    questions::error::AnalysisError,
};

/// Age up to which a running computation may finish although a newer question of the same type has arrived. A moving slider
/// then still shows results.
pub const PATIENCE: Duration = Duration::from_millis(150);

#[derive(Debug, PartialEq)]
pub enum Unanswered {
    /// The user stopped the computation before it had an answer.
    Cancelled,
    Because(String),
}

impl From<Cancelled> for Unanswered {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// A request for a result that takes time to compute. Equal questions, if they can be compared, have equal answers.
pub trait Query: Clone + Send + Sync + 'static {
    type Answer: Send + 'static;
    /// Data that a question keeps, so that the next question of the same type is answered faster.
    type Cache: Default;

    /// Takes the place of [`PATIENCE`] for a computation that has already shown a partial answer.
    const PATIENCE_ONCE_SHOWN: Duration = PATIENCE;

    /// Shortest time between two partial answers on screen. The first partial answer is shown at once.
    const PARTS_INTERVAL: Duration = Duration::from_secs(1);

    /// First words of the notice that a computation failed, for computations that the user starts and the status line shows.
    /// `None` if a pane of the window shows the failure instead.
    const BEGUN_BY_USER: Option<&'static str> = None;

    /// True if the question is about the analysis on screen. The answer is removed when there is no analysis any more.
    const ON_ANALYSIS: bool = false;

    fn title(&self) -> String;

    /// Returns true if the answer to the earlier question `other` may stay on screen until this question is answered.
    fn is_akin(&self, _other: &Self) -> bool {
        true
    }

    /// Computes the answer, or returns the reason why there is none.
    fn compute(&self, work: Work<'_, Self>) -> Answered<Self>;
}

pub type Answered<Q> = Result<<Q as Query>::Answer, Unanswered>;

pub struct Work<'a, Q: Query> {
    /// Data that earlier requests of the same type have stored.
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
