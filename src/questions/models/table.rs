//! A model that was tried: its settings and how it came out, whoever tried it, and the table of such models.

use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Deserializer, Serialize};

use crate::calibration::{Calibration, Estimator, FitSettings, Learner, Scores};
use crate::export::bytes_in_float;
use crate::questions::thresholds::ScoreSet;
use crate::recording::{Axis, RecordingSet, Role};
use crate::report::{Cell, Column, Table};

/// Steps of an estimator that are timed.
const TIMED_STEPS: usize = 2_000;

/// What a calibration costs where it runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Numbers that it consists of.
    pub coefficients: usize,
    /// Bytes of an export in single precision, its numbers and its state, at the rate of the recordings.
    pub bytes: usize,
    /// Time of a sample on this machine (µs).
    #[serde(deserialize_with = "nan_if_null")]
    pub micros_a_sample: f64,
}

/// JSON has no other way to write what is not known.
fn nan_if_null<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

/// Settings with what came of them.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Model {
    /// What brings it back.
    #[serde(skip)]
    pub settings: FitSettings,
    /// The axes, in the order of the scores.
    pub axes: Vec<Axis>,
    /// RMSE per axis.
    #[serde(flatten)]
    pub scores: Scores,
    /// The standard deviation of the cross-validated RMSE over the folds, per axis; empty where the folds are not known.
    pub cv_spread: Vec<f64>,
    /// The standard error of its mean squared error's difference to the conventional one, over the folds, on the scale of
    /// [`relative`](Self::relative); `None` where the folds are not known.
    pub spread: Option<f64>,
    /// What was left out in turn, in words; may be empty.
    #[serde(skip)]
    pub left_out: String,
    /// What the conventional calibration of the same samples scores.
    #[serde(skip)]
    pub conventional: Scores,
    /// What it costs where it runs.
    pub cost: Cost,
    /// How long it took to try (s), where that is known.
    pub seconds: Option<f64>,
    /// What was trained; `None` where a fit gives it again at once.
    #[serde(skip)]
    pub trained: Option<Arc<Calibration>>,
}

impl Model {
    /// What was fitted, or trained, to these recordings.
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
            seconds: None,
            trained: learns.then(|| Arc::clone(calibration)),
        }
    }

    /// Its error in shares of the conventional calibration's, all axes alike; `None` where either is not known.
    pub fn relative(&self, set: ScoreSet) -> Option<f64> {
        let (own, conventional) = (set.rmse(&self.scores)?, set.rmse(&self.conventional)?);
        let weights = weights(conventional);
        let counts = weights.iter().any(|weight| *weight > 0.0);
        let squares = own.iter().zip(weights).map(|(own, weight)| weight * own * own);
        counts.then(|| squares.sum::<f64>().sqrt())
    }
}

/// What makes each axis count alike: one over the conventional calibration's mean square.
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

/// What the calibration costs where it runs.
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

/// Whether a model of a search is the one to take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mark {
    /// It is not, or nobody has asked.
    #[default]
    None,
    /// It is within one standard error of the best.
    Good,
    /// It is the cheapest of these.
    Proposed,
}

impl Mark {
    /// What stands before the model.
    pub fn cell(self) -> Cell {
        match self {
            Self::Proposed => Cell::words("→").about("Proposed"),
            Self::Good => Cell::words("=").about("Within one standard error of the best"),
            Self::None => Cell::words(""),
        }
    }
}

/// The name of the column that tells models apart best.
pub const RELATIVE: &str = "of Conv.";

/// A row of the table of models.
pub struct ModelRow<'a> {
    /// Whether it is the one to take.
    pub mark: Cell,
    /// What it is called.
    pub name: &'a str,
    /// The amount of data in the paper's words; empty where it is that of the settings.
    pub data: &'a str,
    /// What brings it back.
    pub settings: &'a FitSettings,
    /// What came of it, or what is said in its place.
    pub state: Result<&'a Model, Cell>,
}

