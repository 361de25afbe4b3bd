//! Question for the contents of the loop pane and the metrology pane.

use std::sync::Arc;

use crate::questions::loops::query::{Look, Viewer};
use crate::questions::loops::request::LookRequest;
use crate::questions::question::{Answered, Query, Work};

/// Question for loops, cross-plots, dwells, or figures. Each part of the window has its own type, and so its own lane.
#[derive(Clone, Debug, PartialEq)]
pub struct LookAt<const PANE: char>(pub LookRequest);

/// Question of the loop pane.
pub type AskLoops = LookAt<'l'>;
/// Question of the metrology pane, if it shows other recordings than the verdict.
pub type AskFigures = LookAt<'m'>;
/// Question of the verdict strip at the top of the window, and of the metrology pane if it shows the same recordings.
pub type AskVerdict = LookAt<'v'>;
/// Question about predicted over reference load of the model on screen.
pub type AskPredicted = LookAt<'p'>;
/// Question about residual over load of the model on screen.
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
