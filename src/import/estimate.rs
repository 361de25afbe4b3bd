//! Estimates an unknown weight that hangs from the sensor, from measured loads in known poses.

use std::path::Path;

use super::{
    abandonable::abandonable, load::Reading, plan::Side, proposal::mapped, two_clocks,
    weigh::rotations,
};
use crate::{
    import::{
        error::ReadError,
        map::{ColumnMap, ColumnRole},
        pose::{self, WeightEstimate},
    },
    progress::Progress,
    recording::Axis,
};

/// Estimates mass and centre of mass of the weight that a sensor carries, from a recording of poses and measured loads on one
/// clock. The method is least squares with an unknown offset of the measured loads. What the map leaves out, or all columns
/// without a map, are proposed. `weight` in the map may set gravity and the convention of angles; its mass is not used.
/// Returns [`ReadError`] if the map does not fit the file, a pose or forces
/// are missing, the sensor never turned, or the forces do not change with the pose.
pub fn estimate_weight(
    path: &Path,
    map: Option<&ColumnMap>,
    progress: &Progress,
) -> Result<WeightEstimate, ReadError> {
    let (at, map) = (path.to_owned(), map.cloned());
    abandonable(path, progress, move |progress| estimated(&at, map.as_ref(), progress))
}

fn estimated(
    path: &Path,
    map: Option<&ColumnMap>,
    progress: &Progress,
) -> Result<WeightEstimate, ReadError> {
    map.map_or(Ok(()), ColumnMap::check)?;
    let reading = Reading::whole(progress);
    let parts = map.map_or(&[][..], |map| &map.table.text.parts);
    let map = &mapped(path, &reading.open(path, parts)?, map, None)?.map;
    let (path, side) = two_clocks::reference_of(path, map).unwrap_or_else(|| {
        let has_gauges = map.table.has_role(ColumnRole::Gauge);
        (path.to_owned(), if has_gauges { Side::Both } else { Side::ReferenceFile })
    });
    let opened = reading.open(&path, &map.reference_table().text.parts)?;
    let weight = map.weight.clone().unwrap_or_default();
    let mut table = reading.table(&path, opened, map.reference_table(), side, Some(&weight))?;
    let axes = table.plan.axes.clone();
    let slots = |wanted: &[Axis]| -> Option<Vec<usize>> {
        let slot = |axis: &Axis| axes.iter().position(|other| other == axis);
        wanted.iter().map(slot).collect()
    };
    let (Some(attitude), Some(forces)) = (table.plan.attitude, slots(&Axis::ALL[..3])) else {
        return Err(ReadError::NothingToWeigh { path });
    };
    let rotations = rotations(&mut table, attitude, &weight);
    let part = |slots: &[usize]| -> Vec<[f64; 3]> {
        let rows = table.rows.loads.chunks_exact(axes.len());
        rows.map(|row| std::array::from_fn(|i| row[slots[i]])).collect()
    };
    let moments = slots(&Axis::ALL[3..]).map(|slots| part(&slots));
    match pose::estimate_weight(&rotations, &part(&forces), moments.as_deref(), weight.gravity) {
        Some(found) if found.is_certain() => Ok(found),
        Some(_) => Err(ReadError::NoWeight { path }),
        None => Err(ReadError::NeverTurned { path }),
    }
}
