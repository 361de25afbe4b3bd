//! All of the program's state, and the one function that changes it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use crate::analysis::{Analysis, Request, View};
use crate::app::{
    Command, Comparison, Doubt, Effect, Existing, FactoryCalibration, FileContent, History,
    Importing, Leaving, LeftSession, Level, Mark, Notice, Opened, OpenedFile, Pane, Preferences,
    SessionFile, ThresholdStudy, TracesToWrite, Training,
};
use crate::calibration::{Calibration, FitSettings};
use crate::export::{target_endings, target_for};
use crate::features::{Distance, Thresholds};
use crate::recording::columns::ColumnMap;
use crate::recording::delimited::Loaded;
use crate::recording::{Axis, Entry, RecordingSet, Role};

/// A calibration that is applied instead of fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Applied {
    /// The file it came from.
    pub path: PathBuf,
    /// The calibration.
    pub calibration: Arc<Calibration>,
}

/// Everything the window shows, and nothing of how.
#[derive(Clone, Debug, Default)]
pub struct AppState {
    /// The recordings with their roles.
    pub recordings: Arc<RecordingSet>,
    /// The recordings before they were cut in time, while they are cut.
    pub unsplit: Option<Arc<RecordingSet>>,
    /// The first share of each recording that trains, while they are cut.
    pub cut: f64,
    /// The choices of the fit.
    pub settings: FitSettings,
    /// Which recordings are on screen.
    pub view: View,
    /// The panes that are on screen.
    pub on_screen: Vec<Pane>,
    /// Axes that are not shown.
    pub hidden_axes: Vec<Axis>,
    /// A calibration that is applied instead of fitted.
    pub applied: Option<Applied>,
    /// The matrix that the sensor came with, beside the one that is fitted.
    pub factory: Option<FactoryCalibration>,
    /// Networks and kernels.
    pub training: Training,
    /// Regressors side by side.
    pub comparison: Comparison,
    /// The choice of thresholds.
    pub study: ThresholdStudy,
    /// The last analysis that succeeded; stays on screen while the next one runs.
    pub analysis: Option<Arc<Analysis>>,
    /// Why the newest analysis failed.
    pub problem: Option<String>,
    /// Whether recordings were opened or closed since the built-in sensor was asked for.
    pub overtook_built_in: bool,
    /// What there is to say.
    pub notices: Vec<Notice>,
    /// A file that is there already, and what would be written into it.
    pub replacing: Option<(FileContent, PathBuf, Doubt)>,
    /// What waits for a path to be typed, with a suggested name.
    pub naming: Option<(FileContent, String)>,
    /// The file whose columns are being said.
    pub importing: Option<Importing>,
    /// The maps that files were read by.
    pub maps: BTreeMap<PathBuf, ColumnMap>,
    /// Free text that is saved with the session.
    pub notes: String,
    /// The session's file, if it has one.
    pub session: Option<PathBuf>,
    /// What the session held when it was saved or opened.
    pub saved: Option<Mark>,
    /// Files of the session that are not where they were.
    pub lost: Vec<SessionFile>,
    /// What the recordings of files that are being read are for.
    pub awaited_roles: BTreeMap<PathBuf, BTreeMap<String, Role>>,
    /// Autosaved sessions of windows that did not end as they should.
    pub recoverable: Vec<LeftSession>,
    /// What is to be done, once somebody has said what becomes of what is not saved.
    pub leaving: Option<Leaving>,
    /// What is remembered between runs.
    pub preferences: Preferences,
    /// The choices of before and after.
    pub history: History,
}

/// More notices than this are forgotten, oldest first.
const MOST_NOTICES: usize = 200;

