//! Background work: what effects start, and what comes of it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::analysis::{
    AnalysisError, Study, compare, comparison_table, report, stretches_on_screen, train,
};
use crate::app::{
    Command, ComparisonCommand, Effect, Existing, FileContent, ImportCommand, KnownOf, Level,
    Notice, Opened, OpenedFile, SessionCommand, StudyCommand, TrainingCommand,
};
use crate::evaluation::threshold_study::ScoreSet;
use crate::export::{
    CalibrationFormat, ReportData, TargetError, WriteError, check_targets, read_calibration,
    threshold_map_files, with_sources, write_atomically, write_calibration, write_report,
    write_threshold_map, write_traces,
};
use crate::panicked::caught;
use crate::progress::Progress;
use crate::recording::columns::ColumnMap;
use crate::recording::delimited::inspect::{Known, inspect, map_for};
use crate::recording::delimited::{self, ReadError};
use crate::recording::{Recording, RecordingSet, Source, Tare, simulated};
use crate::report::figure_records;
use crate::ui::SaveAs;
use crate::ui::recovery::drop_left;
use crate::ui::shell::{Shell, sessions};
use crate::ui::status_line::Running;
use crate::worker::Job;

/// What a job does; some can be cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Read,
    Simulate,
    Train,
    Compare,
    Choose,
    /// Takes its time, so it can be seen and cancelled.
    Report,
    /// Ends by itself, so that no file is left half written.
    Write,
}

/// The jobs that run.
#[derive(Default)]
pub struct Jobs(Vec<(Kind, Job<Command>)>);

impl Jobs {
    /// Whether none runs.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What the status line shows of them.
    pub fn running(&self) -> impl Iterator<Item = Running<'_>> {
        let worth_showing = |kind: &Kind| *kind != Kind::Write;
        (self.0.iter())
            .filter(move |(kind, _)| worth_showing(kind))
            .map(|(_, job)| Running::from(job))
    }

    fn cancel(&mut self, which: impl Fn(Kind) -> bool) {
        for (_, job) in self.0.iter().filter(|(kind, _)| which(*kind)) {
            job.progress.cancel();
        }
    }

    /// The results of jobs that have ended.
    fn finished(&mut self) -> Vec<Command> {
        let mut commands = Vec::new();
        self.0.retain(|(_, job)| match job.result() {
            None => true,
            Some(result) => {
                log::info!(
                    "ended after {:.3} s: {}",
                    job.since.elapsed().as_secs_f64(),
                    job.title
                );
                commands.push(result.unwrap_or_else(|panicked| {
                    let text = format!("{}: {panicked}", job.title);
                    Command::Tell(Notice::new(Level::Error, text))
                }));
                false
            }
        });
        commands
    }
}

