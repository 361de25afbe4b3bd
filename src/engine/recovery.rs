//! What is not saved is written down now and then, so that a crash costs half a minute at most.
//!
//! Each window has a file of its own beside a lock that ends with its process: what stands beside a lock that nobody holds
//! was left by a window that did not close as it should.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::engine::session::Session;
use crate::export::write_atomically;

/// How often what is not saved is written down (s).
const EVERY_SECS: f64 = 30.0;

/// An autosaved session of a window that did not close as it should.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftSession {
    /// Its file.
    pub path: PathBuf,
    /// When it was written last.
    pub written: SystemTime,
    /// The recordings' files.
    pub files: Vec<PathBuf>,
}

/// The file of this window.
#[derive(Debug, Default)]
pub struct Recovery {
    own: Option<Own>,
    /// What was written down last.
    written: Option<Session>,
    /// When the next look is due, on the window's clock.
    due_secs: f64,
}

#[derive(Debug)]
struct Own {
    session: PathBuf,
    lock: PathBuf,
    /// Held as long as the process lives.
    _held: File,
}

impl Recovery {
    /// Takes a file in `folder`; returns what others left there, oldest first. Where the folder cannot be used, nothing is
    /// written down.
    pub fn begin(folder: &Path) -> (Self, Vec<LeftSession>) {
        let left = left_in(folder);
        let own = Own::new(folder);
        let recovery = Self {
            own,
            ..Self::default()
        };
        (recovery, left)
    }

    /// Writes down what is not saved (`None`: nothing is), if it is time on the window's clock; tells when the next look is due.
    pub fn follow(&mut self, now_secs: f64, unsaved: Option<&dyn Fn() -> Session>) -> Option<f64> {
        let own = self.own.as_ref()?;
        let Some(session) = unsaved else {
            if self.written.take().is_some() {
                // Whoever reads it would go back behind what is saved; a file that stays does no other harm.
                let _ = fs::remove_file(&own.session);
            }
            return None;
        };
        if now_secs < self.due_secs {
            return None;
        }
        self.due_secs = now_secs + EVERY_SECS;
        let session = session();
        if self.written.as_ref() != Some(&session) {
            let path = own.session.clone();
            let text = session.to_json(Path::new(""));
            self.written = Some(session);
            std::thread::spawn(move || {
                // Nobody waits for it; a folder that cannot be written was not asked for by anyone.
                let _ = write_atomically(&path, |out| out.write_all(&text));
            });
        }
        Some(EVERY_SECS)
    }

    /// Drops what another window left; what is not saved is written down at the next look.
    pub fn drop_left(&mut self, session: &Path) {
        self.due_secs = 0.0;
        drop_left(session);
    }

    /// Nothing needs to be recovered.
    pub fn end(&mut self) {
        if let Some(own) = self.own.take() {
            let _ = fs::remove_file(&own.session);
            let _ = fs::remove_file(&own.lock);
        }
    }
}

impl Own {
    fn new(folder: &Path) -> Option<Self> {
        fs::create_dir_all(folder).ok()?;
        // A process may have the number of one that left its session there.
        let numbers = std::process::id()..;
        let names = numbers.map(|number| folder.join(format!("autosave-{number}.lock")));
        let mut free = names.filter(|lock| !lock.exists() && !lock.with_extension("json").exists());
        let lock = free.next()?;
        let held = File::create_new(&lock).ok()?;
        held.try_lock().ok()?;
        Some(Self {
            session: lock.with_extension("json"),
            lock,
            _held: held,
        })
    }
}

/// Sessions beside locks that nobody holds, oldest first.
fn left_in(folder: &Path) -> Vec<LeftSession> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut left = Vec::new();
    for lock in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        let is_lock = lock.extension().is_some_and(|ending| ending == "lock");
        let is_free = || File::open(&lock).is_ok_and(|file| file.try_lock().is_ok());
        if !is_lock || !is_free() {
            continue;
        }
        let session = lock.with_extension("json");
        match fs::metadata(&session).and_then(|metadata| metadata.modified()) {
            Ok(written) => {
                // One that cannot be understood is there all the same; restoring it says why.
                let text = fs::read(&session).unwrap_or_default();
                let files = Session::from_json(&text).map_or_else(|_| Vec::new(), |own| own.files);
                left.push(LeftSession {
                    path: session,
                    written,
                    files: files.into_iter().map(|file| file.absolute).collect(),
                });
            }
            Err(_) => {
                let _ = fs::remove_file(&lock);
            }
        }
    }
    left.sort_by(|a, b| (a.written, &a.path).cmp(&(b.written, &b.path)));
    left
}

fn drop_left(session: &Path) {
    let _ = fs::remove_file(session);
    let _ = fs::remove_file(session.with_extension("lock"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_dead_window_left_is_found_and_that_of_a_living_one_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let (mut living, left) = Recovery::begin(folder.path());
        assert!(left.is_empty());
        let own = living.own.as_ref().unwrap().session.clone();
        fs::write(&own, "{}").unwrap();
        fs::write(path("autosave-1.lock"), "").unwrap();
        fs::write(path("autosave-1.json"), "{}").unwrap();
        fs::write(path("autosave-2.lock"), "").unwrap();
        fs::write(path("autosave-3.lock"), "").unwrap();
        let named = r#"{"format": "loopscope session", "files": [{"absolute": "/data/a.csv"}]}"#;
        fs::write(path("autosave-3.json"), named).unwrap();
        let found: Vec<_> = left_in(folder.path())
            .into_iter()
            .map(|left| (left.path, left.files))
            .collect();
        let expected = [
            (path("autosave-1.json"), vec![]),
            (path("autosave-3.json"), vec![PathBuf::from("/data/a.csv")]),
        ];
        assert_eq!(found, expected);
        assert!(
            !path("autosave-2.lock").exists(),
            "there was nothing beside it"
        );
        drop_left(&path("autosave-1.json"));
        assert_eq!(left_in(folder.path()).len(), 1, "the other one stays");
        living.end();
        assert!(!own.exists());
    }

    #[test]
    fn a_window_never_writes_over_what_another_left() {
        let folder = tempfile::tempdir().unwrap();
        let of_own_number = format!("autosave-{}.lock", std::process::id());
        let lock = folder.path().join(of_own_number);
        fs::write(&lock, "").unwrap();
        fs::write(lock.with_extension("json"), "{}").unwrap();
        let (mut next, left) = Recovery::begin(folder.path());
        assert_eq!(left.len(), 1);
        assert_ne!(next.own.as_ref().unwrap().session, left[0].path);
        next.end();
        assert!(left[0].path.exists());
    }
}
