//! The document: everything that a session saves, and every change of it.
//!
//! Guarantees: the document contains no computed results and no state of the window. A refused change changes nothing. A new
//! document has the settings, the identity and the notes of no earlier one. Recordings of other gauges begin a new document.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::{
    calibration::{Calibration, FitSettings},
    export::{name_gauges, names_gauges},
    features::{Distance, Thresholds},
    import::map::ColumnMap,
    questions::{BlockSuggestion, Datasets, Request, View, metrology::MetrologySettings},
    recording::{
        Axis, Entry, GaugeRange, Identity, Judged, Missing, Recording, RecordingError,
        RecordingSet, Role, SensorFrame, Source, Tare, ValidRange, identity::rate, load_ranges,
    },
    same::same_where,
    scoring::numbers::round_step,
};

/// Default force threshold F_th, as a share of the range of the force. It is near the 3 N for a range of 22 N of Koike et al.
/// (2019).
const USUAL_SHARE: f64 = 0.125;
/// Sensible values of the force threshold F_th, as shares of the range of the force. With a larger F_th, the look-back finds
/// almost no earlier sample. With a smaller F_th, it finds only neighbouring samples.
const SENSIBLE_SHARES: std::ops::RangeInclusive<f64> = 0.01..=0.5;

#[derive(Clone, Debug)]
pub struct FromFile {
    pub path: PathBuf,
    pub calibration: Arc<Calibration>,
}

// Calibrations are compared by address, so a file that is opened twice gives two calibrations that are not equal.
same_where!(FromFile: shared(calibration) value() besides(path));

/// Split of each recording in time into a training segment and a test segment.
#[derive(Clone, Debug)]
pub struct Split {
    /// Whole recordings, from before the split.
    pub whole: Arc<RecordingSet>,
    /// Share of each recording, from its start, that is the training segment.
    pub fraction: f64,
}

same_where!(Split: shared(whole) value(fraction) besides());

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SessionFile {
    /// Path of the recording file, relative to the folder of the session if possible.
    pub path: PathBuf,
    /// Absolute path of the recording file when the session was saved.
    pub absolute: PathBuf,
    pub bytes: Option<u64>,
    pub sha256: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<ColumnMap>,
    /// Tares that the user applied after the file was read, by the name of the recording.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub tares: BTreeMap<String, Tare>,
    /// Limits by which the user had faulty samples removed, by the name of the recording before the removal.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub left_out: BTreeMap<String, Judged>,
    /// Training or test roles of the recordings, by name. A recording without an entry has the role that its name suggests.
    pub roles: BTreeMap<String, Role>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub groups: BTreeMap<String, String>,
}

/// Everything that a session saves. A copy is cheap, because the copies share the recordings in memory.
///
/// A session file contains the document as it is, without the skipped fields. For these, the
/// [`Session`](super::session::Session) contains names of files and recordings.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Project {
    #[serde(skip)]
    pub recordings: Arc<RecordingSet>,
    #[serde(skip)]
    pub split: Option<Split>,
    pub notes: String,
    #[serde(skip_serializing_if = "Identity::is_empty")]
    pub identity: Identity,
    /// Frame of the reference loads of all recordings; `None` for the frame in which they were measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<SensorFrame>,
    pub settings: FitSettings,
    pub measuring: MetrologySettings,
    /// Minimum and maximum reading of the gauges in the logger's unit, to detect clipping; `None` if the user entered none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gauge_range: Option<GaugeRange>,
    /// Share by which a load may exceed the rated load before it counts as overload; `None` if the user entered none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overload_tolerance: Option<f64>,
    /// Calibration from a file that is applied to the recordings; `None` if a calibration is fitted to them.
    #[serde(skip)]
    pub applied: Option<FromFile>,
    #[serde(skip)]
    pub factory: Option<FromFile>,
    #[serde(skip)]
    pub view: View,
    #[serde(skip)]
    pub maps: BTreeMap<PathBuf, ColumnMap>,
    /// Recording files of the session that were not found.
    #[serde(skip)]
    pub lost: Vec<SessionFile>,
}

// Fields that no edit changes (the view and the column maps) are not compared.
same_where!(Project:
    shared(recordings)
    value(split, settings, measuring, gauge_range, overload_tolerance, applied, factory, notes, identity, frame, lost)
    besides(view, maps)
);

