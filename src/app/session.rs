//! A session: which files were open, what they are for, and how everything was set; recordings and results stay where they are.
//!
//! Guarantees: what is written reads back the same; parts that a file does not name are as in a new window, so that
//! older sessions keep loading.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use crate::analysis::View;
use crate::app::{
    AppState, Applied, Choices, Effect, Existing, FileContent, History, Level, Notice, OpenedFile,
    Wish,
};
use crate::calibration::{Calibration, FitSettings};
use crate::import::Loaded;
use crate::import::map::ColumnMap;
use crate::recording::{Axis, RecordingSet, Role, Source, Tare};

const FORMAT: &str = "loopscope session";
const VERSION: u32 = 1;

/// What a session's file holds.
///
/// | part | meaning |
/// |---|---|
/// | `notes` | free text |
/// | `built_in` | whether the built-in sensor was open; then there are no files |
/// | `files` | the recordings' files, in the order of opening |
/// | `cut` | recordings are cut in time: this first share trains |
/// | `calibration` | the file of a calibration that is applied instead of fitted |
/// | `settings` | the choices of the fit |
/// | `on_screen` | the name of the recording on screen; absent: all of them |
/// | `hidden_axes` | axes that are not shown |
/// | `layout` | where the panes stand |
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[expect(missing_docs, reason = "the table above says what the fields are")]
pub struct Session {
    pub format: String,
    pub version: u32,
    /// The program that wrote it.
    pub program: String,
    pub notes: String,
    pub built_in: bool,
    pub files: Vec<SessionFile>,
    pub cut: Option<f64>,
    pub calibration: Option<PathBuf>,
    pub settings: FitSettings,
    pub on_screen: Option<String>,
    pub hidden_axes: Vec<Axis>,
    pub layout: Option<serde_json::Value>,
}

/// One file of a session.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SessionFile {
    /// Where it is: seen from the session's folder where that is possible.
    pub path: PathBuf,
    /// Where it was, from the root.
    pub absolute: PathBuf,
    /// How long it was.
    pub bytes: Option<u64>,
    /// What it held (SHA-256, hexadecimal).
    pub sha256: Option<String>,
    /// The map that it was read by.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<ColumnMap>,
    /// How its recordings were tared after reading, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub tares: BTreeMap<String, Tare>,
    /// What its recordings are for, by name; those that are not named take the role that their name asks for.
    pub roles: BTreeMap<String, Role>,
}

/// Why a file is no session.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SessionError {
    #[error("not a session: {0}")]
    Json(#[from] serde_json::Error),
    #[error(
        "a session of version {found}, where this program knows up to {VERSION}; open it with a newer one"
    )]
    Version { found: u32 },
}

impl Session {
    /// Whether a file's text is that of a session, as far as its start tells.
    #[must_use]
    pub fn is_one(text: &[u8]) -> bool {
        #[derive(Deserialize)]
        struct Start {
            #[serde(default)]
            format: serde_json::Value,
        }
        serde_json::from_slice::<Start>(text).is_ok_and(|start| start.format == FORMAT)
    }

    /// Understands a session's text.
    ///
    /// # Errors
    /// [`SessionError`] if it is no session, or of a version that is not known yet.
    pub fn from_json(text: &[u8]) -> Result<Self, SessionError> {
        let session: Self = serde_json::from_slice(text)?;
        if session.version > VERSION {
            return Err(SessionError::Version {
                found: session.version,
            });
        }
        Ok(session)
    }

    /// The session as JSON for a file in `folder`: paths below it are written as seen from there.
    #[must_use]
    pub fn to_json(&self, folder: &Path) -> Vec<u8> {
        let mut session = self.clone();
        for file in &mut session.files {
            file.path = match file.absolute.strip_prefix(folder) {
                Ok(inside) => inside.to_owned(),
                Err(_) => file.absolute.clone(),
            };
        }
        let mut text = serde_json::to_vec_pretty(&session).unwrap_or_default();
        text.push(b'\n');
        text
    }
}

