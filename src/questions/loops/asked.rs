//! Questions of the panes that show loops and metrology figures.

use std::sync::Arc;

use crate::questions::loops::query::{Look, Viewer};
use crate::questions::loops::request::LookRequest;
use crate::questions::question::{Answered, Query, Work};

/// Question of one part of the window. Each part has its own type, so that the answers do not replace each other.
#[derive(Clone, Debug, PartialEq)]
pub struct LookAt<const PANE: char>(pub LookRequest);

/// Question of the loop pane.
pub type AskLoops = LookAt<'l'>;
/// Question of the metrology pane, if the verdict strip shows other recordings.
pub type AskFigures = LookAt<'m'>;
/// Question of the verdict strip at the top of the window. The metrology pane uses the answer if both show the same
/// recordings.
pub type AskVerdict = LookAt<'v'>;
/// Question of the plot of predicted against reference load, for the model on screen.
pub type AskPredicted = LookAt<'p'>;
/// Question of the plot of residual against reference load, for the model on screen.
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
