//! Leaving everything that is loaded: for another session, because the window closes, or by a crash.

use super::*;

impl Engine {
    /// Puts a session in place of everything that is loaded; one without a path was recovered.
    pub(super) fn take_session(&mut self, path: Option<PathBuf>, mut opened: OpenedSession) {
        self.layout.clone_from(&opened.session.layout);
        self.unproven = match opened.trained.take() {
            Some(Ok(trained)) => Some(trained),
            Some(Err(error)) => {
                self.tell(Level::Warning, error);
                None
            }
            None => None,
        };
        self.saved_trained.clone_from(&self.unproven);
        let (is_built_in, late) = (opened.session.built_in, opened.session.built_in_lag);
        let (project, notices) = opened.into_project();
        notices.into_iter().for_each(|notice| self.say(notice));
        let maps = std::mem::take(&mut self.project.maps);
        self.project = project;
        for (path, map) in maps {
            self.project.maps.entry(path).or_insert(map);
        }
        if is_built_in {
            self.await_turn(InTurn::Simulate(late));
        }
        // What was recovered is not saved anywhere, be it of the built-in sensor.
        self.saved = Some(match &path {
            Some(_) => self.project.clone(),
            None => Project::default(),
        });
        self.session = path;
        // Its file must not be saved over with what was loaded before.
        self.history = History::default();
        self.lanes.of_mut::<Analyse>().forget();
        self.prove();
    }

    /// Does what takes everything away that is loaded, or asks first where something is not saved.
    pub(super) fn leave_for(&mut self, leaving: Leaving) {
        self.leaving = Some(leaving);
        if !self.is_unsaved() {
            self.leave();
        }
    }

    /// Does what waited for an answer.
    pub(super) fn leave(&mut self) {
        match self.leaving.take() {
            None => {}
            Some(Leaving::Close) => self.closes = true,
            Some(Leaving::Open(files)) => self.take_files(files),
            Some(Leaving::Restore(path, opened)) => {
                self.take_session(None, *opened);
                self.recoverable.retain(|left| left.path != path);
                self.restored.push(path);
            }
        }
    }

    /// Where to write down what is not saved, so that it survives a crash; offers what others left there.
    pub fn recover_in(&mut self, folder: &Path) {
        self.recovery = Recovery::begin(folder);
        self.act(Action::ShowLeft(true));
    }

    /// Hands what is not saved to the autosave; `layout` says where the panes stand.
    pub fn write_down(&mut self, layout: &dyn Fn() -> serde_json::Value) {
        let is_saved = !self.is_unsaved();
        let trained = self.trained_to_save();
        let is_same = |own: &Project| *own == self.project;
        if !(self.kept.as_ref().is_some_and(is_same) && self.recovery.has(trained, is_saved)) {
            let newest = Unsaved {
                session: Session::of(&self.project, Some(layout())),
                trained: trained.cloned(),
                of: Arc::clone(&self.project.recordings),
            };
            self.recovery.keep(newest, is_saved);
            self.kept = Some(self.project.clone());
        }
        // After the newest state, which is what takes their place; while files are read or simulated it is not whole yet.
        if self.tasks.is_empty() {
            self.recovery.take_over(std::mem::take(&mut self.restored));
        }
    }

    /// The window closes as it should: nothing needs to be recovered.
    pub fn end(&mut self) {
        self.recovery.end();
    }
}