/// Change of the document. Each edit is one step of undo.
#[derive(Clone, Debug)]
pub enum Edit {
    /// Change the settings of the fit.
    Settings(FitSettings),
    /// Change the settings for loops, dwells and metrology.
    Measuring(MetrologySettings),
    /// Use the settings of another model. An applied calibration is removed, and the entered full scales stay.
    Model(Box<FitSettings>),
    /// Set the thresholds F_th and t_th of the first look-back. The other look-backs get the same t_th, and keep their F_th.
    Thresholds(Thresholds),
    /// Set the values of a feature block that cross-validation has chosen.
    Block(BlockSuggestion),
    /// Set the training or test role of the recordings with these indices.
    Roles(Vec<usize>, Role),
    /// Set the role of all recordings that have a reference load.
    AllRoles(Role),
    /// Set the group of each recording, in their order; `None` for the group that follows from its file or name.
    Groups(Vec<Option<String>>),
    /// Set the minimum and maximum reading of the gauges, to detect clipping.
    GaugeRange(Option<GaugeRange>),
    /// Set the share by which a load may exceed the rated load before it counts as overload.
    OverloadTolerance(f64),
    /// Close the recordings with these indices.
    Remove(Vec<usize>),
    /// Begin an empty document with default settings. The column maps stay, because each belongs to a file.
    New,
    /// Replace the recordings by these, such as tared ones.
    Replace(Arc<RecordingSet>),
    /// Split each recording in time. This share, from its start, is used for training, and the remainder for testing.
    Split(f64),
    /// Undo the split, and use whole recordings again.
    Unsplit,
    /// Change the notes of the user.
    Notes(String),
    /// Change the identity of the sensor, and date, operator and reference of the calibration.
    Identity(Identity),
    /// Turn and shift the reference loads of all recordings into another frame; `None` for the frame in which they were
    /// measured.
    Frame(Option<SensorFrame>),
    /// Apply this calibration from a file to the recordings; `None` fits a calibration again.
    Apply(Option<FromFile>),
    /// Show the errors of this manufacturer's matrix beside those of the calibration; `None` for none.
    Compare(Option<FromFile>),
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    #[error(transparent)]
    Frame(#[from] RecordingError),
    #[error(
        "There is nothing to split: the recordings are off, have no reference, or are too short. Set their role to train or test"
    )]
    NothingToSplit,
    #[error(
        "{}: the calibration is for the gauges {}, but the loaded recordings have {}; first open recordings of the same sensor",
        .path.display(), .wanted.join(" "), .loaded.join(" ")
    )]
    OtherGauges { path: PathBuf, wanted: Vec<String>, loaded: Vec<String> },
    #[error("{}: the matrix was made for {wanted} gauges, but the loaded recordings have {}", .path.display(), .loaded.join(" "))]
    OtherFactoryGauges { path: PathBuf, wanted: usize, loaded: Vec<String> },
}

impl Project {
    /// Changes the document.
    ///
    /// # Errors
    /// [`EditError`] if the change is refused. The document is then unchanged.
    pub fn edit(&mut self, edit: Edit) -> Result<(), EditError> {
        let axes = self.axes().to_vec();
        let edited = self.make(edit);
        // The axes have changed, so the reversal thresholds that the user entered for the old axes are removed.
        if *self.axes() != axes {
            self.measuring.reversal_thresholds.clear();
        }
        edited
    }

