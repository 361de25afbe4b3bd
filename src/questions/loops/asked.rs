//! Requests for loops and metrology figures, one type for each part of the window that shows them.

use std::sync::Arc;

use crate::questions::loops::query::{Look, Viewer};
use crate::questions::loops::request::LookRequest;
use crate::questions::question::{Answered, Query, Work};

/// Request of one part of the window. Each part has its own type, so that the results do not replace each other.
#[derive(Clone, Debug, PartialEq)]
pub struct LookAt<const PANE: char>(pub LookRequest);

/// Request for the contents of the loop pane.
pub type AskLoops = LookAt<'l'>;
/// Request for the table of the metrology pane.
pub type AskFigures = LookAt<'m'>;
/// Request for the plot of predicted against reference load, for the model on screen.
pub type AskPredicted = LookAt<'p'>;
/// Request for the plot of residual against reference load, for the model on screen.
pub type AskResidual = LookAt<'e'>;

impl<const PANE: char> Query for LookAt<PANE> {
    type Answer = Look;
    type Cache = Viewer;
    const ON_ANALYSIS: bool = true;

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
