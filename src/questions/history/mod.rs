//! Sizes of the files of a calibration, and the history rate of an exported calibration: the number of earlier samples per second that a controller stores. The lowest
//! rate that hardly increases the error of the fit is searched.

use std::fmt;
use std::sync::Arc;

use crate::{
    calibration::{Calibration, FitSettings, Regressor},
    export::{Footprint, file_sizes},
    progress::Progress,
    questions::{
        error::AnalysisError,
        models::training::train,
        question::{Answered, Query, Work},
        request::Request,
    },
    scoring::numbers::significant,
};

/// History rates to try, ascending (Hz).
const RATES_HZ: [f64; 9] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0];
/// Maximum error of a fit with a lower history rate, as a multiple of the error with all samples in the history.
const LARGEST_COST: f64 = 1.01;

/// History that stores fewer samples per second than the recordings have.
#[derive(Clone, Copy, Debug)]
pub struct CoarseHistory {
    pub rate_hz: f64,
    /// Memory on a controller (bytes): with this history, and with all samples.
    memory: [usize; 2],
    /// Mean error of the linear fit as a share of full scale: with this history, and with all samples.
    errors: [f64; 2],
}

impl fmt::Display for CoarseHistory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [coarse, whole] = self.memory.map(|bytes| bytes as f64 / 1000.0);
        let [error, all] = self.errors.map(|error| significant(100.0 * error, 3));
        write!(
            f,
            "with {} stored samples per second of history, a controller needs {coarse:.1} kB instead of {whole:.1} kB; the mean error of the \
             linear fit is then {error} % of full scale instead of {all} %",
            self.rate_hz
        )
    }
}

/// Returns the history with the lowest rate that increases the error of the fit by less than 1 %. Without such a rate, returns
/// the history with the highest rate that needs at most 64 kB on a controller.
///
/// Returns `None` if all samples fit into 64 kB, or if a history rate is set.
///
/// # Errors
/// [`AnalysisError`] if a fit fails.
pub fn coarse_history(
    request: &Request,
    progress: &Progress,
) -> Result<Option<CoarseHistory>, AnalysisError> {
    let settings = &request.settings;
    if settings.history_rate_hz != 0.0 || !settings.features.has_history() {
        return Ok(None);
    }
    // Only the linear regressor is fitted in this search: it has the same history as the other regressors, and is the
    // fastest.
    let fitted = |history_rate_hz| {
        let regressor = Regressor::Linear;
        let settings = FitSettings { history_rate_hz, regressor, ..settings.clone() };
        let request = Request::fit(Arc::clone(&request.recordings), settings);
        let trained = train(&request, progress, &mut |_| {})?;
        Ok::<_, AnalysisError>((error_of(&trained), Footprint::of(&trained)))
    };
    let (whole_error, whole) = fitted(0.0)?;
    if !whole.is_large() || !whole_error.is_finite() {
        return Ok(None);
    }
    let mut chosen = None;
    for rate_hz in RATES_HZ {
        let (error, footprint) = fitted(rate_hz)?;
        if footprint.is_large() {
            break;
        }
        chosen = Some(CoarseHistory {
            rate_hz,
            memory: [footprint.memory, whole.memory],
            errors: [error, whole_error],
        });
        if error < LARGEST_COST * whole_error {
            break;
        }
    }
    Ok(chosen)
}

/// Returns the mean error of all axes as a share of full scale: the cross-validation error, or if there is none, the training
/// error.
fn error_of(calibration: &Calibration) -> f64 {
    calibration.mean_cv_share().or(calibration.mean_train_share()).unwrap_or(f64::NAN)
}

/// Request for a lower history rate, for a calibration that needs too much memory on a controller.
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
