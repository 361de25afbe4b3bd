//! Inputs that all requests for a result share: the recordings, and the settings of the fit.

use std::ops::Range;
use std::sync::Arc;

use crate::{
    calibration::{Calibration, FitSettings},
    questions::dataset::{Datasets, Key},
    recording::RecordingSet,
    same::same_where,
};

/// Inputs of an analysis: recordings, and either settings of a fit or a calibration to apply.
#[derive(Clone, Debug)]
pub struct Request {
    /// Recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// Settings of the fit.
    pub settings: FitSettings,
    /// Recordings whose loads are shown against time.
    pub view: View,
    /// Calibration that is applied to the recordings instead of a new fit; of `settings`, only the decimation is then used.
    /// `None` for a fit.
    pub calibration: Option<Arc<Calibration>>,
    /// True if `calibration` was fitted to these recordings, so that the errors stored with it are the errors on them.
    pub trained: bool,
    /// Calibration of the sensor's manufacturer, for comparison.
    pub factory: Option<Arc<Calibration>>,
    /// Cache of prepared recordings, which all requests about the same recordings share.
    pub datasets: Datasets,
}

same_where!(Request: shared(recordings, calibration, factory) value(settings, view, trained) besides(datasets));

impl Request {
    /// Returns the request to fit the same recordings with the same settings, without an applied calibration and without a
    /// choice of what is shown.
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

/// Recordings that the trace panes show.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum View {
    /// The recording with this index in the recording set.
    One(usize),
    /// All recordings, one after another.
    #[default]
    All,
}

impl View {
    /// Returns this view. If its recording does not exist, returns a view of the last recording.
    pub fn within(self, n_recordings: usize) -> Self {
        match self {
            Self::One(at) => Self::One(at.min(n_recordings.saturating_sub(1))),
            Self::All => Self::All,
        }
    }

    pub(crate) fn recordings(self, n_recordings: usize) -> Range<usize> {
        match self {
            Self::One(at) => at..(at + 1).min(n_recordings),
            Self::All => 0..n_recordings,
        }
    }
}
