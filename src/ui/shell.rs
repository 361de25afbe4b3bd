//! One frame after another: finished work in, commands applied, effects carried out, panels drawn.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use crate::analysis::{
    Analysis, AnalysisError, Analyst, HistoryBlock, Request, Study, compare, train,
};
use crate::app::{
    AppState, Command, ComparisonCommand, Effect, FileContent, Level, Notice, Opened, OpenedFile,
    Pane, StudyCommand, StudyRequest, TrainingCommand,
};
use crate::evaluation::threshold_study::ScoreSet;
use crate::export::{
    WriteError, read_calibration, write_atomically, write_calibration, write_comparison_csv,
    write_metrology_csv, write_threshold_map,
};
use crate::panicked::caught;
use crate::progress::Progress;
use crate::recording::{RecordingSet, delimited, simulated};
use crate::ui::dialogs::Reply;
use crate::ui::looking::Looking;
use crate::ui::loops_pane::LoopsPane;
use crate::ui::metrology_pane::MetrologyPane;
use crate::ui::status_line::Running;
use crate::ui::study_worker;
use crate::ui::thresholds_pane::{self, MapTexture};
use crate::ui::trace_panes::{TracePanes, trace_panes};
use crate::ui::{
    Dialogs, calibration_pane, compare_pane, errors_pane, menu, notices_panel, recordings_panel,
    settings_panel, status_line,
};
use crate::worker::{Job, Notify, Worker};

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
    /// The recordings of the newest request, and the first request that was for them.
    analysed: (Arc<RecordingSet>, u64),
    reading: Vec<Job<Vec<OpenedFile>>>,
    simulating: Option<Job<RecordingSet>>,
    writing: Vec<Job<Command>>,
    training: Vec<Job<Command>>,
    comparing: Vec<Job<Command>>,
    choosing: Vec<Job<Command>>,
    dialogs: Box<dyn Dialogs>,
    fields: Fields,
    panes: TracePanes,
    map: MapTexture,
    looking: Looking,
    loops: LoopsPane,
    metrology: MetrologyPane,
}

/// What stands in the window's text fields.
#[derive(Debug)]
pub struct Fields {
    /// The path to open.
    pub open: String,
    /// The path to export to.
    pub export: String,
    /// The share of a split that trains (%).
    pub split_percent: f64,
    /// The path to save the comparison to.
    pub comparison: String,
    /// Which errors the comparison shows.
    pub errors_on: compare_pane::ErrorsOn,
    /// The path to save the map of thresholds to.
    pub study: String,
    /// Which errors the map shows.
    pub study_on: ScoreSet,
}

