//! Candidates of a model search, and the choice of their thresholds, play radii and times on the training recordings of one
//! cross-validation fold.
//!
//! A new feature block becomes a candidate as soon as the list of feature blocks has a line for it.

use std::sync::Arc;

use crate::{
    calibration::{Calibration, FitSettings, Learner, Regressor, RidgeChoice},
    features::{Appends, Auxiliary, BLOCKS, Block, FeatureSettings, FixedLag, Lists, Thresholds},
    progress::Progress,
    questions::{
        dataset::Datasets,
        error::AnalysisError,
        models::training::{Fitted, best_shares, fit_all, fit_and_score},
        request::Request,
        thresholds::{Measure, ThresholdGrid, study::Study},
    },
    recording::{RecordingSet, Role},
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
