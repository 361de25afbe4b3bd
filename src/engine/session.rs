//! The session file: the document as it is, with names and roles of the open recordings in place of samples. It contains no
//! results.
//!
//! Guarantees: a session that is written and read again is unchanged. Entries that a session file lacks get their defaults.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::{
    calibration::{Calibration, UsedRecording},
    engine::{
        lost::{self, is_another},
        notice::{Level, Notice},
        project::{Edit, FromFile, Project, SessionFile, Split, absolute},
    },
    export::{Together, WriteError, add_calibration, read_calibration, sha256, with_sources},
    finding::{Advice, Face},
    import::{self, Loaded},
    progress::Progress,
    questions::View,
    recording::{Recording, RecordingSet, Source, Tare, ValidRange, simulated::Late},
    scoring::faults::faults_of,
    small_file::read_small,
};

const FORMAT: &str = "loopscope session";
const VERSION: u32 = 1;
/// File name ending of the trained calibration that is saved beside a session.
const TRAINED: &str = "trained.json";
const BYTES_LIMIT: u64 = 64 << 20;

/// Content of a session file: the document, and in place of its recordings and calibrations the names of their files.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Session {
    pub format: String,
    pub version: u32,
    pub program: String,
    /// All fields of the document that are saved as they are.
    #[serde(flatten)]
    pub project: Project,
    /// True if the recordings of the built-in simulated sensor are open; `files` is then empty.
    pub built_in: bool,
    /// Set of the built-in sensor that shows a time lag, hysteresis, or both.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub built_in_lag: Option<Late>,
    /// Files of the recordings, in the order of opening.
    pub files: Vec<SessionFile>,
    /// Share of each recording, from its start, that is used for training, if recordings are split in time.
    pub cut: Option<f64>,
    /// File of a calibration that is applied instead of a fit.
    pub calibration: Option<PathBuf>,
    /// Name of the shown recording; `None` for all.
    pub on_screen: Option<String>,
    /// File of the trained calibration beside the session, if the settings have a network or kernel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trained: Option<PathBuf>,
}

/// Sessions are equal if their files are.
impl PartialEq for Session {
    fn eq(&self, other: &Self) -> bool {
        self.to_json(Path::new("")) == other.to_json(Path::new(""))
    }
}

impl Session {
    /// Returns true if a text is a session file, even if its end is cut off.
    pub fn is_one(text: &[u8]) -> bool {
        #[derive(Deserialize)]
        struct Start {
            #[serde(default)]
            format: serde_json::Value,
        }
        let start = text.iter().copied().filter(|byte| !byte.is_ascii_whitespace());
        let start: Vec<u8> = start.take(64).collect();
        let begins_as_one = format!("{{\"format\":\"{FORMAT}\"").replace(' ', "");
        start.starts_with(begins_as_one.as_bytes())
            || serde_json::from_slice::<Start>(text).is_ok_and(|start| start.format == FORMAT)
    }

    /// Reads a session from the text of its file.
    ///
    /// # Errors
    /// The reason in words, if the text is not a session or has a newer version.
    pub fn from_json(text: &[u8]) -> Result<Self, String> {
        let session: Self = serde_json::from_slice(text).map_err(|error| {
            if error.is_eof() && Self::is_one(text) {
                let line = error.line();
                format!(
                    "the session is cut off in line {line}; open a copy, or save the session again"
                )
            } else {
                format!("not a session: {error}")
            }
        })?;
        if session.version > VERSION {
            return Err(format!(
                "the session has version {}, but this program reads versions up to {VERSION}; open it with a newer program",
                session.version
            ));
        }
        Ok(session)
    }

