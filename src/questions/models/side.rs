//! One cross-validation fold of a model search: its recordings, and the thresholds, play radii and times that were chosen on
//! its training recordings.

use std::sync::Arc;

use crate::{
    calibration::{Calibration, FitSettings, Regressor, RidgeChoice},
    features::{Appends, Auxiliary, BLOCKS, Block, FeatureSettings, Lists, Thresholds},
    progress::Progress,
    questions::{
        dataset::Datasets,
        error::AnalysisError,
        models::{
            cross_validated::best_shares,
            learning::{Fitted, fit_all},
            recipes::{Recipe, Times},
            training::fit_and_score,
        },
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
