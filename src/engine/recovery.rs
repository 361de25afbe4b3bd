//! What is not saved is written down now and then, so that a crash costs half a minute at most.
//!
//! Each window has a file of its own beside a lock that ends with its process: what stands beside a lock that nobody holds
//! was left by a window that did not close as it should.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::SystemTime;

use crate::calibration::Calibration;
use crate::engine::session::{Session, trained_beside, write_session};
use crate::export::clean_up_in;
use crate::recording::RecordingSet;

/// How often what is not saved is written down (s).
const EVERY_SECS: f64 = 30.0;
/// How soon to look again while it is being written (s).
const SOON_SECS: f64 = 0.2;
/// What the names of autosaved sessions and their locks begin with.
const PREFIX: &str = "autosave-";

/// An autosaved session of a window that did not close as it should.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftSession {
    /// Its file.
    pub path: PathBuf,
    /// When it was written last.
    pub written: SystemTime,
    /// How long its file is.
    pub bytes: u64,
    /// What it holds, or why it cannot be read.
    pub session: Result<Box<Session>, String>,
}

/// The file of this window.
#[derive(Default)]
pub struct Recovery {
    folder: Option<PathBuf>,
    own: Option<Own>,
    /// What was written down last.
    written: Option<Unsaved>,
    /// What is being written down.
    writing: Option<Writing>,
    /// What this window took over of others; it goes once it is safe here.
    restored: Vec<PathBuf>,
    /// When the next look is due, on the window's clock.
    due_secs: f64,
}

struct Own {
    session: PathBuf,
    lock: PathBuf,
    /// Held as long as the process lives.
    _held: File,
}

/// What is not saved.
#[derive(Clone, Default)]
pub struct Unsaved {
    /// The session.
    pub session: Session,
    /// The trained calibration that is written beside it.
    pub trained: Option<Arc<Calibration>>,
    /// The recordings that it was trained on.
    pub of: Arc<RecordingSet>,
}

impl Unsaved {
    fn is_same(&self, other: &Self) -> bool {
        let trained = |own: &Self| own.trained.as_ref().map(Arc::as_ptr);
        self.session == other.session && trained(self) == trained(other)
    }

    fn write(&self, path: &Path) -> bool {
        write_session(&self.session, self.trained.as_deref(), &self.of, path).is_ok()
    }
}

struct Writing {
    unsaved: Unsaved,
    /// Autosaved sessions of other windows that this one restored.
    restored: Vec<PathBuf>,
    /// Whether it could be written.
    thread: JoinHandle<bool>,
}

impl Recovery {
    /// Takes a file in `folder`. Where the folder cannot be used, nothing is written down.
    pub fn begin(folder: &Path) -> Self {
        let own = Own::new(folder);
        // What a killed window was writing; nobody writes a file of its name again.
        clean_up_in(folder);
        Self {
            folder: Some(folder.to_owned()),
            own,
            ..Self::default()
        }
    }

    /// What other windows left, oldest first.
    pub fn left(&self) -> Vec<LeftSession> {
        let mut left = self.folder.as_deref().map_or_else(Vec::new, left_in);
        let writing = self.writing.iter().flat_map(|writing| &writing.restored);
        let taken: Vec<&PathBuf> = self.restored.iter().chain(writing).collect();
        left.retain(|left| !taken.contains(&&left.path));
        left
    }

