//! The questions that the window asks: each is a pure function of what it carries, made known to the lanes.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use crate::calibration::{Calibration, EpochReport, ExpectedError, FitSettings};
use crate::engine::query::{Answered, Query, Unanswered, Work};
use crate::engine::recovery::Autosave;
use crate::features::Thresholds;
use crate::questions::check::independent_loads::Sufficiency;
use crate::questions::check::query::sufficiency;
use crate::questions::expected_error::query::expected_error;
use crate::questions::loops::{Look, LookError, LookRequest, Viewer};
use crate::questions::thresholds::{Measure, PastAges, ThresholdGrid, ThresholdMap};
use crate::questions::{
    Analysis, AnalysisError, Analyst, Best, BlockSuggestion, Candidate, ComparedRow, Datasets,
    HangingMass, HistoryBlock, Request, RowEvent, Search, Study, StudyEvent, TrainingStep, compare,
    find_best, train,
};
use crate::recording::{Entry, Recording, RecordingSet, ValidRange};
use crate::scoring::faults::Faults;
use crate::scoring::mean_hysteresis::MeanHysteresis;

/// The map has so many F_th, and so many t_th.
const MAP_SIDE: usize = 40;

impl From<AnalysisError> for Unanswered {
    fn from(error: AnalysisError) -> Self {
        match error {
            AnalysisError::Cancelled(_) => Self::Cancelled,
            error => Self::Because(error.to_string()),
        }
    }
}

impl From<LookError> for Unanswered {
    fn from(error: LookError) -> Self {
        match error {
            LookError::Cancelled(_) => Self::Cancelled,
            error => Self::Because(error.to_string()),
        }
    }
}

fn request_key(request: &Request) -> impl PartialEq {
    (
        Arc::as_ptr(&request.recordings),
        &request.settings,
        request.view,
        request.trained,
        request.calibration.as_ref().map(Arc::as_ptr),
        request.factory.as_ref().map(Arc::as_ptr),
    )
}

/// Fit and score, and make the traces.
#[derive(Clone, Debug)]
pub struct Analyse(pub Request);

impl Query for Analyse {
    type Answer = Arc<Analysis>;
    type Cache = Analyst;
    const PATIENCE_ONCE_SHOWN: Duration = Duration::ZERO;

    fn title(&self) -> String {
        "Updating".to_owned()
    }

    fn key(&self) -> impl PartialEq {
        request_key(&self.0)
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { cache: analyst, progress, show } = work;
        let show = |preview| show(Arc::new(preview));
        let analysis = analyst.analyse_showing(&self.0, progress, Some(&show))?;
        Ok(Arc::new(analysis))
    }
}

/// Train a network or a kernel, which takes longer than a slider may wait. When it is stopped, a network keeps the best it had.
#[derive(Clone)]
pub struct Train {
    /// What is asked for.
    pub request: Request,
    /// Where the result is kept safe, even while the window draws nothing.
    pub autosave: Autosave,
}

/// How far a training is.
#[derive(Clone, Debug, Default)]
pub struct Trained {
    /// The network's reports, epoch by epoch.
    pub epochs: Vec<EpochReport>,
    /// How far it is.
    pub step: Option<TrainingStep>,
    /// What came of it.
    pub calibration: Option<Arc<Calibration>>,
}

impl Trained {
    /// Whether what came of it was scored on left-out parts.
    pub fn is_cross_validated(&self) -> bool {
        let calibration = self.calibration.as_ref();
        calibration.is_some_and(|own| own.quality.compensated.cv_rmse.is_some())
    }
}

impl Query for Train {
    type Answer = Trained;
    type Cache = ();

    fn title(&self) -> String {
        "Training".to_owned()
    }

    fn key(&self) -> impl PartialEq {
        request_key(&self.request)
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { progress, show, .. } = work;
        let mut trained = Trained::default();
        show(trained.clone());
        let calibration = train(&self.request, progress, &mut |step| {
            trained.step = Some(step);
            if let TrainingStep::Epoch(report) = step {
                trained.epochs.push(report);
            }
            show(trained.clone());
        })?;
        let calibration = Arc::new(calibration);
        let Request { recordings, settings, .. } = &self.request;
        self.autosave.take_trained(recordings, settings, &calibration);
        trained.calibration = Some(calibration);
        Ok(trained)
    }
}

/// Whether the recordings carry the model.
#[derive(Clone, Debug)]
pub struct CheckData {
    /// What would be fitted.
    pub request: Request,
    /// What loads are proposed of; `None`: any within the rated ones.
    pub hanging: Option<HangingMass>,
}

impl Query for CheckData {
    type Answer = Sufficiency;
    type Cache = ();

    fn title(&self) -> String {
        "Checking the data".to_owned()
    }

    fn key(&self) -> impl PartialEq {
        let request = &self.request;
        let recordings = Arc::as_ptr(&request.recordings);
        (recordings, &request.settings, &request.gauge_range, &self.hanging)
    }

    fn is_akin(&self, other: &Self) -> bool {
        self.request.recordings.layout() == other.request.recordings.layout()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        Ok(sufficiency(&self.request, self.hanging.as_ref(), work.progress)?)
    }
}

