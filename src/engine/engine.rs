//! The program without its window: the document (all that a session saves), undo, computed results, and work with files.
//!
//! Guarantees: only [`Engine::act`] and [`Engine::take`] change the document. Each edit is one step of undo. A changed
//! document is analysed again automatically ([`Engine::follow`]). A file that cannot be read never replaces loaded data.

mod act;
mod columns;
mod documents;
mod modelling;
mod reading;
mod take;
mod writing;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Weak};
use std::time::Duration;

use crate::{
    calibration::Calibration,
    engine::{
        files::OpenedFile,
        importing::{ImportCommand, Importing, Preview},
        lanes::{ANYONE, Asked, Asker, Lanes},
        live::{Current, Follow},
        models::Models,
        notice::{Level, Notice},
        preferences::Preferences,
        project::{Edit, Project},
        query::{Background, Lane, Notify, Running},
        recovery::{LeftSession, Recovery},
        saving::{Doubt, Existing, FileContent, Output},
        session::{OpenedSession, Session},
        tasks::Tasks,
        undo::History,
    },
    features::Thresholds,
    import::ColumnChange,
    panicked::locked,
    questions::{
        Analysis, Candidates, Datasets, HistoryBlock, OnScreen, RecordingResult, Request, View,
        check::query::{FaultyRecording, FindFaults},
        errors::query::Analyse,
        loops::{LookRequest, Question},
        models::asked::{Train, TryModels},
        page::ReportRequest,
        question::Query,
        thresholds::Measure,
    },
    recording::{Entry, RecordingSet, Tare, simulated::Late},
};

pub(super) const MAX_NOTICES: usize = 200;

/// Action of the user, which [`Engine::act`] carries out.
#[derive(Clone, Debug)]
pub enum Action {
    /// Change the document.
    Edit(Edit),
    /// Begin an empty document. If there are unsaved changes, the user is first asked whether to save them.
    New,
    /// Undo the last edit.
    Undo,
    /// Redo the last undone edit.
    Redo,
    /// Select the recordings that the window shows.
    Show(View),
    /// Open recordings, calibrations, a session, or folders of them.
    Open(Vec<PathBuf>),
    /// Replace the loaded recordings by those of the built-in simulated sensor; `Some` selects a set that shows time lag, hysteresis, or both.
    OpenBuiltIn(Option<Late>),
    /// Tare the recordings with these indices.
    Tare(Vec<usize>, Tare),
    /// Read the files again with another role for one channel, or with another column map for one file.
    ChangeColumns(ColumnChange),
    /// Remove the faulty samples (such as clipped or overloaded ones) from all recordings.
    LeaveOutFaulty,
    /// Write this content to the file at this path.
    Save(FileContent, PathBuf, Existing),
    /// Write the calibration to each of these files, in the format that its file name ending selects.
    Export(Vec<PathBuf>, Existing),
    /// Answer to whether the files of [`Engine::replacing`] may be written: true writes them.
    Replace(bool),
    /// Train the network or kernel regression that the settings select.
    Train,
    /// Stop training. A network keeps the weights of its best epoch so far.
    StopTraining,
    /// Choose the values of a feature block (such as its time constants) that minimise this cross-validation error.
    ChooseBlock(HistoryBlock, Option<Measure>),
    /// Search for the best model. After this duration, no further model is started.
    FindBest(Candidates, Duration),
    /// Follow a growing file that a logger writes, and show its newest loads.
    Follow(PathBuf),
    /// Stop following the growing file.
    StopFollowing,
    /// Stop the search or comparison of models. Finished models stay in the list.
    StopTrying,
    /// Add the model of the present fit to the list of models.
    KeepModel,
    /// Remove the row with this number from the list of models.
    RemoveModel(u64),
    /// Use the settings of the row with this number in the list of models.
    BringBack(u64),
    /// Command of the import page.
    Import(ImportCommand),
    /// Restore this autosaved session of a window that crashed.
    Restore(PathBuf),
    /// Discard this autosaved session of a window that crashed.
    DropLeft(PathBuf),
    /// Show or hide the list of autosaved sessions of crashed windows. Hidden sessions stay on disk.
    ShowLeft(bool),
    /// Search for the missing files of the session. The path is that of one missing file, or of their folder.
    Locate(PathBuf),
    /// Remove the missing file with this index from the list of the session.
    Forget(usize),
    /// Close the window.
    Close,
    /// Cancel the action [`Engine::leaving`] that would discard the loaded data, and keep the unsaved changes.
    Stay,
    /// Carry out the action [`Engine::leaving`], although it discards the unsaved changes.
    Discard,
    /// Cancel the background work that the status line shows.
    Cancel,
    /// Show a message to the user.
    Notice(Notice),
    /// Dismiss the notice with this index.
    Dismiss(usize),
    /// Dismiss all notices.
    DismissAll,
    /// Change the preferences.
    Prefer(Preferences),
}

