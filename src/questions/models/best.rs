//! Finding the model to calibrate with: sensible candidates in the order of their cost, each scored by nested
//! cross-validation, and the simplest that is within one standard error of the best.
//!
//! Guarantees: for each fold everything is done again without it, as it would be if its recordings had never been made: the
//! conventional calibration, thresholds, the values of blocks, ridge, what learns. Recordings in the test role take no part.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::calibration::{
    Calibration, FitSettings, Quality, Regressor, RidgeChoice, Scores, SettingsError,
};
use crate::features::{
    Auxiliary, BLOCKS, Block, Blocks, Creep, FeatureSettings, FixedLag, Play, Polynomial,
    Thresholds,
};
use crate::progress::Progress;
use crate::questions::dataset::Datasets;
use crate::questions::error::AnalysisError;
use crate::questions::models::table::{Mark, Model, ModelRow, model_table, weights};
use crate::questions::models::training::train_unscored;
use crate::questions::request::Request;
use crate::questions::thresholds::study::Study;
use crate::questions::thresholds::{Measure, ScoreSet, ThresholdGrid, paired};
use crate::recording::{Entry, RECORDING, RecordingSet, Role};
use crate::report::Table;
use crate::scoring::numbers::significant;

/// More folds than this are put together: each costs a whole search.
const MAX_FOLDS: usize = 5;
/// How much wider one standard error is that is known from 2, 3, 4, 5 folds only: Student's t at the share that lies within one
/// standard deviation of a normal distribution.
const OF_FOLDS: [f64; MAX_FOLDS - 1] = [1.837, 1.321, 1.197, 1.142];
/// With fewer groups than can be left out, each recording is cut into so many.
const SEGMENTS: usize = 4;
/// Values of F_th and of t_th that are tried.
const GRID: usize = 12;
/// More training samples than this are thinned out while models are compared.
const ENOUGH_SAMPLES: usize = 60_000;
/// Epochs of a network while models are compared.
const EPOCHS: usize = 60;
/// The degree of a polynomial.
const DEGREE: f64 = 2.0;

/// A way to calibrate, its numbers still open: they are chosen from the training recordings.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    /// What people call it.
    pub name: &'static str,
    /// Whether there is a look-back.
    look_back: bool,
    /// Other blocks.
    blocks: &'static [&'static dyn Block],
    regressor: Regressor,
}

const fn linear(
    name: &'static str,
    look_back: bool,
    blocks: &'static [&'static dyn Block],
) -> Recipe {
    Recipe { name, look_back, blocks, regressor: Regressor::Linear }
}

const fn learned(
    name: &'static str,
    blocks: &'static [&'static dyn Block],
    regressor: Regressor,
) -> Recipe {
    Recipe { name, look_back: false, blocks, regressor }
}

/// What is tried, cheap ones first.
pub const RECIPES: &[Recipe] = &[
    linear("Conventional", false, &[]),
    linear("Polynomial", false, &[&Polynomial]),
    linear("Look-back", true, &[]),
    linear("Lag", false, &[&FixedLag]),
    linear("Creep", false, &[&Creep]),
    linear("Play", false, &[&Play]),
    linear("Look-back + polynomial", true, &[&Polynomial]),
    linear("Creep + polynomial", false, &[&Creep, &Polynomial]),
    linear("Play + polynomial", false, &[&Play, &Polynomial]),
    linear("Play + creep", false, &[&Play, &Creep]),
    linear("Play + creep + polynomial", false, &[&Play, &Creep, &Polynomial]),
    linear("Everything", true, &[&FixedLag, &Creep, &Play, &Polynomial]),
    learned("Linear + kernel", &[], Regressor::HybridKernel),
    learned("Linear + kernel on play", &[&Play], Regressor::HybridKernel),
    learned("Linear + kernel on play and creep", &[&Play, &Creep], Regressor::HybridKernel),
    learned("Linear + network on play and creep", &[&Play, &Creep], Regressor::HybridNetwork),
];

/// Tried, too, where the recordings have auxiliary channels; from there on all candidates take them, and leave away what does not help.
const AUXILIARY: Recipe = linear("Auxiliary channels", false, &[&Auxiliary]);
/// How a gauge may follow them (s): at once, and more and more slowly.
const AUXILIARY_LAGS: [&[f64]; 4] = [&[0.0], &[0.0, 5.0], &[0.0, 20.0], &[0.0, 100.0]];
/// A lag must bring the squared error below this share of that without one.
const LAG_HELPS: f64 = 0.9;

