//! Data of a fit that do not depend on the thresholds of a look-back, prepared once for every request about thresholds.

use std::sync::Arc;

use crate::{
    calibration::{Calibration, FitSettings},
    features::Thresholds,
    finding::Finding,
    progress::{Cancelled, Progress},
    questions::{
        dataset::{Dataset, Key, Paths},
        error::AnalysisError,
        request::Request,
        thresholds::{measure::MeasureScale, past_ages::PastAges},
    },
    recording::Role,
    scoring::mean_hysteresis::{HysteresisRun, MeanHysteresis, mean_hysteresis},
};

/// Number of histogram bins for the ages of earlier samples up to t_th. Ages above t_th have as many bins.
const AGE_BINS: usize = 30;

/// Recordings and settings of a fit, prepared for studies of the look-back's thresholds.
#[derive(Debug)]
pub struct Study {
    pub(crate) data: Arc<Dataset>,
    pub(crate) paths: Paths,
    /// Calibration without coefficients: axes, full scales and gauge scales.
    pub(crate) blank: Calibration,
    pub(crate) settings: FitSettings,
}

impl Study {
    /// Fits the conventional calibration, and prepares the look-back's search for earlier samples.
    ///
    /// # Errors
    /// [`AnalysisError`] if the recordings cannot be fitted, or the work was cancelled.
    pub fn prepare(request: &Request, progress: &Progress) -> Result<Self, AnalysisError> {
        let settings = request.settings.clone();
        settings.validate()?;
        if request.recordings.entries().is_empty() {
            return Err(AnalysisError::NoRecordings);
        }
        if request.recordings.is_static() {
            return Err(AnalysisError::NoTimes);
        }
        let key = Key { calibration: None, ..request.key() };
        // The caller's progress does not count the steps of this preparation.
        let data = request.datasets.get(&key, &progress.part())?;
        let blank = data.blank_calibration(&settings)?;
        let paths = data.paths(&blank);
        progress.check()?;
        Ok(Self { data, paths, blank, settings })
    }

    /// Returns a finding if the recordings have a time lag that a look-back would describe as hysteresis.
    pub fn lag(&self, progress: &Progress) -> Result<Option<Finding>, Cancelled> {
        let mut features = self.settings.features.clone();
        features.look_backs = vec![Thresholds::default_for(features.distance)];
        Ok(self.data.lag_as_hysteresis(&features, progress)?.cloned())
    }

    /// Returns the axes whose errors are measured, with their full scales.
    pub fn scale(&self) -> MeasureScale {
        MeasureScale { axes: self.blank.axes.clone(), full_scale: self.blank.full_scale.clone() }
    }

    /// Returns the largest full scale of the axes whose loads are compared with the force threshold F_th, in the unit of
    /// F_th.
    pub fn largest_distance(&self) -> f64 {
        let weights = self.blank.distance_weights();
        let scaled = weights.iter().zip(&self.blank.full_scale);
        scaled.map(|(weight, full)| weight * full).fold(0.0, f64::max)
    }

    /// Returns the thresholds of the first look-back in the settings, or the default thresholds.
    pub fn present_thresholds(&self) -> Thresholds {
        let first = self.settings.features.look_backs.first();
        first.copied().unwrap_or_else(|| Thresholds::default_for(self.blank.features.distance))
    }

    /// Returns the ages of the earlier samples that a look-back with these thresholds finds in the training recordings.
    pub fn past_ages(&self, thresholds: Thresholds) -> PastAges {
        let unlimited = Thresholds { t_th_secs: f64::INFINITY, ..thresholds };
        let mut past_ages = PastAges::new(thresholds.t_th_secs, AGE_BINS);
        for (entry, path) in self.data.entries.iter().zip(&*self.paths) {
            if entry.role == Role::Train {
                let times = entry.recording.times();
                let past = path.past_samples(times, unlimited);
                past_ages.count(times, &past, thresholds.t_th_secs);
            }
        }
        past_ages
    }

    /// Returns the mean hysteresis of the training recordings.
    pub fn mean_hysteresis(&self) -> MeanHysteresis {
        let training = self.data.entries.iter().enumerate();
        let training: Vec<_> = training
            .filter(|(_, entry)| entry.role == Role::Train)
            .map(|(at, entry)| {
                let loads = self.data.present_loads(at);
                (entry.recording.loads(), move |axis| loads.column(axis))
            })
            .collect();
        let runs: Vec<HysteresisRun<'_>> = (training.iter())
            .map(|(reference, conventional)| HysteresisRun { reference, conventional })
            .collect();
        mean_hysteresis(&runs, &self.blank.axes, &self.blank.distance_weights())
    }
}
