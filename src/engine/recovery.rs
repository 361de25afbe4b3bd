//! Autosave: a thread writes unsaved changes every half minute, and a newly trained calibration at once. The thread also runs
//! while the window is hidden and draws nothing.
//!
//! Each window writes its own autosave file, and holds a lock file that the system unlocks when its process ends. If no
//! process holds the lock of an autosave file, the window that wrote it has crashed.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

use crate::{
    calibration::{Calibration, FitSettings},
    engine::{
        project::Project,
        session::{Session, trained_beside, write_session},
    },
    export::clean_up_in,
    recording::RecordingSet,
    same::same_where,
};

const EVERY: Duration = Duration::from_secs(30);
/// Prefix of the names of autosave files and of their lock files.
const PREFIX: &str = "autosave-";

/// Autosaved session of a window that crashed.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftSession {
    pub path: PathBuf,
    pub written: SystemTime,
    pub bytes: u64,
    pub session: Result<Box<Session>, String>,
}

#[derive(Default)]
pub struct Recovery {
    folder: Option<PathBuf>,
    this: Option<ThisWindow>,
    autosave: Autosave,
    thread: Option<JoinHandle<()>>,
    /// What was last passed to the thread: the document, and true if the user has saved it.
    kept: Option<(Unsaved, bool)>,
    /// Autosave files of crashed windows that were restored here. They are about to be removed, so they are not listed.
    restored: Vec<PathBuf>,
}

struct ThisWindow {
    session: PathBuf,
    lock: PathBuf,
    /// Open lock file. The operating system releases the lock when the process ends.
    _held: File,
}

#[derive(Clone, Default)]
pub struct Unsaved {
    pub session: Session,
    /// Trained network or kernel calibration, which is written in a file beside the session.
    pub trained: Option<Arc<Calibration>>,
}

same_where!(Unsaved: shared(trained) value(session) besides());

impl Unsaved {
    /// Returns true if `trained` is this state's trained calibration, or if both are `None`.
    fn is_training(&self, trained: Option<&Arc<Calibration>>) -> bool {
        self.trained.as_ref().map(Arc::as_ptr) == trained.map(Arc::as_ptr)
    }

    fn write(&self, path: &Path) -> bool {
        write_session(&self.session, self.trained.as_deref(), path).is_ok()
    }
}

/// Way to the autosave thread, if it runs.
#[derive(Clone, Default)]
pub struct Autosave(Option<Sender<Message>>);

enum Message {
    /// The newest document, and true if the user has saved it.
    Newest(Unsaved, bool),
    /// A calibration that was just trained on these recordings with these settings.
    Trained(Arc<RecordingSet>, FitSettings, Arc<Calibration>),
    /// Autosave files of crashed windows that were restored here. Each is removed once this window has autosaved or saved its
    /// content.
    Restored(Vec<PathBuf>),
    /// The window ends.
    End,
}

impl Autosave {
    /// Makes the thread autosave a calibration as soon as it is trained, even if the window is hidden.
    pub fn take_trained(
        &self,
        recordings: &Arc<RecordingSet>,
        settings: &FitSettings,
        trained: &Arc<Calibration>,
    ) {
        let (recordings, trained) = (Arc::clone(recordings), Arc::clone(trained));
        self.send(Message::Trained(recordings, settings.clone(), trained));
    }

    fn send(&self, message: Message) {
        if let Some(thread) = &self.0 {
            // Sending fails only after the end of the thread, so the failure is ignored.
            let _ = thread.send(message);
        }
    }
}

/// State of the autosave thread.
struct Desk {
    path: PathBuf,
    every: Duration,
    newest: Unsaved,
    /// True if the user has saved the newest document in a session file.
    is_saved: bool,
    /// State (session and trained calibration) that the autosave file contains; `None` if there is no file.
    written: Option<Unsaved>,
    restored: Vec<PathBuf>,
}

impl Desk {
    /// Writes changes until the window ends, at intervals of at least `every`.
    fn run(mut self, inbox: &Receiver<Message>) {
        let mut next = Instant::now();
        loop {
            let is_known = self.written.as_ref().is_some_and(|written| *written == self.newest);
            let is_due = !self.is_saved && (!is_known || !self.restored.is_empty());
            let message = if is_due {
                inbox.recv_timeout(next.saturating_duration_since(Instant::now()))
            } else {
                inbox.recv().map_err(RecvTimeoutError::from)
            };
            match message {
                Ok(Message::End) | Err(RecvTimeoutError::Disconnected) => return,
                Ok(message) => {
                    if self.take(message) {
                        next = Instant::now();
                    }
                }
                Err(RecvTimeoutError::Timeout) => {
                    // A failed autosave is not reported, because the user did not ask for it. It is tried again after the
                    // interval.
                    next = Instant::now() + self.every;
                    if self.newest.write(&self.path) {
                        self.written = Some(self.newest.clone());
                        drop_all(std::mem::take(&mut self.restored));
                    }
                }
            }
        }
    }

