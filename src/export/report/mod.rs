//! A report on a calibration: one HTML file that needs nothing beside it, to be read, printed and kept.
//!
//! Guarantees: well-formed markup, whatever names files have; no script, and nothing that is fetched from elsewhere; what
//! could not be computed is said in its place.

mod data;
mod page;
mod tables;

use std::path::Path;

pub use self::data::{ReportCurves, ReportData, ReportErrors, ReportRecording, utc};
use self::page::html_of;
use crate::export::atomic::{WriteError, write_atomically};

/// Writes a report, whole or not at all.
///
/// # Errors
/// [`WriteError`] if the file cannot be written.
pub fn write_report(path: &Path, report: &ReportData) -> Result<(), WriteError> {
    write_atomically(path, |out| out.write_all(html_of(report).as_bytes()))
}
