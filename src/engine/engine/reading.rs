//! Work that adds, replaces or changes recordings: opening files, simulating, taring, and reading again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Engine, Leaving};
use crate::{
    engine::{
        files::{Opened, OpenedFile, open_all},
        importing,
        lost::find,
        notice::{Level, Notice},
        project::{Edit, SessionFile, Split, absolute},
        session::{Session, SessionPart, add_parts, read_again},
        tasks::{Files, Task, Turn},
    },
    finding::{Advice, Face},
    import::{ColumnChange, Loaded, unit_note},
    progress::Progress,
    questions::question::Unanswered,
    recording::{
        Entry, Recording, RecordingSet, Tare, ValidRange,
        simulated::{self, Late},
    },
    scoring::faults::faults_of,
    shown::{file_name, first},
};

/// Maximum number of file names in a notice.
const MAX_NAMED: usize = 4;

impl Engine {
    pub(super) fn open(&mut self, paths: Vec<PathBuf>) {
        let files = paths.into_iter().map(|path| {
            let map = self.project.maps.get(&path).cloned();
            (path, map)
        });
        let files: Files = files.filter(|file| !self.tasks.reads(file)).collect();
        if files.is_empty() {
            return;
        }
        let title = match &files[..] {
            [(one, _)] => format!("Reading {}", file_name(one)),
            many => format!("Reading {} files", many.len()),
        };
        self.await_turn(files.clone(), move |engine| {
            let remembered = engine.preferences.maps.clone();
            let read = move |progress: &_| Ok(open_all(&files, &remembered, progress));
            Task::new(title, read, Self::take_opened)
        });
    }

    pub(in crate::engine) fn take_opened(&mut self, files: Vec<OpenedFile>) {
        if files.iter().any(|(_, file)| matches!(file, Ok(Opened::Session(_)))) {
            self.leave_for(Leaving::Open(files));
        } else {
            self.take_files(files);
        }
    }

    /// Tares the recordings with these indices.
    pub(super) fn tare(&mut self, which: &[usize], tare: Tare) {
        let entries = which.iter().filter_map(|at| self.entries().get(*at));
        // The recordings themselves are kept, because their indices may change before this work begins.
        let which: Vec<_> = entries.map(|entry| Arc::clone(&entry.recording)).collect();
        self.await_turn(Vec::new(), move |engine| {
            let recordings = Arc::clone(&engine.project.recordings);
            let before = Arc::clone(&recordings);
            Task::new(
                "Taring",
                move |_| tared(&recordings, &which, tare),
                move |engine: &mut Self, (tared, warnings)| {
                    engine.take_changed(&before, tared, warnings);
                },
            )
        });
    }

    pub(super) fn leave_out_faulty(&mut self) {
        self.await_turn(Vec::new(), |engine| {
            let recordings = Arc::clone(&engine.project.recordings);
            let (before, range) = (Arc::clone(&recordings), engine.project.valid_range());
            Task::new(
                "Leaving out faulty samples",
                move |_| left_out(&recordings, &range),
                move |engine: &mut Self, set| engine.take_changed(&before, set, Vec::new()),
            )
        });
    }

    /// Reads the files of the recordings again, with changed columns.
    pub(super) fn change_columns(&mut self, change: ColumnChange) {
        self.await_turn(Vec::new(), |engine| {
            let before = Arc::clone(&engine.project.recordings);
            let files = engine.files_found();
            let read = move |progress: &_| {
                let read = |file: &SessionFile| {
                    let (path, columns) = (&file.absolute, &file.columns);
                    let other = change.map_of(path, columns.as_ref(), progress);
                    let columns = other.map_err(because)?.or_else(|| columns.clone());
                    let file = SessionFile { columns, ..file.clone() };
                    let part = SessionPart::at(&file, path.clone(), progress);
                    progress.check()?;
                    match part.loaded {
                        Some(Err(reason)) => Err(Unanswered::Because(reason)),
                        _ => Ok(part),
                    }
                };
                files.iter().map(read).collect::<Result<_, Unanswered>>()
            };
            Task::new("Reading again", read, move |engine: &mut Self, parts| {
                if engine.has_still(&before) {
                    engine.take_read_again(parts);
                }
            })
        });
    }