    fn make(&mut self, edit: Edit) -> Result<(), EditError> {
        match edit {
            Edit::Settings(settings) => self.settings = settings,
            Edit::Measuring(measuring) => self.measuring = measuring,
            Edit::Model(settings) => {
                self.settings = self.with_full_scale(*settings);
                self.applied = None;
            }
            Edit::Thresholds(thresholds) => self.set_thresholds(thresholds),
            Edit::Block(chosen) => {
                let blocks = &mut self.settings.features.blocks;
                blocks.set(chosen.block, chosen.values);
            }
            Edit::Roles(which, role) => {
                let set = Arc::make_mut(&mut self.recordings);
                which.into_iter().for_each(|at| set.set_role(at, role));
            }
            Edit::AllRoles(role) => {
                let set = Arc::make_mut(&mut self.recordings);
                for at in 0..set.entries().len() {
                    set.set_role(at, role);
                }
            }
            Edit::Groups(groups) => {
                let set = Arc::make_mut(&mut self.recordings);
                for (at, group) in groups.into_iter().enumerate() {
                    set.set_group(at, group);
                }
            }
            Edit::Remove(mut which) => {
                which.sort_unstable();
                which.into_iter().rev().for_each(|at| self.remove(at));
            }
            Edit::New => self.begin_anew(),
            Edit::Replace(recordings) => {
                self.recordings = recordings;
                self.split = None;
            }
            Edit::Split(fraction) => self.split_at(fraction)?,
            Edit::Unsplit => {
                if let Some(split) = self.split.take() {
                    self.recordings = split.whole;
                    self.show_first_test();
                }
            }
            Edit::GaugeRange(range) => self.gauge_range = range,
            Edit::OverloadTolerance(share) => self.overload_tolerance = Some(share),
            Edit::Notes(notes) => self.notes = notes,
            Edit::Identity(identity) => self.identity = identity,
            Edit::Frame(frame) if frame == self.frame => {}
            Edit::Frame(frame) => {
                let recordings = Arc::new(self.recordings.in_frame(frame)?);
                if let Some(split) = &mut self.split {
                    split.whole = Arc::new(split.whole.in_frame(frame)?);
                }
                (self.recordings, self.frame) = (recordings, frame);
            }
            Edit::Apply(Some(applied)) => {
                let loaded = &self.recordings.layout().gauge_names;
                let wanted = &applied.calibration.gauges;
                if !loaded.is_empty() && loaded != wanted {
                    return Err(EditError::OtherGauges {
                        path: applied.path,
                        wanted: wanted.clone(),
                        loaded: loaded.clone(),
                    });
                }
                self.make(Edit::Frame(applied.calibration.frame))?;
                self.take_rated_loads(&applied.calibration);
                // The items are not mixed, because they may be of two sensors.
                if !applied.calibration.identity.is_empty() {
                    self.identity = applied.calibration.identity.clone();
                }
                self.applied = Some(applied);
            }
            Edit::Apply(None) => self.applied = None,
            Edit::Compare(factory) => {
                let before = std::mem::replace(&mut self.factory, factory);
                if let Err(error) = self.name_factory_gauges() {
                    self.factory = before;
                    return Err(error);
                }
            }
        }
        Ok(())
    }

    /// Returns the document `other` for an undo step. Two things are kept from this document: the recording on screen, and the
    /// column maps of files that are not open in `other`.
    pub fn with_edits_of(&self, other: Self) -> Self {
        let mut maps = self.maps.clone();
        for path in other.files() {
            maps.remove(path);
            maps.extend(other.maps.get(path).map(|map| (path.to_owned(), map.clone())));
        }
        Self { view: self.view.within(other.recordings.entries().len()), maps, ..other }
    }

    /// Returns what is missing for a fit: the gauges or the reference load. If a calibration from a file is applied, only gauges
    /// can be missing.
    pub fn missing(&self) -> Option<Missing> {
        let missing = self.recordings.missing();
        missing.filter(|missing| self.applied.is_none() || *missing == Missing::Gauges)
    }

    fn begin_anew(&mut self) {
        *self = Self { maps: std::mem::take(&mut self.maps), ..Self::default() };
    }

    /// Returns true if the recordings that are or were loaded have other gauges, so that the settings and the identity are of
    /// another sensor.
    pub fn is_of_other(&self, gauges: &[String]) -> bool {
        let known = &self.recordings.layout().gauge_names;
        !known.is_empty() && known != gauges
    }

    /// Returns true if these recordings of files would begin a new document, because they are of another sensor and no other
    /// recordings of files are loaded.
    pub fn begins_with(&self, files: &[Vec<Recording>]) -> bool {
        let is_free = self.recordings.is_simulated() || self.recordings.entries().is_empty();
        let first = files.iter().flatten().next().filter(|_| is_free);
        first.is_some_and(|first| self.is_of_other(first.gauge_names()))
    }

    /// Begins a new document for another sensor. A manufacturer's matrix stays, because it may have been opened for this sensor.
    pub fn begin_for_other(&mut self) {
        let factory = self.factory.take();
        self.begin_anew();
        self.factory = factory;
    }

    pub fn valid_range(&self) -> ValidRange {
        ValidRange {
            gauges: self.gauge_range.clone(),
            rated: self.settings.full_scale.clone(),
            overload_tolerance: self.overload_tolerance,
        }
    }

    pub fn axes(&self) -> &[Axis] {
        match &self.applied {
            Some(applied) => &applied.calibration.axes,
            None => &self.recordings.layout().axes,
        }
    }

    /// Returns the settings of a model, with its full scales replaced by those of this document.
    pub(super) fn with_full_scale(&self, settings: FitSettings) -> FitSettings {
        let full_scale = self.settings.full_scale.clone();
        FitSettings { full_scale, ..settings }
    }

