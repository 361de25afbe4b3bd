//! The program behind the window: the document with its undo, the questions about it, and what is done with files.
//!
//! Guarantees: only [`Engine::act`] changes the document, and each edit is one step of undo; what is shown follows the document
//! by itself ([`Engine::follow`]); wrong files lose nothing that is loaded.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use crate::calibration::{Calibration, FitSettings};
use crate::engine::files::{Opened, OpenedFile};
use crate::engine::importing;
use crate::engine::importing::ImportCommand;
use crate::engine::importing::{Importing, Preview};
use crate::engine::lanes::Lanes;
use crate::engine::live::{Current, Follow, Followed};
use crate::engine::models::{ModelChange, Models};
use crate::engine::notice::{Level, Notice};
use crate::engine::preferences::Preferences;
use crate::engine::project::SessionFile;
use crate::engine::project::{Edit, FromFile, Project, Split};
use crate::engine::query::{Background, Lane, LaneEvent, Notify, Running};
use crate::engine::recovery::{LeftSession, Recovery, Unsaved, drop_left};
use crate::engine::saving::{Doubt, Existing, FileContent, TracesToWrite};
use crate::engine::session::{OpenedSession, Session, SessionPart, add_parts, trained_beside};
use crate::engine::task::{Done, Task};
use crate::engine::undo::History;
use crate::export::{target_endings, target_for};
use crate::features::{Distance, Thresholds};
use crate::finding::Face;
use crate::import::map::ColumnMap;
use crate::questions::check::faulty::{FaultyRecording, FindFaults};
use crate::questions::errors::asked::Analyse;
use crate::questions::loops::asked::{AskFigures, AskLoops};
use crate::questions::loops::{LookRequest, Question};
use crate::questions::models::asked::{Compare, FindBest, OnTrained, Train, Trained};
use crate::questions::page::ReportRequest;
use crate::questions::question::Query;
use crate::questions::thresholds::Measure;
use crate::questions::thresholds::asked::ChooseBlock;
use crate::questions::{Analysis, Datasets, HistoryBlock, RecordingResult, Request, Search, View};
use crate::recording::{Entry, Recording, RecordingSet, Role, Tare};
use crate::scoring::numbers::significant;

/// Files with the maps that they are read by.
type Files = Vec<(PathBuf, Option<ColumnMap>)>;

/// A task that was begun.
struct Begun {
    is_seen: bool,
    /// What waited for its turn, if it did.
    turn: Option<InTurn>,
    lane: Lane<Task>,
}

/// What makes recordings is done one after another: each begins with what the one before it made, and many long recordings at
/// once would not be in memory.
#[derive(Clone)]
enum InTurn {
    Read(Files),
    /// By recordings, not by places, which may move while it waits.
    Tare(Vec<Arc<Recording>>, Tare),
    LeaveOutFaulty,
    Simulate,
}

impl InTurn {
    fn files(&self) -> &[(PathBuf, Option<ColumnMap>)] {
        match self {
            Self::Read(files) => files,
            _ => &[],
        }
    }
}

/// More notices than this are forgotten, oldest first.
pub(super) const MAX_NOTICES: usize = 200;

/// Something to do.
#[derive(Clone, Debug)]
pub enum Action {
    /// Change the document.
    Edit(Edit),
    /// Take the last edit back.
    Undo,
    /// Make it again.
    Redo,
    /// Put these recordings on screen.
    Show(View),
    /// Open recordings, calibrations, a session, or folders of them.
    Open(Vec<PathBuf>),
    /// Open the built-in simulated sensor instead of what is loaded.
    OpenBuiltIn,
    /// Tare these recordings.
    Tare(Vec<usize>, Tare),
    /// Leave what is faulty out of all recordings.
    LeaveOutFaulty,
    /// Write a file.
    Save(FileContent, PathBuf, Existing),
    /// Write the calibration.
    Export(PathBuf, Existing),
    /// The answer to [`Engine::replacing`]: write it, or leave it.
    Replace(bool),
    /// Train what the settings ask for.
    Train,
    /// Stop training; a network keeps the best it had.
    StopTraining,
    /// Choose a block's numbers by cross-validation; whose errors count, if that was chosen.
    ChooseBlock(HistoryBlock, Option<Measure>),
    /// Try sensible models and propose one; begin none after this time.
    FindBest(Duration),
    /// Fit all that the paper compares.
    ComparePaper,
    /// Follow a file that a logger writes.
    Follow(PathBuf),
    /// Do not follow it any more.
    StopFollowing,
    /// Stop trying models; those that are there stay.
    StopTrying,
    /// Put what is shown on the list of models.
    KeepModel,
    /// Change a row of the list of models.
    Model(u64, ModelChange),
    /// Take the settings of this row of the list of models.
    BringBack(u64),
    /// What concerns files whose columns have to be said.
    Import(ImportCommand),
    /// Restore this autosaved session of a window that did not close as it should.
    Restore(PathBuf),
    /// Forget it.
    DropLeft(PathBuf),
    /// Show what other windows left, or do not ask about it now: it stays where it is.
    ShowLeft(bool),
    /// This is one of the session's files that are not where they were, or the folder that they are in now.
    Locate(PathBuf),
    /// Go on without this one of them.
    Forget(usize),
    /// Close the window.
    Close,
    /// What is not saved is to stay on screen.
    Stay,
    /// Do what waits for an answer, whatever is not saved.
    Discard,
    /// Stop background work.
    Cancel,
    /// Something to tell.
    Tell(Notice),
    /// Take notice `n` away.
    Dismiss(usize),
    /// Take all notices away.
    DismissAll,
    /// What is remembered of a person has changed.
    Prefer(Preferences),
}

