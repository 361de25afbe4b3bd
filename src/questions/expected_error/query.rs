//! Computes the expected error of a calibration from the recordings of its fit.

use std::sync::Arc;

use crate::{
    calibration::{
        Calibration, ExpectedError, Learned, NoCrossValidation, Past, measured_pauses,
        scatter_of_starts,
    },
    export::with_sources,
    progress::Progress,
    questions::{
        dataset::{Dataset, Key},
        error::AnalysisError,
        errors::query::Analysis,
        expected_error::rule::{HeldOutErrors, MIN_GROUPS, expected_from},
        question::{Answered, Query, Work},
        request::Request,
    },
    recording::{Axis, Entry, Recording, RecordingSet, Role, first_pieces, in_role},
    same::same_where,
};

/// Maximum number of held-out samples whose errors are kept in memory.
const KEPT: usize = 200_000;

/// Returns the expected error of a calibration, or the reason why there is none.
///
/// A linear calibration is fitted again without each group. Networks and kernels were cross-validated during training. `fitted`
/// is true if the calibration was fitted to these recordings. Otherwise only the calibration's file can contain an expected
/// error.
///
/// # Errors
/// [`AnalysisError`] if the recordings cannot be used, or the work was cancelled.
pub fn expected_error(
    request: &Request,
    calibration: &Calibration,
    fitted: bool,
    progress: &Progress,
) -> Result<Result<ExpectedError, String>, AnalysisError> {
    if let Some(known) = &calibration.quality.expected_error {
        return Ok(Ok(known.clone()));
    }
    if !fitted {
        return Ok(Err("the calibration was not fitted to these recordings".to_owned()));
    }
    let key = Key { calibration: None, ..request.key() };
    let data = request.datasets.get(&key, progress)?;
    let has_tests = data.entries.iter().any(|entry| entry.role == Role::Test);
    // Without held-out samples, no loads are computed, so the earlier samples of the look-backs are not searched.
    let past = if has_tests || groups_left_out(&data).is_ok() {
        data.past(calibration, progress)?
    } else {
        Vec::new()
    };
    let left_out = left_out_errors(&data, calibration, &past, progress);
    progress.check()?;
    Ok(expected_error_of_fit(&data, calibration, &past, left_out))
}

/// Completes a fitted calibration for export: adds its expected error, the pauses after which its states are kept, and the
/// names of the files that hold the recordings, and removes the uncertainty band of a kernel.
///
/// # Errors
/// Those of [`expected_error`].
pub fn handed_over(
    request: &Request,
    calibration: &Calibration,
    progress: &Progress,
) -> Result<Calibration, AnalysisError> {
    let expected = expected_error(request, calibration, true, progress)?;
    handed_over_with(calibration.clone(), &expected, &request.recordings, progress)
}

pub fn training(recordings: &RecordingSet) -> impl Iterator<Item = &Recording> {
    in_role(recordings.entries(), Role::Train).into_iter()
}

pub fn handed_over_with(
    calibration: Calibration,
    expected: &Result<ExpectedError, String>,
    recordings: &RecordingSet,
    progress: &Progress,
) -> Result<Calibration, AnalysisError> {
    let mut calibration = with_sources(&calibration, recordings);
    if let Some(Learned::Kernel(kernel)) = &mut calibration.learned {
        kernel.remove_band();
    }
    let quality = &mut calibration.quality;
    quality.expected_error = expected.as_ref().ok().cloned();
    if quality.history_scatter.is_none() {
        calibration.quality.history_scatter = scatter_of_starts(&calibration, training(recordings));
    }
    calibration.keep_secs = measured_pauses(&calibration, training(recordings), progress)?;
    Ok(calibration)
}

