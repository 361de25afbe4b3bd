//! List of the models that were tried or kept, with their errors.
//!
//! Guarantees: fitted models stay in the list when the user cancels their search. A new search replaces the models of the
//! previous search, except pinned ones.

use std::sync::{Arc, Weak};

use crate::{
    calibration::Calibration,
    engine::project::Project,
    questions::{Best, Mark, Model, ModelRow, model_table, models::asked::TryModels},
    recording::RecordingSet,
    report::{Cell, Table},
    scoring::score_set::ScoreSet,
};

/// Default limit of the processor time of a search (min), after which no further model is started.
pub const SEARCH_MINUTES: f64 = 10.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// The model was fitted by a search: number of the search, and index of the model in it.
    Search(u64, usize),
    Kept,
    Present,
}

#[derive(Clone, Debug)]
pub struct Row {
    pub id: u64,
    pub name: String,
    pub model: Model,
    /// Recommendation that the last search gives for this model.
    pub mark: Mark,
    origin: Origin,
    recordings: Weak<RecordingSet>,
}

impl Row {
    /// Returns true if the model was fitted to other recordings or roles than the present ones, so that its errors are not
    /// comparable.
    pub fn is_stale(&self, project: &Project) -> bool {
        !std::ptr::eq(self.recordings.as_ptr(), Arc::as_ptr(&project.recordings))
    }

    /// Returns true if the settings of the model are those of the document. Full scales are not compared, because they belong
    /// to the sensor.
    pub fn is_present(&self, project: &Project) -> bool {
        let settings = project.with_full_scale(self.model.settings.clone());
        project.applied.is_none() && settings == project.settings
    }
}

/// List of the models that were tried or kept.
#[derive(Clone, Debug, Default)]
pub struct Models {
    /// Rows in the order in which the models were fitted.
    pub rows: Vec<Row>,
    /// Reasons for the recommendation of the last search, and notes about models that the search did not fit.
    pub remarks: Vec<String>,
    n_rows: u64,
    n_runs: u64,
    /// Number of the last search, and indices of those of its models that are already in the list.
    taken: (u64, Vec<usize>),
}

impl Models {
    pub(super) fn next_run(&mut self) -> u64 {
        self.n_runs += 1;
        self.n_runs
    }

    fn push(
        &mut self,
        name: String,
        origin: Origin,
        model: Model,
        recordings: &Arc<RecordingSet>,
    ) -> &mut Row {
        self.n_rows += 1;
        self.rows.push(Row {
            id: self.n_rows,
            name,
            model,
            mark: Mark::None,
            origin,
            recordings: Arc::downgrade(recordings),
        });
        self.rows.last_mut().expect("a row was added")
    }

    /// Returns the row of the list with this number.
    pub fn row(&self, id: u64) -> Option<&Row> {
        self.rows.iter().find(|row| row.id == id)
    }

    pub(super) fn remove(&mut self, id: u64) {
        self.rows.retain(|row| row.id != id);
    }

    /// Adds the models that a running search has fitted so far.
    pub(super) fn take(&mut self, asked: &TryModels, found: &Best) {
        let run = asked.run;
        if self.taken.0 != run {
            self.taken = (run, Vec::new());
            self.rows.retain(|row| !matches!(row.origin, Origin::Search(..)));
            self.rows.iter_mut().for_each(|row| row.mark = Mark::None);
        }
        for (at, tried) in found.tried.iter().enumerate() {
            let origin = Origin::Search(run, at);
            let known = self.rows.iter_mut().find(|row| row.origin == origin);
            let row = match known {
                Some(row) => row,
                // This model was in the list before, so the user has removed its row.
                None if self.taken.1.contains(&at) => continue,
                None => {
                    self.taken.1.push(at);
                    self.push(
                        tried.name.clone(),
                        origin,
                        tried.model.clone(),
                        &asked.search.recordings,
                    )
                }
            };
            row.mark = tried.mark();
        }
        self.remarks = found.why().into_iter().chain(found.remarks()).collect();
    }

    pub(super) fn keep(&mut self, model: Model, recordings: &Arc<RecordingSet>) {
        let kept = self.rows.iter().filter(|row| row.origin == Origin::Kept);
        let number = kept.count() + 1;
        self.push(format!("Kept {number}"), Origin::Kept, model, recordings);
    }

    /// Returns true if the list has a model with the present settings and recordings.
    pub(super) fn has_present(&self, project: &Project) -> bool {
        self.rows.iter().any(|row| row.is_present(project) && !row.is_stale(project))
    }

    /// Adds the model of the present settings to the list. The unpinned model that was added in this way for earlier settings
    /// is removed.
    pub(super) fn take_present(&mut self, model: Model, recordings: &Arc<RecordingSet>) {
        self.rows.retain(|row| row.origin != Origin::Present);
        self.push("Present settings".to_owned(), Origin::Present, model, recordings);
    }

    /// Returns the network or kernel calibration in the list that was trained with the present recordings and settings.
    pub(super) fn trained(&self, project: &Project) -> Option<&Arc<Calibration>> {
        let holds = |row: &&Row| !row.is_stale(project) && row.model.settings == project.settings;
        self.rows.iter().filter(holds).rev().find_map(|row| row.model.trained.as_ref())
    }

    /// Returns the table of all models with their cost, and with their errors on these kinds of samples (such as test
    /// samples).
    pub fn table(&self, project: &Project, sets: &[ScoreSet]) -> Table {
        let rows = self.rows.iter().map(|row| ModelRow {
            mark: if row.is_stale(project) {
                Cell::words("others").about(
                    "Stale: fitted to other recordings, roles or groups than the present ones",
                )
            } else {
                row.mark.cell()
            },
            name: &row.name,
            model: &row.model,
        });
        model_table(project.axes(), sets, rows)
    }
}