impl AppState {
    /// Does what `command` asks.
    pub fn apply(&mut self, command: Command) -> Vec<Effect> {
        match command {
            Command::SetSettings(settings) => self.set_settings(settings),
            Command::SetRole(at, role) => self.change_recordings(|set| set.set_role(at, role)),
            Command::SetAllRoles(role) => self.change_recordings(|set| {
                for at in 0..set.entries().len() {
                    set.set_role(at, role);
                }
            }),
            Command::Tare(which, tare) => {
                vec![Effect::Tare(Arc::clone(&self.recordings), which, tare)]
            }
            Command::Tared(before, tared) => match tared {
                // Others have been opened meanwhile.
                _ if !Arc::ptr_eq(&before, &self.recordings) => Vec::new(),
                Ok(tared) => {
                    self.recordings = Arc::new(tared);
                    self.unsplit = None;
                    self.analyse()
                }
                Err(error) => {
                    self.tell(Notice::new(Level::Error, error));
                    Vec::new()
                }
            },
            Command::RemoveRecording(at) => self.remove(at),
            Command::CloseRecordings => self.close_recordings(),
            Command::Split(fraction) => self.split(fraction),
            Command::Unsplit => match self.unsplit.take() {
                Some(whole) => {
                    self.recordings = whole;
                    self.forget_results();
                    self.show_first_test()
                }
                None => Vec::new(),
            },
            Command::SetView(view) => {
                self.view = view;
                self.analyse()
            }
            Command::Wish(wish) => vec![Effect::Wish(wish)],
            Command::PanesOnScreen(panes) => {
                self.on_screen = panes;
                self.follow_study().into_iter().collect()
            }
            Command::ShowAxis(axis, shown) => {
                self.hidden_axes.retain(|hidden| *hidden != axis);
                if !shown {
                    self.hidden_axes.push(axis);
                }
                Vec::new()
            }
            Command::ChooseFiles => vec![Effect::AskForFiles],
            Command::OpenFiles(paths) if paths.is_empty() => Vec::new(),
            Command::OpenFiles(paths) => vec![self.read(paths)],
            Command::FilesOpened(files) => {
                let is_session =
                    |opened: &Result<Opened, String>| matches!(opened, Ok(Opened::Session(_)));
                match files.iter().any(|(_, opened)| is_session(opened)) {
                    true => self.leave_for(Leaving::Open(files)),
                    false => self.take_files(files),
                }
            }
            Command::OpenBuiltIn => {
                self.overtook_built_in = false;
                vec![Effect::Simulate]
            }
            Command::BuiltInReady(set) => self.take_built_in(set),
            Command::FitAgain => {
                self.applied = None;
                self.analyse()
            }
            Command::DropFactory => self.drop_factory(),
            Command::ChooseReport => {
                let content = FileContent::Report(Box::new(self.request()), self.notes.clone());
                vec![Effect::AskWhere(content, "report.html".to_owned())]
            }
            Command::ChooseTraces(visible) => match self.traces(visible) {
                Some(content) => vec![Effect::AskWhere(content, "traces.csv".to_owned())],
                None => Vec::new(),
            },
            Command::ChooseExport => match self.calibration() {
                Some(calibration) => {
                    let content = FileContent::Calibration(calibration, self.sources());
                    vec![Effect::AskWhere(content, "calibration.json".to_owned())]
                }
                None => self.nothing_to_export(),
            },
            Command::ChooseFileFor(content, name) => {
                vec![Effect::AskWhere(content, name.to_owned())]
            }
            Command::TypePathFor(content, name) => {
                self.naming = Some((content, name));
                Vec::new()
            }
            Command::PathTyped(path) => match (self.naming.take(), path) {
                (Some((FileContent::Calibration(..), _)), Some(path)) => {
                    self.export(path, Existing::Ask)
                }
                (Some((content, _)), Some(path)) => {
                    vec![Effect::Write(content, path, Existing::Ask)]
                }
                _ => Vec::new(),
            },
            Command::Export(path, existing) => self.export(path, existing),
            Command::Save(content, path, existing) => vec![Effect::Write(content, path, existing)],
            Command::AskToReplace(content, path) => {
                self.replacing = Some((content, path, Doubt::IsThere));
                Vec::new()
            }
            Command::Replace(yes) => match self.replacing.take() {
                Some((content, path, doubt)) if yes => {
                    let existing = match doubt {
                        Doubt::IsThere => Existing::Replace,
                        Doubt::Undetermined(_, existing) => existing,
                    };
                    vec![Effect::Write(content, path, existing)]
                }
                _ => Vec::new(),
            },
            Command::Saved(path, result) => {
                self.tell(match result {
                    Ok(()) => Notice::new(Level::Info, format!("Wrote {}", path.display())),
                    Err(error) => Notice::new(Level::Error, error),
                });
                Vec::new()
            }
            Command::Analysed(result) => {
                match result {
                    Ok(analysis) => {
                        self.analysis = Some(analysis);
                        self.problem = None;
                    }
                    Err(problem) => self.problem = Some(problem),
                }
                Vec::new()
            }
            Command::Tell(notice) => {
                self.tell(notice);
                Vec::new()
            }
            Command::DismissNotice(at) => {
                if at < self.notices.len() {
                    self.notices.remove(at);
                }
                Vec::new()
            }
            Command::DismissNotices => {
                self.notices.clear();
                Vec::new()
            }
            Command::SetPreferences(preferences) => {
                self.preferences = preferences;
                Vec::new()
            }
            Command::Restore(choices) => self.restore(choices),
            Command::Import(command) => self.apply_import(command),
            Command::Session(command) => self.apply_session(command),
            Command::Training(command) => self.apply_training(command),
            Command::Comparison(command) => self.apply_comparison(command),
            Command::Study(command) => self.apply_study(command),
            Command::Cancel => {
                if let Some((_, stopping)) = &mut self.training.running {
                    *stopping = true;
                }
                vec![Effect::CancelWork]
            }
            Command::Nothing => Vec::new(),
        }
    }

