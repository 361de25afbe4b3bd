//! The table of regressors side by side: what is ticked, what runs, what came out and whether it still holds.

use std::path::PathBuf;
use std::sync::Arc;

use crate::analysis::{Candidate, ComparedRow, RowEvent, paper_candidates};
use crate::app::{AppState, Effect, Existing, FileContent, Level, Notice};
use crate::calibration::{EpochReport, FitSettings, Learner, Regressor};
use crate::recording::RecordingSet;

/// What concerns the comparison.
#[derive(Clone, Debug)]
pub enum ComparisonCommand {
    /// Tick a row or take the tick away.
    Tick(usize, bool),
    /// Tick all rows or none.
    TickAll(bool),
    /// Fit the ticked rows that have no result that holds.
    Start,
    /// Fit all that the paper compares.
    StartPaper,
    /// Stop.
    Stop,
    /// Something happened to a row of the run that began with this number.
    Heard(u64, usize, Box<RowEvent>),
    /// The run with this number has ended.
    Ended(u64),
    /// Write the results as CSV.
    Save(PathBuf),
}

/// A row of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// What is to be fitted.
    pub candidate: Candidate,
    /// Whether the next run fits it.
    pub ticked: bool,
    /// Whether it is being fitted, and how far its network is.
    pub running: Option<Option<EpochReport>>,
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
    /// Its rows, quick ones first.
    pub rows: Vec<Row>,
    /// The number of the run that is under way.
    pub running: Option<u64>,
    /// The rows of that run, with what they are made of.
    run: Vec<(usize, Outcome)>,
    n_runs: u64,
}

impl Row {
    /// Whether the row has a result that is not what the state would now give.
    #[must_use]
    pub fn is_stale(&self, state: &AppState) -> bool {
        self.outcome.as_ref().is_some_and(|outcome| {
            !(Arc::ptr_eq(&outcome.recordings, &state.recordings)
                && outcome.candidate == self.candidate
                && outcome.settings == shared_settings(&state.settings))
        })
    }

    /// The result, where there is one.
    #[must_use]
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

impl Comparison {
    /// Makes the rows those of `settings`; what was ticked and what came out stays with rows of the same kind.
    pub(super) fn follow(&mut self, settings: &FitSettings) {
        let mut old = std::mem::take(&mut self.rows);
        for candidate in paper_candidates(settings, &Regressor::ALL) {
            let kind = |candidate: &Candidate| {
                (
                    candidate.regressor,
                    candidate.features.has_history(),
                    candidate.features.without_history().blocks,
                    candidate.decimation,
                )
            };
            let same = old
                .iter()
                .position(|row| kind(&row.candidate) == kind(&candidate));
            self.rows.push(match same {
                Some(at) => Row {
                    candidate,
                    ..old.swap_remove(at)
                },
                None => Row {
                    ticked: candidate.regressor.learner().is_none()
                        || candidate.regressor.learner() == Some(Learner::Network)
                            && candidate.decimation > 1,
                    candidate,
                    running: None,
                    outcome: None,
                },
            });
        }
    }

    /// Whether a row is one of the paper's figures.
    fn is_papers(candidate: &Candidate) -> bool {
        candidate.regressor.learner() != Some(Learner::Kernel)
    }
}

impl AppState {
    pub(super) fn apply_comparison(&mut self, command: ComparisonCommand) -> Vec<Effect> {
        match command {
            ComparisonCommand::Tick(at, ticked) => {
                if let Some(row) = self.comparison.rows.get_mut(at) {
                    row.ticked = ticked;
                }
                Vec::new()
            }
            ComparisonCommand::TickAll(ticked) => {
                for row in &mut self.comparison.rows {
                    row.ticked = ticked;
                }
                Vec::new()
            }
            ComparisonCommand::Start => self.start_comparison(),
            ComparisonCommand::StartPaper => {
                for row in &mut self.comparison.rows {
                    row.ticked = Comparison::is_papers(&row.candidate);
                }
                self.start_comparison()
            }
            ComparisonCommand::Stop => match self.comparison.running {
                Some(_) => vec![Effect::StopComparing],
                None => Vec::new(),
            },
            ComparisonCommand::Heard(run, at, event) => {
                if self.comparison.running == Some(run) {
                    self.hear_of_row(at, *event);
                }
                Vec::new()
            }
            ComparisonCommand::Ended(run) => {
                if self.comparison.running == Some(run) {
                    self.comparison.running = None;
                    for row in &mut self.comparison.rows {
                        row.running = None;
                    }
                }
                Vec::new()
            }
            ComparisonCommand::Save(path) => {
                let rows: Vec<ComparedRow> = self
                    .comparison
                    .rows
                    .iter()
                    .filter_map(|row| row.compared().cloned())
                    .collect();
                if rows.is_empty() {
                    self.tell(Notice::new(Level::Error, "There is no row to save yet"));
                    return Vec::new();
                }
                vec![Effect::Write(
                    FileContent::Comparison(rows),
                    path,
                    Existing::Ask,
                )]
            }
        }
    }

    fn start_comparison(&mut self) -> Vec<Effect> {
        if self.comparison.running.is_some() {
            return Vec::new();
        }
        let asked: Vec<usize> = (0..self.comparison.rows.len())
            .filter(|&at| {
                let row = &self.comparison.rows[at];
                row.ticked && (row.compared().is_none() || row.is_stale(self))
            })
            .collect();
        if asked.is_empty() {
            self.tell(Notice::new(
                Level::Info,
                "Every ticked row already has a result that holds",
            ));
            return Vec::new();
        }
        let settings = shared_settings(&self.settings);
        let comparison = &mut self.comparison;
        comparison.n_runs += 1;
        comparison.running = Some(comparison.n_runs);
        comparison.run = asked
            .into_iter()
            .map(|at| {
                let outcome = Outcome {
                    result: Err(String::new()),
                    candidate: comparison.rows[at].candidate.clone(),
                    recordings: Arc::clone(&self.recordings),
                    settings: settings.clone(),
                };
                (at, outcome)
            })
            .collect();
        let run = comparison.run.iter();
        vec![Effect::Compare {
            run: comparison.n_runs,
            recordings: Arc::clone(&self.recordings),
            settings,
            candidates: run.map(|(_, outcome)| outcome.candidate.clone()).collect(),
        }]
    }

    fn hear_of_row(&mut self, at: usize, event: RowEvent) {
        let Comparison { rows, run, .. } = &mut self.comparison;
        let Some((row, outcome)) = run
            .get(at)
            .and_then(|(at, outcome)| Some((rows.get_mut(*at)?, outcome)))
        else {
            return;
        };
        match event {
            RowEvent::Started => row.running = Some(None),
            RowEvent::Epoch(report) => row.running = Some(Some(report)),
            RowEvent::Ended(result) => {
                row.running = None;
                row.outcome = Some(Outcome {
                    result: result.map_err(|error| error.to_string()),
                    ..outcome.clone()
                });
            }
        }
    }
}
