//! What is done once beside the window: reading and writing files, and what changes recordings.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::calibration::{Calibration, FitSettings};
use crate::engine::files::{OpenedFile, open_all};
use crate::engine::lost::find;
use crate::engine::project::SessionFile;
use crate::engine::query::{Answered, Query, Work};
use crate::engine::saving::{Existing, FileContent};
use crate::engine::session::{OpenedSession, SessionPart, prove_trained};
use crate::export::{TargetError, check_targets};
use crate::import;
use crate::import::map::ColumnMap;
use crate::import::pose::WeightEstimate;
use crate::questions::Model;
use crate::recording::{Entry, Recording, RecordingSet, Tare, ValidRange, simulated};
use crate::scoring::faults::faults_of;

/// Something to do.
#[derive(Clone, Debug)]
pub enum Task {
    /// Read these files, each by its map if it has one, or else by a remembered map of files like it.
    Open(Vec<(PathBuf, Option<ColumnMap>)>, Vec<ColumnMap>),
    /// Tare some of these recordings.
    Tare(Arc<RecordingSet>, Vec<usize>, Tare),
    /// Leave what is faulty by this range out of these recordings.
    LeaveOut(Arc<RecordingSet>, ValidRange),
    /// Make the built-in recordings, to stand in the place of these.
    Simulate(Arc<RecordingSet>),
    /// Write a file; the inputs must not be written over.
    Write {
        /// What.
        content: FileContent,
        /// Where.
        path: PathBuf,
        /// What to do where it is there already.
        existing: Existing,
        /// Files that must stay as they are.
        inputs: Vec<PathBuf>,
    },
    /// Read a column map.
    ReadMap(PathBuf),
    /// Find the weight in a file by this map.
    FindWeight(PathBuf, Box<ColumnMap>),
    /// Read this autosaved session.
    Restore(PathBuf),
    /// Find these files of the session, of which this is one or the folder that they are in, and read them; others are open.
    Locate(Vec<SessionFile>, PathBuf, Vec<PathBuf>),
    /// Check that a session's trained calibration is of these recordings.
    Prove(Arc<RecordingSet>, Arc<Calibration>),
    /// Find out what a calibration of these recordings costs, to list it with these settings.
    Keep(Arc<RecordingSet>, Box<FitSettings>, Arc<Calibration>),
}

/// What came of it.
#[derive(Debug)]
pub enum Done {
    /// The files that were read.
    Opened(Vec<OpenedFile>),
    /// The recordings of before, and those of now: tared, or without what is faulty.
    Changed(Arc<RecordingSet>, Result<RecordingSet, String>),
    /// The recordings that they were to replace, and the built-in ones.
    Simulated(Arc<RecordingSet>, RecordingSet),
    /// The file was written, or could not be.
    Written(FileContent, PathBuf, Result<(), String>),
    /// The file is there already, and nobody was asked.
    IsThere(FileContent, PathBuf),
    /// The map was read.
    Map(Result<Box<ColumnMap>, String>),
    /// The weight was found in this file.
    Weight(PathBuf, Result<Box<WeightEstimate>, String>),
    /// The session was read.
    Restored(PathBuf, Result<Box<OpenedSession>, String>),
    /// Of the session's files those that were found at this place, each beside what was known of it.
    Located(PathBuf, Vec<(SessionFile, SessionPart)>),
    /// The session's trained calibration with the recordings, or why it is not of them.
    Proven(Arc<Calibration>, Arc<RecordingSet>, Result<(), String>),
    /// The model of these recordings is there.
    Kept(Arc<RecordingSet>, Box<Model>),
}

impl Task {
    /// Whether it can be seen, and stopped. A file that is written ends by itself, so that none is left half written.
    pub fn is_seen(&self) -> bool {
        match self {
            Self::Write { content, .. } => content.takes_long(),
            _ => true,
        }
    }
}

impl Query for Task {
    type Answer = Done;
    type Cache = ();

