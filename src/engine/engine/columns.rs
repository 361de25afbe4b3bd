//! The import page, in which the user chooses the columns of a file.

use std::path::{Path, PathBuf};

use super::{Engine, reading::because};
use crate::{
    engine::{
        importing::{ImportCommand, Importing, Preview},
        notice::Level,
        query::{Background as _, LaneEvent},
        tasks::Task,
    },
    import::{ColumnChange, estimate_weight, inspect::Known, pose::WeightEstimate},
};

impl Engine {
    /// Opens the import page for these files, one after another.
    pub(super) fn begin_import(&mut self, mut paths: Vec<PathBuf>) {
        if paths.is_empty() {
            return;
        }
        match &mut self.importing {
            Some(importing) => importing.waiting.extend(paths),
            None => {
                let path = paths.remove(0);
                let mut importing = Importing { path, waiting: paths, ..Importing::default() };
                let preview = match self.project.maps.get(&importing.path) {
                    Some(map) => importing.take_map(map.clone()),
                    None => importing.look(Known::Nothing),
                };
                self.preview.ask_again(preview);
                self.importing = Some(importing);
            }
        }
    }

    /// Changes the state of the import page by `change`, and inspects the file again in the background.
    fn inspect(&mut self, change: impl FnOnce(&mut Importing) -> Preview) {
        if let Some(importing) = &mut self.importing {
            let preview = change(importing);
            self.preview.ask_again(preview);
        }
    }

    /// Uses the weight that was estimated for the file at this path.
    fn take_weight(&mut self, path: &Path, estimate: &WeightEstimate) {
        if self.importing.as_ref().is_some_and(|importing| importing.path == path) {
            self.inspect(|importing| importing.take_weight(estimate));
            let sentences = estimate.sentences().join("; ");
            self.notice(Level::Info, format!("Weight estimated: {sentences}"));
        }
    }

    /// Takes the newest inspection of the file in the import page.
    pub(super) fn take_preview(&mut self) {
        let has_failed = self.preview.take_events().contains(&LaneEvent::Problem);
        let problem = self.preview.problem().filter(|_| has_failed && self.importing.is_none());
        if let Some(problem) = problem.map(str::to_owned) {
            // The import page is closed, so the reason is shown as a message.
            self.notice(Level::Error, problem);
        }
        if !self.preview.happened().is_empty()
            && let Some((importing, asked)) = self.importing.as_mut().zip(self.preview.asked())
            && importing.path == asked.path
        {
            let problem = self.preview.problem().map(str::to_owned);
            // The result for an older column map would undo the newest change of the map, so it is ignored.
            let found = self.preview.answer().filter(|_| self.preview.is_current());
            importing.is_detecting &= found.is_none() && problem.is_none();
            match found {
                Some(found) => importing.take_inspection(found),
                None => importing.problem = problem.or(importing.problem.take()),
            }
        }
    }

    pub(super) fn import(&mut self, command: ImportCommand) {
        match command {
            ImportCommand::Open(path) => self.begin_import(vec![path]),
            ImportCommand::SetLayout(text) => self.inspect(|importing| importing.take_layout(text)),
            ImportCommand::SetMap(map) => self.inspect(|importing| importing.try_map(*map)),
            ImportCommand::Begin => self.inspect(|importing| importing.look(Known::Nothing)),
            ImportCommand::FindWeight => {
                if let Some(Importing { path, map, .. }) = &self.importing {
                    let (path, map, of) = (path.clone(), map.clone(), path.clone());
                    let find = move |progress: &_| {
                        estimate_weight(&path, Some(&map), progress).map_err(because)
                    };
                    let take = move |engine: &mut Self, found| engine.take_weight(&of, &found);
                    self.tasks.begin(Task::new("Estimating the weight", find, take), None);
                }
            }
            ImportCommand::Load => {
                let Some(Importing { path, map, waiting, .. }) = self.importing.take() else {
                    return;
                };
                self.preferences.remember_map(&map);
                if self.project.files().any(|file| file == path) {
                    // The file's recordings are read again, not added a second time.
                    let change = ColumnChange::Map(path, Box::new(map));
                    self.change_columns(change);
                    self.begin_import(waiting);
                } else {
                    self.project.maps.insert(path.clone(), map);
                    self.open([vec![path], waiting].concat());
                }
            }
            ImportCommand::Cancel => {
                let waiting = self.importing.take().map(|importing| importing.waiting);
                self.preview.cancel();
                self.begin_import(waiting.unwrap_or_default());
            }
            ImportCommand::CancelAll => {
                self.preview.cancel();
                if let Some(importing) = self.importing.take() {
                    self.notice(Level::Info, importing.not_read());
                }
            }
        }
    }
}
