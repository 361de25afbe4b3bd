//! Training, the search for models and their list, and the choice of thresholds.

use std::sync::Arc;
use std::time::Duration;

use super::Engine;
use crate::{
    calibration::Calibration,
    engine::{
        lanes::ANYONE,
        notice::Level,
        project::{Edit, Project},
        query::Background as _,
        session::prove_trained,
        tasks::Task,
    },
    questions::{
        Candidates, HistoryBlock, Model, Request, Search, WITHIN,
        models::asked::{OnTrained, Train, Trained, TryModels},
        thresholds::{
            Measure,
            asked::{ChooseBlock, StudyThresholds},
        },
    },
    recording::RecordingSet,
};

impl Engine {
    pub(super) fn train(&mut self) {
        let learns = self.project.settings.regressor.learner().is_some();
        if learns && self.lane::<Train>().is_idle() {
            let train = self.training_of(Arc::clone(&self.project.recordings));
            self.lanes.of_mut(ANYONE).ask_again(train);
        }
    }

    /// Returns the request for a training with the present settings. The trained calibration is autosaved at once, even if
    /// the window is hidden.
    fn training_of(&self, recordings: Arc<RecordingSet>) -> Train {
        let autosave = self.recovery.autosave();
        let request = self.request_of(recordings);
        let on_trained: OnTrained = Arc::new(move |request, calibration| {
            autosave.take_trained(&request.recordings, &request.settings, calibration);
        });
        Train { request, on_trained }
    }

    fn request_of(&self, recordings: Arc<RecordingSet>) -> Request {
        Request {
            datasets: self.datasets.clone(),
            ..Request::fit(recordings, self.project.settings.clone())
        }
    }

    pub(super) fn choose_block(&mut self, block: HistoryBlock, measure: Option<Measure>) {
        if self.lane::<ChooseBlock>().is_idle() {
            let request = self.request_of(Arc::clone(&self.project.recordings));
            self.lanes.of_mut(ANYONE).ask_again(ChooseBlock { block, measure, request });
        }
    }

    pub(super) fn find_best(&mut self, candidates: Candidates, limit: Duration) {
        if self.is_trying() {
            return;
        }
        let run = self.models.next_run();
        let search = Search {
            recordings: Arc::clone(&self.project.recordings),
            settings: self.project.settings.clone(),
            candidates,
            limit,
            within: WITHIN,
        };
        self.lanes.of_mut(ANYONE).ask_again(TryModels { run, search });
    }

    /// Adds the models that a search or comparison has fitted to the list. `have_ended` is true if no search or comparison
    /// runs.
    pub(super) fn take_models(&mut self, have_ended: bool) {
        let lane = self.lanes.of_mut::<TryModels>(ANYONE);
        if let (Some(asked), Some(found)) = (lane.answered(), lane.answer())
            && !lane.happened().is_empty()
        {
            self.models.take(asked, found);
        }
        // All fitted models are now in the list. The request is removed, because it would keep its recordings in memory.
        if have_ended {
            lane.forget();
        }
    }

    pub(super) fn keep_model(&mut self) {
        if self.can_keep() {
            self.list(true);
        } else {
            let text =
                "There is no model to keep yet: fit or train with the present settings first";
            self.notice(Level::Error, text);
        }
    }

    /// Adds the model of the present fit to the list of models, unless the list is empty or already has a model with the
    /// present settings.
    pub(super) fn list_present(&mut self) {
        let is_moving = self.gesture.is_some() || !self.tasks.is_empty() || self.is_trying();
        let is_wanted = !self.models.rows.is_empty() && !self.models.has_present(&self.project);
        if is_wanted && !is_moving && self.can_keep() {
            self.list(false);
        }
    }

    /// Adds the model of the present calibration to the list of models. `is_asked` is true if the user asked to keep it.
    pub(super) fn list(&mut self, is_asked: bool) {
        if let Some((_, analysis)) = self.exact() {
            let calibration = Arc::clone(&analysis.calibration);
            let Project { recordings, settings, .. } = &self.project;
            let (recordings, settings) = (Arc::clone(recordings), settings.clone());
            let of = Arc::clone(&recordings);
            let task = Task::new(
                "Adding the model to the list",
                move |_| Ok(Model::fitted(settings, &calibration, &recordings)),
                move |engine: &mut Self, model| {
                    if is_asked {
                        engine.models.keep(model, &of);
                    } else {
                        engine.models.take_present(model, &of);
                    }
                },
            );
            self.tasks.begin(task.seen_if(is_asked), None);
        }
    }