/// What is asked.
#[derive(Clone, Debug)]
pub struct Search {
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// Offset, full scales, what F_th is measured in: what all candidates have in common.
    pub settings: FitSettings,
    /// No candidate is begun after so long.
    pub time_limit: Duration,
}

/// A candidate that was tried.
#[derive(Clone, Debug, Serialize)]
pub struct Tried {
    /// What it is.
    pub name: &'static str,
    /// The blocks in words; empty without any.
    pub blocks: String,
    /// How the load is made of them.
    pub regressor: Regressor,
    /// Its settings, with the numbers that all training recordings ask for, and how it came out over all folds. Recordings in
    /// the test role have no say in the choice.
    #[serde(flatten)]
    pub model: Model,
    /// The root of its mean squared error, each axis relative to the conventional calibration: 1 is no better.
    pub relative: f64,
    /// Whether it is within one standard error of the best.
    pub is_good: bool,
    /// Whether it is proposed: the first of the good ones.
    pub is_proposed: bool,
    /// Squared errors, `n_folds × n_axes`.
    #[serde(skip)]
    squares: Vec<f64>,
}

impl Tried {
    /// Whether it is the one to take.
    pub fn mark(&self) -> Mark {
        match (self.is_proposed, self.is_good) {
            (true, _) => Mark::Proposed,
            (false, true) => Mark::Good,
            (false, false) => Mark::None,
        }
    }

    /// A row of the table of models.
    fn row(&self) -> ModelRow<'_> {
        ModelRow {
            mark: self.mark().cell(),
            name: self.name,
            data: "",
            settings: &self.model.settings,
            state: Ok(&self.model),
        }
    }
}

/// How a search came out, or how far it is.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Best {
    /// What was tried, in the order of cost.
    pub tried: Vec<Tried>,
    /// What could not be tried, and why.
    pub failed: Vec<(&'static str, String)>,
    /// How many candidates the time did not allow.
    pub n_left: usize,
    /// How many folds were left out in turn.
    pub n_folds: usize,
    /// What a fold is, in words.
    pub folds: String,
    /// Of each recording every so many-th sample was used.
    pub decimation: usize,
}

impl Best {
    /// What is proposed; `None` while nothing is tried.
    pub fn proposed(&self) -> Option<&Tried> {
        self.tried.iter().find(|tried| tried.is_proposed)
    }

    /// Why the proposed one is proposed, in a sentence; `None` while nothing is tried.
    pub fn why(&self) -> Option<String> {
        let proposed = self.proposed()?;
        let lowest = self.lowest()?;
        let percent = |own: &Tried| format!("{} %", significant(100.0 * own.relative, 3));
        let of_all = format!("of the conventional error ({})", self.folds);
        Some(match lowest.name == proposed.name {
            true => format!(
                "Proposed: {}. Of {} tried it has the lowest error, {} {of_all}, and nothing cheaper is within one standard error of it",
                proposed.name,
                self.tried.len(),
                percent(proposed)
            ),
            false => format!(
                "Proposed: {}. Its error, {} {of_all}, is within one standard error of the lowest, {} of {}, and nothing cheaper is",
                proposed.name,
                percent(proposed),
                percent(lowest),
                lowest.name
            ),
        })
    }

