//! Sessions and the files that they name.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::app::{OpenedSession, Session, SessionFile, SessionPart};
use crate::export::{read_calibration, sha256};
use crate::import::{self, Loaded};
use crate::progress::Progress;
use crate::small_file::read_small;

/// A session is short; whatever is longer is something else.
const SESSION_BYTES_LIMIT: u64 = 16 << 20;

/// Whether a file is a session.
pub fn is_one(path: &Path) -> bool {
    read_session(path).is_ok_and(|text| Session::is_one(&text))
}

fn read_session(path: &Path) -> io::Result<Vec<u8>> {
    read_small(path, "a session", SESSION_BYTES_LIMIT)
}

/// Reads a session, and the files that it names where they are still to be found.
pub fn read(path: &Path, progress: &Progress) -> Result<OpenedSession, String> {
    let with_path = |error: String| format!("{}: {error}", path.display());
    let text = read_session(path).map_err(|error| with_path(error.to_string()))?;
    let session = Session::from_json(&text).map_err(|error| with_path(error.to_string()))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    for file in &session.files {
        progress.add_total(file.bytes.unwrap_or(0));
    }
    let parts = session
        .files
        .iter()
        .map(|file| part(file, folder, progress));
    let calibration = session.calibration.as_ref().map(|path| {
        let read = read_calibration(&folder.join(path));
        read.map(Arc::new).map_err(|error| error.to_string())
    });
    Ok(OpenedSession {
        parts: parts.collect(),
        calibration,
        session,
    })
}

/// One file: beside the session if it is there, else where it was.
fn part(file: &SessionFile, folder: &Path, progress: &Progress) -> SessionPart {
    let candidates = [folder.join(&file.path), file.absolute.clone()];
    let Some(found) = candidates.into_iter().find(|path| path.is_file()) else {
        return SessionPart {
            file: file.clone(),
            loaded: None,
            changed: false,
        };
    };
    let loaded = import::read(&found, file.columns.as_ref(), &[], progress);
    SessionPart {
        changed: is_another(file, &found),
        file: SessionFile {
            absolute: found,
            ..file.clone()
        },
        loaded: Some(
            loaded
                .map_err(|error| error.to_string())
                .and_then(|loaded| tared(loaded, file)),
        ),
    }
}

/// The recordings tared as they were when the session was saved.
fn tared(mut loaded: Loaded, file: &SessionFile) -> Result<Loaded, String> {
    for recording in &mut loaded.recordings {
        if let Some(tare) = file.tares.get(recording.name()) {
            let tared = recording.clone().tared(*tare);
            (*recording, _) = tared.map_err(|error| error.to_string())?;
        }
    }
    Ok(loaded)
}

/// Whether the file holds something else than when the session was saved.
fn is_another(file: &SessionFile, found: &Path) -> bool {
    let bytes = fs::metadata(found).ok().map(|metadata| metadata.len());
    let other_length = file.bytes.is_some() && bytes.is_some() && file.bytes != bytes;
    let other_content = || {
        let hash = file.sha256.as_ref().zip(sha256(found).ok());
        hash.is_some_and(|(then, now)| *then != now)
    };
    other_length || other_content()
}

/// The session with what its files hold now; a file that cannot be read goes without.
pub fn with_hashes(session: &Session) -> Session {
    let mut session = session.clone();
    for file in &mut session.files {
        let path: &PathBuf = &file.absolute;
        file.bytes = fs::metadata(path).ok().map(|metadata| metadata.len());
        file.sha256 = sha256(path).ok();
    }
    session
}
