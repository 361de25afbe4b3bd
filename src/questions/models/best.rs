//! Search for the best model. Cross-validation scores each candidate, and [`ErrorBlocks`] chooses among the candidates.
//!
//! Guarantees: held-out recordings influence no step of a fit: conventional calibration, thresholds, values of feature
//! blocks, ridge, and training. Held-out recordings are predicted from a cold start. Test recordings are not used for the
//! choice.

use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::{
    calibration::{
        Calibration, ErrorBlocks, FitSettings, Learner, Refusal, Regressor, RidgeChoice, Scores,
        weighed,
    },
    features::FeatureSettings,
    progress::{Progress, processor_time},
    questions::{
        error::AnalysisError,
        models::{
            recipes::{self, Candidates, Effort, NestedFolds, Recipe, Side},
            table::{Mark, Model, ModelRow, model_table, weights},
        },
    },
    recording::{Recording, RecordingSet, Role, Tare},
    report::Table,
    scoring::{
        left_out::summed_by_target,
        metrics::root_mean,
        numbers::{percent_to, significant},
        score_set::ScoreSet,
    },
    shown::counted,
};

/// Maximum number of training samples while models are compared. Recordings with more samples are decimated.
const ENOUGH_SAMPLES: usize = 60_000;
/// Limits of the short training, which selects networks and kernels for the full training.
const SHORT: Effort = Effort { rows: 3_000, epochs: 20, landmarks: 80, units: 30 };
const FULL: Effort = Effort { rows: 10_000, epochs: 60, landmarks: 150, units: 64 };
/// Which models get the full training: the regressors, the maximum error after the short training as a multiple of the
/// lowest error, and the maximum number of models. A short training says little about networks, so the best three of them
/// are always trained.
const CAN_WIN: [(&[Regressor], f64, usize); 3] = [
    (&[Regressor::HybridNetwork, Regressor::Network], f64::INFINITY, 3),
    (&[Regressor::HybridKernel], 1.3, 3),
    (&[Regressor::Kernel], 1.3, 3),
];
/// Maximum error of a model that is trained again for longer, as a multiple of the lowest error.
const NEARLY_BEST: f64 = 1.15;
/// Error with a tare of each recording, as a share of the error without, below which the tare is mentioned.
const TARE_HELPS: f64 = 0.9;
/// Length of the blocks into which errors are divided, as a multiple of the correlation time of the errors.
const TIMES_CORRELATED: usize = 4;
/// Maximum number of error blocks of one recording.
const MOST_BLOCKS: usize = 50;
/// Default of [`Search::within`], the share by which the error of the smallest model may exceed the lowest error.
pub const WITHIN: f64 = 0.05;

/// Request for a search of the best model.
#[derive(Clone, Debug)]
pub struct Search {
    /// Recordings with their roles (train, test or off).
    pub recordings: Arc<RecordingSet>,
    /// Settings that all candidates share: offset, full scales, and the kind of load distance that is compared with the force
    /// threshold F_th.
    pub settings: FitSettings,
    /// Models to try.
    pub candidates: Candidates,
    /// Processor time of the program after which no further candidate starts.
    pub limit: Duration,
    /// Maximum by which the error of the smallest proposed model exceeds the lowest error, as a share of the lowest error.
    pub within: f64,
}

/// Errors of each held-out recording in each cross-validation fold, `n_samples × n_axes` row-major.
type FoldErrors = [Vec<Vec<f64>>];

#[derive(Clone, Debug, Serialize)]
pub struct Tried {
    pub name: String,
    /// Description of the features; empty for the gauges alone.
    pub blocks: String,
    pub regressor: Regressor,
    /// Model with settings that were chosen on all training recordings, and with its cross-validation errors.
    #[serde(flatten)]
    pub model: Model,
    /// Root mean squared error divided by that of the conventional calibration, with all axes weighted alike.
    pub relative: f64,
    /// True for the most accurate candidate, which is proposed.
    pub is_proposed: bool,
    /// True for the smallest candidate whose error is within [`Search::within`] of the proposed candidate's error.
    pub is_smallest: bool,
    /// Reason why the candidate cannot be proposed; `None` if the candidate is eligible.
    pub refused: Option<String>,
    /// Sums of squared errors of each block of held-out samples, `n_blocks × n_axes` row-major.
    #[serde(skip)]
    squares: Vec<f64>,
}

impl Tried {
    pub fn mark(&self) -> Mark {
        match (self.is_proposed, self.is_smallest) {
            (true, _) => Mark::Proposed,
            (false, true) => Mark::Smallest,
            (false, false) => Mark::None,
        }
    }
}

