//! Computes the error budgets of the uncompensated and of the compensated calibration of a fit.

use serde::Serialize;

use crate::{
    calibration::{Calibration, Quality, Regressor, RidgeChoice, Scores},
    features::FeatureStream,
    progress::Progress,
    questions::{dataset::Dataset, error::AnalysisError, request::Request},
    recording::{Axis, Recording, Role},
    scoring::budget::{Budget, ColumnStream, Measured, Model, NoBudget, Run},
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
    let Quality { conventional, compensated, .. } = &calibration.quality;
    // A history in which no earlier sample differs from the present one leaves the conventional map.
    let has_effect = conventional.train_rmse != compensated.train_rmse;
    let design = calibration.design();
    let n_columns = design.n_columns() - design.n_gauges() - usize::from(calibration.offset);
    let is_linear = request.settings.regressor == Regressor::Linear;
    let has_model = n_columns > 0 && has_effect && is_linear;
    let past = if has_model { data.past(calibration, progress)? } else { Vec::new() };
    // Columns that the features of the fit add to the gauges.
    let stream = |run: usize| -> ColumnStream<'_> {
        let (recording, past) = (recordings[run], &past[numbers[run]]);
        let mut stream = FeatureStream::new(&design);
        let mut row = vec![0.0; design.n_columns()];
        let first = design.n_gauges();
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
    };
    let ridge = match request.settings.ridge {
        RidgeChoice::Strength(own) if own > 0.0 => own,
        _ => RIDGE,
    };
    let model = has_model.then_some(Model { n_columns, ridge, stream: &stream });
    let Some(measured) = Measured::of(&runs, full_scale, model, progress)? else {
        return Ok(Err(NoBudget::NothingToExplain));
    };
    let budget = |of_model, scores: &Scores| -> Result<Budget, AnalysisError> {
        let budget = measured.budget(&pools, of_model, progress)?;
        // The error is that of the fit's cross-validation if both leave out whole recordings, or both parts of them.
        let are_same = data.folds.are_whole != budget.are_segments;
        let squares = scores.cv_rmse.as_ref().filter(|_| are_same).map(|rmse| {
            let errors = rmse.iter().zip(full_scale);
            errors.map(|(error, full)| (error / full).powi(2)).collect::<Vec<f64>>()
        });
        Ok(budget.scaled_to(squares.as_deref(), &pools))
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