/// What takes everything away that is loaded, so that somebody is asked first whether to save it.
#[derive(Clone, Debug)]
pub enum Leaving {
    /// Closing the window.
    Close,
    /// Opening files, a session among them.
    Open(Vec<OpenedFile>),
    /// Restoring the session that was left at this path.
    Restore(PathBuf, Box<OpenedSession>),
}

/// Everything behind the window.
pub struct Engine {
    project: Project,
    history: History,
    /// The document that was saved or opened last.
    saved: Option<Project>,
    /// What edits are made with, while a hand goes on.
    pub gesture: Option<u64>,
    /// The session's file, if it has one.
    pub session: Option<PathBuf>,
    /// The trained calibration that was saved last beside the session.
    saved_trained: Option<Arc<Calibration>>,
    /// The trained calibration beside the session that was opened, until all its recordings are there.
    unproven: Option<Arc<Calibration>>,
    /// Where the panes stood in a session that was just opened.
    pub layout: Option<serde_json::Value>,
    /// What the thresholds begin with, of these recordings measured this way.
    default_thresholds: Option<(Arc<RecordingSet>, Distance, Thresholds)>,
    /// What there is to say.
    pub notices: Vec<Notice>,
    /// How many there have been.
    n_said: u64,
    /// A file that somebody is asked about before it is written.
    pub replacing: Option<(FileContent, PathBuf, Doubt)>,
    /// The file whose columns are being said.
    pub importing: Option<Importing>,
    /// Autosaved sessions of windows that did not end as they should, oldest first.
    pub recoverable: Vec<LeftSession>,
    /// Whether they are on screen.
    pub shows_left: bool,
    recovery: Recovery,
    /// The document that the autosave was given last.
    kept: Option<Project>,
    /// Those whose content is here now.
    restored: Vec<PathBuf>,
    /// What is to be done, once somebody has said what becomes of what is not saved.
    pub leaving: Option<Leaving>,
    /// Whether the window is to close now.
    pub closes: bool,
    /// What is remembered between runs.
    pub preferences: Preferences,
    /// Everything that was tried.
    pub models: Models,
    lanes: Lanes,
    following: Lane<Follow>,
    /// What a file is followed with.
    current: Current,
    preview: Lane<Preview>,
    tasks: Vec<Begun>,
    waiting: VecDeque<InTurn>,
    /// What questions about the same recordings share.
    datasets: Datasets,
    notify: Notify,
}

impl Engine {
    /// An empty document; `notify` is called from other threads when there is something to take.
    pub fn new(notify: Notify) -> Self {
        Self {
            project: Project::default(),
            history: History::default(),
            saved: None,
            gesture: None,
            session: None,
            saved_trained: None,
            unproven: None,
            layout: None,
            default_thresholds: None,
            notices: Vec::new(),
            n_said: 0,
            replacing: None,
            importing: None,
            recoverable: Vec::new(),
            shows_left: false,
            recovery: Recovery::default(),
            kept: None,
            restored: Vec::new(),
            leaving: None,
            closes: false,
            preferences: Preferences::default(),
            models: Models::default(),
            lanes: Lanes::new(&notify),
            following: Lane::new(&notify),
            current: Current::default(),
            preview: Lane::new(&notify),
            tasks: Vec::new(),
            waiting: VecDeque::new(),
            datasets: Datasets::default(),
            notify,
        }
    }

    /// The document.
    pub fn project(&self) -> &Project {
        &self.project
    }

    /// The recordings of the document, with what each is for.
    pub fn entries(&self) -> &[Entry] {
        self.project.recordings.entries()
    }

    /// What can be gone back and forward over.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// The newest analysis of recordings like those that are loaded; it stays while the next one runs.
    pub fn analysis(&self) -> Option<&Arc<Analysis>> {
        let (own, of) = (&self.project.recordings, self.lane::<Analyse>().answered()?);
        let of = &of.0.recordings;
        let fits = own.layout() == of.layout()
            && own.is_simulated() == of.is_simulated()
            && !own.entries().is_empty();
        self.lane::<Analyse>().answer().filter(|_| fits)
    }

    /// How a recording of the document came out, in the newest analysis that has it.
    pub fn result_of(&self, at: usize) -> Option<&RecordingResult> {
        let own = &self.entries().get(at)?.recording;
        let of = self.lane::<Analyse>().answered()?.0.recordings.entries();
        let is_own = |at: &usize| Arc::ptr_eq(&of[*at].recording, own);
        let same_place = Some(at).filter(|at| *at < of.len() && is_own(at));
        let place = same_place.or_else(|| (0..of.len()).find(is_own))?;
        self.analysis()?.recordings.get(place)
    }

    /// Whether the analysis is that of the document as it is now.
    pub fn is_current(&self) -> bool {
        self.lane::<Analyse>().is_current()
    }

    /// Why the newest analysis failed.
    pub fn problem(&self) -> Option<&str> {
        self.lane::<Analyse>().problem()
    }