impl Shell {
    /// Starts the threads; opens `files`, or the built-in sensor if there are none.
    #[must_use]
    pub fn new(context: &egui::Context, files: Vec<PathBuf>, dialogs: Box<dyn Dialogs>) -> Self {
        let waker = context.clone();
        let notify: Notify = Arc::new(move || waker.request_repaint());
        let (post, inbox) = channel();
        let only_calibrations = files.iter().all(|path| is_calibration(path));
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
            analysed: Default::default(),
            looking: Looking::start(Arc::clone(&notify)),
            notify,
            post,
            reading: Vec::new(),
            simulating: None,
            writing: Vec::new(),
            training: Vec::new(),
            comparing: Vec::new(),
            choosing: Vec::new(),
            dialogs,
            fields: Fields {
                open: String::new(),
                export: "calibration.json".to_owned(),
                split_percent: 60.0,
                comparison: "comparison.csv".to_owned(),
                errors_on: Default::default(),
                study: "thresholds.csv".to_owned(),
                study_on: ScoreSet::LeftOut,
            },
            panes: TracePanes::default(),
            map: MapTexture::default(),
            loops: LoopsPane::default(),
            metrology: MetrologyPane::default(),
        }
    }

    /// The program's state, as the panels see it.
    #[must_use]
    pub fn state(&self) -> &AppState {
        &self.state
    }

    /// Whether anything runs or waits to run.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        !self.commands.is_empty()
            || !self.reading.is_empty()
            || !self.writing.is_empty()
            || !self.training.is_empty()
            || !self.comparing.is_empty()
            || !self.choosing.is_empty()
            || !self.study.is_idle()
            || self.simulating.is_some()
            || !self.analysis.is_idle()
            || !self.looking.is_idle()
    }

    /// Asks for something as a panel would.
    pub fn send(&mut self, command: Command) {
        self.commands.push_back(command);
    }

    /// Runs one frame inside `ui`, which is the whole window.
    pub fn frame(&mut self, ui: &mut egui::Ui) {
        self.take_finished_work();
        self.looking.take_answers();
        self.take_dropped_files(ui);
        while let Some(command) = self.commands.pop_front() {
            self.apply(command);
        }
        let mut wishes = Vec::new();
        self.draw(ui, &mut wishes);
        self.ask();
        if !wishes.is_empty() {
            self.commands.extend(wishes);
            ui.request_repaint();
        }
        if self.is_busy() {
            ui.request_repaint_after(PROGRESS_INTERVAL);
        }
    }

    /// Asks for what the pane in the middle shows; it was drawn, so its choices are those of now.
    fn ask(&mut self) {
        let question = match self.state.pane {
            Pane::Loops => self.loops.question(&self.state),
            Pane::Metrology => self.metrology.question(&self.state),
            _ => None,
        };
        let visible = self.panes.visible_time();
        self.looking.ask(&self.state, visible, question);
    }

    fn apply(&mut self, command: Command) {
        for effect in self.state.apply(command) {
            self.carry_out(effect);
        }
    }

    fn take_finished_work(&mut self) {
        self.commands.extend(self.inbox.try_iter());
        while let Some(answer) = self.analysis.answer() {
            if answer.generation < self.analysed.1 && answer.result.is_ok() {
                continue; // the recordings are others now
            }
            let is_newest = answer.generation == self.analysis.newest();
            let outcome = match answer.result {
                Ok(Ok(analysis)) => Ok(Arc::new(analysis)),
                // Cancelled by a newer request, or by the user, who knows.
                Ok(Err(AnalysisError::Cancelled(_))) => continue,
                Ok(Err(error)) if is_newest => Err(error.to_string()),
                Ok(Err(_)) => continue,
                Err(panicked) => Err(panicked.to_string()),
            };
            // Before any wish, which may change the recordings that it is about.
            self.apply(Command::Analysed(outcome));
        }
        finish(&mut self.reading, &mut self.commands, Command::FilesOpened);
        while let Some(answer) = self.study.answer() {
            if let Err(panicked) = answer.result {
                let notice = Notice::new(Level::Error, panicked.to_string());
                self.commands.push_back(Command::Tell(notice));
            }
        }
        for jobs in [
            &mut self.writing,
            &mut self.training,
            &mut self.comparing,
            &mut self.choosing,
        ] {
            finish(jobs, &mut self.commands, |command| command);
        }
        let mut simulating: Vec<_> = self.simulating.take().into_iter().collect();
        finish(&mut simulating, &mut self.commands, Command::BuiltInReady);
        self.simulating = simulating.pop();
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

    fn carry_out(&mut self, effect: Effect) {
        let notify = Arc::clone(&self.notify);
        match effect {
            Effect::Analyse(request) => {
                let recordings = Arc::clone(&request.recordings);
                let generation = self.analysis.request(request);
                if !Arc::ptr_eq(&recordings, &self.analysed.0) {
                    self.analysed = (recordings, generation);
                }
            }
            Effect::Read(paths) => {
                let title = match &paths[..] {
                    [one] => format!("Reading {}", file_name(one)),
                    many => format!("Reading {} files", many.len()),
                };
                let job = Job::start(title, notify, move |progress| read_files(paths, progress));
                self.reading.push(job);
            }
            Effect::Simulate => {
                self.simulating =
                    Some(Job::start("Simulating the built-in sensor", notify, |_| {
                        simulated::recordings(simulated::DEFAULT_SEED)
                    }));
            }
            Effect::AskForFiles => {
                let reply = self.reply();
                self.dialogs.open_files(reply);
            }
            Effect::AskForExport => {
                let reply = self.reply();
                self.dialogs.export(reply);
            }
            Effect::Write(calibration, path) => {
                self.write(path, move |path| write_calibration(&calibration, path));
            }
            Effect::Train(request) => {
                let reply = self.reply();
                self.training
                    .push(Job::start("Training", notify, move |progress| {
                        let trained = caught(|| {
                            train(&request, progress, &mut |report| {
                                reply.send(Command::Training(TrainingCommand::Epoch(report)));
                            })
                        });
                        let trained = match trained {
                            Ok(trained) => trained.map(Arc::new).map_err(|error| error.to_string()),
                            Err(panicked) => Err(panicked.to_string()),
                        };
                        // The same way as the epochs, so that it comes after the last of them.
                        reply.send(Command::Training(TrainingCommand::Ended(trained)));
                        Command::Nothing
                    }));
            }
            Effect::StopTraining => self.training.iter().for_each(|job| job.progress.cancel()),
            Effect::Compare {
                run,
                recordings,
                settings,
                candidates,
            } => {
                let reply = self.reply();
                let title = "Comparing regressors";
                self.comparing
                    .push(Job::start(title, notify, move |progress| {
                        compare(
                            &recordings,
                            &settings,
                            &candidates,
                            progress,
                            &|at, event| {
                                let heard = ComparisonCommand::Heard(run, at, Box::new(event));
                                reply.send(Command::Comparison(heard));
                            },
                        );
                        reply.send(Command::Comparison(ComparisonCommand::Ended(run)));
                        Command::Nothing
                    }));
            }
            Effect::Study(request) => {
                self.study.request(request);
            }
            Effect::ChooseBlock {
                block,
                measure,
                recordings,
                settings,
            } => {
                let title = match block {
                    HistoryBlock::Play => "Choosing play radii",
                    HistoryBlock::Creep => "Choosing creep times",
                };
                self.choosing
                    .push(Job::start(title, notify, move |progress| {
                        let chosen = caught(|| {
                            let study = Study::lay(recordings, settings, progress)?;
                            let measure =
                                measure.unwrap_or_else(|| study.scale().default_measure());
                            study.suggest_block(block, measure, progress)
                        });
                        let chosen = match chosen {
                            Ok(chosen) => chosen.map_err(|error| error.to_string()),
                            Err(panicked) => Err(panicked.to_string()),
                        };
                        Command::Study(StudyCommand::Chosen(chosen))
                    }));
            }
            Effect::WriteStudy(map, measure, path) => {
                self.write(path, move |path| write_threshold_map(&map, measure, path))
            }
            Effect::StopComparing => self.comparing.iter().for_each(|job| job.progress.cancel()),
            Effect::WriteComparison(rows, path) => self.write(path, move |path| {
                write_atomically(path, |out| write_comparison_csv(&rows, out))
            }),
            Effect::WriteFile(content, path) => self.write(path, move |path| {
                write_atomically(path, |out| match &content {
                    FileContent::Metrology(table) => write_metrology_csv(table, out),
                    FileContent::Bytes(bytes) => out.write_all(bytes),
                })
            }),
            Effect::CancelWork => {
                self.analysis.cancel();
                self.looking.cancel();
                // It cannot be stopped, but nobody waits for it any more.
                self.simulating = None;
                self.study.cancel();
                let stopped = (self.training.iter().chain(&self.comparing)).chain(&self.choosing);
                stopped.for_each(|job| job.progress.cancel());
                for job in &self.reading {
                    job.progress.cancel();
                }
            }
        }
    }

    fn reply(&self) -> Reply {
        Reply {
            commands: self.post.clone(),
            notify: Arc::clone(&self.notify),
        }
    }

    /// Writes a file off the window's thread.
    fn write(
        &mut self,
        path: PathBuf,
        write: impl FnOnce(&Path) -> Result<(), WriteError> + Send + 'static,
    ) {
        // The notice about it must say where a relative path led.
        let path = std::path::absolute(&path).unwrap_or(path);
        let title = format!("Writing {}", file_name(&path));
        self.writing
            .push(Job::start(title, Arc::clone(&self.notify), move |_| {
                let written = write(&path);
                Command::Exported(path, written.map_err(|error| error.to_string()))
            }));
    }

    fn draw(&mut self, ui: &mut egui::Ui, out: &mut Vec<Command>) {
        let state = &self.state;
        egui::Panel::top("menu").show(ui, |ui| menu::menu_bar(ui, state, out));
        egui::Panel::bottom("status").show(ui, |ui| {
            let jobs = (self.reading.iter().map(Running::from))
                .chain(self.simulating.iter().map(Running::from))
                .chain(self.training.iter().map(Running::from))
                .chain(self.comparing.iter().map(Running::from))
                .chain(self.choosing.iter().map(Running::from));
            status_line::status_line(ui, state, jobs, self.analysis.running(), out);
        });
        if !state.notices.is_empty() {
            egui::Panel::bottom("notices")
                .resizable(true)
                .default_size(90.0)
                .show(ui, |ui| notices_panel::notices_panel(ui, state, out));
        }
        egui::Panel::left("recordings")
            .resizable(true)
            .default_size(420.0)
            .min_size(240.0)
            .show(ui, |ui| {
                egui::Panel::bottom("settings")
                    .resizable(true)
                    .default_size(350.0)
                    .min_size(120.0)
                    .show(ui, |ui| {
                        egui::ScrollArea::vertical()
                            .auto_shrink([false, false])
                            .show(ui, |ui| settings_panel::settings_panel(ui, state, out));
                    });
                egui::CentralPanel::no_frame().show(ui, |ui| {
                    recordings_panel::recordings_panel(ui, state, &mut self.fields, out);
                });
            });
        egui::Panel::bottom("results")
            .resizable(true)
            .default_size(218.0)
            .min_size(60.0)
            .show(ui, |ui| {
                egui::Panel::left("errors")
                    .resizable(true)
                    .default_size(0.675 * ui.available_width())
                    .frame(egui::Frame::NONE)
                    .show(ui, |ui| errors_pane::errors_pane(ui, state));
                let beside = egui::Frame::NONE.inner_margin(egui::Margin {
                    left: 8,
                    ..Default::default()
                });
                egui::CentralPanel::no_frame().frame(beside).show(ui, |ui| {
                    calibration_pane::calibration_pane(ui, state, &mut self.fields, out);
                });
            });
        egui::CentralPanel::default().show(ui, |ui| {
            ui.horizontal(|ui| {
                for (pane, label, explanation) in [
                    (Pane::Traces, "Traces", "Loads and errors over time"),
                    (
                        Pane::Thresholds,
                        "Thresholds",
                        "The map of F_th and t_th, and which pair to take",
                    ),
                    (
                        Pane::Compare,
                        "Compare",
                        "Every regressor without and with the past",
                    ),
                    (
                        Pane::Loops,
                        "Loops",
                        "Hysteresis loops, cross-plots, and drift at rest",
                    ),
                    (
                        Pane::Metrology,
                        "Metrology",
                        "The figures of a certificate, Conv. beside Comp.",
                    ),
                ] {
                    let tab = ui.selectable_label(state.pane == pane, label);
                    if tab.on_hover_text(explanation).clicked() {
                        out.push(Command::ShowPane(pane));
                    }
                }
            });
            match state.pane {
                Pane::Traces => trace_panes(ui, state, &mut self.panes, out),
                Pane::Thresholds => {
                    let (fields, map) = (&mut self.fields, &mut self.map);
                    thresholds_pane::thresholds_pane(ui, state, fields, map, out);
                }
                Pane::Compare => compare_pane::compare_pane(ui, state, &mut self.fields, out),
                Pane::Loops => {
                    let reply = || Reply {
                        commands: self.post.clone(),
                        notify: Arc::clone(&self.notify),
                    };
                    self.loops.show(ui, state, &self.looking, &reply, out);
                }
                Pane::Metrology => self.metrology.show(ui, state, &self.looking, out),
            }
        });
    }
}

