//! Requests that are answered in the background: a study of a look-back's thresholds, and the choice of a feature's values.

use std::sync::{Arc, Mutex, PoisonError};

use crate::{
    features::Thresholds,
    finding::Finding,
    panicked::locked,
    questions::{
        question::{Answered, Query, Work},
        request::Request,
        thresholds::{
            map::{Measure, ThresholdGrid, ThresholdMap},
            study::{BlockSuggestion, HistoryBlock, PastAges, Study},
        },
    },
    scoring::mean_hysteresis::MeanHysteresis,
};

/// Number of force thresholds F_th, and of time thresholds t_th, that the map of errors tries.
const MAP_SIDE: usize = 40;

/// Request for the errors of a look-back at many pairs of thresholds, and for the ages of the earlier samples that it finds
/// at the present thresholds.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyThresholds {
    /// Inputs of the map of errors. The thresholds of the first look-back have default values here. So the map is not
    /// computed anew when the user changes them.
    request: Request,
    thresholds: Thresholds,
}

/// Answer to [`StudyThresholds`], complete or in progress.
#[derive(Clone, Debug)]
pub struct ThresholdStudy {
    /// Errors at each pair of thresholds; rows may still be missing. `None` before the first row.
    pub map: Option<Arc<ThresholdMap>>,
    /// Ages of the earlier samples that the look-back finds at the present thresholds.
    pub past_ages: PastAges,
    /// Mean hysteresis in the training recordings, for comparison with the force threshold F_th.
    pub hysteresis: MeanHysteresis,
    /// Finding of a time lag in the recordings that the look-back would describe as hysteresis. Measured after the map is
    /// complete.
    pub lag: Option<Finding>,
}

struct Prepared {
    of: Request,
    study: Study,
    map: Option<Arc<ThresholdMap>>,
}

/// Prepared data of the last study, for further requests with the same recordings and settings.
#[derive(Default)]
pub struct StudyCache(Option<Prepared>);

impl StudyThresholds {
    /// Returns the request for a study of the fit in `request`, with `thresholds` as the present thresholds.
    pub fn of(request: &Request, thresholds: Thresholds) -> Self {
        let mut request = request.plain();
        let features = &mut request.settings.features;
        let default = Thresholds::default_for(features.distance);
        match features.look_backs.first_mut() {
            Some(first) => *first = default,
            None => features.look_backs.push(default),
        }
        Self { request, thresholds }
    }
}

impl Query for StudyThresholds {
    type Answer = ThresholdStudy;
    type Cache = StudyCache;

    fn title(&self) -> String {
        "Studying thresholds".to_owned()
    }

    fn is_akin(&self, other: &Self) -> bool {
        self.request == other.request
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { cache, progress, show } = work;
        if cache.0.as_ref().is_none_or(|prepared| prepared.of != self.request) {
            // The old study is dropped before the new one is prepared, because both may not fit in memory.
            cache.0 = None;
            let study = Study::prepare(&self.request, progress)?;
            cache.0 = Some(Prepared { of: self.request.clone(), study, map: None });
        }
        let Prepared { study, map, .. } = cache.0.as_mut().expect("the study was just prepared");
        let mut found = ThresholdStudy {
            map: map.clone(),
            past_ages: study.past_ages(self.thresholds),
            hysteresis: study.mean_hysteresis(),
            lag: None,
        };
        if found.map.as_ref().is_none_or(|map| !map.is_complete()) {
            show(found.clone());
            let grid = ThresholdGrid::covering(study.largest_distance(), MAP_SIDE, MAP_SIDE)
                .expect("the window's threshold grid of fixed size is neither empty nor too large");
            let so_far = Mutex::new(found.map.clone());
            let made = study.threshold_map(found.map.as_deref(), &grid, progress, &|map| {
                let map = Some(Arc::new(map.clone()));
                locked(&so_far).clone_from(&map);
                show(ThresholdStudy { map, ..found.clone() });
            });
            found.map = so_far.into_inner().unwrap_or_else(PoisonError::into_inner);
            // After a cancellation, the next request continues this incomplete map.
            map.clone_from(&found.map);
            made?;
        }
        Ok(ThresholdStudy { lag: study.lag(progress)?, ..found })
    }
}

/// Request for the values of a feature, such as its time constants, that give the lowest cross-validation error.
#[derive(Clone, Debug)]
pub struct ChooseBlock {
    /// Group of features (feature block) whose values are to be chosen.
    pub block: HistoryBlock,
    /// Error that the choice minimises; `None` for the default error of the sensor.
    pub measure: Option<Measure>,
    /// Recordings, and the settings of the fit besides the values of this feature.
    pub request: Request,
}

impl Query for ChooseBlock {
    type Answer = BlockSuggestion;
    type Cache = ();
    const BEGUN_BY_USER: Option<&'static str> = Some("");

    fn title(&self) -> String {
        format!("Choosing {}", self.block.setting().label.to_lowercase())
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let study = Study::prepare(&self.request, work.progress)?;
        let measure = self.measure.unwrap_or_else(|| study.scale().default_measure());
        Ok(study.suggest_block(self.block, measure, work.progress)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::FitSettings;
    use crate::progress::Progress;
    use crate::questions::question::Unanswered;
    use crate::recording::simulated;

    #[test]
    fn the_map_stays_while_new_thresholds_restart_it() {
        let request = Request::fit(Arc::new(simulated::recordings(4)), FitSettings::default());
        let study = |thresholds| StudyThresholds::of(&request, thresholds);
        let thresholds = Thresholds::default();
        let mut cache = StudyCache::default();
        let progress = Progress::default();
        let stopped = study(thresholds).compute(Work {
            cache: &mut cache,
            progress: &progress,
            show: &|found| {
                if found.map.is_some_and(|map| map.n_rows_done() > 0) {
                    progress.cancel();
                }
            },
        });
        assert_eq!(stopped.unwrap_err(), Unanswered::Cancelled);
        let shown = Mutex::new(Vec::new());
        let moved = study(Thresholds { f_th: 2.0 * thresholds.f_th, ..thresholds });
        let found = moved.compute(Work {
            cache: &mut cache,
            progress: &Progress::default(),
            show: &|found| {
                let n_rows = found.map.map(|map| map.n_rows_done());
                shown.lock().unwrap().push(n_rows);
            },
        });
        assert!(found.unwrap().map.unwrap().is_complete());
        let shown = shown.into_inner().unwrap();
        assert!(shown[0].is_some_and(|n_rows| n_rows > 0), "{shown:?}");
        let again = study(thresholds).compute(Work {
            cache: &mut cache,
            progress: &Progress::default(),
            show: &|_| panic!("the map is complete, so there is no partial answer"),
        });
        assert!(again.unwrap().map.unwrap().is_complete());
    }
}
