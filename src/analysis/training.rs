//! Networks and kernels: what takes too long for a slider, and runs beside it.
//!
//! Guarantees: test recordings take no part; features are made again in each pass, only a network's samples are kept (in
//! single precision, since it draws them in a new order every epoch).

use std::sync::Arc;

use crate::analysis::ground::{Ground, Past};
use crate::analysis::{AnalysisError, Request};
use crate::calibration::kernel::{Kernel, Rows};
use crate::calibration::network::{Network, NetworkError, Samples};
use crate::calibration::{
    Calibration, EpochReport, Learned, LearnedError, Learner, LinearMap, Piece, SettingsError,
    learned_inputs, sample_row,
};
use crate::evaluation::cross_validation::FEWEST_RECORDINGS;
use crate::evaluation::metrics::root_mean;
use crate::features::{Design, FeatureStream};
use crate::progress::{Cancelled, Progress};
use crate::recording::{Entry, Recording, Role};

/// One training recording in so many is held out of a network's training, to say when it was best.
const HELD_OUT: usize = 10;
/// A kernel is cross-validated on no more parts than this.
const MOST_PARTS: usize = 10;
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
    let mut ground = Ground::lay(request, progress)?;
    let mut calibration = ground.blank_calibration(settings)?;
    let past = ground.past(&calibration, progress)?;
    ground.fit(settings.ridge, &past, &mut calibration);
    let Some(learner) = settings.regressor.learner() else {
        return Ok(calibration);
    };
    calibration.regressor = settings.regressor;
    if !settings.regressor.is_hybrid() {
        calibration.compensated = None;
    }
    let design = calibration.design();
    let rows = TrainingRows::new(&ground, &past, &design, calibration.compensated.as_ref());
    let mut cv_rmse = None;
    let learned = match learner {
        Learner::Kernel => {
            let found =
                Kernel::fit(&rows, &settings.kernel, progress).map_err(LearnedError::from)?;
            let n = rows.n_samples_in_all() as u64;
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
    ground.score_applied(&past, &mut calibration);
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
    /// The linear calibration whose residual is learned; `None`: the load itself is.
    base: Option<&'a LinearMap>,
    runs: Vec<Run<'a>>,
    n_axes: usize,
}

struct Run<'a> {
    recording: &'a Arc<Recording>,
    past: &'a Past,
    pieces: Vec<Piece>,
}

impl<'a> TrainingRows<'a> {
    fn new(
        ground: &'a Ground,
        past: &'a [Past],
        design: &'a Design,
        base: Option<&'a LinearMap>,
    ) -> Self {
        let entries = ground.entries.iter().zip(past).zip(ground.pieces());
        let runs: Vec<Run<'_>> = entries
            .filter(|((entry, _), _)| entry.role == Role::Train)
            .map(|((Entry { recording, .. }, past), pieces)| Run {
                recording,
                past,
                pieces,
            })
            .collect();
        Self {
            design,
            base,
            n_axes: runs.first().map_or(0, |run| run.recording.axes().len()),
            runs,
        }
    }

    fn n_samples_in_all(&self) -> usize {
        self.runs.iter().map(|run| run.recording.n_samples()).sum()
    }

    /// What a network trains on, and what is held out to say when it was best: whole recordings, or with few of them
    /// the last tenth of all samples.
    fn samples(&self, progress: &Progress) -> Result<(Samples, Samples), AnalysisError> {
        let (n_inputs, n_axes) = self.widths();
        let mut train = Samples::new(n_inputs, n_axes);
        let mut held_out = Samples::new(n_inputs, n_axes);
        let n = self.n_samples_in_all();
        train.reserve(n);
        let by_recording = self.runs.len() >= FEWEST_RECORDINGS;
        let mut at = 0;
        for run in 0..self.runs.len() {
            progress.check()?;
            let mut pushed = Ok(());
            self.pass(run, &mut |_, inputs, targets| {
                if pushed.is_err() {
                    return;
                }
                let is_held_out = match by_recording {
                    true => {
                        run % HELD_OUT == HELD_OUT / 2 || self.runs.len() < HELD_OUT && run == 1
                    }
                    false => at >= n - n / HELD_OUT,
                };
                let samples = if is_held_out {
                    &mut held_out
                } else {
                    &mut train
                };
                pushed = samples.push_rows(inputs, targets);
                at += targets.len() / n_axes;
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

    fn pass(&self, run: usize, take: &mut dyn FnMut(usize, &[f64], &[f64])) {
        let Run {
            recording,
            past,
            pieces,
        } = &self.runs[run];
        let mut stream = FeatureStream::new(self.design);
        let mut raw = vec![0.0; self.design.n_columns()];
        let (mut inputs, mut targets) = (Vec::new(), Vec::new());
        let mut base = vec![0.0; self.n_axes];
        for piece in pieces {
            for start in piece.samples.clone().step_by(BLOCK) {
                inputs.clear();
                targets.clear();
                for k in start..(start + BLOCK).min(piece.samples.end) {
                    sample_row(&mut stream, recording, |at| past[at][k], k, &mut raw);
                    learned_inputs(self.design, &raw, &mut inputs);
                    if let Some(map) = self.base {
                        map.apply(&raw, &mut base);
                    }
                    let loads = &recording.loads()[k * self.n_axes..][..self.n_axes];
                    targets.extend(loads.iter().zip(&base).map(|(load, base)| load - base));
                }
                take(piece.fold % MOST_PARTS, &inputs, &targets);
            }
        }
    }
}
