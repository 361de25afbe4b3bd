//! Chooses the history rate before a fit: the number of earlier samples per second that a controller stores.
//!
//! Guarantees: the rate depends only on the recordings and the settings, so every fit of a calibration chooses the same rate.

use std::fmt;
use std::ops::RangeInclusive;

use crate::{
    calibration::{Calibration, FitSettings},
    export::Footprint,
    panicked::locked,
    progress::Progress,
    questions::{dataset::Dataset, error::AnalysisError},
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

/// Maximum number of choices that a dataset keeps.
const KEPT: usize = 64;

impl Dataset {
    /// Returns the calibration before the fit, with the history rate of the settings or the one that is chosen for them.
    pub fn unfitted(
        &self,
        settings: &FitSettings,
        progress: &Progress,
    ) -> Result<Calibration, AnalysisError> {
        let coarse = self.coarse_history(settings, progress)?;
        let chosen = coarse.map(|coarse| coarse.rate_hz).or(settings.history_rate_hz);
        self.blank_calibration(&FitSettings { history_rate_hz: chosen, ..settings.clone() })
    }

    /// Returns the history with the highest rate that needs at most 64 kB on a controller.
    ///
    /// Returns `None` if all samples fit into 64 kB, if a history rate is set, or if the error of an axis grows by more than 2 %
    /// with this rate. All samples are then stored.
    pub fn coarse_history(
        &self,
        settings: &FitSettings,
        progress: &Progress,
    ) -> Result<Option<CoarseHistory>, AnalysisError> {
        if settings.history_rate_hz.is_some() || !settings.features.has_history() {
            return Ok(None);
        }
        // Only the linear fit is compared: it has the same history as the other regressors, and is the fastest.
        let key = FitSettings {
            features: settings.features.clone(),
            ridge: settings.ridge,
            offset: settings.offset,
            decimation: settings.decimation,
            full_scale: settings.full_scale.clone(),
            auxiliary_references: settings.auxiliary_references.clone(),
            ..FitSettings::default()
        };
        let known = locked(&self.derived.histories);
        if let Some((_, known)) = known.iter().find(|(known, _)| *known == key) {
            return Ok(*known);
        }
        drop(known);
        let found = self.searched_history(&key, &progress.part())?;
        let mut known = locked(&self.derived.histories);
        known.insert(0, (key, found));
        known.truncate(KEPT);
        Ok(found)
    }

    fn searched_history(
        &self,
        settings: &FitSettings,
        progress: &Progress,
    ) -> Result<Option<CoarseHistory>, AnalysisError> {
        let blank = |rate_hz| {
            self.blank_calibration(&FitSettings {
                history_rate_hz: Some(rate_hz),
                ..settings.clone()
            })
        };
        let whole = Footprint::of(&blank(0.0)?);
        if !whole.is_large() {
            return Ok(None);
        }
        let fits = |rate: &u16| {
            blank(f64::from(*rate)).is_ok_and(|found| !Footprint::of(&found).is_large())
        };
        let rate_hz = RATES_HZ.collect::<Vec<_>>().partition_point(fits) as f64;
        if rate_hz == 0.0 {
            return Ok(None);
        }
        let errors = |rate_hz| {
            let mut calibration = blank(rate_hz)?;
            let past = self.past(&calibration, progress)?;
            self.fit(settings.ridge, &past, &mut calibration, progress)?;
            Ok::<_, AnalysisError>(errors_of(&calibration))
        };
        let (coarse, all) = (errors(rate_hz)?, errors(0.0)?);
        let costs = coarse.iter().zip(&all).map(|(coarse, all)| coarse / all);
        let cost = costs.fold(f64::NEG_INFINITY, f64::max);
        let memory = [Footprint::of(&blank(rate_hz)?).memory, whole.memory];
        Ok((cost <= LARGEST_COST).then_some(CoarseHistory { rate_hz, memory, cost }))
    }
}

/// Returns the error of each axis: in cross-validation, or if there is none, on the training recordings.
fn errors_of(calibration: &Calibration) -> Vec<f64> {
    let scores = &calibration.quality.compensated;
    scores.cv_rmse.clone().or_else(|| scores.train_rmse.clone()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::questions::{Request, analyse, train};
    use crate::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

    /// Three runs of a gauge with hysteresis at 400 Hz. A history of 15 s with all samples needs more than 64 kB.
    #[test]
    fn every_fit_chooses_the_same_history() {
        let mut set = RecordingSet::default();
        for at in 0..3 {
            let load = |k: usize| (0.002 * k as f64 + f64::from(at)).sin();
            let mut play = 0.0;
            let gauge = |k| {
                play = f64::clamp(play, load(k) - 0.1, load(k) + 0.1);
                10.0 * load(k) + play
            };
            let gauges: Vec<f64> = (0..12_000).map(gauge).collect();
            let recording = Recording::new(
                format!("r{at}"),
                Source::Simulated,
                (0..12_000).map(|k| f64::from(k) / 400.0).collect(),
                vec!["S1".to_owned()],
                gauges,
                vec![Axis::Fz],
                (0..12_000).map(|k| 10.0 * load(k)).collect(),
            );
            set.push(Entry::new(recording.unwrap(), Role::Train)).unwrap();
        }
        let set = Arc::new(set);
        let request = |history_rate_hz| {
            let settings = FitSettings { history_rate_hz, ..FitSettings::default() };
            Request::fit(Arc::clone(&set), settings)
        };
        let (progress, chosen) = (Progress::default(), request(None));
        let trained = train(&chosen, &progress, &mut |_| {}).unwrap();
        let shown = analyse(&chosen, &progress).unwrap().calibration;
        assert_eq!(shown.history_step_secs, trained.history_step_secs);
        assert_eq!(shown.quality.compensated, trained.quality.compensated);
        assert!(!Footprint::of(&trained).is_large());
        let again = train(&request(trained.settings().history_rate_hz), &progress, &mut |_| {});
        assert_eq!(again.unwrap().quality.compensated, trained.quality.compensated);
        let whole = train(&request(Some(0.0)), &progress, &mut |_| {}).unwrap();
        assert!(Footprint::of(&whole).is_large());
        assert!(whole.history_step_secs < trained.history_step_secs);
    }
}
