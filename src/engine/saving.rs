//! Contents of the files that the window writes.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::{
    calibration::{Calibration, Undetermined},
    engine::session::{Session, write_session},
    export::{
        FileFormat, TARGETS, TRACE_FORMATS, Together, WriteError, caution, write_atomically,
        write_calibration, write_traces,
    },
    progress::Progress,
    questions::{
        OnScreen, Request, handed_over,
        page::{ReportRequest, report, write_report},
        thresholds::{MAP_FORMATS, Measure, ThresholdMap, map_format},
    },
    report::Table,
};

/// Content to be written to one or several files.
#[derive(Clone, Debug)]
pub struct Output {
    pub content: FileContent,
    pub paths: Vec<PathBuf>,
    pub existing: Existing,
}

/// Reason why a file was not written.
#[derive(Debug)]
pub enum Unwritten {
    /// The file exists, and the user has not yet allowed to replace it.
    Exists,
    Because(String),
}

/// Content of a file to be written. If there are several formats, the file name ending selects the format.
#[derive(Clone, Debug)]
pub enum FileContent {
    /// Calibration, and the request by which it was fitted (`None` if the calibration was read from a file).
    Calibration(Arc<Calibration>, Option<Box<Request>>),
    /// HTML report.
    Report(Box<ReportRequest>),
    /// Table of loads and errors over time.
    Traces(Box<OnScreen>),
    /// Table to be written as CSV, with the file name that a save dialog suggests.
    Table(&'static str, Box<Table>),
    /// Map of the errors over F_th and t_th, and the kind of error that its curves show.
    Thresholds(Arc<ThresholdMap>, Measure),
    /// Session, and the trained calibration to be written in a file beside it.
    Session(Box<Session>, Option<Arc<Calibration>>),
    /// Bytes of the file, such as those of a figure.
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
    /// The recordings do not determine the calibration, so the user must confirm.
    Undetermined(Undetermined),
}

impl FileContent {
    /// Returns the file name that a save dialog suggests.
    pub fn usual_name(&self) -> &'static str {
        match self {
            Self::Calibration(..) => "calibration.json",
            Self::Report(..) => "report.html",
            Self::Traces(_) => "traces.csv",
            Self::Table(name, _) => name,
            Self::Thresholds(..) => "thresholds.csv",
            Self::Session(..) => "session.json",
            Self::Bytes(bytes) if bytes.starts_with(b"\x89PNG") => "picture.png",
            Self::Bytes(_) => "plot.svg",
        }
    }

    /// Returns the names of the possible file formats with their endings; empty if there is only one format.
    pub fn formats(&self) -> Vec<(&'static str, Vec<&'static str>)> {
        fn named<W>(all: &[FileFormat<W>]) -> Vec<(&'static str, Vec<&'static str>)> {
            all.iter().map(|format| (format.name, vec![format.ending])).collect()
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

    /// Returns a warning if the file format cannot hold a part of the calibration.
    pub fn caution(&self, path: &Path) -> Option<String> {
        match self {
            Self::Calibration(calibration, _) => caution(calibration, path),
            _ => None,
        }
    }

    /// Returns true if writing can take seconds. The status line then shows it, so that the user can cancel it.
    pub fn takes_long(&self) -> bool {
        matches!(self, Self::Report(..) | Self::Traces(_) | Self::Calibration(..))
    }

    /// Returns the content as it is written. A fitted calibration gets the names and hashes of its recordings.
    ///
    /// # Errors
    /// The reason in words.
    pub fn handed_over(&self, progress: &Progress) -> Result<Self, String> {
        let Self::Calibration(calibration, Some(request)) = self else { return Ok(self.clone()) };
        let whole = handed_over(request, calibration, progress);
        Ok(Self::Calibration(Arc::new(whole.map_err(|error| error.to_string())?), None))
    }

    /// Returns the paths of all files that are written for this path.
    pub fn files(&self, path: &Path) -> Vec<PathBuf> {
        match self {
            Self::Thresholds(..) => (map_format(path).write.files)(path),
            _ => vec![path.to_owned()],
        }
    }

    /// Writes the file completely or not at all. A fitted calibration must have been [handed over](Self::handed_over).
    ///
    /// # Errors
    /// The reason in words.
    pub fn write(&self, path: &Path, progress: &Progress) -> Result<(), String> {
        let mut files = Together::default();
        let written: Result<(), WriteError> = match self {
            Self::Calibration(calibration, _) => write_calibration(calibration, path),
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
            Self::Table(_, table) => write_atomically(path, |out| table.write_csv(out)),
            Self::Session(session, trained) => {
                write_session(&session.with_hashes(), trained.as_deref(), path)
            }
            Self::Bytes(bytes) => write_atomically(path, |out| out.write_all(bytes)),
        };
        let written = written.and_then(|()| files.finish());
        written.map_err(|error| error.to_string())
    }
}
