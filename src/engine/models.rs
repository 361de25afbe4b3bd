//! List of models: origin, result, and whether a model belongs to the present recordings.
//!
//! Guarantees: results stay when a run is cancelled. A run replaces results of the previous run, except pinned ones.

use std::sync::{Arc, Weak};

use crate::calibration::{Calibration, FitSettings, Regressor};
use crate::engine::project::Project;
pub use crate::questions::ModelState as State;
use crate::questions::models::asked::Compare;
use crate::questions::thresholds::ScoreSet;
use crate::questions::{
    Best, Candidate, Mark, Model, ModelRow, TrainingStep, model_table, paper_candidates,
};
use crate::recording::RecordingSet;
use crate::report::{Cell, Table};

/// Default time (min) after which a search starts no further model.
pub const SEARCH_MINUTES: f64 = 10.0;

#[derive(Clone, Debug)]
pub enum ModelChange {
    /// Pin or unpin: a pinned row stays when other models are tried.
    Pin(bool),
    Name(String),
    Remove,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// A search and the index of the candidate.
    Search(u64, usize),
    /// A comparison and the index of the candidate.
    Paper(u64, usize),
    Kept,
    Present,
}

#[derive(Clone, Debug)]
pub struct Row {
    pub id: u64,
    pub name: String,
    /// A pinned row stays when other models are tried.
    pub is_pinned: bool,
    pub settings: FitSettings,
    pub state: State,
    pub mark: Mark,
    /// Amount of data as named in the paper; empty if it follows from the settings.
    data: String,
    origin: Origin,
    recordings: Weak<RecordingSet>,
}

impl Row {
    /// Returns the model, if it is fitted.
    pub fn model(&self) -> Option<&Model> {
        match &self.state {
            State::Ready(model) => Some(model),
            _ => None,
        }
    }

    fn has_ended(&self) -> bool {
        matches!(self.state, State::Ready(_) | State::Failed(_))
    }

    /// Returns true if the model was fitted to other recordings or roles than the present ones.
    pub fn is_stale(&self, project: &Project) -> bool {
        !std::ptr::eq(self.recordings.as_ptr(), Arc::as_ptr(&project.recordings))
    }

    /// Returns true if the document has the settings of this row; full scales belong to the sensor and do not count.
    pub fn is_present(&self, project: &Project) -> bool {
        let own = project.with_full_scale(self.settings.clone());
        project.applied.is_none() && own == project.settings
    }
}

/// List of models.
#[derive(Clone, Debug, Default)]
pub struct Models {
    /// Rows in the order of their fits.
    pub rows: Vec<Row>,
    /// Reasons for the proposal of a search, and candidates that it left out.
    pub remarks: Vec<String>,
    n_rows: u64,
    n_runs: u64,
    /// Run whose first answer was taken, and the number of its candidates that were taken.
    taken: (u64, usize),
}

impl Models {
    pub(super) fn next_run(&mut self) -> u64 {
        self.n_runs += 1;
        self.n_runs
    }

    fn push(
        &mut self,
        (name, origin): (String, Origin),
        (settings, state): (FitSettings, State),
        recordings: &Arc<RecordingSet>,
    ) -> &mut Row {
        self.n_rows += 1;
        self.rows.push(Row {
            id: self.n_rows,
            name,
            is_pinned: false,
            settings,
            state,
            mark: Mark::None,
            data: String::new(),
            origin,
            recordings: Arc::downgrade(recordings),
        });
        self.rows.last_mut().expect("a row was added")
    }

    fn push_model(
        &mut self,
        origin: (String, Origin),
        model: Model,
        recordings: &Arc<RecordingSet>,
    ) -> &mut Row {
        let state = State::Ready(Box::new(model.clone()));
        self.push(origin, (model.settings, state), recordings)
    }