    /// How far the last training is, or what came of it.
    pub fn trained(&self) -> Option<&Trained> {
        self.lane::<Train>().answer()
    }

    /// The newest analysis that is no preview, with what it is of.
    pub fn exact(&self) -> Option<(&Request, &Arc<Analysis>)> {
        self.analysis()?;
        let (Analyse(request), analysis) = self.lane::<Analyse>().whole()?;
        Some((request, analysis))
    }

    /// What was trained for just these recordings and settings, be it cross-validated or not.
    pub fn fitting(&self) -> Option<&Arc<Calibration>> {
        let last = self.fitted_last();
        last.or_else(|| self.models.trained(&self.project))
    }

    fn fitted_last(&self) -> Option<&Arc<Calibration>> {
        let (settings, _, calibration) = self.last_training()?;
        let mut settings = settings.clone();
        settings.network.cross_validate = self.project.settings.network.cross_validate;
        (settings == self.project.settings).then_some(calibration)
    }

    /// Whether what is shown can be kept as a model: it was fitted to what is loaded, by the settings of now.
    pub fn can_keep(&self) -> bool {
        let learns = self.project.settings.regressor.learner().is_some();
        self.is_current() && self.project.applied.is_none() && (!learns || self.fitting().is_some())
    }

    /// The training that runs.
    pub fn training(&self) -> Option<Running> {
        self.lane::<Train>().running()
    }

    /// Whether models are being tried.
    pub fn is_trying(&self) -> bool {
        !self.lane::<Compare>().is_idle() || !self.lane::<FindBest>().is_idle()
    }

    /// The refit that runs.
    pub fn refit(&self) -> Option<Running> {
        self.lane::<Analyse>().running()
    }

    /// What else runs and is worth a word.
    pub fn running(&self) -> Vec<Running> {
        let seen = self.tasks.iter().filter(|task| task.is_seen);
        let tasks = seen.filter_map(|task| task.lane.running());
        tasks.chain(self.lanes.running()).collect()
    }

    /// What the thresholds begin with in these recordings.
    pub fn default_thresholds(&self) -> Thresholds {
        let own = self.default_thresholds.as_ref();
        own.map_or_else(|| self.project.default_thresholds(), |own| own.2)
    }

    /// The share of training samples, or of all without any, for which the first look-back finds a past sample; `None` without a
    /// look-back.
    pub fn share_with_past(&self) -> Option<f64> {
        let entries = self.entries();
        let share = |is_asked: &dyn Fn(Role) -> bool| {
            let (mut found, mut all) = (0.0, 0.0);
            for (at, _) in entries.iter().enumerate().filter(|(_, entry)| is_asked(entry.role)) {
                let result = self.result_of(at)?;
                found += result.share_with_past? * result.n_samples as f64;
                all += result.n_samples as f64;
            }
            (all > 0.0).then(|| found / all)
        };
        share(&|role| role == Role::Train).or_else(|| share(&|_| true))
    }

    /// The file that is followed.
    pub fn followed_file(&self) -> Option<&Path> {
        self.following.asked().map(|follow| &*follow.path)
    }

    /// Its newest minute.
    pub fn followed(&self) -> Option<&Followed> {
        self.following.answer()
    }

    /// Why it is not followed any more.
    pub fn following_problem(&self) -> Option<&str> {
        self.following.problem()
    }

    /// The lane of a kind of question: what was asked on it last, and the answer.
    pub fn lane<Q: Query>(&self) -> &Lane<Q> {
        self.lanes.of()
    }

    /// Asks, unless this was asked last.
    pub fn ask<Q: Query>(&mut self, question: Q) {
        self.lanes.of_mut().ask(question);
    }

    /// Whether anything runs or waits to run.
    pub fn is_busy(&self) -> bool {
        !self.lanes.are_idle() || !self.tasks.is_empty() || !self.preview.is_idle()
    }

    /// Whether something would be lost with the window.
    pub fn is_unsaved(&self) -> bool {
        let recordings = &self.project.recordings;
        let is_changed = match &self.saved {
            Some(saved) => *saved != self.project,
            None => !recordings.entries().is_empty() && !recordings.is_simulated(),
        };
        let trained = self.trained_to_save().map(Arc::as_ptr);
        is_changed || trained.is_some() && trained != self.saved_trained.as_ref().map(Arc::as_ptr)
    }

    /// Returns the trained calibration that is saved beside the session: that of the settings, where they ask for a training.
    fn trained_to_save(&self) -> Option<&Arc<Calibration>> {
        let learns = self.project.settings.regressor.learner().is_some();
        self.unproven.as_ref().or_else(|| self.fitting().filter(|_| learns))
    }

    /// The last training, if it is of the recordings of now.
    fn last_training(&self) -> Option<(&FitSettings, &Trained, &Arc<Calibration>)> {
        let (Train { request: of, .. }, trained) = self.lane::<Train>().whole()?;
        let is_own = Arc::ptr_eq(&of.recordings, &self.project.recordings);
        let calibration = trained.calibration.as_ref().filter(|_| is_own)?;
        Some((&of.settings, trained, calibration))
    }

    /// The window's title: the session's name, and a star while it is not saved.
    pub fn title(&self) -> String {
        let name = self.session.as_ref().and_then(|path| path.file_stem());
        let star = if self.is_unsaved() { " *" } else { "" };
        match name {
            Some(name) => format!("{}{star} – LoopScope", name.to_string_lossy()),
            None => format!("LoopScope{star}"),
        }
    }

