//! Actions of the user. Quick actions are done at once, slow ones in the background.

use super::*;
use crate::{import::inspect::Known, questions::WITHIN};

impl Engine {
    /// Carries out an action of the user. Slow work runs in the background.
    pub fn act(&mut self, action: Action) {
        match action {
            Action::Edit(edit) => self.edit(edit),
            Action::New => self.leave_for(Leaving::New),
            Action::Undo => self.travel(History::undo),
            Action::Redo => self.travel(History::redo),
            Action::Show(view) => self.project.view = view,
            Action::Open(paths) => self.open(paths),
            Action::OpenBuiltIn(late) => self.await_turn(InTurn::Simulate(late)),
            Action::Tare(which, tare) => {
                let entries = which.iter().filter_map(|at| self.entries().get(*at));
                let which = entries.map(|entry| Arc::clone(&entry.recording)).collect();
                self.await_turn(InTurn::Tare(which, tare));
            }
            Action::SetRole(asked) => self.await_turn(InTurn::SetRole(asked)),
            Action::LeaveOutFaulty => self.await_turn(InTurn::LeaveOutFaulty),
            Action::Save(content, path, existing) => {
                self.save(Output { content, paths: vec![path], existing });
            }
            Action::Export(paths, existing) => self.export(paths, existing),
            Action::Replace(yes) => self.replace(yes),
            Action::Train => self.train(),
            Action::StopTraining => self.lane::<Train>().cancel(),
            Action::ChooseBlock(block, measure) => self.choose_block(block, measure),
            Action::FindBest(..) if self.is_trying() => {}
            Action::FindBest(candidates, time_limit) => {
                let run = self.models.next_run();
                let search = Search {
                    recordings: Arc::clone(&self.project.recordings),
                    settings: self.project.settings.clone(),
                    candidates,
                    time_limit,
                    within: WITHIN,
                };
                self.lanes.of_mut(ANYONE).ask_again(TryModels { run, search });
            }
            Action::StopTrying => self.lane::<TryModels>().cancel(),
            Action::Follow(path) => {
                self.following.cancel();
                self.following.ask_again(Follow { path, calibration: Arc::clone(&self.current) });
            }
            Action::StopFollowing => self.following.forget(),
            Action::KeepModel if self.can_keep() => self.list(true),
            Action::KeepModel => self.notice(
                Level::Error,
                "There is no model to keep yet: fit or train with the present settings first",
            ),
            Action::Model(id, change) => self.models.change(id, change),
            Action::BringBack(id) => {
                let settings = self.models.row(id).map(|row| Box::new(row.model.settings.clone()));
                settings.into_iter().for_each(|settings| self.edit(Edit::Model(settings)));
            }
            Action::Import(command) => self.import(command),
            Action::Restore(path) => self.tasks.start(Task::restore(path)),
            Action::DropLeft(path) => {
                self.recoverable.retain(|left| left.path != path);
                drop_left(&path);
            }
            Action::ShowLeft(yes) => self.show_left(yes),
            Action::Locate(place) => {
                let lost = self.project.lost.clone();
                let open = self.project.files().map(Path::to_owned).collect();
                self.tasks.start(Task::locate(lost, place, open));
            }
            Action::Forget(at) => {
                if at < self.project.lost.len() {
                    self.change(|project| project.lost.remove(at));
                    self.prove();
                }
            }
            Action::Close => self.leave_for(Leaving::Close),
            Action::Stay => self.leaving = None,
            Action::Discard => self.leave(),
            Action::Cancel => {
                self.lanes.cancel();
                self.tasks.cancel();
            }
            Action::Notice(notice) => self.show_notice(notice),
            Action::Dismiss(at) => {
                if at < self.notices.len() {
                    self.notices.remove(at);
                }
            }
            Action::DismissAll => self.notices.clear(),
            Action::Prefer(preferences) => self.preferences = preferences,
        }
        self.follow();
    }

    /// Writes the files that wait for confirmation in [`Engine::replacing`] if `yes`; otherwise drops them.
    pub(super) fn replace(&mut self, yes: bool) {
        match self.replacing.take().filter(|_| yes) {
            None => {}
            Some((output, Doubt::IsThere)) => {
                self.save(Output { existing: Existing::Replace, ..output });
            }
            Some((output, Doubt::Undetermined(_))) => self.save_whole(output),
        }
    }

    pub(super) fn train(&mut self) {
        let learns = self.project.settings.regressor.learner().is_some();
        if learns && self.lane::<Train>().is_idle() {
            let train = self.training_of(Arc::clone(&self.project.recordings));
            self.lanes.of_mut(ANYONE).ask_again(train);
        }
    }

    /// Returns the request for a training with the present settings. The trained calibration is autosaved at once, even if
    /// the window is hidden.
    pub(super) fn training_of(&self, recordings: Arc<RecordingSet>) -> Train {
        let autosave = self.recovery.autosave();
        let request = self.request_of(recordings);
        let on_trained: OnTrained = Arc::new(move |request, calibration| {
            autosave.take_trained(&request.recordings, &request.settings, calibration);
        });
        Train { request, on_trained }
    }