    /// Uses the settings of the row with this number in the list of models.
    pub(super) fn bring_back(&mut self, id: u64) {
        if let Some(row) = self.models.row(id) {
            self.edit(Edit::Model(Box::new(row.model.settings.clone())));
        }
    }

    /// Starts the automatic choice of F_th and t_th by cross-validation, unless the user has chosen these thresholds.
    pub(super) fn find_first_thresholds(&mut self) {
        let thresholds = self.project.thresholds();
        let features = &self.project.settings.features;
        let is_default = features.look_backs == [self.project.default_thresholds()];
        if is_default && self.project.applied.is_none() && !self.project.recordings.is_static() {
            self.first_thresholds = Some((Arc::clone(&self.project.recordings), thresholds));
            self.ask(StudyThresholds::of(&self.request(), thresholds));
        }
    }

    /// Sets the automatically chosen thresholds, unless the user has meanwhile changed thresholds, recordings or roles.
    pub(super) fn take_first_thresholds(&mut self) {
        let Some((recordings, before)) = &self.first_thresholds else { return };
        let study = self.lane::<StudyThresholds>();
        let is_meant = Arc::ptr_eq(recordings, &self.project.recordings)
            && self.project.settings.features.look_backs == [*before]
            && self.project.applied.is_none();
        if is_meant && !study.is_idle() {
            return;
        }
        let map = study.answer().filter(|_| is_meant && study.is_current());
        let map = map.and_then(|study| study.map.clone());
        self.first_thresholds = None;
        let Some(map) = map else { return };
        let measure = map.scale.default_measure();
        let Ok(found) = map.suggestion(measure) else { return };
        // Setting the thresholds is no undo step of its own. So undo returns to the document before the files were opened.
        let set = self.project.edit(Edit::Thresholds(found.thresholds));
        debug_assert!(set.is_ok(), "thresholds fit any recordings");
        let text = format!("Thresholds set to the {}", found.in_words(&map, measure));
        self.notice(Level::Info, text);
    }

    /// Starts the check that the session's trained calibration was trained on the session's recordings, once all are loaded.
    pub(super) fn prove(&mut self) {
        let recordings = &self.project.recordings;
        let is_whole = self.project.lost.is_empty() && !recordings.entries().is_empty();
        if let Some(trained) = self.unproven.as_ref().filter(|_| is_whole) {
            let (recordings, trained) = (Arc::clone(recordings), Arc::clone(trained));
            let both = (Arc::clone(&trained), Arc::clone(&recordings));
            let prove = move |_: &_| Ok(prove_trained(&trained, &recordings));
            let take = move |engine: &mut Self, proven| engine.take_proven(both, proven);
            self.tasks.begin(Task::new("Checking the trained calibration", prove, take), None);
        }
    }

    /// Uses the session's trained calibration if it was trained on the session's recordings. The result is ignored if another
    /// session was opened since this check began, or if an earlier check has already ended.
    fn take_proven(
        &mut self,
        (trained, recordings): (Arc<Calibration>, Arc<RecordingSet>),
        proven: Result<(), String>,
    ) {
        if self.unproven.take_if(|unproven| Arc::ptr_eq(unproven, &trained)).is_none() {
            return;
        }
        match proven {
            Ok(()) => self.take_trained(trained, recordings),
            Err(reason) => self.notice(Level::Warning, reason),
        }
    }

    /// Uses the trained calibration that was read with the session as if it had just been trained.
    fn take_trained(&mut self, calibration: Arc<Calibration>, recordings: Arc<RecordingSet>) {
        let train = self.training_of(recordings);
        let trained = Trained { calibration: Some(calibration), ..Trained::default() };
        self.lanes.of_mut(ANYONE).put(train, trained);
    }
}