impl Shell {
    pub(super) fn take_finished_work(&mut self) {
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
            self.state.apply(Command::Analysed(outcome));
        }
        while let Some(answer) = self.study.answer() {
            if let Err(panicked) = answer.result {
                let notice = Notice::new(Level::Error, panicked.to_string());
                self.commands.push_back(Command::Tell(notice));
            }
        }
        while let Some(answer) = self.inspecting.answer() {
            if answer.generation == self.inspecting.newest() {
                let command = answer.result.unwrap_or_else(|panicked| {
                    Command::Tell(Notice::new(Level::Error, panicked.to_string()))
                });
                self.commands.push_back(command);
            }
        }
        self.commands.extend(self.jobs.finished());
    }

    fn start(
        &mut self,
        kind: Kind,
        title: impl Into<String>,
        work: impl FnOnce(&Progress) -> Command + Send + 'static,
    ) {
        let title = title.into();
        log::info!("begins: {title}");
        let job = Job::start(title, Arc::clone(&self.notify), work);
        self.jobs.0.push((kind, job));
    }

    pub(super) fn carry_out(&mut self, effect: Effect, ui: &egui::Ui) {
        match effect {
            Effect::Analyse(request) => {
                let recordings = Arc::clone(&request.recordings);
                let generation = self.analysis.request(request);
                if !Arc::ptr_eq(&recordings, &self.analysed.0) {
                    self.analysed = (recordings, generation);
                }
            }
            Effect::Read(files, remembered) => {
                let title = match &files[..] {
                    [(one, _)] => format!("Reading {}", file_name(one)),
                    many => format!("Reading {} files", many.len()),
                };
                self.start(Kind::Read, title, move |progress| {
                    let files = with_folders_opened(files);
                    Command::FilesOpened(read_files(files, &remembered, progress))
                });
            }
            Effect::Tare(recordings, which, tare) => {
                self.start(Kind::Read, "Taring", move |_| {
                    let tared = tared(&recordings, &which, tare);
                    Command::Tared(recordings, tared)
                });
            }
            Effect::Inspect(path, known) => {
                self.inspecting.request((path, known));
            }
            Effect::ReadMap(path) => self.start(Kind::Read, "Reading a column map", move |_| {
                let read = ColumnMap::read(&path).map(Box::new);
                Command::Import(ImportCommand::MapRead(
                    read.map_err(|error| error.to_string()),
                ))
            }),
            Effect::EstimateWeight(path, map) => {
                self.start(Kind::Read, "Finding the weight", move |progress| {
                    let found = delimited::estimate_weight(&path, &map, progress);
                    let found = found.map(Box::new).map_err(|error| error.to_string());
                    Command::Import(ImportCommand::WeightEstimated(path, found))
                });
            }
            Effect::Restore(path) => self.start(Kind::Read, "Restoring", move |progress| {
                let opened = sessions::read(&path, progress).map(Box::new);
                match progress.is_cancelled() {
                    true => Command::Nothing,
                    false => Command::Session(SessionCommand::Recovered(path, opened)),
                }
            }),
            Effect::DropLeft(path) => {
                self.recovery.hurry();
                drop_left(&path);
            }
            Effect::AskForImport => {
                let reply = self.reply();
                self.dialogs.import(reply);
            }
            Effect::Simulate => {
                self.start(Kind::Simulate, "Simulating the built-in sensor", |_| {
                    Command::BuiltInReady(simulated::recordings(simulated::DEFAULT_SEED))
                })
            }
            Effect::AskForFiles => {
                let reply = self.reply();
                self.dialogs.open_files(reply);
            }
            Effect::AskWhere(content, name) => {
                let reply = self.reply();
                self.dialogs.save(SaveAs { content, name }, reply);
            }
            Effect::Write(content, path, existing) => self.write(content, path, existing),
            Effect::Train(request) => {
                let reply = self.reply();
                self.start(Kind::Train, "Training", move |progress| {
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
                });
            }
            Effect::StopTraining => self.jobs.cancel(|kind| kind == Kind::Train),
            Effect::Compare {
                run,
                recordings,
                settings,
                candidates,
            } => {
                let reply = self.reply();
                self.start(Kind::Compare, "Comparing regressors", move |progress| {
                    let tell = |at, event| {
                        let heard = ComparisonCommand::Heard(run, at, Box::new(event));
                        reply.send(Command::Comparison(heard));
                    };
                    compare(&recordings, &settings, &candidates, progress, &tell);
                    reply.send(Command::Comparison(ComparisonCommand::Ended(run)));
                    Command::Nothing
                });
            }
            Effect::StopComparing => self.jobs.cancel(|kind| kind == Kind::Compare),
            Effect::Study(request) => {
                self.study.request(request);
            }
            Effect::ChooseBlock {
                block,
                measure,
                recordings,
                settings,
            } => {
                let title = format!("Choosing {}", block.setting().label.to_lowercase());
                self.start(Kind::Choose, title, move |progress| {
                    let chosen = caught(|| {
                        let study = Study::lay(recordings, settings, progress)?;
                        let measure = measure.unwrap_or_else(|| study.scale().default_measure());
                        study.suggest_block(block, measure, progress)
                    });
                    let chosen = match chosen {
                        Ok(chosen) => chosen.map_err(|error| error.to_string()),
                        Err(panicked) => Err(panicked.to_string()),
                    };
                    Command::Study(StudyCommand::Chosen(chosen))
                });
            }
            Effect::CancelWork => {
                self.analysis.cancel();
                self.looking.iter().for_each(|looking| looking.cancel());
                self.study.cancel();
                // It cannot be stopped, but nobody waits for it any more.
                self.jobs.0.retain(|(kind, _)| *kind != Kind::Simulate);
                self.jobs.cancel(|kind| kind != Kind::Write);
            }
            Effect::Wish(wish) => self.fulfil(wish, ui),
        }
    }

    /// Writes a file off the window's thread.
    fn write(&mut self, content: FileContent, path: PathBuf, existing: Existing) {
        // The notice about it must say where a relative path led.
        let path = std::path::absolute(&path).unwrap_or(path);
        let title = format!("Writing {}", file_name(&path));
        let kind = match content {
            FileContent::Report(..) | FileContent::Traces(_) => Kind::Report,
            _ => Kind::Write,
        };
        let outputs = match content {
            FileContent::Thresholds(..) => threshold_map_files(&path),
            _ => vec![path.clone()],
        };
        let entries = self.state.recordings.entries().iter();
        let inputs: Vec<PathBuf> = entries
            .filter_map(|entry| match entry.recording.source() {
                Source::File(path) => Some(path.clone()),
                Source::Simulated => None,
            })
            .collect();
        self.start(kind, title, move |progress| {
            match check_targets(&inputs, &outputs, existing == Existing::Replace) {
                Ok(()) => {}
                Err(TargetError::Exists { .. }) => return Command::AskToReplace(content, path),
                Err(error) => return Command::Saved(path, Err(error.to_string())),
            }
            let written = write_content(&content, &path, progress);
            match (written, content) {
                (Ok(()), FileContent::Session(_, mark)) => {
                    Command::Session(SessionCommand::Saved(path, mark))
                }
                (written, _) => Command::Saved(path, written),
            }
        });
    }
}