    /// Simulates the recordings of the built-in sensor, which replace those that are loaded.
    pub(super) fn simulate(&mut self, late: Option<Late>) {
        self.await_turn(Vec::new(), move |engine| {
            let before = Arc::clone(&engine.project.recordings);
            let simulate = move |progress: &Progress| {
                let made = match late {
                    Some(late) => simulated::late_set(simulated::DEFAULT_SEED, late),
                    None => simulated::demonstration(simulated::DEFAULT_SEED),
                };
                progress.check()?;
                Ok(made)
            };
            let take = move |engine: &mut Self, set| engine.take_simulated(&before, set);
            Task::new("Simulating the built-in sensor", simulate, take)
        });
    }

    /// Replaces the recordings by the same ones after a tare, or without their faulty samples.
    pub(in crate::engine) fn take_changed(
        &mut self,
        before: &Arc<RecordingSet>,
        changed: RecordingSet,
        warnings: Vec<String>,
    ) {
        if self.has_still(before) {
            self.edit(Edit::Replace(Arc::new(changed)));
            warnings.into_iter().for_each(|text| self.notice(Level::Warning, text));
        }
    }

    /// Returns true if these recordings are still loaded. Otherwise the result of work on them is discarded with a notice.
    fn has_still(&mut self, before: &Arc<RecordingSet>) -> bool {
        let is_so = Arc::ptr_eq(before, &self.project.recordings);
        if !is_so {
            let text = "The recordings changed while they were tared, read again or searched for faulty samples, so the \
                        result was discarded. Repeat the action.";
            self.notice(Level::Warning, text);
        }
        is_so
    }

    /// Begins work on the recordings, which reads these files, after the other work on recordings has ended.
    fn await_turn(&mut self, files: Files, begin: impl FnOnce(&mut Self) -> Task<Self> + 'static) {
        self.tasks.wait(Turn { files, begin: Box::new(begin) });
        self.begin_next();
    }

    pub(super) fn begin_next(&mut self) {
        if let Some(Turn { files, begin }) = self.tasks.next_turn() {
            let task = begin(self);
            self.tasks.begin(task, Some(files));
        }
    }

    pub(super) fn take_files(&mut self, files: Vec<OpenedFile>) {
        let (mut recordings, mut again) = (Vec::new(), BTreeMap::new());
        let mut kinds = Kinds::default();
        let mut calibrations = Vec::new();
        let mut session = None;
        let mut to_import = Vec::new();
        let mut by_remembered = Vec::new();
        for (path, opened) in files {
            if opened.is_ok() {
                self.preferences.remember(&path);
            }
            match opened {
                Ok(Opened::Recordings(mut loaded)) => {
                    for warning in &loaded.warnings {
                        kinds.note(Level::Warning, &warning.seen, warning.text(Face::Window));
                    }
                    note_units(&path, &loaded, &mut kinds);
                    let map = loaded.map.take();
                    let absolute_path = absolute(&path);
                    if self.project.files().any(|file| absolute(file) == absolute_path) {
                        again.insert(absolute_path, loaded);
                    } else {
                        recordings.push(loaded.recordings);
                    }
                    if let Some(map) = map {
                        if self.project.maps.get(&path) != Some(&*map) {
                            by_remembered.push((path.clone(), (*map).clone()));
                        }
                        self.project.maps.insert(path, *map);
                    }
                }
                Ok(Opened::Calibration(edit, notes)) => {
                    notes.into_iter().for_each(|note| self.notice(Level::Warning, note));
                    calibrations.push(edit);
                }
                Ok(Opened::Session(opened)) => session = Some((path, *opened)),
                Ok(Opened::WantsMap) => to_import.push(path),
                Err(error) => self.notice(Level::Error, error),
            }
        }
        for text in importing::by_remembered(by_remembered) {
            self.notice(Level::Info, text);
        }
        self.begin_import(to_import);
        if let Some((path, opened)) = session {
            self.take_session(Some(path), opened);
        }
        if self.project.begins_with(&recordings) {
            self.set_aside();
        }
        kinds.into_notices().into_iter().for_each(|notice| self.show_notice(notice));
        if !again.is_empty() {
            self.reload(again);
        }
        if !recordings.is_empty() {
            let refused = self.change(|project| project.add(recordings));
            refused.into_iter().for_each(|refused| self.notice(Level::Error, refused));
        }
        let has_recordings = !self.entries().is_empty();
        calibrations.into_iter().for_each(|edit| self.edit(edit));
        if has_recordings && self.finds_thresholds {
            self.find_first_thresholds();
        }
    }

