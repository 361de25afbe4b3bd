//! Trains any regressor, and scores it on samples outside the fit.
//!
//! Networks and kernels are trained on all training recordings, either alone or on the residuals of a linear fit (hybrid). For
//! their cross-validation, parts of the training recordings are left out in turn, and the complete fit is repeated without
//! each part.
//!
//! Guarantees: the features of a kernel are computed once if there is enough memory, and otherwise again in each pass through
//! the samples. A network draws its samples in a new order in each epoch, so all samples stay in memory, in single precision.
//!
//! No fitted value depends on the left-out part. This applies to the conventional calibration, the look-back (earlier gauge
//! values), the linear fit with its ridge, the standardisation, the landmarks and ridge strengths of the kernel, early
//! stopping, and the share with which the network or kernel is added. Only the full scales, which belong to the sensor, are
//! the same in every fit.

use std::borrow::Borrow;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::{
    calibration::{
        Calibration, EpochReport, FitSettings, Learned, Learner, LinearMap, NetworkSettings,
        NoCrossValidation, Past, Piece, PresentLoads, Regressor, RowsOf, SHARES, best_share,
        kernel::{Kernel, LinearStage, RowBlock, Rows, TakeRows},
        learned_inputs,
        network::{Network, Samples},
    },
    features::{Design, FeatureStream},
    panicked::locked,
    progress::Progress,
    questions::{
        dataset::{Dataset, Datasets, fit::LinearFit},
        error::AnalysisError,
        expected_error::{
            query::{expected_error_of_fit, groups_left_out, step_of},
            rule::HeldOutErrors,
        },
        request::Request,
    },
    recording::{Entry, Recording, Role},
    scoring::{
        cross_validation::{Fold, MOST_FITS, fit_without},
        metrics::root_mean,
        part_squares::PartSquares,
    },
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
    if scores {
        calibration.quality.band = band(&data, &past, &calibration);
    }
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

/// One of this number of training groups is held out for early stopping of a network. With few groups, the last tenth of the
/// samples is held out.
const HELD_OUT: usize = 10;
/// Minimum number of training groups for holding out a whole group. With fewer groups, too few samples would remain for
/// training.
const FEWEST_GROUPS: usize = 3;
/// Maximum number of cross-validation parts by which the ridge strengths of a kernel are chosen.
const MAX_PARTS: usize = 10;
/// Maximum number of values that are kept in memory for further passes of a kernel: 64 MB.
const MOST_KEPT: usize = 8_000_000;
/// Number of training samples that are passed to a network or kernel together, as one block.
const BLOCK: usize = 128;
/// Half width of the uncertainty band around the load, in standard deviations.
const BAND_DEVIATIONS: f64 = 2.0;

#[derive(Clone, Copy, Debug)]
pub enum TrainingStep {
    Epoch(EpochReport),
    CrossValidation {
        /// Finished share of the cross-validation, 0 to 1.
        done: f64,
        elapsed: Duration,
    },
}

impl TrainingStep {
    /// Returns the finished share of the training or of the cross-validation, 0 to 1.
    pub fn done(&self) -> f64 {
        match self {
            Self::Epoch(report) => report.epoch as f64 / report.epochs.max(1) as f64,
            Self::CrossValidation { done, .. } => *done,
        }
    }

    pub fn time_left(&self) -> Duration {
        match self {
            Self::Epoch(report) => report.time_left(),
            Self::CrossValidation { done, elapsed } => {
                elapsed.mul_f64((1.0 - done).max(0.0) / done.max(1e-3))
            }
        }
    }
}

/// Sums over samples of a hybrid model. They give the squared error for any share of the network's or kernel's output that is
/// added to the linear fit.
#[derive(Clone, Debug)]
pub struct Moments {
    pub n_samples: u64,
    /// `Σ r²`, `Σ r g` and `Σ g²` of each axis: r is the residual of the linear fit, g the output of the network or kernel.
    pub of_axes: Vec<[f64; 3]>,
    /// Residual r of the linear fit and output g of the network or kernel, for evenly spaced samples, `n × n_axes` row-major.
    pub kept: Vec<[f64; 2]>,
}

impl Moments {
    pub fn new(n_axes: usize) -> Self {
        Self { n_samples: 0, of_axes: vec![[0.0; 3]; n_axes], kept: Vec::new() }
    }

    /// Adds residuals of the linear fit (`left_over`) and outputs of the network or kernel (`added`) to the sums, both `n ×
    /// n_axes` row-major.
    pub fn add(&mut self, left_over: &[f64], added: &[f64]) {
        let n_axes = self.of_axes.len();
        for (left_over, added) in left_over.chunks_exact(n_axes).zip(added.chunks_exact(n_axes)) {
            for ((sums, r), g) in self.of_axes.iter_mut().zip(left_over).zip(added) {
                sums[0] += r * r;
                sums[1] += r * g;
                sums[2] += g * g;
            }
            self.n_samples += 1;
        }
    }

    /// Keeps the residual of the linear fit and the output of the network or kernel for every `step`-th sample, both `n ×
    /// n_axes` row-major.
    pub fn keep(&mut self, left_over: &[f64], added: &[f64], step: usize) {
        let n_axes = self.of_axes.len();
        let rows = left_over.chunks_exact(n_axes).zip(added.chunks_exact(n_axes));
        for (left_over, added) in rows.step_by(step) {
            self.kept.extend(left_over.iter().zip(added).map(|(r, g)| [*r, *g]));
        }
    }

    /// Returns the sum of squared errors if this share of the network's or kernel's output is added to the linear fit.
    pub fn squares(&self, axis: usize, share: f64) -> f64 {
        let [rr, rg, gg] = self.of_axes[axis];
        (rr - 2.0 * share * rg + share * share * gg).max(0.0)
    }
}

pub struct Fitted {
    pub past: Vec<Past>,
    /// Fitted calibration. The output of its network or kernel is not multiplied by a share yet.
    pub calibration: Calibration,
    /// Sums of the squared errors of the linear fit on each part that cross-validation leaves out.
    pub linear: Option<PartSquares>,
    /// Sums of each recording over the samples that were held out for early stopping.
    pub held_out: Vec<Moments>,
}

/// Fits the training recordings of `data`. A network or a kernel is trained on every `row_step`-th sample.
pub fn fit_all(
    data: &Dataset,
    settings: &FitSettings,
    row_step: usize,
    progress: &Progress,
    on_epoch: &mut dyn FnMut(EpochReport),
) -> Result<Fitted, AnalysisError> {
    let mut calibration = data.unfitted(settings, progress)?;
    let past = data.past(&calibration, progress)?;
    let LinearFit { shares, left_out, .. } =
        data.fit(settings.ridge, &past, &mut calibration, progress)?;
    let mut held_out = Vec::new();
    if let Some(learner) = settings.regressor.learner() {
        calibration.regressor = settings.regressor;
        // The standard errors of the linear coefficients do not apply to a model with a network or kernel.
        calibration.quality.coefficients = None;
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
        let mut rows = TrainingRows {
            design: &design,
            target,
            runs: runs(data, &past),
            n_axes: calibration.axes.len(),
            step: row_step,
            holds_out: settings.network.early_stopping,
            kept: Vec::new(),
        };
        calibration.learned = Some(match learner {
            Learner::Kernel => {
                rows.keep();
                let found = Kernel::fit(&rows, &settings.kernel, progress)?;
                calibration.quality.kernel_ridge_edge = found.edge;
                Learned::Kernel(found.kernel)
            }
            Learner::Network => {
                let (train, kept_back) = rows.samples(progress)?;
                let kept_back = (kept_back.n_samples() > 0).then_some(&kept_back);
                let network =
                    Network::train(&train, kept_back, &settings.network, progress, on_epoch)?;
                held_out = rows.moments_held_out(&network);
                Learned::Network(network)
            }
        });
        data.measure_fade(&mut calibration, &[], progress)?;
    }
    Ok(Fitted { past, calibration, linear: left_out, held_out })
}

/// Returns the half width of the uncertainty band around the compensated load for each axis; `None` if the regressor has no
/// band. See [`Quality::band`](crate::calibration::Quality::band).
pub fn band(data: &Dataset, past: &[Past], calibration: &Calibration) -> Option<Vec<f64>> {
    let has = |role| data.entries.iter().any(|entry| entry.role == role);
    let role = if has(Role::Test) { Role::Test } else { Role::Train };
    let mut squares = vec![0.0; calibration.axes.len()];
    let mut n = 0;
    for (entry, past) in data.entries.iter().zip(past) {
        if entry.role == role {
            let deviations = calibration.deviations(&entry.recording, past)?;
            for row in deviations.chunks_exact(squares.len()) {
                for (square, deviation) in squares.iter_mut().zip(row) {
                    *square += (BAND_DEVIATIONS * deviation).powi(2);
                }
            }
            n += entry.recording.n_samples() as u64;
        }
    }
    root_mean(&squares, n)
}

struct TrainingRows<'a> {
    design: &'a Design,
    target: Target<'a>,
    runs: Vec<Run<'a>>,
    n_axes: usize,
    /// Every `step`-th sample of a recording is a training row.
    step: usize,
    /// True if some training rows are held out for early stopping of a network.
    holds_out: bool,
    /// Training rows of each recording that stay in memory; empty if there are too many.
    kept: Vec<Vec<KeptBlock>>,
}

