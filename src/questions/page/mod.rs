//! Report on a calibration: one self-contained HTML file, without scripts or external files. The markup is well-formed for
//! any file names. In place of a missing result, the report gives the reason.

mod data;
mod html;
mod request;
mod tables;

use std::path::Path;

pub(crate) use self::data::utc;
pub use self::data::{ReportData, ReportRecording};
use self::html::html_of;
pub use self::request::{ReportRequest, check_limits, report};
pub(crate) use self::tables::settings as settings_table;
use crate::export::{WriteError, write_atomically};

/// Writes a report. An error leaves an existing file unchanged.
///
/// # Errors
/// [`WriteError`] if the file cannot be written.
pub fn write_report(path: &Path, report: &ReportData) -> Result<(), WriteError> {
    write_atomically(path, |out| out.write_all(html_of(report).as_bytes()))
}
