//! A model that was tried: its settings and how it came out, whoever tried it.

use std::sync::Arc;

use crate::analysis::best::{Best, Cost, Tried, cost};
use crate::analysis::comparison::ComparedRow;
use crate::calibration::{Calibration, FitSettings, Scores};
use crate::evaluation::threshold_study::ScoreSet;
use crate::recording::{Axis, RecordingSet};

/// Settings with what came of them.
#[derive(Clone, Debug)]
pub struct Model {
    /// What brings it back.
    pub settings: FitSettings,
    /// The axes, in the order of the scores.
    pub axes: Vec<Axis>,
    /// RMSE per axis.
    pub scores: Scores,
    /// The standard deviation of the cross-validated RMSE over the folds, per axis; empty where the folds are not known.
    pub cv_spread: Vec<f64>,
    /// What was left out in turn, in words; may be empty.
    pub left_out: String,
    /// What the conventional calibration of the same samples scores.
    pub conventional: Scores,
    /// What it costs where it runs.
    pub cost: Cost,
    /// How long it took to try (s), where that is known.
    pub seconds: Option<f64>,
    /// What was trained; `None` where a fit gives it again at once.
    pub trained: Option<Arc<Calibration>>,
}

impl Model {
    /// What was fitted, or trained, to these recordings.
    pub fn fitted(
        settings: FitSettings,
        calibration: &Arc<Calibration>,
        recordings: &RecordingSet,
    ) -> Self {
        let cost = cost(calibration, recordings);
        Self::with_cost(settings, calibration, cost)
    }

    fn with_cost(settings: FitSettings, calibration: &Arc<Calibration>, cost: Cost) -> Self {
        let quality = &calibration.quality;
        let left_out = quality.cross_validation.as_ref();
        let learns = settings.regressor.learner().is_some();
        Self {
            settings,
            axes: calibration.axes.clone(),
            scores: quality.compensated.clone(),
            cv_spread: Vec::new(),
            left_out: left_out.map_or_else(String::new, ToString::to_string),
            conventional: quality.conventional.clone(),
            cost,
            seconds: None,
            trained: learns.then(|| Arc::clone(calibration)),
        }
    }

    /// A row of a comparison; `settings` are what all its rows have in common.
    pub fn compared(row: &ComparedRow, settings: &FitSettings) -> Self {
        let candidate = &row.candidate;
        let settings = FitSettings {
            regressor: candidate.regressor,
            features: candidate.features.clone(),
            decimation: candidate.decimation,
            ..settings.clone()
        };
        Self {
            seconds: Some(row.elapsed.as_secs_f64()),
            ..Self::with_cost(settings, &row.calibration, row.cost)
        }
    }

    /// One of the candidates of a search.
    pub fn tried(tried: &Tried, best: &Best) -> Self {
        let scores = |own: &Tried| Scores {
            train_rmse: own.train_rmse.clone(),
            test_rmse: own.test_rmse.clone(),
            cv_rmse: Some(own.cv_rmse.clone()),
        };
        Self {
            settings: tried.settings.clone(),
            axes: tried.axes.clone(),
            scores: scores(tried),
            cv_spread: tried.cv_spread.clone(),
            left_out: best.folds.clone(),
            // The first is always the conventional calibration.
            conventional: best.tried.first().map(scores).unwrap_or_default(),
            cost: tried.cost,
            seconds: Some(tried.seconds),
            trained: None,
        }
    }

    /// Its error in shares of the conventional calibration's, all axes alike; `None` where either is not known.
    pub fn relative(&self, set: ScoreSet) -> Option<f64> {
        let (own, conventional) = (set.rmse(&self.scores)?, set.rmse(&self.conventional)?);
        let ratios = own
            .iter()
            .zip(conventional)
            .filter(|(_, from)| **from > 0.0);
        let squares: Vec<f64> = ratios.map(|(own, from)| (own / from).powi(2)).collect();
        let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
        (!squares.is_empty()).then(|| mean.sqrt())
    }
}
