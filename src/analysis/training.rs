//! Networks and kernels: what takes too long for a slider, and runs beside it.
//!
//! Guarantees: test recordings take no part; features are made again in each pass, only a network's samples are kept (in
//! single precision, since it draws them in a new order every epoch).

use std::sync::Arc;

use crate::analysis::dataset::{Dataset, Key};
use crate::analysis::{AnalysisError, Request};
use crate::calibration::kernel::{Kernel, LinearStage, RowBlock, Rows, TakeRows};
use crate::calibration::network::{Network, NetworkError, Samples};
use crate::calibration::{
    Calibration, EpochReport, Learned, LearnedError, Learner, LinearMap, Past, Piece,
    SettingsError, learned_inputs, sample_row,
};
use crate::evaluation::metrics::root_mean;
use crate::features::{Design, FeatureStream};
use crate::progress::{Cancelled, Progress};
use crate::recording::{Entry, Recording, Role};

/// One group of training recordings in so many is held out of a network's training, to say when it was best.
const HELD_OUT: usize = 10;
/// With fewer groups too little would be left to train on.
const FEWEST_GROUPS: usize = 3;
/// A kernel is cross-validated on no more parts than this.
const MAX_PARTS: usize = 10;
/// Rows that are made before they are passed on.
const BLOCK: usize = 128;

/// Fits what `request` asks for, its regressor included; test recordings only score it.
///
/// A network reports after each epoch and, when it is cancelled, keeps the best it had.
///
/// # Errors
/// [`AnalysisError`] where the request cannot be met.
pub fn train(
    request: &Request,
    progress: &Progress,
    on_epoch: &mut dyn FnMut(EpochReport),
) -> Result<Calibration, AnalysisError> {
    let settings = &request.settings;
    settings.validate()?;
    let data = request.datasets.get(&Key::of(request), progress)?;
    let mut calibration = data.blank_calibration(settings)?;
    let past = data.past(&calibration, progress)?;
    let (_, shares) = data.fit(settings.ridge, &past, &mut calibration);
    let Some(learner) = settings.regressor.learner() else {
        return Ok(calibration);
    };
    calibration.regressor = settings.regressor;
    if !settings.regressor.is_hybrid() {
        calibration.compensated = None;
    }
    let design = calibration.design();
    let target = match (&calibration.compensated, learner) {
        (None, _) => Target::Load,
        (Some(_), Learner::Kernel) => Target::AfterStage(LinearStage {
            kinds: design.kinds(),
            known: data.map.standardised(&design),
            shares,
        }),
        (Some(map), Learner::Network) => Target::LeftOver(map),
    };
    let rows = TrainingRows::new(&data, &past, &design, target);
    let mut cv_rmse = None;
    let learned = match learner {
        Learner::Kernel => {
            let found =
                Kernel::fit(&rows, &settings.kernel, progress).map_err(LearnedError::from)?;
            let n = rows.n_samples_in_all() as u64;
            if let Some(own) = &mut calibration.quality.cross_validation {
                own.parts = own.parts.min(MAX_PARTS);
            }
            cv_rmse = found
                .left_out_squares
                .and_then(|squares| root_mean(&squares, n));
            Learned::Kernel(found.kernel)
        }
        Learner::Network => {
            let (train, held_out) = rows.samples(progress)?;
            let held_out = (held_out.n_samples() > 0).then_some(&held_out);
            let trained = Network::train(&train, held_out, &settings.network, progress, on_epoch)
                .map_err(LearnedError::from)?;
            Learned::Network(trained.network)
        }
    };
    calibration.learned = Some(learned);
    // Cancelled or not, what was learned is scored.
    let own = calibration.quality.conventional.clone();
    data.score_applied(&past, &mut calibration);
    calibration.quality.conventional = own;
    calibration.quality.compensated.cv_rmse = cv_rmse;
    Ok(calibration)
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

/// The training recordings as rows of features and of what is left to learn.
struct TrainingRows<'a> {
    design: &'a Design,
    target: Target<'a>,
    runs: Vec<Run<'a>>,
    n_axes: usize,
}

/// What is learned.
enum Target<'a> {
    /// The load itself.
    Load,
    /// What this linear calibration leaves over.
    LeftOver(&'a LinearMap),
    /// What a linear fit leaves over that goes with the learner, into every fold; the rows bring its columns, and as
    /// targets what the conventional calibration leaves over.
    AfterStage(LinearStage),
}

struct Run<'a> {
    recording: &'a Arc<Recording>,
    past: &'a Past,
    /// Conventional loads.
    conventional: &'a [f64],
    pieces: Vec<Piece>,
}

impl<'a> TrainingRows<'a> {
    fn new(data: &'a Dataset, past: &'a [Past], design: &'a Design, target: Target<'a>) -> Self {
        let entries = data.entries.iter().zip(past).zip(&data.loads);
        let runs: Vec<Run<'_>> = (entries.zip(data.pieces()))
            .filter(|(((entry, _), _), _)| entry.role == Role::Train)
            .map(
                |(((Entry { recording, .. }, past), conventional), pieces)| Run {
                    recording,
                    past,
                    conventional,
                    pieces,
                },
            )
            .collect();
        Self {
            design,
            target,
            n_axes: runs.first().map_or(0, |run| run.recording.axes().len()),
            runs,
        }
    }