pub fn expected_error_of_fit(
    data: &Dataset,
    calibration: &Calibration,
    past: &[Past],
    left_out: Result<HeldOutErrors, NoCrossValidation>,
) -> Result<ExpectedError, String> {
    let is_test =
        |entry: &Entry| entry.role == Role::Test && *entry.recording.axes() == calibration.axes;
    let step = step_of(data, is_test);
    let mut tested = HeldOutErrors::new(calibration.axes.len());
    let firsts = first_pieces(&data.entries);
    let all = data.entries.iter().zip(past).enumerate();
    for (at, (entry, past)) in all.filter(|(_, (entry, _))| is_test(entry)) {
        let loads = calibration.compensated_loads(&entry.recording, past);
        tested.add_loads(firsts[at], &loads, entry.recording.loads(), step);
    }
    let full_scale = calibration.full_scale.iter().copied();
    let axes: Vec<(Axis, f64)> = calibration.axes.iter().copied().zip(full_scale).collect();
    expected_from(&data.entries, &axes, data.groups.by, left_out, tested)
}

pub fn groups_left_out(data: &Dataset) -> Result<(), NoCrossValidation> {
    match data.cross_validation() {
        by if by.is_by_block() => Err(NoCrossValidation::FewGroups {
            found: data.training_groups().len(),
            needed: MIN_GROUPS,
        }),
        _ => Ok(()),
    }
}

/// Returns the errors of a linear calibration on each group of training recordings. A group is predicted by a fit to the
/// other groups.
fn left_out_errors(
    data: &Dataset,
    calibration: &Calibration,
    past: &[Past],
    progress: &Progress,
) -> Result<HeldOutErrors, NoCrossValidation> {
    groups_left_out(data)?;
    if calibration.learned.is_some() {
        return Err(NoCrossValidation::of(calibration.regressor.learner()));
    }
    let n_axes = calibration.axes.len();
    let sums = data.sums(&calibration.design(), past, n_axes, progress);
    let fits = data.fits_left_out(calibration, &sums)?;
    let is_trained = |entry: &Entry| entry.role == Role::Train;
    let step = step_of(data, is_trained);
    let mut errors = HeldOutErrors::new(n_axes);
    let mut without_part = calibration.clone();
    for ((entry, pieces), past) in data.entries.iter().zip(&data.folds.pieces).zip(past) {
        if !is_trained(entry) || progress.is_cancelled() {
            continue;
        }
        // Cross-validation leaves out only whole recordings here, so each recording is one piece.
        without_part.compensated = Some(fits[pieces[0].fold].clone());
        let loads = without_part.compensated_loads(&entry.recording, past);
        errors.add_loads(pieces[0].fold, &loads, entry.recording.loads(), step);
    }
    Ok(errors)
}

/// Returns n so that every n-th sample of the chosen recordings makes at most [`KEPT`] samples.
pub fn step_of(data: &Dataset, is_chosen: impl Fn(&Entry) -> bool) -> usize {
    let chosen = data.entries.iter().filter(|entry| is_chosen(entry));
    let n: usize = chosen.map(|entry| entry.recording.n_samples()).sum();
    n.div_ceil(KEPT).max(1)
}

/// Request for the expected error of the calibration on screen.
#[derive(Clone, Debug)]
pub struct AskExpectedError {
    request: Request,
    pub calibration: Arc<Calibration>,
    /// True if the calibration was fitted to the recordings of the request.
    fitted: bool,
}

same_where!(AskExpectedError: shared(calibration) value(request, fitted) besides());

impl AskExpectedError {
    /// Returns the request for the expected error of an analysed calibration; `analysis` must be the answer to `request`.
    pub fn of(request: &Request, analysis: &Analysis) -> Self {
        let calibration = Arc::clone(&analysis.calibration);
        Self { request: request.plain(), calibration, fitted: analysis.fitted }
    }
}

impl Query for AskExpectedError {
    type Answer = Result<ExpectedError, String>;
    type Cache = ();

    fn title(&self) -> String {
        "Expected error".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        Ok(expected_error(&self.request, &self.calibration, self.fitted, work.progress)?)
    }
}
