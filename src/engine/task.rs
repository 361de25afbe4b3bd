//! Background tasks that run once: reading and writing files, and changing recordings.

use std::path::PathBuf;
use std::sync::Arc;

use crate::calibration::{Calibration, FitSettings};
use crate::engine::files::{OpenedFile, open_all};
use crate::engine::lost::find;
use crate::engine::project::SessionFile;
use crate::engine::saving::{Existing, FileContent};
use crate::engine::session::{OpenedSession, SessionPart, prove_trained};
use crate::export::{TargetError, check_targets};
use crate::finding::{Advice, Face};
use crate::import;
use crate::import::map::ColumnMap;
use crate::import::pose::WeightEstimate;
use crate::progress::Progress;
use crate::questions::Model;
use crate::questions::question::{Answered, Query, Work};
use crate::recording::simulated::Late;
use crate::recording::{Entry, Recording, RecordingSet, Tare, ValidRange, simulated};
use crate::scoring::faults::faults_of;
use crate::shown::file_name;

#[derive(Clone)]
pub struct Task {
    title: String,
    /// True if the task is shown and can be cancelled.
    pub is_seen: bool,
    run: Arc<Run>,
}

type Run = dyn Fn(&Progress) -> Answered<Task> + Send + Sync;

#[derive(Debug)]
pub enum Done {
    Opened(Vec<OpenedFile>),
    /// Recordings before and after a change (tared, or without faulty samples), with warnings.
    Changed(Arc<RecordingSet>, Result<RecordingSet, String>, Vec<String>),
    /// Recordings to be replaced, and the built-in recordings.
    Simulated(Arc<RecordingSet>, RecordingSet),
    /// Written file, or the reason why it could not be written.
    Written(FileContent, PathBuf, Result<(), String>),
    /// File that already exists; the user is asked whether to replace it.
    IsThere(FileContent, PathBuf),
    Map(Result<Box<ColumnMap>, String>),
    Weight(PathBuf, Result<Box<WeightEstimate>, String>),
    Restored(PathBuf, Result<Box<OpenedSession>, String>),
    /// Missing files of the session that were found at this place, each with its entry in the session.
    Located(PathBuf, Vec<(SessionFile, SessionPart)>),
    /// Trained calibration of the session with its recordings, or the reason why they do not match.
    Proven(Arc<Calibration>, Arc<RecordingSet>, Result<(), String>),
    /// Model of these recordings to be listed.
    Kept(Arc<RecordingSet>, Box<Model>),
    /// Model of the present settings, for these recordings.
    Present(Arc<RecordingSet>, Box<Model>),
}

impl Task {
    fn new(
        title: impl Into<String>,
        run: impl Fn(&Progress) -> Answered<Self> + Send + Sync + 'static,
    ) -> Self {
        Self { title: title.into(), is_seen: true, run: Arc::new(run) }
    }

    /// Reads files, each by its map or by a remembered map of similar files.
    pub fn open(files: Vec<(PathBuf, Option<ColumnMap>)>, remembered: Vec<ColumnMap>) -> Self {
        let title = match &files[..] {
            [(one, _)] => format!("Reading {}", file_name(one)),
            many => format!("Reading {} files", many.len()),
        };
        Self::new(title, move |progress| Ok(Done::Opened(open_all(&files, &remembered, progress))))
    }

    pub fn tare(recordings: Arc<RecordingSet>, which: Vec<usize>, tare: Tare) -> Self {
        Self::new("Taring", move |_| {
            let mut warnings = Vec::new();
            let tared = tared(&recordings, &which, tare, &mut warnings);
            Ok(Done::Changed(Arc::clone(&recordings), tared, warnings))
        })
    }

    pub fn leave_out(recordings: Arc<RecordingSet>, range: ValidRange) -> Self {
        Self::new("Leaving out faulty samples", move |_| {
            let rest = left_out(&recordings, &range);
            Ok(Done::Changed(Arc::clone(&recordings), rest, Vec::new()))
        })
    }

    /// Simulates the built-in recordings, which replace these.
    pub fn simulate(replaced: Arc<RecordingSet>, late: Option<Late>) -> Self {
        Self::new("Simulating the built-in sensor", move |progress| {
            let made = match late {
                Some(late) => simulated::late_set(simulated::DEFAULT_SEED, late),
                None => simulated::demonstration(simulated::DEFAULT_SEED),
            };
            progress.check()?;
            Ok(Done::Simulated(Arc::clone(&replaced), made))
        })
    }

    /// Writes a file, which must not be one of `inputs`. A short write is not cancelled, so that no file is incomplete.
    pub fn write(
        content: FileContent,
        path: PathBuf,
        existing: Existing,
        inputs: Vec<PathBuf>,
    ) -> Self {
        let (title, is_seen) = (format!("Writing {}", file_name(&path)), content.takes_long());
        let write = Self::new(title, move |progress| {
            let (content, path) = (content.clone(), path.clone());
            let replaces = existing == Existing::Replace;
            let written = match check_targets(&inputs, &content.files(&path), replaces) {
                Err(TargetError::Exists { .. }) => return Ok(Done::IsThere(content, path)),
                Err(error) => Err(error.text(Face::Window)),
                Ok(()) => content.write(&path, progress),
            };
            Ok(Done::Written(content, path, written))
        });
        Self { is_seen, ..write }
    }