/// Action that discards all loaded data. If there are unsaved changes, the user is first asked whether to save them.
#[derive(Clone, Debug)]
pub enum Leaving {
    Close,
    New,
    Open(Vec<OpenedFile>),
    Restore(PathBuf, Box<OpenedSession>),
}

/// Parts of a document that are neither edits nor results. They are set aside when a new document begins, and come back when
/// undo returns to the recordings of the document.
struct SetAside {
    recordings: Weak<RecordingSet>,
    session: Option<PathBuf>,
    models: Models,
}

/// Result of each exported file, by its path.
type Exported = BTreeMap<PathBuf, Result<(), String>>;

/// State of the whole program except its window.
#[derive(Default)]
pub struct Engine {
    project: Project,
    pub(crate) history: History,
    /// Document as it was last saved or opened, to detect unsaved changes.
    saved: Option<Project>,
    /// Number of the present gesture, such as a drag of a slider. All edits of one gesture are one step of undo.
    pub gesture: Option<u64>,
    /// Path of the session file; `None` if the session was never saved or opened.
    pub session: Option<PathBuf>,
    /// Trained network or kernel calibration as it was last saved in the file beside the session.
    saved_trained: Option<Arc<Calibration>>,
    /// Trained calibration that was read with the session, until it is checked that it was trained on the session's
    /// recordings.
    unproven: Option<Arc<Calibration>>,
    /// Recordings and thresholds when the automatic search for thresholds began, to detect later changes by the user.
    first_thresholds: Option<(Arc<RecordingSet>, Thresholds)>,
    /// True if the thresholds F_th and t_th are chosen automatically whenever recordings are opened.
    pub(crate) finds_thresholds: bool,
    /// Notices.
    pub notices: Vec<Notice>,
    n_notices: u64,
    /// Files that wait until the user confirms that they may be written, and the question's reason.
    pub replacing: Option<(Output, Doubt)>,
    /// Files that wait until the user has answered about those in `replacing`.
    pub(super) replaced_next: Vec<(Output, Doubt)>,
    /// The document at the last export, and the result of each exported file.
    exported: Option<(Project, Exported)>,
    /// Number of documents that began since the start of the program. The window shows each document with fresh panes.
    pub n_documents: u64,
    aside: Vec<SetAside>,
    /// State of the import page for the file whose columns the user is choosing; `None` if the window is closed.
    pub importing: Option<Importing>,
    /// Autosaved sessions of windows that crashed, oldest first.
    pub recoverable: Vec<LeftSession>,
    /// True if the window shows the list of autosaved sessions of crashed windows.
    pub shows_left: bool,
    recovery: Recovery,
    restored: Vec<PathBuf>,
    /// Action that would discard the loaded data, and waits until the user has decided about unsaved changes.
    pub leaving: Option<Leaving>,
    /// True if the window must close now.
    pub closes: bool,
    /// Preferences of the user.
    pub preferences: Preferences,
    /// List of the models that were tried or kept, with their errors.
    pub models: Models,
    lanes: Lanes,
    pub(crate) following: Lane<Follow>,
    current: Current,
    preview: Lane<Preview>,
    tasks: Tasks<Self>,
    datasets: Datasets,
}

