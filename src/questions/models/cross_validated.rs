//! Cross-validates networks, kernels and their combinations with a linear fit: parts of the training recordings are left out
//! in turn, and the complete fit is repeated without each part.
//!
//! Guarantees: no fitted value depends on the left-out part. This applies to the conventional calibration, the look-back
//! (earlier gauge values), the linear fit with its ridge, the standardisation, the landmarks and ridge strengths of the
//! kernel, early stopping, and the share with which the network or kernel is added. Only the full scales, which belong to the
//! sensor, are the same in every fit.

use std::borrow::Borrow;
use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Instant;

use crate::{
    calibration::{
        Calibration, EpochReport, FitSettings, Learner, NetworkSettings, Piece, SHARES, best_share,
    },
    panicked::locked,
    progress::Progress,
    questions::{
        dataset::{Dataset, Datasets},
        error::AnalysisError,
        expected_error::query::step_of,
        models::learning::{Fitted, Moments, TrainingStep, fit_all},
        request::Request,
    },
    recording::{Entry, Role},
    scoring::{
        cross_validation::{Fold, MOST_FITS, fit_without},
        part_squares::PartSquares,
    },
};

/// Ratio of two times: training two networks one after the other, and training both at once.
const GAIN_OF_TWO: f64 = 1.8;

/// Returns the approximate duration of the cross-validation, divided by the duration of the fit; zero if the settings ask for
/// no cross-validation.
pub fn cross_validation_cost(settings: &FitSettings) -> f64 {
    let samples = MOST_FITS as f64 - 1.0; // each fit uses four fifths of the samples
    match settings.regressor.learner() {
        Some(Learner::Kernel) => samples,
        Some(Learner::Network) if settings.network.cross_validate => samples / GAIN_OF_TWO,
        Some(Learner::Network) | None => 0.0,
    }
}

/// Returns the approximate number of steps that the cross-validation adds to the progress of the fit.
pub fn cross_validation_steps(data: &Dataset, settings: &FitSettings) -> u64 {
    let training = data.training();
    let steps = match settings.regressor.learner() {
        Some(Learner::Network) => {
            let samples: usize = training.iter().map(|recording| recording.n_samples()).sum();
            samples.div_ceil(settings.network.batch) * settings.network.epochs
        }
        _ => 10 * training.len(),
    };
    (steps as f64 * cross_validation_cost(settings)) as u64
}

/// Returns, for each axis, the share of the output of a network or kernel that gives the lowest held-out error when it is
/// added to the linear fit. If there are no parts, the list is empty.
pub fn best_shares(parts: &[impl Borrow<Moments>]) -> Vec<f64> {
    let n_axes = parts.first().map_or(0, |part| part.borrow().of_axes.len());
    let share = |axis| {
        let squares = |at: usize, part: usize| parts[part].borrow().squares(axis, SHARES[at]);
        SHARES[best_share(parts.len(), squares)]
    };
    (0..n_axes).map(share).collect()
}

/// Returns, for each part and axis, the share of the output of the network or kernel that is added to the linear fit. If
/// `has_shares` is true, the share for a part is chosen on the parts that other fits leave out. Otherwise all shares are 1.
pub fn part_shares(parts: &[Moments], has_shares: bool) -> Vec<Vec<f64>> {
    let n = parts.len();
    let of_folds: Vec<Vec<f64>> = (0..n.min(MOST_FITS))
        .map(|fold| {
            let others = parts.iter().enumerate();
            let others = others.filter(|(part, _)| fit_without(*part, n) != fold);
            if has_shares {
                best_shares(&others.map(|(_, part)| part).collect::<Vec<_>>())
            } else {
                vec![1.0; parts[0].of_axes.len()]
            }
        })
        .collect();
    (0..n).map(|at| of_folds[fit_without(at, n)].clone()).collect()
}

/// Returns the squared errors of the left-out parts, with the shares from [`part_shares`].
pub fn part_squares(parts: &[Moments], has_shares: bool) -> PartSquares {
    let squares = parts.iter().zip(part_shares(parts, has_shares)).flat_map(|(part, shares)| {
        let shares = shares.into_iter().enumerate();
        shares.map(|(axis, share)| part.squares(axis, share))
    });
    PartSquares {
        squares: squares.collect(),
        part_samples: parts.iter().map(|part| part.n_samples).collect(),
    }
}

