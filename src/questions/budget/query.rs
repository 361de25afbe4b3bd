//! Computes the error budgets of the uncompensated and of the compensated calibration of a fit.

use serde::Serialize;

use crate::{
    calibration::{Calibration, Past, Quality, Regressor, RidgeChoice, Scores},
    features::{Design, FeatureStream},
    progress::Progress,
    questions::{dataset::Dataset, error::AnalysisError, request::Request},
    recording::{Axis, Recording, Role},
    scoring::budget::{Budget, ColumnStream, Measured, ModelColumns, NoBudget, Run},
};

/// Maximum number of recordings. Of more recordings, evenly spread ones are used.
const MOST_RECORDINGS: usize = 400;
/// Ridge on the columns of the compensation, as a share of their variance, if the fit chooses its own or has none.
const RIDGE: f64 = 1e-4;

/// Error budgets of a fit.
#[derive(Debug, Serialize)]
pub struct ErrorBudget {
    /// Axes of the budgets' `axes`.
    pub axes: Vec<Axis>,
    /// Name of each pool of axes: the forces, the moments.
    pub pools: Vec<&'static str>,
    pub uncompensated: Budget,
    /// Budget of what the compensation leaves; `None` without a compensation, if it has no effect, or if it is not linear in
    /// its coefficients.
    pub compensated: Option<Budget>,
}

/// Columns that the features of a fit add to the gauges.
struct Appended<'a> {
    design: &'a Design,
    recordings: Vec<&'a Recording>,
    past: Vec<Past>,
    n_columns: usize,
}

impl ModelColumns for Appended<'_> {
    fn n_columns(&self) -> usize {
        self.n_columns
    }

    fn stream(&self, run: usize) -> ColumnStream<'_> {
        let (recording, past) = (self.recordings[run], &self.past[run]);
        let mut stream = FeatureStream::new(self.design);
        let first = self.design.n_gauges();
        let mut row = vec![0.0; self.design.n_columns()];
        Box::new(move |sample, out| {
            let stride = row.len();
            stream.standardised_rows(
                &[sample],
                recording.times(),
                |k| recording.gauges_at(k),
                |k| recording.auxiliary().at(k),
                |look_back, k| recording.gauges_at(past[look_back][k] as usize),
                (&mut row, stride),
            );
            out.copy_from_slice(&row[first..][..out.len()]);
        })
    }
}

/// Returns the error budgets of a fit, or the reason why there is none. `calibration` is the linear fit.
///
/// # Errors
/// [`AnalysisError`] if there is nothing to fit, or the work was cancelled.
pub fn error_budget(
    request: &Request,
    calibration: &Calibration,
    progress: &Progress,
) -> Result<Result<ErrorBudget, NoBudget>, AnalysisError> {
    let data = request.datasets.get(&request.key(), progress)?;
    let numbers = training(&data);
    let recordings: Vec<&Recording> =
        numbers.iter().map(|at| &*data.entries[*at].recording).collect();
    let part = |at: &usize| data.folds.pieces[*at].first().map_or(0, |piece| piece.fold);
    let parts = data.folds.are_whole.then(|| numbers.iter().map(part));
    let parts: Vec<usize> = parts.map_or_else(|| (0..numbers.len()).collect(), Iterator::collect);
    let runs = recordings.iter().zip(parts).map(|(own, part)| Run {
        n_samples: own.n_samples(),
        gauges: own.gauges(),
        loads: own.loads(),
        auxiliary: own.auxiliary().values(),
        part,
        has_times: !own.is_static(),
    });
    let runs: Vec<Run<'_>> = runs.collect();
    let full_scale = &calibration.full_scale;
    let (names, pools) = pools(calibration);
    // The error is that of the fit's cross-validation if both leave out whole recordings, or both parts of them.
    let scaled = |budget: Budget, scores: &Scores| match &scores.cv_rmse {
        Some(rmse) if data.folds.are_whole != budget.are_segments => {
            let squares = rmse.iter().zip(full_scale).map(|(error, full)| (error / full).powi(2));
            budget.scaled_to(&squares.collect::<Vec<f64>>(), &pools)
        }
        _ => budget,
    };
    let Quality { conventional, compensated, .. } = &calibration.quality;
    // A history in which no earlier sample differs from the present one leaves the conventional map.
    let has_effect = conventional.train_rmse != compensated.train_rmse;
    let design = calibration.design();
    let n_columns = design.n_columns() - design.n_gauges() - usize::from(calibration.offset);
    let is_linear = request.settings.regressor == Regressor::Linear;
    let columns = if n_columns > 0 && has_effect && is_linear {
        let mut past = data.past(calibration, progress)?;
        Some(Appended {
            design: &design,
            recordings,
            past: numbers.iter().map(|at| std::mem::take(&mut past[*at])).collect(),
            n_columns,
        })
    } else {
        None
    };
    let ridge = match request.settings.ridge {
        RidgeChoice::Strength(own) if own > 0.0 => own,
        _ => RIDGE,
    };
    let model = columns.as_ref().map(|own| (own as &dyn ModelColumns, ridge));
    let Some(measured) = Measured::of(&runs, full_scale, model, progress)? else {
        return Ok(Err(NoBudget::NothingToExplain));
    };
    let budget = |of_model, scores| {
        Ok::<_, AnalysisError>(scaled(measured.budget(&pools, of_model, progress)?, scores))
    };
    let uncompensated = budget(false, conventional)?;
    let compensated = model.map(|_| budget(true, compensated)).transpose()?;
    Ok(Ok(ErrorBudget { axes: calibration.axes.clone(), pools: names, uncompensated, compensated }))
}

/// Returns the numbers of the training recordings of a budget.
fn training(data: &Dataset) -> Vec<usize> {
    let entries = data.entries.iter().enumerate();
    let used = entries.filter(|(_, entry)| {
        entry.role == Role::Train
            && entry.recording.has_reference()
            && entry.recording.n_samples() > 0
    });
    let all: Vec<usize> = used.map(|(at, _)| at).collect();
    let n = all.len().min(MOST_RECORDINGS);
    (0..n).map(|at| all[at * all.len() / n]).collect()
}

/// Returns the axes with a full scale that are forces, and those that are moments, each with a name.
pub(super) fn pools(calibration: &Calibration) -> (Vec<&'static str>, Vec<Vec<usize>>) {
    let of = |is_force: bool| {
        let axes = calibration.axes.iter().zip(&calibration.full_scale).enumerate();
        let axes = axes.filter(|(_, (axis, full))| axis.is_force() == is_force && **full > 0.0);
        axes.map(|(at, _)| at).collect::<Vec<usize>>()
    };
    let pools = [("Forces", of(true)), ("Moments", of(false))];
    pools.into_iter().filter(|(_, axes)| !axes.is_empty()).unzip()
}
