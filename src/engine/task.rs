//! Background work that runs once, such as reading and writing files, and taring recordings.

use std::path::PathBuf;
use std::sync::Arc;

use crate::{
    calibration::{Calibration, FitSettings},
    engine::{
        files::{OpenedFile, open_all},
        lost::find,
        project::SessionFile,
        saving::{Existing, FileContent, Output, Unwritten},
        session::{OpenedSession, SessionPart, prove_trained},
    },
    export::{TargetError, check_targets},
    finding::{Advice, Face},
    import::{self, ColumnChange, map::ColumnMap, pose::WeightEstimate},
    progress::Progress,
    questions::{
        Model,
        question::{Answered, Query, Unanswered, Work},
    },
    recording::{
        Entry, Recording, RecordingSet, Tare, ValidRange,
        simulated::{self, Late},
    },
    scoring::faults::faults_of,
    shown::file_name,
};

#[derive(Clone)]
pub struct Task {
    title: String,
    /// True if the status line shows this work, so that the user can cancel it.
    pub is_seen: bool,
    run: Arc<Run>,
}

type Run = dyn Fn(&Progress) -> Answered<Task> + Send + Sync;

#[derive(Debug)]
pub enum Done {
    Opened(Vec<OpenedFile>),
    /// Recordings before and after taring or removing faulty samples, with warnings.
    Changed(Arc<RecordingSet>, RecordingSet, Vec<String>),
    /// Recordings to be replaced, and their files, read again by other column maps.
    ReadAgain(Arc<RecordingSet>, Vec<SessionPart>),
    /// Recordings to be replaced, and the simulated recordings of the built-in sensor that replace them.
    Simulated(Arc<RecordingSet>, RecordingSet),
    /// Content, and the files to which it was or was not written.
    Written(FileContent, Vec<(PathBuf, Result<(), Unwritten>)>),
    Map(Box<ColumnMap>),
    Weight(PathBuf, Box<WeightEstimate>),
    Restored(PathBuf, Box<OpenedSession>),
    /// Path at which missing files of the session were searched, and the session entries of the found files with their
    /// contents.
    Located(PathBuf, Vec<(SessionFile, SessionPart)>),
    /// Trained calibration that was read with the session, the loaded recordings, and the reason if it was not trained on
    /// them.
    Proven(Arc<Calibration>, Arc<RecordingSet>, Result<(), String>),
    /// Recordings, a model that was fitted to them, and true if the user asked to keep this model in the list.
    Listed(Arc<RecordingSet>, Box<Model>, bool),
}

impl Task {
    fn new(
        title: impl Into<String>,
        run: impl Fn(&Progress) -> Answered<Self> + Send + Sync + 'static,
    ) -> Self {
        Self { title: title.into(), is_seen: true, run: Arc::new(run) }
    }

    /// Reads files, each by its column map. If a file has no map and its column names are not sufficient, a remembered map of
    /// similar files is tried.
    pub fn open(files: Vec<(PathBuf, Option<ColumnMap>)>, remembered: Vec<ColumnMap>) -> Self {
        let title = match &files[..] {
            [(one, _)] => format!("Reading {}", file_name(one)),
            many => format!("Reading {} files", many.len()),
        };
        Self::new(title, move |progress| Ok(Done::Opened(open_all(&files, &remembered, progress))))
    }

    /// Tares those of the recordings that have the name and file of a recording in `which`.
    pub fn tare(recordings: Arc<RecordingSet>, which: Vec<Arc<Recording>>, tare: Tare) -> Self {
        Self::new("Taring", move |_| {
            let (tared, warnings) = tared(&recordings, &which, tare)?;
            Ok(Done::Changed(Arc::clone(&recordings), tared, warnings))
        })
    }

    pub fn leave_out(recordings: Arc<RecordingSet>, range: ValidRange) -> Self {
        Self::new("Leaving out faulty samples", move |_| {
            let others = left_out(&recordings, &range).map_err(Unanswered::Because)?;
            Ok(Done::Changed(Arc::clone(&recordings), others, Vec::new()))
        })
    }

    /// Reads the files of the recordings again, with another role for one channel. `files` describes how they were read.
    pub fn change_columns(
        recordings: Arc<RecordingSet>,
        files: Vec<SessionFile>,
        change: ColumnChange,
    ) -> Self {
        Self::new("Reading again", move |progress| {
            let read = |file: &SessionFile| {
                let (path, columns) = (&file.absolute, &file.columns);
                let other = change.map_of(path, columns.as_ref(), progress);
                let columns = other.map_err(because)?.or_else(|| columns.clone());
                let part = SessionPart::at(
                    &SessionFile { columns, ..file.clone() },
                    path.clone(),
                    progress,
                );
                progress.check()?;
                match part.loaded {
                    Some(Err(reason)) => Err(Unanswered::Because(reason)),
                    _ => Ok(part),
                }
            };
            let parts = files.iter().map(read).collect::<Result<_, Unanswered>>()?;
            Ok(Done::ReadAgain(Arc::clone(&recordings), parts))
        })
    }