/// A file of a session with what became of it.
#[derive(Clone, Debug)]
pub struct SessionPart {
    /// As the session has it; [`SessionFile::absolute`] is where it was found.
    pub file: SessionFile,
    /// What it held; `None` where it is not there.
    pub loaded: Option<Result<Loaded, String>>,
    /// Whether it is another file than it was.
    pub changed: bool,
}

/// A session that was read, with its files.
#[derive(Clone, Debug)]
pub struct OpenedSession {
    /// The session.
    pub session: Session,
    /// Its files.
    pub parts: Vec<SessionPart>,
    /// The calibration that it applies.
    pub calibration: Option<Result<Arc<Calibration>, String>>,
}

/// What concerns sessions.
#[derive(Clone, Debug)]
pub enum SessionCommand {
    /// Save it where it was saved before, or ask where.
    Save,
    /// Ask where to save it.
    SaveAs,
    /// The window's layout for the file, which only the window knows, comes with it.
    SaveTo(Option<PathBuf>, Option<serde_json::Value>),
    /// It was saved here, with these choices.
    Saved(PathBuf, Box<Mark>),
    /// Take up this autosaved session of a window that did not close as it should.
    Restore(PathBuf),
    /// It was read.
    Recovered(PathBuf, Result<Box<OpenedSession>, String>),
    /// It is not wanted.
    DropLeft(PathBuf),
    /// What other windows left is not to be asked about now; it stays where it is.
    KeepLeft,
    /// Its notes are these.
    SetNotes(String),
    /// A file that is not where it was is here.
    Found(usize, PathBuf),
    /// Go on without it.
    Forget(usize),
    /// The window is to be closed.
    Close,
    /// What is not saved is to stay on screen.
    Cancel,
    /// Do what waits for an answer, whatever is not saved.
    Discard,
}

/// What takes everything away that is loaded, so that somebody is asked first whether to save it.
#[derive(Clone, Debug)]
pub enum Leaving {
    /// Closing the window.
    Close,
    /// Opening files, a session among them.
    Open(Vec<OpenedFile>),
    /// Restoring the session that was left at this path.
    Restore(PathBuf, Box<OpenedSession>),
}

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

/// What a saved session held, to know whether something has changed since.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    choices: Choices,
    notes: String,
}

impl AppState {
    pub(super) fn mark(&self) -> Mark {
        Mark {
            choices: self.choices(),
            notes: self.notes.clone(),
        }
    }

    /// Whether something would be lost with the window.
    #[must_use]
    pub fn is_unsaved(&self) -> bool {
        match &self.saved {
            Some(saved) => *saved != self.mark(),
            None => !self.recordings.entries().is_empty() && !self.recordings.is_simulated(),
        }
    }

    /// The window's title: the session's name, and a star while it is not saved.
    #[must_use]
    pub fn title(&self) -> String {
        let name = self.session.as_ref().and_then(|path| path.file_stem());
        let star = if self.is_unsaved() { " *" } else { "" };
        match name {
            Some(name) => format!("{}{star} – LoopScope", name.to_string_lossy()),
            None => format!("LoopScope{star}"),
        }
    }

    /// What there is to save.
    #[must_use]
    pub fn as_session(&self, layout: Option<serde_json::Value>) -> Session {
        let whole = self.unsplit.as_ref().unwrap_or(&self.recordings);
        let mut files: Vec<SessionFile> = Vec::new();
        for entry in whole.entries() {
            let Source::File(path) = entry.recording.source() else {
                continue;
            };
            let absolute = std::path::absolute(path).unwrap_or_else(|_| path.clone());
            let at = files.iter().position(|file| file.absolute == absolute);
            let at = at.unwrap_or_else(|| {
                files.push(SessionFile {
                    path: absolute.clone(),
                    columns: self.maps.get(path).cloned(),
                    absolute,
                    ..SessionFile::default()
                });
                files.len() - 1
            });
            let name = entry.recording.name().to_owned();
            let by_map = files[at].columns.as_ref().and_then(|map| map.tare);
            if let Some(tare) = entry.recording.tare().filter(|tare| Some(*tare) != by_map) {
                files[at].tares.insert(name.clone(), tare);
            }
            files[at].roles.insert(name, entry.role);
        }
        let on_screen = match self.view {
            View::One(at) => self.recordings.entries().get(at),
            View::All => None,
        };
        Session {
            format: FORMAT.to_owned(),
            version: VERSION,
            program: env!("CARGO_PKG_VERSION").to_owned(),
            notes: self.notes.clone(),
            built_in: self.recordings.is_simulated(),
            files,
            cut: self.unsplit.is_some().then_some(self.cut),
            calibration: self.applied.as_ref().map(|applied| applied.path.clone()),
            settings: self.settings.clone(),
            on_screen: on_screen.map(|entry| entry.recording.name().to_owned()),
            hidden_axes: self.hidden_axes.clone(),
            layout,
        }
    }

