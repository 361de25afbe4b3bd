//! The list of everything that was tried: who tried it, what came of it, and whether it is of the recordings of now.
//!
//! Guarantees: what a run has found stays when it is cancelled; a run replaces what the one before it found, but nothing that is
//! pinned; a row is known by its number, wherever it stands.

use std::sync::{Arc, Weak};

use crate::calibration::{Calibration, FitSettings, Regressor};
use crate::engine::project::Project;
use crate::questions::models::asked::{Compare, RowState};
use crate::questions::thresholds::ScoreSet;
use crate::questions::{
    Best, Candidate, Mark, Model, ModelRow, TrainingStep, model_table, paper_candidates,
};
use crate::recording::RecordingSet;
use crate::report::{Cell, Table};

/// The most minutes in which the search begins another model, unless somebody says otherwise.
pub const SEARCH_MINUTES: f64 = 2.0;

/// What becomes of a row of the list.
#[derive(Clone, Debug)]
pub enum ModelChange {
    /// Keep it when others are tried, or no longer.
    Pin(bool),
    /// Call it so.
    Name(String),
    /// Take it off the list.
    Remove,
}

/// How far a model is.
#[derive(Clone, Debug)]
pub enum State {
    /// It is still to be fitted.
    Waits,
    /// It is being fitted; its network is so far.
    Runs(Option<TrainingStep>),
    /// It could not be fitted, for this reason.
    Failed(String),
    /// It is there.
    Ready(Box<Model>),
}

/// Who tried it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// A search, and its so many-th candidate.
    Search(u64, usize),
    /// A comparison, and its so many-th candidate.
    Paper(u64, usize),
    /// The user kept it.
    Kept,
    /// It is that of the settings of now.
    Present,
}

/// A row of the list.
#[derive(Clone, Debug)]
pub struct Row {
    /// What it is known by.
    pub id: u64,
    /// What it is called.
    pub name: String,
    /// Whether it stays when others are tried.
    pub is_pinned: bool,
    /// What brings it back.
    pub settings: FitSettings,
    /// How far it is.
    pub state: State,
    /// Whether it is the one to take.
    pub mark: Mark,
    /// The amount of data in the paper's words; empty where it is that of the settings.
    data: String,
    origin: Origin,
    recordings: Weak<RecordingSet>,
}

impl Row {
    /// What came of it, where something did.
    pub fn model(&self) -> Option<&Model> {
        match &self.state {
            State::Ready(model) => Some(model),
            _ => None,
        }
    }

    fn has_ended(&self) -> bool {
        matches!(self.state, State::Ready(_) | State::Failed(_))
    }

    /// Whether it was made of other recordings, or of other roles, than those of now.
    pub fn is_stale(&self, project: &Project) -> bool {
        !std::ptr::eq(self.recordings.as_ptr(), Arc::as_ptr(&project.recordings))
    }

    /// Whether the document's settings are its own. Full scales are the sensor's, not a model's.
    pub fn is_present(&self, project: &Project) -> bool {
        let own = project.with_full_scale(self.settings.clone());
        project.applied.is_none() && own == project.settings
    }
}

/// The list.
#[derive(Clone, Debug, Default)]
pub struct Models {
    /// In the order in which they were tried.
    pub rows: Vec<Row>,
    /// Why a search proposes what it proposes, and what it left away.
    pub said: Vec<String>,
    n_rows: u64,
    n_runs: u64,
    /// The run whose first answer was taken, and how many of its candidates.
    taken: (u64, usize),
}

impl Models {
    /// The number of the next run.
    pub(super) fn next_run(&mut self) -> u64 {
        self.n_runs += 1;
        self.n_runs
    }

    fn push(&mut self, row: Row) {
        self.n_rows += 1;
        self.rows.push(Row { id: self.n_rows, ..row });
    }

    /// The row of this number.
    pub fn row(&self, id: u64) -> Option<&Row> {
        self.rows.iter().find(|row| row.id == id)
    }

    /// Changes the row of this number, if it is still there.
    pub(super) fn change(&mut self, id: u64, change: ModelChange) {
        let Some(at) = self.rows.iter().position(|row| row.id == id) else {
            return;
        };
        match change {
            ModelChange::Pin(is_pinned) => self.rows[at].is_pinned = is_pinned,
            ModelChange::Name(name) => self.rows[at].name = name,
            ModelChange::Remove => {
                self.rows.remove(at);
            }
        }
    }

    /// Takes how far a search is.
    pub(super) fn take_search(&mut self, run: u64, best: &Best, recordings: &Arc<RecordingSet>) {
        if self.taken.0 != run {
            self.taken = (run, 0);
            let is_other = |row: &Row| !matches!(row.origin, Origin::Search(..));
            self.rows.retain(|row| row.is_pinned || is_other(row));
            self.rows.iter_mut().for_each(|row| row.mark = Mark::None);
        }
        for (at, tried) in best.tried.iter().enumerate() {
            let mark = tried.mark();
            let origin = Origin::Search(run, at);
            // What was removed meanwhile stays away.
            match self.rows.iter_mut().find(|row| row.origin == origin) {
                Some(row) => row.mark = mark,
                None if at >= self.taken.1 => self.push(Row {
                    id: 0,
                    name: tried.name.to_owned(),
                    is_pinned: false,
                    settings: tried.model.settings.clone(),
                    state: State::Ready(Box::new(tried.model.clone())),
                    mark,
                    data: String::new(),
                    origin,
                    recordings: Arc::downgrade(recordings),
                }),
                None => {}
            }
        }
        self.taken.1 = best.tried.len();
        self.said = best.why().into_iter().chain(best.remarks()).collect();
    }