    /// Returns the files of the session without those that are missing.
    fn files_found(&self) -> Vec<SessionFile> {
        let mut files = Session::of(&self.project).files;
        files.retain(|file| !self.project.lost.contains(file));
        files
    }

    /// Replaces the recordings of open files by those just read from the same files.
    fn reload(&mut self, mut again: BTreeMap<PathBuf, Loaded>) {
        let names = first(MAX_NAMED, again.keys().map(|path| file_name(path)));
        let files = self.files_found();
        let whole = self.project.split.as_ref().map(|split| &split.whole);
        let whole = Arc::clone(whole.unwrap_or(&self.project.recordings));
        let parts = files.into_iter().map(|file| {
            let read = again.remove(&file.absolute);
            SessionPart::again(file, read, &whole)
        });
        let parts = parts.collect();
        self.take_read_again(parts);
        self.notice(
            Level::Info,
            format!("These files were open already and were read again: {names}"),
        );
    }

    pub(in crate::engine) fn take_simulated(
        &mut self,
        before: &Arc<RecordingSet>,
        set: RecordingSet,
    ) {
        if !Arc::ptr_eq(before, &self.project.recordings) {
            return;
        }
        // A session that was just opened has no unsaved changes, and stays so when its simulated recordings arrive.
        let is_first = self.entries().is_empty();
        let is_saved = is_first && self.saved.is_some() && !self.is_unsaved();
        let is_other = self.project.is_of_other(&set.layout().gauge_names);
        if is_other {
            self.set_aside();
        }
        let refused = self.change(|project| {
            if is_other {
                project.begin_for_other();
            }
            // A split of the opened session waits here for these recordings, because the session had none when it was opened.
            let waits = |split: &&Split| split.whole.entries().is_empty();
            let split = project.split.as_ref().filter(waits);
            let split = split.map(|split| Edit::Split(split.fraction));
            let refused = project.take_set(set).err();
            // If the user opened a calibration during the simulation, it is now applied to the simulated recordings.
            let applied = project.applied.take();
            let fits = project.edit(Edit::Apply(applied)).err();
            let split = split.and_then(|split| project.edit(split).err());
            project.show_first_test();
            refused.into_iter().chain(fits).chain(split)
        });
        refused.for_each(|error| self.notice(Level::Error, error.to_string()));
        if is_saved {
            self.saved = Some(self.project.clone());
        }
        self.prove();
        if is_first && !is_saved && self.finds_thresholds {
            self.find_first_thresholds();
        }
    }

    /// Replaces the recordings by those of the same files that were read by other column maps.
    fn take_read_again(&mut self, parts: Vec<SessionPart>) {
        for map in parts.iter().filter_map(|part| part.file.columns.as_ref()) {
            self.preferences.remember_map(map);
        }
        let notices = self.change(|project| read_again(project, parts));
        notices.into_iter().for_each(|notice| self.show_notice(notice));
        if self.finds_thresholds {
            self.find_first_thresholds();
        }
    }

    /// Searches for the missing files of the session at this path.
    pub(super) fn locate(&mut self, place: PathBuf) {
        let open: Vec<PathBuf> = self.project.files().map(Path::to_owned).collect();
        let (lost, searched) = (self.project.lost.clone(), place.clone());
        let search = move |progress: &Progress| {
            let found = find(&lost, &searched, &open).into_iter();
            let found = found.map(|(at, path)| {
                let part = SessionPart::at(&lost[at], path, progress);
                (lost[at].clone(), part)
            });
            let found: Vec<_> = found.collect();
            progress.check()?;
            Ok(found)
        };
        let take = move |engine: &mut Self, found| engine.take_located(&place, found);
        self.tasks.begin(Task::new("Searching missing files", search, take), None);
    }

