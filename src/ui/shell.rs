//! One frame after another: finished work in, commands applied, effects carried out, panes drawn.

mod drawing;
mod jobs;
mod sessions;
mod wishes;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use crate::analysis::{Analysis, AnalysisError, Analyst, Request};
use crate::app::{AppState, Command, KnownOf, Pane, Preferences, SessionCommand, StudyRequest};
use crate::progress::Progress;
use crate::recording::RecordingSet;
use crate::ui::Dialogs;
use crate::ui::actions::CanGo;
use crate::ui::appearance;
use crate::ui::command_palette::CommandPalette;
use crate::ui::dialogs::Reply;
use crate::ui::fields::Fields;
use crate::ui::hand::Hand;
use crate::ui::help::Help;
use crate::ui::import_window::ImportFields;
use crate::ui::looking::Looking;
use crate::ui::loops_pane::LoopsPane;
use crate::ui::metrology_pane::MetrologyPane;
use crate::ui::picture::Pictures;
use crate::ui::recovery::Recovery;
use crate::ui::study_worker;
use crate::ui::thresholds_pane::MapTexture;
use crate::ui::tour::Tour;
use crate::ui::trace_panes::TracePanes;
use crate::ui::workspace::Workspace;
use crate::engine::query::{Notify, Worker, let_window_go_first};
use jobs::Jobs;

/// How often progress bars move while something runs.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(50);

/// The program behind the window: state, threads, and what only the window remembers.
pub struct Shell {
    state: AppState,
    commands: VecDeque<Command>,
    inbox: Receiver<Command>,
    post: Sender<Command>,
    notify: Notify,
    analysis: Worker<Request, Result<Analysis, AnalysisError>>,
    study: Worker<StudyRequest, ()>,
    /// Looks at files for the import window.
    inspecting: Worker<(PathBuf, KnownOf), Command>,
    /// The recordings of the newest request, and the first request that was for them.
    analysed: (Arc<RecordingSet>, u64),
    jobs: Jobs,
    dialogs: Box<dyn Dialogs>,
    workspace: Workspace,
    hand: Hand,
    fields: Fields,
    import_fields: ImportFields,
    panes: TracePanes,
    map: MapTexture,
    loops: LoopsPane,
    metrology: MetrologyPane,
    /// Answers for the loops, and for the table beside them.
    looking: [Looking; 2],
    palette: CommandPalette,
    help: Help,
    tour: Tour,
    pictures: Pictures,
    /// Whether somebody came with files: then the tour on the built-in sensor is not what they want.
    was_given_files: bool,
    /// Whether the window may close, whatever is not saved.
    closing: bool,
    /// The title that the window has.
    title: String,
    recovery: Recovery,
    /// The preferences that the window looks like.
    looks: Option<Preferences>,
}

impl Shell {
    /// Starts the threads; opens `files`, or the built-in sensor if there are none.
    #[must_use]
    pub fn new(context: &egui::Context, files: Vec<PathBuf>, dialogs: Box<dyn Dialogs>) -> Self {
        let_window_go_first();
        appearance::prepare(context);
        let waker = context.clone();
        let notify: Notify = Arc::new(move || waker.request_repaint());
        let (post, inbox) = channel();
        let was_given_files = !files.is_empty();
        let only_calibrations = files.iter().all(|path| jobs::is_calibration(path));
        let mut commands = VecDeque::new();
        if only_calibrations {
            commands.push_back(Command::OpenBuiltIn);
        }
        if !files.is_empty() {
            commands.push_back(Command::OpenFiles(files));
        }
        Self {
            state: AppState::default(),
            commands,
            inbox,
            analysis: Worker::start("analysis", Arc::clone(&notify), || {
                let mut analyst = Analyst::default();
                move |request: Request, progress: &Progress| analyst.analyse(&request, progress)
            }),
            study: study_worker::start(Reply {
                commands: post.clone(),
                notify: Arc::clone(&notify),
            }),
            inspecting: Worker::start("import", Arc::clone(&notify), || jobs::look_at),
            analysed: Default::default(),
            looking: [(); 2].map(|()| Looking::start(Arc::clone(&notify))),
            notify,
            post,
            jobs: Jobs::default(),
            dialogs,
            workspace: Workspace::default(),
            hand: Hand::default(),
            fields: Fields::default(),
            import_fields: ImportFields::default(),
            panes: TracePanes::default(),
            map: MapTexture::default(),
            loops: LoopsPane::default(),
            metrology: MetrologyPane::default(),
            palette: CommandPalette::default(),
            help: Help::default(),
            tour: Tour::default(),
            pictures: Pictures::default(),
            was_given_files,
            closing: false,
            title: String::new(),
            recovery: Recovery::default(),
            looks: None,
        }
    }

    /// Takes over what was remembered of a person; begins the tour for one who has not had it.
    #[must_use]
    pub fn with_preferences(mut self, preferences: Preferences) -> Self {
        if let Some(layout) = preferences.layout.as_ref().and_then(Workspace::from_value) {
            self.workspace = layout;
        }
        if !preferences.toured && !self.was_given_files {
            self.tour.begin();
        }
        self.state.preferences = preferences;
        self
    }