    /// Returns true if the newest document must be written at once.
    fn take(&mut self, message: Message) -> bool {
        let is_urgent = match message {
            Message::Newest(newest, is_saved) => {
                let trained = newest.trained.as_ref();
                let is_new = trained.is_some() && !self.newest.is_training(trained);
                (self.newest, self.is_saved) = (newest, is_saved);
                is_new
            }
            Message::Trained(recordings, settings, trained) => {
                let of = &self.newest.session.project;
                let is_meant = Arc::ptr_eq(&of.recordings, &recordings) && of.settings == settings;
                if is_meant {
                    (self.newest.trained, self.is_saved) = (Some(trained), false);
                }
                is_meant
            }
            Message::Restored(restored) => {
                self.restored.extend(restored);
                true
            }
            Message::End => false,
        };
        if self.is_saved {
            // The autosave file is older than the session that the user saved, so it is removed.
            if self.written.take().is_some() {
                remove_pair(&self.path);
            }
            drop_all(std::mem::take(&mut self.restored));
        }
        is_urgent
    }
}

impl Recovery {
    /// Starts the autosave in `folder`. If the folder cannot be used, nothing is autosaved.
    pub fn begin(folder: &Path) -> Self {
        Self::begin_every(folder, EVERY)
    }

    pub fn begin_every(folder: &Path, every: Duration) -> Self {
        let this = ThisWindow::new(folder);
        // A window that was killed leaves its temporary files behind, so they are removed here.
        clean_up_in(folder);
        let begun = this.as_ref().map(|this| {
            let desk = Desk {
                path: this.session.clone(),
                every,
                newest: Unsaved::default(),
                is_saved: true,
                written: None,
                restored: Vec::new(),
            };
            let (sender, inbox) = channel();
            (sender, std::thread::spawn(move || desk.run(&inbox)))
        });
        let (sender, thread) = begun.unzip();
        let folder = Some(folder.to_owned());
        let (kept, restored) = (None, Vec::new());
        Self { folder, this, autosave: Autosave(sender), thread, kept, restored }
    }

    pub fn autosave(&self) -> Autosave {
        self.autosave.clone()
    }

    /// Returns the autosave file of this window.
    #[cfg(test)]
    pub fn path(&self) -> Option<&Path> {
        self.this.as_ref().map(|this| &*this.session)
    }

    /// Returns the sessions of crashed windows, oldest first.
    pub fn left(&self) -> Vec<LeftSession> {
        let mut left = self.folder.as_deref().map_or_else(Vec::new, left_in);
        left.retain(|left| !self.restored.contains(&left.path));
        left
    }

    /// Returns true if the autosave thread already has this document, this trained calibration and this value of `is_saved`.
    pub fn has(
        &self,
        project: &Project,
        trained: Option<&Arc<Calibration>>,
        is_saved: bool,
    ) -> bool {
        self.kept.as_ref().is_some_and(|(kept, was_saved)| {
            *was_saved == is_saved && kept.is_training(trained) && kept.session.project == *project
        })
    }

    /// Passes the newest document to the autosave thread. `is_saved` is true if the user has saved it.
    pub fn keep(&mut self, newest: Unsaved, is_saved: bool) {
        self.kept = Some((newest.clone(), is_saved));
        self.autosave.send(Message::Newest(newest, is_saved));
    }

    /// Removes these restored files of crashed windows as soon as this window has autosaved or saved their content.
    pub fn take_over(&mut self, restored: Vec<PathBuf>) {
        if self.kept.as_ref().is_some_and(|(_, is_saved)| *is_saved) {
            drop_all(restored);
        } else if !restored.is_empty() {
            self.restored.extend_from_slice(&restored);
            self.autosave.send(Message::Restored(restored));
        }
    }

    /// Ends the autosave thread, and removes the autosave file of this window.
    pub fn end(&mut self) {
        self.stop();
        if let Some(this) = self.this.take() {
            remove_pair(&this.session);
            let _ = fs::remove_file(&this.lock);
        }
    }