impl Engine {
    /// Creates an engine with an empty document. Background threads call `notify` when there are new results.
    pub fn new(notify: Notify) -> Self {
        Self {
            following: Lane::new(Some(Arc::clone(&notify))),
            preview: Lane::new(Some(Arc::clone(&notify))),
            tasks: Tasks::new(Arc::clone(&notify)),
            lanes: Lanes::new(notify),
            ..Self::default()
        }
    }

    /// Returns the document.
    pub fn project(&self) -> &Project {
        &self.project
    }

    /// Returns the recordings of the document with their roles.
    pub fn entries(&self) -> &[Entry] {
        self.project.recordings.entries()
    }

    /// Returns the newest finished analysis of the loaded recordings, even if a newer analysis is being computed.
    pub fn analysis(&self) -> Option<&Arc<Analysis>> {
        let now = &self.project.recordings;
        let analysed = &self.lane::<Analyse>().answered()?.0.recordings;
        let fits = now.layout() == analysed.layout()
            && now.is_simulated() == analysed.is_simulated()
            && !now.entries().is_empty();
        self.lane::<Analyse>().answer().filter(|_| fits)
    }

    /// Returns the results of the recording with this index, if the newest analysis contains the recording.
    pub fn result_of(&self, at: usize) -> Option<&RecordingResult> {
        let recording = &self.entries().get(at)?.recording;
        let analysed = self.lane::<Analyse>().answered()?.0.recordings.entries();
        let is_it = |entry: &Entry| Arc::ptr_eq(&entry.recording, recording);
        let is_in_place = analysed.get(at).is_some_and(is_it);
        let place = if is_in_place { at } else { analysed.iter().position(is_it)? };
        self.analysis()?.recordings.get(place)
    }

    /// Returns true if the newest analysis was computed from the present document.
    pub fn is_current(&self) -> bool {
        self.lane::<Analyse>().is_current()
    }

    /// Returns the reason why the newest analysis failed.
    pub fn problem(&self) -> Option<&str> {
        self.lane::<Analyse>().problem()
    }

    /// Returns the newest complete analysis with the request that it answers. Partial results do not count.
    pub fn exact(&self) -> Option<(&Request, &Arc<Analysis>)> {
        self.analysis()?;
        let (Analyse(request), analysis) = self.lane::<Analyse>().whole()?;
        Some((request, analysis))
    }

    /// Returns the network or kernel calibration that was trained with the present recordings and settings.
    pub fn fitting(&self) -> Option<&Arc<Calibration>> {
        let last = self.fitted_last();
        last.or_else(|| self.models.trained(&self.project))
    }

    fn fitted_last(&self) -> Option<&Arc<Calibration>> {
        let (Train { request: of, .. }, trained) = self.lane::<Train>().whole()?;
        let is_present = Arc::ptr_eq(&of.recordings, &self.project.recordings);
        let calibration = trained.calibration.as_ref().filter(|_| is_present)?;
        let mut settings = of.settings.clone();
        settings.network.cross_validate = self.project.settings.network.cross_validate;
        (settings == self.project.settings).then_some(calibration)
    }

    /// Returns true if the newest fit used the present recordings and settings, so that its model can be added to the list of
    /// models.
    pub fn can_keep(&self) -> bool {
        let learns = self.project.settings.regressor.learner().is_some();
        self.is_current() && self.project.applied.is_none() && (!learns || self.fitting().is_some())
    }

    /// Returns true if a search or comparison of models is running.
    pub fn is_trying(&self) -> bool {
        !self.lane::<TryModels>().is_idle()
    }

    /// Returns all background work that the status line shows, other than the fit.
    pub fn running(&self) -> Vec<Running> {
        self.tasks.running().chain(self.lanes.running()).collect()
    }