    /// The session as a file's content; `layout` says where the panes stand.
    pub fn session_content(&self, layout: Option<serde_json::Value>) -> FileContent {
        let session = Box::new(Session::of(&self.project, layout));
        let trained = self.trained_to_save().cloned();
        FileContent::Session(session, Box::new(self.project.clone()), trained)
    }

    /// The calibration as a file's content. An applied one leaves as it came, not with the scores it has here.
    pub fn calibration_content(&self) -> Option<FileContent> {
        let (_, analysis) = self.exact()?;
        let applied = self.project.applied.as_ref();
        let calibration = applied.map_or(&analysis.calibration, |own| &own.calibration);
        let fitted_to = applied.is_none().then(|| Box::new(self.request()));
        let identity = &self.project.identity;
        let calibration = match *identity == calibration.identity {
            true => Arc::clone(calibration),
            false => Arc::new(calibration.of_sensor(identity)),
        };
        Some(FileContent::Calibration(calibration, fitted_to))
    }

    /// A report as a file's content.
    pub fn report_content(&self) -> FileContent {
        FileContent::Report(Box::new(ReportRequest {
            identity: self.project.identity.clone(),
            notes: self.project.notes.clone(),
            measuring: self.project.measuring.clone(),
            gauge_range: self.project.gauge_range.clone(),
            ..ReportRequest::of(self.request())
        }))
    }

    /// The traces of this interval of their time as a file's content.
    pub fn traces_content(&self, visible: Option<(f64, f64)>) -> Option<FileContent> {
        let (of, analysis) = self.exact()?;
        Some(FileContent::Traces(Box::new(TracesToWrite {
            calibration: Arc::clone(&analysis.calibration),
            recordings: Arc::clone(&of.recordings),
            decimation: of.settings.decimation,
            traces: Arc::clone(&analysis.traces),
            visible,
        })))
    }

    /// What is to be analysed.
    pub fn request(&self) -> Request {
        Request { datasets: self.datasets.clone(), ..self.project.request(self.fitting()) }
    }

    /// Asks for what follows from the document.
    fn follow(&mut self) {
        let (own, distance) = (&self.project.recordings, self.project.settings.features.distance);
        let holds = self
            .default_thresholds
            .as_ref()
            .is_some_and(|(of, measured, _)| Arc::ptr_eq(of, own) && *measured == distance);
        if !holds {
            let default = self.project.default_thresholds();
            self.default_thresholds = Some((Arc::clone(own), distance, default));
        }
        // Before anything was opened there is nothing to ask, and nothing to complain about.
        let asked = self.lane::<Analyse>().asked();
        if !self.entries().is_empty() {
            self.ask(Analyse(self.request()));
        } else if asked.is_some_and(|asked| !asked.0.recordings.entries().is_empty()) {
            self.lanes.forget_shown();
            self.ask(Analyse(self.request()));
        }
        let calibration = self.exact().map(|(_, analysis)| Arc::clone(&analysis.calibration));
        *self.current.lock().unwrap_or_else(PoisonError::into_inner) = calibration;
        if self.analysis().is_none() {
            self.lanes.of_mut::<AskLoops>().forget();
            self.lanes.of_mut::<AskFigures>().forget();
        }
    }

    /// What is wrong with each recording of the document, once it is known.
    pub fn all_faults(&self) -> Option<&[Arc<FaultyRecording>]> {
        let faults = self.lane::<FindFaults>();
        let is_own = Arc::ptr_eq(&faults.answered()?.recordings, &self.project.recordings);
        faults.answer().filter(|_| is_own).map(Vec::as_slice)
    }

    /// What is wrong with a recording of the document, as far as it is known.
    pub fn faults_of(&self, at: usize) -> Option<&Arc<FaultyRecording>> {
        self.all_faults()?.get(at)
    }

    /// What a pane asks of the loops, by the newest analysis, of this interval of time on screen.
    pub fn look(&self, visible: Option<(f64, f64)>, question: Question) -> Option<LookRequest> {
        let (of, analysis) = self.exact()?;
        Some(LookRequest {
            calibration: Arc::clone(&analysis.calibration),
            recordings: Arc::clone(&of.recordings),
            decimation: of.settings.decimation,
            traces: Arc::clone(&analysis.traces),
            visible: visible.filter(|_| question.follows_screen()),
            measuring: self.project.measuring.clone(),
            question,
        })
    }

    /// Changes the document, as one step of undo.
    fn change<T>(&mut self, change: impl FnOnce(&mut Project) -> T) -> T {
        let before = self.project.clone();
        let changed = change(&mut self.project);
        self.history.step(before, &self.project, self.gesture);
        changed
    }

    fn edit(&mut self, edit: Edit) {
        if let Err(error) = self.change(|project| project.edit(edit)) {
            self.tell(Level::Error, error.to_string());
        }
    }

    /// Says something.
    pub fn tell(&mut self, level: Level, text: impl Into<String>) {
        self.say(Notice::new(level, text));
    }

    fn say(&mut self, notice: Notice) {
        let level = match notice.level {
            Level::Info => log::Level::Info,
            Level::Warning => log::Level::Warn,
            Level::Error => log::Level::Error,
        };
        log::log!(level, "{}", notice.text);
        self.n_said += 1;
        self.notices.push(Notice { number: self.n_said, ..notice });
        let surplus = self.notices.len().saturating_sub(MAX_NOTICES);
        self.notices.drain(..surplus);
    }