/// Copy of a [`RowBlock`]: cross-validation fold, then inputs, columns of the linear fit, and targets.
type KeptBlock = (usize, [Vec<f64>; 3]);

/// What the network or kernel is trained to predict.
enum Target<'a> {
    Load,
    /// Residual of this linear map, which a network learns.
    LeftOver(&'a LinearMap),
    /// Residual of a linear fit that the kernel repeats without each cross-validation part. The training rows contain the
    /// columns of this linear fit. Their targets are the residuals of the conventional calibration.
    AfterStage(LinearStage),
}

struct Run<'a> {
    recording: &'a Arc<Recording>,
    past: &'a Past,
    conventional: PresentLoads<'a>,
    pieces: &'a [Piece],
}

fn runs<'a>(data: &'a Dataset, past: &'a [Past]) -> Vec<Run<'a>> {
    let entries = data.entries.iter().zip(past).zip(&data.folds.pieces).enumerate();
    let training = entries.filter(|(_, ((entry, _), _))| entry.role == Role::Train);
    let run = |(at, ((entry, past), pieces)): (usize, ((&'a Entry, _), &'a Vec<Piece>))| Run {
        recording: &entry.recording,
        past,
        conventional: data.present_loads(at),
        pieces,
    };
    training.map(run).collect()
}

impl TrainingRows<'_> {
    fn n_samples_in_all(&self) -> usize {
        (0..self.runs.len()).map(|run| self.n_samples(run)).sum()
    }

    /// Computes all training rows once for several passes, unless the rows need too much memory.
    fn keep(&mut self) {
        let (n_inputs, n_axes) = self.widths();
        let n_linear = self.linear_stage().map_or(0, |stage| stage.kinds.len());
        if self.n_samples_in_all() * (n_inputs + n_linear + n_axes) > MOST_KEPT {
            return;
        }
        let run = |run| {
            let mut blocks = Vec::new();
            self.pass(run, &mut |RowBlock { fold, inputs, linear, targets }| {
                blocks.push((fold, [inputs, linear, targets].map(<[f64]>::to_vec)));
            });
            blocks
        };
        self.kept = (0..self.runs.len()).into_par_iter().map(run).collect();
    }

    /// Returns true if training row `at`, counted over all recordings, is held out for early stopping. Whole groups of
    /// recordings are held out, or the last tenth of all samples if there are few groups.
    fn is_held_out(&self, run: usize, at: usize) -> bool {
        if !self.holds_out {
            return false;
        }
        let pieces = self.runs.iter().flat_map(|run| run.pieces);
        let n_folds = pieces.map(|piece| piece.fold + 1).max().unwrap_or(0);
        let are_whole = self.runs.iter().all(|run| run.pieces.len() == 1);
        if are_whole && n_folds >= FEWEST_GROUPS {
            let fold = self.runs[run].pieces[0].fold;
            return fold % HELD_OUT == HELD_OUT / 2 || n_folds < HELD_OUT && fold == 1;
        }
        let n = self.n_samples_in_all();
        at >= n - n / HELD_OUT
    }

    /// Returns the training samples of a network, and the samples held out for early stopping.
    fn samples(&self, progress: &Progress) -> Result<(Samples, Samples), AnalysisError> {
        let (n_inputs, n_axes) = self.widths();
        let mut train = Samples::new(n_inputs, n_axes);
        let mut held_out = Samples::new(n_inputs, n_axes);
        train.reserve(self.n_samples_in_all());
        let mut at = 0;
        for run in 0..self.runs.len() {
            progress.check()?;
            let mut pushed = Ok(());
            self.pass(run, &mut |block| {
                if pushed.is_err() {
                    return;
                }
                let samples = if self.is_held_out(run, at) { &mut held_out } else { &mut train };
                pushed = samples.push_rows(block.inputs, block.targets);
                at += block.targets.len() / n_axes;
            });
            pushed?;
        }
        Ok((train, held_out))
    }

    /// Returns for each recording the sums of residuals and network outputs over the samples that are held out for early
    /// stopping.
    fn moments_held_out(&self, network: &Network) -> Vec<Moments> {
        let mut at = 0;
        let mut answers = Vec::new();
        let moments = (0..self.runs.len()).map(|run| {
            let mut moments = Moments::new(self.n_axes);
            self.pass(run, &mut |block| {
                if self.is_held_out(run, at) {
                    answers.resize(block.targets.len(), 0.0);
                    network.predict_rows(block.inputs, &mut answers);
                    moments.add(block.targets, &answers);
                }
                at += block.targets.len() / self.n_axes;
            });
            moments
        });
        moments.filter(|moments| moments.n_samples > 0).collect()
    }
}

