//! Fitted model with its settings and results, and the table that lists models.

use std::sync::Arc;
use std::time::Instant;

use serde::Serialize;

use crate::{
    calibration::{Calibration, Estimator, FitSettings, NoCrossValidation, Scores},
    export::bytes_in_float,
    recording::{Axis, RecordingSet, Role},
    report::{Cell, Column, Table},
    scoring::score_set::ScoreSet,
};

/// Maximum number of samples on which the computing time per sample is measured.
const TIMED_STEPS: usize = 2_000;

#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Cost {
    pub coefficients: usize,
    /// Memory that an exported calibration needs in single precision (bytes): parameters and state, at the sample rate of the
    /// recordings.
    pub bytes: usize,
    /// Computing time per sample on this machine (µs).
    micros_a_sample: Option<f64>,
}

#[derive(Clone, Debug, Default, Serialize)]
pub struct Model {
    #[serde(skip)]
    pub settings: FitSettings,
    pub axes: Vec<Axis>,
    #[serde(flatten)]
    pub scores: Scores,
    /// Standard deviation of the cross-validated RMSE between the left-out parts, per axis; empty if unknown.
    pub cv_spread: Vec<f64>,
    /// Standard error of the difference between the mean squared errors of the model and of the conventional calibration, as
    /// a share of the conventional one; `None` if unknown.
    pub spread: Option<f64>,
    /// Description of the cross-validation; may be empty.
    #[serde(skip)]
    pub left_out: String,
    /// Errors of the conventional calibration, for comparison.
    #[serde(skip)]
    pub conventional: Scores,
    pub cost: Cost,
    pub n_train: u64,
    /// Time for fitting and scoring the model (s), if known.
    pub seconds: Option<f64>,
    /// Trained calibration; `None` for a linear model, whose fit is quick to repeat.
    #[serde(skip)]
    pub trained: Option<Arc<Calibration>>,
}

impl Model {
    pub fn fitted(
        settings: FitSettings,
        calibration: &Arc<Calibration>,
        recordings: &RecordingSet,
    ) -> Self {
        let quality = &calibration.quality;
        let left_out = quality.cross_validation.as_ref();
        let learns = settings.regressor.learner().is_some();
        Self {
            settings,
            axes: calibration.axes.clone(),
            scores: quality.compensated.clone(),
            left_out: left_out.map_or_else(String::new, ToString::to_string),
            conventional: quality.conventional.clone(),
            cost: cost(calibration, recordings),
            n_train: quality.n_train,
            trained: learns.then(|| Arc::clone(calibration)),
            ..Self::default()
        }
    }

    /// Returns the RMSE divided by the conventional RMSE, with all axes weighted alike; `None` if one RMSE is unknown.
    pub fn relative(&self, set: ScoreSet) -> Option<f64> {
        let (rmse, conventional) = (set.rmse(&self.scores)?, set.rmse(&self.conventional)?);
        let weights = weights(conventional);
        let counts = weights.iter().any(|weight| *weight > 0.0);
        let squares = rmse.iter().zip(weights).map(|(rmse, weight)| weight * rmse * rmse);
        counts.then(|| squares.sum::<f64>().sqrt())
    }
}

/// Returns the weight of each axis' squared error: the inverse of the conventional mean squared error. All axes then count
/// alike.
pub fn weights(conventional_rmse: &[f64]) -> Vec<f64> {
    let largest = conventional_rmse.iter().fold(0.0_f64, |a, b| a.max(*b));
    let counts = |rmse: &f64| *rmse > 1e-9 * largest;
    let n = conventional_rmse.iter().filter(|rmse| counts(rmse)).count();
    let weight = |rmse: &f64| if counts(rmse) { 1.0 / (rmse * rmse * n as f64) } else { 0.0 };
    conventional_rmse.iter().map(weight).collect()
}

fn cost(calibration: &Calibration, recordings: &RecordingSet) -> Cost {
    Cost {
        coefficients: calibration.n_coefficients(),
        bytes: bytes_in_float(calibration),
        micros_a_sample: micros_a_sample(calibration, recordings),
    }
}

fn micros_a_sample(calibration: &Calibration, recordings: &RecordingSet) -> Option<f64> {
    let entry = recordings.entries().iter().find(|entry| entry.role == Role::Train)?;
    let recording = calibration.prepared(&entry.recording).ok()?;
    let design = calibration.design();
    let mut estimator = Estimator::new(calibration, &design).ok()?;
    let steps = recording.n_samples().min(TIMED_STEPS);
    let start = Instant::now();
    for k in 0..steps {
        estimator.update_at(&recording, k).ok()?;
    }
    Some(start.elapsed().as_secs_f64() * 1e6 / steps.max(1) as f64)
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark {
    None,
    /// Mark of the smallest model that is nearly as accurate as the most accurate one.
    Smallest,
    /// Mark of the most accurate model, which is proposed.
    Proposed,
}

impl Mark {
    pub fn cell(self) -> Cell {
        match self {
            Self::Proposed => Cell::words("→").about("Proposed: the most accurate model"),
            Self::Smallest => {
                Cell::words("=").about("The smallest model that is nearly as accurate")
            }
            Self::None => Cell::words(""),
        }
    }
}

/// Name of the column by which the window first sorts the list of models.
pub const RELATIVE: &str = "relative RMSE";

pub struct ModelRow<'a> {
    pub mark: Cell,
    pub name: &'a str,
    pub model: &'a Model,
}