    fn n_samples_in_all(&self) -> usize {
        self.runs.iter().map(|run| run.recording.n_samples()).sum()
    }

    /// What a network trains on, and what is held out to say when it was best: whole groups of recordings, or with few of
    /// them the last tenth of all samples.
    fn samples(&self, progress: &Progress) -> Result<(Samples, Samples), AnalysisError> {
        let (n_inputs, n_axes) = self.widths();
        let mut train = Samples::new(n_inputs, n_axes);
        let mut held_out = Samples::new(n_inputs, n_axes);
        let n = self.n_samples_in_all();
        train.reserve(n);
        let pieces = self.runs.iter().flat_map(|run| &run.pieces);
        let n_folds = pieces.map(|piece| piece.fold + 1).max().unwrap_or(0);
        let are_whole = self.runs.iter().all(|run| run.pieces.len() == 1);
        let by_group = are_whole && n_folds >= FEWEST_GROUPS;
        let mut at = 0;
        for run in 0..self.runs.len() {
            progress.check()?;
            let mut pushed = Ok(());
            self.pass(run, &mut |block| {
                if pushed.is_err() {
                    return;
                }
                let fold = self.runs[run].pieces[0].fold;
                let is_held_out = match by_group {
                    true => fold % HELD_OUT == HELD_OUT / 2 || n_folds < HELD_OUT && fold == 1,
                    false => at >= n - n / HELD_OUT,
                };
                let samples = if is_held_out {
                    &mut held_out
                } else {
                    &mut train
                };
                pushed = samples.push_rows(block.inputs, block.targets);
                at += block.targets.len() / n_axes;
            });
            pushed?;
        }
        Ok((train, held_out))
    }
}

impl Rows for TrainingRows<'_> {
    fn n_runs(&self) -> usize {
        self.runs.len()
    }

    fn n_samples(&self, run: usize) -> usize {
        self.runs[run].recording.n_samples()
    }

    fn widths(&self) -> (usize, usize) {
        let n_inputs = self.design.n_columns() - usize::from(self.design.offset);
        (n_inputs, self.n_axes)
    }

    fn linear_stage(&self) -> Option<&LinearStage> {
        match &self.target {
            Target::AfterStage(stage) => Some(stage),
            Target::Load | Target::LeftOver(_) => None,
        }
    }

    fn pass(&self, run: usize, take: TakeRows<'_>) {
        let Run {
            recording,
            past,
            conventional,
            pieces,
        } = &self.runs[run];
        let mut stream = FeatureStream::new(self.design);
        let mut raw = vec![0.0; self.design.n_columns()];
        let (mut inputs, mut linear, mut targets) = (Vec::new(), Vec::new(), Vec::new());
        let mut known = vec![0.0; self.n_axes];
        for piece in pieces {
            for start in piece.samples.clone().step_by(BLOCK) {
                inputs.clear();
                linear.clear();
                targets.clear();
                for k in start..(start + BLOCK).min(piece.samples.end) {
                    sample_row(&mut stream, recording, |at| past[at][k], k, &mut raw);
                    learned_inputs(self.design, &raw, &mut inputs);
                    let of_sample = k * self.n_axes..(k + 1) * self.n_axes;
                    match &self.target {
                        Target::Load => {}
                        Target::LeftOver(map) => map.apply(&raw, &mut known),
                        Target::AfterStage(_) => {
                            self.design.standardise(&mut raw);
                            linear.extend(&raw);
                            known.copy_from_slice(&conventional[of_sample.clone()]);
                        }
                    }
                    let loads = recording.loads()[of_sample].iter();
                    targets.extend(loads.zip(&known).map(|(load, known)| load - known));
                }
                take(RowBlock {
                    fold: piece.fold % MAX_PARTS,
                    inputs: &inputs,
                    linear: &linear,
                    targets: &targets,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::{FitSettings, KernelSettings, Regressor};
    use crate::features::{Blocks, FeatureSettings, Polynomial};
    use crate::random::Random;
    use crate::recording::{Axis, RecordingSet, Source};

    /// Five recordings of noise: with many monomials the linear stage learns them by heart, and what it leaves over of a
    /// recording that it has seen is far too small.
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
            set.push(Entry {
                recording,
                role,
                group: None,
            })
            .unwrap();
        }
        let set = Arc::new(set);
        let scores = |regressor| {
            let settings = FitSettings {
                features: FeatureSettings {
                    blocks: Blocks::default().with(&Polynomial, &[2.0]),
                    ..FeatureSettings::present()
                },
                regressor,
                kernel: KernelSettings {
                    landmarks: 20,
                    length_scale: Some(1.0),
                },
                ..FitSettings::default()
            };
            let request = Request::fit(Arc::clone(&set), settings);
            let quality = train(&request, &Progress::default(), &mut |_| {})
                .unwrap()
                .quality;
            let compensated = quality.compensated;
            (
                compensated.train_rmse.unwrap()[0],
                compensated.cv_rmse.unwrap()[0],
            )
        };
        let (by_heart, linear) = scores(Regressor::Linear);
        let (_, hybrid) = scores(Regressor::HybridKernel);
        assert!(by_heart < 0.8 && linear > 1.3, "{by_heart} {linear}");
        assert!((hybrid / linear - 1.0).abs() < 0.2, "{hybrid} {linear}");
    }
}
