//! A tried model with its settings and results, and the table of models.

use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Deserializer, Serialize};

use crate::calibration::{Calibration, Estimator, FitSettings, NoCrossValidation, Scores};
use crate::export::bytes_in_float;
use crate::questions::thresholds::ScoreSet;
use crate::recording::{Axis, RecordingSet, Role};
use crate::report::{Cell, Column, Table};

const TIMED_STEPS: usize = 2_000;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    pub coefficients: usize,
    /// Size of an export in single precision, numbers and state, at the sample rate of the recordings (bytes).
    pub bytes: usize,
    /// Time per sample on this machine (µs).
    #[serde(deserialize_with = "nan_if_null")]
    pub micros_a_sample: f64,
}

/// Writes NaN as null, because JSON has no NaN.
fn nan_if_null<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

#[derive(Clone, Debug, Default, Serialize)]
pub struct Model {
    #[serde(skip)]
    pub settings: FitSettings,
    pub axes: Vec<Axis>,
    #[serde(flatten)]
    pub scores: Scores,
    /// Standard deviation of the cross-validated RMSE over the folds, per axis; empty if the folds are unknown.
    pub cv_spread: Vec<f64>,
    /// Standard error of the difference of the mean squared error to the conventional one, over blocks of held-out samples, on
    /// the scale of [`relative`](Self::relative); `None` if the folds are unknown.
    pub spread: Option<f64>,
    /// Description of the held-out parts; may be empty.
    #[serde(skip)]
    pub left_out: String,
    /// Scores of the conventional calibration on the same samples.
    #[serde(skip)]
    pub conventional: Scores,
    pub cost: Cost,
    pub n_train: u64,
    /// Ridge of the linear part, per axis.
    #[serde(skip)]
    pub ridge: Vec<f64>,
    /// Time that the trial took (s), if known.
    pub seconds: Option<f64>,
    /// Trained calibration; `None` if a fit reproduces it at once.
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
            cv_spread: Vec::new(),
            spread: None,
            left_out: left_out.map_or_else(String::new, ToString::to_string),
            conventional: quality.conventional.clone(),
            cost: cost(calibration, recordings),
            n_train: quality.n_train,
            ridge: quality.ridge.clone(),
            seconds: None,
            trained: learns.then(|| Arc::clone(calibration)),
        }
    }

    /// Returns the error relative to the conventional calibration, each axis weighted alike; `None` if either is unknown.
    pub fn relative(&self, set: ScoreSet) -> Option<f64> {
        let (own, conventional) = (set.rmse(&self.scores)?, set.rmse(&self.conventional)?);
        let weights = weights(conventional);
        let counts = weights.iter().any(|weight| *weight > 0.0);
        let squares = own.iter().zip(weights).map(|(own, weight)| weight * own * own);
        counts.then(|| squares.sum::<f64>().sqrt())
    }
}

/// Returns the weights that make all axes count alike: one over the conventional mean squared error.
pub(crate) fn weights(conventional_rmse: &[f64]) -> Vec<f64> {
    let largest = conventional_rmse.iter().fold(0.0_f64, |a, b| a.max(*b));
    let counts = |rmse: &f64| *rmse > 1e-9 * largest;
    let n = conventional_rmse.iter().filter(|rmse| counts(rmse)).count();
    let weight = |rmse: &f64| match counts(rmse) {
        true => 1.0 / (rmse * rmse * n as f64),
        false => 0.0,
    };
    conventional_rmse.iter().map(weight).collect()
}