/// Returns the residuals of each part of the training recordings, predicted by a fit to the other parts. The whole work
/// counts as `steps` steps of `progress`.
///
/// Returns `None` if the work was cancelled, or if the other parts have too few samples for a fit.
pub fn cross_validated(
    data: &Dataset,
    calibration: &Calibration,
    settings: &FitSettings,
    steps: u64,
    progress: &Progress,
    on_step: &mut (dyn FnMut(TrainingStep) + Send),
) -> Option<Vec<Moments>> {
    let start = Instant::now();
    let training = data.entries.iter().zip(&data.folds.pieces).enumerate();
    let training: Vec<(Entry, &[Piece])> = training
        .filter(|(_, (entry, _))| entry.role == Role::Train)
        .map(|(at, (entry, pieces))| (data.groups.with_group_name(at, entry), &pieces[..]))
        .collect();
    let n_parts = data.folds.n_parts;
    let n_folds = n_parts.min(MOST_FITS);
    if n_folds < 2 {
        return None;
    }
    let step = step_of(data, |entry| entry.role == Role::Train);
    let full_scale = calibration.full_scale.iter();
    let settings = FitSettings {
        decimation: 1, // the recordings are decimated already
        full_scale: full_scale.map(|full| (*full > 0.0).then_some(*full)).collect(),
        network: NetworkSettings { cross_validate: false, ..settings.network.clone() },
        ..settings.clone()
    };
    let all_done = Mutex::new((0.0, on_step));
    let scored = side_by_side(n_folds, progress, |at| {
        let mut own_done = 0.0;
        let mut report = |done: f64| {
            let (all_done, on_step) = &mut *locked(&all_done);
            let before = (*all_done * steps as f64) as u64;
            *all_done += (done - own_done) / n_folds as f64;
            own_done = done;
            progress.advance((*all_done * steps as f64) as u64 - before);
            on_step(TrainingStep::CrossValidation { done: *all_done, elapsed: start.elapsed() });
        };
        let fold = fold_without(&training, |part| fit_without(part, n_parts) == at);
        let scored = fold.score(settings.clone(), step, progress, &mut |epoch| {
            report(TrainingStep::Epoch(epoch).done());
        })?;
        report(1.0);
        Ok::<_, AnalysisError>(scored)
    });
    let scored: Vec<_> = match scored.into_iter().collect::<Result<_, AnalysisError>>() {
        // After a cancellation, the fits are incomplete and give no errors.
        _ if progress.is_cancelled() => return None,
        Ok(scored) => scored,
        Err(error) => {
            log::warn!("cross-validation: {error}");
            return None;
        }
    };
    let mut parts = vec![Moments::new(calibration.axes.len()); n_parts];
    for (part, moments) in scored.into_iter().flatten() {
        let sums = &mut parts[part];
        sums.n_samples += moments.n_samples;
        sums.kept.extend(&moments.kept);
        for (sums, more) in sums.of_axes.iter_mut().zip(&moments.of_axes) {
            for (sum, more) in sums.iter_mut().zip(more) {
                *sum += more;
            }
        }
    }
    Some(parts)
}

/// Returns the training recordings, with the left-out parts in the role of test recordings. A recording with a left-out
/// interval is cut into several recordings. At the start of each, no earlier gauge values are known.
fn fold_without(training: &[(Entry, &[Piece])], is_left_out: impl Fn(usize) -> bool) -> Fold {
    let mut cut: Vec<(Entry, Option<usize>)> = Vec::new();
    for (entry, pieces) in training {
        let mut push = |samples: Range<usize>, part: Option<usize>| {
            if samples.is_empty() {
                return;
            }
            let mut segment = entry.clone();
            if samples.len() < entry.recording.n_samples() {
                segment.recording = Arc::new(entry.recording.segment(samples.clone()));
            }
            cut.push((segment, part));
        };
        let mut kept = 0..0;
        for piece in *pieces {
            if is_left_out(piece.fold) {
                push(std::mem::take(&mut kept), None);
                push(piece.samples.clone(), Some(piece.fold));
            } else if kept.is_empty() {
                kept = piece.samples.clone();
            } else {
                kept.end = piece.samples.end;
            }
        }
        push(kept, None);
    }
    Fold::of(cut.into_iter())
}

