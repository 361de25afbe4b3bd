//! All of the program's state, and the one function that changes it.

use std::path::PathBuf;
use std::sync::Arc;

use crate::analysis::{Analysis, Request, View};
use crate::app::{Command, Effect, Level, Notice, Opened};
use crate::calibration::{Calibration, FitSettings};
use crate::export::CalibrationFormat;
use crate::features::{Distance, Thresholds};
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
    /// The choices of the fit.
    pub settings: FitSettings,
    /// Which recordings are on screen.
    pub view: View,
    /// Axes that are not shown.
    pub hidden_axes: Vec<Axis>,
    /// A calibration that is applied instead of fitted.
    pub applied: Option<Applied>,
    /// The last analysis that succeeded; stays on screen while the next one runs.
    pub analysis: Option<Arc<Analysis>>,
    /// Why the newest analysis failed.
    pub problem: Option<String>,
    /// What there is to say.
    pub notices: Vec<Notice>,
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
            Command::RemoveRecording(at) => self.remove(at),
            Command::CloseRecordings => self.replace_recordings(RecordingSet::default()),
            Command::Split(fraction) => self.split(fraction),
            Command::Unsplit => match self.unsplit.take() {
                Some(whole) => {
                    self.recordings = whole;
                    self.show_first_test()
                }
                None => Vec::new(),
            },
            Command::SetView(view) => {
                self.view = view;
                self.analyse()
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
            Command::OpenFiles(paths) => vec![Effect::Read(paths)],
            Command::FilesOpened(files) => self.take_files(files),
            Command::OpenBuiltIn => vec![Effect::Simulate],
            Command::BuiltInReady(set) => self.replace_recordings(set),
            Command::FitAgain => {
                self.applied = None;
                self.analyse()
            }
            Command::ChooseExport => vec![Effect::AskForExport],
            Command::Export(path) => self.export(path),
            Command::Exported(path, result) => {
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
            Command::Cancel => vec![Effect::CancelWork],
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

    fn set_settings(&mut self, settings: FitSettings) -> Vec<Effect> {
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
        if let View::One(shown) = self.view
            && shown > at
        {
            self.view = View::One(shown - 1);
        }
        // What the cut was made of no longer fits together.
        self.unsplit = None;
        self.change_recordings(|set| set.remove(at))
    }

    fn replace_recordings(&mut self, set: RecordingSet) -> Vec<Effect> {
        self.recordings = Arc::new(set);
        self.unsplit = None;
        self.applied = None;
        self.analysis = None;
        self.show_first_test()
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

    fn split(&mut self, fraction: f64) -> Vec<Effect> {
        let whole = self
            .unsplit
            .take()
            .unwrap_or_else(|| Arc::clone(&self.recordings));
        let cut = whole.split(fraction);
        if !cut.entries().iter().any(|entry| entry.role == Role::Test) {
            self.tell(Notice::new(
                Level::Error,
                "There is nothing to cut: the recordings are off, have no reference, or are too short",
            ));
            return Vec::new();
        }
        self.unsplit = Some(whole);
        self.recordings = Arc::new(cut);
        self.show_first_test()
    }

    fn take_files(&mut self, files: Vec<(PathBuf, Result<Opened, String>)>) -> Vec<Effect> {
        let mut loaded = Vec::new();
        let mut calibration = None;
        for (path, opened) in files {
            match opened {
                Ok(Opened::Recordings(recordings)) => loaded.push(recordings),
                Ok(Opened::Calibration(found)) => calibration = Some((path, found)),
                Err(error) => self.tell(Notice::new(Level::Error, error)),
            }
        }
        let mut changed = self.take_recordings(loaded);
        if let Some((path, calibration)) = calibration {
            changed |= self.take_calibration(path, calibration);
        }
        if changed { self.analyse() } else { Vec::new() }
    }

    fn take_recordings(&mut self, loaded: Vec<Loaded>) -> bool {
        // The built-in sensor was there so that there was something to see; real recordings take its place.
        let mut set = if self.recordings.is_simulated() {
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
        if added {
            // Keep an applied calibration: opening recordings to apply it to is what it is for.
            self.recordings = Arc::new(set);
            self.unsplit = None;
            self.view = View::One(before);
            let axes = &self.recordings.layout().axes;
            if !axes.is_empty() && self.settings.distance.effective(axes) != self.settings.distance
            {
                self.settings.distance = Distance::FullScale;
                self.settings.thresholds = Thresholds::default_for(Distance::FullScale);
            }
        }
        added
    }

    fn take_calibration(&mut self, path: PathBuf, calibration: Calibration) -> bool {
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
        let calibration = Arc::new(calibration);
        self.applied = Some(Applied { path, calibration });
        true
    }

    fn export(&mut self, path: PathBuf) -> Vec<Effect> {
        let Some(analysis) = &self.analysis else {
            self.tell(Notice::new(
                Level::Error,
                "There is no calibration to export yet",
            ));
            return Vec::new();
        };
        if CalibrationFormat::from_path(&path).is_none() {
            self.tell(Notice::new(
                Level::Error,
                format!(
                    "{}: the ending says no format; use .json or .csv",
                    path.display()
                ),
            ));
            return Vec::new();
        }
        // An applied calibration leaves as it came, not with the scores it has here.
        let calibration = match &self.applied {
            Some(applied) => &applied.calibration,
            None => &analysis.calibration,
        };
        vec![Effect::Write(Arc::clone(calibration), path)]
    }

    fn analyse(&mut self) -> Vec<Effect> {
        self.problem = None;
        vec![Effect::Analyse(Request {
            recordings: Arc::clone(&self.recordings),
            settings: self.settings.clone(),
            view: self.view,
            calibration: self
                .applied
                .as_ref()
                .map(|applied| Arc::clone(&applied.calibration)),
        })]
    }

    fn tell(&mut self, notice: Notice) {
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
