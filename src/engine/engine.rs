//! The program behind the window: the document with its undo, the questions about it, and what is done with files.
//!
//! Guarantees: only [`Engine::act`] changes the document, and each edit is one step of undo; what is shown follows the document
//! by itself ([`Engine::follow`]); wrong files lose nothing that is loaded.

mod act;
mod leave;
mod take;

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
use crate::export::{ShownFTh, target_endings, target_for};
use crate::features::{Distance, Thresholds};
use crate::finding::{Advice, Face};
use crate::import::map::ColumnMap;
use crate::questions::check::faulty::{FaultyRecording, FindFaults};
use crate::questions::errors::asked::Analyse;
use crate::questions::loops::asked::{AskFigures, AskLoops, AskVerdict};
use crate::questions::loops::{LookRequest, Question};
use crate::questions::models::asked::{Compare, FindBest, OnTrained, Train, Trained};
use crate::questions::page::ReportRequest;
use crate::questions::question::Query;
use crate::questions::thresholds::Measure;
use crate::questions::thresholds::asked::{ChooseBlock, StudyThresholds};
use crate::questions::{Analysis, Datasets, HistoryBlock, RecordingResult, Request, Search, View};
use crate::recording::simulated::Late;
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
    /// The built-in sensor, or the set that tells lag from hysteresis.
    Simulate(Option<Late>),
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
    /// Open the built-in simulated sensor, or the set that tells lag from hysteresis, instead of what is loaded.
    OpenBuiltIn(Option<Late>),
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
    /// The thresholds that stand while the cross-validation minimum of recordings that were just opened is looked for.
    first_thresholds: Option<(Arc<RecordingSet>, Thresholds)>,
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
            first_thresholds: None,
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
            self.lanes.of_mut::<AskVerdict>().forget();
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
}