    /// Returns the newest background request of type `Q` with its result.
    pub fn lane<Q: Query>(&self) -> &Lane<Q> {
        self.lane_of(ANYONE)
    }

    /// Returns the requests of this type that one pane asks, with their results.
    pub fn lane_of<Q: Query>(&self, asker: Asker) -> &Lane<Q> {
        self.lanes.of(asker)
    }

    /// Computes a request in the background, unless it equals the last request of its type.
    pub fn ask<Q: Query + PartialEq>(&mut self, question: Q) {
        self.ask_as(ANYONE, question);
    }

    /// Computes a request of a pane in the background, unless it equals the last request of its type by this pane.
    pub fn ask_as<Q: Query + PartialEq>(&mut self, asker: Asker, question: Q) {
        self.ask_for(Asked::of(asker, question));
    }

    /// Computes a pane's stored request in the background, unless the request equals the pane's last one.
    pub(crate) fn ask_for(&mut self, asked: Asked) {
        self.lanes.ask(asked);
    }

    /// Returns true if any background work runs or waits, apart from following a growing file.
    pub fn is_busy(&self) -> bool {
        !self.lanes.are_idle() || !self.tasks.is_empty() || !self.preview.is_idle()
    }

    /// Returns true if closing the window would lose changes.
    pub fn is_unsaved(&self) -> bool {
        let recordings = &self.project.recordings;
        let is_changed = match &self.saved {
            Some(saved) => *saved != self.project,
            None => !recordings.entries().is_empty() && !recordings.is_simulated(),
        };
        let trained = self.trained_to_save().map(Arc::as_ptr);
        is_changed || trained.is_some() && trained != self.saved_trained.as_ref().map(Arc::as_ptr)
    }

    /// Returns the trained network or kernel calibration to be saved in a file beside the session.
    fn trained_to_save(&self) -> Option<&Arc<Calibration>> {
        let learns = self.project.settings.regressor.learner().is_some();
        self.unproven.as_ref().or_else(|| self.fitting().filter(|_| learns))
    }

    /// Returns the title of the window: the name of the session, with a star if there are unsaved changes.
    pub fn title(&self) -> String {
        let name = self.session.as_ref().and_then(|path| path.file_stem());
        let star = if self.is_unsaved() { " *" } else { "" };
        match name {
            Some(name) => format!("{}{star} – LoopScope", name.to_string_lossy()),
            None => format!("LoopScope{star}"),
        }
    }

    /// Returns the content of the session file to be written.
    pub fn session_content(&self) -> FileContent {
        let session = Box::new(Session::of(&self.project));
        FileContent::Session(session, self.trained_to_save().cloned())
    }

    /// Returns the content of the calibration file to be written. A calibration that was opened from a file is saved as it
    /// was opened.
    pub fn calibration_content(&self) -> Option<FileContent> {
        let (_, analysis) = self.exact()?;
        let applied = self.project.applied.as_ref();
        let calibration = applied.map_or(&analysis.calibration, |applied| &applied.calibration);
        let fitted_to = applied.is_none().then(|| Box::new(self.request()));
        let identity = &self.project.identity;
        let calibration = if *identity == calibration.identity {
            Arc::clone(calibration)
        } else {
            Arc::new(Calibration { identity: identity.clone(), ..Calibration::clone(calibration) })
        };
        Some(FileContent::Calibration(calibration, fitted_to))
    }

    /// Returns the result of the export to this path: the reason if the file was not written. `None` if there was no export to
    /// it, or the document has changed since.
    pub fn exported(&self, path: &Path) -> Option<&Result<(), String>> {
        let (_, files) = self.exported.as_ref().filter(|(of, _)| *of == self.project)?;
        files.get(&std::path::absolute(path).ok()?)
    }

