//! What a report says.

use std::sync::Arc;
use std::time::SystemTime;

use jiff::Timestamp;

use crate::calibration::{Calibration, ExpectedError, FactoryScores, UsedRecording};
use crate::questions::check::independent_loads::Sufficiency;
use crate::questions::expected_error::limits::Checked;
use crate::questions::metrology::Metrology;
use crate::report::figure::Figure;

/// Everything that a report says.
///
/// [`report`](crate::questions::page::report) gathers it.
#[derive(Clone, Debug)]
pub struct ReportData {
    /// When it was made.
    pub made: SystemTime,
    /// What it is about.
    pub calibration: Arc<Calibration>,
    /// Notes of the user; may be empty.
    pub notes: String,
    /// Errors of the calibration that the sensor came with, where there is one.
    pub factory: Option<FactoryScores>,
    /// Whether the calibration was fitted to these recordings rather than applied to them.
    pub fitted: bool,
    /// All recordings, in order.
    pub recordings: Vec<ReportRecording>,
    /// Whether the recordings carry the model, or a sentence that says why that is not known.
    pub check: Result<Sufficiency, String>,
    /// The errors over both thresholds, or a sentence that says why they are missing.
    pub thresholds: Result<ReportCurves, String>,
    /// Which recordings loops and figures are of, in words.
    pub measured: String,
    /// Per axis of the calibration: its loops, or a sentence that says why there are none.
    pub loops: Vec<Result<Figure<'static>, String>>,
    /// The errors over time of the recording that came out worst.
    pub errors: Option<ReportErrors>,
    /// The table of figures, or a sentence that says why it is missing.
    pub metrology: Result<Arc<Metrology>, String>,
    /// Expected error of a reading, or a sentence that says why there is none.
    pub expected_error: Result<ExpectedError, String>,
    /// Outcome of each limit; empty without limits.
    pub limits: Vec<Checked>,
    /// What to know before reading on.
    pub warnings: Vec<String>,
}

/// One recording in a report.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportRecording {
    /// Its name, role and file.
    pub used: UsedRecording,
    /// What its group is called; `None` where it stands for itself.
    pub group: Option<String>,
    /// How many samples it has, before decimation.
    pub n_samples: usize,
    /// From first to last sample (s).
    pub duration_secs: f64,
    /// One over the median step (Hz).
    pub rate_hz: Option<f64>,
    /// RMSE per axis with the present alone; `None` without a reference.
    pub conventional_rmse: Option<Vec<f64>>,
    /// RMSE per axis with the past; `None` without a reference.
    pub compensated_rmse: Option<Vec<f64>>,
}

/// Errors over the thresholds.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportCurves {
    /// Over F_th and over t_th, for forces and moments.
    pub plots: Vec<Figure<'static>>,
    /// What they show.
    pub about: String,
}

/// Errors over time.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportErrors {
    /// The recording's name.
    pub recording: String,
    /// Why it is this one.
    pub chosen: &'static str,
    /// One per axis that has a reference.
    pub figures: Vec<Figure<'static>>,
}

/// A time to the minute, as ISO 8601 writes it; one beyond all calendars is 1970.
pub fn utc(time: SystemTime) -> String {
    let time = Timestamp::try_from(time).unwrap_or_default();
    time.strftime("%Y-%m-%d %H:%M UTC").to_string()
}