    /// Returns the session as JSON for a session file in `folder`. Recordings in this folder are named by relative paths.
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

#[derive(Clone, Debug)]
pub struct SessionPart {
    /// Entry of a recording file in the session, in which [`SessionFile::absolute`] is the path at which the file was found.
    pub file: SessionFile,
    /// Recordings of the file, or the reason why it cannot be read; `None` if the file was not found.
    pub loaded: Option<Result<Loaded, String>>,
    /// True if the recording file has changed since the session was saved.
    pub changed: bool,
}

#[derive(Clone, Debug)]
pub struct OpenedSession {
    pub session: Session,
    pub parts: Vec<SessionPart>,
    /// Calibration from a file that the session applies to its recordings, or the reason why it cannot be read.
    pub calibration: Option<Result<FromFile, String>>,
    /// Trained calibration in the file beside the session, or the reason why it cannot be read.
    pub trained: Option<Result<Arc<Calibration>, String>>,
}

impl Session {
    pub fn of(project: &Project) -> Self {
        let whole = project.split.as_ref().map(|split| &split.whole);
        let whole = whole.unwrap_or(&project.recordings);
        let mut files: Vec<SessionFile> = Vec::new();
        for entry in whole.entries() {
            let Source::File(path) = entry.recording.source() else {
                continue;
            };
            let absolute = self::absolute(path);
            let at = files.iter().position(|file| file.absolute == absolute);
            let at = at.unwrap_or_else(|| {
                files.push(SessionFile {
                    path: absolute.clone(),
                    columns: project.maps.get(path).cloned(),
                    absolute,
                    ..SessionFile::default()
                });
                files.len() - 1
            });
            let (file, recording) = (&mut files[at], &entry.recording);
            let name = recording.name().to_owned();
            let left_out = recording.left_out();
            file.left_out
                .extend(left_out.map(|removed| (removed.of.clone(), removed.judged.clone())));
            let by_map = file.columns.as_ref().and_then(|map| map.tare);
            let tare = recording.tare().filter(|tare| Some(*tare) != by_map);
            file.tares.extend(tare.map(|tare| (name.clone(), tare)));
            let by_map = project.group_by_map(recording);
            let by_map = by_map.or_else(|| recording.group().map(str::to_owned));
            let group = entry.group.clone().filter(|_| entry.group != by_map);
            file.groups.extend(group.map(|group| (name.clone(), group)));
            // A recording that lacks gauges or a load is off. If it gets them, it has its default role.
            if recording.missing().is_none() {
                file.roles.insert(name, entry.role);
            }
        }
        // Missing files stay in the saved session, so that they can still be found later.
        files.extend(project.lost.iter().cloned());
        let on_screen = match project.view {
            View::One(at) => project.recordings.entries().get(at),
            View::All => None,
        };
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            program: env!("CARGO_PKG_VERSION").to_owned(),
            project: project.clone(),
            built_in: project.recordings.is_simulated(),
            built_in_lag: Late::of(&project.recordings),
            files,
            cut: project.split.as_ref().map(|split| split.fraction),
            calibration: project.applied.as_ref().map(|applied| applied.path.clone()),
            on_screen: on_screen.map(|entry| entry.recording.name().to_owned()),
            trained: None,
        }
    }

    /// Returns the session with the present sizes and hashes of its recording files. Files that cannot be read keep their
    /// saved size and hash.
    pub fn with_hashes(&self) -> Self {
        let mut session = self.clone();
        for file in &mut session.files {
            let path: &PathBuf = &file.absolute;
            let bytes = fs::metadata(path).map(|metadata| metadata.len());
            file.bytes = bytes.ok().or(file.bytes);
            file.sha256 = sha256(path).ok().or(file.sha256.take());
        }
        session
    }

    /// Reads a session file, but not the recordings that it names.
    ///
    /// # Errors
    /// The reason in words.
    pub fn read(path: &Path) -> Result<Self, String> {
        Self::from_json(&text_of(path).map_err(|error| error.to_string())?)
    }

    pub fn is_at(path: &Path) -> bool {
        text_of(path).is_ok_and(|text| Self::is_one(&text))
    }
}

