//! Content of files, and writing it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::calibration::{Calibration, Undetermined};
use crate::engine::project::Project;
use crate::engine::session::Session;
use crate::engine::session::write_session;
use crate::export::{
    FileFormat, TARGETS, TRACE_FORMATS, Together, WriteError, caution, write_atomically,
    write_calibration, write_traces,
};
use crate::progress::Progress;
use crate::questions::metrology::Metrology;
use crate::questions::metrology::figure_records;
use crate::questions::page::{ReportRequest, report, write_report};
use crate::questions::thresholds::{MAP_FORMATS, map_format};
use crate::questions::thresholds::{Measure, ThresholdMap};
use crate::questions::{OnScreen, Request, handed_over};
use crate::report::Table;

/// Content of a file. If there are several formats, the ending of the file name selects one.
#[derive(Clone, Debug)]
pub enum FileContent {
    /// Calibration, with the request of the fit if it was fitted here.
    Calibration(Arc<Calibration>, Option<Box<Request>>),
    /// Report on a request, with the notes.
    Report(Box<ReportRequest>),
    /// Loads and errors over time.
    Traces(Box<OnScreen>),
    /// The list of models as CSV.
    Models(Box<Table>),
    /// The metrology table as CSV.
    Metrology(Arc<Metrology>),
    /// Map of thresholds with its curves.
    Thresholds(Arc<ThresholdMap>, Measure),
    /// Session, with its document, and the trained calibration beside it.
    Session(Box<Session>, Box<Project>, Option<Arc<Calibration>>),
    /// Complete file, such as a figure.
    Bytes(Arc<[u8]>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    Ask,
    Replace,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    IsThere,
    /// The fit is undetermined. The second value is the treatment of an existing file.
    Undetermined(Undetermined, Existing),
}

impl FileContent {
    /// Returns the file name that a dialog suggests.
    pub fn usual_name(&self) -> &'static str {
        match self {
            Self::Calibration(..) => "calibration.json",
            Self::Report(..) => "report.html",
            Self::Traces(_) => "traces.csv",
            Self::Models(_) => "models.csv",
            Self::Metrology(_) => "metrology.csv",
            Self::Thresholds(..) => "thresholds.csv",
            Self::Session(..) => "session.json",
            Self::Bytes(bytes) if bytes.starts_with(b"\x89PNG") => "picture.png",
            Self::Bytes(_) => "plot.svg",
        }
    }

    /// Returns the formats with their endings; empty if there is no choice.
    pub fn formats(&self) -> Vec<(&'static str, Vec<&'static str>)> {
        fn named<W>(all: &[FileFormat<W>]) -> Vec<(&'static str, Vec<&'static str>)> {
            all.iter().map(|own| (own.name, vec![own.ending])).collect()
        }
        match self {
            Self::Calibration(..) => {
                let targets = TARGETS.iter();
                targets.map(|target| (target.name, target.endings.to_vec())).collect()
            }
            Self::Traces(_) => named(TRACE_FORMATS),
            Self::Thresholds(..) => named(MAP_FORMATS),
            _ => Vec::new(),
        }
    }

    /// Returns a description of the parts of the loads that this format leaves out.
    pub fn caution(&self, path: &Path) -> Option<String> {
        match self {
            Self::Calibration(calibration, _) => caution(calibration, path),
            _ => None,
        }
    }

    /// Returns true if writing takes long enough to be shown and cancelled.
    pub fn takes_long(&self) -> bool {
        matches!(self, Self::Report(..) | Self::Traces(_))
    }

    /// Returns the files that are written together under this name.
    pub fn files(&self, path: &Path) -> Vec<PathBuf> {
        match self {
            Self::Thresholds(..) => (map_format(path).write.files)(path),
            _ => vec![path.to_owned()],
        }
    }

    /// Writes the file completely or not at all.
    ///
    /// # Errors
    /// The reason as a sentence.
    pub fn write(&self, path: &Path, progress: &Progress) -> Result<(), String> {
        let mut files = Together::default();
        let written: Result<(), WriteError> = match self {
            Self::Calibration(calibration, Some(request)) => {
                let own = handed_over(request, calibration, progress);
                write_calibration(&own.map_err(|error| error.to_string())?, path)
            }
            Self::Calibration(calibration, None) => write_calibration(calibration, path),
            Self::Report(asked) => {
                let made = report(asked, progress).map_err(|error| error.to_string())?;
                write_report(path, &made)
            }
            Self::Traces(shown) => {
                write_traces(&mut files, path, &shown.calibration, &shown.intervals(), progress)
            }
            Self::Thresholds(map, measure) => {
                (map_format(path).write.write)(map, *measure, path, &mut files)
            }
            Self::Models(table) => write_atomically(path, |out| table.write_csv(out)),
            Self::Metrology(table) => {
                write_atomically(path, |out| figure_records(table).write_csv(out))
            }
            Self::Session(session, project, trained) => {
                let trained = trained.as_deref();
                write_session(&session.with_hashes(), trained, &project.recordings, path)
            }
            Self::Bytes(bytes) => write_atomically(path, |out| out.write_all(bytes)),
        };
        let written = written.and_then(|()| files.finish());
        written.map_err(|error| error.to_string())
    }
}