/// Network or kernel that was dropped after the short training.
#[derive(Clone, Debug, Serialize)]
pub struct RuledOut {
    name: String,
    /// Error after the short training, divided by that of the conventional calibration.
    relative: f64,
    why: String,
}

#[derive(Clone, Debug, Default, Serialize)]
pub struct Best {
    pub tried: Vec<Tried>,
    /// Names of candidates that could not be tried, with the reasons.
    pub failed: Vec<(String, String)>,
    /// Networks and kernels that were dropped after the short training.
    pub ruled_out: Vec<RuledOut>,
    /// Number of candidates that were not tried yet and may be better than the proposal. It is zero only after a complete
    /// search.
    pub n_left: usize,
    pub n_folds: usize,
    /// Description of the cross-validation.
    pub folds: String,
    /// Decimation of the recordings while models were compared.
    pub decimation: usize,
    /// Copy of [`Search::within`].
    pub within: f64,
    /// Tare of the training recordings; `None` if a training recording is not tared.
    pub tare: Option<Tare>,
    /// Cross-validated error of the conventional calibration if each training recording is tared, divided by its error with
    /// the recordings as they are; `None` unless the tare lowers the error by more than a tenth.
    pub with_tare: Option<f64>,
    #[serde(skip)]
    cut: Cut,
}

impl Best {
    /// Returns the most accurate candidate; `None` before the first result.
    pub fn proposed(&self) -> Option<&Tried> {
        self.tried.iter().find(|tried| tried.is_proposed)
    }

    /// Returns the smallest candidate that is nearly as accurate; `None` before the first result.
    pub fn smallest(&self) -> Option<&Tried> {
        self.tried.iter().find(|tried| tried.is_smallest)
    }

    /// Returns a sentence with the reason for the proposal, and a sentence about the smallest model.
    pub fn why(&self) -> Vec<String> {
        let (Some(proposed), Some(smallest)) = (self.proposed(), self.smallest()) else {
            return Vec::new();
        };
        let cost = |tried: &Tried| {
            let cost = &tried.model.cost;
            format!("{} parameters, {} bytes", cost.coefficients, cost.bytes)
        };
        if proposed.name == self.tried[0].name {
            return vec![format!(
                "Proposed: {}. Each of the {} other models is not better with 90 % confidence ({} blocks of left-out samples), or much worse on one of the groups",
                proposed.name,
                self.tried.len() - 1,
                self.cut.blocks.samples.len()
            )];
        }
        let first = format!(
            "Proposed: {}, the most accurate model: {} of the conventional error ({}); {}",
            proposed.name,
            percent_to(proposed.relative, 3),
            self.folds,
            cost(proposed)
        );
        let within = significant(100.0 * self.within, 2);
        let second = if smallest.name == proposed.name {
            format!("No smaller model has an error within {within} % of the proposed model's error")
        } else {
            format!(
                "Smallest model with an error within {within} % of the proposed model's error: {}, {} of the conventional error; {}",
                smallest.name,
                percent_to(smallest.relative, 3),
                cost(smallest)
            )
        };
        vec![first, second]
    }