    pub(super) fn apply_session(&mut self, command: SessionCommand) -> Vec<Effect> {
        match command {
            SessionCommand::Save => vec![Effect::Wish(Wish::SaveSession(self.session.clone()))],
            SessionCommand::SaveAs => vec![Effect::Wish(Wish::SaveSession(None))],
            SessionCommand::SaveTo(path, layout) => {
                let content =
                    FileContent::Session(Box::new(self.as_session(layout)), Box::new(self.mark()));
                match path {
                    Some(path) => vec![Effect::Write(content, path, Existing::Replace)],
                    None => vec![Effect::AskWhere(content, "session.json".to_owned())],
                }
            }
            SessionCommand::Saved(path, mark) => {
                self.preferences.remember(&path);
                let text = format!("Saved the session {}", path.display());
                self.tell(Notice::new(Level::Info, text));
                self.session = Some(path);
                self.saved = Some(*mark);
                match self.is_unsaved() {
                    true => Vec::new(),
                    false => self.leave(),
                }
            }
            SessionCommand::Restore(path) => vec![Effect::Restore(path)],
            SessionCommand::Recovered(path, Ok(opened)) => {
                self.leave_for(Leaving::Restore(path, opened))
            }
            SessionCommand::Recovered(_, Err(error)) => {
                self.tell(Notice::new(Level::Error, error));
                Vec::new()
            }
            SessionCommand::SetNotes(notes) => {
                self.notes = notes;
                Vec::new()
            }
            SessionCommand::Found(at, path) if at < self.lost.len() => {
                let SessionFile { columns, roles, .. } = self.lost.remove(at);
                if let Some(columns) = columns {
                    self.maps.insert(path.clone(), columns);
                }
                self.awaited_roles.insert(path.clone(), roles);
                vec![self.read(vec![path])]
            }
            SessionCommand::Forget(at) if at < self.lost.len() => {
                self.lost.remove(at);
                Vec::new()
            }
            SessionCommand::DropLeft(path) => {
                self.recoverable.retain(|left| left.path != path);
                vec![Effect::DropLeft(path)]
            }
            SessionCommand::KeepLeft => {
                self.recoverable.clear();
                Vec::new()
            }
            SessionCommand::Found(..) | SessionCommand::Forget(_) => Vec::new(),
            SessionCommand::Close => self.leave_for(Leaving::Close),
            SessionCommand::Cancel => {
                self.leaving = None;
                Vec::new()
            }
            SessionCommand::Discard => self.leave(),
        }
    }

    /// Does what takes everything away that is loaded, or asks first where something is not saved.
    pub(super) fn leave_for(&mut self, leaving: Leaving) -> Vec<Effect> {
        self.leaving = Some(leaving);
        match self.is_unsaved() {
            true => Vec::new(),
            false => self.leave(),
        }
    }

    /// Does what waited for an answer.
    fn leave(&mut self) -> Vec<Effect> {
        match self.leaving.take() {
            None => Vec::new(),
            Some(Leaving::Close) => vec![Effect::Wish(Wish::CloseNow)],
            Some(Leaving::Open(files)) => self.take_files(files),
            Some(Leaving::Restore(path, opened)) => {
                let restored = self.take_session(None, *opened);
                let dropped = self.apply_session(SessionCommand::DropLeft(path));
                restored.into_iter().chain(dropped).collect()
            }
        }
    }

