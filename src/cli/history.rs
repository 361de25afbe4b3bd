//! The history rate of an export without a given rate: the coarsest that the fit allows.

use std::sync::Arc;

use super::error::JobError;
use super::run::Run;
use crate::calibration::{Calibration, FitSettings, Regressor};
use crate::export::Footprint;
use crate::questions::{Request, train};
use crate::scoring::numbers::significant;

/// History rates to try, from the coarsest (Hz).
const RATES_HZ: [f64; 9] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0];
/// Largest accepted ratio of the error with a coarser history to the error with all samples.
const LARGEST_COST: f64 = 1.01;

/// Returns the request with the coarsest history whose fit costs less than 1 % of the error, if the whole history needs more
/// than 64 kB on a controller and no rate is given. The fit uses the same rate.
///
/// # Errors
/// [`JobError`] if a fit fails.
pub fn with_history_that_fits(run: &Run, request: Request) -> Result<Request, JobError> {
    let settings = &request.settings;
    if settings.history_rate_hz != 0.0 || !settings.features.has_history() {
        return Ok(request);
    }
    // All regressors have the same blocks, and least squares is the fastest.
    let at_rate = |regressor, history_rate_hz| FitSettings {
        history_rate_hz,
        regressor,
        ..request.settings.clone()
    };
    let fitted = |rate_hz| {
        let settings = at_rate(Regressor::Linear, rate_hz);
        let own = Request::fit(Arc::clone(&request.recordings), settings);
        let own = train(&own, &run.progress, &mut |_| {})?;
        Ok::<_, JobError>((error_of(&own), Footprint::of(&own)))
    };
    let (whole_error, whole) = fitted(0.0)?;
    if !whole.is_large() {
        return Ok(request);
    }
    // The finest rate that fits into the memory, until a coarser rate with a small cost is found.
    let mut chosen = None;
    for rate_hz in RATES_HZ {
        let (error, footprint) = fitted(rate_hz)?;
        if footprint.is_large() {
            break;
        }
        chosen = Some((rate_hz, error, footprint));
        if error < LARGEST_COST * whole_error {
            break;
        }
    }
    let Some((rate_hz, error, footprint)) = chosen else {
        return Ok(request);
    };
    let percent = |error: f64| significant(100.0 * error, 3);
    let kilobytes = |footprint: Footprint| format!("{:.1} kB", footprint.memory as f64 / 1000.0);
    run.say.note(format_args!(
        "the history keeps {rate_hz} samples a second, {} on a controller instead of {}; the mean error of the linear fit is {} % of \
         full scale, with all samples {} %; --history-rate sets another rate",
        kilobytes(footprint),
        kilobytes(whole),
        percent(error),
        percent(whole_error)
    ));
    let settings = at_rate(request.settings.regressor, rate_hz);
    Ok(Request::fit(request.recordings, settings))
}

/// Returns the mean error over the axes as a share of full scale: in cross-validation, else on the training recordings.
fn error_of(calibration: &Calibration) -> f64 {
    calibration.mean_cv_share().unwrap_or_else(|| {
        let errors = calibration.quality.compensated.train_rmse.iter().flatten();
        let shares = errors.zip(&calibration.full_scale).map(|(error, scale)| error / scale);
        shares.sum::<f64>() / calibration.axes.len() as f64
    })
}