/// The recordings, some of them tared; all or none.
fn tared(recordings: &RecordingSet, which: &[usize], tare: Tare) -> Result<RecordingSet, String> {
    let mut set = recordings.clone();
    for at in which {
        let Some(entry) = recordings.entries().get(*at) else {
            continue;
        };
        let tared = Recording::clone(&entry.recording).tared(tare);
        set.replace(*at, tared.map_err(|error| error.to_string())?.0);
    }
    Ok(set)
}

/// Looks at a file for the import window.
pub(super) fn look_at((path, known): (PathBuf, KnownOf), progress: &Progress) -> Command {
    let found = match &known {
        KnownOf::Nothing => inspect(&path, Known::Nothing, progress),
        KnownOf::Layout(text) => inspect(&path, Known::Layout(text), progress),
        KnownOf::Map(map) => inspect(&path, Known::Map(map), progress),
    };
    let found = found.map(Box::new).map_err(|error| error.to_string());
    Command::Import(ImportCommand::Inspected(path, found))
}

fn write_content(content: &FileContent, path: &Path, progress: &Progress) -> Result<(), String> {
    let written: Result<(), WriteError> = match content {
        FileContent::Calibration(calibration, Some(recordings)) => {
            write_calibration(&with_sources(calibration, recordings), path)
        }
        FileContent::Calibration(calibration, None) => write_calibration(calibration, path),
        FileContent::Report(request, notes) => match report(request, progress) {
            Ok(report) => {
                let notes = notes.clone();
                write_report(path, &ReportData { notes, ..report })
            }
            Err(error) => return Err(error.to_string()),
        },
        FileContent::Traces(what) => {
            let (recordings, decimation) = (&what.recordings, what.decimation);
            let stretches = stretches_on_screen(recordings, decimation, &what.traces, what.visible);
            write_traces(path, &what.calibration, &stretches, progress)
        }
        FileContent::Thresholds(map, measure) => write_threshold_map(map, *measure, path),
        FileContent::Comparison(rows) => write_atomically(path, |out| {
            comparison_table(rows, &ScoreSet::ALL).write_csv(out)
        }),
        FileContent::Metrology(table) => {
            write_atomically(path, |out| figure_records(table).write_csv(out))
        }
        FileContent::Session(session, _) => {
            let session = sessions::with_hashes(session);
            let folder = path.parent().unwrap_or(Path::new(""));
            let text = session.to_json(folder);
            write_atomically(path, |out| out.write_all(&text))
        }
        FileContent::Bytes(bytes) => write_atomically(path, |out| out.write_all(bytes)),
    };
    written.map_err(|error| error.to_string())
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

pub(super) fn is_calibration(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("json"))
}