impl Fold {
    /// Fits the training recordings, and returns the residuals of each left-out part. Their sums contain all samples, but
    /// only every `step`-th residual is kept in memory.
    fn score(
        self,
        mut settings: FitSettings,
        step: usize,
        progress: &Progress,
        on_epoch: &mut dyn FnMut(EpochReport),
    ) -> Result<Vec<(usize, Moments)>, AnalysisError> {
        // The progress of this fit is not shown, because the caller counts the progress of all fits.
        let progress = &progress.part();
        let n_train = self.set.n_samples(Role::Train);
        settings.kernel.landmarks = settings.kernel.landmarks.min(n_train.max(1));
        let request = Request::fit(self.set, settings);
        let data = Datasets::default().get(&request.key(), progress)?;
        let Fitted { past, mut calibration, .. } =
            fit_all(&data, &request.settings, 1, progress, on_epoch)?;
        let learned = calibration.learned.take();
        let left_out = data.entries.iter().zip(&past);
        let left_out = left_out.filter(|(entry, _)| entry.role == Role::Test);
        let scored = left_out.zip(self.parts).map(|((entry, past), part)| {
            let linear = calibration.compensated_loads(&entry.recording, past);
            calibration.learned.clone_from(&learned);
            let whole = calibration.compensated_loads(&entry.recording, past);
            calibration.learned = None;
            let difference = |of: &[f64]| -> Vec<f64> {
                of.iter().zip(&linear).map(|(of, linear)| of - linear).collect()
            };
            let mut moments = Moments::new(calibration.axes.len());
            let (left_over, added) = (difference(entry.recording.loads()), difference(&whole));
            moments.add(&left_over, &added);
            moments.keep(&left_over, &added, step);
            (part, moments)
        });
        Ok(scored.collect())
    }
}

/// Number of threads of [`side_by_side`]. The fit of a neural network uses only one processor core.
const N_THREADS: usize = 2;