    /// Returns the row with this number.
    pub fn row(&self, id: u64) -> Option<&Row> {
        self.rows.iter().find(|row| row.id == id)
    }

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
            // Rows that the user removed are not added again.
            match self.rows.iter_mut().find(|row| row.origin == origin) {
                Some(row) => row.mark = mark,
                None if at >= self.taken.1 => {
                    let origin = (tried.name.clone(), origin);
                    self.push_model(origin, tried.model.clone(), recordings).mark = mark;
                }
                None => {}
            }
        }
        self.taken.1 = best.tried.len();
        self.remarks = best.why().into_iter().chain(best.remarks()).collect();
    }

    /// Adds the models of the paper's comparison that have no valid result; `None` if all have one.
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
            let origin = (candidate.regressor.label().to_owned(), Origin::Paper(run, at));
            let waits = (candidate.settings(&settings), State::Waits);
            self.push(origin, waits, &project.recordings).data = candidate.pattern();
        }
        (!candidates.is_empty()).then(|| Compare {
            run,
            recordings: Arc::clone(&project.recordings),
            settings,
            candidates,
        })
    }

    pub(super) fn take_paper(&mut self, asked: &Compare, states: &[State]) {
        for (at, state) in states.iter().enumerate() {
            let origin = Origin::Paper(asked.run, at);
            let Some(row) = self.rows.iter_mut().find(|row| row.origin == origin) else {
                continue;
            };
            row.state = state.clone();
        }
    }

    /// Removes unfinished rows after the end of a run.
    pub(super) fn end_paper(&mut self) {
        self.rows.retain(Row::has_ended);
    }

    pub(super) fn keep(&mut self, model: Model, recordings: &Arc<RecordingSet>) {
        let kept = self.rows.iter().filter(|row| row.origin == Origin::Kept);
        let number = kept.count() + 1;
        let origin = (format!("Kept {number}"), Origin::Kept);
        self.push_model(origin, model, recordings).is_pinned = true;
    }

    /// Returns true if the present settings have a row with the present recordings.
    pub(super) fn has_present(&self, project: &Project) -> bool {
        self.rows.iter().any(|row| row.is_present(project) && !row.is_stale(project))
    }

    /// Replaces the row of earlier present settings by the model of the present settings.
    pub(super) fn take_present(&mut self, model: Model, recordings: &Arc<RecordingSet>) {
        self.rows.retain(|row| row.origin != Origin::Present || row.is_pinned);
        self.push_model(("Present settings".to_owned(), Origin::Present), model, recordings);
    }

    /// Returns the calibration that was trained with the present recordings and settings.
    pub(super) fn trained(&self, project: &Project) -> Option<&Arc<Calibration>> {
        let holds = |row: &&Row| !row.is_stale(project) && row.settings == project.settings;
        let models = self.rows.iter().filter(holds).filter_map(Row::model);
        models.rev().find_map(|model| model.trained.as_ref())
    }

    /// Returns the table of all rows in order: errors on these samples, and cost.
    pub fn table(&self, project: &Project, sets: &[ScoreSet]) -> Table {
        let rows = self.rows.iter().map(|row| row.of_table(project));
        model_table(project.axes(), sets, rows)
    }
}

impl Row {
    fn of_table(&self, project: &Project) -> ModelRow<'_> {
        let mark = match self.is_stale(project) {
            true => Cell::words("others")
                .about("Stale: fitted to other recordings, roles or groups than the present ones"),
            false => self.mark.cell(),
        };
        let state = match &self.state {
            State::Ready(model) => Ok(&**model),
            State::Waits => Err(Cell::missing("waits", "not fitted yet")),
            State::Runs(None) => Err(Cell::missing("runs", "being fitted")),
            State::Runs(Some(TrainingStep::Epoch(report))) => {
                let text = format!("{}/{}", report.epoch, report.epochs);
                Err(Cell::missing(text, "epochs of the network done"))
            }
            State::Runs(Some(TrainingStep::CrossValidation { done, .. })) => {
                let text = format!("{:.0} %", 100.0 * done);
                Err(Cell::missing(text, "of the cross-validation done"))
            }
            State::Failed(reason) => Err(Cell::missing("failed", reason.to_string())),
        };
        ModelRow { mark, name: &self.name, data: &self.data, settings: &self.settings, state }
    }
}

/// Returns the settings that all candidates of a comparison share.
fn shared_settings(settings: &FitSettings) -> FitSettings {
    FitSettings {
        features: Default::default(),
        regressor: Regressor::Linear,
        decimation: 1,
        ..settings.clone()
    }
}