    /// Returns sentences with further results of the search, such as the models that were not tried.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        remarks.extend(self.tare.map(|tare| {
            format!("The models are compared after a tare over {tare}; tare the gauges on the robot, too")
        }));
        remarks.extend(self.with_tare.map(|share| {
            format!(
                "The zeros of the recordings differ: a tare of each recording lowers the conventional error to {}. If the robot tares the gauges before use, tare the recordings, too (--tare auto), to compare the models after this tare",
                percent_to(share, 3)
            )
        }));
        let lowest = self.proposed().map_or(1.0, |tried| tried.relative);
        // A model with a lower error than the proposed model needs an explanation why it is not proposed.
        let lower = self.tried.iter().filter(|tried| tried.relative < lowest);
        remarks.extend(lower.map(|tried| match &tried.refused {
            Some(why) => format!("{} is not proposed: {why}", tried.name),
            None => format!(
                "{} has a lower mean error, but only because of a few extreme blocks of samples",
                tried.name
            ),
        }));
        if self.n_left > 0 {
            let n = counted(self.n_left, "model");
            remarks.push(format!(
                "{n} not tried before the search ended; any of them may be better than the proposal"
            ));
        }
        let failures = self.failed.iter();
        remarks.extend(failures.map(|(name, why)| format!("{name} could not be tried: {why}")));
        let dropped = self.ruled_out.iter();
        let best = dropped.min_by(|a, b| a.relative.total_cmp(&b.relative));
        remarks.extend(best.map(|best| {
            format!(
                "{} networks and kernels were dropped after a short training; the best of them is {}, with {} of the conventional error: {}",
                self.ruled_out.len(),
                best.name,
                percent_to(best.relative, 3),
                best.why
            )
        }));
        remarks
    }

    fn push(&mut self, mut tried: Tried) {
        // The first candidate is always the conventional calibration.
        let conventional = self.tried.first().unwrap_or(&tried).clone();
        tried.model.conventional = conventional.model.scores.clone();
        tried.model.left_out.clone_from(&self.folds);
        let rmse = tried.model.conventional.cv_rmse.as_deref();
        let weights = weights(rmse.unwrap_or_default());
        let of = |tried: &Tried| weighed(&tried.squares, &weights);
        let (squares, reference) = (of(&tried), of(&conventional));
        // If the conventional calibration has no error, no model is better.
        tried.relative = tried.model.relative(ScoreSet::LeftOut).unwrap_or(1.0);
        tried.model.spread = Some(self.cut.blocks.compare(&squares, &reference).standard_error);
        self.tried.push(tried);
        let mut order: Vec<usize> = (0..self.tried.len()).collect();
        order[1..].sort_by_key(|at| {
            let cost = &self.tried[*at].model.cost;
            (cost.bytes, cost.coefficients)
        });
        let squares: Vec<Vec<f64>> = order.iter().map(|at| of(&self.tried[*at])).collect();
        let choice = self.cut.blocks.choose(order.len(), self.within, |at| &squares[at]);
        for (position, (at, refused)) in order.into_iter().zip(choice.refused).enumerate() {
            let candidate = &mut self.tried[at];
            candidate.is_proposed = position == choice.accurate;
            candidate.is_smallest = position == choice.smallest;
            candidate.refused = refused.map(|refused| self.cut.words(refused));
        }
    }

    fn lowest(&self) -> f64 {
        self.tried.iter().map(|tried| tried.relative).fold(f64::INFINITY, f64::min)
    }

    pub fn table(&self, set: ScoreSet) -> Table {
        let axes = (self.tried.first()).map_or(&[][..], |tried| &tried.model.axes);
        let folds = match set {
            ScoreSet::Test => String::new(),
            _ => format!("; {}", self.folds),
        };
        let rows = self.tried.iter().map(|tried| ModelRow {
            mark: tried.mark().cell(),
            name: &tried.name,
            model: &tried.model,
        });
        Table {
            title: format!("RMSE, {}{folds}", set.label()),
            note: format!(
                "→: the proposed, most accurate model; =: the smallest model with an error within {} % of the proposed model's error",
                significant(100.0 * self.within, 2)
            ),
            ..model_table(axes, &[set], rows)
        }
    }
}

/// Division of the held-out samples into blocks of consecutive samples.
#[derive(Clone, Debug, Default)]
struct Cut {
    blocks: ErrorBlocks,
    /// Number of blocks of each held-out recording.
    counts: Vec<usize>,
    /// Names of the groups of recordings that are held out.
    groups: Vec<String>,
}

impl Cut {
    /// Divides the held-out samples into blocks that are longer than the correlation time of `errors`, the errors of the
    /// conventional calibration.
    fn of(folds: &NestedFolds, errors: &FoldErrors, n_axes: usize) -> Self {
        let length = TIMES_CORRELATED * correlated(errors, n_axes);
        let fewest = if folds.parts.len() < folds.n_left_out.max(2) { 2 } else { 1 };
        let mut cut = Self { groups: folds.parts.clone(), ..Self::default() };
        let parts = folds.folds.iter().flat_map(|fold| &fold.parts);
        for (part, errors) in parts.zip(errors.iter().flatten()) {
            let n = errors.len() / n_axes;
            let count = (n / length).clamp(fewest, MOST_BLOCKS).min(n.max(1));
            cut.blocks.samples.extend(blocks(n, count).map(|block| block.len() as f64));
            cut.blocks.groups.extend(std::iter::repeat_n(*part, count));
            cut.counts.push(count);
        }
        cut
    }

    /// Returns the sums of squared errors of each block, `n_blocks × n_axes`.
    fn squares(&self, errors: &FoldErrors, n_axes: usize) -> Vec<f64> {
        let mut squares = Vec::new();
        for (count, errors) in self.counts.iter().zip(errors.iter().flatten()) {
            for at in blocks(errors.len() / n_axes, *count) {
                let block = &errors[at.start * n_axes..at.end * n_axes];
                squares.extend(summed_squares(block, n_axes));
            }
        }
        squares
    }

