//! Runs each frame of the window: takes finished results from the engine, executes commands and draws the panes.

mod questions;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use egui::{Panel, Ui};

use crate::{
    calibration::FitSettings,
    engine::{
        Action, Edit, Engine, Existing, FileContent, Level, Preferences, is_calibration,
        query::{Notify, let_window_go_first},
    },
    features::{F_TH, T_TH},
    questions::View,
    recording::Tare,
    ui::{
        actions::{self, CanGo},
        appearance,
        command::{Command, Out, Pane, PathFor, Workspace},
        command_palette::CommandPalette,
        dialogs::{Dialogs, Reply},
        dock,
        hand::Hand,
        help::Help,
        import_window::import_page,
        menu,
        notices::Notices,
        pane::Cx,
        panes::{Views, needs_calibration},
        picture::Images,
        presenter::Presenter,
        scope::Scope,
        setting, status_line, strip,
        time_view::TimeView,
        welcome,
        workspace::Workspaces,
    },
};
use questions::Questions;

/// Change of the text scale factor at each press of Ctrl+Plus or Ctrl+Minus.
const TEXT_STEP: f32 = 0.1;
const STATUS_HEIGHT: f32 = 24.0;
/// Height of the foot of the import page and of the list of exports, which notices do not cover (points).
const PAGE_FOOT: f32 = 100.0;

/// The program window: the engine, and the state of everything on screen.
pub struct Shell {
    engine: Engine,
    commands: VecDeque<Command>,
    inbox: Receiver<Command>,
    reply: Reply,
    dialogs: Box<dyn Dialogs>,
    workspaces: Workspaces,
    views: Views,
    places: Vec<(Pane, egui::Rect)>,
    time: TimeView,
    scope: Scope,
    hand: Hand,
    /// True if a text field of the import page had the focus in the last frame.
    was_typing: bool,
    questions: Questions,
    notices: Notices,
    palette: CommandPalette,
    help: Help,
    pictures: Images,
    presenter: Presenter,
    /// Settings of a model that is compared with the one before it.
    compared: Option<Box<FitSettings>>,
    /// True once the user agreed to close the window with unsaved changes.
    closing: bool,
    title: String,
    /// Number of the document for which the panes were made; see [`Engine::n_documents`].
    n_documents: u64,
    /// Preferences that the last frame used. Theme and text size are set again if the preferences have changed.
    looks: Option<(Preferences, f32)>,
}

impl Shell {
    /// Makes the engine search for the best thresholds whenever recordings are opened.
    #[must_use]
    pub fn finding_thresholds(mut self) -> Self {
        self.engine.finds_thresholds = true;
        self
    }

    /// Opens `files`, or the built-in simulated sensor if there are none.
    pub fn new(context: &egui::Context, files: Vec<PathBuf>, dialogs: Box<dyn Dialogs>) -> Self {
        let_window_go_first();
        appearance::prepare(context);
        let waker = context.clone();
        let notify: Notify = Arc::new(move || waker.request_repaint());
        let (commands, inbox): (Sender<Command>, _) = channel();
        let mut engine = Engine::new(Arc::clone(&notify));
        if files.iter().all(|path| is_calibration(path)) {
            engine.act(Action::OpenBuiltIn(None));
        }
        engine.act(Action::Open(files));
        Self {
            engine,
            commands: VecDeque::new(),
            inbox,
            reply: Reply { commands, notify },
            dialogs,
            workspaces: Workspaces::default(),
            views: Views::default(),
            places: Vec::new(),
            time: TimeView::default(),
            scope: Scope::default(),
            hand: Hand::default(),
            was_typing: false,
            questions: Questions::default(),
            notices: Notices::default(),
            palette: CommandPalette::default(),
            help: Help::default(),
            pictures: Images::default(),
            presenter: Presenter::default(),
            compared: None,
            closing: false,
            title: String::new(),
            n_documents: 0,
            looks: None,
        }
    }

    /// Applies the stored preferences.
    pub fn with_preferences(mut self, preferences: Preferences) -> Self {
        self.engine.preferences = preferences;
        self
    }

    /// Sets the folder in which unsaved work is stored in case of a crash. Offers the unsaved work of earlier crashes.
    pub fn with_recovery(mut self, folder: &Path) -> Self {
        self.engine.recover_in(folder);
        self
    }