    /// Writes down what is not saved (`None`: nothing is), if it is time on the window's clock; tells when the next look is due.
    pub fn follow(&mut self, now_secs: f64, unsaved: Option<&dyn Fn() -> Unsaved>) -> Option<f64> {
        // One after the other, so that the newest is what stays.
        if self.is_writing() {
            return Some(SOON_SECS);
        }
        let Some(unsaved) = unsaved else {
            drop_all(std::mem::take(&mut self.restored));
            if let (Some(_), Some(own)) = (self.written.take(), &self.own) {
                // Restored, it would go back behind what is saved.
                remove_pair(&own.session);
            }
            return None;
        };
        let own = self.own.as_ref()?;
        if now_secs < self.due_secs {
            return Some(self.due_secs - now_secs);
        }
        self.due_secs = now_secs + EVERY_SECS;
        let unsaved = unsaved();
        let restored = std::mem::take(&mut self.restored);
        if self
            .written
            .as_ref()
            .is_some_and(|own| own.is_same(&unsaved))
        {
            drop_all(restored);
            return Some(EVERY_SECS);
        }
        let (path, own) = (own.session.clone(), unsaved.clone());
        self.writing = Some(Writing {
            unsaved,
            restored,
            // A folder that cannot be written is no error of the user's.
            thread: std::thread::spawn(move || own.write(&path)),
        });
        Some(SOON_SECS)
    }

    /// Whether it is being written down just now.
    fn is_writing(&mut self) -> bool {
        let goes_on = |writing: &Writing| !writing.thread.is_finished();
        let is_writing = self.writing.as_ref().is_some_and(goes_on);
        if !is_writing {
            self.take_written();
        }
        is_writing
    }

    /// Waits until it is written down. What could not be is tried again at the next look.
    fn take_written(&mut self) {
        let Some(writing) = self.writing.take() else {
            return;
        };
        if writing.thread.join().unwrap_or(false) {
            self.written = Some(writing.unsaved);
            drop_all(writing.restored);
        } else {
            self.restored.extend(writing.restored);
        }
    }

    /// This window holds what these files of others hold: they go once that is written down or saved.
    pub fn take_over(&mut self, restored: Vec<PathBuf>) {
        if !restored.is_empty() {
            self.restored.extend(restored);
            self.due_secs = 0.0;
        }
    }

    /// Nothing needs to be recovered.
    pub fn end(&mut self) {
        // It would come after its file is taken away.
        self.take_written();
        if let Some(own) = self.own.take() {
            remove_pair(&own.session);
            let _ = fs::remove_file(&own.lock);
        }
    }
}

impl Own {
    fn new(folder: &Path) -> Option<Self> {
        fs::create_dir_all(folder).ok()?;
        // A process may have the number of one that left its session there.
        for number in std::process::id().. {
            let lock = folder.join(format!("{PREFIX}{number}.lock"));
            let session = lock.with_extension("json");
            if session.exists() {
                continue;
            }
            let held = match File::create_new(&lock) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                created => created.ok()?,
            };
            held.lock().ok()?;
            // Somebody may have been quicker to lock it, and took it away.
            if lock.exists() {
                return Some(Self {
                    session,
                    lock,
                    _held: held,
                });
            }
        }
        None
    }
}

/// A lock that no living window holds; the lock is ours as long as it is kept.
fn free(lock: &Path) -> Option<File> {
    let file = File::open(lock).ok()?;
    file.try_lock().ok()?;
    Some(file)
}

/// Sessions that belong to no living window, oldest first. Locks without a session go.
fn left_in(folder: &Path) -> Vec<LeftSession> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut left = Vec::new();
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let ending = path.extension().and_then(|ending| ending.to_str());
        match ending.filter(|_| name.starts_with(PREFIX)) {
            Some("lock") if !path.with_extension("json").exists() => {
                if let Some(_ours) = free(&path) {
                    let _ = fs::remove_file(&path);
                }
            }
            Some("json") if !name.ends_with(".trained.json") => {
                let lock = path.with_extension("lock");
                let is_free = !lock.exists() || free(&lock).is_some();
                let metadata = fs::metadata(&path).ok().filter(|_| is_free);
                if let Some(metadata) = metadata {
                    left.push(LeftSession {
                        written: metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH),
                        bytes: metadata.len(),
                        session: Session::read(&path).map(Box::new),
                        path,
                    });
                }
            }
            _ => {}
        }
    }
    left.sort_by(|a, b| (a.written, &a.path).cmp(&(b.written, &b.path)));
    left
}

/// Takes away what another window left.
pub fn drop_left(session: &Path) {
    remove_pair(session);
    let _ = fs::remove_file(session.with_extension("lock"));
}

