//! Candidates of a model search, and the choice of their thresholds, play radii and times on the training recordings of one
//! cross-validation fold.
//!
//! A new feature block becomes a candidate as soon as the list of feature blocks has a line for it.
//!
//! A fold holds out a group of recordings, or a segment of one long recording. The models are fitted to the remaining training
//! recordings.
//!
//! Guarantees: each training sample is held out once, and is then predicted from a cold start. Later segments of one long
//! recording are also predicted from the earlier segments alone, so that a drift increases the error.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::{
    calibration::{Calibration, CrossValidation, FitSettings, Learner, Regressor, RidgeChoice},
    features::{Appends, Auxiliary, BLOCKS, Block, FeatureSettings, FixedLag, Lists, Thresholds},
    progress::Progress,
    questions::{
        dataset::Datasets,
        error::AnalysisError,
        models::training::{Fitted, best_shares, fit_all, fit_and_score},
        request::Request,
        thresholds::{Measure, ThresholdGrid, study::Study},
    },
    recording::{Entry, GroupedBy, RecordingSet, Role},
    scoring::cross_validation::{Fold, MOST_FITS, fit_without},
};

/// Number of values that are tried for each look-back threshold: the force threshold F_th and the time threshold t_th.
const GRID: usize = 12;
/// Number of values that a feature block gets with [`Times::Spread`].
const SPREAD: usize = 6;
/// Maximum number of lags with [`Times::Doubling`].
const MOST_DOUBLINGS: u32 = 12;
/// Maximum number of lags with [`Times::EverySample`].
const MOST_LAGS: usize = 160;
/// Maximum number of feature columns with [`Times::EverySample`].
const MOST_LAG_COLUMNS: usize = 200;
/// Maximum number of multiplications for the sums of a fit with [`Times::EverySample`], to limit the computing time.
const MOST_LAG_WORK: usize = 400_000_000;
/// Lists of lags to try for the effect of auxiliary channels (s).
const AUXILIARY_LAGS: [&[f64]; 4] = [&[0.0], &[0.0, 5.0], &[0.0, 20.0], &[0.0, 100.0]];
/// Squared error below which a lag of auxiliary channels is used, as a share of the squared error without a lag.
const LAG_HELPS: f64 = 0.9;

/// Limits of one training, which bound its computing time.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Maximum number of training samples.
    pub rows: usize,
    pub epochs: usize,
    pub landmarks: usize,
    /// Number of units in each hidden layer of a network.
    pub units: usize,
}

/// Recordings of one cross-validation fold, and the values chosen on its training recordings.
pub struct Side {
    recordings: Arc<RecordingSet>,
    settings: FitSettings,
    datasets: Datasets,
    /// Thresholds of the look-back that were chosen on the training recordings; `None` before the choice.
    look_back: Option<Thresholds>,
    /// Values (lags or radii) of feature blocks that were chosen so far.
    values: Vec<(&'static dyn Block, Times, Vec<f64>)>,
    /// Chosen lags of the auxiliary channels (s); empty without auxiliary channels.
    pub auxiliary: Vec<f64>,
}

impl Side {
    pub fn new(recordings: Arc<RecordingSet>, settings: &FitSettings) -> Self {
        Self {
            recordings,
            settings: settings.clone(),
            datasets: Datasets::default(),
            look_back: None,
            values: Vec::new(),
            auxiliary: Vec::new(),
        }
    }

    pub fn is_static(&self) -> bool {
        self.recordings.is_static()
    }

    /// Chooses the lags of the auxiliary channels by the error of a linear fit.
    pub fn settle_auxiliary(&mut self, progress: &Progress) -> Result<(), AnalysisError> {
        let (mut without_lag, mut lowest) = (None, f64::INFINITY);
        for lags in AUXILIARY_LAGS {
            let mut settings = self.settings.clone();
            settings.features.blocks.set(&Auxiliary, lags.to_vec());
            let calibration = self.fit(settings, usize::MAX, progress)?;
            if calibration.features.auxiliary.is_empty() {
                return Ok(());
            }
            let scores = &calibration.quality.compensated;
            let errors = scores.cv_rmse.as_ref().or(scores.train_rmse.as_ref());
            let scaled = errors.into_iter().flatten().zip(&calibration.full_scale);
            let scaled = scaled.filter(|(_, scale)| **scale > 0.0);
            let square: f64 = scaled.map(|(error, scale)| (error / scale).powi(2)).sum();
            let helps = without_lag.is_none_or(|before| square < LAG_HELPS * before);
            if helps && square < lowest {
                self.auxiliary = lags.to_vec();
                lowest = square;
            }
            without_lag = without_lag.or(Some(square));
        }
        Ok(())
    }