    /// What else there is to know of the search, a sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if self.n_left > 0 {
            let n = self.n_left;
            remarks.push(format!("The time did not allow {n} more; a longer limit does"));
        }
        let failed = self.failed.iter();
        remarks.extend(failed.map(|(name, why)| format!("{name} could not be tried: {why}")));
        remarks
    }

    /// Takes one more, and says anew which are good.
    fn push(&mut self, mut tried: Tried, fold_samples: &[u64]) {
        // The first is always the conventional calibration.
        let conventional = self.tried.first().unwrap_or(&tried);
        let reference = conventional.squares.clone();
        tried.model.conventional = conventional.model.scores.clone();
        tried.model.left_out.clone_from(&self.folds);
        // Where nothing has an error there is nothing to be better at.
        tried.relative = tried.model.relative(ScoreSet::LeftOut).unwrap_or(1.0);
        let conventional = tried.model.conventional.cv_rmse.as_deref();
        let weights = weights(conventional.unwrap_or_default());
        let against =
            |own: &Tried, other: &[f64]| paired(&own.squares, other, fold_samples, &weights);
        let spread = against(&tried, &reference).map_or(0.0, |found| found.standard_error);
        tried.model.spread = Some(spread);
        self.tried.push(tried);
        let best = self.lowest().map(|best| best.squares.clone());
        let best = best.unwrap_or_default();
        let few = OF_FOLDS[fold_samples.len().clamp(2, MAX_FOLDS) - 2];
        for own in &mut self.tried {
            own.is_good = against(own, &best)
                .is_none_or(|found| found.difference <= few * found.standard_error);
        }
        let first = self.tried.iter().position(|own| own.is_good);
        for (at, own) in self.tried.iter_mut().enumerate() {
            own.is_proposed = Some(at) == first;
        }
    }

    fn lowest(&self) -> Option<&Tried> {
        let by_error = |a: &&Tried, b: &&Tried| a.relative.total_cmp(&b.relative);
        self.tried.iter().min_by(by_error)
    }

    /// One row per candidate: its errors on these samples, what it costs, and whether it is good.
    pub fn table(&self, set: ScoreSet) -> Table {
        let axes = (self.tried.first()).map_or(&[][..], |tried| &tried.model.axes);
        let folds = match set {
            ScoreSet::Test => String::new(),
            _ => format!("; {}", self.folds),
        };
        Table {
            title: format!("RMSE, {}{folds}", set.label()),
            note: "→ proposed: the first within one standard error of the best; = within it, too"
                .to_owned(),
            ..model_table(axes, &[set], self.tried.iter().map(Tried::row))
        }
    }
}

/// Tries the candidates, and shows what is known after each.
///
/// # Errors
/// [`AnalysisError`] where there is nothing to calibrate, or somebody asked to stop.
pub fn find_best(
    search: &Search,
    progress: &Progress,
    show: &(dyn Fn(&Best) + Sync),
) -> Result<Best, AnalysisError> {
    let start = Instant::now();
    search.settings.validate()?;
    let (folds, what) = folds(&search.recordings)?;
    let n_samples = |set: &RecordingSet, role| -> usize {
        let own = set.entries().iter().filter(|entry| entry.role == role);
        own.map(|entry| entry.recording.n_samples()).sum()
    };
    let n_train = n_samples(&search.recordings, Role::Train);
    let asked = search.settings.decimation;
    let thinned = asked.max(n_train.div_ceil(ENOUGH_SAMPLES));
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
    let mut best =
        Best { n_folds: folds.len(), folds: what, decimation: thinned, ..Best::default() };
    let mut whole = Side::new(Arc::clone(&search.recordings), &common);
    whole.settle_auxiliary(progress)?;
    let mut folds: Vec<Side> = (folds.into_iter())
        .map(|set| Side { auxiliary: whole.auxiliary.clone(), ..Side::new(Arc::new(set), &common) })
        .collect();
    let (first, others) = RECIPES.split_at(1);
    let with_auxiliary = (!whole.auxiliary.is_empty()).then_some(&AUXILIARY);
    let recipes: Vec<&Recipe> = first.iter().chain(with_auxiliary).chain(others).collect();
    progress.add_total((recipes.len() * (folds.len() + 1)) as u64);
    for (at, &recipe) in recipes.iter().enumerate() {
        progress.check()?;
        if at > 0 && start.elapsed() > search.time_limit {
            best.n_left = recipes.len() - at;
            break;
        }
        let since = Instant::now();
        match try_one(recipe, asked, &mut whole, &mut folds, progress) {
            Ok((mut tried, fold_samples)) => {
                let seconds = since.elapsed().as_secs_f64();
                let is_same = |own: &Tried| own.model.settings == tried.model.settings;
                // What is left of it once nothing useless is in it may have been tried before.
                if !best.tried.iter().any(is_same) {
                    tried.model.seconds = Some(seconds);
                    best.push(tried, &fold_samples);
                }
            }
            Err(AnalysisError::Cancelled(cancelled)) => return Err(cancelled.into()),
            // Nothing can be compared without the first.
            Err(error) if at == 0 => return Err(error),
            Err(error) => best.failed.push((recipe.name, error.to_string())),
        }
        show(&best);
    }
    Ok(best)
}