impl Rows for TrainingRows<'_> {
    fn n_runs(&self) -> usize {
        self.runs.len()
    }

    fn n_samples(&self, run: usize) -> usize {
        self.runs[run].recording.n_samples().div_ceil(self.step)
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
        if let Some(kept) = self.kept.get(run) {
            for (fold, [inputs, linear, targets]) in kept {
                take(RowBlock { fold: *fold, inputs, linear, targets });
            }
            return;
        }
        let Run { recording, past, conventional, pieces } = &self.runs[run];
        let (from, mut stream) = (RowsOf::of(recording), FeatureStream::new(self.design));
        let mut raw = vec![0.0; self.design.n_columns()];
        let (mut inputs, mut linear, mut targets) = (Vec::new(), Vec::new(), Vec::new());
        let mut known = vec![0.0; self.n_axes];
        for piece in *pieces {
            let length = BLOCK * self.step;
            for start in piece.samples.clone().step_by(length) {
                inputs.clear();
                linear.clear();
                targets.clear();
                for k in start..(start + length).min(piece.samples.end) {
                    from.raw_row(&mut stream, |at| past[at][k], k, &mut raw);
                    if k % self.step != 0 {
                        continue;
                    }
                    learned_inputs(self.design, &raw, &mut inputs);
                    let of_sample = k * self.n_axes..(k + 1) * self.n_axes;
                    match &self.target {
                        Target::Load => {}
                        Target::LeftOver(map) => map.apply(&raw, &mut known),
                        Target::AfterStage(_) => {
                            self.design.standardise(&mut raw);
                            linear.extend(&raw);
                            conventional.row(k, &mut known);
                        }
                    }
                    let loads = recording.loads()[of_sample].iter();
                    targets.extend(loads.zip(&known).map(|(load, known)| load - known));
                }
                if !targets.is_empty() {
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
}

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

/// Returns the pieces of the training recordings as recordings of their own, each with a cold start. Those of the parts that
/// are left out have the role of test recordings.
fn fold_without(training: &[(Entry, &[Piece])], is_left_out: impl Fn(usize) -> bool) -> Fold {
    let pieces =
        training.iter().flat_map(|(entry, pieces)| pieces.iter().map(move |piece| (entry, piece)));
    Fold::of(pieces.map(|(entry, Piece { samples, fold })| {
        let mut piece = entry.clone();
        if samples.len() < entry.recording.n_samples() {
            piece.recording = Arc::new(entry.recording.segment(samples.clone()));
        }
        (piece, is_left_out(*fold).then_some(*fold))
    }))
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

#[cfg(test)]
mod cross_validated_tests {
    use crate::calibration::{KernelSettings, Regressor, RidgeChoice};
    use crate::features::{Blocks, FeatureSettings, Polynomial, Thresholds};
    use crate::questions::models::training::fit_and_score;
    use crate::questions::models::training::*;
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
