//! Weight that a column map describes. The reference load is computed from this weight and the pose of the sensor.

use serde::{Deserialize, Serialize};

use crate::{
    import::map::{
        error::{FINITE, MapError, NOT_NEGATIVE, POSITIVE, must},
        role::{Attitude, ColumnRole, PosePart},
        table::TableMap,
    },
    recording::kinetics::{STANDARD_GRAVITY, Weight},
};

/// Known weight that hangs from the sensor. The reference load is computed from weight and pose instead of being measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WeightMap {
    /// Mass of the weight (kg). Not needed if each of the `mounts` has a mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Centre of mass of the weight in the sensor's frame (m). Not needed if each of the `mounts` has a centre of mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre_m: Option<[f64; 3]>,
    /// Several weights, or several mounting points of one weight. In each row, the column with the role `mount` names the one
    /// that is used. Without this column, the name of the file contains the name of the one that is used.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mounts: Vec<Mount>,
    /// Acceleration of gravity along the axes of the world's frame (m/s²). The default is `[0, 0, -9.80665]`, for a z axis
    /// that points up.
    pub gravity: [f64; 3],
    /// Order and axes of the rotations by roll, pitch and yaw.
    pub angles: Angles,
    /// Length of the time window (s) in which the path of the weight is smoothed to compute its acceleration.
    pub smoothing_secs: f64,
    /// True if the force that accelerates the weight is added to the reference load.
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
    /// Name of this weight or mounting point, as it occurs in the `mount` column or in the names of files.
    pub name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre_m: Option<[f64; 3]>,
}

/// Order and axes of the rotations by roll, pitch and yaw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Angles {
    /// First roll about the fixed x axis of the world, then pitch about its y axis, then yaw about its z axis, as in ROS:
    /// `Rz(yaw) Ry(pitch) Rx(roll)`.
    #[default]
    FixedXyz,
    /// First roll about the x axis, then pitch about the y axis turned by the roll, then yaw about the z axis turned by both:
    /// `Rx(roll) Ry(pitch) Rz(yaw)`.
    IntrinsicXyz,
}

impl Attitude {
    /// Returns how the columns of a table represent the orientation of the sensor. `None` if there is no pose. Returns an
    /// error if columns of the orientation are missing, or if two representations are mixed.
    pub fn of_table(table: &TableMap) -> Result<Option<Self>, MapError> {
        let of_pose = table.columns.iter().filter_map(|rule| match rule.is {
            ColumnRole::Pose(part) => Some(part),
            _ => None,
        });
        let of_pose: Vec<PosePart> = of_pose.collect();
        let turns = of_pose.iter().filter(|part| !PosePart::POSITION.contains(part)).count();
        let is_whole = |attitude: &Self| {
            let parts = attitude.parts();
            parts.len() == turns && parts.iter().all(|part| of_pose.contains(part))
        };
        match Self::ALL.into_iter().find(is_whole) {
            None if !of_pose.is_empty() => Err(MapError::Pose),
            attitude => Ok(attitude),
        }
    }
}

impl WeightMap {
    fn weight_of(&self, mount: &Mount) -> Option<Weight> {
        let (mass_kg, centre_m) =
            (mount.mass_kg.or(self.mass_kg), mount.centre_m.or(self.centre_m));
        Some(Weight { mass_kg: mass_kg?, centre_m: centre_m? })
    }

    /// Returns the weights whose mass and centre of mass are known, each with its name in `mounts`. If there are no `mounts`,
    /// the name is empty.
    pub fn weights(&self) -> Vec<(String, Weight)> {
        let own = [Mount::default()];
        let mounts = if self.mounts.is_empty() { &own[..] } else { &self.mounts };
        let weight = |mount: &Mount| Some((mount.name.clone(), self.weight_of(mount)?));
        mounts.iter().filter_map(weight).collect()
    }

    /// Returns an error if the weight is unknown, or if a column holds a measured load. Neither is an error when the weight
    /// is to be estimated.
    pub fn check_complete(&self, table: &TableMap) -> Result<(), MapError> {
        if let Some(rule) = table.columns.iter().find(|rule| rule.is.is_load()) {
            return Err(MapError::WeightAndLoad { role: rule.is });
        }
        if self.weights().is_empty() {
            return Err(MapError::WeightUnknown { mount: "\"weight\"".to_owned() });
        }
        Ok(())
    }

    pub fn check(&self, table: &TableMap) -> Result<(), MapError> {
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
