//! Results of questions and tasks, taken into the document.

use super::*;

impl Engine {
    /// Takes the results of questions and tasks into the document.
    pub fn take(&mut self) {
        // Queried before taking answers: once a lane is idle, its answer can be taken.
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
        if !self.preview.take_events().is_empty()
            && let Some((importing, asked)) = self.importing.as_mut().zip(self.preview.asked())
        {
            // An answer to an older map would undo the newest change of the map.
            let found = self.preview.answer().filter(|_| self.preview.is_current());
            let answer = found.ok_or(self.preview.problem());
            match answer {
                Ok(found) => importing.take_answer(&asked.path, Ok(found)),
                Err(Some(problem)) => importing.take_answer(&asked.path, Err(problem)),
                Err(None) => {}
            }
        }
        self.take_tasks();
        self.take_first_thresholds();
        self.list_present();
        self.follow();
    }

    /// Adds the present settings to the list of models, if the list has rows but none with these settings.
    fn list_present(&mut self) {
        let is_moving = self.gesture.is_some() || !self.tasks.is_empty() || self.is_trying();
        if self.models.rows.is_empty() || is_moving || !self.can_keep() {
            return;
        }
        let analysis = self.exact().map(|(_, analysis)| Arc::clone(&analysis.calibration));
        if let Some(calibration) = analysis.filter(|_| !self.models.has_present(&self.project)) {
            let (recordings, settings) = (&self.project.recordings, &self.project.settings);
            self.start(Task::list_present(Arc::clone(recordings), settings.clone(), calibration));
        }
    }

    /// Searches for the thresholds with the lowest cross-validation error, unless the user has chosen thresholds.
    fn find_first_thresholds(&mut self) {
        let thresholds = self.project.thresholds();
        let features = &self.project.settings.features;
        let is_default = features.look_backs == [self.project.default_thresholds()];
        if is_default && self.project.applied.is_none() && !self.project.recordings.is_static() {
            self.first_thresholds = Some((Arc::clone(&self.project.recordings), thresholds));
            self.ask(StudyThresholds::of(&self.request(), thresholds));
        }
    }