    fn start(&mut self, task: Task) {
        self.begin(task, None);
    }

    fn begin(&mut self, task: Task, turn: Option<InTurn>) {
        let mut lane = Lane::new(&self.notify);
        let is_seen = task.is_seen;
        lane.ask_again(task);
        self.tasks.push(Begun { is_seen, turn, lane });
    }

    fn await_turn(&mut self, turn: InTurn) {
        self.waiting.push_back(turn);
        self.begin_next();
    }

    /// Begins what waits, where nothing of its kind goes on.
    fn begin_next(&mut self) {
        if self.tasks.iter().any(|task| task.turn.is_some()) {
            return;
        }
        let Some(turn) = self.waiting.pop_front() else {
            return;
        };
        let recordings = Arc::clone(&self.project.recordings);
        let task = match turn.clone() {
            InTurn::Read(files) => Task::open(files, self.preferences.maps.clone()),
            InTurn::Tare(which, tare) => {
                let is_meant = |own: &Recording| {
                    let mut which = which.iter();
                    which.any(|meant| meant.name() == own.name() && meant.source() == own.source())
                };
                let entries = recordings.entries().iter().enumerate();
                let meant = entries.filter(|(_, entry)| is_meant(&entry.recording));
                let meant = meant.map(|(at, _)| at).collect();
                Task::tare(recordings, meant, tare)
            }
            InTurn::LeaveOutFaulty => Task::leave_out(recordings, self.project.valid_range()),
            InTurn::Simulate => Task::simulate(recordings),
        };
        self.begin(task, Some(turn));
    }