    /// Returns the preferences to store.
    pub fn preferences(&self) -> Preferences {
        self.engine.preferences.clone()
    }

    /// Returns the engine.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Returns the interval of time that the traces show; `None` for the whole time.
    pub fn visible_time(&self) -> Option<(f64, f64)> {
        self.time.visible_time()
    }

    /// Returns the panes on screen.
    pub fn on_screen(&self) -> Vec<Pane> {
        self.workspaces.on_screen()
    }

    /// Returns true if work runs or waits to run.
    pub fn is_busy(&self) -> bool {
        !self.commands.is_empty() || self.engine.is_busy()
    }

    /// Sends a command, like a pane does.
    pub fn send(&mut self, command: impl Into<Command>) {
        self.commands.push_back(command.into());
    }

    /// Removes the stored unsaved work when the window closes normally.
    pub fn end(&mut self) {
        self.engine.end();
    }

    /// Runs one frame inside `ui`, which is the whole window.
    pub fn frame(&mut self, ui: &mut Ui) {
        self.engine.gesture = None;
        self.engine.take();
        // The commands of this frame were sent in the previous frame, so they belong to the mouse or key gesture of the
        // previous frame.
        self.engine.gesture = self.hand.gesture();
        self.commands.extend(self.inbox.try_iter());
        self.take_dropped_files(ui);
        while let Some(command) = self.commands.pop_front() {
            self.apply(command, ui);
        }
        self.follow_engine(ui);
        let mut out = Out::default();
        self.draw(ui, &mut out);
        self.hand.follow(ui.ctx());
        self.pictures.take(ui.ctx(), &self.reply);
        if !out.0.is_empty() {
            self.commands.extend(out.0);
            ui.request_repaint();
        }
        if self.is_busy() {
            ui.request_repaint_after(status_line::progress_interval(ui.ctx()));
        }
    }

    fn apply(&mut self, command: Command, ui: &Ui) {
        match command {
            Command::Do(action) => {
                if matches!(action, Action::Follow(_)) {
                    self.workspaces.bring(Pane::LIVE);
                }
                self.engine.act(action);
            }
            Command::ShowPane(pane) => self.workspaces.bring(pane),
            Command::Show(workspace) => self.workspaces.show(workspace),
            Command::ToggleMaximized(pane) => {
                let pointer = ui.ctx().pointer_latest_pos();
                let is_pointed =
                    |place: &egui::Rect| pointer.is_some_and(|pointer| place.contains(pointer));
                let pointed = self.places.iter().find(|(_, place)| is_pointed(place));
                let pointed = pointed.or(self.places.first()).map(|(pane, _)| *pane);
                self.workspaces.toggle_maximized(pane.or(pointed));
            }
            Command::TogglePresentedLoops => {
                self.presenter.shows_loops = !self.presenter.shows_loops;
            }
            Command::ToggleRight => self.workspaces.toggle_right(),
            Command::ToggleDrawer(pane) => self.workspaces.toggle_drawer(Some(pane)),
            Command::Axes(choice) => self.scope.show(choice, self.engine.project().axes()),
            Command::OtherRecording(step) => self.show_other_recording(step),
            Command::StepThreshold(along, steps) => {
                let thresholds = dock::stepped(&self.engine, along, steps);
                self.engine.act(Action::Edit(Edit::Thresholds(thresholds)));
            }
            Command::Remedy => {
                if let Some(command) = strip::remedy(&self.engine) {
                    self.apply(command, ui);
                }
            }
            Command::Compare(id) => {
                let present = self.engine.project().settings.clone();
                self.engine.act(Action::BringBack(id));
                let compared = Box::new(self.engine.project().settings.clone());
                self.compared = (*compared != present).then_some(compared);
                self.workspaces.show(Workspace::Calibrate);
                let text =
                    "The loads are those of the compared model. Escape restores the present model";
                self.engine.notice(Level::Info, text);
            }
            Command::TogglePresenter => {
                self.presenter.is_on = !self.presenter.is_on;
                let is_on = self.presenter.is_on;
                ui.send_viewport_cmd(egui::ViewportCommand::Fullscreen(is_on));
            }
            Command::ShowPalette => self.palette.open(),
            Command::FindSetting(setting) => {
                if [F_TH, T_TH].contains(&setting) && !self.workspaces.has_dock() {
                    self.workspaces.show(Workspace::Calibrate);
                } else if ![F_TH, T_TH].contains(&setting) {
                    self.workspaces.bring(Pane::SETTINGS);
                }
                setting::seek(ui.ctx(), setting);
            }
            Command::ToggleHelp => self.help.toggle(),
            Command::ShowGuide(page) => self.help.open_guide(page),
            Command::ShowAbout => self.help.open_about(),
            Command::ToggleNotices => self.notices.toggle_list(),
            Command::Time(time_move) => self.time.apply(time_move),
            Command::TextScale(step) => {
                let scale = &mut self.engine.preferences.text_scale;
                let (min, max) = Preferences::TEXT_SCALES.into_inner();
                let changed = (*scale + f32::from(step) * TEXT_STEP).clamp(min, max);
                *scale = if step == 0 { 1.0 } else { changed };
            }
            Command::Image(part, to) => self.pictures.ask(part, to),
            Command::TareBetweenCursors(at) => self.tare_between_cursors(at),
            Command::Choose(what) => self.dialogs.ask(what, self.reply.clone()),
            Command::TypePath(what) => self.questions.ask_path(what),
            Command::ChooseExport => {
                let content = self.engine.calibration_content();
                self.ask_where(content, "There is no calibration to export yet");
            }
            Command::ChooseReport => self.ask_where(Some(self.engine.report_content()), ""),
            Command::ChooseTraces => {
                let content = self.engine.traces_content(self.time.visible_time());
                self.ask_where(content, "There are no traces to save yet");
            }
            Command::SaveSession | Command::SaveSessionAs => {
                let content = self.engine.session_content();
                match self.engine.session.clone() {
                    Some(path) if matches!(command, Command::SaveSession) => {
                        self.engine.act(Action::Save(content, path, Existing::Replace));
                    }
                    _ => self.ask_where(Some(content), ""),
                }
            }
        }
    }

