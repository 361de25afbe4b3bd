//! Actions that discard all loaded data, such as opening a session, and the autosave that protects the data.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Action, Engine, Leaving, SetAside};
use crate::{
    engine::{
        lanes::ANYONE,
        notice::Level,
        project::{Edit, Project},
        query::Background as _,
        recovery::{Recovery, Unsaved, drop_left},
        session::{OpenedSession, Session},
        tasks::Task,
        undo::History,
    },
    progress::Progress,
    questions::{errors::query::Analyse, models::asked::TryModels, question::Unanswered},
};

impl Engine {
    /// Replaces all loaded data by an opened session. `path` is `None` for an autosaved session.
    pub(super) fn take_session(&mut self, path: Option<PathBuf>, mut opened: OpenedSession) {
        self.unproven = opened.trained.take().transpose().unwrap_or_else(|error| {
            self.notice(Level::Warning, error);
            None
        });
        self.saved_trained.clone_from(&self.unproven);
        let (is_built_in, late) = (opened.session.built_in, opened.session.built_in_lag);
        let (project, notices) = opened.into_project();
        notices.into_iter().for_each(|notice| self.show_notice(notice));
        let mut maps = std::mem::take(&mut self.project.maps);
        maps.extend(project.maps);
        self.project = Project { maps, ..project };
        if is_built_in {
            self.simulate(late);
        }
        // A restored autosaved session counts as unsaved, because its file is removed once it is restored.
        self.saved = Some(match &path {
            Some(_) => self.project.clone(),
            None => Project::default(),
        });
        self.session = path;
        self.n_documents += 1;
        // Undo must not bring back the data of the previous session, because saving would then write them over this session.
        self.history = History::default();
        self.lanes.of_mut::<Analyse>(ANYONE).forget();
        self.prove();
    }

    /// Drops the running and waiting work on the present document.
    pub(super) fn drop_work(&mut self) {
        self.lanes.cancel();
        self.tasks.drop_turns();
        self.following.forget();
        self.importing = None;
    }

    /// Sets the session file and the list of models of the present document aside, because a new document begins.
    pub(super) fn set_aside(&mut self) {
        self.lanes.of_mut::<TryModels>(ANYONE).forget();
        (self.saved, self.saved_trained, self.unproven) = (None, None, None);
        self.n_documents += 1;
        self.aside.retain(|aside| aside.recordings.strong_count() > 0);
        self.aside.push(SetAside {
            recordings: Arc::downgrade(&self.project.recordings),
            session: self.session.take(),
            models: std::mem::take(&mut self.models),
        });
    }

    /// Undoes or redoes an edit. If this leads to another document, its session file and its list of models come back.
    pub(super) fn travel(&mut self, step: fn(&mut History, &mut Project)) {
        let before = Arc::downgrade(&self.project.recordings);
        step(&mut self.history, &mut self.project);
        let now = Arc::as_ptr(&self.project.recordings);
        let is_now = |aside: &&mut SetAside| std::ptr::eq(aside.recordings.as_ptr(), now);
        if let Some(aside) = self.aside.iter_mut().find(is_now) {
            self.lanes.of_mut::<TryModels>(ANYONE).forget();
            std::mem::swap(&mut self.session, &mut aside.session);
            std::mem::swap(&mut self.models, &mut aside.models);
            aside.recordings = before;
            self.saved = None;
        }
    }

    /// Carries out an action that discards all loaded data. If there are unsaved changes, the user is asked first.
    pub(super) fn leave_for(&mut self, leaving: Leaving) {
        self.leaving = Some(leaving);
        if !self.is_unsaved() {
            self.leave();
        }
    }

    pub(super) fn restore(&mut self, path: PathBuf) {
        let autosaved = path.clone();
        let read = move |progress: &Progress| {
            let opened = OpenedSession::read(&autosaved, progress).map_err(Unanswered::Because);
            progress.check()?;
            opened
        };
        let take = move |engine: &mut Self, opened| {
            engine.leave_for(Leaving::Restore(path, Box::new(opened)));
        };
        self.tasks.begin(Task::new("Restoring an autosaved session", read, take), None);
    }

    pub(super) fn leave(&mut self) {
        match self.leaving.take() {
            None => {}
            Some(Leaving::Close) => self.closes = true,
            Some(Leaving::New) => self.edit(Edit::New),
            Some(Leaving::Open(files)) => self.take_files(files),
            Some(Leaving::Restore(path, opened)) => {
                self.take_session(None, *opened);
                self.recoverable.retain(|left| left.path != path);
                self.restored.push(path);
            }
        }
    }

    /// Starts the autosave in `folder`, and shows the user the autosaved sessions of crashed windows.
    pub fn recover_in(&mut self, folder: &Path) {
        self.recovery = Recovery::begin(folder);
        self.act(Action::ShowLeft(true));
    }

    pub(super) fn show_left(&mut self, yes: bool) {
        self.shows_left = yes;
        if yes {
            // Since this list of autosaved sessions was made, other windows may have crashed, or restored or discarded
            // sessions.
            self.recoverable = self.recovery.left();
            self.recoverable.retain(|left| !self.restored.contains(&left.path));
        }
    }

    pub(super) fn drop_left(&mut self, path: &Path) {
        self.recoverable.retain(|left| left.path != path);
        drop_left(path);
    }

    /// Passes the newest document to the autosave if it has changed.
    pub fn write_down(&mut self) {
        let is_saved = !self.is_unsaved();
        let trained = self.trained_to_save();
        if !self.recovery.has(&self.project, trained, is_saved) {
            let session = Session::of(&self.project);
            self.recovery.keep(Unsaved { session, trained: trained.cloned() }, is_saved);
        }
        // The autosave of this window replaces the files of restored sessions. This begins only when all their recordings are
        // loaded.
        if self.tasks.is_empty() {
            self.recovery.take_over(std::mem::take(&mut self.restored));
        }
    }

    /// Ends the autosave, and removes the file of this window. The window calls this when it closes normally.
    pub fn end(&mut self) {
        self.recovery.end();
    }
}
