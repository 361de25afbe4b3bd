//! Question for the expected error.

use std::sync::Arc;

use crate::calibration::{Calibration, ExpectedError, FitSettings};
use crate::questions::dataset::Datasets;
use crate::questions::errors::query::Analysis;
use crate::questions::expected_error::query::expected_error;
use crate::questions::question::{Answered, Query, Work};
use crate::questions::request::Request;
use crate::recording::RecordingSet;
use crate::same::same_where;

/// Question for the expected error of the calibration on screen.
#[derive(Clone, Debug)]
pub struct AskExpectedError {
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// Settings of the fit.
    pub settings: FitSettings,
    /// The calibration.
    pub calibration: Arc<Calibration>,
    /// True if the calibration was fitted to these recordings.
    pub fitted: bool,
    /// Data that questions about the same recordings share.
    pub datasets: Datasets,
}

same_where!(AskExpectedError: shared(recordings, calibration) value(settings, fitted) besides(datasets));

impl AskExpectedError {
    /// Returns the question for an analysis that answers this request.
    pub fn of(request: &Request, analysis: &Analysis) -> Self {
        Self {
            recordings: Arc::clone(&request.recordings),
            settings: request.settings.clone(),
            calibration: Arc::clone(&analysis.calibration),
            fitted: analysis.fitted,
            datasets: request.datasets.clone(),
        }
    }
}

impl Query for AskExpectedError {
    type Answer = Result<ExpectedError, String>;
    type Cache = ();

    fn title(&self) -> String {
        "Expected error".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let request = Request {
            datasets: self.datasets.clone(),
            ..Request::fit(Arc::clone(&self.recordings), self.settings.clone())
        };
        Ok(expected_error(&request, &self.calibration, self.fitted, work.progress)?)
    }
}
