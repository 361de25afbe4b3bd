//! A network or a kernel that is trained apart, since it takes longer than a slider may wait.

use std::sync::Arc;

use crate::analysis::{Request, View};
use crate::app::{AppState, Effect, Level, Notice};
use crate::calibration::{Calibration, EpochReport, FitSettings};
use crate::recording::RecordingSet;

/// What concerns training.
#[derive(Clone, Debug)]
pub enum TrainingCommand {
    /// Train what the settings ask for.
    Start,
    /// Stop; a network keeps the best it had.
    Stop,
    /// A network has passed over its samples once more.
    Epoch(EpochReport),
    /// Training has ended.
    Ended(Result<Arc<Calibration>, String>),
}

/// What a training was asked for with.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// The choices of the fit.
    pub settings: FitSettings,
}

impl Inputs {
    fn of(state: &AppState) -> Self {
        Self {
            recordings: Arc::clone(&state.recordings),
            settings: state.settings.clone(),
        }
    }

    /// Whether the state still asks for the same.
    #[must_use]
    pub fn hold(&self, state: &AppState) -> bool {
        Arc::ptr_eq(&self.recordings, &state.recordings) && self.settings == state.settings
    }
}

/// The training that runs, or the last one.
#[derive(Clone, Debug, Default)]
pub struct Training {
    /// What runs, and whether somebody asked it to stop.
    pub running: Option<(Inputs, bool)>,
    /// The network's reports, epoch by epoch.
    pub epochs: Vec<EpochReport>,
    /// What came out of the last one, with what it was made of.
    pub trained: Option<(Inputs, Arc<Calibration>)>,
}

impl Training {
    /// What was trained for just these recordings and settings.
    #[must_use]
    pub fn fitting(&self, state: &AppState) -> Option<&Arc<Calibration>> {
        let (inputs, calibration) = self.trained.as_ref()?;
        inputs.hold(state).then_some(calibration)
    }
}

impl AppState {
    pub(super) fn apply_training(&mut self, command: TrainingCommand) -> Vec<Effect> {
        match command {
            TrainingCommand::Start => {
                if self.training.running.is_some() || self.settings.regressor.learner().is_none() {
                    return Vec::new();
                }
                let inputs = Inputs::of(self);
                self.training.epochs.clear();
                self.training.running = Some((inputs.clone(), false));
                vec![Effect::Train(Request {
                    view: View::One(0),
                    ..Request::fit(inputs.recordings, inputs.settings)
                })]
            }
            TrainingCommand::Stop => match &mut self.training.running {
                Some((_, stopping)) => {
                    *stopping = true;
                    vec![Effect::StopTraining]
                }
                None => Vec::new(),
            },
            TrainingCommand::Epoch(report) => {
                self.training.epochs.push(report);
                Vec::new()
            }
            TrainingCommand::Ended(result) => {
                let Some((inputs, stopped)) = self.training.running.take() else {
                    return Vec::new();
                };
                match result {
                    Ok(calibration) => {
                        self.training.trained = Some((inputs, calibration));
                        self.analyse()
                    }
                    Err(_) if stopped => Vec::new(),
                    Err(error) => {
                        let error = format!("Training: {error}");
                        self.tell(Notice::new(Level::Error, error));
                        Vec::new()
                    }
                }
            }
        }
    }
}