fn cost(calibration: &Calibration, recordings: &RecordingSet) -> Cost {
    let design = calibration.design();
    let coefficients = calibration.n_coefficients();
    let entry = recordings.entries().iter().find(|entry| entry.role == Role::Train);
    let micros = entry.and_then(|entry| {
        let recording = calibration.prepared(&entry.recording).ok()?;
        let needs_auxiliary = !calibration.features.auxiliary.is_empty();
        let mut estimator = Estimator::new(calibration, &design).ok()?;
        let steps = recording.n_samples().min(TIMED_STEPS);
        let start = Instant::now();
        for k in 0..steps {
            let auxiliary = match needs_auxiliary {
                true => recording.auxiliary().at(k),
                false => &[],
            };
            let (time, gauges) = (recording.times()[k], recording.gauges_at(k));
            estimator.update_with(time, gauges, auxiliary).ok()?;
        }
        Some(start.elapsed().as_secs_f64() * 1e6 / steps.max(1) as f64)
    });
    Cost {
        coefficients,
        bytes: bytes_in_float(calibration),
        micros_a_sample: micros.unwrap_or(f64::NAN),
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mark {
    #[default]
    None,
    /// Smallest model that is nearly as accurate as the most accurate one.
    Smallest,
    Proposed,
}

impl Mark {
    pub fn cell(self) -> Cell {
        match self {
            Self::Proposed => Cell::words("→").about("Proposed: the most accurate"),
            Self::Smallest => Cell::words("=").about("The smallest that is nearly as accurate"),
            Self::None => Cell::words(""),
        }
    }
}

/// Name of the column that the table is sorted by.
pub const RELATIVE: &str = "relative RMSE";

pub struct ModelRow<'a> {
    pub mark: Cell,
    pub name: &'a str,
    /// Amount of data as named in the paper; empty if the settings give it.
    pub data: &'a str,
    pub model: &'a Model,
}

/// Returns the table with one row per model: errors on these samples, and cost.
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
        .about("→: proposed, the most accurate; =: the smallest that is nearly as accurate; others: made of other recordings")
        .words("model", |row| row.name)
        .about("What it is called")
        .columns(
            sets,
            |set| {
                let head = Column::numbers(RELATIVE).unit("%");
                in_group(set, head.about("Of the conventional calibration's error, all axes alike"))
            },
            |row, set| Cell::digits(percent(row.model.relative(**set)), 3),
        )
        .columns(
            has_spread.then(|| Column::numbers("±").unit("%").about(
                "Standard error of its mean squared error's difference to the conventional one, over blocks of left-out samples",
            )),
            Column::clone,
            |row, _| Cell::digits(percent(row.model.spread), 2),
        )
        .words("features", |row| row.model.settings.features.describe())
        .about("What is appended to the gauges")
        .words("regressor", |row| row.model.settings.regressor.label())
        .about("How the load is made of them")
        .words("cross-validation", |row| {
            row.model.left_out.clone()
        })
        .about(
            "What was left out in turn. Nested: the numbers of the model were chosen anew without each part, so that its error \
             cannot be compared with one that is not nested",
        )
        .words("data", |row| match (row.data, row.model.settings.decimation) {
            ("", 1) => "A".to_owned(),
            ("", 10) => "B".to_owned(),
            ("", step) => format!("1/{step}"),
            (data, _) => data.to_owned(),
        })
        .about("A: all samples; B: every tenth sample; 1/n: every n-th sample")
        .columns(
            errors,
            |(set, axis, is_spread)| match is_spread {
                true => in_group(
                    set,
                    Column::numbers(format!("± {axis}"))
                        .unit(axis.unit())
                        .about("Standard deviation of the RMSE over what is left out in turn"),
                ),
                false => in_group(set, Column::load(**axis).about(format!("RMSE, {}", set.label()))),
            },
            |row, (set, axis, is_spread)| error(row.model, **axis, **set, *is_spread),
        )
        .column(Column::numbers("numbers"), |row| Cell::whole(row.model.cost.coefficients))
        .about("Numbers that it consists of")
        .column(Column::numbers("memory").unit("B"), |row| Cell::whole(row.model.cost.bytes))
        .about("Of an export in single precision, its numbers and its state, at the rate of the recordings")
        .column(Column::numbers("a sample").unit("µs"), |row| {
            let micros = row.model.cost.micros_a_sample;
            Cell::digits(Some(micros).filter(|micros| micros.is_finite()), 2)
        })
        .about("Time of a sample, measured on this machine")
        .column(Column::numbers("took").unit("s"), |row| {
            Cell::digits(row.model.seconds, 2)
        })
        .about("How long it took to try")
        .table("", "")
}

/// Returns the cell of a model's error on these samples, or of its spread over the held-out parts.
fn error(model: &Model, axis: Axis, set: ScoreSet, is_spread: bool) -> Cell {
    let at = model.axes.iter().position(|own| *own == axis);
    let of = |values: &[f64]| at.and_then(|at| values.get(at).copied());
    let value = set.rmse(&model.scores).and_then(of);
    if is_spread {
        let spread = of(&model.cv_spread).filter(|_| value.is_some());
        let spread = spread.map(|spread| Cell::digits(Some(spread), 2));
        return Cell::known(spread, "only \"Find the best\" scores each fold by itself");
    }
    let why = match set {
        ScoreSet::Train => "it was not scored on its training recordings".to_owned(),
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
