//! Work that adds, replaces or changes recordings: opening files, simulating, taring, and reading again.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Engine;
use crate::{
    engine::{
        files::{Opened, OpenedFile},
        importing,
        notice::Level,
        project::{Edit, SessionFile, Split},
        session::{Session, SessionPart, add_parts, read_again},
        task::Task,
        tasks::{Files, InTurn},
    },
    finding::Face,
    import::{Loaded, unit_note},
    recording::{RecordingSet, Tare},
    shown::file_name,
};

impl Engine {
    pub(super) fn open(&mut self, paths: Vec<PathBuf>) {
        let files = paths.into_iter().map(|path| {
            let map = self.project.maps.get(&path).cloned();
            (path, map)
        });
        let files: Files = files.filter(|file| !self.tasks.reads(file)).collect();
        if !files.is_empty() {
            self.await_turn(InTurn::Read(files));
        }
    }

    /// Tares the recordings with these indices.
    pub(super) fn tare(&mut self, which: &[usize], tare: Tare) {
        let entries = which.iter().filter_map(|at| self.entries().get(*at));
        let which = entries.map(|entry| Arc::clone(&entry.recording)).collect();
        self.await_turn(InTurn::Tare(which, tare));
    }

    pub(super) fn await_turn(&mut self, turn: InTurn) {
        self.tasks.wait(turn);
        self.begin_next();
    }

    pub(super) fn begin_next(&mut self) {
        let Some(turn) = self.tasks.next_turn() else { return };
        let recordings = Arc::clone(&self.project.recordings);
        let task = match turn.clone() {
            InTurn::Read(files) => Task::open(files, self.preferences.maps.clone()),
            InTurn::Tare(which, tare) => Task::tare(recordings, which, tare),
            InTurn::LeaveOutFaulty => Task::leave_out(recordings, self.project.valid_range()),
            InTurn::ChangeColumns(change) => {
                let is_open = |file: &SessionFile| !self.project.lost.contains(file);
                let mut files = Session::of(&self.project).files;
                files.retain(is_open);
                Task::change_columns(recordings, files, change)
            }
            InTurn::Simulate(late) => Task::simulate(recordings, late),
        };
        self.tasks.begin(task, Some(turn));
    }

    pub(super) fn take_files(&mut self, files: Vec<OpenedFile>) {
        let mut recordings = Vec::new();
        let mut calibrations = Vec::new();
        let mut session = None;
        let mut to_import = Vec::new();
        let mut by_remembered = Vec::new();
        for (path, opened) in files {
            if opened.is_ok() {
                self.preferences.remember(&path);
            }
            match opened {
                Ok(Opened::Recordings(loaded)) => {
                    for warning in &loaded.warnings {
                        self.notice(Level::Warning, warning.text(Face::Window));
                    }
                    self.note_units(&path, &loaded);
                    recordings.push(loaded.recordings);
                    if let Some(map) = loaded.map {
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

    /// Tells which loads have no unit, and which questions about the file's loads are open.
    fn note_units(&mut self, path: &Path, loaded: &Loaded) {
        let asked: Vec<String> = loaded.load_questions().collect();
        let name = file_name(path);
        if !asked.is_empty() {
            let asked = asked.join(" ");
            let text = format!(
                "{name}: {asked} Answer with the menu of each channel in Import > Channels."
            );
            self.notice(Level::Warning, text);
        } else if let Some(note) = unit_note(&loaded.mapped.without_unit) {
            self.notice(Level::Info, format!("{name}: {note}"));
        }
    }

    pub(super) fn take_simulated(&mut self, set: RecordingSet) {
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
    pub(super) fn take_read_again(&mut self, parts: Vec<SessionPart>) {
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
        let open = self.project.files().map(Path::to_owned).collect();
        self.tasks.start(Task::locate(self.project.lost.clone(), place, open));
    }

    /// Adds missing files of the session that have been found at `place`. Files that cannot be read stay in the list of
    /// missing files.
    pub(super) fn take_located(&mut self, place: &Path, found: Vec<(SessionFile, SessionPart)>) {
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