    fn ask_where(&mut self, content: Option<FileContent>, otherwise: &str) {
        match content {
            Some(content) => self.dialogs.ask(PathFor::Save(content), self.reply.clone()),
            None => self.engine.notice(Level::Error, otherwise),
        }
    }

    fn show_other_recording(&mut self, step: i8) {
        let n = self.engine.entries().len() as isize;
        let at = match self.engine.project().view {
            View::One(at) => at as isize + isize::from(step),
            View::All => 0,
        };
        if (0..n).contains(&at) {
            self.engine.act(Action::Show(View::One(at as usize)));
        }
    }

    fn tare_between_cursors(&mut self, at: usize) {
        let analysis = self.engine.analysis().filter(|_| self.engine.is_current());
        let span = analysis.and_then(|analysis| self.time.span_in(at, &analysis.traces));
        match span {
            Some((from, to)) => self.engine.act(Action::Tare(vec![at], Tare::Interval(from, to))),
            None => self.engine.notice(
                Level::Error,
                "To tare between the cursors: show this recording, click in a trace to set cursor A, and Shift+click to set cursor B",
            ),
        }
    }

    fn take_dropped_files(&mut self, ui: &Ui) {
        let dropped: Vec<PathBuf> = ui.input(|input| {
            let files = input.raw.dropped_files.iter();
            files.map(|file| file.path().to_owned()).collect()
        });
        if !dropped.is_empty() {
            self.send(Action::Open(dropped));
        }
    }