    /// The axes of the recordings or of the applied calibration.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        match &self.applied {
            Some(applied) => &applied.calibration.axes,
            None => &self.recordings.layout().axes,
        }
    }

    /// Whether an axis is shown.
    #[must_use]
    pub fn is_shown(&self, axis: Axis) -> bool {
        !self.hidden_axes.contains(&axis)
    }

    pub(super) fn set_settings(&mut self, settings: FitSettings) -> Vec<Effect> {
        if settings == self.settings {
            return Vec::new();
        }
        self.settings = settings;
        self.analyse()
    }

    fn change_recordings(&mut self, change: impl FnOnce(&mut RecordingSet)) -> Vec<Effect> {
        change(Arc::make_mut(&mut self.recordings));
        self.analyse()
    }

    fn remove(&mut self, at: usize) -> Vec<Effect> {
        let n_left = self.recordings.entries().len().saturating_sub(1);
        self.view = match self.view {
            View::One(shown) if shown > at => View::One(shown - 1),
            view => view.within(n_left),
        };
        // What the cut was made of no longer fits together.
        self.unsplit = None;
        match &mut self.analysis {
            Some(_) if n_left == 0 => self.analysis = None,
            // The results below move up with their recordings.
            Some(analysis) if at < analysis.recordings.len() => {
                Arc::make_mut(analysis).recordings.remove(at);
            }
            _ => {}
        }
        self.change_recordings(|set| set.remove(at))
    }

    pub(super) fn close_recordings(&mut self) -> Vec<Effect> {
        self.use_recordings(RecordingSet::default());
        self.overtook_built_in = true;
        self.applied = None;
        self.analysis = None;
        self.show_first_test()
    }

    /// Puts the built-in sensor in place of what is loaded, unless something else was opened while it was made.
    fn take_built_in(&mut self, set: RecordingSet) -> Vec<Effect> {
        if self.overtook_built_in {
            return Vec::new();
        }
        // A session that was just opened and asked for it is still the same.
        let is_saved =
            self.recordings.entries().is_empty() && self.saved.is_some() && !self.is_unsaved();
        // A calibration that was opened meanwhile is there to be applied to it.
        let applied = self.applied.take();
        self.use_recordings(set);
        self.analysis = None;
        if let Some(Applied { path, calibration }) = applied {
            self.take_calibration(path, calibration);
        }
        if is_saved {
            self.saved = Some(self.mark());
        }
        self.show_first_test()
    }

    /// Takes other recordings; what was chosen for the old ones' axes or made of them does not fit.
    fn use_recordings(&mut self, set: RecordingSet) {
        if set.layout().axes != self.recordings.layout().axes {
            self.settings.full_scale.clear();
        }
        self.recordings = Arc::new(set);
        self.unsplit = None;
        self.fit_factory();
    }

    /// The last analysis' results stand in the order of recordings that are no longer there.
    pub(super) fn forget_results(&mut self) {
        if let Some(analysis) = &mut self.analysis {
            Arc::make_mut(analysis).recordings.clear();
        }
    }

    /// Puts a test recording on screen: the first in which every axis moves, else the first, else any.
    fn show_first_test(&mut self) -> Vec<Effect> {
        let entries = self.recordings.entries();
        let first = |wanted: &dyn Fn(&Entry) -> bool| entries.iter().position(wanted);
        let is_test = |entry: &Entry| entry.role == Role::Test;
        let shown = first(&|entry| is_test(entry) && every_axis_moves(entry)).or(first(&is_test));
        self.view = View::One(shown.unwrap_or(0));
        self.analyse()
    }

    pub(super) fn split(&mut self, fraction: f64) -> Vec<Effect> {
        let whole = Arc::clone(self.unsplit.as_ref().unwrap_or(&self.recordings));
        let cut = whole.split(fraction);
        if !cut.entries().iter().any(|entry| entry.role == Role::Test) {
            self.tell(Notice::new(
                Level::Error,
                "There is nothing to cut: the recordings are off, have no reference, or are too short",
            ));
            return Vec::new();
        }
        self.unsplit = Some(whole);
        self.cut = fraction;
        self.recordings = Arc::new(cut);
        self.forget_results();
        self.show_first_test()
    }

    pub(super) fn take_files(&mut self, files: Vec<OpenedFile>) -> Vec<Effect> {
        let mut loaded = Vec::new();
        let mut calibration = None;
        let mut session = None;
        let mut factory = None;
        let mut to_import = Vec::new();
        let mut by_remembered = Vec::new();
        for (path, opened) in files {
            if opened.is_ok() {
                self.preferences.remember(&path);
            }
            match opened {
                Ok(Opened::Recordings(recordings, map)) => {
                    if let Some(map) = map {
                        if self.maps.get(&path) != Some(&*map) {
                            by_remembered.push((path.clone(), (*map).clone()));
                        }
                        self.maps.insert(path, *map);
                    }
                    loaded.push(recordings);
                }
                Ok(Opened::Calibration(found)) => calibration = Some((path, found)),
                Ok(Opened::Factory(found)) => factory = Some((path, found)),
                Ok(Opened::Session(opened)) => session = Some((path, *opened)),
                Ok(Opened::WantsMap(reason)) => {
                    log::info!("{reason}");
                    to_import.push(path);
                }
                Err(error) => self.tell(Notice::new(Level::Error, error)),
            }
        }
        self.tell_remembered(by_remembered);
        let mut effects = self.import(to_import);
        if let Some((path, opened)) = session {
            effects.extend(self.take_session(Some(path), opened));
        }
        let mut changed = self.take_recordings(loaded);
        if let Some((path, calibration)) = calibration {
            changed |= self.take_calibration(path, calibration);
        }
        if changed {
            effects.extend(self.analyse());
        }
        if let Some((path, calibration)) = factory {
            effects.extend(self.take_factory(path, &calibration));
        }
        effects
    }

    pub(super) fn take_recordings(&mut self, loaded: Vec<Loaded>) -> bool {
        // The built-in sensor was there so that there was something to see; real recordings take its place.
        let replaces = self.recordings.is_simulated();
        let mut set = if replaces {
            RecordingSet::default()
        } else {
            RecordingSet::clone(&self.recordings)
        };
        let before = set.entries().len();
        for Loaded {
            recordings,
            warnings,
        } in loaded
        {
            for warning in warnings {
                self.tell(Notice::new(Level::Warning, warning.to_string()));
            }
            for recording in recordings {
                if let Err(error) = set.push(Entry::with_default_role(recording)) {
                    self.tell(Notice::new(Level::Error, error.to_string()));
                    break; // the other runs of this file have the same columns
                }
            }
        }
        let added = set.entries().len() > before;
        self.give_awaited_roles(&mut set);
        if added {
            // Keep an applied calibration: opening recordings to apply it to is what it is for.
            self.use_recordings(set);
            self.overtook_built_in = true;
            self.view = View::One(before);
            if replaces {
                self.analysis = None;
            }
            let axes = &self.recordings.layout().axes;
            if !axes.is_empty()
                && self.settings.features.distance.effective(axes)
                    != self.settings.features.distance
            {
                self.settings.features.distance = Distance::FullScale;
                for thresholds in &mut self.settings.features.look_backs {
                    *thresholds = Thresholds::default_for(Distance::FullScale);
                }
            }
        }
        added
    }

    fn take_calibration(&mut self, path: PathBuf, calibration: Arc<Calibration>) -> bool {
        let gauges = &self.recordings.layout().gauge_names;
        if !gauges.is_empty() && *gauges != calibration.gauges {
            self.tell(Notice::new(
                Level::Error,
                format!(
                    "{}: made for the gauges {}, while the loaded recordings have {}; open recordings of that sensor first",
                    path.display(),
                    calibration.gauges.join(" "),
                    gauges.join(" "),
                ),
            ));
            return false;
        }
        self.applied = Some(Applied { path, calibration });
        true
    }

    /// The calibration that an export writes. An applied one leaves as it came, not with the scores it has here.
    fn calibration(&self) -> Option<Arc<Calibration>> {
        let analysis = self.analysis.as_ref()?;
        let applied = self.applied.as_ref().map(|applied| &applied.calibration);
        Some(Arc::clone(applied.unwrap_or(&analysis.calibration)))
    }

    /// What the exported calibration was fitted to, if it was fitted here.
    fn sources(&self) -> Option<Arc<RecordingSet>> {
        self.applied.is_none().then(|| Arc::clone(&self.recordings))
    }

    fn nothing_to_export(&mut self) -> Vec<Effect> {
        let text = "There is no calibration to export yet";
        self.tell(Notice::new(Level::Error, text));
        Vec::new()
    }

    fn export(&mut self, path: PathBuf, existing: Existing) -> Vec<Effect> {
        let Some(calibration) = self.calibration() else {
            return self.nothing_to_export();
        };
        if target_for(&path).is_none() {
            self.tell(Notice::new(
                Level::Error,
                format!(
                    "{}: the ending says no format; use one of {}",
                    path.display(),
                    target_endings()
                ),
            ));
            return Vec::new();
        }
        let fitted = self.applied.is_none();
        let undetermined = calibration.undetermined().filter(|_| fitted);
        let content = FileContent::Calibration(calibration, self.sources());
        if let Some(undetermined) = undetermined {
            self.replacing = Some((content, path, Doubt::Undetermined(undetermined, existing)));
            return Vec::new();
        }
        vec![Effect::Write(content, path, existing)]
    }

    pub(super) fn analyse(&mut self) -> Vec<Effect> {
        self.problem = None;
        self.comparison.follow(&self.settings);
        let study = self.follow_study();
        let analyse = Effect::Analyse(self.request());
        std::iter::once(analyse).chain(study).collect()
    }

    /// What is to be analysed.
    fn request(&self) -> Request {
        let trained = self.training.fitting(self);
        let trained = trained.filter(|_| self.applied.is_none()).cloned();
        let applied = self.applied.as_ref().map(|applied| &applied.calibration);
        let factory = self.factory.as_ref().map(|factory| &factory.calibration);
        Request {
            recordings: Arc::clone(&self.recordings),
            settings: self.settings.clone(),
            view: self.view,
            trained: trained.is_some(),
            calibration: applied.cloned().or(trained),
            factory: factory.cloned(),
        }
    }

    /// The traces on screen as a file's content.
    fn traces(&self, visible: Option<(f64, f64)>) -> Option<FileContent> {
        let analysis = self.analysis.as_ref()?;
        Some(FileContent::Traces(Box::new(TracesToWrite {
            calibration: Arc::clone(&analysis.calibration),
            recordings: Arc::clone(&self.recordings),
            decimation: self.settings.decimation,
            traces: Arc::clone(&analysis.traces),
            visible,
        })))
    }

    pub(super) fn tell(&mut self, notice: Notice) {
        let level = match notice.level {
            Level::Info => log::Level::Info,
            Level::Warning => log::Level::Warn,
            Level::Error => log::Level::Error,
        };
        log::log!(level, "{}", notice.text);
        self.notices.push(notice);
        let surplus = self.notices.len().saturating_sub(MOST_NOTICES);
        self.notices.drain(..surplus);
    }
}

