//! Comparison of regressors and features as in Figures 9, 10, 12 and 13 of the paper of Koike et al. (2019), with further
//! regressors.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use serde::Serialize;

use crate::{
    calibration::{FitSettings, Learner, Regressor},
    features::{Blocks, FeatureSettings, Polynomial},
    panicked::{caught, locked},
    progress::Progress,
    questions::{
        error::AnalysisError,
        models::{
            best::{Best, Tried},
            cross_validated::{cross_validation_cost, side_by_side},
            learning::TrainingStep,
            table::{Model, pattern},
            training::train,
        },
        request::Request,
    },
    recording::{RecordingSet, Role},
};

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    pub regressor: Regressor,
    pub features: FeatureSettings,
    /// Decimation: 1 is pattern A of the paper of Koike et al. (2019), 10 is its pattern B.
    pub decimation: usize,
    /// True if only the recordings of the first load programme are used for training. This pattern is not in the paper of
    /// Koike et al. (2019).
    pub few_trajectories: bool,
}

impl Candidate {
    /// Returns the name of the amount of training data: A or B as in the paper of Koike et al. (2019), or C for recordings of
    /// one load programme.
    pub fn pattern(&self) -> String {
        match (self.few_trajectories, self.decimation) {
            (false, step) => pattern(step),
            (true, 10) => "C".to_owned(),
            (true, step) => format!("C, 1/{step}"),
        }
    }

    /// Returns the description of the features, or "none".
    pub fn history(&self) -> String {
        let blocks = self.features.describe();
        if blocks.is_empty() { "none".to_owned() } else { blocks }
    }
}

/// Fitted model or the error of its fit; `None` before the end of the fit.
pub type Outcome = Option<Result<Model, AnalysisError>>;

/// Request to fit and compare candidates.
#[derive(Clone, Debug)]
pub struct Comparison {
    pub recordings: Arc<RecordingSet>,
    /// Settings that all candidates of the comparison share.
    pub settings: FitSettings,
    pub candidates: Vec<Candidate>,
}

impl Comparison {
    /// Returns the fitted candidates as rows of the list of models.
    pub fn tried(&self, outcomes: &[Outcome]) -> Best {
        let mut best = Best::default();
        for (at, (candidate, outcome)) in self.candidates.iter().zip(outcomes).enumerate() {
            let name = candidate.regressor.label();
            match outcome {
                Some(Ok(model)) => {
                    let mut row = Tried::new(name, candidate.history(), model.clone(), Vec::new());
                    (row.at, row.data) = (at, candidate.pattern());
                    best.tried.push(row);
                }
                Some(Err(error)) => {
                    let name = format!("{name}, {}", candidate.history());
                    best.failed.push((name, error.to_string()));
                }
                None => {}
            }
        }
        best
    }
}

/// Returns the candidates of a comparison: each regressor without and with the features of `settings`, for each amount of
/// training data that the recordings allow. A polynomial of the present gauges is added for the linear regressor. Candidates
/// that are quick to fit come first.
pub fn paper_candidates(
    recordings: &RecordingSet,
    settings: &FitSettings,
    regressors: &[Regressor],
) -> Vec<Candidate> {
    let history = match settings.features.has_history() {
        true => settings.features.clone(),
        false => {
            FeatureSettings { distance: settings.features.distance, ..FeatureSettings::default() }
        }
    };
    let polynomial = FeatureSettings {
        blocks: Blocks::default().with(&Polynomial, &[2.0]),
        distance: history.distance,
        ..FeatureSettings::present()
    };
    let (is_static, has_few) = (recordings.is_static(), few_trajectories(recordings).is_some());
    let mut candidates = Vec::new();
    for &regressor in regressors {
        let mut blocks = vec![history.without_history(), history.clone()];
        if regressor == Regressor::Linear && history.blocks.of(&Polynomial).is_empty() {
            blocks.insert(1, polynomial.clone());
        }
        blocks.retain(|features| !is_static || !features.has_history());
        for features in blocks {
            for (decimation, few_trajectories) in [(10, true), (10, false), (1, false)] {
                if has_few || !few_trajectories {
                    let features = features.clone();
                    let own = Candidate { regressor, features, decimation, few_trajectories };
                    candidates.push(own);
                }
            }
        }
    }
    candidates.sort_by_key(|own| {
        let learns = own.regressor.learner().is_some();
        (learns, learns && own.decimation == 1, own.few_trajectories)
    });
    candidates
}