/// The expected error of the calibration that is shown.
#[derive(Clone, Debug)]
pub struct AskExpectedError {
    /// The request that the calibration answers.
    pub request: Request,
    /// The calibration.
    pub calibration: Arc<Calibration>,
    /// Whether it was fitted to these recordings.
    pub fitted: bool,
}

impl Query for AskExpectedError {
    type Answer = Result<ExpectedError, String>;
    type Cache = ();

    fn title(&self) -> String {
        "Expected error".to_owned()
    }

    fn key(&self) -> impl PartialEq {
        let recordings = Arc::as_ptr(&self.request.recordings);
        (recordings, Arc::as_ptr(&self.calibration))
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Self { request, calibration, fitted } = self;
        Ok(expected_error(request, calibration, *fitted, work.progress)?)
    }
}

/// Find the model to calibrate with.
#[derive(Clone, Debug)]
pub struct FindBest {
    /// Its number among the runs.
    pub run: u64,
    /// What is asked.
    pub search: Search,
}

impl Query for FindBest {
    type Answer = Best;
    type Cache = ();

    fn title(&self) -> String {
        "Finding the best model".to_owned()
    }

    fn key(&self) -> impl PartialEq {
        self.run
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { progress, show, .. } = work;
        Ok(find_best(&self.search, progress, &|best| show(best.clone()))?)
    }
}

/// Fit regressors and features side by side.
#[derive(Clone, Debug)]
pub struct Compare {
    /// Its number among the runs.
    pub run: u64,
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// What the candidates do not say.
    pub settings: FitSettings,
    /// What is fitted.
    pub candidates: Vec<Candidate>,
}

/// How far a row of a comparison is.
#[derive(Clone, Debug, Default)]
pub enum RowState {
    /// It has not begun.
    #[default]
    Waits,
    /// It is fitted; a network has passed over its samples so often.
    Runs(Option<TrainingStep>),
    /// It has ended.
    Ended(Result<ComparedRow, String>),
}

impl Query for Compare {
    type Answer = Vec<RowState>;
    type Cache = ();

    fn title(&self) -> String {
        "Comparing regressors".to_owned()
    }