/// Takes the results of finished jobs.
fn finish<A: Send + 'static>(
    jobs: &mut Vec<Job<A>>,
    commands: &mut VecDeque<Command>,
    command: impl Fn(A) -> Command,
) {
    jobs.retain(|job| match job.result() {
        None => true,
        Some(result) => {
            commands.push_back(match result {
                Ok(result) => command(result),
                Err(panicked) => Command::Tell(Notice::new(
                    Level::Error,
                    format!("{}: {panicked}", job.title),
                )),
            });
            false
        }
    });
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

fn is_calibration(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("json"))
}

/// Reads files one after another; what was read before a cancel is kept.
fn read_files(paths: Vec<PathBuf>, progress: &Progress) -> Vec<OpenedFile> {
    for path in &paths {
        // A file that cannot be asked for its size is reported when it is read.
        progress.add_total(std::fs::metadata(path).map_or(0, |metadata| metadata.len()));
    }
    let mut read = Vec::new();
    for path in paths {
        let opened = if is_calibration(&path) {
            read_calibration(&path)
                .map(|calibration| Opened::Calibration(Arc::new(calibration)))
                .map_err(|error| error.to_string())
        } else {
            delimited::read(&path, progress)
                .map(Opened::Recordings)
                .map_err(|error| error.to_string())
        };
        if progress.is_cancelled() {
            break;
        }
        read.push((path, opened));
    }
    read
}
