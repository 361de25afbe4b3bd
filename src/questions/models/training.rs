//! Training of networks and kernels in the background. Each score is of samples outside the fit.

use crate::calibration::network::NetworkError;
use crate::calibration::{Calibration, Learner, SettingsError};
use crate::progress::{Cancelled, Progress};
use crate::questions::cross_validated::{
    best_shares, cross_validated, cross_validation_steps, part_squares,
};
use crate::questions::error::AnalysisError;
use crate::questions::models::learning::{Fitted, TrainingStep, band, fit_all};
use crate::questions::request::Request;
use crate::scoring::cross_validation::MOST_FITS;
use crate::scoring::part_squares::PartSquares;

#[derive(Clone, Debug)]
pub struct Scored {
    pub calibration: Calibration,
    /// Residuals of the fits without each part; `None` without cross-validation.
    #[cfg_attr(not(test), expect(dead_code, reason = "tests compare the parts"))]
    pub left_out: Option<PartSquares>,
}

/// Fits the request with its regressor. Test recordings are only scored.
///
/// # Errors
/// [`AnalysisError`] if the request cannot be fitted.
pub fn train(
    request: &Request,
    progress: &Progress,
    on_step: &mut dyn FnMut(TrainingStep),
) -> Result<Calibration, AnalysisError> {
    train_and_score(request, progress, on_step).map(|scored| scored.calibration)
}

/// Fits the request with its regressor, and returns also the residuals on each held-out part. Test recordings are only scored.
/// A network reports each epoch and keeps its best one if it is cancelled; a cancelled cross-validation gives no score.
///
/// # Errors
/// [`AnalysisError`] if the request cannot be fitted.
pub fn train_and_score(
    request: &Request,
    progress: &Progress,
    on_step: &mut dyn FnMut(TrainingStep),
) -> Result<Scored, AnalysisError> {
    fit_and_score(request, true, 1, progress, on_step)
}

/// Fits as [`train`] without cross-validation, because the caller holds out samples itself. A network or a kernel is trained on
/// every `row_step`-th sample.
///
/// # Errors
/// [`AnalysisError`] if the request cannot be fitted.
pub(crate) fn train_unscored(
    request: &Request,
    row_step: usize,
    progress: &Progress,
) -> Result<Calibration, AnalysisError> {
    fit_and_score(request, false, row_step, progress, &mut |_| {}).map(|scored| scored.calibration)
}

fn fit_and_score(
    request: &Request,
    scores: bool,
    row_step: usize,
    progress: &Progress,
    on_step: &mut dyn FnMut(TrainingStep),
) -> Result<Scored, AnalysisError> {
    let settings = &request.settings;
    settings.validate()?;
    let data = request.datasets.get(&request.key(), progress)?;
    let steps = match scores {
        true => cross_validation_steps(&data, settings),
        false => 0,
    };
    progress.add_total(steps);
    let fitted = fit_all(&data, settings, row_step, progress, &mut |report| {
        on_step(TrainingStep::Epoch(report));
    })?;
    let Fitted { past, mut calibration, linear, held_out } = fitted;
    let Some(learner) = settings.regressor.learner() else {
        return Ok(Scored { calibration, left_out: linear });
    };
    let is_hybrid = settings.regressor.is_hybrid();
    // A linear stage with too few samples makes the second stage meaningless.
    let moments = match steps > 0 && (linear.is_some() || !is_hybrid) {
        true => cross_validated(&data, &calibration, settings, steps, progress, on_step),
        false => None,
    };
    // A kernel chose its shares in its fit, again in every fold.
    let has_shares = is_hybrid && learner == Learner::Network;
    if let (true, Some(learned)) = (has_shares, &mut calibration.learned) {
        learned.scale(&best_shares(moments.as_ref().unwrap_or(&held_out)));
    }
    let left_out = moments.as_ref().map(|moments| part_squares(moments, has_shares));
    // A cancelled training is scored, too.
    let own = calibration.quality.conventional.clone();
    data.score_applied(&past, &mut calibration);
    calibration.quality.conventional = own;
    if let (true, Some(own)) = (left_out.is_some(), &mut calibration.quality.cross_validation) {
        own.parts = own.parts.min(MOST_FITS);
    }
    calibration.quality.compensated.cv_rmse = left_out.as_ref().and_then(PartSquares::rmse);
    calibration.quality.band = band(&data, &past, &calibration);
    if let Some(moments) = moments {
        let errors = data.left_out_errors_of(&moments, has_shares);
        calibration.quality.expected_error = data.expected_error(&calibration, &past, errors).ok();
    }
    Ok(Scored { calibration, left_out })
}

impl From<NetworkError> for AnalysisError {
    fn from(error: NetworkError) -> Self {
        match error {
            NetworkError::Cancelled => Self::Cancelled(Cancelled),
            error => Self::Learned(error.into()),
        }
    }
}

impl From<crate::features::FeatureError> for AnalysisError {
    fn from(error: crate::features::FeatureError) -> Self {
        Self::Settings(SettingsError::from(error))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibration::{FitSettings, KernelSettings, NetworkSettings, Regressor};
    use crate::features::{Blocks, FeatureSettings, Polynomial};
    use crate::random::Random;
    use crate::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

    /// Five recordings of noise: with many monomials the linear stage fits the noise, so its residual on a recording that it
    /// was fitted to is far too small.
    #[test]
    fn a_hybrid_is_scored_on_recordings_that_neither_stage_has_seen() {
        let mut set = RecordingSet::default();
        for at in 0..5 {
            let mut random = Random::new(7, &[at]);
            let mut normal = |n: usize| (0..n).map(|_| random.normal()).collect::<Vec<f64>>();
            let n = 24;
            let recording = Recording::new(
                format!("r{at}"),
                Source::Simulated,
                (0..n).map(|k| k as f64 * 0.01).collect(),
                (1..=10).map(|gauge| format!("S{gauge}")).collect(),
                normal(10 * n),
                vec![Axis::Fz],
                normal(n),
            );
            let recording = Arc::new(recording.unwrap());
            let role = Role::Train;
            set.push(Entry { recording, role, group: None }).unwrap();
        }
        let set = Arc::new(set);
        let scores = |regressor| {
            let settings = FitSettings {
                features: FeatureSettings {
                    blocks: Blocks::default().with(&Polynomial, &[2.0]),
                    ..FeatureSettings::present()
                },
                regressor,
                kernel: KernelSettings { landmarks: 20, length_scale: Some(1.0) },
                network: NetworkSettings {
                    hidden: vec![10],
                    epochs: 20,
                    cross_validate: true,
                    ..NetworkSettings::default()
                },
                ..FitSettings::default()
            };
            let request = Request::fit(Arc::clone(&set), settings);
            let quality = train(&request, &Progress::default(), &mut |_| {}).unwrap().quality;
            let compensated = quality.compensated;
            (compensated.train_rmse.unwrap()[0], compensated.cv_rmse.unwrap()[0])
        };
        let (by_heart, linear) = scores(Regressor::Linear);
        assert!(by_heart < 0.8 && linear > 1.3, "{by_heart} {linear}");
        for regressor in [Regressor::HybridKernel, Regressor::HybridNetwork] {
            let (train, hybrid) = scores(regressor);
            assert!((hybrid / linear - 1.0).abs() < 0.2, "{hybrid} {linear}");
            // Nothing remains for a second stage, so the linear stage stands alone.
            assert!((train / by_heart - 1.0).abs() < 1e-6, "{train} {by_heart}");
        }
    }
}