    fn key(&self) -> impl PartialEq {
        self.run
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { progress, show, .. } = work;
        let rows = Mutex::new(vec![RowState::Waits; self.candidates.len()]);
        let Self { recordings, settings, candidates, .. } = self;
        compare(recordings, settings, candidates, progress, &|at, event| {
            let mut rows = rows.lock().unwrap_or_else(PoisonError::into_inner);
            rows[at] = match event {
                RowEvent::Started => RowState::Runs(None),
                RowEvent::Step(step) => RowState::Runs(Some(step)),
                RowEvent::Ended(row) => RowState::Ended(row.map_err(|error| error.to_string())),
            };
            show(rows.clone());
        });
        Ok(rows.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}

/// What look-backs of all thresholds would give, and which past samples the present one finds.
#[derive(Clone, Debug)]
pub struct StudyThresholds {
    recordings: Arc<RecordingSet>,
    /// The choices of the fit, the first look-back's thresholds set to a fixed pair.
    settings: FitSettings,
    /// The present thresholds.
    thresholds: Thresholds,
    datasets: Datasets,
}

/// A threshold study as far as it is.
#[derive(Clone, Debug)]
pub struct ThresholdStudy {
    /// The map; rows that have not come yet are missing. Not there before it is begun.
    pub map: Option<Arc<ThresholdMap>>,
    /// Which past samples the present thresholds find.
    pub past_ages: PastAges,
    /// The mean hysteresis of the training recordings.
    pub hysteresis: MeanHysteresis,
}

/// A study with what it was prepared for, and its map as far as it has come.
struct Prepared {
    of: StudyThresholds,
    study: Study,
    map: Option<Arc<ThresholdMap>>,
}

/// What a study finds ready.
#[derive(Default)]
pub struct StudyCache(Option<Prepared>);

impl StudyThresholds {
    /// The study of these recordings around these settings.
    pub fn new(
        recordings: Arc<RecordingSet>,
        settings: &FitSettings,
        thresholds: Thresholds,
        datasets: &Datasets,
    ) -> Self {
        let mut settings = settings.clone();
        let default = Thresholds::default_for(settings.features.distance);
        match settings.features.look_backs.first_mut() {
            Some(first) => *first = default,
            None => settings.features.look_backs.push(default),
        }
        Self { recordings, settings, thresholds, datasets: datasets.clone() }
    }

    /// What its map depends on.
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

    fn key(&self) -> impl PartialEq {
        (self.map_key(), self.thresholds)
    }

    fn is_akin(&self, other: &Self) -> bool {
        self.map_key() == other.map_key()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { cache, progress, show } = work;
        let holds = |own: &Prepared| own.of.is_akin(self);
        if !cache.0.as_ref().is_some_and(holds) {
            // Taken away first: two of them need not fit in memory at once.
            cache.0 = None;
            let (recordings, settings) = (Arc::clone(&self.recordings), self.settings.clone());
            cache.0 = Some(Prepared {
                study: Study::prepare(&self.datasets, recordings, settings, progress)?,
                of: self.clone(),
                map: None,
            });
        }
        let prepared = cache.0.as_mut().expect("was just prepared");
        let study = &prepared.study;
        let mut found = ThresholdStudy {
            map: prepared.map.clone(),
            past_ages: study.past_ages(self.thresholds),
            hysteresis: study.mean_hysteresis(),
        };
        if found.map.as_ref().is_some_and(|map| map.is_complete()) {
            return Ok(found);
        }
        show(found.clone());
        let grid = ThresholdGrid::covering(study.largest_distance(), MAP_SIDE, MAP_SIDE)
            .expect("the grid of the window is neither empty nor too large");
        let so_far = Mutex::new(None::<ThresholdMap>);
        let begun = found.map.as_deref();
        let map = study.rest_of_map(begun, &grid, progress, &|event| {
            let mut so_far = so_far.lock().unwrap_or_else(PoisonError::into_inner);
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
        // Other thresholds go on with the map where these leave it.
        found.map = so_far.map(Arc::new).or(found.map);
        prepared.map.clone_from(&found.map);
        map?;
        Ok(found)
    }
}

/// Choose the numbers of a block by cross-validation.
#[derive(Clone, Debug)]
pub struct ChooseBlock {
    /// Which.
    pub block: HistoryBlock,
    /// Whose errors count; `None`: what is looked at first.
    pub measure: Option<Measure>,
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// Everything else.
    pub settings: FitSettings,
    /// What is shared with other questions.
    pub datasets: Datasets,
}

impl Query for ChooseBlock {
    type Answer = BlockSuggestion;
    type Cache = ();

    fn title(&self) -> String {
        format!("Choosing {}", self.block.setting().label.to_lowercase())
    }

    fn key(&self) -> impl PartialEq {
        let recordings = Arc::as_ptr(&self.recordings);
        (self.block, self.measure, recordings, &self.settings)
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

/// What is wrong with recordings.
#[derive(Clone, Debug)]
pub struct FindFaults {
    /// Which.
    pub recordings: Arc<RecordingSet>,
    /// What is known of the sensor.
    pub range: ValidRange,
    /// What is shared with other questions about the same recordings.
    pub datasets: Datasets,
}

/// What is wrong with one of them, as it is shown.
#[derive(Debug)]
pub struct FaultyRecording {
    /// How many samples cannot be used.
    pub n_samples: usize,
    /// Each kind in words.
    pub words: Vec<String>,
    /// From when to when they are, on the recording's own clock (s).
    pub intervals: Vec<(f64, f64)>,
}

impl FaultyRecording {
    fn of(recording: &Recording, faults: &Faults) -> Self {
        let (samples, times) = (faults.samples(), recording.times());
        let interval =
            |samples: &std::ops::Range<usize>| (times[samples.start], times[samples.end - 1]);
        Self {
            n_samples: faults.n_samples(),
            words: faults.in_words(recording),
            intervals: samples.iter().map(interval).collect(),
        }
    }
}

impl Query for FindFaults {
    /// In the order of the recordings.
    type Answer = Vec<Arc<FaultyRecording>>;
    type Cache = ();

    fn title(&self) -> String {
        "Looking for faulty samples".to_owned()
    }

    fn key(&self) -> impl PartialEq {
        (Arc::as_ptr(&self.recordings), &self.range)
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let found = (self.datasets).faults(&self.recordings, &self.range, work.progress)?;
        let entries = self.recordings.entries().iter().zip(&found);
        let of = |entry: &Entry, found: &Faults| FaultyRecording::of(&entry.recording, found);
        Ok(entries.map(|(entry, found)| Arc::new(of(entry, found))).collect())
    }
}

/// Loops, cross-plots, dwells, the table of figures.
#[derive(Clone, Debug)]
pub struct LookAt(pub LookRequest);

impl Query for LookAt {
    type Answer = Look;
    type Cache = Viewer;

    fn title(&self) -> String {
        "Drawing loops".to_owned()
    }

    fn key(&self) -> impl PartialEq {
        let own = &self.0;
        (
            Arc::as_ptr(&own.calibration),
            Arc::as_ptr(&own.recordings),
            Arc::as_ptr(&own.traces),
            own.decimation,
            own.visible,
            &own.measuring,
            &own.question,
        )
    }

    fn is_akin(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0.recordings, &other.0.recordings)
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { cache: viewer, progress, .. } = work;
        Ok(viewer.look(&self.0, progress)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::tests::with_files;
    use crate::progress::Progress;

    #[test]
    fn the_map_stays_while_other_thresholds_begin_it_again() {
        let project = with_files();
        let study = |thresholds| {
            let recordings = Arc::clone(&project.recordings);
            let datasets = Datasets::default();
            StudyThresholds::new(recordings, &project.settings, thresholds, &datasets)
        };
        let thresholds = project.thresholds();
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
            show: &|_| panic!("the map is there, and what the thresholds past_ages takes no time"),
        });
        assert!(again.unwrap().map.unwrap().is_complete());
    }
}
