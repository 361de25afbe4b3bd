//! The loaded recordings and their roles.
//!
//! Guarantees: all recordings of a set have the same gauges and the same axes, in the same order, and their reference loads are
//! in one frame. A recording without gauges
//! or without a reference may be loaded, but is neither fitted nor scored.

pub(super) mod groups;

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use crate::{
    recording::{
        axis::Axis,
        frame::SensorFrame,
        kinetics::Weight,
        median::median,
        recording::{Missing, Recording, RecordingError},
        tare::Tare,
    },
    shown::listed,
};

/// Role of a recording in the fit of a calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Role {
    /// The recording trains: the calibration is fitted to it.
    Train,
    /// The recording tests: the errors of the calibration are measured on it.
    Test,
    /// The recording is shown, but neither fitted nor scored.
    #[default]
    Off,
}

impl Role {
    /// Returns the default role for the name of a recording or file: test if the name starts with `test`, otherwise train.
    pub fn of_name(name: &str) -> Self {
        let start = name.get(..4);
        if start.is_some_and(|start| start.eq_ignore_ascii_case("test")) {
            Self::Test
        } else {
            Self::Train
        }
    }

    /// Returns the name of the role in the window and in files.
    pub fn label(self) -> &'static str {
        self.into()
    }
}

/// A recording with its role.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The recording, shared with background threads.
    pub recording: Arc<Recording>,
    /// Role of the recording.
    pub role: Role,
    /// Name of the recording's group, if the user or a column of the file gives it; see [`RecordingSet::groups`].
    pub group: Option<String>,
}

impl Entry {
    /// Creates an entry with the role that the recording's name gives ([`Role::of_name`]). Without gauges or without a
    /// reference load, the role is off.
    pub fn with_default_role(recording: Recording) -> Self {
        let role = Role::of_name(recording.name());
        Self::new(recording, role)
    }

    /// Creates an entry with this role. Without gauges or without a reference load, the role is off.
    pub fn new(recording: Recording, role: Role) -> Self {
        let role = if recording.missing().is_none() { role } else { Role::Off };
        let group = recording.group().map(str::to_owned);
        Self { recording: Arc::new(recording), role, group }
    }
}

pub fn in_role(entries: &[Entry], role: Role) -> Vec<&Recording> {
    entries.iter().filter(|entry| entry.role == role).map(|entry| &*entry.recording).collect()
}

/// Gauges and axes that all recordings of one set have, in the order of columns.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Layout {
    pub gauge_names: Vec<String>,
    /// Axes of the reference load; empty until a recording with a reference load is loaded.
    pub axes: Vec<Axis>,
}

/// The loaded recordings with their roles, in the order of loading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordingSet {
    layout: Layout,
    entries: Vec<Entry>,
}

impl RecordingSet {
    /// Returns the gauges and axes that all recordings of the set share.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Returns the unit of a gauge in the first recording, or `raw` if the unit is unknown.
    pub fn gauge_unit(&self, gauge: usize) -> &str {
        let first = self.entries.first();
        let unit = first.and_then(|entry| entry.recording.gauge_units().get(gauge));
        unit.filter(|unit| !unit.is_empty()).map_or("raw", String::as_str)
    }

    /// Returns the recordings in the order of loading.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Returns what a calibration needs and no recording has. `None` if a recording can be fitted, or if there is no
    /// recording.
    pub fn missing(&self) -> Option<Missing> {
        let mut missing = self.entries.iter().map(|entry| entry.recording.missing());
        missing.clone().all(|missing| missing.is_some()).then(|| missing.next())?.flatten()
    }

    /// Returns the number of samples in all recordings with this role.
    pub fn n_samples(&self, role: Role) -> usize {
        in_role(&self.entries, role).into_iter().map(Recording::n_samples).sum()
    }

    /// Returns true if there are recordings, and all come from the built-in simulated sensor.
    pub fn is_simulated(&self) -> bool {
        let mut entries = self.entries.iter();
        let is_read = |entry: &Entry| entry.recording.source().path().is_some();
        !self.entries.is_empty() && !entries.any(is_read)
    }

    /// Returns the median sample rate (Hz) of the recordings with this role, or `None` if no recording has a rate.
    pub fn rate_hz(&self, role: Role) -> Option<f64> {
        median(in_role(&self.entries, role).into_iter().filter_map(Recording::rate_hz))
    }