    fn title(&self) -> String {
        match self {
            Self::Open(files, _) => match &files[..] {
                [(one, _)] => format!("Reading {}", file_name(one)),
                many => format!("Reading {} files", many.len()),
            },
            Self::Tare(..) => "Taring".to_owned(),
            Self::LeaveOut(..) => "Leaving out faulty samples".to_owned(),
            Self::Simulate(_) => "Simulating the built-in sensor".to_owned(),
            Self::Write { path, .. } => format!("Writing {}", file_name(path)),
            Self::ReadMap(_) => "Reading a column map".to_owned(),
            Self::FindWeight(..) => "Finding the weight".to_owned(),
            Self::Restore(_) => "Restoring".to_owned(),
            Self::Prove(..) => "Checking the trained calibration".to_owned(),
            Self::Locate(..) => "Finding the session's files".to_owned(),
            Self::Keep(..) => "Keeping the model".to_owned(),
        }
    }

    fn is_same(&self, _: &Self) -> bool {
        false
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let Work { progress, .. } = work;
        Ok(match self {
            Self::Open(files, remembered) => Done::Opened(open_all(files, remembered, progress)),
            Self::Tare(recordings, which, tare) => {
                Done::Changed(Arc::clone(recordings), tared(recordings, which, *tare))
            }
            Self::LeaveOut(recordings, range) => {
                Done::Changed(Arc::clone(recordings), left_out(recordings, range))
            }
            Self::Simulate(replaced) => {
                let made = simulated::demonstration(simulated::DEFAULT_SEED);
                progress.check()?;
                Done::Simulated(Arc::clone(replaced), made)
            }
            Self::Write {
                content,
                path,
                existing,
                inputs,
            } => {
                let outputs = content.files(path);
                let (content, path) = (content.clone(), path.clone());
                match check_targets(inputs, &outputs, *existing == Existing::Replace) {
                    Err(TargetError::Exists { .. }) => Done::IsThere(content, path),
                    Err(error) => Done::Written(content, path, Err(error.to_string())),
                    Ok(()) => {
                        let written = content.write(&path, progress);
                        Done::Written(content, path, written)
                    }
                }
            }
            Self::ReadMap(path) => {
                let read = ColumnMap::read(path).map(Box::new);
                Done::Map(read.map_err(|error| error.to_string()))
            }
            Self::FindWeight(path, map) => {
                let found = import::estimate_weight(path, map, progress).map(Box::new);
                Done::Weight(path.clone(), found.map_err(|error| error.to_string()))
            }
            Self::Restore(path) => {
                let opened = OpenedSession::read(path, progress).map(Box::new);
                progress.check()?;
                Done::Restored(path.clone(), opened)
            }
            Self::Locate(lost, place, others) => {
                let found = find(lost, place, others).into_iter();
                let found = found.map(|(at, path)| {
                    let part = SessionPart::at(&lost[at], path, progress);
                    (lost[at].clone(), part)
                });
                let found = found.collect();
                progress.check()?;
                Done::Located(place.clone(), found)
            }
            Self::Prove(recordings, trained) => {
                let proven = prove_trained(trained, recordings);
                Done::Proven(Arc::clone(trained), Arc::clone(recordings), proven)
            }
            Self::Keep(recordings, settings, calibration) => {
                let model = Model::fitted(FitSettings::clone(settings), calibration, recordings);
                Done::Kept(Arc::clone(recordings), Box::new(model))
            }
        })
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

/// The recordings without what is faulty in them; a recording of which nothing remains is not there any more.
fn left_out(recordings: &RecordingSet, range: &ValidRange) -> Result<RecordingSet, String> {
    let mut set = RecordingSet::default();
    let all: Vec<&Recording> = recordings
        .entries()
        .iter()
        .map(|entry| &*entry.recording)
        .collect();
    for (entry, found) in recordings.entries().iter().zip(faults_of(&all, range)) {
        for part in found.left_out_of(&entry.recording, range) {
            let part = Entry {
                group: entry.group.clone(),
                ..Entry::new(part, entry.role)
            };
            set.push(part).map_err(|error| error.to_string())?;
        }
    }
    match set.entries().is_empty() {
        true => Err("all samples look faulty; none would be left".to_owned()),
        false => Ok(set),
    }
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}
