//! Errors that end a computation on recordings, such as an analysis or a search for thresholds.

use crate::{
    calibration::{CalibrationError, NoCrossValidation},
    features::FeatureError,
    panicked::Panicked,
    progress::Cancelled,
    recording::Missing,
};

#[derive(Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the error text of each variant says what its fields are")]
pub enum AnalysisError {
    #[error(
        "the recordings have no times, so a look-back finds no earlier samples; record each load over time, with a time column t"
    )]
    NoTimes,
    #[error(transparent)]
    Missing(#[from] Missing),
    #[error("no recording is loaded; open a file or the built-in simulated sensor")]
    NoRecordings,
    #[error(
        "no recording is in the train role; give a recording the role Train, or open a calibration and apply it"
    )]
    NoTraining,
    #[error(
        "{recording}: sample {sample} has the value {value:e}, which is too large for the fit; remove the row from the file, or use a larger unit"
    )]
    TooLarge { recording: String, sample: usize, value: f64 },
    #[error("{given} full scales were entered for {axes} axes; enter one for each axis")]
    FullScales { given: usize, axes: usize },
    #[error(
        "{t_ths} values of the time threshold t_th for {columns} features and {parts} cross-validation parts would fill the memory; use fewer values of t_th or fewer \
         features"
    )]
    MapTooLarge { t_ths: usize, columns: usize, parts: usize },
    #[error(transparent)]
    NoCrossValidation(#[from] NoCrossValidation),
    #[error("the sensor has none of the axes whose error is to be minimised; choose another error")]
    NoSuchAxis,
    #[error("the map of errors is still empty; wait until its first row is computed")]
    EmptyMap,
    /// Reason that only one kind of question knows, such as a grid of thresholds that cannot be tried.
    #[error("{0}")]
    Because(String),
    #[error(transparent)]
    Calibration(CalibrationError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    Panicked(#[from] Panicked),
}

impl From<CalibrationError> for AnalysisError {
    fn from(error: CalibrationError) -> Self {
        match error {
            CalibrationError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            error => Self::Calibration(error),
        }
    }
}

impl From<FeatureError> for AnalysisError {
    fn from(error: FeatureError) -> Self {
        Self::Calibration(error.into())
    }
}