/// Returns the path of a file that a session in `folder` names. A missing file is searched in this folder, so that a session
/// can be moved together with its files.
fn found_again(path: &Path, folder: &Path) -> PathBuf {
    let there = folder.join(path);
    if there.is_file() {
        return there;
    }
    let lost = SessionFile { absolute: path.to_owned(), ..SessionFile::default() };
    lost::find(&[lost], folder, &[]).pop().map_or(there, |(_, found)| found)
}

pub fn trained_beside(session: &Path) -> PathBuf {
    session.with_extension(TRAINED)
}

/// Writes a session, and in a file beside it the calibration that was trained on these recordings. If one of the files cannot
/// be written, neither is.
///
/// # Errors
/// [`WriteError`] if a file cannot be written.
pub fn write_session(
    session: &Session,
    trained: Option<&Calibration>,
    path: &Path,
) -> Result<(), WriteError> {
    let mut files = Together::default();
    let beside = trained_beside(path);
    let mut session = session.clone();
    session.trained = trained.and_then(|_| Some(beside.file_name()?.into()));
    if let Some(trained) = trained {
        // A trained calibration that was read with its session keeps its list of recordings, because some of them may be
        // missing now.
        let trained = if trained.sources.is_empty() {
            &with_sources(trained, &session.project.recordings)
        } else {
            trained
        };
        add_calibration(&mut files, trained, &beside)?;
    }
    let text = session.to_json(path.parent().unwrap_or(Path::new("")));
    files.write(path, |out| out.write_all(&text))?;
    files.finish()
}

/// Checks, by names and contents, that a calibration was trained on these recordings with their present training and test
/// roles.
///
/// # Errors
/// The difference in words.
pub fn prove_trained(trained: &Calibration, recordings: &RecordingSet) -> Result<(), String> {
    let layout = recordings.layout();
    if trained.gauges != layout.gauge_names || trained.axes != layout.axes {
        return Err("The trained calibration beside the session is not used: it has other gauges or axes than the recordings. Train again".to_owned());
    }
    let now = with_sources(trained, recordings).sources;
    let then = &trained.sources;
    let is_known = |recording: &&UsedRecording| !then.contains(recording);
    let gone = then.iter().find(|recording| !now.contains(recording));
    match now.iter().find(is_known).or(gone) {
        None => Ok(()),
        Some(other) => Err(format!(
            "The trained calibration beside the session is not used: the recording {} or its role has changed since the training. Train again",
            other.name
        )),
    }
}

fn text_of(path: &Path) -> io::Result<Vec<u8>> {
    read_small(path, "a session", BYTES_LIMIT)
}

impl OpenedSession {
    /// Reads a session and the recording and calibration files that it names.
    ///
    /// # Errors
    /// The reason in words, if the session cannot be read. Missing and unreadable files are noted in [`Self::parts`].
    pub fn read(path: &Path, progress: &Progress) -> Result<Self, String> {
        let session = Session::read(path);
        let session = session.map_err(|error| format!("{}: {error}", path.display()))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        for file in &session.files {
            progress.add_total(file.bytes.unwrap_or(0));
        }
        let parts = session.files.iter();
        let parts = parts.map(|file| SessionPart::read(file, folder, progress));
        let calibration = session.calibration.as_ref().map(|path| {
            let path = found_again(path, folder);
            let read = read_calibration(&path).map(Arc::new);
            read.map(|calibration| FromFile { path, calibration })
                .map_err(|error| format!("{error}; open the calibration to apply it again"))
        });
        let trained = session.trained.as_ref().map(|path| {
            let read = read_calibration(&found_again(path, folder)).map(Arc::new);
            read.map_err(|error| {
                format!("{error}. The network or kernel of the session has to be trained again")
            })
        });
        Ok(Self { parts: parts.collect(), calibration, trained, session })
    }

