//! Training of networks and kernels on all training recordings, either alone or on the residuals of a linear fit (hybrid).
//!
//! Guarantees: the features of a kernel are computed once if there is enough memory, and otherwise again in each pass through
//! the samples. A network draws its samples in a new order in each epoch, so all samples stay in memory, in single precision.

use std::sync::Arc;
use std::time::Duration;

use rayon::prelude::*;

use crate::{
    calibration::{
        Calibration, EpochReport, FitSettings, Learned, Learner, LinearMap, Past, Piece,
        PresentLoads, RowsOf,
        kernel::{Kernel, LinearStage, RowBlock, Rows, TakeRows},
        learned_inputs,
        network::{Network, Samples},
    },
    features::{Design, FeatureStream},
    progress::Progress,
    questions::{
        dataset::{Dataset, fit::LinearFit},
        error::AnalysisError,
    },
    recording::{Entry, Recording, Role},
    scoring::{metrics::root_mean, part_squares::PartSquares},
};

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
        data.measure_fade(&mut calibration, progress)?;
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