    /// Simulates the recordings of the built-in sensor, which replace the recordings `replaced`.
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

    /// Writes files, except those of `inputs` (the files of the loaded recordings), which must not be overwritten.
    pub fn write(Output { content, paths, existing }: Output, inputs: Vec<PathBuf>) -> Self {
        let title = match &paths[..] {
            [one] => format!("Writing {}", file_name(one)),
            many => format!("Writing {} files", many.len()),
        };
        let is_seen = content.takes_long();
        let write = Self::new(title, move |progress| {
            let whole = content.handed_over(progress).map_err(Unanswered::Because)?;
            let replaces = existing == Existing::Replace;
            let write = |path: &PathBuf| match check_targets(&inputs, &whole.files(path), replaces)
            {
                Err(TargetError::Exists { .. }) => Err(Unwritten::Exists),
                Err(error) => Err(Unwritten::Because(error.text(Face::Window))),
                Ok(()) => whole.write(path, progress).map_err(Unwritten::Because),
            };
            let written = paths.iter().map(|path| (path.clone(), write(path))).collect();
            Ok(Done::Written(content.clone(), written))
        });
        Self { is_seen, ..write }
    }

    pub fn read_map(path: PathBuf) -> Self {
        Self::new("Reading a column map", move |_| {
            Ok(Done::Map(Box::new(ColumnMap::read(&path).map_err(because)?)))
        })
    }

    /// Estimates the weight that the sensor carries from a file that is read by this column map.
    pub fn find_weight(path: PathBuf, map: ColumnMap) -> Self {
        Self::new("Estimating the weight", move |progress| {
            let found = import::estimate_weight(&path, Some(&map), progress).map_err(because)?;
            Ok(Done::Weight(path.clone(), Box::new(found)))
        })
    }

    pub fn restore(path: PathBuf) -> Self {
        Self::new("Restoring an autosaved session", move |progress| {
            let opened = OpenedSession::read(&path, progress).map_err(Unanswered::Because);
            progress.check()?;
            Ok(Done::Restored(path.clone(), Box::new(opened?)))
        })
    }

    /// Finds and reads missing files of the session. `place` is the path of one of them or their folder. The files in
    /// `others` are already open and are not considered.
    pub fn locate(lost: Vec<SessionFile>, place: PathBuf, others: Vec<PathBuf>) -> Self {
        Self::new("Searching missing files", move |progress| {
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

    /// Measures the computing time of a calibration of these recordings, to show it in the list of models. `is_asked` is true
    /// if the user asked to keep the model. Otherwise the status line does not show this work.
    pub fn list(
        recordings: Arc<RecordingSet>,
        settings: FitSettings,
        calibration: Arc<Calibration>,
        is_asked: bool,
    ) -> Self {
        let task = Self::new("Adding the model to the list", move |_| {
            let model = Model::fitted(settings.clone(), &calibration, &recordings);
            Ok(Done::Listed(Arc::clone(&recordings), Box::new(model), is_asked))
        });
        Self { is_seen: is_asked, ..task }
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

fn because(error: impl Advice) -> Unanswered {
    Unanswered::Because(error.text(Face::Window))
}

/// Returns the recordings, of which those in `which` are tared, and a warning for each that carries a load during its tare.
fn tared(
    recordings: &RecordingSet,
    which: &[Arc<Recording>],
    tare: Tare,
) -> Result<(RecordingSet, Vec<String>), Unanswered> {
    let (mut set, mut warnings) = (recordings.clone(), Vec::new());
    for (at, Entry { recording, .. }) in recordings.entries().iter().enumerate() {
        if which
            .iter()
            .any(|meant| meant.name() == recording.name() && meant.source() == recording.source())
        {
            let (tared, place) = Recording::clone(recording).tared(tare).map_err(because)?;
            warnings.extend(tared.loaded_while_tared(place).map(|found| found.text(Face::Window)));
            set.replace(at, tared);
        }
    }
    Ok((set, warnings))
}

/// Returns the recordings without faulty samples. A recording that consists only of faulty samples is removed.
fn left_out(recordings: &RecordingSet, range: &ValidRange) -> Result<RecordingSet, String> {
    let mut set = RecordingSet::default();
    let all: Vec<&Recording> = recordings.entries().iter().map(|entry| &*entry.recording).collect();
    for (entry, found) in recordings.entries().iter().zip(faults_of(&all, range)) {
        for part in found.left_out_of(&entry.recording, range) {
            let part = Entry { group: entry.group.clone(), ..Entry::new(part, entry.role) };
            set.push(part).map_err(|error| error.to_string())?;
        }
    }
    if set.entries().is_empty() {
        return Err(
            "all samples look faulty, so none is left; check the gauge range and the rated loads"
                .to_owned(),
        );
    }
    Ok(set)
}