    /// Does something; what takes its time goes on beside.
    pub fn act(&mut self, action: Action) {
        match action {
            Action::Edit(edit) => self.edit(edit),
            Action::Undo => self.history.undo(&mut self.project),
            Action::Redo => self.history.redo(&mut self.project),
            Action::Show(view) => self.project.view = view,
            Action::Open(paths) => self.open(paths),
            Action::OpenBuiltIn => self.await_turn(InTurn::Simulate),
            Action::Tare(which, tare) => {
                let entries = self.entries();
                let which = which.iter().filter_map(|at| entries.get(*at));
                let which = which.map(|entry| Arc::clone(&entry.recording)).collect();
                self.await_turn(InTurn::Tare(which, tare));
            }
            Action::LeaveOutFaulty => self.await_turn(InTurn::LeaveOutFaulty),
            Action::Save(content, path, existing) => self.save(content, path, existing),
            Action::Export(path, existing) => self.export(path, existing),
            Action::Replace(yes) => {
                let replacing = self.replacing.take().filter(|_| yes);
                if let Some((content, path, doubt)) = replacing {
                    match doubt {
                        Doubt::IsThere => self.save(content, path, Existing::Replace),
                        Doubt::Undetermined(_, existing) => {
                            self.save_whole(content, path, existing);
                        }
                    }
                }
            }
            Action::Train => {
                if self.lane::<Train>().is_idle()
                    && self.project.settings.regressor.learner().is_some()
                {
                    let recordings = Arc::clone(&self.project.recordings);
                    let settings = self.project.settings.clone();
                    let request = Request {
                        datasets: self.datasets.clone(),
                        ..Request::fit(recordings, settings)
                    };
                    let on_trained = self.on_trained();
                    self.lanes.of_mut::<Train>().ask_again(Train { request, on_trained });
                }
            }
            Action::StopTraining => self.lane::<Train>().cancel(),
            Action::ChooseBlock(block, measure) => {
                if self.lane::<ChooseBlock>().is_idle() {
                    self.lanes.of_mut::<ChooseBlock>().ask_again(ChooseBlock {
                        block,
                        measure,
                        recordings: Arc::clone(&self.project.recordings),
                        settings: self.project.settings.clone(),
                        datasets: self.datasets.clone(),
                    });
                }
            }
            Action::FindBest(time_limit) => self.find_best(time_limit),
            Action::ComparePaper => self.compare(),
            Action::StopTrying => {
                self.lane::<Compare>().cancel();
                self.lane::<FindBest>().cancel();
            }
            Action::Follow(path) => {
                self.following.cancel();
                self.following.ask_again(Follow { path, calibration: Arc::clone(&self.current) });
            }
            Action::StopFollowing => {
                self.following.cancel();
                self.following.forget();
            }
            Action::KeepModel => self.keep_model(),
            Action::Model(id, change) => self.models.change(id, change),
            Action::BringBack(id) => {
                let settings = self.models.row(id).map(|row| row.settings.clone());
                if let Some(settings) = settings {
                    self.edit(Edit::Model(Box::new(settings)));
                }
            }
            Action::Import(command) => self.import(command),
            Action::Restore(path) => self.start(Task::restore(path)),
            Action::DropLeft(path) => {
                self.recoverable.retain(|left| left.path != path);
                drop_left(&path);
            }
            Action::ShowLeft(yes) => {
                self.shows_left = yes;
                if yes {
                    // Others may have left, restored or dropped some meanwhile.
                    self.recoverable = self.recovery.left();
                    let restored = &self.restored;
                    self.recoverable.retain(|left| !restored.contains(&left.path));
                }
            }
            Action::Locate(place) => {
                let lost = self.project.lost.clone();
                let open = self.project.files().map(Path::to_owned).collect();
                self.start(Task::locate(lost, place, open));
            }
            Action::Forget(at) => {
                if at < self.project.lost.len() {
                    self.project.lost.remove(at);
                    self.prove();
                }
            }
            Action::Close => self.leave_for(Leaving::Close),
            Action::Stay => self.leaving = None,
            Action::Discard => self.leave(),
            Action::Cancel => {
                self.lanes.cancel();
                // Nobody waits for what cannot be stopped.
                let seen = self.tasks.iter().filter(|task| task.is_seen);
                seen.for_each(|task| task.lane.cancel());
                self.waiting.clear();
            }
            Action::Tell(notice) => self.say(notice),
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

    /// Takes what has been answered and done.
    pub fn take(&mut self) {
        // Asked before: whoever finds a lane idle also finds its answer.
        let have_ended = [self.lane::<Compare>().is_idle(), self.lane::<FindBest>().is_idle()];
        for failed in self.lanes.take() {
            self.tell(Level::Error, failed);
        }
        self.take_models(have_ended);
        let choice = self.lane::<ChooseBlock>();
        if choice.happened().contains(&LaneEvent::Answer)
            && let Some(chosen) = choice.answer().cloned()
        {
            self.edit(Edit::Block(chosen));
        }
        self.following.hear_all();
        if !self.preview.hear_all().is_empty()
            && let Some((importing, asked)) = self.importing.as_mut().zip(self.preview.asked())
        {
            // What was found before the newest change of the map would take it back.
            let found = self.preview.answer().filter(|_| self.preview.is_current());
            let answer = found.ok_or(self.preview.problem());
            match answer {
                Ok(found) => importing.take_answer(&asked.path, Ok(found)),
                Err(Some(problem)) => importing.take_answer(&asked.path, Err(problem)),
                Err(None) => {}
            }
        }
        self.take_tasks();
        self.follow();
    }

    fn take_tasks(&mut self) {
        let mut ended = Vec::new();
        self.tasks.retain_mut(|Begun { lane: task, .. }| {
            let is_idle = task.is_idle();
            task.hear_all();
            if is_idle {
                ended.push((task.take_whole(), task.problem().map(str::to_owned)));
            }
            !is_idle
        });
        for (done, problem) in ended {
            problem.into_iter().for_each(|problem| self.tell(Level::Error, problem));
            done.into_iter().for_each(|done| self.finish(done));
        }
        self.begin_next();
    }

    pub(super) fn finish(&mut self, done: Done) {
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
            Done::Changed(before, _) if !Arc::ptr_eq(&before, &self.project.recordings) => {
                let text = "The recordings were changed while they were tared or their faults left out; what was asked for \
                            was not done. Ask again.";
                self.tell(Level::Warning, text);
            }
            Done::Changed(_, Ok(changed)) => self.edit(Edit::Replace(Arc::new(changed))),
            Done::Changed(_, Err(error)) => self.tell(Level::Error, error),
            Done::Simulated(_, set) => {
                // A session that was just opened and asked for it is still the same.
                let is_saved =
                    self.entries().is_empty() && self.saved.is_some() && !self.is_unsaved();
                let refused = self.change(|project| {
                    // That of a session which was opened, and waits for its recordings.
                    let waits = |split: &&Split| split.whole.entries().is_empty();
                    let split = project.split.as_ref().filter(waits);
                    let split = split.map(|split| Edit::Split(split.fraction));
                    let refused = project.take_set(set).err();
                    // A calibration that was opened meanwhile is there to be applied to it.
                    let applied = project.applied.take();
                    let fits = project.edit(Edit::Apply(applied)).err();
                    let split = split.and_then(|split| project.edit(split).err());
                    project.show_first_test();
                    refused.into_iter().chain(fits).chain(split)
                });
                refused.for_each(|error| self.tell(Level::Error, error.to_string()));
                if is_saved {
                    self.saved = Some(self.project.clone());
                }
                self.prove();
            }
            Done::Written(FileContent::Session(_, project, trained), path, Ok(())) => {
                self.preferences.remember(&path);
                let beside = trained.as_ref().map(|_| trained_beside(&path));
                let beside = beside.map_or_else(String::new, |own| {
                    format!(", with the trained calibration {}", own.display())
                });
                self.tell(Level::Info, format!("Saved the session {}{beside}", path.display()));
                self.session = Some(path);
                self.saved = Some(*project);
                self.saved_trained = trained;
                if !self.is_unsaved() {
                    self.leave();
                }
            }
            Done::Written(_, path, Ok(())) => {
                self.tell(Level::Info, format!("Wrote {}", path.display()));
            }
            Done::Written(_, _, Err(error)) => self.tell(Level::Error, error),
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
                        self.tell(Level::Info, importing::in_words(&estimate));
                    }
                    Err(error) => self.tell(Level::Error, error),
                }
            }
            Done::Restored(path, Ok(opened)) => self.leave_for(Leaving::Restore(path, opened)),
            Done::Located(place, found) => self.take_located(&place, found),
            Done::Proven(trained, recordings, proven) => {
                // Another session may have been opened meanwhile, or the same thing been asked twice.
                let is_own = |own: &mut Arc<_>| Arc::ptr_eq(own, &trained);
                if self.unproven.take_if(is_own).is_none() {
                    return;
                }
                match proven {
                    Ok(()) => self.take_trained(trained, recordings),
                    Err(reason) => self.tell(Level::Warning, reason),
                }
            }
            Done::Kept(recordings, model) => self.models.keep(*model, &recordings),
            Done::Map(Err(error)) | Done::Restored(_, Err(error)) => self.tell(Level::Error, error),
        }
    }

    fn open(&mut self, paths: Vec<PathBuf>) {
        let files = paths.into_iter().map(|path| {
            let map = self.project.maps.get(&path).cloned();
            (path, map)
        });
        // What is opened again while it is read or waits is meant once.
        let begun = self.tasks.iter().filter_map(|task| task.turn.as_ref());
        let awaited: Vec<_> = begun.chain(&self.waiting).flat_map(InTurn::files).collect();
        let files: Files = files.filter(|file| !awaited.contains(&file)).collect();
        if !files.is_empty() {
            self.await_turn(InTurn::Read(files));
        }
    }

    fn take_files(&mut self, files: Vec<OpenedFile>) {
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
                        self.tell(Level::Warning, warning.text(Face::Window));
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
                        self.tell(Level::Warning, note);
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
                Err(error) => self.tell(Level::Error, error),
            }
        }
        for said in importing::by_remembered(by_remembered) {
            self.tell(Level::Info, said);
        }
        self.begin_import(to_import);
        if let Some((path, opened)) = session {
            self.take_session(Some(path), opened);
        }
        if !recordings.is_empty() {
            let before = self.project.thresholds();
            let refused = self.change(|project| project.add(recordings, |_| None));
            let now = self.project.thresholds();
            if now != before && self.project.settings.features.distance == Distance::Force {
                let text = format!(
                    "F_th begins at {} N: of how far the force moves in these recordings about the share that the paper's 3 N are of \
                     its sensor's range. The pane Thresholds finds a better one",
                    significant(now.f_th, 3)
                );
                self.tell(Level::Info, text);
            }
            refused.into_iter().for_each(|refused| self.tell(Level::Error, refused));
        }
        calibrations.into_iter().for_each(|edit| self.edit(edit));
    }

    /// Takes files of the session that were found; those that cannot be read are still asked for.
    fn take_located(&mut self, place: &Path, found: Vec<(SessionFile, SessionPart)>) {
        let mut parts = Vec::new();
        for (file, part) in found {
            let at = self.project.lost.iter().position(|lost| *lost == file);
            // Somebody may have opened another session meanwhile.
            let Some(at) = at else { continue };
            if let Some(Ok(_)) = part.loaded {
                self.project.lost.remove(at);
            }
            parts.push(part);
        }
        if parts.is_empty() {
            let text = format!(
                "{}: none of the missing files is there; they are known by their names, and where it was saved by what they hold",
                place.display()
            );
            self.tell(Level::Error, text);
            return;
        }
        let said = self.change(|project| add_parts(project, parts));
        said.into_iter().for_each(|notice| self.say(notice));
        self.prove();
    }

    /// Checks that the session's trained calibration is of its recordings, once these are there.
    fn prove(&mut self) {
        let recordings = &self.project.recordings;
        let is_whole = self.project.lost.is_empty() && !recordings.entries().is_empty();
        if let Some(trained) = self.unproven.as_ref().filter(|_| is_whole) {
            let task = Task::prove(Arc::clone(recordings), Arc::clone(trained));
            self.start(task);
        }
    }

    /// Takes the session's trained calibration as if it had just been trained.
    fn take_trained(&mut self, calibration: Arc<Calibration>, recordings: Arc<RecordingSet>) {
        let request = Request {
            datasets: self.datasets.clone(),
            ..Request::fit(recordings, self.project.settings.clone())
        };
        let trained = Trained { calibration: Some(calibration), ..Trained::default() };
        let on_trained = self.on_trained();
        self.lanes.of_mut::<Train>().put(Train { request, on_trained }, trained);
    }

    /// Keeps a training's result safe at once, even while the window draws nothing.
    fn on_trained(&self) -> OnTrained {
        let autosave = self.recovery.autosave();
        Arc::new(move |request, calibration| {
            autosave.take_trained(&request.recordings, &request.settings, calibration);
        })
    }

    /// Puts a session in place of everything that is loaded; one without a path was recovered.
    fn take_session(&mut self, path: Option<PathBuf>, mut opened: OpenedSession) {
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
        let is_built_in = opened.session.built_in;
        let (project, notices) = opened.into_project();
        notices.into_iter().for_each(|notice| self.say(notice));
        let maps = std::mem::take(&mut self.project.maps);
        self.project = project;
        for (path, map) in maps {
            self.project.maps.entry(path).or_insert(map);
        }
        if is_built_in {
            self.await_turn(InTurn::Simulate);
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
    fn leave_for(&mut self, leaving: Leaving) {
        self.leaving = Some(leaving);
        if !self.is_unsaved() {
            self.leave();
        }
    }

    /// Does what waited for an answer.
    fn leave(&mut self) {
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

    fn save(&mut self, content: FileContent, path: PathBuf, existing: Existing) {
        // The notice about it must say where a relative path led.
        let path = std::path::absolute(&path).unwrap_or(path);
        let inputs = self.project.files().map(Path::to_owned).collect();
        self.start(Task::write(content, path, existing, inputs));
    }

    fn export(&mut self, path: PathBuf, existing: Existing) {
        let Some(content) = self.calibration_content() else {
            self.tell(Level::Error, "There is no calibration to export yet");
            return;
        };
        if target_for(&path).is_none() {
            let text = format!(
                "{}: the ending says no format; use one of {}",
                path.display(),
                target_endings()
            );
            self.tell(Level::Error, text);
            return;
        }
        let fitted = self.project.applied.is_none();
        match &content {
            FileContent::Calibration(calibration, _) if fitted => {
                if let Some(undetermined) = calibration.undetermined() {
                    let doubt = Doubt::Undetermined(undetermined, existing);
                    self.replacing = Some((content, path, doubt));
                    return;
                }
            }
            _ => {}
        }
        self.save_whole(content, path, existing);
    }

    /// Says first, where the file leaves out a part of the loads that are shown.
    fn save_whole(&mut self, content: FileContent, path: PathBuf, existing: Existing) {
        if let Some(caution) = content.caution(&path) {
            self.tell(Level::Warning, caution);
        }
        self.save(content, path, existing);
    }

    /// Searches for the best model, unless models are being tried already.
    fn find_best(&mut self, time_limit: Duration) {
        if self.is_trying() {
            return;
        }
        let search = Search {
            recordings: Arc::clone(&self.project.recordings),
            settings: self.project.settings.clone(),
            time_limit,
        };
        let run = self.models.next_run();
        self.lanes.of_mut::<FindBest>().ask_again(FindBest { run, search });
    }

    fn compare(&mut self) {
        if self.is_trying() {
            return;
        }
        match self.models.begin_paper(&self.project) {
            Some(compare) => self.lanes.of_mut::<Compare>().ask_again(compare),
            None => self
                .tell(Level::Info, "Every row of the comparison already has a result that holds"),
        }
    }

    fn keep_model(&mut self) {
        let fitted = self.analysis().filter(|_| self.can_keep());
        let Some(analysis) = fitted else {
            self.tell(
                Level::Error,
                "There is nothing to keep yet: what is shown is not fitted, or not trained, by the settings of now",
            );
            return;
        };
        let calibration = Arc::clone(&analysis.calibration);
        let recordings = Arc::clone(&self.project.recordings);
        let settings = self.project.settings.clone();
        self.start(Task::keep(recordings, settings, calibration));
    }

    /// Takes how far the models are that are being tried.
    fn take_models(&mut self, [has_compared, has_searched]: [bool; 2]) {
        let comparing = self.lanes.of_mut::<Compare>();
        if let (Some(asked), Some(states)) = (comparing.answered(), comparing.answer())
            && !comparing.happened().is_empty()
        {
            self.models.take_paper(asked, states);
        }
        // What was found is on the list; the recordings need not be kept for it.
        if has_compared {
            self.models.end_paper();
            comparing.forget();
        }
        let searching = self.lanes.of_mut::<FindBest>();
        if let (Some(asked), Some(best)) = (searching.answered(), searching.answer())
            && !searching.happened().is_empty()
        {
            self.models.take_search(asked.run, best, &asked.search.recordings);
        }
        if has_searched {
            searching.forget();
        }
    }

    /// Begins to import files, one after another.
    fn begin_import(&mut self, mut paths: Vec<PathBuf>) {
        if paths.is_empty() {
            return;
        }
        match &mut self.importing {
            Some(importing) => importing.waiting.extend(paths),
            None => {
                let path = paths.remove(0);
                let mut importing = Importing::of(path, paths);
                let preview = importing.look(importing::KnownOf::Nothing);
                self.preview.ask_again(preview);
                self.importing = Some(importing);
            }
        }
    }

    fn import(&mut self, command: ImportCommand) {
        match command {
            ImportCommand::Open(path) => return self.begin_import(vec![path]),
            ImportCommand::CancelAll => {
                let not_read = self.importing.take().map(|own| own.not_read());
                if let Some(said) = not_read {
                    self.tell(Level::Info, said);
                }
            }
            ImportCommand::Cancel => {
                let waiting = self.importing.take().map(|importing| importing.waiting);
                return self.begin_import(waiting.unwrap_or_default());
            }
            ImportCommand::Load => {
                let Some(importing) = self.importing.take() else {
                    return;
                };
                let Importing { path, map, waiting, .. } = importing;
                self.preferences.remember_map(&map);
                self.project.maps.insert(path.clone(), map);
                return self.open([vec![path], waiting].concat());
            }
            ImportCommand::ReadMap(path) => return self.start(Task::read_map(path)),
            _ => {}
        }
        let Some(importing) = &mut self.importing else {
            return;
        };
        match command {
            ImportCommand::FindWeight => {
                let task = Task::find_weight(importing.path.clone(), importing.map.clone());
                self.start(task);
            }
            ImportCommand::WriteMap(path) => {
                let mut text = Vec::new();
                match importing.map.write_json(&mut text) {
                    Ok(()) => self.save(FileContent::Bytes(text.into()), path, Existing::Ask),
                    Err(error) => self.tell(Level::Error, error.to_string()),
                }
            }
            command => {
                let preview = importing.apply(command, &self.preferences);
                preview.into_iter().for_each(|preview| self.preview.ask_again(preview));
            }
        }
    }
}