    pub fn into_project(self) -> (Project, Vec<Notice>) {
        let Session { mut project, cut, on_screen, .. } = self.session;
        let mut notices = add_parts(&mut project, self.parts);
        let mut say = |level, text: String| notices.push(Notice::new(level, text));
        match cut {
            // The split stays even without recordings, so that files that are found later are split in the same way.
            Some(fraction) if project.recordings.entries().is_empty() => {
                let whole = Arc::clone(&project.recordings);
                project.split = Some(Split { whole, fraction });
            }
            Some(fraction) => {
                let cut = project.edit(Edit::Split(fraction));
                cut.unwrap_or_else(|error| say(Level::Error, error.to_string()));
            }
            None => {}
        }
        let mut entries = project.recordings.entries().iter();
        project.view = on_screen.map_or(View::All, |name| {
            let shown = entries.position(|entry| entry.recording.name() == name);
            View::One(shown.unwrap_or(0))
        });
        match self.calibration {
            Some(Ok(applied)) => project.applied = Some(applied),
            Some(Err(error)) => say(Level::Error, error),
            None => {}
        }
        (project, notices)
    }
}

/// Replaces the recordings of a document by those of the same files, which were read again by other column maps. Roles, groups
/// and the split stay. Returns the messages of [`add_parts`].
pub fn read_again(project: &mut Project, parts: Vec<SessionPart>) -> Vec<Notice> {
    let (view, before) = (project.view, project.axes().to_vec());
    let has_default = project.settings.features.look_backs == [project.default_thresholds()];
    let fraction = project.split.take().map(|split| split.fraction);
    project.recordings = Arc::default();
    let notices = add_parts(project, parts);
    if *project.axes() != before {
        project.settings.full_scale.clear();
        project.measuring.reversal_thresholds.clear();
        project.choose_distance();
    }
    if has_default {
        project.settings.features.look_backs = vec![project.default_thresholds()];
    }
    // Recordings that now lack a load cannot be split. They stay whole.
    let split = fraction.map(|fraction| project.edit(Edit::Split(fraction)));
    log::debug!("the split after reading again: {split:?}");
    project.view = view.within(project.recordings.entries().len());
    notices
}

/// Adds the recordings of a session's files to a document, with their saved roles and groups. Returns messages about
/// missing, changed and unreadable files. The settings stay unchanged.
pub fn add_parts(project: &mut Project, parts: Vec<SessionPart>) -> Vec<Notice> {
    let mut notices = Vec::new();
    let mut say = |level, text: String| notices.push(Notice::new(level, text));
    let (mut read, mut known) = (Vec::new(), BTreeMap::<PathBuf, SessionFile>::new());
    for SessionPart { file, loaded, changed } in parts {
        let found = file.absolute.clone();
        if changed {
            let text = "the file has changed since the session was saved";
            say(Level::Warning, format!("{}: {text}", found.display()));
        }
        match loaded {
            Some(Ok(loaded)) => {
                for warning in loaded.warnings {
                    say(Level::Warning, warning.text(Face::Window));
                }
                read.push(loaded.recordings);
                let map = file.columns.clone().map(|map| (found.clone(), map));
                project.maps.extend(map);
                known.insert(found, file);
            }
            Some(Err(error)) => say(Level::Error, error),
            None => project.lost.push(file),
        }
    }
    if read.is_empty() {
        return notices;
    }
    let fraction = project.split.as_ref().map(|split| split.fraction);
    // The split is undone here and repeated below, so that the added recordings are split too.
    let mut failed = project.edit(Edit::Unsplit).err();
    let (settings, measuring) = (project.settings.clone(), project.measuring.clone());
    for refused in project.add(read) {
        say(Level::Error, refused);
    }
    let set = Arc::make_mut(&mut project.recordings);
    for at in 0..set.entries().len() {
        let recording = Arc::clone(&set.entries()[at].recording);
        let (Source::File(path), name) = (recording.source(), recording.name()) else { continue };
        let Some(file) = known.get(path) else { continue };
        if let Some(role) = file.roles.get(name) {
            set.set_role(at, *role);
        }
        if let Some(group) = file.groups.get(name) {
            set.set_group(at, Some(group.clone()));
        }
    }
    (project.settings, project.measuring) = (settings, measuring);
    if let Some(fraction) = fraction {
        failed = failed.or(project.edit(Edit::Split(fraction)).err());
    }
    if let Some(error) = failed {
        say(Level::Error, error.to_string());
    }
    notices
}