fn try_one(
    recipe: &Recipe,
    decimation: usize,
    whole: &mut Side,
    folds: &mut [Side],
    progress: &Progress,
) -> Result<(Tried, Vec<u64>), AnalysisError> {
    let run = |side: &mut Side| {
        let settings = side.settle(recipe, progress)?;
        let calibration = side.fit(settings.clone(), progress)?;
        progress.advance(1);
        Ok::<_, AnalysisError>((settings, calibration))
    };
    // Each has a thread of its own: a fold takes long, and what a window asks for waits for the threads that all share.
    let run = &run;
    let fitted: Vec<(FitSettings, Calibration)> = std::thread::scope(|scope| {
        let begun: Vec<_> = (folds.iter_mut()).map(|side| scope.spawn(move || run(side))).collect();
        let ended = begun.into_iter().map(|fold| match fold.join() {
            Ok(fitted) => fitted,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        ended.collect::<Result<_, _>>()
    })?;
    let n_axes = fitted[0].1.axes.len();
    let mut squares = Vec::new();
    let mut fold_samples = Vec::new();
    for (_, calibration) in &fitted {
        let Quality { n_test, compensated, .. } = &calibration.quality;
        let rmse = compensated.test_rmse.as_ref();
        let rmse = rmse.ok_or(AnalysisError::NoTraining)?;
        squares.extend(rmse.iter().map(|rmse| rmse * rmse * *n_test as f64));
        fold_samples.push(*n_test);
    }
    let (mut settings, calibration) = run(whole)?;
    settings.decimation = decimation;
    leave_away(&mut settings.features, &calibration);
    let n: u64 = fold_samples.iter().sum();
    let cv_rmse = (0..n_axes).map(|axis| {
        let own: f64 = squares.iter().skip(axis).step_by(n_axes).sum();
        (own / n.max(1) as f64).sqrt()
    });
    let quality = &calibration.quality.compensated;
    let scores = Scores { cv_rmse: Some(cv_rmse.collect()), ..quality.clone() };
    let spread = |axis: usize| spread(&squares, &fold_samples, axis);
    let tried = Tried {
        name: recipe.name,
        blocks: settings.features.describe(),
        regressor: recipe.regressor,
        model: Model {
            scores,
            cv_spread: (0..n_axes).map(spread).collect(),
            trained: None,
            ..Model::fitted(settings, &Arc::new(calibration), &whole.recordings)
        },
        relative: 1.0,
        is_good: false,
        is_proposed: false,
        squares,
    };
    Ok((tried, fold_samples))
}

/// The standard deviation over the folds of the RMSE of one axis.
fn spread(squares: &[f64], fold_samples: &[u64], axis: usize) -> f64 {
    let n_axes = squares.len() / fold_samples.len().max(1);
    let own = squares.iter().skip(axis).step_by(n_axes.max(1));
    let rmse = own.zip(fold_samples).map(|(square, n)| (square / (*n).max(1) as f64).sqrt());
    let rmse: Vec<f64> = rmse.collect();
    let mean = rmse.iter().sum::<f64>() / rmse.len().max(1) as f64;
    let variance = rmse.iter().map(|rmse| (rmse - mean).powi(2)).sum::<f64>();
    (variance / rmse.len().saturating_sub(1).max(1) as f64).sqrt()
}

/// Takes out the blocks that help no axis.
fn leave_away(features: &mut FeatureSettings, calibration: &Calibration) {
    let helps = |block: &str| {
        let own = calibration.quality.ridge_by_block.iter().find(|own| own.block == block);
        own.is_none_or(|own| own.strengths.iter().any(Option::is_some))
    };
    let alone = |look_backs: &[Thresholds], blocks: Blocks| FeatureSettings {
        look_backs: look_backs.to_vec(),
        blocks,
        // What they are called by.
        auxiliary: calibration.features.auxiliary.clone(),
        ..features.clone()
    };
    let mut kept = alone(&[], Blocks::default());
    if helps(&alone(&features.look_backs, Blocks::default()).describe()) {
        kept.look_backs.clone_from(&features.look_backs);
    }
    for (block, values) in features.blocks.used() {
        let own = Blocks::default().with(block, values);
        if helps(&alone(&[], own).describe()) {
            kept.blocks.set(block, values.to_vec());
        }
    }
    kept.auxiliary.clone_from(&features.auxiliary);
    *features = kept;
}

/// Recordings to calibrate on and to score, with what was chosen from the former.
struct Side {
    recordings: Arc<RecordingSet>,
    settings: FitSettings,
    datasets: Datasets,
    /// What the thresholds of a look-back are to be.
    look_back: Option<FeatureSettings>,
    /// The values of blocks that were looked for.
    values: Vec<(&'static dyn Block, Vec<f64>)>,
    /// Those of the auxiliary channels; empty where there are none.
    auxiliary: Vec<f64>,
}

impl Side {
    fn new(recordings: Arc<RecordingSet>, settings: &FitSettings) -> Self {
        Self {
            recordings,
            settings: settings.clone(),
            datasets: Datasets::default(),
            look_back: None,
            values: Vec::new(),
            auxiliary: Vec::new(),
        }
    }

    /// Finds with which lags the auxiliary channels do best, if there are any.
    fn settle_auxiliary(&mut self, progress: &Progress) -> Result<(), AnalysisError> {
        let (mut at_once, mut least) = (None, f64::INFINITY);
        for lags in AUXILIARY_LAGS {
            let mut settings = self.settings.clone();
            settings.features.blocks.set(&Auxiliary, lags.to_vec());
            let calibration = self.fit(settings, progress)?;
            if calibration.features.auxiliary.is_empty() {
                return Ok(());
            }
            let scores = &calibration.quality.compensated;
            let errors = scores.cv_rmse.as_ref().or(scores.train_rmse.as_ref());
            let scaled = errors.into_iter().flatten().zip(&calibration.full_scale);
            let scaled = scaled.filter(|(_, scale)| **scale > 0.0);
            let square: f64 = scaled.map(|(error, scale)| (error / scale).powi(2)).sum();
            let helps = at_once.is_none_or(|at_once| square < LAG_HELPS * at_once);
            if helps && square < least {
                self.auxiliary = lags.to_vec();
                least = square;
            }
            at_once = at_once.or(Some(square));
        }
        Ok(())
    }

    /// The settings of a recipe with the numbers that the training recordings ask for.
    fn settle(
        &mut self,
        recipe: &Recipe,
        progress: &Progress,
    ) -> Result<FitSettings, AnalysisError> {
        let mut features = match recipe.look_back {
            true => self.thresholds(progress)?,
            false => self.settings.features.clone(),
        };
        for &block in BLOCKS {
            if recipe.blocks.contains(&block) && block != (&Auxiliary as &dyn Block) {
                features.blocks.set(block, self.values(block, progress)?);
            }
        }
        // The first is the conventional calibration.
        if !self.auxiliary.is_empty() && recipe.name != RECIPES[0].name {
            features.blocks.set(&Auxiliary, self.auxiliary.clone());
        }
        let n_gauges = self.recordings.layout().gauge_names.len();
        features.check_columns(n_gauges).map_err(SettingsError::from)?;
        let mut settings =
            FitSettings { features, regressor: recipe.regressor, ..self.settings.clone() };
        settings.network.epochs = settings.network.epochs.min(EPOCHS);
        Ok(settings)
    }

    /// A look-back with the thresholds of the lowest left-out error.
    fn thresholds(&mut self, progress: &Progress) -> Result<FeatureSettings, AnalysisError> {
        if self.look_back.is_none() {
            let study = self.study(progress)?;
            let grid = ThresholdGrid::covering(study.largest_distance(), GRID, GRID)?;
            let map = study.threshold_map(&grid, &progress.part(), &|_| {})?;
            let suggestion = map.suggestion(Measure::FullScale)?;
            self.look_back = Some(FeatureSettings {
                look_backs: vec![suggestion.thresholds],
                ..self.settings.features.clone()
            });
        }
        Ok(self.look_back.clone().unwrap_or_default())
    }

    /// The list of a block; its default where no list helps by itself.
    fn values(
        &mut self,
        block: &'static dyn Block,
        progress: &Progress,
    ) -> Result<Vec<f64>, AnalysisError> {
        if block.search().is_none() {
            return Ok(match block.setting().choices() {
                Some(_) => vec![DEGREE],
                None => block.setting().default.to_vec(),
            });
        }
        if let Some((_, values)) = self.values.iter().find(|(own, _)| *own == block) {
            return Ok(values.clone());
        }
        let study = self.study(progress)?;
        let found = study.suggest_block(block, Measure::FullScale, &progress.part())?;
        let values = match found.values.is_empty() {
            true => block.setting().default.to_vec(),
            false => found.values,
        };
        self.values.push((block, values.clone()));
        Ok(values)
    }

    fn study(&self, progress: &Progress) -> Result<Study, AnalysisError> {
        let settings = FitSettings { ridge: RidgeChoice::Auto, ..self.settings.clone() };
        Study::prepare(&self.datasets, Arc::clone(&self.recordings), settings, progress)
    }

    fn fit(
        &self,
        settings: FitSettings,
        progress: &Progress,
    ) -> Result<Calibration, AnalysisError> {
        let request = Request {
            datasets: self.datasets.clone(),
            ..Request::fit(Arc::clone(&self.recordings), settings)
        };
        train_unscored(&request, &progress.part())
    }
}

/// The training recordings with each fold in the test role in turn, and what a fold is.
fn folds(recordings: &RecordingSet) -> Result<(Vec<RecordingSet>, String), AnalysisError> {
    let groups = recordings.groups();
    let training: Vec<(Entry, usize)> = (recordings.entries().iter().enumerate())
        .filter(|(_, entry)| entry.role == Role::Train)
        .map(|(at, entry)| (groups.said(at, entry), groups.of[at]))
        .collect();
    if training.is_empty() {
        return Err(AnalysisError::NoTraining);
    }
    let of_training: Vec<usize> = training.iter().map(|(_, group)| *group).collect();
    let mut numbers = of_training.clone();
    numbers.sort_unstable();
    numbers.dedup();
    let n_groups = numbers.len();
    // Two are enough: a segment begins without a past, which blocks with a long memory pay for.
    let (of_fold, n_folds, what) = if n_groups > 1 {
        let n_folds = n_groups.min(MAX_FOLDS);
        let of_fold = training.iter().map(|(entry, group)| {
            let number = numbers.binary_search(group).unwrap_or_default();
            (number % n_folds, entry.clone())
        });
        let noun = match groups.by == RECORDING {
            true => "recordings".to_owned(),
            false => format!("groups by {}", groups.by),
        };
        let what = match n_groups == n_folds {
            true => format!("nested: {n_folds} {noun}, each left out in turn"),
            false => format!("nested: {n_groups} {noun} in {n_folds} folds"),
        };
        (of_fold.collect::<Vec<_>>(), n_folds, what)
    } else {
        let cut = training.iter().flat_map(|(entry, _)| {
            let segments = entry.recording.segments(SEGMENTS).into_iter().enumerate();
            segments.map(|(fold, segment)| {
                let mut own = entry.clone();
                own.recording = Arc::new(segment);
                (fold, own)
            })
        });
        let what =
            format!("nested, by {SEGMENTS} segments of the recordings: there is but one group");
        (cut.collect(), SEGMENTS, what)
    };
    let without = |fold: usize| -> Result<RecordingSet, AnalysisError> {
        let mut set = RecordingSet::default();
        for (own, entry) in &of_fold {
            let mut entry = entry.clone();
            if *own == fold {
                entry.role = Role::Test;
            }
            set.push(entry).expect("they were together before");
        }
        Ok(set)
    };
    let sets = (0..n_folds).map(without).collect::<Result<_, _>>()?;
    Ok((sets, what))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Axis, simulated};

    /// A sensor whose zero follows a temperature slowly.
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
            time_limit: Duration::from_millis(1),
        };
        let best = find_best(&search, &Progress::default(), &|_| {}).unwrap();
        assert_eq!(best.tried[0].name, "Conventional");
        assert_eq!(best.n_left, RECIPES.len(), "the time allowed one");
        let patient = Search { time_limit: Duration::from_secs(3), ..search };
        let best = find_best(&patient, &Progress::default(), &|_| {}).unwrap();
        let own = &best.tried[1];
        assert_eq!(own.name, "Auxiliary channels");
        assert!(own.relative < 0.2, "{}", own.relative);
        assert_eq!(own.model.settings.features.blocks.of(&Auxiliary), [0.0, 20.0]);
        assert!(best.proposed().unwrap().relative < 0.2);
    }

    fn of_lengths(n: usize) -> RecordingSet {
        let mut set = RecordingSet::default();
        for entry in simulated::recordings(1).entries().iter().take(n) {
            set.push(Entry::new(entry.recording.decimated(20), Role::Train)).unwrap();
        }
        let tested = simulated::recordings(1).entries()[89].recording.decimated(20);
        set.push(Entry::new(tested, Role::Test)).unwrap();
        set
    }

    /// Each training sample is left out once, and is trained on in every other fold; nothing of the test is anywhere.
    #[test]
    fn folds_are_made_of_the_training_recordings() {
        for n in [1, 2, 3, 7] {
            let set = of_lengths(n);
            let (folds, _) = folds(&set).unwrap();
            let samples = |set: &RecordingSet, role| -> usize {
                let own = set.entries().iter().filter(|entry| entry.role == role);
                own.map(|entry| entry.recording.n_samples()).sum()
            };
            let all = samples(&set, Role::Train);
            let left_out: usize = folds.iter().map(|fold| samples(fold, Role::Test)).sum();
            assert_eq!(left_out, all, "{n} recordings");
            for fold in &folds {
                let (own, others) = (samples(fold, Role::Test), samples(fold, Role::Train));
                assert!(own > 0 && own + others == all, "{n} recordings");
            }
        }
        assert!(matches!(folds(&RecordingSet::default()), Err(AnalysisError::NoTraining)));
    }

    /// What a choice within a fold leaves out must be groups, too, though fewer of them are left to be found.
    #[test]
    fn a_fold_is_a_whole_group_and_the_others_stay_groups() {
        let all = simulated::recordings(1);
        let mut set = RecordingSet::default();
        for at in [0, 1, 15, 16, 30, 31] {
            let recording = all.entries()[at].recording.decimated(20);
            set.push(Entry::new(recording, Role::Train)).unwrap();
        }
        let (folds, what) = folds(&set).unwrap();
        assert_eq!(what, "nested: 3 groups by path, each left out in turn");
        for (fold, path) in folds.iter().zip(["path 1", "path 2", "path 3"]) {
            for entry in fold.entries() {
                let is_own = entry.group.as_deref() == Some(path);
                assert_eq!(entry.role == Role::Test, is_own);
            }
            let groups = fold.groups();
            assert_eq!(groups.by, "group");
        }
    }

    fn tried(name: &'static str, squares: &[f64]) -> Tried {
        let sum: f64 = squares.iter().sum();
        Tried {
            name,
            blocks: String::new(),
            regressor: Regressor::Linear,
            model: Model {
                axes: vec![Axis::Fz],
                scores: Scores { cv_rmse: Some(vec![(sum / 40.0).sqrt()]), ..Scores::default() },
                ..Model::default()
            },
            relative: 0.0,
            is_good: false,
            is_proposed: false,
            squares: squares.to_vec(),
        }
    }

    /// Mean squares 10, 1, 0.9: the last is best, but not by more than the folds disagree.
    #[test]
    fn the_first_within_one_standard_error_is_proposed() {
        let mut best = Best::default();
        let samples = [10; 4];
        best.push(tried("conventional", &[100.0; 4]), &samples);
        assert_eq!(best.proposed().unwrap().name, "conventional");
        best.push(tried("play", &[12.0, 8.0, 10.0, 10.0]), &samples);
        assert_eq!(best.proposed().unwrap().name, "play");
        best.push(tried("everything", &[6.0, 12.0, 9.0, 9.0]), &samples);
        assert_eq!(best.proposed().unwrap().name, "play");
        assert!((best.tried[2].relative - 0.09_f64.sqrt()).abs() < 1e-12);
        best.push(tried("better", &[5.0; 4]), &samples);
        assert_eq!(best.proposed().unwrap().name, "better");
        assert!(!best.tried[1].is_good);
    }

    /// Folds of 4 and 9 samples with RMSE 1 and 3 on the first axis, 2 and 2 on the second.
    #[test]
    fn the_spread_is_that_of_the_folds_errors() {
        let squares = [4.0, 16.0, 81.0, 36.0];
        assert!((spread(&squares, &[4, 9], 0) - 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(spread(&squares, &[4, 9], 1), 0.0);
        assert_eq!(spread(&squares[..2], &[4], 0), 0.0);
    }
}