    fn words(&self, refused: Refusal) -> String {
        match refused {
            Refusal::NotBetter => {
                "it is not better than the conventional calibration with 90 % confidence".to_owned()
            }
            Refusal::Harms { group, ratio } => {
                let (group, ratio) = (&self.groups[group], significant(ratio, 2));
                format!("unstable: its error on {group} is {ratio} times the conventional one")
            }
        }
    }
}

/// Returns the sample ranges of `count` blocks of nearly equal length.
fn blocks(n_samples: usize, count: usize) -> impl Iterator<Item = Range<usize>> {
    (0..count).map(move |at| at * n_samples / count..(at + 1) * n_samples / count)
}

/// Returns the sum of the squared errors of each axis.
fn summed_squares(errors: &[f64], n_axes: usize) -> Vec<f64> {
    let squares: Vec<f64> = errors.iter().map(|error| error * error).collect();
    summed_by_target(&squares, n_axes)
}

/// Returns the correlation time of errors in samples: the lag at which the autocorrelation around zero falls below 1/e. The
/// correlation time of a constant error is the length of the recording.
fn correlated(errors: &FoldErrors, n_axes: usize) -> usize {
    let all = || errors.iter().flatten();
    let longest = all().map(|errors| errors.len() / n_axes).max().unwrap_or(1);
    let mut lag = 1;
    while lag < longest {
        let (mut products, mut squares) = (vec![0.0; n_axes], vec![0.0; n_axes]);
        for errors in all() {
            let later = errors.iter().skip(lag * n_axes);
            for (at, (a, b)) in errors.iter().zip(later).enumerate() {
                products[at % n_axes] += a * b;
                squares[at % n_axes] += a * a;
            }
        }
        let correlations = products.iter().zip(&squares).filter(|(_, square)| **square > 0.0);
        let sum: f64 = correlations.map(|(product, square)| product / square).sum();
        if sum < n_axes as f64 / std::f64::consts::E {
            break;
        }
        lag *= 2;
    }
    lag
}

/// Fits and scores the candidates of the search. `show` receives all results after each candidate. A cancelled search returns
/// the results so far.
///
/// # Errors
/// [`AnalysisError`] without training recordings, or if the conventional calibration cannot be fitted.
pub fn find_best(
    search: &Search,
    progress: &Progress,
    show: &(dyn Fn(&Best) + Sync),
) -> Result<Best, AnalysisError> {
    search.settings.validate()?;
    let mut running = Running::new(search, progress, show)?;
    match running.try_all() {
        Err(AnalysisError::Cancelled(_)) if !running.best.tried.is_empty() => {}
        ended => ended?,
    }
    Ok(running.best)
}

/// Returns the cross-validated error of the conventional calibration after a tare of each training recording, divided by its
/// error without. Returns `None` unless the tare lowers the error by more than a tenth.
fn error_with_tare(
    recordings: &Arc<RecordingSet>,
    settings: &FitSettings,
    progress: &Progress,
) -> Result<Option<f64>, AnalysisError> {
    let mut tared = RecordingSet::clone(recordings);
    let training = recordings.entries().iter().enumerate();
    for (at, entry) in training.filter(|(_, entry)| entry.role == Role::Train) {
        let recording = Recording::clone(&entry.recording);
        match (recording.tare(), recording.tared(Tare::Auto)) {
            (None, Ok((recording, _))) => tared.replace(at, recording),
            // The recording is tared already, or never at rest without load.
            _ => return Ok(None),
        }
    }
    let rmse = |set: &Arc<RecordingSet>| {
        let side = Side::new(Arc::clone(set), settings);
        let quality = side.fit(settings.clone(), usize::MAX, progress)?.quality;
        Ok::<_, AnalysisError>(quality.conventional.cv_rmse.unwrap_or_default())
    };
    let weights = weights(&rmse(recordings)?);
    let tared = rmse(&Arc::new(tared))?;
    let share = weights.iter().zip(tared).map(|(weight, rmse)| weight * rmse * rmse);
    let share = share.sum::<f64>().sqrt();
    Ok((0.0 < share && share < TARE_HELPS).then_some(share))
}

struct Running<'a> {
    search: &'a Search,
    progress: &'a Progress,
    show: &'a (dyn Fn(&Best) + Sync),
    /// Processor time of the program at the start of the search.
    start: Duration,
    folds: NestedFolds,
    /// All training recordings, to which the final settings of each candidate are fitted.
    whole: Side,
    /// Training and held-out recordings of each cross-validation fold.
    sides: Vec<Side>,
    n_axes: usize,
    best: Best,
}