fn every_axis_moves(entry: &Entry) -> bool {
    let n_axes = entry.recording.axes().len();
    let mut samples = entry.recording.loads().chunks_exact(n_axes.max(1));
    let Some(first) = samples.next() else {
        return false;
    };
    let mut moves = vec![false; n_axes];
    for sample in samples {
        for axis in 0..n_axes {
            moves[axis] |= sample[axis] != first[axis];
        }
    }
    moves.into_iter().all(|moves| moves)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::analysis::{Analysis, analyse};
    use crate::app::{ImportCommand, KnownOf};
    use crate::progress::Progress;
    use crate::recording::delimited::{Finding, LoadWarning};
    use crate::recording::{Recording, Source};

    const FORCES: [Axis; 3] = [Axis::Fx, Axis::Fy, Axis::Fz];

    /// A recording whose gauges are a mixture of its loads, none of which stands still.
    fn recording(name: &str, source: Source, gauges: &[&str], axes: &[Axis]) -> Recording {
        let n = 40;
        let load = |k: usize, axis: usize| (0.4 * k as f64 * (axis + 1) as f64).sin() * 5.0;
        let gauge = |k: usize, gauge: usize| {
            let mixed = (0..3).map(|axis| load(k, axis) / (1 + gauge + axis) as f64);
            mixed.sum::<f64>() + 0.01 * (k * k % 7) as f64
        };
        let table = |width: usize, value: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..n * width)
                .map(|at| value(at / width, at % width))
                .collect()
        };
        Recording::new(
            name,
            source,
            (0..n).map(|k| k as f64 / 20.0).collect(),
            gauges.iter().map(|&gauge| gauge.to_owned()).collect(),
            table(gauges.len(), &gauge),
            axes.to_vec(),
            table(axes.len(), &load),
        )
        .unwrap()
    }

    fn of_file(name: &str, gauges: &[&str], axes: &[Axis]) -> Command {
        let path = PathBuf::from(name);
        let recording = recording(name, Source::File(path.clone()), gauges, axes);
        let loaded = Loaded {
            recordings: vec![recording],
            warnings: Vec::new(),
        };
        Command::FilesOpened(vec![(path, Ok(Opened::Recordings(loaded, None)))])
    }

    /// Training recordings `a` and `b` and the test recording `test`, all from files.
    fn with_files() -> AppState {
        let mut state = AppState::default();
        for name in ["a", "b", "test"] {
            state.apply(of_file(name, &["S1", "S2", "S3"], &FORCES));
        }
        state
    }

    fn built_in() -> RecordingSet {
        let mut set = RecordingSet::default();
        for name in ["train", "test"] {
            let recording = recording(name, Source::Simulated, &["S1", "S2", "S3"], &FORCES);
            set.push(Entry::with_default_role(recording)).unwrap();
        }
        set
    }

    fn with_built_in() -> AppState {
        let mut state = AppState::default();
        state.apply(Command::OpenBuiltIn);
        state.apply(Command::BuiltInReady(built_in()));
        state
    }

    fn names(state: &AppState) -> Vec<&str> {
        let entries = state.recordings.entries().iter();
        entries.map(|entry| entry.recording.name()).collect()
    }

    fn roles(state: &AppState) -> Vec<Role> {
        let entries = state.recordings.entries().iter();
        entries.map(|entry| entry.role).collect()
    }

    /// The one effect, which is to analyse.
    #[track_caller]
    fn request(effects: Vec<Effect>) -> Request {
        match <[Effect; 1]>::try_from(effects) {
            Ok([Effect::Analyse(request)]) => request,
            other => panic!("not one Analyse: {other:?}"),
        }
    }

    /// Does what an `Analyse` effect asks.
    #[track_caller]
    fn analyse_now(state: &mut AppState, effects: Vec<Effect>) -> Arc<Analysis> {
        let analysis = Arc::new(analyse(&request(effects), &Progress::default()).unwrap());
        state.apply(Command::Analysed(Ok(Arc::clone(&analysis))));
        analysis
    }

    fn fitted(state: &mut AppState) -> Arc<Analysis> {
        let effects = state.apply(Command::FitAgain);
        analyse_now(state, effects)
    }

    fn opened(calibration: &Arc<Calibration>) -> Command {
        let calibration = Opened::Calibration(Arc::clone(calibration));
        Command::FilesOpened(vec![("c.json".into(), Ok(calibration))])
    }

    #[track_caller]
    fn last_notice(state: &AppState, level: Level, part: &str) {
        let notice = state.notices.last().expect("a notice");
        assert_eq!(notice.level, level);
        assert!(notice.text.contains(part), "{}", notice.text);
    }

    #[test]
    fn other_settings_ask_for_one_analysis_and_the_same_for_none() {
        let mut state = with_files();
        let mut settings = state.settings.clone();
        assert!(
            state
                .apply(Command::SetSettings(settings.clone()))
                .is_empty()
        );
        settings.features.look_backs[0].f_th = 1.5;
        let request = request(state.apply(Command::SetSettings(settings.clone())));
        assert_eq!(request.settings, settings);
        assert_eq!(state.settings, settings);
    }

    #[test]
    fn roles_change_one_by_one_and_all_at_once() {
        let mut state = with_files();
        assert_eq!(roles(&state), [Role::Train, Role::Train, Role::Test]);
        let before = Arc::clone(&state.recordings);
        let request = request(state.apply(Command::SetRole(1, Role::Off)));
        assert_eq!(request.recordings.entries()[1].role, Role::Off);
        assert_eq!(
            before.entries()[1].role,
            Role::Train,
            "work goes on with what it was given"
        );
        state.apply(Command::SetAllRoles(Role::Test));
        assert_eq!(roles(&state), [Role::Test; 3]);
    }

    #[test]
    fn removing_keeps_the_same_recording_on_screen_or_the_last_one() {
        let mut state = with_files();
        state.apply(Command::SetView(View::One(2)));
        state.apply(Command::RemoveRecording(0));
        assert_eq!(
            (state.view, names(&state)),
            (View::One(1), vec!["b", "test"])
        );
        let request = request(state.apply(Command::RemoveRecording(1)));
        assert_eq!((state.view, request.view), (View::One(0), View::One(0)));
        state.apply(Command::RemoveRecording(0));
        assert_eq!((state.view, names(&state).len()), (View::One(0), 0));
    }

    #[test]
    fn results_move_up_with_their_recordings_when_one_is_removed() {
        let mut state = with_files();
        let all = fitted(&mut state).recordings.clone();
        state.apply(Command::RemoveRecording(0));
        assert_eq!(state.analysis.as_ref().unwrap().recordings, all[1..]);
        state.apply(Command::RemoveRecording(0));
        state.apply(Command::RemoveRecording(0));
        assert!(state.analysis.is_none());
    }

    #[test]
    fn a_cut_can_be_changed_and_taken_back() {
        let mut state = with_files();
        let whole = Arc::clone(&state.recordings);
        fitted(&mut state);
        let samples = |state: &AppState| -> Vec<usize> {
            let entries = state.recordings.entries().iter();
            entries.map(|entry| entry.recording.n_samples()).collect()
        };
        let request = request(state.apply(Command::Split(0.5)));
        assert_eq!(request.recordings.entries().len(), 6);
        assert_eq!(state.view, View::One(1), "the first rest tests");
        assert!(state.analysis.as_ref().unwrap().recordings.is_empty());
        state.apply(Command::Split(0.25));
        assert_eq!(
            samples(&state),
            [10, 30, 10, 30, 10, 30],
            "of the whole, not of the halves"
        );
        state.apply(Command::Unsplit);
        assert!(Arc::ptr_eq(&state.recordings, &whole));
        assert!(state.unsplit.is_none());
        assert!(state.apply(Command::Unsplit).is_empty());
    }

    #[test]
    fn choices_of_another_moment_come_back_with_roles_cuts_and_closed_recordings() {
        let mut state = with_files();
        fitted(&mut state);
        let before = state.choices();
        state.apply(Command::SetRole(0, Role::Off));
        let mut settings = state.settings.clone();
        settings.offset = false;
        state.apply(Command::SetSettings(settings));
        let off = state.choices();
        assert_ne!(before, off);
        state.apply(Command::RemoveRecording(0));
        state.apply(Command::Split(0.5));
        let request = request(state.apply(Command::Restore(off.clone())));
        assert_eq!(roles(&state), [Role::Off, Role::Train, Role::Test]);
        assert!(!request.settings.offset && state.unsplit.is_none());
        assert!(state.choices() == off);
        state.apply(Command::Restore(before.clone()));
        assert!(state.settings.offset && state.choices() == before);
        assert_eq!(roles(&state), [Role::Train, Role::Train, Role::Test]);
    }

    #[test]
    fn a_cut_that_leaves_nothing_to_test_changes_nothing() {
        let mut state = with_files();
        state.apply(Command::SetRole(2, Role::Off));
        state.apply(Command::Split(0.5));
        let (cut, whole) = (Arc::clone(&state.recordings), state.unsplit.clone());
        assert!(state.apply(Command::Split(0.001)).is_empty());
        last_notice(&state, Level::Error, "nothing to cut");
        assert!(Arc::ptr_eq(&state.recordings, &cut));
        assert_eq!(state.unsplit, whole, "the cut can still be taken back");
    }

    #[test]
    fn real_recordings_take_the_place_of_simulated_ones() {
        let mut state = with_built_in();
        fitted(&mut state);
        let request = request(state.apply(of_file("a", &["G1", "G2"], &[Axis::Fz])));
        assert_eq!((names(&state), request.view), (vec!["a"], View::One(0)));
        assert!(
            state.analysis.is_none(),
            "what was fitted to the simulated ones is gone"
        );
        state.apply(of_file("test", &["G1", "G2"], &[Axis::Fz]));
        assert_eq!(
            (names(&state), state.view),
            (vec!["a", "test"], View::One(1))
        );
    }

    #[test]
    fn the_built_in_sensor_replaces_what_is_loaded_but_not_what_was_opened_while_it_was_made() {
        let mut state = with_files();
        let effects = state.apply(Command::OpenBuiltIn);
        assert!(matches!(effects[..], [Effect::Simulate]));
        request(state.apply(Command::BuiltInReady(built_in())));
        assert!(state.recordings.is_simulated());
        assert_eq!(state.view, View::One(1), "its test recording");

        state.apply(Command::OpenBuiltIn);
        state.apply(of_file("a", &["S1"], &[Axis::Fz]));
        assert!(state.apply(Command::BuiltInReady(built_in())).is_empty());
        assert_eq!(names(&state), ["a"]);
    }

    #[test]
    fn a_calibration_opened_before_the_built_in_sensor_is_ready_is_applied_to_it() {
        let calibration = fitted(&mut with_built_in()).calibration.clone();
        let mut state = AppState::default();
        state.apply(Command::OpenBuiltIn);
        state.apply(opened(&calibration));
        let request = request(state.apply(Command::BuiltInReady(built_in())));
        assert_eq!(request.calibration, Some(calibration));
        assert!(state.notices.is_empty());
    }

    #[test]
    fn other_gauges_are_refused_and_nothing_is_lost() {
        let mut state = with_files();
        let analysis = fitted(&mut state);
        let before = Arc::clone(&state.recordings);
        let effects = state.apply(of_file("other", &["G1"], &FORCES));
        assert!(effects.is_empty());
        last_notice(&state, Level::Error, "other: its gauges are G1");
        assert!(Arc::ptr_eq(&state.recordings, &before));
        assert!(Arc::ptr_eq(state.analysis.as_ref().unwrap(), &analysis));
    }

    #[test]
    fn a_file_that_failed_leaves_what_is_loaded_and_what_came_with_it() {
        for mut state in [with_files(), with_built_in()] {
            let before = Arc::clone(&state.recordings);
            let failed = vec![("x".into(), Err("x: cannot be read".to_owned()))];
            assert!(state.apply(Command::FilesOpened(failed)).is_empty());
            last_notice(&state, Level::Error, "x: cannot be read");
            assert!(Arc::ptr_eq(&state.recordings, &before));
        }
        let mut state = with_files();
        let Command::FilesOpened(mut files) = of_file("c", &["S1", "S2", "S3"], &FORCES) else {
            unreachable!()
        };
        files.insert(0, ("x".into(), Err("x: cannot be read".to_owned())));
        request(state.apply(Command::FilesOpened(files)));
        assert_eq!(names(&state), ["a", "b", "test", "c"]);
        assert_eq!(state.notices.len(), 1);
    }

    #[test]
    fn warnings_of_a_file_become_notices() {
        let mut state = AppState::default();
        let Command::FilesOpened(mut files) = of_file("a", &["S1"], &[Axis::Fz]) else {
            unreachable!()
        };
        let Ok(Opened::Recordings(loaded, None)) = &mut files[0].1 else {
            unreachable!()
        };
        loaded.warnings.push(LoadWarning {
            path: "a.csv".into(),
            first_line: 3,
            last_line: 3,
            count: 1,
            finding: Finding::EmptyCell {
                column: 2,
                name: "S1".to_owned(),
            },
        });
        state.apply(Command::FilesOpened(files));
        last_notice(&state, Level::Warning, "a.csv");
    }

    #[test]
    fn a_calibration_is_applied_until_fit_again() {
        let mut state = with_files();
        let calibration = fitted(&mut state).calibration.clone();
        let effects = state.apply(opened(&calibration));
        assert_eq!(state.applied.as_ref().unwrap().path, Path::new("c.json"));
        assert!(!analyse_now(&mut state, effects).fitted);

        state.apply(of_file("c", &["S1", "S2", "S3"], &FORCES));
        assert!(state.applied.is_some(), "also to what is opened later");

        let effects = state.apply(Command::FitAgain);
        assert!(state.applied.is_none());
        assert!(analyse_now(&mut state, effects).fitted);
    }

    #[test]
    fn a_calibration_of_other_gauges_is_refused() {
        let mut state = with_files();
        let mut calibration = Calibration::clone(&fitted(&mut state).calibration);
        calibration.gauges[0] = "G1".to_owned();
        assert!(state.apply(opened(&Arc::new(calibration))).is_empty());
        last_notice(&state, Level::Error, "G1");
        assert!(state.applied.is_none());
    }

    #[test]
    fn export_needs_an_analysis_and_an_ending_that_says_the_format() {
        let mut state = with_files();
        assert!(
            state
                .apply(Command::Export("c.json".into(), Existing::Ask))
                .is_empty()
        );
        last_notice(&state, Level::Error, "no calibration");
        let analysis = fitted(&mut state);
        assert!(
            state
                .apply(Command::Export("c.xlsx".into(), Existing::Ask))
                .is_empty()
        );
        last_notice(&state, Level::Error, "c.xlsx");
        for path in ["c.json", "c.CSV"] {
            let effects = state.apply(Command::Export(path.into(), Existing::Ask));
            let [Effect::Write(FileContent::Calibration(calibration, _), to, _)] = &effects[..]
            else {
                panic!("not one Write: {effects:?}");
            };
            assert_eq!(
                (calibration, to.as_path()),
                (&analysis.calibration, Path::new(path))
            );
        }
        assert_eq!(state.notices.len(), 2);
    }

    #[test]
    fn an_applied_calibration_is_exported_unchanged() {
        let mut state = with_files();
        let calibration = fitted(&mut state).calibration.clone();
        let effects = state.apply(opened(&calibration));
        analyse_now(&mut state, effects);
        let effects = state.apply(Command::SetRole(0, Role::Test));
        let rescored = analyse_now(&mut state, effects);
        assert_ne!(rescored.calibration.quality, calibration.quality);
        let effects = state.apply(Command::Export("d.json".into(), Existing::Ask));
        let [Effect::Write(FileContent::Calibration(written, _), ..)] = &effects[..] else {
            panic!("not one Write: {effects:?}");
        };
        assert_eq!(*written, calibration);
    }

    #[test]
    fn the_end_of_writing_is_told() {
        let mut state = AppState::default();
        state.apply(Command::Saved("c.json".into(), Ok(())));
        last_notice(&state, Level::Info, "c.json");
        state.apply(Command::Saved("c.json".into(), Err("disk full".to_owned())));
        last_notice(&state, Level::Error, "disk full");
    }

    #[test]
    fn moments_alone_are_measured_over_full_scale() {
        let mut state = AppState::default();
        let moments = &[Axis::Mx, Axis::My];
        let request = request(state.apply(of_file("a", &["S1", "S2"], moments)));
        assert_eq!(request.settings.features.distance, Distance::FullScale);
        let default = Thresholds::default_for(Distance::FullScale);
        assert_eq!(request.settings.features.look_backs, [default]);
    }

    #[test]
    fn full_scales_are_forgotten_with_the_axes_they_were_entered_for() {
        let mut state = with_built_in();
        state.settings.full_scale = vec![None, Some(12.0), None];
        state.apply(of_file("a", &["S1", "S2", "S3"], &FORCES));
        assert_eq!(state.settings.full_scale.len(), 3, "the same axes");
        state.apply(Command::CloseRecordings);
        let effects = state.apply(of_file("b", &["S1"], &[Axis::Fz]));
        analyse_now(&mut state, effects);
        assert!(state.settings.full_scale.is_empty());
    }

    #[test]
    fn a_failed_analysis_keeps_the_last_one_and_says_why() {
        let mut state = with_files();
        let analysis = fitted(&mut state);
        state.apply(Command::Analysed(Err("no".to_owned())));
        assert_eq!(state.problem.as_deref(), Some("no"));
        assert!(Arc::ptr_eq(state.analysis.as_ref().unwrap(), &analysis));
        fitted(&mut state);
        assert_eq!(state.problem, None);
    }

    #[test]
    fn closing_leaves_nothing_of_the_recordings() {
        let mut state = with_files();
        let calibration = fitted(&mut state).calibration.clone();
        state.apply(opened(&calibration));
        state.apply(Command::CloseRecordings);
        assert!(state.recordings.entries().is_empty());
        assert!(state.analysis.is_none() && state.applied.is_none());
    }

    #[test]
    fn axes_are_hidden_and_shown_again() {
        let mut state = with_files();
        for _ in 0..2 {
            state.apply(Command::ShowAxis(Axis::Fy, false));
            let shown: Vec<bool> = state
                .axes()
                .iter()
                .map(|axis| state.is_shown(*axis))
                .collect();
            assert_eq!(shown, [true, false, true]);
        }
        state.apply(Command::ShowAxis(Axis::Fy, true));
        assert!(state.is_shown(Axis::Fy));
    }

    #[test]
    fn notices_are_capped_oldest_first_and_can_be_dismissed() {
        let mut state = AppState::default();
        for at in 0..MOST_NOTICES + 5 {
            state.apply(Command::Tell(Notice::new(Level::Info, at.to_string())));
        }
        assert_eq!(state.notices.len(), MOST_NOTICES);
        assert_eq!(state.notices[0].text, "5");
        state.apply(Command::DismissNotice(1));
        assert_eq!(state.notices[1].text, "7");
        state.apply(Command::DismissNotice(MOST_NOTICES));
        assert_eq!(state.notices.len(), MOST_NOTICES - 1);
        state.apply(Command::DismissNotices);
        assert!(state.notices.is_empty());
    }

    #[test]
    fn a_file_that_is_there_is_replaced_only_after_a_yes() {
        let mut state = AppState::default();
        let content = || FileContent::Bytes(Arc::from(*b"x"));
        for yes in [false, true] {
            state.apply(Command::AskToReplace(content(), "a.png".into()));
            assert!(state.replacing.is_some());
            let effects = state.apply(Command::Replace(yes));
            let writes = matches!(effects[..], [Effect::Write(.., Existing::Replace)]);
            assert_eq!(writes, yes);
            assert!(state.replacing.is_none());
        }
    }

    #[test]
    fn a_fit_to_fewer_samples_than_coefficients_is_exported_only_after_a_yes() {
        let mut state = with_files();
        let mut analysis = Analysis::clone(&fitted(&mut state));
        Arc::make_mut(&mut analysis.calibration).quality.n_train = 3;
        state.analysis = Some(Arc::new(analysis));
        let export = Command::Export("c.json".into(), Existing::Ask);
        assert!(state.apply(export).is_empty());
        let effects = state.apply(Command::Replace(true));
        let writes = matches!(effects[..], [Effect::Write(.., Existing::Ask)]);
        assert!(
            writes,
            "a file that is there is still asked about: {effects:?}"
        );
    }

    #[test]
    fn a_file_whose_columns_must_be_said_is_imported_and_its_map_remembered() {
        let mut state = with_files();
        let wants = |path: &str| (path.into(), Ok(Opened::WantsMap("no names".to_owned())));
        let effects = state.apply(Command::FilesOpened(vec![wants("x"), wants("y")]));
        assert!(
            matches!(&effects[..], [Effect::Inspect(path, KnownOf::Nothing)] if path == Path::new("x"))
        );
        let mut map = ColumnMap::default();
        map.table.shape.columns = 3;
        let import = |command| Command::Import(command);
        let effects = state.apply(import(ImportCommand::SetMap(Box::new(map.clone()))));
        assert!(matches!(
            &effects[..],
            [Effect::Inspect(_, KnownOf::Map(_))]
        ));
        let effects = state.apply(import(ImportCommand::Load));
        let [Effect::Read(files, remembered)] = &effects[..] else {
            panic!("not read: {effects:?}");
        };
        assert_eq!(
            files[..],
            [("x".into(), Some(map.clone())), ("y".into(), None)]
        );
        assert_eq!(
            remembered[..],
            [map.clone()],
            "y is read by it if it has the same shape"
        );
        assert!(state.importing.is_none());
        assert_eq!(state.preferences.maps, [map]);
    }

    #[test]
    fn wishes_for_dialogs_files_and_a_stop_are_passed_on() {
        let mut state = AppState::default();
        let mut effect = |command| state.apply(command);
        assert!(matches!(
            effect(Command::ChooseFiles)[..],
            [Effect::AskForFiles]
        ));
        assert!(
            effect(Command::ChooseExport).is_empty(),
            "nothing is fitted yet"
        );
        assert!(matches!(effect(Command::Cancel)[..], [Effect::CancelWork]));
        assert!(effect(Command::OpenFiles(Vec::new())).is_empty());
        let effects = effect(Command::OpenFiles(vec!["a".into()]));
        assert!(matches!(&effects[..], [Effect::Read(files, _)] if files[0].0 == Path::new("a")));
    }
}