impl SessionPart {
    /// Reads one recording file from its path relative to the session, or from its absolute path if the relative one does not
    /// exist.
    fn read(file: &SessionFile, folder: &Path, progress: &Progress) -> Self {
        let candidates = [folder.join(&file.path), file.absolute.clone()];
        match candidates.into_iter().find(|path| path.is_file()) {
            Some(found) => Self::at(file, found, progress),
            None => Self { file: file.clone(), loaded: None, changed: false },
        }
    }

    pub fn at(file: &SessionFile, found: PathBuf, progress: &Progress) -> Self {
        let loaded = import::read(&found, file.columns.as_ref(), &[], progress);
        let loaded = loaded.map_err(|error| error.text(Face::Window));
        Self {
            changed: is_another(file, &found),
            file: SessionFile { absolute: found, ..file.clone() },
            loaded: Some(loaded.and_then(|loaded| as_saved(loaded, file))),
        }
    }

    /// Returns the part of a file that was read again, or whose recordings are still in memory (`None`).
    pub fn again(file: SessionFile, read: Option<Loaded>, open: &RecordingSet) -> Self {
        let loaded = match read {
            Some(loaded) => as_saved(Loaded { warnings: Vec::new(), ..loaded }, &file),
            None => {
                let entries = open.entries().iter().map(|entry| &entry.recording);
                let is_of_file = |of: &&Arc<Recording>| is_of(of, &file.absolute);
                let recordings = entries.filter(is_of_file).map(|of| Recording::clone(of));
                Ok(Loaded { recordings: recordings.collect(), ..Loaded::default() })
            }
        };
        // The recordings may name their file by a relative path.
        let first = loaded.as_ref().ok().and_then(|loaded| loaded.recordings.first());
        let path = first.and_then(|first| first.source().path()).map(Path::to_owned);
        let absolute = path.unwrap_or_else(|| file.absolute.clone());
        Self { file: SessionFile { absolute, ..file }, loaded: Some(loaded), changed: false }
    }
}

/// Returns true if a recording was read from the file with this absolute path.
fn is_of(recording: &Recording, absolute: &Path) -> bool {
    recording.source().path().is_some_and(|path| self::absolute(path) == *absolute)
}