impl<'a> Running<'a> {
    fn new(
        search: &'a Search,
        progress: &'a Progress,
        show: &'a (dyn Fn(&Best) + Sync),
    ) -> Result<Self, AnalysisError> {
        let start = processor_time();
        let folds = NestedFolds::of(&search.recordings)?;
        let n_train = search.recordings.n_samples(Role::Train);
        let thinned = search.settings.decimation.max(n_train.div_ceil(ENOUGH_SAMPLES));
        let common = FitSettings {
            features: FeatureSettings {
                distance: search.settings.features.distance,
                ..FeatureSettings::present()
            },
            regressor: Regressor::Linear,
            ridge: RidgeChoice::ByBlock,
            decimation: thinned,
            ..search.settings.clone()
        };
        let mut whole = Side::new(Arc::clone(&folds.whole), &common);
        whole.settle_auxiliary(progress)?;
        let side = |set: &Arc<RecordingSet>| {
            let mut side = Side::new(Arc::clone(set), &common);
            side.auxiliary.clone_from(&whole.auxiliary);
            side
        };
        let best = Best {
            n_folds: folds.n_left_out,
            folds: folds.what.clone(),
            decimation: thinned,
            within: search.within,
            tare: search.recordings.tare(),
            with_tare: error_with_tare(&search.recordings, &common, progress)?,
            ..Best::default()
        };
        Ok(Self {
            search,
            progress,
            show,
            start,
            sides: folds.folds.iter().map(|fold| side(&fold.set)).collect(),
            folds,
            whole,
            n_axes: search.recordings.layout().axes.len(),
            best,
        })
    }

    fn try_all(&mut self) -> Result<(), AnalysisError> {
        let (linear, learned) = match self.search.candidates {
            Candidates::All => {
                (recipes::linear(!self.whole.auxiliary.is_empty()), recipes::learned())
            }
            // The paper's models are few, so each of them gets the full training.
            Candidates::Paper => (recipes::paper(self.whole.is_static()), Vec::new()),
        };
        let most_trained: usize = CAN_WIN.iter().map(|(_, _, most)| most + 1).sum();
        self.progress.add_total((linear.len() + learned.len() + most_trained) as u64);
        self.best.n_left = linear.len() + learned.len();
        for recipe in &linear {
            self.try_fully(recipe)?;
        }
        let mut trained = Vec::new();
        if !learned.is_empty() && !self.whole.is_static() {
            let recipe = recipes::always_trained();
            self.best.n_left += 1;
            self.try_fully(&recipe)?;
            trained.push(recipe);
        }
        // Kernels come last, because they take longest.
        for learner in [Learner::Network, Learner::Kernel] {
            let alike = learned.iter().filter(|recipe| recipe.regressor.learner() == Some(learner));
            for recipe in self.worth_training(alike)? {
                self.try_fully(recipe)?;
                trained.push(recipe.clone());
            }
        }
        for (regressors, ..) in CAN_WIN {
            if let Some(longer) = self.best_of(regressors, &trained).map(Recipe::longer) {
                self.best.n_left += 1;
                self.try_fully(&longer)?;
            }
        }
        Ok(())
    }

    fn is_out_of_time(&self) -> bool {
        processor_time() - self.start > self.search.limit
    }

    /// Fits a candidate in each cross-validation fold. Returns the errors of each held-out recording.
    fn errors(
        &mut self,
        recipe: &Recipe,
        effort: Effort,
    ) -> Result<Vec<Vec<Vec<f64>>>, AnalysisError> {
        let progress = self.progress;
        progress.check()?;
        let run = |side: &mut Side| {
            let settings = side.settle(recipe, effort, progress)?;
            side.errors(settings, effort.rows, progress)
        };
        // Each fit has its own thread, so that the shared thread pool stays free for the window.
        let run = &run;
        std::thread::scope(|scope| {
            let threads: Vec<_> =
                self.sides.iter_mut().map(|side| scope.spawn(move || run(side))).collect();
            let results = threads.into_iter().map(|thread| thread.join());
            results.map(|errors| errors.unwrap_or_else(|panic| resume_unwind(panic))).collect()
        })
    }

    /// Returns the result of fitting a candidate. If the candidate could not be fitted, stores the reason and returns `None`.
    fn noted<T>(
        &mut self,
        recipe: &Recipe,
        found: Result<T, AnalysisError>,
    ) -> Result<Option<T>, AnalysisError> {
        if let Err(AnalysisError::Cancelled(cancelled)) = found {
            return Err(cancelled.into());
        }
        self.progress.advance(1);
        self.best.n_left -= 1;
        match found {
            Ok(found) => Ok(Some(found)),
            // Without the conventional calibration, which is the first candidate, no model can be compared.
            Err(error) if self.best.tried.is_empty() => Err(error),
            Err(error) => {
                self.best.failed.push((recipe.name.clone(), error.to_string()));
                Ok(None)
            }
        }
    }

