//! Option `--export` of `fit` and `best`: writes a fitted calibration to files.

use std::path::PathBuf;

use super::error::{JobError, failed};
use super::run::Run;
use crate::{
    calibration::Calibration,
    export::{Outline, Together, add_calibration, caution, known_target},
    finding::Face,
    progress::Progress,
    questions::{Request, handed_over, history::coarse_history},
    recording::identity::Identity,
};

/// Checks that each file name ends like an export format (such as `.json` or `.h`).
pub fn check_endings(paths: &[PathBuf]) -> Result<(), JobError> {
    paths.iter().try_for_each(|path| known_target(path).map(drop).map_err(JobError::Usage))
}

/// Checks, before the fit, that each format can hold the calibration. All refusals are reported together, and nothing is
/// written.
pub fn check_formats(paths: &[PathBuf], outline: &Outline<'_>) -> Result<(), JobError> {
    let refusals = paths.iter().filter_map(|path| {
        let refusal = (known_target(path).ok()?.refusal)(outline)?;
        Some(format!("cannot write {}: {refusal}", path.display()))
    });
    let refusals: Vec<String> = refusals.collect();
    if refusals.is_empty() { Ok(()) } else { failed(refusals.join("; ")) }
}

/// Checks that the recordings have enough samples to determine the calibration. With `force`, every calibration passes.
pub fn check_determined(calibration: &Calibration, force: bool) -> Result<(), JobError> {
    match calibration.undetermined().filter(|_| !force) {
        None => Ok(()),
        Some(undetermined) => {
            let found = undetermined.finding().text(Face::CommandLine);
            failed(format!("{found}; --force exports it anyway"))
        }
    }
}

/// Lowers the rate at which earlier samples are stored if exported code would otherwise need too much memory, and prints a
/// note about it; see [`coarse_history`].
pub fn with_history_that_fits(
    run: &Run,
    mut request: Request,
    progress: &Progress,
) -> Result<Request, JobError> {
    if let Some(coarse) = coarse_history(&request, progress)? {
        run.say.note(format_args!("{coarse}; --history-rate sets another rate"));
        request.settings.history_rate_hz = coarse.rate_hz;
    }
    Ok(request)
}

/// Adds the calibration to `files`, once for each of `paths`, in the format of its file name. Prints a warning if a format
/// cannot hold a part of it.
pub fn export(
    run: &Run,
    request: &Request,
    calibration: &Calibration,
    identity: &Identity,
    paths: &[PathBuf],
    files: &mut Together,
) -> Result<(), JobError> {
    if paths.is_empty() {
        return Ok(());
    }
    for caution in paths.iter().filter_map(|path| caution(calibration, path)) {
        run.say.warning(caution);
    }
    let whole = handed_over(request, calibration, &Progress::default())?.of_sensor(identity);
    for path in paths {
        add_calibration(files, &whole, path)?;
    }
    Ok(())
}
