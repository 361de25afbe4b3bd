//! The contents of the loop pane and the metrology pane, as a question.

use std::sync::Arc;

use crate::questions::loops::query::{Look, Viewer};
use crate::questions::loops::request::LookRequest;
use crate::questions::question::{Answered, Query, Work};

/// Loops, cross-plots, dwells, or the table of figures.
///
/// Two panes ask, each on its own lane: see [`AskLoops`] and [`AskFigures`].
#[derive(Clone, Debug, PartialEq)]
pub struct LookAt<const PANE: char>(pub LookRequest);

/// Question of the loop pane.
pub type AskLoops = LookAt<'l'>;
/// Question of the metrology pane.
pub type AskFigures = LookAt<'m'>;
/// Question of the verdict strip at the top of the window.
pub type AskVerdict = LookAt<'v'>;

impl<const PANE: char> Query for LookAt<PANE> {
    type Answer = Look;
    type Cache = Viewer;

    fn title(&self) -> String {
        "Drawing loops".to_owned()
    }

    fn is_akin(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0.loads.recordings, &other.0.loads.recordings)
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { cache: viewer, progress, .. } = work;
        Ok(viewer.look(&self.0, progress)?)
    }
}
