//! Request for a plot or a table of metrology figures, which is computed in the background.

use std::sync::Arc;

use crate::questions::loops::query::{Look, look};
use crate::questions::loops::request::LookRequest;
use crate::questions::question::{Answered, Query, Work};

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