    /// Puts a session in place of everything that is loaded; one without a path was recovered.
    pub(super) fn take_session(
        &mut self,
        path: Option<PathBuf>,
        opened: OpenedSession,
    ) -> Vec<Effect> {
        let OpenedSession {
            session,
            parts,
            calibration,
        } = opened;
        self.close_recordings();
        self.lost.clear();
        self.settings = session.settings;
        self.hidden_axes = session.hidden_axes;
        self.notes = session.notes;
        let mut loaded = Vec::new();
        for part in parts {
            let file = part.file;
            let found = file.absolute.clone();
            if part.changed {
                let text = format!(
                    "{}: not the file that the session was saved with",
                    found.display()
                );
                self.tell(Notice::new(Level::Warning, text));
            }
            match part.loaded {
                Some(Ok(recordings)) => {
                    if let Some(map) = file.columns {
                        self.maps.insert(found.clone(), map);
                    }
                    self.awaited_roles.insert(found, file.roles);
                    loaded.push(recordings);
                }
                Some(Err(error)) => self.tell(Notice::new(Level::Error, error)),
                None => self.lost.push(file),
            }
        }
        let mut effects = Vec::new();
        // What is loaded must not choose the settings anew.
        let settings = self.settings.clone();
        self.take_recordings(loaded);
        self.settings = settings;
        if let Some(cut) = session.cut {
            self.split(cut);
        }
        let entries = self.recordings.entries();
        let shown = |name: &String| {
            entries
                .iter()
                .position(|entry| entry.recording.name() == *name)
        };
        self.view = session
            .on_screen
            .as_ref()
            .map_or(View::All, |name| View::One(shown(name).unwrap_or(0)));
        match (session.calibration, calibration) {
            (Some(path), Some(Ok(calibration))) => {
                self.applied = Some(Applied { path, calibration });
            }
            (_, Some(Err(error))) => self.tell(Notice::new(Level::Error, error)),
            _ => {}
        }
        effects.extend(
            session
                .layout
                .map(|layout| Effect::Wish(Wish::Layout(layout))),
        );
        if session.built_in {
            self.overtook_built_in = false;
            effects.push(Effect::Simulate);
        }
        // What was recovered is not saved anywhere.
        self.saved = path.is_some().then(|| self.mark());
        self.session = path;
        // Its file must not be saved over with what was loaded before.
        self.history = History::default();
        effects.extend(self.analyse());
        effects
    }

