//! Fits any regressor and scores it on samples outside the fit.

use crate::{
    calibration::{Calibration, NoCrossValidation, Regressor},
    progress::Progress,
    questions::{
        dataset::Dataset,
        error::AnalysisError,
        expected_error::{
            query::{expected_error_of_fit, groups_left_out},
            rule::HeldOutErrors,
        },
        models::{
            cross_validated::{
                best_shares, cross_validated, cross_validation_steps, part_shares, part_squares,
            },
            learning::{Fitted, Moments, TrainingStep, band, fit_all},
        },
        request::Request,
    },
    scoring::{cross_validation::MOST_FITS, part_squares::PartSquares},
};

/// Fits a calibration with the regressor of the request. Test recordings are only used for scores.
///
/// A network reports each epoch of its training. A cancelled network keeps its best epoch. A cancelled cross-validation gives
/// no score.
///
/// # Errors
/// [`AnalysisError`] if the request cannot be fitted.
pub fn train(
    request: &Request,
    progress: &Progress,
    on_step: &mut (dyn FnMut(TrainingStep) + Send),
) -> Result<Calibration, AnalysisError> {
    Ok(fit_and_score(request, true, 1, progress, on_step)?.0)
}

/// Fits as [`train`], and also returns the squared errors of the parts that cross-validation leaves out. `scores` is false if
/// the caller holds out samples itself; the cross-validation is then omitted. A network or a kernel is trained on every
/// `row_step`-th sample.
pub fn fit_and_score(
    request: &Request,
    scores: bool,
    row_step: usize,
    progress: &Progress,
    on_step: &mut (dyn FnMut(TrainingStep) + Send),
) -> Result<(Calibration, Option<PartSquares>), AnalysisError> {
    let settings = &request.settings;
    settings.validate()?;
    let data = request.datasets.get(&request.key(), progress)?;
    let steps = if scores { cross_validation_steps(&data, settings) } else { 0 };
    progress.add_total(steps);
    let fitted = fit_all(&data, settings, row_step, progress, &mut |report| {
        on_step(TrainingStep::Epoch(report));
    })?;
    let Fitted { past, mut calibration, linear, held_out } = fitted;
    if settings.regressor.learner().is_none() {
        return Ok((calibration, linear));
    }
    // If there are too few samples to cross-validate the linear fit, cross-validating the network or kernel after it is
    // meaningless.
    let moments = if steps > 0 && (linear.is_some() || !settings.regressor.is_hybrid()) {
        cross_validated(&data, &calibration, settings, steps, progress, on_step)
    } else {
        None
    };
    // A hybrid kernel chooses the share of its output in each fit, so only a hybrid network gets its share here.
    let has_shares = settings.regressor == Regressor::HybridNetwork;
    if let (true, Some(learned)) = (has_shares, &mut calibration.learned) {
        learned.scale(&best_shares(moments.as_ref().unwrap_or(&held_out)));
    }
    let left_out = moments.as_ref().map(|moments| part_squares(moments, has_shares));
    // A network is scored even if its training was cancelled.
    let conventional = calibration.quality.conventional.clone();
    data.score_applied(&past, &mut calibration);
    calibration.quality.conventional = conventional;
    if let (true, Some(held_out_parts)) =
        (left_out.is_some(), &mut calibration.quality.cross_validation)
    {
        held_out_parts.parts = held_out_parts.parts.min(MOST_FITS);
    }
    calibration.quality.compensated.cv_rmse = left_out.as_ref().and_then(PartSquares::rmse);
    calibration.quality.band = band(&data, &past, &calibration);
    if let Some(moments) = moments {
        let errors = left_out_errors(&data, &moments, has_shares);
        let expected = expected_error_of_fit(&data, &calibration, &past, errors);
        calibration.quality.expected_error = expected.ok();
    }
    Ok((calibration, left_out))
}

/// Returns the held-out errors of a network or a kernel from the residuals of the cross-validation.
fn left_out_errors(
    data: &Dataset,
    parts: &[Moments],
    has_shares: bool,
) -> Result<HeldOutErrors, NoCrossValidation> {
    groups_left_out(data)?;
    let n_axes = parts.first().map_or(0, |part| part.of_axes.len());
    let mut errors = HeldOutErrors::new(n_axes);
    for (group, (part, shares)) in parts.iter().zip(part_shares(parts, has_shares)).enumerate() {
        let kept = part.kept.iter().enumerate();
        let kept = kept.map(|(at, [residual, output])| residual - shares[at % n_axes] * output);
        errors.add(group, kept, 1);
    }
    errors.n_samples = parts.iter().map(|part| part.n_samples).sum();
    Ok(errors)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibration::{FitSettings, KernelSettings, NetworkSettings};
    use crate::features::{Blocks, FeatureSettings, Polynomial};
    use crate::random::Random;
    use crate::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

    /// Five recordings of noise. With many monomials, the linear stage fits the noise, so its residuals on the training
    /// recordings are far too small.
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
