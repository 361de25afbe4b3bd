//! Sizes of the files of a calibration, and its history rate: the number of earlier samples per second that a controller stores.
//! The highest rate is searched whose history fits into the memory of small controllers.

use std::fmt;
use std::ops::RangeInclusive;
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
};

/// History rates to try, ascending (Hz).
const RATES_HZ: RangeInclusive<u16> = 1..=1000;
/// Maximum error of a fit with a lower history rate on each axis, as a multiple of the error with all samples in the history.
const LARGEST_COST: f64 = 1.02;

/// History that stores fewer samples per second than the recordings have.
#[derive(Clone, Copy, Debug)]
pub struct CoarseHistory {
    pub rate_hz: f64,
    /// Memory on a controller (bytes): with this history, and with all samples.
    memory: [usize; 2],
    /// Factor by which the error of the linear fit grows, on the axis on which it grows most.
    cost: f64,
}

impl fmt::Display for CoarseHistory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [coarse, whole] = self.memory.map(|bytes| bytes as f64 / 1000.0);
        write!(
            f,
            "with {} stored samples per second of history, a controller needs {coarse:.1} kB instead of {whole:.1} kB; this changes the error \
             of the linear fit by at most {:+.1} % on every axis",
            self.rate_hz,
            100.0 * (self.cost - 1.0)
        )
    }
}

/// Returns the history with the highest rate that needs at most 64 kB on a controller.
///
/// Returns `None` if all samples fit into 64 kB, if a history rate is set, or if the error of an axis grows by more than 2 %
/// with this rate. All samples are then stored.
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
    let at = |history_rate_hz| FitSettings {
        history_rate_hz,
        regressor: Regressor::Linear,
        ..settings.clone()
    };
    let data = request.datasets.get(&request.key(), progress)?;
    let footprint =
        |rate_hz| Ok::<_, AnalysisError>(Footprint::of(&data.blank_calibration(&at(rate_hz))?));
    let whole = footprint(0.0)?;
    let fits = |rate: &u16| footprint(f64::from(*rate)).is_ok_and(|found| !found.is_large());
    let n_fit = RATES_HZ.collect::<Vec<_>>().partition_point(fits);
    if !whole.is_large() || n_fit == 0 {
        return Ok(None);
    }
    let rate_hz = n_fit as f64;
    let errors = |rate_hz| {
        let request = Request { settings: at(rate_hz), ..request.plain() };
        Ok::<_, AnalysisError>(errors_of(&train(&request, progress, &mut |_| {})?))
    };
    let (coarse, all) = (errors(rate_hz)?, errors(0.0)?);
    let costs = coarse.iter().zip(&all).map(|(coarse, all)| coarse / all);
    let cost = costs.fold(f64::NEG_INFINITY, f64::max);
    let memory = [footprint(rate_hz)?.memory, whole.memory];
    Ok((cost <= LARGEST_COST).then_some(CoarseHistory { rate_hz, memory, cost }))
}

/// Returns the error of each axis: in cross-validation, or if there is none, on the training recordings.
fn errors_of(calibration: &Calibration) -> Vec<f64> {
    let scores = &calibration.quality.compensated;
    scores.cv_rmse.clone().or_else(|| scores.train_rmse.clone()).unwrap_or_default()
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