/// Removes a session and the trained calibration beside it; a file that stays does no harm.
fn remove_pair(session: &Path) {
    let _ = fs::remove_file(trained_beside(session));
    let _ = fs::remove_file(session);
}

fn drop_all(restored: Vec<PathBuf>) {
    restored.iter().for_each(|session| drop_left(session));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_dead_window_left_is_found_and_that_of_a_living_one_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let mut living = Recovery::begin(folder.path());
        assert!(living.left().is_empty());
        let own = living.own.as_ref().unwrap().session.clone();
        fs::write(&own, "{}").unwrap();
        fs::write(path("autosave-1.lock"), "").unwrap();
        fs::write(path("autosave-1.json"), "{}").unwrap();
        fs::write(path("autosave-2.lock"), "").unwrap();
        fs::write(path("autosave-3.lock"), "").unwrap();
        let named = r#"{"format": "loopscope session", "files": [{"absolute": "/data/a.csv"}]}"#;
        fs::write(path("autosave-3.json"), named).unwrap();
        let files = |left: LeftSession| {
            let files = left.session.unwrap().files.into_iter();
            (left.path, files.map(|file| file.absolute).collect())
        };
        let found: Vec<(PathBuf, Vec<PathBuf>)> =
            left_in(folder.path()).into_iter().map(files).collect();
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
        let mut next = Recovery::begin(folder.path());
        let left = next.left();
        assert_eq!(left.len(), 1);
        assert_ne!(next.own.as_ref().unwrap().session, left[0].path);
        next.end();
        assert!(left[0].path.exists());
    }

    #[test]
    fn what_cannot_be_read_is_listed_with_its_size_and_the_reason_whatever_became_of_its_lock() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("autosave-1.json");
        fs::write(&path, "torn").unwrap();
        fs::write(folder.path().join("other.json"), "{}").unwrap();
        fs::write(folder.path().join("other.lock"), "").unwrap();
        let left = Recovery::begin(folder.path()).left();
        assert_eq!((left.len(), &left[0].path, left[0].bytes), (1, &path, 4));
        let reason = left[0].session.as_ref().unwrap_err();
        assert!(reason.contains("not a session"), "{reason}");
        assert!(folder.path().join("other.lock").exists(), "it is not ours");
    }

    /// Draws frames until nothing is being written.
    fn written(window: &mut Recovery, unsaved: Option<&dyn Fn() -> Unsaved>) {
        let mut now_secs = 0.0;
        window.follow(now_secs, unsaved);
        while window.is_writing() {
            now_secs += 0.01;
            window.follow(now_secs, unsaved);
            std::thread::yield_now();
        }
    }

    #[test]
    fn what_is_restored_stays_until_it_is_written_down_or_saved_here() {
        let folder = tempfile::tempdir().unwrap();
        let other = folder.path().join("autosave-1.json");
        let session = Session {
            notes: "restored".to_owned(),
            ..Session::default()
        };
        let unsaved = || Unsaved {
            session: session.clone(),
            ..Unsaved::default()
        };
        let mut window = Recovery::begin(folder.path());
        let own = window.own.as_ref().unwrap().session.clone();
        for is_saved in [false, true] {
            fs::write(&other, "{}").unwrap();
            window.take_over(vec![other.clone()]);
            assert!(window.left().is_empty() && other.exists());
            let unsaved: &dyn Fn() -> Unsaved = &unsaved;
            written(&mut window, Some(unsaved).filter(|_| !is_saved));
            assert!(!other.exists());
            assert_eq!(own.exists(), !is_saved);
        }
        // Where nothing can be written, it stays, and it is tried again.
        fs::write(&other, "{}").unwrap();
        fs::create_dir(&own).unwrap();
        window.take_over(vec![other.clone()]);
        written(&mut window, Some(&unsaved));
        assert!(other.exists());
        fs::remove_dir(&own).unwrap();
        window.due_secs = 0.0;
        written(&mut window, Some(&unsaved));
        assert!(!other.exists() && own.exists());
        window.end();
        assert!(!own.exists());
    }
}
