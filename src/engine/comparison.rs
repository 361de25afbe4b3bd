//! The table of regressors side by side: what is ticked, what runs, what came out and whether it still holds.

use std::sync::Arc;

use crate::analysis::{Candidate, ComparedRow, TrainingStep, paper_candidates};
use crate::calibration::{FitSettings, Learner, Regressor};
use crate::engine::Project;
use crate::engine::questions::{Compare, RowState};
use crate::recording::RecordingSet;

/// A row of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// What is to be fitted.
    pub candidate: Candidate,
    /// Whether the next run fits it.
    pub ticked: bool,
    /// Whether it is being fitted, and how far it is.
    pub running: Option<Option<TrainingStep>>,
    /// What came out of the last run, with what it was made of.
    pub outcome: Option<Outcome>,
}

/// What came out of a row.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The row, or why there is none.
    pub result: Result<ComparedRow, String>,
    candidate: Candidate,
    recordings: Arc<RecordingSet>,
    settings: FitSettings,
}

/// The whole table.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// Its rows, quick ones first; no two are of the same kind.
    pub rows: Vec<Row>,
}

impl Row {
    /// Whether the row has a result that is not what the state would now give.
    pub fn is_stale(&self, project: &Project) -> bool {
        self.outcome.as_ref().is_some_and(|outcome| {
            !(Arc::ptr_eq(&outcome.recordings, &project.recordings)
                && outcome.candidate == self.candidate
                && outcome.settings == shared_settings(&project.settings))
        })
    }

    /// The result, where there is one.
    pub fn compared(&self) -> Option<&ComparedRow> {
        self.outcome.as_ref()?.result.as_ref().ok()
    }
}

/// What all rows have in common; the rest is the candidate's.
fn shared_settings(settings: &FitSettings) -> FitSettings {
    FitSettings {
        features: Default::default(),
        regressor: Regressor::Linear,
        decimation: 1,
        ..settings.clone()
    }
}

/// What tells a row from the others, whatever the numbers of its blocks are.
fn kind(candidate: &Candidate) -> impl PartialEq + use<> {
    (
        candidate.regressor,
        candidate.features.has_history(),
        candidate.features.without_history().blocks,
        (candidate.decimation, candidate.few_trajectories),
    )
}

impl Comparison {
    /// Makes the rows those of `settings`; what was ticked and what came out stays with rows of the same kind.
    pub(super) fn follow(&mut self, settings: &FitSettings) {
        let mut old = std::mem::take(&mut self.rows);
        for candidate in paper_candidates(settings, &Regressor::ALL) {
            let same = old
                .iter()
                .position(|row| kind(&row.candidate) == kind(&candidate));
            self.rows.push(match same {
                Some(at) => Row {
                    candidate,
                    ..old.swap_remove(at)
                },
                None => Row {
                    ticked: !candidate.few_trajectories
                        && (candidate.regressor.learner().is_none()
                            || candidate.regressor.learner() == Some(Learner::Network)
                                && candidate.decimation > 1),
                    candidate,
                    running: None,
                    outcome: None,
                },
            });
        }
    }

    /// Ticks the rows that the paper compares, and no others.
    pub fn tick_paper(&mut self) {
        for row in &mut self.rows {
            row.ticked = row.candidate.regressor.learner() != Some(Learner::Kernel)
                && !row.candidate.few_trajectories;
        }
    }

    /// What fits the ticked rows that have no result that holds; `None` without any.
    pub(super) fn to_run(&self, project: &Project) -> Option<Compare> {
        let lacks = |row: &&Row| row.compared().is_none() || row.is_stale(project);
        let asked = self.rows.iter().filter(|row| row.ticked).filter(lacks);
        let candidates: Vec<Candidate> = asked.map(|row| row.candidate.clone()).collect();
        (!candidates.is_empty()).then(|| Compare {
            recordings: Arc::clone(&project.recordings),
            settings: shared_settings(&project.settings),
            candidates,
        })
    }

    /// Takes how far the rows of a run are.
    pub(super) fn take(&mut self, asked: &Compare, states: &[RowState], is_running: bool) {
        for (candidate, state) in asked.candidates.iter().zip(states) {
            let mut rows = self.rows.iter_mut();
            // The settings may have become others meanwhile.
            let Some(row) = rows.find(|row| kind(&row.candidate) == kind(candidate)) else {
                continue;
            };
            row.running = match state {
                RowState::Runs(step) if is_running => Some(*step),
                _ => None,
            };
            if let RowState::Ended(result) = state {
                row.outcome = Some(Outcome {
                    result: result.clone(),
                    candidate: candidate.clone(),
                    recordings: Arc::clone(&asked.recordings),
                    settings: asked.settings.clone(),
                });
            }
        }
    }
}
