//! A report on a calibration: one self-contained HTML file to read, print and keep.
//!
//! Guarantees: the markup is well-formed for any file names. There is no script, and nothing is loaded from elsewhere. A
//! missing result is replaced by its reason.

mod data;
mod html;
mod request;
mod tables;

use std::path::Path;

pub(crate) use self::data::utc;
pub use self::data::{ReportData, ReportRecording};
use self::html::html_of;
pub use self::request::{ReportRequest, check_limits, report};
use crate::export::{WriteError, write_atomically};

/// Writes a report atomically.
///
/// # Errors
/// [`WriteError`] if the file cannot be written.
pub fn write_report(path: &Path, report: &ReportData) -> Result<(), WriteError> {
    write_atomically(path, |out| out.write_all(html_of(report).as_bytes()))
}