    fn request_of(&self, recordings: Arc<RecordingSet>) -> Request {
        Request {
            datasets: self.datasets.clone(),
            ..Request::fit(recordings, self.project.settings.clone())
        }
    }

    pub(super) fn choose_block(&mut self, block: HistoryBlock, measure: Option<Measure>) {
        if self.lane::<ChooseBlock>().is_idle() {
            let request = self.request_of(Arc::clone(&self.project.recordings));
            self.lanes.of_mut(ANYONE).ask_again(ChooseBlock { block, measure, request });
        }
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

    pub(super) fn save(&mut self, mut output: Output) {
        for path in &mut output.paths {
            if let Ok(absolute) = std::path::absolute(&*path) {
                *path = absolute;
            }
        }
        let inputs = self.project.files().map(Path::to_owned).collect();
        self.tasks.start(Task::write(output, inputs));
    }

    pub(super) fn export(&mut self, mut paths: Vec<PathBuf>, existing: Existing) {
        let Some(content) = self.calibration_content() else {
            self.notice(Level::Error, "There is no calibration to export yet");
            return;
        };
        paths.retain(|path| {
            let unknown = known_target(path).err();
            let is_known = unknown.is_none();
            unknown.into_iter().for_each(|text| self.notice(Level::Error, text));
            is_known
        });
        let output = Output { content, paths, existing };
        // A calibration that comes with a request was fitted in this session, not read from a file.
        if let FileContent::Calibration(calibration, Some(_)) = &output.content
            && let Some(undetermined) = calibration.undetermined()
        {
            self.replacing = Some((output, Doubt::Undetermined(undetermined)));
        } else {
            self.save_whole(output);
        }
    }

    /// Writes the whole content to its files, with a warning for each file format that cannot hold a part of a calibration.
    pub(super) fn save_whole(&mut self, output: Output) {
        for caution in output.paths.iter().filter_map(|path| output.content.caution(path)) {
            self.notice(Level::Warning, caution);
        }
        self.save(output);
    }

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
            InTurn::SetRole(asked) => {
                let is_open = |file: &SessionFile| !self.project.lost.contains(file);
                let mut files = Session::of(&self.project, None).files;
                files.retain(is_open);
                Task::set_role(recordings, files, asked)
            }
            InTurn::Simulate(late) => Task::simulate(recordings, late),
        };
        self.tasks.begin(task, Some(turn));
    }

    /// Opens the import window for these files, one after another.
    pub(super) fn begin_import(&mut self, mut paths: Vec<PathBuf>) {
        if paths.is_empty() {
            return;
        }
        match &mut self.importing {
            Some(importing) => importing.waiting.extend(paths),
            None => {
                let path = paths.remove(0);
                let mut importing = Importing { path, waiting: paths, ..Importing::default() };
                let preview = importing.look(Known::Nothing);
                self.preview.ask_again(preview);
                self.importing = Some(importing);
            }
        }
    }

    /// Changes the state of the import window by `change`, and inspects the file again in the background.
    pub(super) fn inspect(&mut self, change: impl FnOnce(&mut Importing) -> Preview) {
        if let Some(importing) = &mut self.importing {
            let preview = change(importing);
            self.preview.ask_again(preview);
        }
    }

    fn import(&mut self, command: ImportCommand) {
        match command {
            ImportCommand::Open(path) => self.begin_import(vec![path]),
            ImportCommand::SetLayout(text) => self.inspect(|own| own.take_layout(text)),
            ImportCommand::SetMap(map) => self.inspect(|own| own.try_map(*map)),
            ImportCommand::Begin => self.inspect(|own| own.look(Known::Nothing)),
            ImportCommand::TakeMap(at) => {
                let map = self.preferences.maps.get(at).cloned();
                map.into_iter().for_each(|map| self.inspect(|own| own.take_map(map)));
            }
            ImportCommand::ReadMap(path) => self.tasks.start(Task::read_map(path)),
            ImportCommand::FindWeight => {
                if let Some(Importing { path, map, .. }) = &self.importing {
                    self.tasks.start(Task::find_weight(path.clone(), map.clone()));
                }
            }
            ImportCommand::WriteMap(path) => {
                let Some(Importing { map, .. }) = &self.importing else { return };
                let mut text = Vec::new();
                match map.write_json(&mut text) {
                    Ok(()) => self.save(Output {
                        content: FileContent::Bytes(text.into()),
                        paths: vec![path],
                        existing: Existing::Ask,
                    }),
                    Err(error) => self.notice(Level::Error, error.to_string()),
                }
            }
            ImportCommand::Load => {
                let Some(Importing { path, map, waiting, .. }) = self.importing.take() else {
                    return;
                };
                self.preferences.remember_map(&map);
                self.project.maps.insert(path.clone(), map);
                self.open([vec![path], waiting].concat());
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