/// Returns the recordings with only the first group in the train role. Returns `None` for fewer than two groups, or if the first
/// group has only one recording.
fn few_trajectories(recordings: &RecordingSet) -> Option<RecordingSet> {
    let groups = recordings.groups();
    let training = recordings.entries().iter().zip(&groups.of).enumerate();
    let training = training.filter(|(_, (entry, _))| entry.role == Role::Train);
    let training: Vec<(usize, usize)> = training.map(|(at, (_, group))| (at, *group)).collect();
    let (_, first) = *training.first()?;
    let (own, others): (Vec<_>, Vec<_>) = (training.iter()).partition(|(_, group)| *group == first);
    let mut few = recordings.clone();
    for (at, _) in &others {
        few.set_role(*at, Role::Off);
    }
    (own.len() > 1 && !others.is_empty()).then_some(few)
}

/// Fits and scores the candidates, two at a time. `show` receives all outcomes after each fit. A cancelled fit has no outcome.
pub fn compare(
    asked: &Comparison,
    progress: &Progress,
    show: &(dyn Fn(&[Outcome]) + Sync),
) -> Vec<Outcome> {
    let Comparison { settings, candidates, .. } = asked;
    for candidate in candidates {
        progress.add_total(candidate.weight(settings));
    }
    let outcomes = Mutex::new(vec![None; candidates.len()]);
    side_by_side(candidates.len(), progress, |at| {
        let one = || compare_one(&asked.recordings, settings, &candidates[at], progress);
        let found = caught(one).unwrap_or_else(|panicked| Err(panicked.into()));
        if !matches!(found, Err(AnalysisError::Cancelled(_))) {
            let mut outcomes = locked(&outcomes);
            outcomes[at] = Some(found);
            show(&outcomes);
        }
    });
    outcomes.into_inner().unwrap_or_else(PoisonError::into_inner)
}

impl Candidate {
    pub fn settings(&self, common: &FitSettings) -> FitSettings {
        FitSettings {
            regressor: self.regressor,
            features: self.features.clone(),
            decimation: self.decimation,
            ..common.clone()
        }
    }

    fn weight(&self, settings: &FitSettings) -> u64 {
        let passes = match self.regressor.learner() {
            None => 1,
            Some(Learner::Kernel) => 50,
            Some(Learner::Network) => settings.network.epochs as u64,
        };
        let settings = self.settings(settings);
        let passes = 1000.0 * passes as f64 * (1.0 + cross_validation_cost(&settings));
        (passes / self.decimation.max(1) as f64).max(1.0) as u64
    }
}