    /// Sets the thresholds that were found, unless the user has changed thresholds, recordings or roles.
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
        // Undo must also undo opening the files, so this is not a step of its own.
        let set = self.project.edit(Edit::Thresholds(found.thresholds));
        debug_assert!(set.is_ok(), "thresholds fit any recordings");
        let shown = ShownFTh::of(map.distance);
        let f_th = format!("{} {}", shown.number(found.thresholds.f_th), shown.unit);
        let text = format!("Thresholds set to the {}", found.in_words(&map, measure, &f_th));
        self.notice(Level::Info, text);
    }

    /// Takes the models that were tried.
    pub(super) fn take_models(&mut self, have_ended: bool) {
        let lane = self.lanes.of_mut::<TryModels>();
        if let (Some(asked), Some(found)) = (lane.answered(), lane.answer())
            && !lane.happened().is_empty()
        {
            self.models.take(asked, found);
        }
        // The models are in the list, so the recordings need not be kept for the question.
        if have_ended {
            lane.forget();
        }
    }

    pub(super) fn take_tasks(&mut self) {
        let mut ended = Vec::new();
        self.tasks.retain_mut(|Begun { lane: task, .. }| {
            let is_idle = task.is_idle();
            task.take_events();
            if is_idle {
                ended.push((task.take_whole(), task.problem().map(str::to_owned)));
            }
            !is_idle
        });
        for (done, problem) in ended {
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
            Done::Changed(before, ..) if !Arc::ptr_eq(&before, &self.project.recordings) => {
                let text = "The recordings were changed during taring or leaving out faulty samples, so the result was \
                            discarded. Repeat the action.";
                self.notice(Level::Warning, text);
            }
            Done::Changed(_, Ok(changed), warnings) => {
                self.edit(Edit::Replace(Arc::new(changed)));
                warnings.into_iter().for_each(|text| self.notice(Level::Warning, text));
            }
            Done::Changed(_, Err(error), _) => self.notice(Level::Error, error),
            Done::Simulated(_, set) => self.take_simulated(set),
            Done::Written(FileContent::Session(_, project, trained), path, Ok(())) => {
                self.take_saved(*project, trained, path);
            }
            Done::Written(_, path, Ok(())) => {
                self.notice(Level::Info, format!("Wrote {}", path.display()));
            }
            Done::Written(_, _, Err(error)) => self.notice(Level::Error, error),
            Done::IsThere(content, path) => {
                self.replacing = Some((content, path, Doubt::IsThere));
            }
            Done::Map(Ok(map)) => {
                let preview = self.importing.as_mut().map(|own| own.take_map(*map));
                preview.into_iter().for_each(|preview| self.preview.ask_again(preview));
            }
            Done::Weight(path, found) => {
                let importing = self.importing.as_mut().filter(|own| own.path == path);
                let Some(importing) = importing else { return };
                match found {
                    Ok(estimate) => {
                        let preview = importing.take_weight(&estimate);
                        self.preview.ask_again(preview);
                        self.notice(Level::Info, importing::in_words(&estimate));
                    }
                    Err(error) => self.notice(Level::Error, error),
                }
            }
            Done::Restored(path, Ok(opened)) => self.leave_for(Leaving::Restore(path, opened)),
            Done::Located(place, found) => self.take_located(&place, found),
            Done::Proven(trained, recordings, proven) => {
                // Another session may have been opened in the meantime, or the same check been started twice.
                let is_own = |own: &mut Arc<_>| Arc::ptr_eq(own, &trained);
                if self.unproven.take_if(is_own).is_none() {
                    return;
                }
                match proven {
                    Ok(()) => self.take_trained(trained, recordings),
                    Err(reason) => self.notice(Level::Warning, reason),
                }
            }
            Done::Kept(recordings, model) => self.models.keep(*model, &recordings),
            Done::Present(recordings, model) => self.models.take_present(*model, &recordings),
            Done::Map(Err(error)) | Done::Restored(_, Err(error)) => {
                self.notice(Level::Error, error)
            }
        }
    }

    pub(super) fn take_simulated(&mut self, set: RecordingSet) {
        // A session that was just opened with the built-in sensor is unchanged.
        let is_saved = self.entries().is_empty() && self.saved.is_some() && !self.is_unsaved();
        let refused = self.change(|project| {
            // Split of an opened session that waits for its recordings.
            let waits = |split: &&Split| split.whole.entries().is_empty();
            let split = project.split.as_ref().filter(waits);
            let split = split.map(|split| Edit::Split(split.fraction));
            let refused = project.take_set(set).err();
            // A calibration that was opened in the meantime is applied to these recordings.
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
                Ok(Opened::Recordings(loaded, map)) => {
                    for warning in &loaded.warnings {
                        self.notice(Level::Warning, warning.text(Face::Window));
                    }
                    recordings.push(loaded.recordings);
                    if let Some(map) = map {
                        if self.project.maps.get(&path) != Some(&*map) {
                            by_remembered.push((path.clone(), (*map).clone()));
                        }
                        self.project.maps.insert(path, *map);
                    }
                }
                Ok(Opened::Calibration(calibration, notes)) => {
                    for note in notes {
                        self.notice(Level::Warning, note);
                    }
                    calibrations.push(Edit::Apply(Some(FromFile { path, calibration })));
                }
                Ok(Opened::Factory(calibration)) => {
                    calibrations.push(Edit::Compare(Some(FromFile { path, calibration })));
                }
                Ok(Opened::Session(opened)) => session = Some((path, *opened)),
                Ok(Opened::WantsMap(reason)) => {
                    log::info!("{reason}");
                    to_import.push(path);
                }
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
        if !recordings.is_empty() {
            let refused = self.change(|project| project.add(recordings, |_| None));
            refused.into_iter().for_each(|refused| self.notice(Level::Error, refused));
        }
        let has_recordings = !self.entries().is_empty();
        calibrations.into_iter().for_each(|edit| self.edit(edit));
        if has_recordings && self.finds_thresholds {
            self.find_first_thresholds();
        }
    }

    /// Takes missing files of the session that were found. Files that cannot be read stay missing.
    pub(super) fn take_located(&mut self, place: &Path, found: Vec<(SessionFile, SessionPart)>) {
        let mut parts = Vec::new();
        for (file, part) in found {
            let at = self.project.lost.iter().position(|lost| *lost == file);
            // Another session may have been opened in the meantime.
            let Some(at) = at else { continue };
            if let Some(Ok(_)) = part.loaded {
                self.project.lost.remove(at);
            }
            parts.push(part);
        }
        if parts.is_empty() {
            let text = format!(
                "{}: none of the missing files was found there; choose a folder with files of the same name or content",
                place.display()
            );
            self.notice(Level::Error, text);
            return;
        }
        let notices = self.change(|project| add_parts(project, parts));
        notices.into_iter().for_each(|notice| self.show_notice(notice));
        self.prove();
    }

    /// Checks that the trained calibration of the session belongs to its recordings, once all are loaded.
    pub(super) fn prove(&mut self) {
        let recordings = &self.project.recordings;
        let is_whole = self.project.lost.is_empty() && !recordings.entries().is_empty();
        if let Some(trained) = self.unproven.as_ref().filter(|_| is_whole) {
            let task = Task::prove(Arc::clone(recordings), Arc::clone(trained));
            self.start(task);
        }
    }

    /// Takes the trained calibration of the session as the result of a training.
    pub(super) fn take_trained(
        &mut self,
        calibration: Arc<Calibration>,
        recordings: Arc<RecordingSet>,
    ) {
        let train = self.training_of(recordings);
        let trained = Trained { calibration: Some(calibration), ..Trained::default() };
        self.lanes.of_mut().put(train, trained);
    }
}