    /// What is to be remembered.
    #[must_use]
    pub fn preferences(&self) -> Preferences {
        Preferences {
            layout: Some(self.workspace.to_value()),
            ..self.state.preferences.clone()
        }
    }

    /// The program's state, as the panels see it.
    #[must_use]
    pub fn state(&self) -> &AppState {
        &self.state
    }

    /// The stretch of time that the traces show; `None` where it is all of it.
    #[must_use]
    pub fn visible_time(&self) -> Option<(f64, f64)> {
        self.panes.visible_time()
    }

    /// Whether anything runs or waits to run.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        !self.commands.is_empty()
            || !self.jobs.is_empty()
            || !self.inspecting.is_idle()
            || !self.study.is_idle()
            || !self.analysis.is_idle()
            || !self.looking.iter().all(Looking::is_idle)
    }

    /// Asks for something as a panel would.
    pub fn send(&mut self, command: Command) {
        self.commands.push_back(command);
    }

    /// Runs one frame inside `ui`, which is the whole window.
    pub fn frame(&mut self, ui: &mut egui::Ui) {
        self.take_finished_work();
        for looking in &mut self.looking {
            looking.take_answers();
        }
        self.take_dropped_files(ui);
        while let Some(command) = self.commands.pop_front() {
            self.apply(command, ui);
        }
        // They were wished for in the frame before.
        let choices = self.state.choices();
        self.state.history.follow(choices, self.hand.gesture());
        self.follow_preferences(ui);
        self.follow_session(ui);
        let mut wishes = Vec::new();
        self.draw(ui, &mut wishes);
        self.hand.follow(ui.ctx());
        self.pictures.take(ui.ctx(), &self.reply());
        let on_screen = self.workspace.on_screen();
        if on_screen != self.state.on_screen {
            wishes.push(Command::PanesOnScreen(on_screen));
        }
        self.ask();
        if !wishes.is_empty() {
            self.commands.extend(wishes);
            ui.request_repaint();
        }
        if self.is_busy() {
            ui.request_repaint_after(PROGRESS_INTERVAL);
        }
    }

    /// Asks for what the panes on screen show; they were drawn, so their choices are those of now.
    fn ask(&mut self) {
        let visible = self.panes.visible_time();
        let questions = [
            (Pane::Loops, self.loops.question(&self.state)),
            (Pane::Metrology, self.metrology.question(&self.state)),
        ];
        for ((pane, question), looking) in questions.into_iter().zip(&mut self.looking) {
            let question = question.filter(|_| self.state.on_screen.contains(&pane));
            looking.ask(&self.state, visible, question);
        }
    }

    fn apply(&mut self, command: Command, ui: &egui::Ui) {
        for effect in self.state.apply(command) {
            self.carry_out(effect, ui);
        }
    }

    fn take_dropped_files(&mut self, ui: &egui::Ui) {
        let dropped: Vec<PathBuf> = ui.input(|input| {
            let files = input.raw.dropped_files.iter();
            files.map(|file| file.path().to_owned()).collect()
        });
        if !dropped.is_empty() {
            self.commands.push_back(Command::OpenFiles(dropped));
        }
    }

    fn follow_preferences(&mut self, ui: &egui::Ui) {
        if self.looks.as_ref() != Some(&self.state.preferences) {
            appearance::apply(ui.ctx(), &self.state.preferences);
            self.looks = Some(self.state.preferences.clone());
        }
    }

    /// Keeps the title true, asks before something is lost, and writes down what is not saved.
    fn follow_session(&mut self, ui: &egui::Ui) {
        let title = self.state.title();
        if title != self.title {
            ui.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        if ui.input(|input| input.viewport().close_requested())
            && !self.closing
            && self.state.is_unsaved()
        {
            ui.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.commands
                .push_back(Command::Session(SessionCommand::Close));
            ui.request_repaint();
        }
        self.recovery.follow(&self.state, &self.workspace, ui.ctx());
    }

    /// Where to write down what is not saved, so that it survives a crash; offers what others left behind.
    #[must_use]
    pub fn with_recovery(mut self, folder: &Path) -> Self {
        let (recovery, left) = Recovery::begin(folder);
        self.recovery = recovery;
        self.state.recoverable = left;
        self
    }

    /// The window closes as it should: nothing needs to be recovered.
    pub fn end(&mut self) {
        self.recovery.end();
    }

    fn can_go(&self) -> CanGo {
        CanGo {
            undo: self.state.history.can_undo(),
            redo: self.state.history.can_redo(),
            zoom_back: self.panes.can_go_back(),
            zoom_forward: self.panes.can_go_forward(),
        }
    }

    fn reply(&self) -> Reply {
        Reply {
            commands: self.post.clone(),
            notify: Arc::clone(&self.notify),
        }
    }
}