/// Tares the recordings and removes faulty samples as the saved session states.
fn as_saved(mut loaded: Loaded, file: &SessionFile) -> Result<Loaded, String> {
    let tared = |recording: Recording, tare: Option<Tare>| match tare {
        Some(tare) if recording.tare() != Some(tare) => {
            let tared = recording.tared(tare);
            tared.map(|(tared, _)| tared).map_err(|error| error.to_string())
        }
        _ => Ok(recording),
    };
    let judged = |recording: &Recording| file.left_out.get(recording.name());
    let as_judged = loaded.recordings.into_iter().map(|recording| {
        let tare = judged(&recording).and_then(|judged| judged.tared);
        tared(recording, tare)
    });
    let as_judged = as_judged.collect::<Result<Vec<_>, _>>()?;
    let all: Vec<&Recording> = as_judged.iter().collect();
    let mut recordings = Vec::new();
    // All recordings are searched for faulty samples once for each set of limits. Most recordings have the same limits.
    let ranges = file.left_out.values().map(|judged| &judged.range);
    let mut ranges: Vec<&ValidRange> = ranges.collect();
    ranges.dedup();
    let found: Vec<_> = ranges.iter().map(|range| faults_of(&all, range)).collect();
    for (at, recording) in as_judged.iter().enumerate() {
        let range = judged(recording).map(|judged| &judged.range);
        match ranges.iter().zip(&found).find(|(known, _)| Some(**known) == range) {
            Some((range, found)) => recordings.extend(found[at].left_out_of(recording, range)),
            None => recordings.push(recording.clone()),
        }
    }
    let recordings = recordings.into_iter().map(|recording| {
        let tare = file.tares.get(recording.name()).copied();
        tared(recording, tare)
    });
    loaded.recordings = recordings.collect::<Result<_, _>>()?;
    Ok(loaded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::FitSettings;
    use crate::engine::tests::{add, of_file};
    use crate::questions::metrology::MetrologySettings;
    use crate::recording::{Axis, Role};

    fn recordings(path: &str, names: &[&str]) -> Vec<Recording> {
        let named = |name: &&str| {
            let own = of_file(path, &["S1"], &[Axis::Fz]);
            let (gauges, axes) = (own.gauge_names().to_vec(), own.axes().to_vec());
            let source = own.source().clone();
            let (times, values, loads) = (own.times(), own.gauges(), own.loads());
            let (times, values, loads) = (times.to_vec(), values.to_vec(), loads.to_vec());
            Recording::new(*name, source, times, gauges, values, axes, loads).unwrap()
        };
        names.iter().map(named).collect()
    }

    fn reopened(text: &[u8]) -> Project {
        let session = Session::from_json(text).unwrap();
        let parts = session.files.iter().map(|file| {
            let names: Vec<&str> = file.roles.keys().map(String::as_str).collect();
            let loaded = Loaded {
                recordings: recordings(file.absolute.to_str().unwrap(), &names),
                ..Loaded::default()
            };
            SessionPart { loaded: Some(Ok(loaded)), file: file.clone(), changed: false }
        });
        let opened =
            OpenedSession { parts: parts.collect(), calibration: None, trained: None, session };
        let (project, notices) = opened.into_project();
        assert!(notices.is_empty(), "{notices:?}");
        project
    }

    #[test]
    fn a_calibration_is_found_again_that_moved_with_the_session() {
        let folder = tempfile::tempdir().unwrap();
        let now = folder.path();
        let old = Path::new("/elsewhere/sensors/17/calibration.json");
        assert_eq!(found_again(old, now), old, "the path of a missing file is unchanged");
        std::fs::write(now.join("calibration.json"), "").unwrap();
        assert_eq!(found_again(old, now), now.join("calibration.json"));
        std::fs::create_dir(now.join("17")).unwrap();
        let inside = now.join("17/calibration.json");
        std::fs::write(&inside, "").unwrap();
        assert_eq!(found_again(old, now), inside, "the longest equal end of the path is found");
        let there = now.join("other.json");
        std::fs::write(&there, "").unwrap();
        assert_eq!(found_again(&there, &now.join("17")), there);
    }

    #[test]
    fn a_session_that_is_cut_off_is_named_as_one() {
        let whole = Session::of(&Project::default()).to_json(Path::new(""));
        let half = &whole[..whole.len() / 2];
        assert!(Session::is_one(&whole) && Session::is_one(half));
        let error = Session::from_json(half).unwrap_err();
        assert!(error.starts_with("the session is cut off in line"), "{error}");
        assert!(!Session::is_one(b"{\"format\": \"loopscope calibration\", "));
    }

    #[test]
    fn roles_settings_split_view_and_notes_are_restored() {
        let mut project = Project::default();
        for (path, names) in [("/data/a.csv", &["a.1", "a.2"][..]), ("/data/b.csv", &["b"])] {
            let refused = project.add(vec![recordings(path, names)]);
            assert!(refused.is_empty());
        }
        let mut settings = project.settings.clone();
        settings.features.look_backs[0].f_th = 0.125;
        settings.full_scale = vec![Some(7.0)];
        let measuring = MetrologySettings {
            reversal_thresholds: vec![Some(0.25)],
            hold_secs: 2.0,
            ..MetrologySettings::default()
        };
        for edit in [
            Edit::Roles(vec![1], Role::Off),
            Edit::Groups(vec![None, Some("mounted anew".to_owned())]),
            Edit::Settings(settings),
            Edit::Measuring(measuring),
            Edit::Split(0.25),
            Edit::Notes("oiled".to_owned()),
        ] {
            project.edit(edit).unwrap();
        }
        project.view = View::One(3);
        let text = Session::of(&project).to_json(Path::new("/data"));
        assert!(String::from_utf8_lossy(&text).contains(r#""path": "a.csv""#));
        let back = reopened(&text);
        assert_eq!(Session::of(&back), Session::of(&project));
        assert_eq!(back.recordings, project.recordings);
        assert_eq!((back.view, &*back.notes), (View::One(3), "oiled"));
    }

    #[test]
    fn missing_and_unreadable_files_are_reported_and_the_rest_is_restored() {
        let mut project = Project::default();
        for path in ["/data/a.csv", "/data/b.csv", "/data/c.csv"] {
            add(&mut project, path, &["S1"], &[Axis::Fz]);
        }
        let text = Session::of(&project).to_json(Path::new(""));
        let session = Session::from_json(&text).unwrap();
        let found = [
            None,
            Some(Err("/data/b.csv: torn".to_owned())),
            Some(Ok(Loaded {
                recordings: recordings("/data/c.csv", &["/data/c.csv"]),
                ..Loaded::default()
            })),
        ];
        let parts = session.files.iter().zip(found).map(|(file, loaded)| SessionPart {
            file: file.clone(),
            loaded,
            changed: false,
        });
        let opened = OpenedSession {
            parts: parts.collect(),
            calibration: None,
            trained: None,
            session: session.clone(),
        };
        let (back, notices) = opened.into_project();
        assert_eq!(back.lost, session.files[..1]);
        let again = Session::of(&back).with_hashes();
        assert!(again.files.contains(&session.files[0]), "the missing file stays in the session");
        let torn = Notice::new(Level::Error, "/data/b.csv: torn");
        assert_eq!(notices, [torn]);
        assert_eq!(back.files().collect::<Vec<_>>(), [Path::new("/data/c.csv")]);
    }

    /// The order of the parts is that of files from before the document was saved as it is.
    #[test]
    fn every_part_of_an_older_session_is_read() {
        let text = br#"{"format": "loopscope session", "version": 1, "program": "0.1.0", "notes": "oiled",
            "identity": {"serial": "4711"}, "built_in": true, "files": [{"path": "a.csv"}], "cut": 0.5,
            "calibration": "c.json", "settings": {"offset": false}, "measuring": {"hold_secs": 1.5},
            "gauge_range": [-10.0, 10.0], "overload_tolerance": 0.25, "on_screen": "a", "hidden_axes": ["Fx"],
            "layout": null}"#;
        let session = Session::from_json(text).unwrap();
        let Session { project, .. } = &session;
        assert_eq!((&*project.notes, project.identity.entered().count()), ("oiled", 1));
        assert!(!project.settings.offset && session.built_in && session.files.len() == 1);
        assert_eq!(project.measuring.hold_secs, 1.5);
        assert_eq!(project.gauge_range, Some(crate::recording::GaugeRange::All((-10.0, 10.0))));
        assert_eq!((project.overload_tolerance, session.cut), (Some(0.25), Some(0.5)));
        assert_eq!(session.on_screen.as_deref(), Some("a"));
        assert_eq!(session.calibration.as_deref(), Some(Path::new("c.json")));
        let again = Session::from_json(&session.to_json(Path::new(""))).unwrap();
        assert_eq!(again, session);
    }

    #[test]
    fn older_sessions_load_and_newer_ones_are_refused() {
        let old = br#"{"format": "loopscope session", "version": 1, "files": [{"path": "a.csv"}]}"#;
        assert!(Session::is_one(old));
        let session = Session::from_json(old).unwrap();
        assert_eq!(session.project.settings, FitSettings::default());
        assert_eq!(session.files[0].path, Path::new("a.csv"));
        let newer = br#"{"format": "loopscope session", "version": 2}"#;
        let error = Session::from_json(newer).unwrap_err();
        assert!(error.contains("version 2"), "{error}");
        assert!(Session::from_json(b"[1").is_err());
        assert!(!Session::is_one(br#"{"format": "loopscope calibration"}"#));
    }
}
