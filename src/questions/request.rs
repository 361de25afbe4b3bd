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
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// Settings of the fit.
    pub settings: FitSettings,
    /// Recordings whose traces are requested.
    pub view: View,
    /// Calibration to apply instead of fitting. `settings` then only gives the decimation.
    pub calibration: Option<Arc<Calibration>>,
    /// True if `calibration` was trained on these recordings, so that its own scores apply.
    pub trained: bool,
    /// Calibration of the sensor's manufacturer, whose matrix gives one more trace.
    pub factory: Option<Arc<Calibration>>,
    /// Cache that is shared with other questions about the same recordings.
    pub datasets: Datasets,
}

same_where!(Request: shared(recordings, calibration, factory) value(settings, view, trained) besides(datasets));

impl Request {
    /// Returns a request for the same fit, without the choices that only concern the display.
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

    /// Returns a request that fits `recordings` and shows the first one.
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
