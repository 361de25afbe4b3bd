//! Request behind most of the window: the fit, its errors, and its traces over time.

use std::sync::Arc;
use std::time::Duration;

use crate::questions::errors::query::{Analysis, Analyst};
use crate::questions::question::{Answered, Query, Work};
use crate::questions::request::Request;

/// Request to fit or apply a calibration, and to compute its errors and load traces in the background.
#[derive(Clone, Debug, PartialEq)]
pub struct Analyse(pub Request);

impl Query for Analyse {
    type Answer = Arc<Analysis>;
    type Cache = Analyst;
    const PATIENCE_ONCE_SHOWN: Duration = Duration::ZERO;

    fn title(&self) -> String {
        "Updating".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { cache: analyst, progress, show } = work;
        let show = |preview| show(Arc::new(preview));
        let analysis = analyst.analyse_showing(&self.0, progress, Some(&show))?;
        Ok(Arc::new(analysis))
    }
}
