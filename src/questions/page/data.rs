//! Data that a report shows.

use std::sync::Arc;
use std::time::SystemTime;

use jiff::Timestamp;

use crate::{
    calibration::{Calibration, ExpectedError, FactoryScores, UsedRecording},
    finding::Finding,
    questions::{
        check::independent_loads::Sufficiency, errors::query::RecordingResult,
        expected_error::limits::Checked, loops::LoopPlot, metrology::Metrology,
    },
    recording::Recording,
    report::figure::Figure,
};

/// Contents of a report, made by [`report`](super::report).
#[derive(Debug)]
pub struct ReportData {
    /// Time when the report was made.
    pub made: SystemTime,
    /// The calibration.
    pub calibration: Arc<Calibration>,
    /// Notes of the user; may be empty.
    pub notes: String,
    /// Errors of the factory calibration; `None` without a factory calibration.
    pub factory: Option<FactoryScores>,
    /// True if the calibration was fitted to these recordings, false if an existing calibration was applied to them.
    pub fitted: bool,
    /// All recordings, in the order of the recording set.
    pub recordings: Vec<ReportRecording>,
    /// Result of the data check, or a sentence with the reason why the check is missing.
    pub check: Result<Sufficiency, String>,
    /// Plots of the errors against each look-back threshold, or a sentence with the reason why the curves are missing.
    pub thresholds: Result<ReportCurves, String>,
    /// Description of the recordings on which loops and metrology figures are measured.
    pub measured: &'static str,
    /// Loops of each axis of the calibration, as measured and without the time lag, or a sentence with the reason why they
    /// are missing.
    pub loops: Vec<Result<Vec<LoopPlot>, String>>,
    /// Plots of the errors against time, for the recording with the largest errors; `None` without a reference.
    pub errors: Option<ReportErrors>,
    /// Metrology table, or a sentence with the reason why the table is missing.
    pub metrology: Result<Arc<Metrology>, String>,
    /// Expected error of a reading, or a sentence with the reason why the expected error is missing.
    pub expected_error: Result<ExpectedError, String>,
    /// Outcome of each limit that the user set for the calibration; empty without limits.
    pub limits: Vec<Checked>,
    /// Warnings at the top of the report.
    pub warnings: Vec<Finding>,
}

/// A recording in a report.
#[derive(Debug)]
pub struct ReportRecording {
    /// Name, role and file of the recording.
    pub used: UsedRecording,
    /// The recording before decimation.
    pub recording: Arc<Recording>,
    /// Group and errors of this recording.
    pub result: RecordingResult,
}

#[derive(Debug)]
pub struct ReportCurves {
    pub plots: Vec<Figure<'static>>,
    pub about: String,
}

#[derive(Debug)]
pub struct ReportErrors {
    pub recording: String,
    pub chosen: &'static str,
    /// One plot for each axis that has a reference.
    pub figures: Vec<Figure<'static>>,
}

/// Returns a time to the minute in ISO 8601. A time beyond the calendar is shown as 1970.
pub fn utc(time: SystemTime) -> String {
    let time = Timestamp::try_from(time).unwrap_or_default();
    time.strftime("%Y-%m-%d %H:%M UTC").to_string()
}