    /// Returns the thresholds F_th and t_th of the first look-back, or the default thresholds without a look-back.
    pub fn thresholds(&self) -> Thresholds {
        let features = &self.settings.features;
        let distance = features.distance.effective(self.axes());
        let first = features.look_backs.first().copied();
        first.unwrap_or_else(|| Thresholds::default_for(distance))
    }

    /// Returns the default thresholds F_th and t_th. If the F_th of 3 N of Koike et al. (2019) does not suit the range of the
    /// force, F_th is a share of this range.
    pub fn default_thresholds(&self) -> Thresholds {
        let chosen = self.settings.features.distance;
        // Without recordings the axes are not known, so the chosen distance stays.
        let distance = match self.axes() {
            [] => chosen,
            axes => chosen.effective(axes),
        };
        let usual = Thresholds::default_for(distance);
        let moves = match distance {
            Distance::Force => self.largest_force_range(),
            Distance::FullScale => None,
        };
        let share = |range: f64| usual.f_th / range;
        match moves {
            Some(range) if !SENSIBLE_SHARES.contains(&share(range)) => {
                Thresholds { f_th: round_step(USUAL_SHARE * range), ..usual }
            }
            _ => usual,
        }
    }

    /// Returns the range of the force axis with the largest range (N); `None` if no force changes.
    fn largest_force_range(&self) -> Option<f64> {
        let layout = self.recordings.layout();
        let entries = self.recordings.entries().iter();
        let recordings = entries.map(|entry| &*entry.recording);
        let ranges = load_ranges(recordings, layout.axes.len());
        let forces = layout.axes.iter().zip(ranges).filter(|(axis, _)| axis.is_force());
        let spans = forces.map(|(_, range)| range.span());
        spans.reduce(f64::max).filter(|span| *span > 0.0 && span.is_finite())
    }