/// Calls `job` with each number of `0..n` on two threads, and returns the results in no particular order. After a
/// cancellation, no further job starts.
pub fn side_by_side<T: Send>(
    n: usize,
    progress: &Progress,
    job: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let work = || {
        let jobs = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        let jobs = jobs.take_while(|at| *at < n && !progress.is_cancelled());
        jobs.map(&job).collect::<Vec<T>>()
    };
    thread::scope(|scope| {
        let threads: Vec<_> = (0..N_THREADS.min(n)).map(|_| scope.spawn(work)).collect();
        let results = threads.into_iter().map(|thread| thread.join());
        results.flat_map(|results| results.unwrap_or_else(|panic| resume_unwind(panic))).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::{KernelSettings, Regressor, RidgeChoice};
    use crate::features::{Blocks, FeatureSettings, Polynomial, Thresholds};
    use crate::questions::models::training::fit_and_score;
    use crate::random::Random;
    use crate::recording::RecordingSet;
    use crate::recording::{Axis, Recording, Source};

    /// Recordings with two axes, a nonlinear gauge and a linear gauge, and noisy loads.
    fn recordings(lengths: &[usize]) -> Vec<Arc<Recording>> {
        let of_length = |(at, &n): (usize, &usize)| {
            let mut random = Random::new(11, &[at as u64]);
            let (mut gauges, mut loads) = (Vec::new(), Vec::new());
            for k in 0..n {
                let (a, b) = ((0.3 * k as f64 + at as f64).sin(), random.normal());
                gauges.extend([a, b]);
                let noise = 0.1 * random.normal();
                loads.extend([2.0 * a + (3.0 * a).cos() + noise, b - 0.4 * a * b]);
            }
            let recording = Recording::new(
                format!("r{at}"),
                Source::Simulated,
                (0..n).map(|k| 0.1 * k as f64).collect(),
                vec!["S1".to_owned(), "S2".to_owned()],
                gauges,
                vec![Axis::Fx, Axis::Fz],
                loads,
            );
            Arc::new(recording.unwrap())
        };
        lengths.iter().enumerate().map(of_length).collect()
    }

    fn settings(regressor: Regressor) -> FitSettings {
        FitSettings {
            features: FeatureSettings {
                look_backs: vec![Thresholds { f_th: 0.5, t_th_secs: 2.0 }],
                blocks: Blocks::default().with(&Polynomial, &[2.0]),
                ..FeatureSettings::present()
            },
            regressor,
            ridge: RidgeChoice::Auto,
            kernel: KernelSettings { landmarks: 12, length_scale: None },
            network: NetworkSettings {
                hidden: vec![5],
                epochs: 6,
                batch: 10,
                cross_validate: true,
                ..NetworkSettings::default()
            },
            ..FitSettings::default()
        }
    }

    fn scored(
        recordings: &[Arc<Recording>],
        tested: Option<usize>,
        settings: &FitSettings,
    ) -> (Calibration, Option<PartSquares>) {
        let mut set = RecordingSet::default();
        for (at, recording) in recordings.iter().enumerate() {
            let mut entry = Entry::with_default_role((**recording).clone());
            entry.role = if tested == Some(at) { Role::Test } else { Role::Train };
            set.push(entry).unwrap();
        }
        let request = Request::fit(Arc::new(set), settings.clone());
        fit_and_score(&request, true, 1, &Progress::default(), &mut |_| {}).unwrap()
    }

    /// The expected scores come from independent fits, each with another recording in the test role.
    #[test]
    fn scores_are_those_of_fits_from_scratch_without_the_part() {
        let recordings = recordings(&[60, 50, 70, 40, 55]);
        for regressor in [Regressor::Kernel, Regressor::HybridKernel, Regressor::Network] {
            let settings = settings(regressor);
            let (whole, left_out) = scored(&recordings, None, &settings);
            let full_scale = whole.full_scale.iter();
            let plain = FitSettings {
                full_scale: full_scale.copied().map(Some).collect(),
                network: NetworkSettings { cross_validate: false, ..settings.network.clone() },
                ..settings
            };
            let left_out = left_out.unwrap();
            assert_eq!(left_out.part_samples, [60, 50, 70, 40, 55]);
            for (at, squares) in left_out.squares.chunks_exact(2).enumerate() {
                let quality = scored(&recordings, Some(at), &plain).0.quality;
                let rmse = quality.compensated.test_rmse.unwrap();
                for (square, rmse) in squares.iter().zip(rmse) {
                    let expected = rmse * rmse * left_out.part_samples[at] as f64;
                    let off = (square / expected - 1.0).abs();
                    assert!(off < 1e-9, "{regressor:?}, part {at}: {square} {expected}");
                }
            }
            let cv_rmse = whole.quality.compensated.cv_rmse;
            assert!(cv_rmse.is_some_and(|cv_rmse| Some(cv_rmse) == left_out.rmse()));
        }
    }

    #[test]
    fn every_regressor_is_scored_on_the_same_parts() {
        for lengths in [&[60, 80][..], &[30, 40, 50, 35, 45, 60, 25]] {
            let recordings = recordings(lengths);
            let parts = |regressor| {
                let left_out = scored(&recordings, None, &settings(regressor)).1.unwrap();
                assert_eq!(left_out.squares.len(), 2 * left_out.part_samples.len());
                left_out.part_samples
            };
            let linear = parts(Regressor::Linear);
            for regressor in Regressor::ALL {
                assert_eq!(parts(regressor), linear, "{regressor:?}");
            }
        }
    }

    #[test]
    fn a_stopped_cross_validation_keeps_the_network_without_a_score() {
        let recordings = recordings(&[60, 50, 70]);
        let mut set = RecordingSet::default();
        for recording in recordings {
            set.push(Entry::with_default_role((*recording).clone())).unwrap();
        }
        let request = Request::fit(Arc::new(set), settings(Regressor::Network));
        let progress = Progress::default();
        let scored = fit_and_score(&request, true, 1, &progress, &mut |step| {
            if matches!(step, TrainingStep::CrossValidation { .. }) {
                progress.cancel();
            }
        });
        let (calibration, left_out) = scored.unwrap();
        assert!(left_out.is_none() && calibration.learned.is_some());
        assert!(calibration.quality.compensated.train_rmse.is_some());
        assert!(calibration.no_cross_validation().is_some());
    }

    /// The second stage is twice as large as the residuals, so each fit chooses a share of one half on the other parts.
    #[test]
    fn the_share_that_scores_a_part_is_chosen_by_the_others() {
        let part = |r: f64, g: f64| {
            let mut moments = Moments::new(1);
            moments.add(&[r], &[g]);
            moments
        };
        let mut parts = vec![part(1.0, 2.0); 9];
        assert_eq!(best_shares(&parts), [0.5]);
        parts.push(part(1.0, -30.0));
        let squares = part_squares(&parts, true);
        // Parts 4 and 9 are left out of the same fit. All other parts prefer a share of one half.
        assert_eq!((squares.squares[4], squares.squares[9]), (0.0, 256.0));
        assert_eq!(squares.squares[0], 1.0);
    }
}