/// A row each, in their order: errors on these samples, and what a model costs.
pub fn model_table<'a>(
    axes: &[Axis],
    sets: &[ScoreSet],
    rows: impl Iterator<Item = ModelRow<'a>>,
) -> Table {
    let rows: Vec<ModelRow<'_>> = rows.collect();
    let words = |name: &str, about: &str| Column { about: about.to_owned(), ..Column::words(name) };
    let numbers = |name: &str, unit: &'static str, about: &str| Column {
        unit,
        about: about.to_owned(),
        ..Column::numbers(name)
    };
    let group = |set: &ScoreSet| {
        let group = (set.label().to_owned(), set.explanation().to_owned());
        (sets.len() > 1).then_some(group)
    };
    let mut columns = vec![
        words(
            "",
            "→: proposed, the cheapest within one standard error of the best; =: within it, too; others: made of other recordings",
        ),
        words("model", "What it is called"),
    ];
    columns.extend(sets.iter().map(|set| Column {
        group: group(set),
        ..numbers(RELATIVE, "%", "Of the conventional calibration's error, all axes alike")
    }));
    let has_spread = |row: &ModelRow<'_>| row.state.as_ref().is_ok_and(|own| own.spread.is_some());
    let has_spread = sets.contains(&ScoreSet::LeftOut) && rows.iter().any(has_spread);
    if has_spread {
        columns.push(numbers(
            "±",
            "%",
            "Standard error of its mean squared error's difference to the conventional one, over the folds",
        ));
    }
    columns.extend([
        words("features", "What is appended to the gauges"),
        words("regressor", "How the load is made of them"),
        words("data", "A: all samples; B: every tenth; else every so many-th"),
    ]);
    for set in sets {
        for axis in axes {
            columns.push(Column {
                group: group(set),
                about: format!("RMSE, {}", set.label()),
                ..Column::load(*axis)
            });
            if *set == ScoreSet::LeftOut {
                let about = "Standard deviation of the RMSE over what is left out in turn";
                columns.push(Column {
                    group: group(set),
                    ..numbers(&format!("± {}", axis.symbol()), axis.unit(), about)
                });
            }
        }
    }
    columns.extend([
        numbers(
            "numbers",
            "",
            "Numbers that it consists of",
        ),
        numbers(
            "memory",
            "B",
            "Of an export in single precision, its numbers and its state, at the rate of the recordings",
        ),
        numbers("a sample", "µs", "Time of a sample, measured on this machine"),
        numbers("took", "s", "How long it took to try"),
    ]);
    let rows = rows.iter();
    Table {
        rows: rows.map(|row| row.cells(axes, sets, has_spread, columns.len())).collect(),
        columns,
        ..Table::default()
    }
}

impl ModelRow<'_> {
    fn cells(
        &self,
        axes: &[Axis],
        sets: &[ScoreSet],
        has_spread: bool,
        n_columns: usize,
    ) -> Vec<Cell> {
        let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
        let relative = |set: &ScoreSet| match &self.state {
            Ok(model) => Cell::digits(percent(model.relative(*set)), 3),
            Err(said) => said.clone(),
        };
        let model = self.state.as_ref().ok();
        let data = match (self.data, self.settings.decimation) {
            ("", 1) => "A".to_owned(),
            ("", 10) => "B".to_owned(),
            ("", step) => format!("1/{step}"),
            (data, _) => data.to_owned(),
        };
        let mut cells = vec![self.mark.clone(), Cell::words(self.name)];
        cells.extend(sets.iter().map(relative));
        if has_spread {
            let spread = model.and_then(|model| model.spread);
            cells.push(Cell::digits(percent(spread), 2));
        }
        let features = self.settings.features.describe();
        let regressor = self.settings.regressor.label();
        cells.extend([&features, regressor, &data].map(Cell::words));
        if let Some(model) = model {
            sets.iter().for_each(|set| errors(model, axes, *set, &mut cells));
            let Cost { coefficients, bytes, micros_a_sample } = model.cost;
            let whole = |number: usize| Cell::number(number as f64, number.to_string());
            cells.extend([coefficients, bytes].map(whole));
            let micros = Some(micros_a_sample).filter(|micros| micros.is_finite());
            cells.push(Cell::digits(micros, 2));
            cells.push(Cell::digits(model.seconds, 2));
        }
        cells.resize(n_columns, Cell::none());
        cells
    }
}

/// A model's errors on these samples.
fn errors(model: &Model, axes: &[Axis], set: ScoreSet, cells: &mut Vec<Cell>) {
    let rmse = set.rmse(&model.scores);
    let why = match (set, model.settings.regressor.learner()) {
        (ScoreSet::Test, _) => "no recording is in the test role",
        (ScoreSet::LeftOut, Some(Learner::Network)) => "the network was not cross-validated",
        (ScoreSet::LeftOut, _) => "it was not cross-validated: too little is left without a part",
        (ScoreSet::Train, _) => "it was not scored on what it was fitted to",
    };
    for axis in axes {
        let at = model.axes.iter().position(|own| own == axis);
        let of = |values: &[f64]| at.and_then(|at| values.get(at).copied());
        let value = rmse.and_then(of);
        cells.push(match value {
            Some(_) if set == ScoreSet::LeftOut => Cell::digits(value, 4).about(&model.left_out),
            Some(_) => Cell::digits(value, 4),
            None => Cell::missing("–", why),
        });
        if set == ScoreSet::LeftOut {
            cells.push(match of(&model.cv_spread).filter(|_| value.is_some()) {
                Some(spread) => Cell::digits(Some(spread), 2),
                None => Cell::missing("–", "only \"Find the best\" scores each fold by itself"),
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An axis that is always zero has no say.
    #[test]
    fn an_axis_without_error_does_not_count() {
        assert_eq!(weights(&[2.0, 0.0]), [0.25, 0.0]);
        assert_eq!(weights(&[0.0, 0.0]), [0.0, 0.0]);
    }
}