    /// Returns the paths of the files of the recordings.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let entries = self.recordings.entries().iter();
        entries.filter_map(|entry| match entry.recording.source() {
            Source::File(path) => Some(path.as_path()),
            Source::Simulated => None,
        })
    }

    /// Returns the request for an analysis of this document. `trained` is a network or kernel calibration trained on its
    /// recordings.
    pub fn request(&self, trained: Option<&Arc<Calibration>>) -> Request {
        let trained = trained.filter(|_| self.applied.is_none()).cloned();
        let applied = self.applied.as_ref().map(|applied| &applied.calibration);
        let factory = self.factory.as_ref().map(|factory| &factory.calibration);
        Request {
            recordings: Arc::clone(&self.recordings),
            settings: self.settings.clone(),
            view: self.view,
            trained: trained.is_some(),
            calibration: applied.cloned().or(trained),
            factory: factory.cloned(),
            datasets: Datasets::default(),
        }
    }

    /// Adds the recordings of files. Their roles follow from their names, and their groups from the column maps. Returns a
    /// message for each file whose columns differ from those of the loaded recordings.
    pub fn add(&mut self, files: Vec<Vec<Recording>>) -> Vec<String> {
        let mut refused = Vec::new();
        // Recordings of files replace the simulated recordings of the built-in sensor, which are only an example.
        if self.begins_with(&files) {
            self.begin_for_other();
        }
        let mut set = if self.recordings.is_simulated() {
            RecordingSet::default()
        } else {
            RecordingSet::clone(&self.recordings)
        };
        let before = set.entries().len();
        let had_default = self.settings.features.look_backs == [self.default_thresholds()];
        for recordings in files {
            for recording in recordings {
                let group = self.group_by_map(&recording);
                let pushed = recording.in_frame(self.frame).and_then(|recording| {
                    let entry = Entry::with_default_role(recording);
                    let group = group.or_else(|| entry.group.clone());
                    set.push(Entry { group, ..entry })
                });
                if let Err(error) = pushed {
                    refused.push(error.to_string());
                    break; // the other runs of this file have the same columns
                }
            }
        }
        if set.entries().len() == before {
            return refused;
        }
        let split = self.split.take().map(|mut split| {
            // Training and test segments that exist keep their roles. New recordings are split at the same share.
            let mut fresh = RecordingSet::default();
            let whole = Arc::make_mut(&mut split.whole);
            for entry in &set.entries()[before..] {
                for set in [&mut fresh, &mut *whole] {
                    let refused = set.push(entry.clone()).err();
                    debug_assert!(refused.is_none(), "the recordings fit those of the split");
                }
            }
            while set.entries().len() > before {
                set.remove(before);
            }
            for segment in fresh.split(split.fraction).entries() {
                refused.extend(set.push(segment.clone()).err().map(|error| error.to_string()));
            }
            split
        });
        // An applied calibration stays, because the user opens further recordings to apply it to them.
        refused.extend(self.take_set(set).err().map(|error| error.to_string()));
        self.split = split;
        self.view = View::One(before);
        self.choose_distance();
        if had_default {
            self.settings.features.look_backs = vec![self.default_thresholds()];
        }
        refused
    }

    pub(super) fn group_by_map(&self, recording: &Recording) -> Option<String> {
        let Source::File(path) = recording.source() else {
            return None;
        };
        self.maps.get(path)?.group.as_ref()?.group_of(recording)
    }

    /// Replaces the recordings. A split is removed. If the axes change, entered full scales and reversal thresholds are
    /// removed, too.
    ///
    /// # Errors
    /// [`EditError`] if the manufacturer's matrix is for other gauges (the matrix is then removed), or if the axes of the
    /// recordings do not suffice for the sensor frame.
    pub fn take_set(&mut self, set: RecordingSet) -> Result<(), EditError> {
        let set = set.in_frame(self.frame)?;
        if set.layout().axes != self.recordings.layout().axes {
            self.settings.full_scale.clear();
            self.measuring.reversal_thresholds.clear();
        }
        self.recordings = Arc::new(set);
        self.split = None;
        if let Some(applied) = self.applied.clone() {
            self.take_rated_loads(&applied.calibration);
        }
        self.name_factory_gauges()
    }

    /// Selects the first test recording in which every axis changes for display. Without one, selects the first test
    /// recording, or else the first recording.
    pub fn show_first_test(&mut self) {
        let entries = self.recordings.entries();
        let first = |wanted: &dyn Fn(&Entry) -> bool| entries.iter().position(wanted);
        let is_test = |entry: &Entry| entry.role == Role::Test;
        let shown = first(&|entry| is_test(entry) && every_axis_moves(entry)).or(first(&is_test));
        self.view = View::One(shown.unwrap_or(0));
    }

    /// If the recordings have no force axis, makes the look-backs measure the distance of two samples over all axes, in
    /// shares of full scale.
    pub(super) fn choose_distance(&mut self) {
        let axes = &self.recordings.layout().axes;
        let features = &mut self.settings.features;
        if !axes.is_empty() && features.distance.effective(axes) != features.distance {
            features.distance = Distance::FullScale;
            for thresholds in &mut features.look_backs {
                *thresholds = Thresholds::default_for(Distance::FullScale);
            }
        }
    }

    fn set_thresholds(&mut self, thresholds: Thresholds) {
        match self.settings.features.look_backs.split_first_mut() {
            Some((first, others)) => {
                *first = thresholds;
                for other in others {
                    other.t_th_secs = thresholds.t_th_secs;
                }
            }
            None => self.settings.features.look_backs.push(thresholds),
        }
    }

    fn remove(&mut self, at: usize) {
        let n_left = self.recordings.entries().len().saturating_sub(1);
        self.view = match self.view {
            View::One(shown) if shown > at => View::One(shown - 1),
            view => view.within(n_left),
        };
        // The split is removed, because undoing it later would bring the removed recording back.
        self.split = None;
        Arc::make_mut(&mut self.recordings).remove(at);
    }

    fn split_at(&mut self, fraction: f64) -> Result<(), EditError> {
        let whole = self.split.as_ref().map(|split| &split.whole);
        let whole = Arc::clone(whole.unwrap_or(&self.recordings));
        let cut = whole.split(fraction);
        if !cut.entries().iter().any(|entry| entry.role == Role::Test) {
            return Err(EditError::NothingToSplit);
        }
        self.split = Some(Split { whole, fraction });
        self.recordings = Arc::new(cut);
        self.show_first_test();
        Ok(())
    }

    /// Takes over the rated loads of a calibration for the axes without an entered rated load, so that the user need not
    /// enter them again.
    fn take_rated_loads(&mut self, calibration: &Calibration) {
        let axes = &self.recordings.layout().axes;
        rate(&calibration.rated_loads(), axes, &mut self.settings.full_scale);
    }

    /// Gives the manufacturer's matrix the names of the loaded gauges if its file names none. A matrix for other gauges is
    /// removed.
    fn name_factory_gauges(&mut self) -> Result<(), EditError> {
        let names = &self.recordings.layout().gauge_names;
        let Some(factory) = self.factory.as_mut().filter(|_| !names.is_empty()) else {
            return Ok(());
        };
        if !names_gauges(&factory.path) && factory.calibration.gauges != *names {
            name_gauges(Arc::make_mut(&mut factory.calibration), names);
        }
        if factory.calibration.gauges == *names {
            return Ok(());
        }
        let error = EditError::OtherFactoryGauges {
            path: factory.path.clone(),
            wanted: factory.calibration.gauges.len(),
            loaded: names.clone(),
        };
        self.factory = None;
        Err(error)
    }
}

