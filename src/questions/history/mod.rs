//! Sizes of the files of a calibration, and its history rate: the number of earlier samples per second that a controller stores.

use std::sync::Arc;

use crate::{
    calibration::Calibration,
    export::file_sizes,
    progress::Progress,
    questions::{
        dataset::fit::CoarseHistory,
        error::AnalysisError,
        question::{Answered, Query, Work},
        request::Request,
    },
};

/// Returns the history that a fit chooses; see [`Dataset::coarse_history`](crate::questions::dataset::Dataset::coarse_history).
///
/// # Errors
/// [`AnalysisError`] if a fit fails.
pub fn coarse_history(
    request: &Request,
    progress: &Progress,
) -> Result<Option<CoarseHistory>, AnalysisError> {
    let data = request.datasets.get(&request.key(), progress)?;
    data.coarse_history(&request.settings, progress)
}

/// Request for the history rate that a fit chooses.
#[derive(Clone, Debug, PartialEq)]
pub struct AskHistory(pub Request);

impl Query for AskHistory {
    type Answer = Option<CoarseHistory>;
    type Cache = ();

    fn title(&self) -> String {
        "History rate".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        Ok(coarse_history(&self.0, work.progress)?)
    }
}

/// Request for the sizes of the files of a calibration (bytes), in the order of [`TARGETS`](crate::export::TARGETS).
#[derive(Clone, Debug)]
pub struct AskFileSizes(pub Arc<Calibration>);

impl PartialEq for AskFileSizes {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Query for AskFileSizes {
    type Answer = Vec<Option<u64>>;
    type Cache = ();

    fn title(&self) -> String {
        "Sizes of files".to_owned()
    }

    fn compute(&self, _: Work<'_, Self>) -> Answered<Self> {
        Ok(file_sizes(&self.0, "calibration"))
    }
}