    /// Returns true if a training or test recording has no times, so that a look-back finds no earlier samples.
    pub fn is_static(&self) -> bool {
        let mut used = self.entries.iter().filter(|entry| entry.role != Role::Off);
        used.any(|entry| entry.recording.is_static())
    }

    /// Returns the tare of the first training recording, if all training recordings were tared.
    pub fn tare(&self) -> Option<Tare> {
        let mut tares = in_role(&self.entries, Role::Train).into_iter().map(Recording::tare);
        let first = tares.next()??;
        tares.all(|tare| tare.is_some()).then_some(first)
    }

    /// Appends a recording. If its gauges or axes differ from those of the set, returns [`RecordingError::Layout`] and leaves the set
    /// unchanged.
    pub fn push(&mut self, entry: Entry) -> Result<(), RecordingError> {
        let recording = &entry.recording;
        let axes = recording.axes();
        let layout = &mut self.layout;
        if self.entries.is_empty() {
            layout.gauge_names = recording.gauge_names().to_vec();
            layout.axes.clear();
        }
        let differ = |what, expected, actual| {
            Err(RecordingError::Layout {
                name: recording.name().to_owned(),
                what,
                expected,
                actual,
            })
        };
        if recording.gauge_names() != layout.gauge_names {
            return differ("gauges", listed(&layout.gauge_names), listed(recording.gauge_names()));
        }
        if layout.axes.is_empty() {
            layout.axes = axes.to_vec();
        } else if recording.has_reference() && axes != layout.axes {
            let [expected, actual] =
                [&layout.axes[..], axes].map(|axes| Axis::symbols(axes).join(" "));
            return differ("reference axes", expected, actual);
        }
        let mut entry = entry;
        if let Some(frame) = self.frame()
            && entry.recording.frame() != frame
        {
            entry.recording = Arc::new(Recording::clone(&entry.recording).in_frame(frame)?);
        }
        self.entries.push(entry);
        Ok(())
    }

    /// Returns the frame of the reference loads; the outer `None` if no recording has a reference.
    pub fn frame(&self) -> Option<Option<SensorFrame>> {
        let mut entries = self.entries.iter();
        let measured = entries.find(|entry| entry.recording.has_reference())?;
        Some(measured.recording.frame())
    }

    /// Returns the weight that the sensor carried in all training recordings, in the frame of the loads; `None` if it is not known
    /// or not always the same.
    pub fn tool(&self) -> Option<Weight> {
        let mut tools = in_role(&self.entries, Role::Train).into_iter().map(Recording::tool);
        let first = tools.next()??;
        tools.all(|tool| tool == Some(first)).then_some(first)
    }

    /// Returns the set with all reference loads in this frame.
    ///
    /// # Errors
    /// [`RecordingError::Frame`] if the frame mixes an axis with one that was not measured.
    pub fn in_frame(&self, frame: Option<SensorFrame>) -> Result<Self, RecordingError> {
        let mut set = self.clone();
        for entry in set.entries.iter_mut().filter(|entry| entry.recording.frame() != frame) {
            entry.recording = Arc::new(Recording::clone(&entry.recording).in_frame(frame)?);
        }
        Ok(set)
    }

    /// Sets the role of a recording. A recording without gauges or without a reference keeps the role "off". An unknown index
    /// changes nothing.
    pub fn set_role(&mut self, index: usize, role: Role) {
        if let Some(entry) = self.entries.get_mut(index)
            && entry.recording.missing().is_none()
        {
            entry.role = role;
        }
    }

    /// Sets the user's group of a recording. With `None`, the file or the name gives the group. An unknown index changes
    /// nothing.
    pub fn set_group(&mut self, index: usize, group: Option<String>) {
        if let Some(entry) = self.entries.get_mut(index) {
            entry.group = group.or_else(|| entry.recording.group().map(str::to_owned));
        }
    }

    /// Replaces a recording by one with other values. If the gauges or axes differ, nothing changes.
    pub fn replace(&mut self, index: usize, recording: Recording) {
        if let Some(entry) = self.entries.get_mut(index)
            && entry.recording.gauge_names() == recording.gauge_names()
            && entry.recording.axes() == recording.axes()
        {
            entry.recording = Arc::new(recording);
        }
    }

