//! Input that all questions share: recordings, and the settings of a fit.

use std::sync::Arc;

use crate::calibration::{Calibration, FitSettings};
use crate::questions::dataset::{Datasets, Key};
use crate::questions::errors::view::View;
use crate::recording::RecordingSet;
use crate::same::same_where;

/// Request for an analysis.
#[derive(Clone, Debug)]
pub struct Request {
    /// Recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// Settings of the fit.
    pub settings: FitSettings,
    /// Recordings whose traces are requested.
    pub view: View,
    /// Calibration that is applied instead of a fit. Of `settings`, only the decimation is then used.
    pub calibration: Option<Arc<Calibration>>,
    /// True if `calibration` was trained on these recordings, so that its own scores apply.
    pub trained: bool,
    /// Calibration of the sensor's manufacturer, for comparison.
    pub factory: Option<Arc<Calibration>>,
    /// Cache that questions about the same recordings share.
    pub datasets: Datasets,
}

same_where!(Request: shared(recordings, calibration, factory) value(settings, view, trained) besides(datasets));

impl Request {
    /// Returns a request for the fit alone, without an applied calibration and without display choices.
    pub(crate) fn plain(&self) -> Self {
        let fit = Self::fit(Arc::clone(&self.recordings), self.settings.clone());
        Self { datasets: self.datasets.clone(), ..fit }
    }

    pub(crate) fn key(&self) -> Key {
        Key {
            recordings: Arc::clone(&self.recordings),
            offset: self.settings.offset,
            decimation: self.settings.decimation,
            calibration: self.calibration.clone(),
        }
    }

    /// Returns a request that fits `recordings` and shows the first recording.
    pub fn fit(recordings: Arc<RecordingSet>, settings: FitSettings) -> Self {
        Self {
            recordings,
            settings,
            view: View::One(0),
            calibration: None,
            trained: false,
            factory: None,
            datasets: Datasets::default(),
        }
    }
}
