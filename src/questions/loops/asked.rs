//! What is shown of the loops, as a question.

use std::sync::Arc;

use crate::questions::loops::query::{Look, LookRequest, Viewer};
use crate::questions::question::{Answered, Query, Work};

/// Loops, cross-plots, dwells, the table of figures.
///
/// Each that asks has its own lane: see [`AskLoops`], [`AskFigures`] and [`AskVerdict`].
#[derive(Clone, Debug, PartialEq)]
pub struct LookAt<const PANE: char>(pub LookRequest);

/// What the loop pane asks.
pub type AskLoops = LookAt<'l'>;
/// What the metrology pane asks.
pub type AskFigures = LookAt<'m'>;
/// What the verdict at the top of the window asks.
pub type AskVerdict = LookAt<'v'>;

impl<const PANE: char> Query for LookAt<PANE> {
    type Answer = Look;
    type Cache = Viewer;

    fn title(&self) -> String {
        "Drawing loops".to_owned()
    }

    fn is_akin(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0.recordings, &other.0.recordings)
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { cache: viewer, progress, .. } = work;
        Ok(viewer.look(&self.0, progress)?)
    }
}