    /// Updates title, theme and panes from the engine. Asks before unsaved work is lost, and stores unsaved work.
    fn follow_engine(&mut self, ui: &Ui) {
        let larger = self.presenter.scale(ui.ctx());
        let looks = (self.engine.preferences.clone(), larger);
        if self.looks.as_ref() != Some(&looks) {
            appearance::apply(ui.ctx(), &looks.0, larger);
            self.looks = Some(looks);
        }
        // Another change of the settings ends the comparison, and keeps the model.
        self.compared.take_if(|settings| **settings != self.engine.project().settings);
        let is_typing = ui.ctx().text_edit_focused() || egui::Popup::is_any_open(ui.ctx());
        let escapes = !is_typing && ui.input(|input| input.key_pressed(egui::Key::Escape));
        if escapes && self.compared.take().is_some() {
            self.engine.act(Action::Undo);
        }
        let title = self.engine.title();
        if title != self.title {
            ui.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        if self.n_documents != self.engine.n_documents {
            self.n_documents = self.engine.n_documents;
            (self.views, self.time) = (Views::default(), TimeView::default());
            self.scope = Scope::default();
        }
        if std::mem::take(&mut self.engine.closes) {
            self.closing = true;
            ui.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        let is_asked = ui.input(|input| input.viewport().close_requested());
        if is_asked && !self.closing && self.engine.is_unsaved() {
            ui.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.send(Action::Close);
            ui.request_repaint();
        }
        self.scope.follow(&self.engine);
        self.engine.write_down();
    }

    fn draw(&mut self, ui: &mut Ui, out: &mut Out) {
        let history = &self.engine.history;
        let can = CanGo { undo: history.can_undo(), redo: history.can_redo() };
        self.palette.listen(ui.ctx());
        actions::listen(ui.ctx(), &self.engine, can, out);
        let mut asked = Vec::new();
        let is_empty = self.engine.entries().is_empty() && self.engine.following.asked().is_none();
        let engine = &self.engine;
        let presents = self.presenter.is_on;
        if presents && ui.input(|input| input.key_pressed(egui::Key::Escape)) {
            out.send(Command::TogglePresenter);
        }
        let (time, scope) = (&mut self.time, &mut self.scope);
        let cx = &mut Cx { engine, time, scope, presents, out: &mut *out, asked: &mut asked };
        let panel = egui::Frame::NONE.fill(ui.visuals().panel_fill);
        let bar = panel.inner_margin(egui::Margin::symmetric(8, 0));
        if !presents {
            Panel::top("menu").exact_size(menu::HEIGHT).frame(bar).show(ui, |ui| {
                menu::menu_bar(ui, engine, &self.workspaces, can, cx.out);
            });
            let top = Panel::top("strip").exact_size(strip::HEIGHT).frame(bar);
            top.show(ui, |ui| strip::strip(ui, cx));
            Panel::bottom("status").exact_size(STATUS_HEIGHT).frame(bar).show(ui, |ui| {
                status_line::status_line(ui, engine, cx.out);
            });
        }
        if !presents && self.workspaces.has_dock() && engine.importing.is_none() {
            let bottom = Panel::bottom("dock").exact_size(dock::HEIGHT).frame(panel);
            bottom.show(ui, |ui| dock::dock(ui, cx));
        }
        egui::CentralPanel::default().frame(panel).show(ui, |ui| {
            let places = &mut self.places;
            places.clear();
            if engine.importing.is_some() {
                let is_covered = self.help.is_open();
                return import_page(ui, engine, &mut self.was_typing, is_covered, cx.out);
            }
            if is_empty && !engine.is_busy() {
                return welcome::choices(ui, engine, cx.out);
            }
            if presents {
                return self.presenter.draw(ui, &mut self.views, cx);
            }
            self.workspaces.draw(ui, cx, &mut |ui, cx, pane| {
                places.push((pane, ui.max_rect()));
                let missing = engine.project().missing();
                if let Some(missing) = missing.filter(|_| needs_calibration(pane)) {
                    ui.centered_and_justified(|ui| ui.weak(format!("Waits: {missing}")));
                } else if let Some(view) = self.views.of(pane) {
                    view.ui(ui, cx);
                }
            });
        });
        if !presents {
            let mut hero = self.places.first().map_or(ui.ctx().content_rect(), |(_, place)| *place);
            // The foot of these pages has the button that ends the work.
            if self.engine.importing.is_some() || self.workspaces.shown() == Workspace::Export {
                hero.max.y -= PAGE_FOOT;
            }
            self.notices.show(ui, &self.engine, hero, out);
        }
        asked.into_iter().for_each(|asked| self.engine.ask_for(asked));
        let engine = &self.engine;
        self.help.show(ui.ctx(), &|| actions::all(engine, can));
        self.palette.show(ui.ctx(), engine, can, out);
        self.questions.show(ui.ctx(), engine, out);
    }
}
