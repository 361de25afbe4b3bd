//! Request for the expected error, which is computed in the background.

use std::sync::Arc;

use crate::calibration::{Calibration, ExpectedError};
use crate::questions::errors::query::Analysis;
use crate::questions::expected_error::query::expected_error;
use crate::questions::question::{Answered, Query, Work};
use crate::questions::request::Request;
use crate::same::same_where;

/// Request for the expected error of the calibration on screen.
#[derive(Clone, Debug)]
pub struct AskExpectedError {
    request: Request,
    pub calibration: Arc<Calibration>,
    /// True if the calibration was fitted to the recordings of the request.
    fitted: bool,
}

same_where!(AskExpectedError: shared(calibration) value(request, fitted) besides());

impl AskExpectedError {
    /// Returns the request for the expected error of an analysed calibration; `analysis` must be the answer to `request`.
    pub fn of(request: &Request, analysis: &Analysis) -> Self {
        let calibration = Arc::clone(&analysis.calibration);
        Self { request: request.plain(), calibration, fitted: analysis.fitted }
    }
}

impl Query for AskExpectedError {
    type Answer = Result<ExpectedError, String>;
    type Cache = ();

    fn title(&self) -> String {
        "Expected error".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        Ok(expected_error(&self.request, &self.calibration, self.fitted, work.progress)?)
    }
}