fn compare_one(
    recordings: &Arc<RecordingSet>,
    settings: &FitSettings,
    candidate: &Candidate,
    progress: &Progress,
) -> Result<Model, AnalysisError> {
    let start = Instant::now();
    let recordings = match candidate.few_trajectories {
        true => Arc::new(
            few_trajectories(recordings)
                .expect("this candidate exists only for recordings with several groups"),
        ),
        false => Arc::clone(recordings),
    };
    let request = Request::fit(recordings, candidate.settings(settings));
    let weight = candidate.weight(settings);
    let training = 1.0 / (1.0 + cross_validation_cost(&request.settings));
    let mut counted = 0;
    let calibration = train(&request, &progress.part(), &mut |step| {
        let done = match step {
            TrainingStep::Epoch(_) => step.done() * training,
            TrainingStep::CrossValidation { .. } => training + step.done() * (1.0 - training),
        };
        let done = ((weight as f64 * done) as u64).clamp(counted, weight);
        progress.advance(done - counted);
        counted = done;
    })?;
    // A network whose training was cancelled is no result of the comparison.
    progress.check()?;
    progress.advance(weight - counted);
    Ok(Model {
        seconds: Some(start.elapsed().as_secs_f64()),
        ..Model::fitted(request.settings, &Arc::new(calibration), &request.recordings)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::{KernelSettings, NetworkSettings};
    use crate::recording::{Entry, simulated};

    fn quick() -> (Arc<RecordingSet>, FitSettings) {
        let mut set = RecordingSet::default();
        for entry in simulated::recordings(3).entries().iter().step_by(9) {
            set.push(Entry { recording: Arc::new(entry.recording.decimated(5)), ..entry.clone() })
                .unwrap();
        }
        let settings = FitSettings {
            network: NetworkSettings { hidden: vec![4], epochs: 3, ..NetworkSettings::default() },
            kernel: KernelSettings { landmarks: 10, length_scale: Some(1.0) },
            ..FitSettings::default()
        };
        (Arc::new(set), settings)
    }

    #[test]
    fn every_row_of_the_whole_comparison_is_fitted() {
        let (set, settings) = quick();
        let candidates = paper_candidates(&set, &settings, &Regressor::ALL);
        assert_eq!(candidates.len(), 33);
        let progress = Progress::default();
        let asked = Comparison { recordings: Arc::clone(&set), settings, candidates };
        let outcomes = compare(&asked, &progress, &|_| {});
        assert_eq!(progress.fraction(), Some(1.0));
        let rows = asked.tried(&outcomes).tried;
        assert!(rows.iter().map(|row| row.at).eq(0..33), "{rows:?}");
        let Comparison { candidates, settings, .. } = asked;
        for (candidate, row) in candidates.iter().zip(rows) {
            let row = row.model;
            assert_eq!(row.settings, candidate.settings(&settings));
            let rmse = row.scores.test_rmse.unwrap();
            assert!(rmse.iter().all(|rmse| *rmse > 0.0 && rmse.is_finite()));
            let all = few_trajectories(&set).unwrap();
            let few = all.entries().iter().filter(|entry| entry.role == Role::Train);
            let few: usize = few.map(|entry| entry.recording.decimated(10).n_samples()).sum();
            assert_eq!(row.n_train == few as u64, candidate.few_trajectories);
            assert_eq!(
                row.scores.cv_rmse.is_none(),
                candidate.regressor.learner() == Some(Learner::Network)
            );
        }
    }

    #[test]
    fn few_trajectories_are_the_first_of_several_programmes_that_are_repeated() {
        let built_in = simulated::recordings(3);
        let few = few_trajectories(&built_in).unwrap();
        let of_role = |role| few.entries().iter().filter(move |entry| entry.role == role);
        assert_eq!((of_role(Role::Train).count(), of_role(Role::Test).count()), (15, 15));
        assert!(of_role(Role::Train).all(|entry| entry.recording.name().contains("path1_")));
        let mut single = RecordingSet::default();
        for entry in built_in.entries().iter().step_by(15) {
            single.push(entry.clone()).unwrap();
        }
        assert!(few_trajectories(&single).is_none());
    }

    #[test]
    fn a_cancelled_comparison_begins_no_further_row() {
        let (set, settings) = quick();
        let candidates = paper_candidates(&set, &settings, &[Regressor::Linear]);
        let progress = Progress::default();
        progress.cancel();
        let asked = Comparison { recordings: set, settings, candidates };
        compare(&asked, &progress, &|outcomes| panic!("{outcomes:?}"));
    }

    #[test]
    fn a_row_that_cannot_be_fitted_says_why() {
        let (set, mut settings) = quick();
        settings.kernel.landmarks = 1_999;
        let candidate = Candidate {
            regressor: Regressor::Kernel,
            features: FeatureSettings::present(),
            decimation: 100,
            few_trajectories: false,
        };
        let asked = Comparison { recordings: set, settings, candidates: vec![candidate] };
        let outcomes = compare(&asked, &Progress::default(), &|_| {});
        let [(name, why)] = &asked.tried(&outcomes).failed[..] else { panic!("{outcomes:?}") };
        assert!(name.ends_with("none") && why.contains("1999 landmarks"), "{name}: {why}");
    }
}