    /// Adds missing files of the session that have been found at `place`. Files that cannot be read stay in the list of
    /// missing files.
    fn take_located(&mut self, place: &Path, found: Vec<(SessionFile, SessionPart)>) {
        let mut parts = Vec::new();
        for (file, part) in found {
            // The missing file is no longer in the list if another session was opened since the search began.
            if self.project.lost.contains(&file) {
                parts.push((file, part));
            }
        }
        if parts.is_empty() {
            let text = format!(
                "{}: none of the missing files was found there; choose a folder with files of the same name or content",
                place.display()
            );
            self.notice(Level::Error, text);
            return;
        }
        let notices = self.change(|project| {
            let is_read = |(_, part): &&(_, SessionPart)| matches!(part.loaded, Some(Ok(_)));
            let read: Vec<&SessionFile> =
                parts.iter().filter(is_read).map(|(file, _)| file).collect();
            project.lost.retain(|lost| !read.contains(&lost));
            add_parts(project, parts.into_iter().map(|(_, part)| part).collect())
        });
        notices.into_iter().for_each(|notice| self.show_notice(notice));
        self.prove();
    }

    /// Removes the missing file with this index from the session.
    pub(super) fn forget(&mut self, at: usize) {
        if at < self.project.lost.len() {
            self.change(|project| project.lost.remove(at));
            self.prove();
        }
    }
}

/// Adds a notice about loads without a unit, or about the questions on the file's loads that are still open.
fn note_units(path: &Path, loaded: &Loaded, kinds: &mut Kinds) {
    let asked: Vec<String> = loaded.load_questions().collect();
    let name = file_name(path);
    if !asked.is_empty() {
        let asked = asked.join(" ");
        let text =
            format!("{name}: {asked} Answer with the menu of each channel in Import > Channels.");
        kinds.note(Level::Warning, &asked, text);
    } else if let Some(note) = unit_note(&loaded.mapped.without_unit) {
        kinds.note(Level::Info, &note, format!("{name}: {note}"));
    }
}

/// Notices about files that were read together: one for each kind. The notices of one kind differ only in their numbers.
#[derive(Default)]
struct Kinds(Vec<(String, Notice, usize)>);

impl Kinds {
    /// Adds a notice. `words` are its text without the name of the file.
    fn note(&mut self, level: Level, words: &str, text: String) {
        let kind: String = words.chars().filter(|c| c.is_alphabetic()).collect();
        match self.0.iter_mut().find(|(known, ..)| *known == kind) {
            Some((.., n)) => *n += 1,
            None => self.0.push((kind, Notice::new(level, text), 1)),
        }
    }

    fn into_notices(self) -> Vec<Notice> {
        let notice = |(_, notice, n): (String, Notice, usize)| match n {
            1 => notice,
            _ => Notice { text: format!("{n} files, such as {}", notice.text), ..notice },
        };
        self.0.into_iter().map(notice).collect()
    }
}

pub(super) fn because(error: impl Advice) -> Unanswered {
    Unanswered::Because(error.text(Face::Window))
}

/// Returns the recordings, of which those in `which` are tared, and a warning for each that carries a load during its tare.
/// They are recognised by name and file.
fn tared(
    recordings: &RecordingSet,
    which: &[Arc<Recording>],
    tare: Tare,
) -> Result<(RecordingSet, Vec<String>), Unanswered> {
    let (mut set, mut warnings) = (recordings.clone(), Vec::new());
    for (at, Entry { recording, .. }) in recordings.entries().iter().enumerate() {
        if which
            .iter()
            .any(|meant| meant.name() == recording.name() && meant.source() == recording.source())
        {
            let (tared, place) = Recording::clone(recording).tared(tare).map_err(because)?;
            warnings.extend(tared.loaded_while_tared(place).map(|found| found.text(Face::Window)));
            set.replace(at, tared);
        }
    }
    Ok((set, warnings))
}

/// Returns the recordings without faulty samples. A recording that consists only of faulty samples is removed.
fn left_out(recordings: &RecordingSet, range: &ValidRange) -> Result<RecordingSet, Unanswered> {
    let mut set = RecordingSet::default();
    let all: Vec<&Recording> = recordings.entries().iter().map(|entry| &*entry.recording).collect();
    for (entry, found) in recordings.entries().iter().zip(faults_of(&all, range)) {
        for part in found.left_out_of(&entry.recording, range) {
            let part = Entry { group: entry.group.clone(), ..Entry::new(part, entry.role) };
            set.push(part).map_err(because)?;
        }
    }
    if set.entries().is_empty() {
        let text =
            "all samples look faulty, so none is left; check the gauge range and the rated loads";
        return Err(Unanswered::Because(text.to_owned()));
    }
    Ok(set)
}
