//! Choosing thresholds: the map over both, what the present pair touches, and what is suggested.

use std::path::PathBuf;
use std::sync::Arc;

use crate::analysis::{BlockSuggestion, HistoryBlock};
use crate::app::{AppState, Effect, Existing, FileContent, Level, Notice, Pane};
use crate::calibration::FitSettings;
use crate::evaluation::mean_hysteresis::MeanHysteresis;
use crate::evaluation::threshold_study::{Measure, PointScores, ThresholdMap, Touch};
use crate::features::Thresholds;
use crate::recording::RecordingSet;

/// What concerns the study.
#[derive(Clone, Debug)]
pub enum StudyCommand {
    /// Show this measure.
    Show(Measure),
    /// Set the thresholds of the first look-back.
    Set(Thresholds),
    /// Set them to the minimum over left-out recordings.
    TakeSuggestion,
    /// Set F_th to the mean hysteresis.
    TakeHysteresis,
    /// Choose a block's numbers by leave-one-out.
    Choose(HistoryBlock),
    /// They are chosen.
    Chosen(Result<BlockSuggestion, String>),
    /// Something came of the request with this number.
    Heard(u64, StudyNews),
    /// Write the map and its curves: .csv or .svg.
    Save(PathBuf),
}

/// What comes of a study, piece by piece.
#[derive(Clone, Debug)]
pub enum StudyNews {
    /// What the present thresholds touch, and the mean hysteresis.
    Touched(Touch, MeanHysteresis),
    /// The map without its rows.
    Laid(Arc<ThresholdMap>),
    /// The scores of one F_th.
    Row(usize, Vec<PointScores>),
    /// It cannot be made.
    Failed(String),
}

/// A request to the study.
#[derive(Clone, Debug)]
pub struct StudyRequest {
    /// Its number.
    pub run: u64,
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// The choices of the fit, the first look-back's thresholds set to a fixed pair.
    pub settings: FitSettings,
    /// The present thresholds.
    pub thresholds: Thresholds,
    /// Whether the map is wanted, or only what the thresholds touch.
    pub with_map: bool,
}

/// The study as far as it is.
#[derive(Clone, Debug, Default)]
pub struct ThresholdStudy {
    /// The map; rows that have not come yet are missing.
    pub map: Option<Arc<ThresholdMap>>,
    /// What the present thresholds touch.
    pub touch: Option<Touch>,
    /// The mean hysteresis of the training recordings.
    pub hysteresis: Option<MeanHysteresis>,
    /// Why there is no map.
    pub problem: Option<String>,
    /// What is shown, if it was chosen.
    pub measure: Option<Measure>,
    /// The block whose numbers are being chosen.
    pub choosing: Option<HistoryBlock>,
    /// What was chosen last.
    pub chosen: Option<BlockSuggestion>,
    /// What the map is of.
    of: Option<(Arc<RecordingSet>, FitSettings)>,
    touched: Option<Thresholds>,
    run: u64,
}

impl ThresholdStudy {
    /// The measure that is shown.
    #[must_use]
    pub fn shown_measure(&self) -> Option<Measure> {
        let scale = &self.map.as_ref()?.scale;
        let chosen = self
            .measure
            .filter(|measure| measure.weights(scale).is_some());
        Some(chosen.unwrap_or_else(|| scale.default_measure()))
    }
}

/// The settings without what the map varies.
fn fixed_settings(settings: &FitSettings) -> FitSettings {
    let mut settings = settings.clone();
    let default = Thresholds::default_for(settings.features.distance);
    match settings.features.look_backs.first_mut() {
        Some(first) => *first = default,
        None => settings.features.look_backs.push(default),
    }
    settings
}

impl AppState {
    /// The thresholds of the first look-back, or what they would begin with.
    #[must_use]
    pub fn thresholds(&self) -> Thresholds {
        let features = &self.settings.features;
        let distance = features.distance.effective(self.axes());
        let first = features.look_backs.first().copied();
        first.unwrap_or_else(|| Thresholds::default_for(distance))
    }

