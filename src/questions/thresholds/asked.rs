//! Questions for the threshold study, and for the choice of a feature's values.

use std::sync::{Arc, Mutex, PoisonError};

use crate::calibration::FitSettings;
use crate::features::Thresholds;
use crate::finding::Finding;
use crate::panicked::locked;
use crate::questions::dataset::Datasets;
use crate::questions::question::{Answered, Query, Work};
use crate::questions::request::Request;
use crate::questions::thresholds::grid::ThresholdGrid;
use crate::questions::thresholds::map::ThresholdMap;
use crate::questions::thresholds::measure::Measure;
use crate::questions::thresholds::past_ages::PastAges;
use crate::questions::thresholds::study::{BlockSuggestion, HistoryBlock, Study, StudyEvent};
use crate::recording::RecordingSet;
use crate::same::same_where;
use crate::scoring::mean_hysteresis::MeanHysteresis;

/// Number of values of F_th, and of t_th, in the map.
const MAP_SIDE: usize = 40;

/// Question for the errors of a look-back at all thresholds, and the past samples that the present thresholds find.
#[derive(Clone, Debug)]
pub struct StudyThresholds {
    recordings: Arc<RecordingSet>,
    /// Settings of the fit, with the first look-back's thresholds set to a fixed pair.
    settings: FitSettings,
    thresholds: Thresholds,
    datasets: Datasets,
}

/// A threshold study, complete or in progress.
#[derive(Clone, Debug)]
pub struct ThresholdStudy {
    /// Map of errors, in which rows may be missing; `None` before the first row.
    pub map: Option<Arc<ThresholdMap>>,
    /// Ages of the past samples that the present thresholds find.
    pub past_ages: PastAges,
    /// Mean hysteresis of the training recordings.
    pub hysteresis: MeanHysteresis,
    /// Time lag that the thresholds would describe as hysteresis; measured after the map.
    pub lag: Option<Finding>,
}

struct Prepared {
    of: StudyThresholds,
    study: Study,
    map: Option<Arc<ThresholdMap>>,
}

/// Prepared study that the next question of the same recordings and settings reuses.
#[derive(Default)]
pub struct StudyCache(Option<Prepared>);

same_where!(StudyThresholds: shared(recordings) value(settings, thresholds) besides(datasets));

impl StudyThresholds {
    /// Returns the study of a request's fit with these present thresholds.
    pub fn of(request: &Request, thresholds: Thresholds) -> Self {
        let mut settings = request.settings.clone();
        let default = Thresholds::default_for(settings.features.distance);
        match settings.features.look_backs.first_mut() {
            Some(first) => *first = default,
            None => settings.features.look_backs.push(default),
        }
        let recordings = Arc::clone(&request.recordings);
        Self { recordings, settings, thresholds, datasets: request.datasets.clone() }
    }

    /// Returns the part of the question that the map depends on.
    fn map_key(&self) -> (*const RecordingSet, &FitSettings) {
        (Arc::as_ptr(&self.recordings), &self.settings)
    }
}

impl Query for StudyThresholds {
    type Answer = ThresholdStudy;
    type Cache = StudyCache;

    fn title(&self) -> String {
        "Studying thresholds".to_owned()
    }

    fn is_akin(&self, other: &Self) -> bool {
        self.map_key() == other.map_key()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { cache, progress, show } = work;
        let holds = |own: &Prepared| own.of.is_akin(self);
        if !cache.0.as_ref().is_some_and(holds) {
            // The old study is dropped first, because two may not fit in memory.
            cache.0 = None;
            let (recordings, settings) = (Arc::clone(&self.recordings), self.settings.clone());
            cache.0 = Some(Prepared {
                study: Study::prepare(&self.datasets, recordings, settings, progress)?,
                of: self.clone(),
                map: None,
            });
        }
        let prepared = cache.0.as_mut().expect("the study was just prepared");
        let study = &prepared.study;
        let mut found = ThresholdStudy {
            map: prepared.map.clone(),
            past_ages: study.past_ages(self.thresholds),
            hysteresis: study.mean_hysteresis(),
            lag: None,
        };
        if found.map.as_ref().is_some_and(|map| map.is_complete()) {
            return Ok(ThresholdStudy { lag: study.lag(progress)?, ..found });
        }
        show(found.clone());
        let grid = ThresholdGrid::covering(study.largest_distance(), MAP_SIDE, MAP_SIDE)
            .expect("the grid of the window is neither empty nor too large");
        let so_far = Mutex::new(None::<ThresholdMap>);
        let begun = found.map.as_deref();
        let map = study.rest_of_map(begun, &grid, progress, &|event| {
            let mut so_far = locked(&so_far);
            match event {
                StudyEvent::Begun(map) => *so_far = Some(map.clone()),
                StudyEvent::Row { f_at, points } => {
                    if let Some(map) = &mut *so_far {
                        map.set_row(f_at, points.to_vec());
                    }
                }
            }
            show(ThresholdStudy { map: so_far.clone().map(Arc::new), ..found.clone() });
        });
        let so_far = so_far.into_inner().unwrap_or_else(PoisonError::into_inner);
        // New thresholds continue the same map if it does not depend on them.
        found.map = so_far.map(Arc::new).or(found.map);
        prepared.map.clone_from(&found.map);
        map?;
        Ok(ThresholdStudy { lag: study.lag(progress)?, ..found })
    }
}

/// Question for the best values of a feature by cross-validation.
#[derive(Clone, Debug)]
pub struct ChooseBlock {
    /// Feature whose values are chosen.
    pub block: HistoryBlock,
    /// Error to minimise; `None` for the default.
    pub measure: Option<Measure>,
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// All other settings.
    pub settings: FitSettings,
    /// Datasets that are shared with other questions.
    pub datasets: Datasets,
}

same_where!(ChooseBlock: shared(recordings) value(block, measure, settings) besides(datasets));

impl Query for ChooseBlock {
    type Answer = BlockSuggestion;
    type Cache = ();
    const BEGUN_BY_USER: Option<&'static str> = Some("");

    fn title(&self) -> String {
        format!("Choosing {}", self.block.setting().label.to_lowercase())
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { progress, .. } = work;
        let recordings = Arc::clone(&self.recordings);
        let study = Study::prepare(&self.datasets, recordings, self.settings.clone(), progress)?;
        let measure = self.measure;
        let measure = measure.unwrap_or_else(|| study.scale().default_measure());
        Ok(study.suggest_block(self.block, measure, progress)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