/// Returns the table of models with their errors on these sets of samples, numbers of parameters, memory and computing time.
pub fn model_table<'a>(
    axes: &[Axis],
    sets: &[ScoreSet],
    rows: impl Iterator<Item = ModelRow<'a>>,
) -> Table {
    let rows: Vec<ModelRow<'_>> = rows.collect();
    let in_group = |set: &ScoreSet, head: Column| Column {
        group: (sets.len() > 1).then(|| (set.label().to_owned(), set.explanation().to_owned())),
        ..head
    };
    let has_spread = |row: &ModelRow<'_>| row.model.spread.is_some();
    let has_spread = sets.contains(&ScoreSet::LeftOut) && rows.iter().any(has_spread);
    let errors = sets.iter().flat_map(|set| {
        axes.iter().flat_map(move |axis| {
            let spread = (*set == ScoreSet::LeftOut).then_some((set, axis, true));
            std::iter::once((set, axis, false)).chain(spread)
        })
    });
    let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
    Table::of(rows)
        .column(Column::words(""), |row| row.mark.clone())
        .about("→: the proposed, most accurate model; =: the smallest model that is nearly as accurate; others: a model of other recordings")
        .words("model", |row| row.name)
        .about("Name of the model")
        .columns(
            sets,
            |set| {
                let head = Column::numbers(RELATIVE).unit("%");
                in_group(set, head.about("RMSE as a share of the conventional RMSE, with all axes weighted alike"))
            },
            |row, set| Cell::digits(percent(row.model.relative(**set)), 3),
        )
        .columns(
            has_spread.then(|| Column::numbers("±").unit("%").about(
                "Standard error of the difference of the mean squared errors of model and conventional calibration, from blocks of left-out samples",
            )),
            Column::clone,
            |row, _| Cell::digits(percent(row.model.spread), 2),
        )
        .words("features", |row| row.model.settings.features.describe())
        .about("Feature columns beside the gauges")
        .words("regressor", |row| row.model.settings.regressor.label())
        .about("Method that computes the load from gauges and features")
        .words("cross-validation", |row| row.model.left_out.clone())
        .about(
            "Parts of the training recordings that were left out in turn. Nested: the settings were also chosen without each part. Compare nested errors only with nested ones",
        )
        .words("data", |row| match row.model.settings.decimation {
            1 => "all".to_owned(),
            step => format!("1/{step}"),
        })
        .about("Samples of the training recordings that were used: all, or every n-th")
        .columns(
            errors,
            |(set, axis, is_spread)| {
                let head = if *is_spread {
                    let about = "Standard deviation of the RMSE over the left-out parts";
                    Column::numbers(format!("± {axis}")).unit(axis.unit()).about(about)
                } else {
                    Column::load(**axis).about(format!("RMSE, {}", set.label()))
                };
                in_group(set, head)
            },
            |row, (set, axis, is_spread)| error(row.model, **axis, **set, *is_spread),
        )
        .column(Column::numbers("parameters"), |row| Cell::whole(row.model.cost.coefficients))
        .about("Number of coefficients or network weights of the model")
        .column(Column::numbers("memory").unit("B"), |row| Cell::whole(row.model.cost.bytes))
        .about("Parameters and state of the exported model in single precision, at the sample rate of the recordings")
        .column(Column::numbers("time per sample").unit("µs"), |row| {
            Cell::digits(row.model.cost.micros_a_sample, 2)
        })
        .about("Time to compute one load, measured on this machine")
        .column(Column::numbers("trial time").unit("s"), |row| Cell::digits(row.model.seconds, 2))
        .about("Time to fit and score the model")
        .table("", "")
}

/// Returns the table cell with a model's RMSE on one axis, or with the standard deviation of this RMSE over the left-out
/// parts.
fn error(model: &Model, axis: Axis, set: ScoreSet, is_spread: bool) -> Cell {
    let at = model.axes.iter().position(|known| *known == axis);
    let of = |values: &[f64]| at.and_then(|at| values.get(at).copied());
    let value = set.rmse(&model.scores).and_then(of);
    if is_spread {
        let spread = of(&model.cv_spread).filter(|_| value.is_some());
        let spread = spread.map(|spread| Cell::digits(Some(spread), 2));
        return Cell::known(
            spread,
            "only \"Find the best\" measures the scatter of the RMSE between the left-out parts",
        );
    }
    let why = match set {
        ScoreSet::Train => "the model was not scored on its training recordings".to_owned(),
        _ => set.missing(Some(NoCrossValidation::of(model.settings.regressor.learner()))),
    };
    let about = if set == ScoreSet::LeftOut { &*model.left_out } else { "" };
    Cell::known(value.map(|value| Cell::digits(Some(value), 4).about(about)), why)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_without_error_does_not_count() {
        assert_eq!(weights(&[2.0, 0.0]), [0.25, 0.0]);
        assert_eq!(weights(&[0.0, 0.0]), [0.0, 0.0]);
    }
}