    /// Returns the settings of a candidate, with thresholds, play radii and times chosen on the training recordings.
    pub fn settle(
        &mut self,
        recipe: &Recipe,
        effort: Effort,
        progress: &Progress,
    ) -> Result<FitSettings, AnalysisError> {
        let mut features = self.settings.features.clone();
        if recipe.look_back {
            features.look_backs = vec![self.thresholds(progress)?];
        }
        for &block in BLOCKS {
            if recipe.blocks.contains(&block) && block != (&Auxiliary as &dyn Block) {
                features.blocks.set(block, self.values(block, recipe, progress)?);
            }
        }
        // The conventional calibration has no auxiliary channels.
        let more_than_conventional =
            recipe.look_back || !recipe.blocks.is_empty() || recipe.regressor.learner().is_some();
        if more_than_conventional && !self.auxiliary.is_empty() {
            features.blocks.set(&Auxiliary, self.auxiliary.clone());
        }
        self.thin_out(&mut features)?;
        let rows = self.recordings.n_samples(Role::Train).min(effort.rows);
        let mut settings =
            FitSettings { features, regressor: recipe.regressor, ..self.settings.clone() };
        settings.network.hidden.fill(effort.units);
        settings.network.epochs = effort.epochs * recipe.times_longer;
        settings.network.early_stopping = true;
        settings.kernel.landmarks = (effort.landmarks * recipe.times_longer).min(rows.max(1));
        Ok(settings)
    }

    /// Removes every second value from the feature block with most values, until the number of feature columns is allowed.
    fn thin_out(&self, features: &mut FeatureSettings) -> Result<(), AnalysisError> {
        let n_gauges = self.recordings.layout().gauge_names.len();
        while let Err(error) = features.check_columns(n_gauges) {
            let longest = features.blocks.used().max_by_key(|(_, values)| values.len());
            let Some((block, values)) = longest.filter(|(_, values)| values.len() > 1) else {
                return Err(error.into());
            };
            let thinned = values.iter().copied().step_by(2).collect();
            features.blocks.set(block, thinned);
        }
        Ok(())
    }

    fn thresholds(&mut self, progress: &Progress) -> Result<Thresholds, AnalysisError> {
        if let Some(known) = self.look_back {
            return Ok(known);
        }
        let study = self.study(progress)?;
        let grid = ThresholdGrid::covering(study.largest_distance(), GRID, GRID)?;
        let map = study.threshold_map(None, &grid, &progress.part(), &|_| {})?;
        Ok(*self.look_back.insert(map.suggestion(Measure::FullScale)?.thresholds))
    }

    /// Returns the values chosen for a feature block, or its default values if no tried list of values reduces the error.
    fn values(
        &mut self,
        block: &'static dyn Block,
        recipe: &Recipe,
        progress: &Progress,
    ) -> Result<Vec<f64>, AnalysisError> {
        if let Appends::Monomials(_) = block.appends() {
            return Ok(vec![recipe.degree]);
        }
        let Some(search) = block.search() else {
            return Ok(block.setting().default.to_vec());
        };
        let times = match search.lists {
            Lists::OneByOne(_) => recipe.times,
            Lists::Even { .. } => Times::Chosen,
        };
        if let Some((_, _, values)) =
            self.values.iter().find(|chosen| (chosen.0, chosen.1) == (block, times))
        {
            return Ok(values.clone());
        }
        let study = self.study(progress)?;
        let values = match times {
            Times::Chosen => {
                study.suggest_block(block, Measure::FullScale, &progress.part())?.values
            }
            Times::Spread => spread(&study.candidates(block, search)),
            Times::EverySample => self.every_sample(),
            Times::Doubling => self.doubling(),
        };
        let values = if values.is_empty() { block.setting().default.to_vec() } else { values };
        self.values.push((block, times, values.clone()));
        Ok(values)
    }

    /// Returns the time between two samples, and a tenth of the duration of the shortest training recording (s).
    fn shortest_and_longest_lag(&self) -> Option<(f64, f64)> {
        let step = self.settings.decimation as f64 / self.recordings.rate_hz(Role::Train)?;
        let training = self.recordings.entries().iter().filter(|entry| entry.role == Role::Train);
        let secs = training.map(|entry| entry.recording.duration_secs());
        Some((step, 0.1 * secs.fold(f64::INFINITY, f64::min)))
    }

