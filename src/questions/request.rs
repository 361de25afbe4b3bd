//! What is asked about, for every question.

use std::sync::Arc;

use crate::calibration::{Calibration, FitSettings};
use crate::questions::dataset::Datasets;
use crate::questions::dataset::Key;
use crate::questions::errors::view::View;
use crate::recording::RecordingSet;
use crate::same::same_where;

/// What is to be analysed.
#[derive(Clone, Debug)]
pub struct Request {
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// The choices of the fit.
    pub settings: FitSettings,
    /// The recordings to make traces of.
    pub view: View,
    /// Where present, this is applied instead of fitting, and `settings` only gives the decimation.
    pub calibration: Option<Arc<Calibration>>,
    /// Whether that calibration was trained on these very recordings, so that its own scores stand.
    pub trained: bool,
    /// The calibration that the sensor came with: its conventional matrix gives one more trace, see [`read_factory`](crate::questions::errors::factory::read_factory).
    pub factory: Option<Arc<Calibration>>,
    /// What is shared with other questions about the same recordings.
    pub datasets: Datasets,
}

same_where!(Request: shared(recordings, calibration, factory) value(settings, view, trained) besides(datasets));

impl Request {
    /// The dataset that it needs.
    pub(crate) fn key(&self) -> Key {
        Key {
            recordings: Arc::clone(&self.recordings),
            offset: self.settings.offset,
            decimation: self.settings.decimation,
            calibration: self.calibration.clone(),
        }
    }

    /// Fits `recordings`, showing the first.
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
