//! Reading of files that the user opens: sessions, calibrations, manufacturers' matrices, and recordings.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::{
    engine::{
        project::{Edit, FromFile},
        session::{OpenedSession, Session},
    },
    export::{names_gauges, read_with_notes, target_for},
    finding::{Advice, Face},
    import::{self, Loaded, ReadError, map::ColumnMap},
    progress::Progress,
    questions::question::Unanswered,
    shown::file_name,
};

#[derive(Clone, Debug)]
pub enum Opened {
    Recordings(Loaded),
    /// Calibration from a file, and the edit that applies it or compares the fit with it, with notes for the user.
    Calibration(Edit, Vec<String>),
    Session(Box<OpenedSession>),
    /// Recordings whose columns are not recognised, so that the user must choose them in the import page.
    WantsMap,
}

pub type OpenedFile = (PathBuf, Result<Opened, String>);

/// Returns true if the file name ending is that of a calibration file with gauge names or of a session (`.json`).
pub fn is_calibration(path: &Path) -> bool {
    target_for(path).is_some_and(|target| target.reader.is_some()) && names_gauges(path)
}

/// Reads files one after another, each by its column map if it has one. Folders are replaced by the files in them. The column
/// maps in `remembered` are tried for files whose column names are not sufficient. If the user cancels the work, the files
/// read so far are returned.
pub fn open_all(
    files: &[(PathBuf, Option<ColumnMap>)],
    remembered: &[ColumnMap],
    progress: &Progress,
) -> Vec<OpenedFile> {
    let files = with_folders_opened(files);
    for (path, _) in &files {
        // A file of unknown size counts as empty here. If it cannot be read, the error is reported when it is opened below.
        progress.add_total(std::fs::metadata(path).map_or(0, |metadata| metadata.len()));
    }
    let mut read = Vec::new();
    for (path, map) in files {
        match open(&path, map, remembered, progress) {
            Err(Unanswered::Cancelled) => break,
            Err(Unanswered::Because(why)) => read.push((path, Err(why))),
            Ok(opened) => read.push((path, Ok(opened))),
        }
        if progress.is_cancelled() {
            break;
        }
    }
    read
}

fn open(
    path: &Path,
    map: Option<ColumnMap>,
    remembered: &[ColumnMap],
    progress: &Progress,
) -> Result<Opened, Unanswered> {
    if target_for(path).is_none_or(|target| target.reader.is_none()) {
        let opened = open_recordings(path, map.as_ref(), remembered, progress);
        return opened.map_err(|error| match error {
            ReadError::Cancelled => Unanswered::Cancelled,
            error => Unanswered::Because(error.text(Face::Window)),
        });
    }
    if is_calibration(path) && Session::is_at(path) {
        let session = OpenedSession::read(path, progress).map_err(Unanswered::Because)?;
        // The parts of a session whose reading was cancelled are missing.
        progress.check()?;
        return Ok(Opened::Session(Box::new(session)));
    }
    let calibration = read_with_notes(path);
    let (calibration, notes) =
        calibration.map_err(|error| Unanswered::Because(error.to_string()))?;
    let opened = Some(FromFile { path: path.to_owned(), calibration: Arc::new(calibration) });
    // A file format without gauge names holds a manufacturer's matrix, which is compared with the fit, not applied.
    Ok(if names_gauges(path) {
        Opened::Calibration(Edit::Apply(opened), notes)
    } else {
        Opened::Calibration(Edit::Compare(opened), Vec::new())
    })
}

fn open_recordings(
    path: &Path,
    map: Option<&ColumnMap>,
    remembered: &[ColumnMap],
    progress: &Progress,
) -> Result<Opened, ReadError> {
    match import::read(path, map, remembered, progress) {
        Ok(loaded) => Ok(Opened::Recordings(loaded)),
        Err(error) if map.is_none() && error.wants_a_map() => {
            log::info!("{error}");
            Ok(Opened::WantsMap)
        }
        Err(error) => Err(error),
    }
}

/// Replaces each folder by the files in it, sorted by name. Hidden files are omitted.
fn with_folders_opened(
    files: &[(PathBuf, Option<ColumnMap>)],
) -> Vec<(PathBuf, Option<ColumnMap>)> {
    let is_hidden = |path: &Path| file_name(path).starts_with('.');
    let mut all = Vec::new();
    for (path, map) in files {
        let Ok(entries) = std::fs::read_dir(path) else {
            all.push((path.clone(), map.clone()));
            continue;
        };
        let mut inside: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path.is_file() && !is_hidden(path))
            .collect();
        inside.sort();
        all.extend(inside.into_iter().map(|path| (path, None)));
    }
    all
}