    /// Returns lags of 1, 2, 4, 8 … samples (s), up to a tenth of the shortest recording.
    fn doubling(&self) -> Vec<f64> {
        let Some((step, longest)) = self.shortest_and_longest_lag() else { return Vec::new() };
        let lags = (0..MOST_DOUBLINGS).map(|at| step * f64::from(1 << at));
        lags.take_while(|lag| *lag <= longest).map(significant_secs).collect()
    }

    /// Returns lags of 1, 2, 3 … samples (s), up to the limits for [`Times::EverySample`] and to a tenth of the shortest
    /// recording.
    fn every_sample(&self) -> Vec<f64> {
        let Some((step, longest)) = self.shortest_and_longest_lag() else { return Vec::new() };
        let n_gauges = self.recordings.layout().gauge_names.len();
        let n_samples = self.recordings.n_samples(Role::Train) / self.settings.decimation;
        let columns = MOST_LAG_COLUMNS.min((MOST_LAG_WORK / n_samples.max(1)).isqrt());
        let n = MOST_LAGS.min(columns / n_gauges.max(1)).min((longest / step) as usize);
        (1..=n).map(|lag| significant_secs(lag as f64 * step)).collect()
    }

    fn study(&self, progress: &Progress) -> Result<Study, AnalysisError> {
        let settings = FitSettings { ridge: RidgeChoice::Auto, ..self.settings.clone() };
        Study::prepare(&self.request(settings), progress)
    }

    fn row_step(&self, rows: usize) -> usize {
        let n_samples = self.recordings.n_samples(Role::Train);
        n_samples.div_ceil(self.settings.decimation).div_ceil(rows).max(1)
    }

    fn request(&self, settings: FitSettings) -> Request {
        Request {
            datasets: self.datasets.clone(),
            ..Request::fit(Arc::clone(&self.recordings), settings)
        }
    }

    pub fn fit(
        &self,
        settings: FitSettings,
        rows: usize,
        progress: &Progress,
    ) -> Result<Calibration, AnalysisError> {
        let (request, row_step) = (self.request(settings), self.row_step(rows));
        Ok(fit_and_score(&request, false, row_step, &progress.part(), &mut |_| {})?.0)
    }