/// Whether the file is a matrix as sensors come with.
fn is_factory(path: &Path) -> bool {
    CalibrationFormat::from_path(path) == Some(CalibrationFormat::Cal)
}

/// Reads files one after another; what was read before a cancel is kept.
fn read_files(
    files: Vec<(PathBuf, Option<ColumnMap>)>,
    remembered: &[ColumnMap],
    progress: &Progress,
) -> Vec<OpenedFile> {
    for (path, _) in &files {
        // A file that cannot be asked for its size is reported when it is read.
        progress.add_total(std::fs::metadata(path).map_or(0, |metadata| metadata.len()));
    }
    let mut read = Vec::new();
    for (path, map) in files {
        let opened = if is_calibration(&path) && sessions::is_one(&path) {
            sessions::read(&path, progress).map(|opened| Opened::Session(Box::new(opened)))
        } else if is_factory(&path) {
            read_calibration(&path)
                .map(|calibration| Opened::Factory(Arc::new(calibration)))
                .map_err(|error| error.to_string())
        } else if is_calibration(&path) {
            read_calibration(&path)
                .map(|calibration| Opened::Calibration(Arc::new(calibration)))
                .map_err(|error| error.to_string())
        } else {
            read_recordings(&path, map, remembered, progress).map_err(|error| error.to_string())
        };
        if progress.is_cancelled() {
            break;
        }
        read.push((path, opened));
    }
    read
}

/// Reads by the file's own map, else by its names, else by a remembered map for files like it.
fn read_recordings(
    path: &Path,
    map: Option<ColumnMap>,
    remembered: &[ColumnMap],
    progress: &Progress,
) -> Result<Opened, ReadError> {
    let by_map = |map: ColumnMap| {
        let loaded = delimited::read_mapped(path, &map, progress)?;
        Ok(Opened::Recordings(loaded, Some(Box::new(map))))
    };
    if let Some(map) = map {
        return by_map(map);
    }
    let error = match delimited::read(path, progress) {
        Ok(loaded) => return Ok(Opened::Recordings(loaded, None)),
        Err(error) if error.wants_a_map() => error,
        Err(error) => return Err(error),
    };
    match map_for(path, remembered, progress)? {
        Some(map) => by_map(map.clone()),
        None => Ok(Opened::WantsMap(error.to_string())),
    }
}

/// Folders are replaced by the files in them, in the order of their names; hidden ones are left out.
fn with_folders_opened(
    files: Vec<(PathBuf, Option<ColumnMap>)>,
) -> Vec<(PathBuf, Option<ColumnMap>)> {
    let mut all = Vec::new();
    for (path, map) in files {
        let Ok(entries) = std::fs::read_dir(&path) else {
            all.push((path, map));
            continue;
        };
        let mut inside: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path.is_file() && !file_name(path).starts_with('.'))
            .collect();
        inside.sort();
        all.extend(inside.into_iter().map(|path| (path, None)));
    }
    all
}