    /// Returns the content of the HTML report to be written.
    pub fn report_content(&self) -> FileContent {
        FileContent::Report(Box::new(ReportRequest {
            identity: self.project.identity.clone(),
            notes: self.project.notes.clone(),
            measuring: self.project.measuring.clone(),
            range: self.project.valid_range(),
            ..ReportRequest::of(self.request())
        }))
    }

    /// Returns the content of a table of loads and errors to be written, for this interval of time (s).
    pub fn traces_content(&self, visible: Option<(f64, f64)>) -> Option<FileContent> {
        let (of, analysis) = self.exact()?;
        Some(FileContent::Traces(Box::new(OnScreen::of(of, analysis, visible))))
    }

    /// Returns the request for an analysis of the present document.
    pub fn request(&self) -> Request {
        Request { datasets: self.datasets.clone(), ..self.project.request(self.fitting()) }
    }

    fn follow(&mut self) {
        // Without recordings, gauges or a load there is nothing to analyse. When the last of them is gone, all computed results
        // are removed.
        let asked = self.lane::<Analyse>().asked();
        if !self.entries().is_empty() && self.project.missing().is_none() {
            self.ask(Analyse(self.request()));
        } else if asked.is_some_and(|asked| {
            let set = &asked.0.recordings;
            !set.entries().is_empty() && set.missing().is_none()
        }) {
            self.lanes.forget(|lane| !lane.is_begun_by_user());
            self.ask(Analyse(self.request()));
        }
        let current = self.exact().map(|(request, analysis)| {
            let fitted_to = analysis.fitted.then(|| Arc::clone(&request.recordings));
            (Arc::clone(&analysis.calibration), fitted_to)
        });
        *locked(&self.current) = current;
        if self.analysis().is_none() {
            self.lanes.forget(|lane| lane.is_on_analysis());
        }
    }

    /// Returns the faulty samples of each recording; `None` until they are found.
    pub fn all_faults(&self) -> Option<&[Arc<FaultyRecording>]> {
        let faults = self.lane::<FindFaults>();
        let is_present = Arc::ptr_eq(&faults.answered()?.recordings, &self.project.recordings);
        faults.answer().filter(|_| is_present).map(Vec::as_slice)
    }

    /// Returns the faulty samples of the recording with this index; `None` until they are found.
    pub fn faults_of(&self, at: usize) -> Option<&Arc<FaultyRecording>> {
        self.all_faults()?.get(at)
    }

    /// Returns the request for loops, dwells or plots computed from the newest analysis, in this interval of time (s).
    pub fn look(&self, visible: Option<(f64, f64)>, question: Question) -> Option<LookRequest> {
        let (of, analysis) = self.exact()?;
        Some(LookRequest {
            loads: OnScreen::of(of, analysis, visible.filter(|_| question.follows_screen())),
            measuring: self.project.measuring.clone(),
            question,
        })
    }

    fn change<T>(&mut self, change: impl FnOnce(&mut Project) -> T) -> T {
        let before = self.project.clone();
        let changed = change(&mut self.project);
        self.history.step(before, &self.project, self.gesture);
        changed
    }

    fn edit(&mut self, edit: Edit) {
        if matches!(edit, Edit::New) {
            self.drop_work();
            self.set_aside();
        }
        if let Err(error) = self.change(|project| project.edit(edit)) {
            self.notice(Level::Error, error.to_string());
        }
    }

    pub(crate) fn notice(&mut self, level: Level, text: impl Into<String>) {
        self.show_notice(Notice::new(level, text));
    }

    fn show_notice(&mut self, notice: Notice) {
        let level = match notice.level {
            Level::Info => log::Level::Info,
            Level::Warning => log::Level::Warn,
            Level::Error => log::Level::Error,
        };
        log::log!(level, "{}", notice.text);
        self.n_notices += 1;
        self.notices.push(Notice { number: self.n_notices, ..notice });
        let surplus = self.notices.len().saturating_sub(MAX_NOTICES);
        self.notices.drain(..surplus);
    }
}
