//! Weight in a column map. Its load is computed from the pose of the sensor.

use serde::{Deserialize, Serialize};

use crate::import::map::error::{FINITE, MapError, NOT_NEGATIVE, POSITIVE, must};
use crate::import::map::role::{Attitude, ColumnRole, PosePart};
use crate::import::map::table::TableMap;
use crate::recording::kinetics::{STANDARD_GRAVITY, Weight};

/// Weight that a sensor carries in known poses. The reference load is computed from weight and pose instead of measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WeightMap {
    /// Mass (kg). Not needed if each of the `mounts` has a mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Centre of mass in the sensor's frame (m). Not needed if each of the `mounts` has a centre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre_m: Option<[f64; 3]>,
    /// Several weights, or several mounting points of one weight. The `mount` column selects one for each row. Without this
    /// column, the name of the file selects one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mounts: Vec<Mount>,
    /// Acceleration of gravity in the world's axes (m/s²). The default is `[0, 0, -9.80665]`, so that z points up.
    pub gravity: [f64; 3],
    /// Convention of roll, pitch and yaw.
    pub angles: Angles,
    /// Time (s) over which the pose is smoothed to compute the acceleration of the weight.
    pub smoothing_secs: f64,
    /// True if the force that accelerates the weight is part of the load.
    pub inertia: bool,
}

impl Default for WeightMap {
    fn default() -> Self {
        Self {
            mass_kg: None,
            centre_m: None,
            mounts: Vec::new(),
            gravity: [0.0, 0.0, -STANDARD_GRAVITY],
            angles: Angles::default(),
            smoothing_secs: 0.2,
            inertia: false,
        }
    }
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mount {
    /// Name in the `mount` column or in the names of files.
    pub name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre_m: Option<[f64; 3]>,
}

/// Convention of roll, pitch and yaw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Angles {
    /// Roll about the world's x, then pitch about its y, then yaw about its z: `Rz(yaw) Ry(pitch) Rx(roll)`, as in ROS.
    #[default]
    FixedXyz,
    /// Roll about x, then pitch about the turned y, then yaw about the z turned by both: `Rx(roll) Ry(pitch) Rz(yaw)`.
    IntrinsicXyz,
}

impl Attitude {
    /// Returns the representation of the orientation in a table. `None` without a pose. Returns an error if columns are
    /// missing, or two representations are mixed.
    pub fn of_table(table: &TableMap) -> Result<Option<Self>, MapError> {
        let has = |part: &PosePart| table.has_role(ColumnRole::Pose(*part));
        let begun = Self::ALL.into_iter().filter(|attitude| attitude.parts().iter().any(has));
        let begun: Vec<Self> = begun.collect();
        match begun[..] {
            [] if PosePart::POSITION.iter().any(has) => Err(MapError::NoAttitude),
            [] => Ok(None),
            [attitude] => match attitude.parts().iter().find(|part| !has(part)) {
                None => Ok(Some(attitude)),
                Some(missing) => Err(MapError::PoseIncomplete { missing: *missing }),
            },
            [first, second, ..] => Err(MapError::TwoPoses {
                first: ColumnRole::Pose(first.parts()[0]),
                second: ColumnRole::Pose(second.parts()[0]),
            }),
        }
    }
}

impl WeightMap {
    fn weight_of(&self, mount: &Mount) -> Option<Weight> {
        let (mass_kg, centre_m) =
            (mount.mass_kg.or(self.mass_kg), mount.centre_m.or(self.centre_m));
        Some(Weight { mass_kg: mass_kg?, centre_m: centre_m? })
    }

    /// Returns the weights with known mass and centre, and the names of their mounts. The name of a single weight is empty.
    pub fn weights(&self) -> Vec<(String, Weight)> {
        let own = [Mount::default()];
        let mounts = if self.mounts.is_empty() { &own[..] } else { &self.mounts };
        let weight = |mount: &Mount| Some((mount.name.clone(), self.weight_of(mount)?));
        mounts.iter().filter_map(weight).collect()
    }

    /// Returns an error if the weight is unknown, or if a column is a measured load. Both are allowed for estimating the
    /// weight.
    pub fn check_complete(&self, table: &TableMap) -> Result<(), MapError> {
        if let Some(rule) = table.columns.iter().find(|rule| rule.is.is_load()) {
            return Err(MapError::WeightAndLoad { role: rule.is });
        }
        if self.weights().is_empty() {
            return Err(MapError::WeightUnknown { mount: "\"weight\"".to_owned() });
        }
        Ok(())
    }

    pub(super) fn check(&self, table: &TableMap) -> Result<(), MapError> {
        if Attitude::of_table(table)?.is_none() {
            return Err(MapError::WeightWithoutPose);
        }
        if self.mounts.is_empty() && table.has_role(ColumnRole::Mount) {
            return Err(MapError::NoMounts);
        }
        for (at, mount) in self.mounts.iter().enumerate() {
            let is_whole = self.weight_of(mount).is_some();
            let is_new = self.mounts[..at].iter().all(|m| m.name != mount.name);
            if mount.name.trim().is_empty() || !is_whole || !is_new {
                return Err(MapError::WeightUnknown { mount: format!("mount \"{}\"", mount.name) });
            }
        }
        for (_, weight) in self.weights() {
            must("weight.mass_kg", weight.mass_kg, POSITIVE)?;
            weight.centre_m.into_iter().try_for_each(|x| must("weight.centre_m", x, FINITE))?;
        }
        self.gravity.into_iter().try_for_each(|x| must("weight.gravity", x, FINITE))?;
        must("weight.smoothing_secs", self.smoothing_secs, NOT_NEGATIVE)
    }
}