    /// Returns false if the error equals that of a linear model: then the network or kernel after the linear fit has no
    /// effect.
    fn is_new(&self, relative: f64) -> bool {
        let is_linear = |tried: &&Tried| tried.regressor == Regressor::Linear;
        let same = |tried: &Tried| (tried.relative - relative).abs() < 1e-9;
        !self.best.tried.iter().filter(is_linear).any(same)
    }

    /// Returns the candidate with the lowest error among those with one of these regressors; `None` if this error is far above the
    /// lowest error of all models.
    fn best_of<'r>(&self, regressors: &[Regressor], trained: &'r [Recipe]) -> Option<&'r Recipe> {
        let reach = NEARLY_BEST * self.best.lowest();
        let alike = trained.iter().filter(|recipe| regressors.contains(&recipe.regressor));
        let found = alike.filter_map(|recipe| {
            let tried = self.best.tried.iter().find(|tried| tried.name == recipe.name)?;
            let can_win = tried.relative < reach && tried.refused.is_none();
            (can_win && self.is_new(tried.relative)).then_some((tried.relative, recipe))
        });
        found.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, recipe)| recipe)
    }

    /// Returns the root mean squared error divided by that of the conventional calibration, with all axes weighted alike.
    fn relative(&self, errors: &FoldErrors) -> f64 {
        let conventional = &self.best.tried[0].model.scores;
        let weights = weights(conventional.cv_rmse.as_deref().unwrap_or_default());
        let squares = weighed(&self.best.cut.squares(errors, self.n_axes), &weights);
        let n: f64 = self.best.cut.blocks.samples.iter().sum();
        (squares.iter().sum::<f64>() / n).sqrt()
    }

    /// Trains these networks or kernels for a short time. Returns those whose full training may give the lowest error, the
    /// best first.
    fn worth_training<'r>(
        &mut self,
        recipes: impl Iterator<Item = &'r Recipe>,
    ) -> Result<Vec<&'r Recipe>, AnalysisError> {
        let mut short = Vec::new();
        for recipe in recipes {
            if self.is_out_of_time() {
                break;
            }
            let errors = self.errors(recipe, SHORT);
            if let Some(errors) = self.noted(recipe, errors)? {
                short.push((self.relative(&errors), recipe));
            }
        }
        short.sort_by(|a, b| a.0.total_cmp(&b.0));
        let lowest = short.first().map_or(f64::INFINITY, |(relative, _)| *relative);
        let lowest = lowest.min(self.best.lowest());
        let mut left = CAN_WIN;
        let mut worth = Vec::new();
        for (relative, recipe) in short {
            let limits = left.iter_mut().find(|limits| limits.0.contains(&recipe.regressor));
            let Some((_, reach, most)) = limits else { continue };
            let why = if !self.is_new(relative) {
                "the linear model before it has the same error".to_owned()
            } else if relative >= *reach * lowest {
                format!("its error is above {reach} times the lowest, {}", percent_to(lowest, 3))
            } else if *most == 0 {
                "others of its kind have lower errors".to_owned()
            } else {
                *most -= 1;
                worth.push(recipe);
                continue;
            };
            self.best.ruled_out.push(RuledOut { name: recipe.name.clone(), relative, why });
        }
        self.best.n_left += worth.len();
        Ok(worth)
    }

    /// Fits and scores a candidate with the full training, unless the search is out of time. The conventional calibration is
    /// always tried.
    fn try_fully(&mut self, recipe: &Recipe) -> Result<(), AnalysisError> {
        if !self.best.tried.is_empty() && self.is_out_of_time() {
            return Ok(());
        }
        let since = Instant::now();
        let tried = self.tried(recipe);
        let Some(mut tried) = self.noted(recipe, tried)? else { return Ok(()) };
        let is_same = |earlier: &Tried| earlier.model.settings == tried.model.settings;
        // Feature blocks without effect were removed, so a candidate may equal an earlier candidate.
        if !self.best.tried.iter().any(is_same) {
            tried.model.seconds = Some(since.elapsed().as_secs_f64());
            self.best.push(tried);
        }
        (self.show)(&self.best);
        Ok(())
    }

    fn tried(&mut self, recipe: &Recipe) -> Result<Tried, AnalysisError> {
        let n_axes = self.n_axes;
        let errors = self.errors(recipe, FULL)?;
        if self.best.tried.is_empty() {
            self.best.cut = Cut::of(&self.folds, &errors, n_axes);
        }
        let squares = self.best.cut.squares(&errors, n_axes);
        let mut settings = self.whole.settle(recipe, FULL, self.progress)?;
        let calibration = self.whole.fit(settings.clone(), FULL.rows, self.progress)?;
        settings.decimation = self.search.settings.decimation;
        leave_away(&mut settings.features, &calibration);
        let n: f64 = self.best.cut.blocks.samples.iter().sum();
        let cv_rmse = root_mean(&summed_by_target(&squares, n_axes), n as u64);
        let blocks = settings.features.describe();
        let model = Model {
            scores: Scores { cv_rmse, ..calibration.quality.compensated.clone() },
            cv_spread: spreads(&errors, n_axes),
            ..Model::fitted(settings, &Arc::new(calibration), &self.folds.whole)
        };
        Ok(Tried {
            name: recipe.name.clone(),
            blocks,
            regressor: recipe.regressor,
            // Comparison with the other models follows.
            relative: 1.0,
            is_proposed: false,
            is_smallest: false,
            refused: None,
            model,
            squares,
        })
    }
}

