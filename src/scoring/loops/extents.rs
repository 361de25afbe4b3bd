//! Noise and range of the load on each axis, over several recordings.

use crate::{
    recording::{Axis, Recording, RecordingSet, Role},
    scoring::loops::turns::LoadExtent,
};

/// Returns the noise and range of each axis' load in these recordings. A recording without an axis is skipped for this axis.
pub fn extents_of<'a>(
    recordings: impl IntoIterator<Item = &'a Recording>,
    axes: &[Axis],
) -> Vec<LoadExtent> {
    let mut extents = vec![LoadExtent::default(); axes.len()];
    for recording in recordings {
        for (extent, axis) in extents.iter_mut().zip(axes) {
            if let Some(loads) = recording.load(*axis) {
                let loads: Vec<f64> = loads.collect();
                *extent = extent.with(LoadExtent::of([&loads[..]]));
            }
        }
    }
    extents
}

/// Returns the noise and range of each axis' load in the training and test recordings. Without such recordings, it uses all
/// recordings.
pub fn extents_of_set(set: &RecordingSet, axes: &[Axis]) -> Vec<LoadExtent> {
    let entries = set.entries().iter();
    let used = entries.clone().filter(|entry| entry.role != Role::Off);
    if used.clone().next().is_some() {
        extents_of(used.map(|entry| &*entry.recording), axes)
    } else {
        extents_of(entries.map(|entry| &*entry.recording), axes)
    }
}