    /// Lists what the paper compares and has no result yet that holds; `None` where all have one.
    pub(super) fn begin_paper(&mut self, project: &Project) -> Option<Compare> {
        const LEARNERS: [Regressor; 3] =
            [Regressor::Linear, Regressor::Network, Regressor::HybridNetwork];
        let run = self.next_run();
        let settings = shared_settings(&project.settings);
        let mut candidates = paper_candidates(&project.recordings, &project.settings, &LEARNERS);
        let holds = |row: &Row, candidate: &Candidate| {
            matches!(row.origin, Origin::Paper(..))
                && row.model().is_some()
                && !row.is_stale(project)
                && row.data == candidate.pattern()
                && row.settings == candidate.settings(&settings)
        };
        self.rows.retain(|row| {
            let is_paper = matches!(row.origin, Origin::Paper(..));
            !is_paper || row.is_pinned || candidates.iter().any(|own| holds(row, own))
        });
        candidates.retain(|own| !self.rows.iter().any(|row| holds(row, own)));
        for (at, candidate) in candidates.iter().enumerate() {
            self.push(Row {
                id: 0,
                name: candidate.regressor.label().to_owned(),
                is_pinned: false,
                settings: candidate.settings(&settings),
                state: State::Waits,
                mark: Mark::None,
                data: candidate.pattern(),
                origin: Origin::Paper(run, at),
                recordings: Arc::downgrade(&project.recordings),
            });
        }
        (!candidates.is_empty()).then(|| Compare {
            run,
            recordings: Arc::clone(&project.recordings),
            settings,
            candidates,
        })
    }

    /// Takes how far a comparison is.
    pub(super) fn take_paper(&mut self, asked: &Compare, states: &[RowState]) {
        for (at, state) in states.iter().enumerate() {
            let origin = Origin::Paper(asked.run, at);
            let Some(row) = self.rows.iter_mut().find(|row| row.origin == origin) else {
                continue;
            };
            row.state = match state {
                RowState::Waits => State::Waits,
                RowState::Runs(report) => State::Runs(*report),
                RowState::Ended(Err(reason)) => State::Failed(reason.clone()),
                RowState::Ended(Ok(compared)) => State::Ready(compared.model.clone()),
            };
        }
    }

    /// Nothing runs any more: what has not ended goes.
    pub(super) fn end_paper(&mut self) {
        self.rows.retain(Row::has_ended);
    }

    /// Takes a model that somebody keeps.
    pub(super) fn keep(&mut self, model: Model, recordings: &Arc<RecordingSet>) {
        let kept = self.rows.iter().filter(|row| row.origin == Origin::Kept);
        let number = kept.count() + 1;
        self.push(Row {
            id: 0,
            name: format!("Kept {number}"),
            is_pinned: true,
            settings: model.settings.clone(),
            state: State::Ready(Box::new(model)),
            mark: Mark::None,
            data: String::new(),
            origin: Origin::Kept,
            recordings: Arc::downgrade(recordings),
        });
    }

    /// Whether the settings of now have a row of these recordings.
    pub(super) fn has_present(&self, project: &Project) -> bool {
        self.rows.iter().any(|row| row.is_present(project) && !row.is_stale(project))
    }

    /// Takes the model of the settings of now in the place of those of before.
    pub(super) fn take_present(&mut self, model: Model, recordings: &Arc<RecordingSet>) {
        self.rows.retain(|row| row.origin != Origin::Present || row.is_pinned);
        self.push(Row {
            id: 0,
            name: "Settings of now".to_owned(),
            is_pinned: false,
            settings: model.settings.clone(),
            state: State::Ready(Box::new(model)),
            mark: Mark::None,
            data: String::new(),
            origin: Origin::Present,
            recordings: Arc::downgrade(recordings),
        });
    }

    /// What was trained for just these recordings and settings.
    pub(super) fn trained(&self, project: &Project) -> Option<&Arc<Calibration>> {
        let holds = |row: &&Row| !row.is_stale(project) && row.settings == project.settings;
        let models = self.rows.iter().filter(holds).filter_map(Row::model);
        models.rev().find_map(|model| model.trained.as_ref())
    }

    /// All of them, a row each, in their order: errors on these samples, and what a model costs.
    pub fn table(&self, project: &Project, sets: &[ScoreSet]) -> Table {
        let rows = self.rows.iter().map(|row| row.of_table(project));
        model_table(project.axes(), sets, rows)
    }
}

impl Row {
    fn of_table(&self, project: &Project) -> ModelRow<'_> {
        let mark = match self.is_stale(project) {
            true => Cell::words("others").about(
                "Stale: made of other recordings, or of other roles or groups of them, than those of now",
            ),
            false => self.mark.cell(),
        };
        let state = match &self.state {
            State::Ready(model) => Ok(&**model),
            State::Waits => Err(Cell::missing("waits", "it is still to be fitted")),
            State::Runs(None) => Err(Cell::missing("runs", "it is being fitted")),
            State::Runs(Some(TrainingStep::Epoch(report))) => {
                let text = format!("{}/{}", report.epoch, report.epochs);
                Err(Cell::missing(text, "epochs that its network has had"))
            }
            State::Runs(Some(TrainingStep::CrossValidation { done, .. })) => {
                let text = format!("{:.0} %", 100.0 * done);
                Err(Cell::missing(text, "of its cross-validation is done"))
            }
            State::Failed(reason) => Err(Cell::missing("failed", reason)),
        };
        ModelRow { mark, name: &self.name, data: &self.data, settings: &self.settings, state }
    }
}

/// What all candidates of a comparison have in common; the rest is the candidate's.
fn shared_settings(settings: &FitSettings) -> FitSettings {
    FitSettings {
        features: Default::default(),
        regressor: Regressor::Linear,
        decimation: 1,
        ..settings.clone()
    }
}