    fn stop(&mut self) {
        self.autosave.send(Message::End);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// If the window ends without [`Recovery::end`], the autosave file stays, so that it can be restored.
impl Drop for Recovery {
    fn drop(&mut self) {
        self.stop();
    }
}

impl ThisWindow {
    fn new(folder: &Path) -> Option<Self> {
        fs::create_dir_all(folder).ok()?;
        // The process number of this window may be that of an earlier crashed process, so the next free number is used.
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
            // Another process may have removed the lock file before it was locked here.
            if lock.exists() {
                return Some(Self { session, lock, _held: held });
            }
        }
        None
    }
}

/// Locks the lock file of a session and returns it; `None` if another process holds the lock.
fn free(lock: &Path) -> Option<File> {
    let file = File::open(lock).ok()?;
    file.try_lock().ok()?;
    Some(file)
}

/// Returns the autosaved sessions of ended processes, oldest first. Lock files without a session are removed.
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

/// Removes the autosaved session of a crashed window, with its lock file.
pub fn drop_left(session: &Path) {
    remove_pair(session);
    let _ = fs::remove_file(session.with_extension("lock"));
}

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
    fn sessions_of_crashed_windows_are_found_and_those_of_running_ones_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let mut living = Recovery::begin(folder.path());
        assert!(living.left().is_empty());
        let own = living.this.as_ref().unwrap().session.clone();
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
        assert!(!path("autosave-2.lock").exists(), "a lock without a session is removed");
        drop_left(&path("autosave-1.json"));
        assert_eq!(left_in(folder.path()).len(), 1, "the other session stays");
        living.end();
        assert!(!own.exists());
    }

    #[test]
    fn a_window_never_overwrites_the_session_of_another() {
        let folder = tempfile::tempdir().unwrap();
        let of_own_number = format!("autosave-{}.lock", std::process::id());
        let lock = folder.path().join(of_own_number);
        fs::write(&lock, "").unwrap();
        fs::write(lock.with_extension("json"), "{}").unwrap();
        let mut next = Recovery::begin(folder.path());
        let left = next.left();
        assert_eq!(left.len(), 1);
        assert_ne!(next.this.as_ref().unwrap().session, left[0].path);
        next.end();
        assert!(left[0].path.exists());
    }

    #[test]
    fn unreadable_sessions_are_listed_with_size_and_reason() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("autosave-1.json");
        fs::write(&path, "torn").unwrap();
        fs::write(folder.path().join("other.json"), "{}").unwrap();
        fs::write(folder.path().join("other.lock"), "").unwrap();
        let left = Recovery::begin(folder.path()).left();
        assert_eq!((left.len(), &left[0].path, left[0].bytes), (1, &path, 4));
        let reason = left[0].session.as_ref().unwrap_err();
        assert!(reason.contains("not a session"), "{reason}");
        assert!(folder.path().join("other.lock").exists(), "locks with other names stay");
    }

    /// Waits until a condition holds that another thread causes.
    #[track_caller]
    fn until(holds: impl Fn() -> bool) {
        let deadline = Instant::now() + Duration::from_secs(60);
        while !holds() {
            assert!(Instant::now() < deadline);
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn unsaved(notes: &str) -> Unsaved {
        let project = Project { notes: notes.to_owned(), ..Project::default() };
        Unsaved { session: Session::of(&project), trained: None }
    }

    #[test]
    fn restored_files_stay_until_they_are_written_or_saved_here() {
        let folder = tempfile::tempdir().unwrap();
        let other = folder.path().join("autosave-1.json");
        let mut window = Recovery::begin_every(folder.path(), Duration::from_millis(5));
        let own = window.this.as_ref().unwrap().session.clone();
        for is_saved in [false, true] {
            fs::write(&other, "{}").unwrap();
            window.keep(unsaved("restored"), is_saved);
            window.take_over(vec![other.clone()]);
            assert!(window.left().iter().all(|left| left.path != other));
            until(|| !other.exists() && own.exists() != is_saved);
        }
        // If the content cannot be written, the file stays and the write is tried again.
        fs::write(&other, "{}").unwrap();
        fs::create_dir(&own).unwrap();
        window.keep(unsaved("again"), false);
        window.take_over(vec![other.clone()]);
        std::thread::sleep(Duration::from_millis(30));
        assert!(other.exists());
        fs::remove_dir(&own).unwrap();
        until(|| !other.exists() && own.exists());
        window.end();
        assert!(!own.exists());
    }

    /// No frame is drawn, but the thread writes the training long before the next turn.
    #[test]
    fn a_training_in_a_hidden_window_is_written_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let mut window = Recovery::begin_every(folder.path(), Duration::from_secs(3600));
        let own = window.this.as_ref().unwrap().session.clone();
        let set = Arc::new(crate::recording::simulated::recordings(3));
        let settings = FitSettings { decimation: 50, ..FitSettings::default() };
        let mut newest = unsaved("saved");
        let of = &mut newest.session.project;
        (of.recordings, of.settings) = (Arc::clone(&set), settings.clone());
        window.keep(newest, true);
        let request = crate::questions::Request::fit(Arc::clone(&set), settings.clone());
        let trained =
            crate::questions::train(&request, &crate::progress::Progress::default(), &mut |_| {});
        let trained = Arc::new(trained.unwrap());
        let other = FitSettings::default();
        window.autosave().take_trained(&set, &other, &trained);
        std::thread::sleep(Duration::from_millis(30));
        assert!(!own.exists(), "the training has other settings");
        window.autosave().take_trained(&set, &settings, &trained);
        until(|| own.exists() && trained_beside(&own).exists());
        window.end();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