/// Returns the standard deviation of each axis' RMSE between the cross-validation folds.
fn spreads(errors: &FoldErrors, n_axes: usize) -> Vec<f64> {
    let rmse = errors.iter().filter_map(|fold| {
        let all = fold.concat();
        root_mean(&summed_squares(&all, n_axes), (all.len() / n_axes) as u64)
    });
    let rmse: Vec<Vec<f64>> = rmse.collect();
    let of_axis = |axis: usize| {
        let n = rmse.len() as f64;
        let mean = rmse.iter().map(|rmse| rmse[axis]).sum::<f64>() / n.max(1.0);
        let squares = rmse.iter().map(|rmse| (rmse[axis] - mean).powi(2)).sum::<f64>();
        (squares / (n - 1.0).max(1.0)).sqrt()
    };
    (0..n_axes).map(of_axis).collect()
}

/// Removes the feature blocks that the ridge has left out for all axes.
fn leave_away(features: &mut FeatureSettings, calibration: &Calibration) {
    let ridges = &calibration.quality.ridge_by_block;
    for (of_block, ridge) in calibration.design().blocks().iter().zip(ridges) {
        if ridge.strengths.iter().all(Option::is_none) {
            match of_block.block {
                Some(block) => features.blocks.set(block, Vec::new()),
                None => features.look_backs.clear(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::Auxiliary;
    use crate::random::Random;
    use crate::recording::{Axis, Entry};

    /// The zero of the sensor follows a temperature slowly.
    #[test]
    fn auxiliary_channels_are_tried_where_there_are_some() {
        let mut set = RecordingSet::default();
        for at in 0..4 {
            let (mut gauges, mut loads, mut warmth) = (Vec::new(), Vec::new(), Vec::new());
            let mut slow = 20.0;
            for k in 0..600 {
                let t = f64::from(k) + 700.0 * f64::from(at);
                let warm = 20.0 + 10.0 * (0.03 * t).sin() + 8.0 * (0.17 * t).sin();
                slow += (warm - slow) / 20.0;
                let load = [10.0 * (0.7 * t).sin(), 8.0 * (0.9 * t).cos()];
                let noise = 0.01 * (1e3 * t).sin();
                gauges.extend([load[0] + 0.2 * slow + noise, load[1] - 0.1 * slow - noise]);
                loads.extend(load);
                warmth.push(warm);
            }
            let recording = crate::recording::Recording::new(
                format!("r{at}"),
                crate::recording::Source::Simulated,
                (0..600).map(f64::from).collect(),
                vec!["S1".to_owned(), "S2".to_owned()],
                gauges,
                vec![Axis::Fx, Axis::Fy],
                loads,
            );
            let names = (vec!["T".to_owned()], vec!["°C".to_owned()]);
            let recording = recording.unwrap().with_auxiliary(names.0, names.1, warmth);
            set.push(Entry::new(recording.unwrap(), Role::Train)).unwrap();
        }
        let search = Search {
            recordings: Arc::new(set),
            settings: FitSettings::default(),
            candidates: Candidates::All,
            limit: Duration::from_millis(1),
            within: WITHIN,
        };
        let best = find_best(&search, &Progress::default(), &|_| {}).unwrap();
        assert_eq!(best.tried[0].name, "Conventional");
        assert_eq!(
            best.n_left,
            recipes::linear(true).len() + recipes::learned().len(),
            "the time allowed one"
        );
        let patient = Search { limit: Duration::from_secs(20), ..search };
        let best = find_best(&patient, &Progress::default(), &|_| {}).unwrap();
        let auxiliary = &best.tried[1];
        assert_eq!(auxiliary.name, "Auxiliary channels");
        assert!(auxiliary.relative < 0.2, "{}", auxiliary.relative);
        assert_eq!(auxiliary.model.settings.features.blocks.of(&Auxiliary), [0.0, 20.0]);
        assert!(best.proposed().unwrap().relative < 0.2);
    }

    /// Four recordings of one gauge that start without load. In some sets, the zero differs between recordings.
    #[test]
    fn a_tare_is_mentioned_if_the_zeros_differ_and_the_recordings_are_not_tared() {
        let found = |shift: f64, is_tared: bool| {
            let mut set = RecordingSet::default();
            for at in 0..4 {
                let time = |k: usize| 0.02 * k as f64;
                let load = |k: usize| 20.0 * ((1.0 + 0.1 * f64::from(at)) * (time(k) - 2.0)).sin();
                let loads: Vec<f64> =
                    (0..600).map(|k| if k < 100 { 0.0 } else { load(k) }).collect();
                let zero = 5.0 + shift * f64::from((at * 7) % 4);
                let noise = |k: usize| 0.02 * (1e3 * k as f64).sin();
                let gauges = loads.iter().enumerate();
                let gauges = gauges.map(|(k, load)| zero + load + 1e-3 * load * load + noise(k));
                let recording = Recording::new(
                    format!("r{at}"),
                    crate::recording::Source::Simulated,
                    (0..600).map(time).collect(),
                    vec!["S1".to_owned()],
                    gauges.collect(),
                    vec![Axis::Fz],
                    loads,
                );
                let recording = recording.unwrap();
                let recording =
                    if is_tared { recording.tared(Tare::Auto).unwrap().0 } else { recording };
                set.push(Entry::new(recording, Role::Train)).unwrap();
            }
            let search = Search {
                recordings: Arc::new(set),
                settings: FitSettings::default(),
                candidates: Candidates::All,
                limit: Duration::ZERO,
                within: WITHIN,
            };
            let best = find_best(&search, &Progress::default(), &|_| {}).unwrap();
            (best.tare, best.with_tare)
        };
        assert_eq!(found(0.0, false), (None, None));
        let (tare, with_tare) = found(2.0, false);
        assert!(tare.is_none() && with_tare.is_some_and(|share| share < 0.3), "{with_tare:?}");
        assert_eq!(found(2.0, true), (Some(Tare::Auto), None));
    }

    /// Runs with two threads, and with one thread beside other work.
    #[test]
    fn the_proposal_does_not_depend_on_how_busy_the_machine_is() {
        let mut set = RecordingSet::default();
        for entry in crate::recording::simulated::recordings(1).entries().iter().step_by(30) {
            let thinned = Entry::new(entry.recording.decimated(40), Role::Train);
            set.push(thinned).unwrap();
        }
        let search = Search {
            recordings: Arc::new(set),
            settings: FitSettings::default(),
            candidates: Candidates::All,
            limit: Duration::from_secs(3600),
            within: WITHIN,
        };
        let found = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let best = pool.install(|| find_best(&search, &Progress::default(), &|_| {}));
            let tried = best.unwrap().tried.into_iter();
            tried.map(|tried| (tried.name, tried.squares, tried.is_proposed)).collect::<Vec<_>>()
        };
        let idle = found(2);
        let is_done = std::sync::atomic::AtomicBool::new(false);
        let busy = std::thread::scope(|scope| {
            for _ in 0..2 {
                scope.spawn(|| {
                    while !is_done.load(std::sync::atomic::Ordering::Relaxed) {
                        std::hint::spin_loop();
                    }
                });
            }
            let busy = found(1);
            is_done.store(true, std::sync::atomic::Ordering::Relaxed);
            busy
        });
        assert!(idle.len() > 10 && idle == busy);
    }

    /// One series of errors changes at every tenth sample, the other series at every sample.
    #[test]
    fn blocks_are_longer_than_errors_are_correlated() {
        let mut random = Random::new(3, &[]);
        let quick: Vec<f64> = (0..4000).map(|_| random.normal()).collect();
        assert_eq!(correlated(&[vec![quick.clone()]], 1), 1);
        let slow: Vec<f64> = (0..4000).map(|k| quick[k / 10]).collect();
        assert_eq!(correlated(&[vec![slow]], 1), 8);
        assert!(correlated(&[vec![vec![1.0; 4000]]], 1) >= 4000, "an offset");
    }

    /// Two folds have the errors 1 and 3 on the first axis, 2 and 2 on the second.
    #[test]
    fn the_spread_is_that_of_the_folds_errors() {
        let errors = [vec![[1.0, 2.0].repeat(4)], vec![[3.0, -2.0].repeat(9)]];
        let found = spreads(&errors, 2);
        assert!((found[0] - 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(found[1], 0.0);
    }
}