    /// Removes a recording. An unknown index changes nothing.
    pub fn remove(&mut self, index: usize) {
        if index < self.entries.len() {
            self.entries.remove(index);
        }
        let mut entries = self.entries.iter();
        if !entries.any(|entry| entry.recording.has_reference()) {
            self.layout.axes.clear();
        }
    }

    /// Splits each training or test recording in time: the first part trains, the second part tests. Recordings that are off
    /// or too short stay unchanged. Load cases without times are not split: all samples under one load get the same role.
    pub fn split(&self, fraction: f64) -> Self {
        let cases = if self.is_static() { self.groups().of } else { Vec::new() };
        // The loads for training are spread evenly over all loads, because tables often list loads in increasing order.
        let trains = |case: usize| {
            let before = |n: usize| (fraction * n as f64).floor();
            before(case + 1) > before(case)
        };
        let split = |(at, entry): (usize, &Entry)| -> Vec<Entry> {
            if entry.role == Role::Off {
                return vec![entry.clone()];
            }
            if entry.recording.is_load_case() {
                let role = if trains(cases[at]) { Role::Train } else { Role::Test };
                return vec![Entry { role, ..entry.clone() }];
            }
            let part =
                |(part, role)| Entry { group: entry.group.clone(), ..Entry::new(part, role) };
            match entry.recording.split(fraction) {
                Some((first, rest)) => [(first, Role::Train), (rest, Role::Test)].map(part).into(),
                None => vec![entry.clone()],
            }
        };
        let entries = self.entries.iter().enumerate().flat_map(split).collect();
        Self { layout: self.layout.clone(), entries }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::recording::Source;

    fn recording(name: &str, gauges: &[&str], axes: &[Axis]) -> Recording {
        let n = 10;
        Recording::new(
            name,
            Source::File(name.into()),
            (0..n).map(f64::from).collect(),
            gauges.iter().map(|&gauge| gauge.to_owned()).collect(),
            vec![0.5; n as usize * gauges.len()],
            axes.to_vec(),
            vec![1.0; n as usize * axes.len()],
        )
        .unwrap()
    }

    #[test]
    fn the_name_decides_the_first_role() {
        let role = |name| Entry::with_default_role(recording(name, &["S1"], &[Axis::Fz])).role;
        assert_eq!(role("test_path6"), Role::Test);
        assert_eq!(role("Test 3"), Role::Test);
        assert_eq!(role("train_1"), Role::Train);
        assert_eq!(role("é"), Role::Train);
        let bare = Entry::with_default_role(recording("test", &["S1"], &[]));
        assert_eq!(bare.role, Role::Off);
    }

    #[test]
    fn other_columns_are_refused_and_change_nothing() {
        let mut set = RecordingSet::default();
        set.push(Entry::with_default_role(recording("bare", &["S1", "S2"], &[]))).unwrap();
        set.push(Entry::with_default_role(recording("a", &["S1", "S2"], &[Axis::Fz]))).unwrap();
        let before = set.clone();
        let gauges = set.push(Entry::with_default_role(recording("b", &["S1"], &[Axis::Fz])));
        let is_about = |refused: Result<(), RecordingError>, meant| matches!(refused, Err(RecordingError::Layout { what, .. }) if what == meant);
        assert!(is_about(gauges, "gauges"));
        let axes = set.push(Entry::with_default_role(recording("c", &["S1", "S2"], &[Axis::Fx])));
        assert!(is_about(axes, "reference axes"));
        assert_eq!(set, before);
    }

    #[test]
    fn a_split_set_trains_on_first_parts_and_tests_on_the_rest() {
        let mut set = RecordingSet::default();
        set.push(Entry::with_default_role(recording("a", &["S1"], &[Axis::Fz]))).unwrap();
        set.push(Entry::with_default_role(recording("bare", &["S1"], &[]))).unwrap();
        let split = set.split(0.6);
        let seen: Vec<_> =
            split.entries().iter().map(|entry| (entry.recording.n_samples(), entry.role)).collect();
        assert_eq!(seen, [(6, Role::Train), (4, Role::Test), (10, Role::Off)]);
    }
}