    pub fn read_map(path: PathBuf) -> Self {
        Self::new("Reading a column map", move |_| {
            let read = ColumnMap::read(&path).map(Box::new);
            Ok(Done::Map(read.map_err(|error| error.text(Face::Window))))
        })
    }

    /// Estimates the weight from a file read by this map.
    pub fn find_weight(path: PathBuf, map: ColumnMap) -> Self {
        Self::new("Finding the weight", move |progress| {
            let found = import::estimate_weight(&path, &map, progress).map(Box::new);
            let found = found.map_err(|error| error.text(Face::Window));
            Ok(Done::Weight(path.clone(), found))
        })
    }

    pub fn restore(path: PathBuf) -> Self {
        Self::new("Restoring", move |progress| {
            let opened = OpenedSession::read(&path, progress).map(Box::new);
            progress.check()?;
            Ok(Done::Restored(path.clone(), opened))
        })
    }

    /// Finds and reads missing files of the session. `place` is one of them or their folder; `others` are already open.
    pub fn locate(lost: Vec<SessionFile>, place: PathBuf, others: Vec<PathBuf>) -> Self {
        Self::new("Finding the session's files", move |progress| {
            let found = find(&lost, &place, &others).into_iter();
            let found = found.map(|(at, path)| {
                let part = SessionPart::at(&lost[at], path, progress);
                (lost[at].clone(), part)
            });
            let found = found.collect();
            progress.check()?;
            Ok(Done::Located(place.clone(), found))
        })
    }

    pub fn prove(recordings: Arc<RecordingSet>, trained: Arc<Calibration>) -> Self {
        Self::new("Checking the trained calibration", move |_| {
            let proven = prove_trained(&trained, &recordings);
            Ok(Done::Proven(Arc::clone(&trained), Arc::clone(&recordings), proven))
        })
    }

    /// Measures the cost of a calibration of these recordings, to list it with these settings.
    pub fn keep(
        recordings: Arc<RecordingSet>,
        settings: FitSettings,
        calibration: Arc<Calibration>,
    ) -> Self {
        Self::new("Keeping the model", move |_| {
            let model = Model::fitted(settings.clone(), &calibration, &recordings);
            Ok(Done::Kept(Arc::clone(&recordings), Box::new(model)))
        })
    }

    /// Measures the cost of the calibration with the present settings, to list it. The task is not shown.
    pub fn list_present(
        recordings: Arc<RecordingSet>,
        settings: FitSettings,
        calibration: Arc<Calibration>,
    ) -> Self {
        let task = Self::new("Adding the present settings to the list", move |_| {
            let model = Model::fitted(settings.clone(), &calibration, &recordings);
            Ok(Done::Present(Arc::clone(&recordings), Box::new(model)))
        });
        Self { is_seen: false, ..task }
    }
}

/// Two tasks are never equal, so each runs once.
impl PartialEq for Task {
    fn eq(&self, _: &Self) -> bool {
        false
    }
}

impl Query for Task {
    type Answer = Done;
    type Cache = ();

    fn title(&self) -> String {
        self.title.clone()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        (self.run)(work.progress)
    }
}

/// Returns the recordings with some of them tared; all or none. Adds a warning for each that is tared under load.
fn tared(
    recordings: &RecordingSet,
    which: &[usize],
    tare: Tare,
    warnings: &mut Vec<String>,
) -> Result<RecordingSet, String> {
    let mut set = recordings.clone();
    for at in which {
        let Some(entry) = recordings.entries().get(*at) else {
            continue;
        };
        let tared = Recording::clone(&entry.recording).tared(tare);
        let (tared, place) = tared.map_err(|why| why.text(Face::Window))?;
        warnings.extend(tared.loaded_while_tared(place).map(|found| found.text(Face::Window)));
        set.replace(*at, tared);
    }
    Ok(set)
}

/// Returns the recordings without faulty samples. A recording without remaining samples is removed.
fn left_out(recordings: &RecordingSet, range: &ValidRange) -> Result<RecordingSet, String> {
    let mut set = RecordingSet::default();
    let all: Vec<&Recording> = recordings.entries().iter().map(|entry| &*entry.recording).collect();
    for (entry, found) in recordings.entries().iter().zip(faults_of(&all, range)) {
        for part in found.left_out_of(&entry.recording, range) {
            let part = Entry { group: entry.group.clone(), ..Entry::new(part, entry.role) };
            set.push(part).map_err(|error| error.to_string())?;
        }
    }
    match set.entries().is_empty() {
        true => Err("all samples look faulty, so none can be used".to_owned()),
        false => Ok(set),
    }
}