    /// Gives recordings of a session the roles that they had there.
    pub(super) fn give_awaited_roles(&mut self, set: &mut RecordingSet) {
        for at in 0..set.entries().len() {
            let recording = &set.entries()[at].recording;
            let Source::File(path) = recording.source() else {
                continue;
            };
            let roles = self.awaited_roles.get(path);
            if let Some(role) = roles.and_then(|roles| roles.get(recording.name())).copied() {
                set.set_role(at, role);
            }
        }
        self.awaited_roles.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{Command, Opened};
    use crate::recording::Recording;

    fn recording(path: &str, name: &str) -> Recording {
        let values: Vec<f64> = (0..40).map(|k| f64::from(k * k % 17)).collect();
        let times = (0..40).map(f64::from).collect();
        let gauges = vec!["S1".to_owned()];
        let source = Source::File(path.into());
        let loads = values.iter().map(|value| 2.0 * value).collect();
        Recording::new(name, source, times, gauges, values, vec![Axis::Fz], loads).unwrap()
    }

    fn loaded(path: &str, names: &[&str]) -> Loaded {
        Loaded {
            recordings: names.iter().map(|name| recording(path, name)).collect(),
            warnings: Vec::new(),
            map: None,
        }
    }

    fn open(state: &mut AppState, path: &str, names: &[&str]) {
        let opened = Opened::Recordings(loaded(path, names), None);
        state.apply(Command::FilesOpened(vec![(path.into(), Ok(opened))]));
    }

    /// The session as it comes back from its file, every recording found.
    fn reopened(text: &[u8]) -> AppState {
        let session = Session::from_json(text).unwrap();
        let parts = session.files.iter().map(|file| {
            let names: Vec<&str> = file.roles.keys().map(String::as_str).collect();
            let path = file.absolute.to_str().unwrap();
            SessionPart {
                loaded: Some(Ok(loaded(path, &names))),
                file: file.clone(),
                changed: false,
            }
        });
        let opened = OpenedSession {
            parts: parts.collect(),
            calibration: None,
            session,
        };
        let mut state = AppState::default();
        let opened = Opened::Session(Box::new(opened));
        state.apply(Command::FilesOpened(vec![("s.json".into(), Ok(opened))]));
        state
    }

    #[test]
    fn roles_settings_cut_view_and_notes_come_back() {
        let mut state = AppState::default();
        open(&mut state, "/data/a.csv", &["a.1", "a.2"]);
        open(&mut state, "/data/b.csv", &["b"]);
        state.apply(Command::SetRole(1, Role::Off));
        let mut settings = state.settings.clone();
        settings.features.look_backs[0].f_th = 0.125;
        settings.full_scale = vec![Some(7.0)];
        state.apply(Command::SetSettings(settings));
        state.apply(Command::Split(0.25));
        state.apply(Command::SetView(View::One(3)));
        state.apply(Command::Session(SessionCommand::SetNotes(
            "oiled".to_owned(),
        )));
        let text = state.as_session(None).to_json(Path::new("/data"));
        assert!(String::from_utf8_lossy(&text).contains(r#""path": "a.csv""#));
        let back = reopened(&text);
        assert_eq!(back.as_session(None), state.as_session(None));
        assert_eq!(back.recordings, state.recordings);
        assert_eq!((back.view, &*back.notes), (View::One(3), "oiled"));
    }

    #[test]
    fn a_star_stands_in_the_title_while_something_is_not_saved() {
        let mut state = AppState::default();
        assert!(!state.is_unsaved());
        open(&mut state, "/data/a.csv", &["a"]);
        assert_eq!(state.title(), "LoopScope *");
        let mark = Box::new(state.mark());
        state.apply(Command::Session(SessionCommand::Saved(
            "/data/s.json".into(),
            mark,
        )));
        assert_eq!(state.title(), "s – LoopScope");
        assert!(matches!(
            state.apply(Command::Session(SessionCommand::Close))[..],
            [Effect::Wish(Wish::CloseNow)]
        ));
        state.apply(Command::SetRole(0, Role::Test));
        assert_eq!(state.title(), "s * – LoopScope");
        assert!(
            state
                .apply(Command::Session(SessionCommand::Close))
                .is_empty()
        );
        assert!(
            matches!(state.leaving, Some(Leaving::Close)),
            "somebody is asked first"
        );
    }

    fn session_file(name: &str) -> Command {
        let opened = OpenedSession {
            session: Session {
                notes: name.to_owned(),
                ..Session::default()
            },
            parts: Vec::new(),
            calibration: None,
        };
        let opened = Opened::Session(Box::new(opened));
        Command::FilesOpened(vec![(name.into(), Ok(opened))])
    }

    #[test]
    fn a_session_opened_over_what_is_not_saved_waits_for_an_answer() {
        let mut state = AppState::default();
        open(&mut state, "/data/a.csv", &["a"]);
        let before = state.choices();
        for answer in [SessionCommand::Cancel, SessionCommand::Discard] {
            assert!(state.apply(session_file("s.json")).is_empty());
            assert!(matches!(state.leaving, Some(Leaving::Open(_))));
            assert!(state.choices() == before && state.session.is_none());
            state.apply(Command::Session(answer));
            assert!(state.leaving.is_none());
        }
        assert_eq!(state.session.as_deref(), Some(Path::new("s.json")));
        assert!(state.recordings.entries().is_empty());
        state.apply(session_file("t.json"));
        assert_eq!(state.notes, "t.json", "nothing would be lost");

        open(&mut state, "/data/a.csv", &["a"]);
        state.apply(session_file("u.json"));
        let mark = Box::new(state.mark());
        let saved = SessionCommand::Saved("t.json".into(), mark);
        state.apply(Command::Session(saved));
        assert_eq!(state.notes, "u.json", "once it is saved");
        assert!(!state.history.can_undo(), "the session begins anew");
    }

    #[test]
    fn a_session_of_the_built_in_sensor_is_saved_when_it_is_there() {
        let mut state = AppState::default();
        let session = Session {
            built_in: true,
            ..Session::default()
        };
        let opened = OpenedSession {
            session,
            parts: Vec::new(),
            calibration: None,
        };
        state.take_session(Some("s.json".into()), opened);
        let mut set = RecordingSet::default();
        let of_file = recording("a", "a");
        let simulated = Recording::new(
            "a",
            Source::Simulated,
            of_file.times().to_vec(),
            of_file.gauge_names().to_vec(),
            of_file.gauges().to_vec(),
            of_file.axes().to_vec(),
            of_file.loads().to_vec(),
        );
        set.push(crate::recording::Entry::new(
            simulated.unwrap(),
            Role::Train,
        ))
        .unwrap();
        state.apply(Command::BuiltInReady(set));
        assert!(!state.recordings.entries().is_empty() && !state.is_unsaved());
    }

    #[test]
    fn what_windows_left_stays_until_it_is_restored_or_dropped() {
        let mut state = AppState::default();
        open(&mut state, "/data/a.csv", &["a"]);
        let left = |name: &str| LeftSession {
            path: name.into(),
            written: SystemTime::UNIX_EPOCH,
            files: Vec::new(),
        };
        state.recoverable = vec![left("1"), left("2"), left("3")];
        let say = |state: &mut AppState, command| state.apply(Command::Session(command));
        let effects = say(&mut state, SessionCommand::DropLeft("2".into()));
        assert!(matches!(&effects[..], [Effect::DropLeft(path)] if path == Path::new("2")));
        let effects = say(&mut state, SessionCommand::Restore("3".into()));
        assert!(matches!(&effects[..], [Effect::Restore(_)]));
        let failed = SessionCommand::Recovered("3".into(), Err("torn".to_owned()));
        say(&mut state, failed);
        assert_eq!(state.recoverable, [left("1"), left("3")]);
        let opened = OpenedSession {
            session: Session::default(),
            parts: Vec::new(),
            calibration: None,
        };
        let read = SessionCommand::Recovered("3".into(), Ok(Box::new(opened)));
        assert!(say(&mut state, read).is_empty(), "a.csv is not saved");
        assert_eq!(state.recoverable.len(), 2);
        let effects = say(&mut state, SessionCommand::Discard);
        assert!(matches!(effects.last(), Some(Effect::DropLeft(path)) if path == Path::new("3")));
        assert_eq!(state.recoverable, [left("1")]);
    }

    #[test]
    fn a_file_that_moved_is_asked_for_and_takes_its_role_where_it_is_found() {
        let mut state = AppState::default();
        let file = SessionFile {
            absolute: "/gone/a.csv".into(),
            roles: BTreeMap::from([("a".to_owned(), Role::Test)]),
            ..SessionFile::default()
        };
        let part = SessionPart {
            file,
            loaded: None,
            changed: false,
        };
        let opened = OpenedSession {
            session: Session::default(),
            parts: vec![part],
            calibration: None,
        };
        state.take_session(Some("s.json".into()), opened);
        assert_eq!(state.lost.len(), 1);
        let found = SessionCommand::Found(0, "/here/a.csv".into());
        let effects = state.apply(Command::Session(found));
        assert!(matches!(&effects[..], [Effect::Read(files, _)] if files.len() == 1));
        open(&mut state, "/here/a.csv", &["a"]);
        assert_eq!(state.recordings.entries()[0].role, Role::Test);
        assert!(state.lost.is_empty());
    }

    #[test]
    fn older_sessions_load_and_newer_ones_say_so() {
        let old = br#"{"format": "loopscope session", "version": 1, "files": [{"path": "a.csv"}]}"#;
        assert!(Session::is_one(old));
        let session = Session::from_json(old).unwrap();
        assert_eq!(session.settings, FitSettings::default());
        assert_eq!(session.files[0].path, Path::new("a.csv"));
        let newer = br#"{"format": "loopscope session", "version": 2}"#;
        let error = Session::from_json(newer).unwrap_err();
        assert!(error.to_string().contains("version 2"), "{error}");
        assert!(Session::from_json(b"[1").is_err());
        assert!(!Session::is_one(br#"{"format": "loopscope calibration"}"#));
    }
}