    /// Asks for what the pane lacks, while it is shown.
    pub(super) fn follow_study(&mut self) -> Option<Effect> {
        if !self.on_screen.contains(&Pane::Thresholds) || self.recordings.entries().is_empty() {
            return None;
        }
        let settings = fixed_settings(&self.settings);
        let thresholds = self.thresholds();
        let study = &mut self.study;
        let same = study.of.as_ref().is_some_and(|(recordings, own)| {
            Arc::ptr_eq(recordings, &self.recordings) && *own == settings
        });
        let complete =
            study.problem.is_some() || study.map.as_ref().is_some_and(|map| map.is_complete());
        let with_map = !same || !complete;
        if !with_map && study.touched == Some(thresholds) {
            return None;
        }
        if !same {
            study.map = None;
            study.problem = None;
            study.hysteresis = None;
        }
        study.run += 1;
        study.of = Some((Arc::clone(&self.recordings), settings.clone()));
        study.touched = Some(thresholds);
        Some(Effect::Study(StudyRequest {
            run: study.run,
            recordings: Arc::clone(&self.recordings),
            settings,
            thresholds,
            with_map,
        }))
    }

    pub(super) fn apply_study(&mut self, command: StudyCommand) -> Vec<Effect> {
        match command {
            StudyCommand::Show(measure) => {
                self.study.measure = Some(measure);
                Vec::new()
            }
            StudyCommand::Set(thresholds) => self.set_thresholds(thresholds),
            StudyCommand::TakeSuggestion => {
                let suggestion = self.study.map.as_ref().zip(self.study.shown_measure());
                match suggestion.map(|(map, measure)| map.suggestion(measure)) {
                    Some(Ok(suggestion)) => self.set_thresholds(suggestion.thresholds),
                    Some(Err(reason)) => {
                        self.tell(Notice::new(Level::Error, reason.to_string()));
                        Vec::new()
                    }
                    None => Vec::new(),
                }
            }
            StudyCommand::TakeHysteresis => {
                match self.study.hysteresis.as_ref().and_then(|found| found.value) {
                    Some(f_th) => self.set_thresholds(Thresholds {
                        f_th,
                        ..self.thresholds()
                    }),
                    None => Vec::new(),
                }
            }
            StudyCommand::Choose(block) => {
                if self.study.choosing.is_some() {
                    return Vec::new();
                }
                self.study.choosing = Some(block);
                vec![Effect::ChooseBlock {
                    block,
                    measure: self.study.shown_measure(),
                    recordings: Arc::clone(&self.recordings),
                    settings: self.settings.clone(),
                }]
            }
            StudyCommand::Chosen(result) => {
                self.study.choosing = None;
                match result {
                    Ok(chosen) => self.take_chosen(chosen),
                    Err(error) => {
                        self.tell(Notice::new(Level::Error, error));
                        Vec::new()
                    }
                }
            }
            StudyCommand::Heard(run, news) => {
                if run == self.study.run {
                    self.hear_of_study(news);
                }
                Vec::new()
            }
            StudyCommand::Save(path) => match (&self.study.map, self.study.shown_measure()) {
                (Some(map), Some(measure)) => {
                    let content = FileContent::Thresholds(Arc::clone(map), measure);
                    vec![Effect::Write(content, path, Existing::Ask)]
                }
                _ => {
                    self.tell(Notice::new(Level::Error, "There is no map to save yet"));
                    Vec::new()
                }
            },
        }
    }

    fn set_thresholds(&mut self, thresholds: Thresholds) -> Vec<Effect> {
        let mut settings = self.settings.clone();
        match settings.features.look_backs.split_first_mut() {
            Some((first, others)) => {
                *first = thresholds;
                for other in others {
                    other.t_th_secs = thresholds.t_th_secs;
                }
            }
            None => settings.features.look_backs.push(thresholds),
        }
        self.set_settings(settings)
    }

    fn take_chosen(&mut self, chosen: BlockSuggestion) -> Vec<Effect> {
        let mut settings = self.settings.clone();
        let blocks = &mut settings.features.blocks;
        blocks.set(chosen.block, chosen.values.clone());
        self.study.chosen = Some(chosen);
        self.set_settings(settings)
    }

    fn hear_of_study(&mut self, news: StudyNews) {
        let study = &mut self.study;
        match news {
            StudyNews::Touched(touch, hysteresis) => {
                study.touch = Some(touch);
                study.hysteresis = Some(hysteresis);
            }
            StudyNews::Laid(map) => {
                study.map = Some(map);
                study.problem = None;
            }
            StudyNews::Row(f_at, points) => {
                if let Some(map) = &mut study.map {
                    Arc::make_mut(map).set_row(f_at, points);
                }
            }
            StudyNews::Failed(problem) => study.problem = Some(problem),
        }
    }
}
