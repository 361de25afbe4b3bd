//! Puts results of background work into the document.

use super::*;
use crate::{import::unit_note, shown::file_name};

impl Engine {
    /// Puts the finished results of background work into the document. The window calls this before each frame.
    pub fn take(&mut self) {
        // This is checked before the results are taken. If no search runs now, all results of the search have arrived.
        let have_ended = self.lane::<TryModels>().is_idle();
        for failed in self.lanes.take() {
            self.notice(Level::Error, failed);
        }
        self.take_models(have_ended);
        let choice = self.lane::<ChooseBlock>();
        if choice.happened().contains(&LaneEvent::Answer)
            && let Some(chosen) = choice.answer().cloned()
        {
            self.edit(Edit::Block(chosen));
        }
        self.following.take_events();
        let has_failed = self.preview.take_events().contains(&LaneEvent::Problem);
        let problem = self.preview.problem().filter(|_| has_failed && self.importing.is_none());
        if let Some(problem) = problem.map(str::to_owned) {
            // The import window is closed, so the reason is shown as a message.
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
        self.take_tasks();
        self.take_first_thresholds();
        self.list_present();
        self.follow();
    }

    /// Adds the model of the present fit to the list of models, unless the list is empty or already has a model with the
    /// present settings.
    fn list_present(&mut self) {
        let is_moving = self.gesture.is_some() || !self.tasks.is_empty() || self.is_trying();
        let is_wanted = !self.models.rows.is_empty() && !self.models.has_present(&self.project);
        if is_wanted && !is_moving && self.can_keep() {
            self.list(false);
        }
    }

    /// Adds the model of the present calibration to the list of models. `is_asked` is true if the user asked to keep it.
    pub(super) fn list(&mut self, is_asked: bool) {
        if let Some((_, analysis)) = self.exact() {
            let calibration = Arc::clone(&analysis.calibration);
            let Project { recordings, settings, .. } = &self.project;
            let (recordings, settings) = (Arc::clone(recordings), settings.clone());
            self.tasks.start(Task::list(recordings, settings, calibration, is_asked));
        }
    }

    /// Starts the automatic choice of F_th and t_th by cross-validation, unless the user has chosen these thresholds.
    fn find_first_thresholds(&mut self) {
        let thresholds = self.project.thresholds();
        let features = &self.project.settings.features;
        let is_default = features.look_backs == [self.project.default_thresholds()];
        if is_default && self.project.applied.is_none() && !self.project.recordings.is_static() {
            self.first_thresholds = Some((Arc::clone(&self.project.recordings), thresholds));
            self.ask(StudyThresholds::of(&self.request(), thresholds));
        }
    }

    /// Sets the automatically chosen thresholds, unless the user has meanwhile changed thresholds, recordings or roles.
    fn take_first_thresholds(&mut self) {
        let Some((recordings, before)) = &self.first_thresholds else { return };
        let study = self.lane::<StudyThresholds>();
        let is_meant = Arc::ptr_eq(recordings, &self.project.recordings)
            && self.project.settings.features.look_backs == [*before]
            && self.project.applied.is_none();
        if is_meant && !study.is_idle() {
            return;
        }
        let map = study.answer().filter(|_| is_meant && study.is_current());
        let map = map.and_then(|study| study.map.clone());
        self.first_thresholds = None;
        let Some(map) = map else { return };
        let measure = map.scale.default_measure();
        let Ok(found) = map.suggestion(measure) else { return };
        // Setting the thresholds is no undo step of its own. So undo returns to the document before the files were opened.
        let set = self.project.edit(Edit::Thresholds(found.thresholds));
        debug_assert!(set.is_ok(), "thresholds fit any recordings");
        let text = format!("Thresholds set to the {}", found.in_words(&map, measure));
        self.notice(Level::Info, text);
    }

    /// Adds the models that a search or comparison has fitted to the list. `have_ended` is true if no search or comparison
    /// runs.
    pub(super) fn take_models(&mut self, have_ended: bool) {
        let lane = self.lanes.of_mut::<TryModels>(ANYONE);
        if let (Some(asked), Some(found)) = (lane.answered(), lane.answer())
            && !lane.happened().is_empty()
        {
            self.models.take(asked, found);
        }
        // All fitted models are now in the list. The request is removed, because it would keep its recordings in memory.
        if have_ended {
            lane.forget();
        }
    }

    pub(super) fn take_tasks(&mut self) {
        for (done, problem) in self.tasks.take() {
            problem.into_iter().for_each(|problem| self.notice(Level::Error, problem));
            done.into_iter().for_each(|done| self.finish(done));
        }
        self.begin_next();
    }

    pub(in crate::engine) fn finish(&mut self, done: Done) {
        match done {
            Done::Opened(files) => {
                let has_session =
                    files.iter().any(|(_, file)| matches!(file, Ok(Opened::Session(_))));
                match has_session {
                    true => self.leave_for(Leaving::Open(files)),
                    false => self.take_files(files),
                }
            }
            Done::Simulated(before, _) if !Arc::ptr_eq(&before, &self.project.recordings) => {}
            Done::Changed(before, ..) | Done::ReadAgain(before, _)
                if !Arc::ptr_eq(&before, &self.project.recordings) =>
            {
                let text = "The recordings changed while they were tared, read again or searched for faulty samples, so the \
                            result was discarded. Repeat the action.";
                self.notice(Level::Warning, text);
            }
            Done::Changed(_, changed, warnings) => {
                self.edit(Edit::Replace(Arc::new(changed)));
                warnings.into_iter().for_each(|text| self.notice(Level::Warning, text));
            }
            Done::ReadAgain(_, parts) => {
                for map in parts.iter().filter_map(|part| part.file.columns.as_ref()) {
                    self.preferences.remember_map(map);
                }
                let notices = self.change(|project| read_again(project, parts));
                notices.into_iter().for_each(|notice| self.show_notice(notice));
                if self.finds_thresholds {
                    self.find_first_thresholds();
                }
            }
            Done::Simulated(_, set) => self.take_simulated(set),
            Done::Written(content, files) => self.take_written(content, files),
            Done::Map(map) => self.inspect(|own| own.take_map(*map)),
            Done::Weight(path, estimate) => {
                if self.importing.as_ref().is_some_and(|own| own.path == path) {
                    self.inspect(|own| own.take_weight(&estimate));
                    let sentences = estimate.sentences().join("; ");
                    self.notice(Level::Info, format!("Weight estimated: {sentences}"));
                }
            }
            Done::Restored(path, opened) => self.leave_for(Leaving::Restore(path, opened)),
            Done::Located(place, found) => self.take_located(&place, found),
            Done::Proven(trained, recordings, proven) => {
                // The result is ignored if another session was opened since this check began, or if an earlier check has
                // already ended.
                let is_own = |own: &mut Arc<_>| Arc::ptr_eq(own, &trained);
                if self.unproven.take_if(is_own).is_none() {
                    return;
                }
                match proven {
                    Ok(()) => self.take_trained(trained, recordings),
                    Err(reason) => self.notice(Level::Warning, reason),
                }
            }
            Done::Listed(recordings, model, true) => self.models.keep(*model, &recordings),
            Done::Listed(recordings, model, false) => {
                self.models.take_present(*model, &recordings);
            }
        }
    }

    pub(super) fn take_simulated(&mut self, set: RecordingSet) {
        // A session that was just opened has no unsaved changes, and stays so when its simulated recordings arrive.
        let is_saved = self.entries().is_empty() && self.saved.is_some() && !self.is_unsaved();
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
    }

    /// Reports which files were written, and asks whether those that exist may be replaced.
    fn take_written(&mut self, content: FileContent, files: Vec<(PathBuf, Result<(), Unwritten>)>) {
        let (mut existing, mut results) = (Vec::new(), BTreeMap::new());
        for (path, written) in files {
            let result = match (written, &content) {
                (Err(Unwritten::Exists), _) => {
                    existing.push(path);
                    continue;
                }
                (Err(Unwritten::Because(reason)), _) => Err(reason),
                (Ok(()), FileContent::Session(session, trained)) => {
                    self.take_saved(session.project.clone(), trained.clone(), path);
                    continue;
                }
                (Ok(()), _) => Ok(()),
            };
            match &result {
                Ok(()) => self.notice(Level::Info, format!("Wrote {}", path.display())),
                Err(reason) => self.notice(Level::Error, reason),
            }
            results.insert(path, result);
        }
        if let FileContent::Calibration(..) = content {
            let earlier = self.exported.take().filter(|(of, _)| *of == self.project);
            let mut all = earlier.map_or_else(BTreeMap::new, |(_, files)| files);
            all.extend(results);
            self.exported = Some((self.project.clone(), all));
        }
        if !existing.is_empty() {
            let output = Output { content, paths: existing, existing: Existing::Ask };
            self.replacing = Some((output, Doubt::IsThere));
        }
    }

    pub(super) fn take_saved(
        &mut self,
        project: Project,
        trained: Option<Arc<Calibration>>,
        path: PathBuf,
    ) {
        self.preferences.remember(&path);
        let beside = trained.as_ref().map(|_| trained_beside(&path));
        let beside = beside.map_or_else(String::new, |own| {
            format!(", with the trained calibration {}", own.display())
        });
        self.notice(Level::Info, format!("Saved the session {}{beside}", path.display()));
        self.session = Some(path);
        self.saved = Some(project);
        self.saved_trained = trained;
        if !self.is_unsaved() {
            self.leave();
        }
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
                    let questions: Vec<String> = loaded.load_questions().collect();
                    match (&questions[..], unit_note(&loaded.without_unit)) {
                        ([], None) => {}
                        ([], Some(note)) => {
                            self.notice(Level::Info, format!("{}: {note}", file_name(&path)));
                        }
                        (asked, _) => {
                            let text = format!(
                                "{}: {} Answer with the menu of each channel in Import > Channels.",
                                file_name(&path),
                                asked.join(" ")
                            );
                            self.notice(Level::Warning, text);
                        }
                    }
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

    /// Starts the check that the session's trained calibration was trained on the session's recordings, once all are loaded.
    pub(super) fn prove(&mut self) {
        let recordings = &self.project.recordings;
        let is_whole = self.project.lost.is_empty() && !recordings.entries().is_empty();
        if let Some(trained) = self.unproven.as_ref().filter(|_| is_whole) {
            let task = Task::prove(Arc::clone(recordings), Arc::clone(trained));
            self.tasks.start(task);
        }
    }

    /// Uses the trained calibration that was read with the session as if it had just been trained.
    pub(super) fn take_trained(
        &mut self,
        calibration: Arc<Calibration>,
        recordings: Arc<RecordingSet>,
    ) {
        let train = self.training_of(recordings);
        let trained = Trained { calibration: Some(calibration), ..Trained::default() };
        self.lanes.of_mut(ANYONE).put(train, trained);
    }
}