fn every_axis_moves(entry: &Entry) -> bool {
    let mut ranges = entry.recording.load_ranges().iter();
    ranges.all(|range| range.span() > 0.0)
}

/// Returns the absolute path of a file; the path as it is if there is none.
pub fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::tests::{
        FORCES, GAUGES, add, built_in, fitted, names, of_file, roles, with_files,
    };

    fn applied(calibration: Calibration) -> FromFile {
        FromFile { path: "c.json".into(), calibration: Arc::new(calibration) }
    }

    #[test]
    fn roles_change_one_by_one_and_all_at_once() {
        let mut project = with_files();
        assert_eq!(roles(&project), [Role::Train, Role::Train, Role::Test]);
        let before = Arc::clone(&project.recordings);
        project.edit(Edit::Roles(vec![1], Role::Off)).unwrap();
        let request = project.request(None);
        assert_eq!(request.recordings.entries()[1].role, Role::Off);
        assert_eq!(before.entries()[1].role, Role::Train, "the earlier document is unchanged");
        project.edit(Edit::AllRoles(Role::Test)).unwrap();
        assert_eq!(roles(&project), [Role::Test; 3]);
    }

    #[test]
    fn a_recording_without_a_reference_is_always_off() {
        let mut project = Project::default();
        let files = vec![vec![of_file("a", &GAUGES, &[]), of_file("b", &GAUGES, &[])]];
        assert!(project.add(files).is_empty());
        project.edit(Edit::Roles(vec![0], Role::Train)).unwrap();
        assert_eq!(roles(&project), [Role::Off; 2]);
    }

    #[test]
    fn removing_keeps_the_same_recording_on_screen_or_the_last_one() {
        let mut project = with_files();
        project.view = View::One(2);
        project.edit(Edit::Remove(vec![0])).unwrap();
        assert_eq!((project.view, names(&project)), (View::One(1), vec!["b", "test"]));
        project.edit(Edit::Remove(vec![1])).unwrap();
        let request = project.request(None);
        assert_eq!((project.view, request.view), (View::One(0), View::One(0)));
        project.edit(Edit::Remove(vec![0])).unwrap();
        assert_eq!((project.view, names(&project).len()), (View::One(0), 0));
    }

    #[test]
    fn a_split_can_be_changed_and_undone() {
        let mut project = with_files();
        let whole = Arc::clone(&project.recordings);
        let samples = |project: &Project| -> Vec<usize> {
            let entries = project.recordings.entries().iter();
            entries.map(|entry| entry.recording.n_samples()).collect()
        };
        project.edit(Edit::Split(0.5)).unwrap();
        assert_eq!(project.request(None).recordings.entries().len(), 6);
        assert_eq!(project.view, View::One(1), "the first test segment is shown");
        project.edit(Edit::Split(0.25)).unwrap();
        assert_eq!(
            samples(&project),
            [10, 30, 10, 30, 10, 30],
            "the whole recordings are split, not their halves"
        );
        project.edit(Edit::Unsplit).unwrap();
        assert!(Arc::ptr_eq(&project.recordings, &whole));
        assert!(project.split.is_none());
        let before = project.clone();
        project.edit(Edit::Unsplit).unwrap();
        assert!(project == before);
    }

    #[test]
    fn recordings_added_to_a_split_are_split_too() {
        let mut project = with_files();
        project.edit(Edit::Split(0.25)).unwrap();
        project.edit(Edit::Roles(vec![1], Role::Off)).unwrap();
        let refused = project.add(vec![vec![of_file("later", &GAUGES, &FORCES)]]);
        assert_eq!(refused, Vec::<String>::new());
        let entries = project.recordings.entries();
        let of = |at: usize| (entries[at].recording.n_samples(), entries[at].role);
        assert_eq!(of(1), (30, Role::Off), "existing segments keep their roles");
        assert_eq!((of(6), of(7)), ((10, Role::Train), (30, Role::Test)));
        project.edit(Edit::Unsplit).unwrap();
        let entries = project.recordings.entries();
        assert_eq!(entries.len(), 4);
        assert_eq!(entries[3].recording.name(), "later");
    }

    #[test]
    fn a_split_that_leaves_nothing_to_test_changes_nothing() {
        let mut project = with_files();
        project.edit(Edit::Roles(vec![2], Role::Off)).unwrap();
        project.edit(Edit::Split(0.5)).unwrap();
        let before = project.clone();
        let error = project.edit(Edit::Split(0.001)).unwrap_err();
        assert!(error.to_string().contains("nothing to split"), "{error}");
        assert!(project == before && project.view == before.view);
        assert_eq!(project.split, before.split, "the split can still be undone");
    }

    #[test]
    fn other_gauges_are_refused_and_nothing_is_lost() {
        let mut project = with_files();
        let before = project.clone();
        let refused = project.add(vec![vec![of_file("other", &["G1"], &FORCES)]]);
        assert!(refused[0].contains("other: the gauges are G1"), "{refused:?}");
        assert_eq!(refused.len(), 1);
        assert!(project == before);
    }

    #[test]
    fn a_calibration_of_other_gauges_is_refused() {
        let mut project = with_files();
        let mut calibration = Calibration::clone(&fitted(&project));
        calibration.gauges[0] = "G1".to_owned();
        let before = project.clone();
        let error = project.edit(Edit::Apply(Some(applied(calibration))));
        assert!(error.unwrap_err().to_string().contains("G1"));
        assert!(project.applied.is_none() && project == before);
    }

    #[test]
    fn a_matrix_of_other_gauges_is_refused_and_the_one_before_stays() {
        let mut project = with_files();
        let own = applied(Calibration::clone(&fitted(&project)));
        project.edit(Edit::Compare(Some(own.clone()))).unwrap();
        let mut other = Calibration::clone(&own.calibration);
        other.gauges.pop();
        let error = project.edit(Edit::Compare(Some(applied(other))));
        assert!(error.unwrap_err().to_string().contains("made for 2 gauges"));
        assert_eq!(project.factory, Some(own));
        while !project.recordings.entries().is_empty() {
            project.edit(Edit::Remove(vec![0])).unwrap();
        }
        assert!(project.factory.is_some(), "the matrix stays until other recordings are opened");
        let refused = project.add(vec![vec![of_file("a", &["S1"], &FORCES)]]);
        assert!(refused[0].contains("made for 3 gauges"), "{refused:?}");
        assert!(project.factory.is_none());
        assert_eq!(names(&project), ["a"]);
    }

    #[test]
    fn a_matrix_without_gauge_names_takes_the_loaded_names() {
        let mut project = with_files();
        let mut calibration = Calibration::clone(&fitted(&project));
        calibration.gauges = ["SG0", "SG1", "SG2"].map(str::to_owned).to_vec();
        let factory = FromFile { path: "sensor.cal".into(), calibration: Arc::new(calibration) };
        project.edit(Edit::Compare(Some(factory))).unwrap();
        assert_eq!(project.factory.unwrap().calibration.gauges, GAUGES);
    }

    #[test]
    fn real_recordings_replace_simulated_ones() {
        let mut project = Project::default();
        project.take_set(built_in()).unwrap();
        add(&mut project, "a", &["G1", "G2"], &[Axis::Fz]);
        let request = project.request(None);
        assert_eq!((names(&project), request.view), (vec!["a"], View::One(0)));
        add(&mut project, "test", &["G1", "G2"], &[Axis::Fz]);
        assert_eq!((names(&project), project.view), (vec!["a", "test"], View::One(1)));
    }

    #[test]
    fn moments_alone_are_measured_over_full_scale() {
        let mut project = Project::default();
        add(&mut project, "a", &["S1", "S2"], &[Axis::Mx, Axis::My]);
        let request = project.request(None);
        assert_eq!(request.settings.features.distance, Distance::FullScale);
        let default = Thresholds::default_for(Distance::FullScale);
        assert_eq!(request.settings.features.look_backs, [default]);
    }

    /// The forces of `recording` move from -5 to 5 N.
    #[test]
    fn the_default_f_th_has_an_effect_until_the_user_chooses_one() {
        let scaled = |name: &str, factor: f64| {
            let own = of_file(name, &GAUGES, &FORCES);
            let loads = own.loads().iter().map(|load| factor * load).collect();
            Recording::new(
                name,
                own.source().clone(),
                own.times().to_vec(),
                own.gauge_names().to_vec(),
                own.gauges().to_vec(),
                FORCES.to_vec(),
                loads,
            )
            .unwrap()
        };
        let mut project = Project::default();
        project.add(vec![vec![scaled("a", 1.0)]]);
        assert_eq!(project.thresholds().f_th, 3.0);
        project.edit(Edit::New).unwrap();
        project.add(vec![vec![scaled("small", 0.4)]]);
        assert_eq!(project.thresholds().f_th, 0.5, "F_th is an eighth of 4 N");
        project.add(vec![vec![scaled("large", 1000.0)]]);
        assert_eq!(project.thresholds().f_th, 2000.0, "F_th is an eighth of 10 kN, rounded up");
        let chosen = Thresholds { f_th: 3.0, t_th_secs: 4.0 };
        project.edit(Edit::Thresholds(chosen)).unwrap();
        project.add(vec![vec![scaled("more", 0.4)]]);
        assert_eq!(project.thresholds(), chosen);
    }

    #[test]
    fn full_scales_are_forgotten_with_the_axes_they_were_entered_for() {
        let mut project = Project::default();
        project.take_set(built_in()).unwrap();
        project.settings.full_scale = vec![None, Some(12.0), None];
        project.measuring.reversal_thresholds = vec![None, None, Some(0.5)];
        add(&mut project, "a", &GAUGES, &FORCES);
        assert_eq!(project.settings.full_scale.len(), 3, "the axes are the same");
        project.edit(Edit::New).unwrap();
        add(&mut project, "b", &["S1"], &[Axis::Fz]);
        fitted(&project);
        assert!(project.settings.full_scale.is_empty());
        assert!(project.measuring.reversal_thresholds.is_empty());
    }

    #[test]
    fn a_rated_load_is_saved_with_the_sensor_and_asked_for_once() {
        let mut project = with_files();
        project.settings.full_scale = vec![None, Some(12.0), None];
        let calibration = Calibration::clone(&fitted(&project));
        assert_eq!(calibration.rated, [false, true, false]);
        let saved = serde_json::to_vec(&calibration.in_file()).unwrap();
        let read = Calibration::from_json(&saved).unwrap();
        let mut other = with_files();
        other.edit(Edit::Apply(Some(applied(read)))).unwrap();
        other.edit(Edit::Apply(None)).unwrap();
        assert_eq!(fitted(&other).full_scale, calibration.full_scale);
        assert_eq!(other.settings.full_scale, [None, Some(12.0), None]);
        // An entered rated load stays.
        other.settings.full_scale = vec![None, Some(7.0), None];
        other.edit(Edit::Apply(Some(applied(calibration)))).unwrap();
        assert_eq!(other.settings.full_scale, [None, Some(7.0), None]);
        // Without a rated load, nothing is taken.
        let mut plain = with_files();
        let calibration = Calibration::clone(&fitted(&plain));
        plain.edit(Edit::Apply(Some(applied(calibration)))).unwrap();
        assert!(plain.settings.full_scale.is_empty());
    }

    #[test]
    fn closing_removes_all_data_of_the_recordings() {
        let mut project = with_files();
        let calibration = Calibration::clone(&fitted(&project));
        project.edit(Edit::Apply(Some(applied(calibration)))).unwrap();
        project.edit(Edit::New).unwrap();
        assert!(project.recordings.entries().is_empty());
        assert!(project.applied.is_none() && project.split.is_none());
        assert_eq!(project.files().count(), 0);
    }

    #[test]
    fn thresholds_are_those_of_the_first_look_back_and_t_th_is_shared() {
        let mut project = with_files();
        let thresholds = |f_th, t_th_secs| Thresholds { f_th, t_th_secs };
        let features = &mut project.settings.features;
        features.look_backs = vec![thresholds(1.0, 5.0), thresholds(2.0, 5.0)];
        project.edit(Edit::Thresholds(thresholds(3.0, 7.0))).unwrap();
        let own = &project.settings.features.look_backs;
        assert_eq!(own[..], [thresholds(3.0, 7.0), thresholds(2.0, 7.0)]);
        project.settings.features.look_backs.clear();
        let default = Thresholds::default_for(Distance::default());
        assert_eq!(project.thresholds(), default);
        project.edit(Edit::Thresholds(thresholds(3.0, 7.0))).unwrap();
        assert_eq!(project.thresholds(), thresholds(3.0, 7.0));
    }
}
