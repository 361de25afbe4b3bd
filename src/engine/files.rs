//! What a file is, found out in one place: a session, a calibration, the matrix that a sensor came with, or recordings.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::calibration::Calibration;
use crate::engine::session::{OpenedSession, Session};
use crate::export::{names_gauges, read_with_notes, target_for};
use crate::finding::{Advice, Face};
use crate::import;
use crate::import::map::ColumnMap;
use crate::import::{Cause, LoadWarning, Loaded, ReadError};
use crate::progress::Progress;

/// What a file held.
#[derive(Clone, Debug)]
pub enum Opened {
    /// Recordings, with what was remarkable about reading them, and the map that they were read by if any.
    Recordings(Loaded, Option<Box<ColumnMap>>),
    /// A calibration, with what its user must know of the file.
    Calibration(Arc<Calibration>, Vec<String>),
    /// The matrix that the sensor came with.
    Factory(Arc<Calibration>),
    /// A session with its files.
    Session(Box<OpenedSession>),
    /// Its columns have to be said first, for this reason.
    WantsMap(String),
}

/// A file with what it held, or why it could not be read.
pub type OpenedFile = (PathBuf, Result<Opened, String>);

/// Whether the file's name says that it is a calibration or a session rather than recordings.
pub fn is_calibration(path: &Path) -> bool {
    target_for(path).is_some_and(|target| target.reader.is_some()) && names_gauges(path)
}

/// Reads files one after another, each by its map if it has one; what was read before a cancel is kept. Folders are read
/// file by file; `remembered` are maps for files whose names say too little.
pub fn open_all(
    files: &[(PathBuf, Option<ColumnMap>)],
    remembered: &[ColumnMap],
    progress: &Progress,
) -> Vec<OpenedFile> {
    let files = with_folders_opened(files);
    for (path, _) in &files {
        // A file that cannot be asked for its size is reported when it is read.
        progress.add_total(std::fs::metadata(path).map_or(0, |metadata| metadata.len()));
    }
    let mut read = Vec::new();
    for (path, map) in files {
        let opened = open(&path, map, remembered, progress);
        if progress.is_cancelled() {
            break;
        }
        read.push((path, opened));
    }
    read
}

fn open(
    path: &Path,
    map: Option<ColumnMap>,
    remembered: &[ColumnMap],
    progress: &Progress,
) -> Result<Opened, String> {
    let calibration = || {
        let read = read_with_notes(path).map_err(|error| error.to_string());
        read.map(|(calibration, notes)| (Arc::new(calibration), notes))
    };
    match target_for(path).and_then(|target| target.reader) {
        Some(_) if !names_gauges(path) => {
            calibration().map(|(factory, _)| Opened::Factory(factory))
        }
        Some(_) if Session::is_at(path) => {
            let opened = OpenedSession::read(path, progress)?;
            Ok(Opened::Session(Box::new(opened)))
        }
        Some(_) => calibration().map(|(own, notes)| Opened::Calibration(own, notes)),
        None => open_recordings(path, map.as_ref(), remembered, progress)
            .map_err(|error| error.text(Face::Window)),
    }
}

/// Reads recordings, by the file's own map if there is one.
fn open_recordings(
    path: &Path,
    map: Option<&ColumnMap>,
    remembered: &[ColumnMap],
    progress: &Progress,
) -> Result<Opened, ReadError> {
    match import::read(path, map, remembered, progress) {
        Ok(mut loaded) => {
            let asks = |warning: &&LoadWarning| matches!(warning.cause, Cause::UnnamedLoads { .. });
            if let Some(unnamed) = loaded.warnings.iter().find(asks).filter(|_| map.is_none()) {
                return Ok(Opened::WantsMap(unnamed.to_string()));
            }
            let map = loaded.map.take();
            Ok(Opened::Recordings(loaded, map))
        }
        Err(error) if map.is_none() && error.wants_a_map() => {
            Ok(Opened::WantsMap(error.to_string()))
        }
        Err(error) => Err(error),
    }
}

/// Folders are replaced by the files in them, in the order of their names; hidden ones are left out.
fn with_folders_opened(
    files: &[(PathBuf, Option<ColumnMap>)],
) -> Vec<(PathBuf, Option<ColumnMap>)> {
    let is_hidden = |path: &Path| {
        let name = path.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().starts_with('.')
    };
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