    /// Fits the training recordings, and returns the errors of each test recording, `n_samples × n_axes` row-major.
    pub fn errors(
        &self,
        settings: FitSettings,
        rows: usize,
        progress: &Progress,
    ) -> Result<Vec<Vec<f64>>, AnalysisError> {
        settings.validate()?;
        let progress = &progress.part();
        let request = self.request(settings);
        let data = request.datasets.get(&request.key(), progress)?;
        let settings = &request.settings;
        let fitted = fit_all(&data, settings, self.row_step(rows), progress, &mut |_| {})?;
        progress.check()?;
        let Fitted { past, mut calibration, held_out, .. } = fitted;
        if let (Regressor::HybridNetwork, Some(learned)) =
            (settings.regressor, &mut calibration.learned)
        {
            learned.scale(&best_shares(&held_out));
        }
        let tested = data.entries.iter().zip(&past);
        let tested = tested.filter(|(entry, _)| entry.role == Role::Test);
        let errors = tested.map(|(entry, past)| {
            let loads = calibration.compensated_loads(&entry.recording, past);
            entry
                .recording
                .loads()
                .iter()
                .zip(loads)
                .map(|(load, computed)| load - computed)
                .collect()
        });
        Ok(errors.collect())
    }
}

/// Rounds a time (s) to six digits for a short text in the settings.
fn significant_secs(secs: f64) -> f64 {
    format!("{secs:.5e}").parse().unwrap_or(secs)
}

/// Returns at most [`SPREAD`] of these values, evenly spaced in the list.
fn spread(candidates: &[f64]) -> Vec<f64> {
    let n = candidates.len().min(SPREAD);
    let at = |k: usize| candidates[k * (candidates.len() - 1) / (n - 1).max(1)];
    (0..n).map(at).collect()
}

/// Lists of candidates that a search can try.
#[derive(Clone, Copy, Debug, Default)]
pub enum Candidates {
    /// Every feature block alone and in pairs, with every regressor.
    #[default]
    All,
    /// Models of the paper of Koike et al. (2019): linear, network, kernel and both in two stages, without and with look-back.
    Paper,
}

/// Candidate model whose thresholds, play radii and times are not chosen yet.
#[derive(Clone, Debug)]
pub struct Recipe {
    pub name: String,
    pub look_back: bool,
    pub blocks: Vec<&'static dyn Block>,
    /// Degree of the polynomial; zero without a polynomial.
    pub degree: f64,
    pub times: Times,
    pub regressor: Regressor,
    /// Factor on a network's epochs or a kernel's landmarks, for a longer training.
    pub times_longer: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Times {
    /// The times (s) that give the lowest cross-validation error of a linear fit.
    Chosen,
    /// Times spread evenly over the range that the recordings allow.
    Spread,
    /// Times of the latest samples, one time per sample, as in a filter with finite impulse response.
    EverySample,
    /// Times that double from one sample to the slowest time that the recordings allow.
    Doubling,
}

/// From the fastest to the slowest training, because a search may end early.
const LEARNERS: [Regressor; 4] =
    [Regressor::HybridNetwork, Regressor::Network, Regressor::HybridKernel, Regressor::Kernel];

impl Recipe {
    /// Returns a linear candidate; a `degree` above zero adds a polynomial of this degree.
    fn linear(look_back: bool, blocks: &[&'static dyn Block], degree: f64) -> Self {
        let polynomials = BLOCKS
            .iter()
            .copied()
            .filter(|block| degree > 0.0 && matches!(block.appends(), Appends::Monomials(_)));
        let blocks: Vec<&'static dyn Block> = blocks.iter().copied().chain(polynomials).collect();
        let named = blocks.iter().map(|block| match block.appends() {
            Appends::Monomials(_) => format!("{} of degree {degree}", block.name()),
            _ => block.name().to_owned(),
        });
        let names: Vec<String> =
            look_back.then(|| "Look-back".to_owned()).into_iter().chain(named).collect();
        Self {
            name: match &names[..] {
                [] => "Conventional".to_owned(),
                names => sentence(&names.join(" + ")),
            },
            look_back,
            blocks,
            degree,
            times: Times::Chosen,
            regressor: Regressor::Linear,
            times_longer: 1,
        }
    }

    fn learned(regressor: Regressor, blocks: &[&'static dyn Block], times: Times) -> Self {
        let features = Self::linear(false, blocks, 0.0);
        let name = match blocks {
            [] => regressor.label().to_owned(),
            _ => format!("{} on {}", regressor.label(), features.name.to_lowercase()),
        };
        Self { name, times, regressor, ..features }
    }

    fn of_every_sample(self) -> Self {
        Self { name: format!("{} of every sample", self.name), times: Times::EverySample, ..self }
    }

    pub fn longer(&self) -> Self {
        let (how, times_longer) = match self.regressor.learner() {
            Some(Learner::Kernel) => ("more landmarks", 3),
            _ => ("trained longer", 4),
        };
        Self { name: format!("{}, {how}", self.name), times_longer, ..self.clone() }
    }
}

/// Returns the words in lower case, except for the first letter of the sentence.
fn sentence(words: &str) -> String {
    let (first, rest) = words.split_at(1);
    format!("{first}{}", rest.to_lowercase())
}

/// Returns the linear candidates: first the conventional calibration, then the others, from the fastest fit to
/// the slowest.
pub fn linear(has_auxiliary: bool) -> Vec<Recipe> {
    let pasts = pasts();
    let (alone, pairs) = (alone(&pasts), pairs(&pasts));
    let each = |lists: &[Vec<&'static dyn Block>], degree: f64| -> Vec<Recipe> {
        lists.iter().map(|blocks| Recipe::linear(false, blocks, degree)).collect()
    };
    let mut recipes = vec![Recipe::linear(false, &[], 0.0)];
    if has_auxiliary {
        let name = "Auxiliary channels".to_owned();
        recipes.push(Recipe { name, ..Recipe::linear(false, &[&Auxiliary], 0.0) });
    }
    recipes.extend([2.0, 3.0].map(|degree| Recipe::linear(false, &[], degree)));
    recipes.push(Recipe::linear(true, &[], 0.0));
    recipes.extend(each(&alone, 0.0));
    recipes.push(Recipe::linear(false, &[&FixedLag], 0.0).of_every_sample());
    recipes.push(Recipe::linear(true, &[], 2.0));
    recipes.extend(each(&alone, 2.0));
    recipes.extend([0.0, 2.0, 3.0].into_iter().flat_map(|degree| each(&pairs, degree)));
    let name = "Everything".to_owned();
    recipes.push(Recipe { name, ..Recipe::linear(true, &pasts, 2.0) });
    recipes
}

/// Returns the models that the paper of Koike et al. (2019) compares, with the kernels that it cites. Load cases have no past,
/// so `is_static` leaves out the look-back.
pub fn paper(is_static: bool) -> Vec<Recipe> {
    let mut recipes = vec![Recipe::linear(false, &[], 0.0), Recipe::linear(false, &[], 2.0)];
    recipes.extend((!is_static).then(|| Recipe::linear(true, &[], 0.0)));
    for learner in LEARNERS {
        let present = Recipe::learned(learner, &[], Times::Chosen);
        let name = format!("{} on look-back", present.name);
        let with_past = Recipe { name, look_back: true, ..present.clone() };
        recipes.push(present);
        recipes.extend((!is_static).then_some(with_past));
    }
    recipes
}

pub fn learned() -> Vec<Recipe> {
    let pasts = pasts();
    let (alone, pairs) = (alone(&pasts), pairs(&pasts));
    let mut recipes = Vec::new();
    for learner in LEARNERS {
        recipes.push(Recipe::learned(learner, &[], Times::Chosen));
        recipes.extend(alone.iter().map(|blocks| Recipe::learned(learner, blocks, Times::Spread)));
        let several = pairs.iter().chain([&pasts]);
        recipes.extend(several.map(|blocks| Recipe::learned(learner, blocks, Times::Chosen)));
    }
    let filter = |learner| Recipe::learned(learner, &[&FixedLag], Times::EverySample);
    let hybrid = [Regressor::HybridNetwork, Regressor::HybridKernel];
    recipes.extend(hybrid.map(|learner| filter(learner).of_every_sample()));
    recipes
}

/// Returns the network that is always trained fully: a short training does not tell how good it becomes.
pub fn always_trained() -> Recipe {
    let recipe = Recipe::learned(Regressor::HybridNetwork, &[&FixedLag], Times::Doubling);
    Recipe { name: format!("{} at doubling times", recipe.name), ..recipe }
}

/// Returns the feature blocks that append earlier gauge values.
fn pasts() -> Vec<&'static dyn Block> {
    let all = BLOCKS.iter().copied();
    all.filter(|block| matches!(block.appends(), Appends::Past(_))).collect()
}

fn alone(blocks: &[&'static dyn Block]) -> Vec<Vec<&'static dyn Block>> {
    blocks.iter().map(|block| vec![*block]).collect()
}

fn pairs(blocks: &[&'static dyn Block]) -> Vec<Vec<&'static dyn Block>> {
    let with_earlier =
        |at: usize| blocks[..at].iter().map(move |earlier| vec![*earlier, blocks[at]]);
    (0..blocks.len()).flat_map(with_earlier).collect()
}

/// Number of segments of each recording, for recordings without at least two groups.
const SEGMENTS: usize = 4;

pub struct NestedFolds {
    pub folds: Vec<Fold>,
    /// All training recordings, cut into groups or segments as in the folds, and the test recordings.
    pub whole: Arc<RecordingSet>,
    /// Description of the cross-validation folds, for the headings of tables.
    pub what: String,
    /// Names of the groups or segments. The choice of a model compares the errors of each group or segment.
    pub parts: Vec<String>,
    /// Number of folds that together hold out each sample once. Further folds predict forward in time.
    pub n_left_out: usize,
}

struct Piece {
    fold: usize,
    part: usize,
    entry: Entry,
}

impl NestedFolds {
    /// Divides the training recordings into folds. Without training recordings, returns [`AnalysisError::NoTraining`].
    pub fn of(recordings: &RecordingSet) -> Result<Self, AnalysisError> {
        let groups = recordings.groups();
        let mut training: Vec<(Entry, usize)> = (recordings.entries().iter().enumerate())
            .filter(|(_, entry)| entry.role == Role::Train)
            .map(|(at, entry)| (groups.with_group_name(at, entry), groups.of[at]))
            .collect();
        let first = training.first().ok_or(AnalysisError::NoTraining)?;
        let run = first.0.recording.source().path();
        let is_one_run = run.is_some()
            && training.iter().all(|(entry, _)| entry.recording.source().path() == run);
        let group_numbers = |training: &[(Entry, usize)]| -> Vec<usize> {
            let numbers: BTreeSet<usize> = training.iter().map(|(_, group)| *group).collect();
            numbers.into_iter().collect()
        };
        let mut numbers = group_numbers(&training);
        if numbers.len() == 1 && is_one_run && are_even(&training) {
            training.iter_mut().enumerate().for_each(|(at, (_, group))| *group = at);
            numbers = group_numbers(&training);
        }
        let n_groups = numbers.len();
        let (pieces, parts, what): (Vec<Piece>, _, _) = if n_groups > 1 {
            let n_folds = n_groups.min(MOST_FITS);
            // If one file has several recordings, a single one (such as one press) is too short for a group. So consecutive
            // recordings are combined.
            let is_coarse = is_one_run && groups.by == GroupedBy::Recording;
            let pieces: Vec<Piece> = (training.into_iter())
                .map(|(entry, group)| {
                    let group = numbers.binary_search(&group).unwrap_or_default();
                    let fold = if is_one_run {
                        group * n_folds / n_groups
                    } else {
                        fit_without(group, n_groups)
                    };
                    Piece { fold, part: if is_coarse { fold } else { group }, entry }
                })
                .collect();
            let what = CrossValidation { by: groups.by, groups: n_groups, parts: n_folds };
            let name = |part: usize| {
                let mut names = pieces.iter().filter(|piece| piece.part == part).map(|piece| {
                    let group = piece.entry.group.as_deref();
                    group.unwrap_or(piece.entry.recording.name())
                });
                let first = names.next().unwrap_or_default();
                match names.next_back().filter(|last| *last != first) {
                    Some(last) => format!("{first} to {last}"),
                    None => first.to_owned(),
                }
            };
            let n_parts = if is_coarse { n_folds } else { n_groups };
            let parts = (0..n_parts).map(name).collect();
            (pieces, parts, what)
        } else {
            // The pieces of one run are cut where the whole run is cut into segments of equal length.
            let n_all: usize = training.iter().map(|(entry, _)| entry.recording.n_samples()).sum();
            let mut first = 0;
            let segments = |(entry, _): (Entry, usize)| {
                let n = entry.recording.n_samples();
                let (before, n_all) = if is_one_run { (first, n_all) } else { (0, n) };
                first += n;
                let at =
                    move |fold: usize| (fold * n_all / SEGMENTS).clamp(before, before + n) - before;
                let ranges = (0..SEGMENTS).map(move |fold| (fold, at(fold)..at(fold + 1)));
                ranges.filter(|(_, range)| !range.is_empty()).map(move |(fold, range)| {
                    let recording = Arc::new(entry.recording.segment(range));
                    Piece { fold, part: fold, entry: Entry { recording, ..entry.clone() } }
                })
            };
            let what = CrossValidation { by: GroupedBy::Block, groups: SEGMENTS, parts: SEGMENTS };
            let parts = (1..=SEGMENTS).map(|at| format!("segment {at}")).collect();
            (training.into_iter().flat_map(segments).collect(), parts, what)
        };
        // Only groups that follow one another in the same file can be predicted forward in time.
        let is_forward = n_groups == 1 || is_one_run && pieces.is_sorted_by_key(|piece| piece.fold);
        let n_left_out = pieces.iter().map(|piece| piece.fold + 1).max().unwrap_or(0);
        let fold =
            |left_out: usize, n_folds: usize| {
                let used = pieces.iter().filter(|piece| piece.fold < n_folds);
                Fold::of(used.map(|piece| {
                    (piece.entry.clone(), (piece.fold == left_out).then_some(piece.part))
                }))
            };
        let mut folds: Vec<Fold> = (0..n_left_out).map(|at| fold(at, n_left_out)).collect();
        if is_forward {
            // The last segment is already predicted from all earlier segments. Fewer than half of the segments are too few
            // for a fit.
            let later = n_left_out.div_ceil(2)..n_left_out.saturating_sub(1);
            folds.extend(later.map(|at| fold(at, at + 1)));
        }
        let training = pieces.iter().map(|piece| (piece.entry.clone(), None));
        let tested = recordings.entries().iter().filter(|entry| entry.role == Role::Test);
        let whole = Fold::of(training.chain(tested.map(|entry| (entry.clone(), Some(0))))).set;
        let what = if folds.len() > n_left_out {
            format!("nested, {what}; and with later segments predicted from earlier ones")
        } else {
            format!("nested, {what}")
        };
        Ok(Self { folds, whole, what, parts, n_left_out })
    }
}

/// Returns true if the pieces of one run can be combined to [`MOST_FITS`] parts of similar length.
fn are_even(training: &[(Entry, usize)]) -> bool {
    let mut n_samples = [0; MOST_FITS];
    for (at, (entry, _)) in training.iter().enumerate() {
        n_samples[at * MOST_FITS / training.len()] += entry.recording.n_samples();
    }
    let all: usize = n_samples.iter().sum();
    n_samples.iter().all(|n| 2 * MOST_FITS * n >= all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_reaches_from_the_first_to_the_last() {
        let of = |n: usize| spread(&(0..n).map(|at| at as f64).collect::<Vec<_>>());
        assert_eq!(of(11), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(of(3), [0.0, 1.0, 2.0]);
        assert_eq!(of(1), [0.0]);
        assert!(of(0).is_empty());
    }
}

#[cfg(test)]
mod recipes_tests {
    use crate::questions::models::recipes::*;

    #[test]
    fn every_block_is_tried_alone_in_pairs_and_by_every_learner() {
        let (linear, learned) = (linear(true), learned());
        assert_eq!(linear[0].name, "Conventional");
        let names: Vec<&str> =
            linear.iter().chain(&learned).map(|recipe| recipe.name.as_str()).collect();
        let mut distinct = names.clone();
        distinct.sort_unstable();
        distinct.dedup();
        assert_eq!(distinct.len(), names.len(), "{names:?}");
        for block in BLOCKS {
            let alone = linear.iter().find(|recipe| recipe.blocks == [*block] && !recipe.look_back);
            assert!(alone.is_some(), "{block:?}");
        }
        assert_eq!((paper(false).len(), paper(true).len()), (11, 6));
        assert!(paper(true).iter().all(|recipe| !recipe.look_back));
        for expected in ["Creep + play", "Linear + network on fixed lag", "Network on play"] {
            assert!(names.contains(&expected), "{names:?}");
        }
    }
}

#[cfg(test)]
mod folds_tests {
    use crate::questions::models::recipes::*;
    use crate::recording::{Axis, Recording, Source, simulated};

    fn of_lengths(n: usize) -> RecordingSet {
        let mut set = RecordingSet::default();
        for entry in simulated::recordings(1).entries().iter().take(n) {
            set.push(Entry::new(entry.recording.decimated(20), Role::Train)).unwrap();
        }
        let tested = simulated::recordings(1).entries()[89].recording.decimated(20);
        set.push(Entry::new(tested, Role::Test)).unwrap();
        set
    }

    #[test]
    fn folds_are_made_of_the_training_recordings() {
        for n in [1, 2, 3, 7] {
            let set = of_lengths(n);
            let found = NestedFolds::of(&set).unwrap();
            let all = set.n_samples(Role::Train);
            let folds = &found.folds[..found.n_left_out];
            let left_out: usize = folds.iter().map(|fold| fold.set.n_samples(Role::Test)).sum();
            assert_eq!(left_out, all, "{n} recordings");
            for fold in folds {
                let [tested, others] =
                    [Role::Test, Role::Train].map(|role| fold.set.n_samples(role));
                assert!(tested > 0 && tested + others == all, "{n} recordings");
                let tested = fold.set.entries().iter().filter(|entry| entry.role == Role::Test);
                assert_eq!(tested.count(), fold.parts.len());
            }
            assert_eq!(found.whole.n_samples(Role::Train), all);
        }
        assert!(matches!(
            NestedFolds::of(&RecordingSet::default()),
            Err(AnalysisError::NoTraining)
        ));
    }

    /// One recording in four segments: the third is also predicted from the first two.
    #[test]
    fn one_run_is_predicted_forward_in_time() {
        let found = NestedFolds::of(&of_lengths(1)).unwrap();
        assert_eq!((found.folds.len(), found.n_left_out), (5, 4));
        let forward = &found.folds[4];
        assert_eq!(forward.parts, [2]);
        let entries = forward.set.entries();
        let last = |role| {
            let last = entries.iter().rfind(|entry| entry.role == role).unwrap();
            last.recording.times().get(last.recording.n_samples() - 1).copied().unwrap()
        };
        assert!(last(Role::Train) < last(Role::Test));
        assert_eq!(NestedFolds::of(&of_lengths(3)).unwrap().folds.len(), 3);
    }

    /// Twelve presses in one file form five parts. Twelve presses in twelve files form twelve parts.
    #[test]
    fn presses_of_one_file_are_no_groups() {
        let all = simulated::recordings(1);
        let found = |file: &dyn Fn(usize) -> String, group: &dyn Fn(usize) -> Option<String>| {
            let mut set = RecordingSet::default();
            for at in 0..12 {
                let thinned = all.entries()[at].recording.decimated(20);
                let thinned = Recording::new(
                    format!("press #{}", at + 1),
                    Source::File(file(at).into()),
                    thinned.times().to_vec(),
                    thinned.gauge_names().to_vec(),
                    thinned.gauges().to_vec(),
                    thinned.axes().to_vec(),
                    thinned.loads().to_vec(),
                );
                let mut thinned = thinned.unwrap();
                thinned.group = group(at);
                set.push(Entry::new(thinned, Role::Train)).unwrap();
            }
            NestedFolds::of(&set).unwrap()
        };
        let one = |_| "/a.csv".to_owned();
        let of_one = found(&one, &|_| None).parts;
        assert_eq!((of_one.len(), &*of_one[0]), (5, "press #1 to press #3"));
        assert_eq!(found(&|at| format!("/{at}.csv"), &|_| None).parts.len(), 12);
        // A column names four groups, which follow one another or alternate. Only groups that follow one another are predicted
        // forward in time.
        let days = found(&one, &|at| Some(format!("day {}", at / 3)));
        assert_eq!(days.parts, ["day 0", "day 1", "day 2", "day 3"]);
        assert_eq!((days.n_left_out, days.folds.len()), (4, 5));
        let conditions = found(&one, &|at| Some(format!("condition {}", at % 4)));
        assert_eq!((conditions.n_left_out, conditions.folds.len()), (4, 4));
    }

    /// Pauses cut the file into twelve similar pieces, or late rows into a long and two short pieces.
    #[test]
    fn pieces_of_one_run_are_combined_or_cut_into_parts_of_similar_length() {
        let n = 240;
        let values = || (0..n).map(|k| k as f64).collect::<Vec<_>>();
        let source = Source::File("/a.csv".into());
        let (names, axes) = (vec!["S1".to_owned()], vec![Axis::Fz]);
        let whole = Recording::new("a", source, values(), names, values(), axes, values()).unwrap();
        let found = |ends: Vec<usize>| {
            let mut set = RecordingSet::default();
            let mut start = 0;
            for end in ends {
                let mut piece = whole.segment(start..end);
                piece.run = Some(0);
                set.push(Entry::new(piece, Role::Train)).unwrap();
                start = end;
            }
            let found = NestedFolds::of(&set).unwrap();
            let left_out = found.folds.iter().take(found.n_left_out);
            let sizes: Vec<usize> = left_out.map(|fold| fold.set.n_samples(Role::Test)).collect();
            assert_eq!(sizes.iter().sum::<usize>(), n);
            (found.parts.len(), sizes)
        };
        let (n_parts, sizes) = found((1..=12).map(|piece| piece * n / 12).collect());
        assert_eq!((n_parts, sizes), (5, vec![60, 40, 60, 40, 40]));
        let (n_parts, sizes) = found(vec![n - 10, n - 9, n]);
        assert_eq!((n_parts, sizes), (4, vec![60; 4]));
    }

    /// The recordings of a fold still have groups, so that thresholds are also chosen by leaving out groups.
    #[test]
    fn a_fold_is_a_whole_group_and_the_others_stay_groups() {
        let all = simulated::recordings(1);
        let mut set = RecordingSet::default();
        for at in [0, 1, 15, 16, 30, 31] {
            let recording = all.entries()[at].recording.decimated(20);
            set.push(Entry::new(recording, Role::Train)).unwrap();
        }
        let found = NestedFolds::of(&set).unwrap();
        assert_eq!(found.what, "nested, by path: leave-one-path-out, 3 groups");
        assert_eq!(found.parts, ["path 1", "path 2", "path 3"]);
        for (fold, path) in found.folds.iter().zip(["path 1", "path 2", "path 3"]) {
            for entry in fold.set.entries() {
                let is_own = entry.group.as_deref() == Some(path);
                assert_eq!(entry.role == Role::Test, is_own);
            }
            let groups = fold.set.groups();
            assert_eq!(groups.by, GroupedBy::Group);
        }
    }
}
