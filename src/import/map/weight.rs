//! Weight that a column map describes. The reference load is computed from this weight and the pose of the sensor.

use serde::{Deserialize, Serialize};

use crate::{
    import::map::{
        error::{FINITE, MapError, POSITIVE, must},
        role::{Attitude, ColumnRole, PosePart},
        table::TableMap,
    },
    recording::kinetics::{STANDARD_GRAVITY, Weight},
};

/// Known weight that hangs from the sensor. The reference load is computed from weight and pose instead of being measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WeightMap {
    /// Mass of the weight (kg).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Centre of mass of the weight in the sensor's frame (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre_m: Option<[f64; 3]>,
    /// Acceleration of gravity along the axes of the world's frame (m/s²). The default is `[0, 0, -9.80665]`, for a z axis
    /// that points up.
    pub gravity: [f64; 3],
    /// Order and axes of the rotations by roll, pitch and yaw.
    pub angles: Angles,
}

impl Default for WeightMap {
    fn default() -> Self {
        Self {
            mass_kg: None,
            centre_m: None,
            gravity: [0.0, 0.0, -STANDARD_GRAVITY],
            angles: Angles::default(),
        }
    }
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
    /// Returns the weight, if its mass and its centre of mass are known.
    pub fn weight(&self) -> Option<Weight> {
        Some(Weight { mass_kg: self.mass_kg?, centre_m: self.centre_m? })
    }

    /// Returns an error if the weight is unknown, or if a column holds a measured load. Neither is an error when the weight
    /// is to be estimated.
    pub fn check_complete(&self, table: &TableMap) -> Result<(), MapError> {
        if let Some(rule) = table.columns.iter().find(|rule| rule.is.is_load()) {
            return Err(MapError::WeightAndLoad { role: rule.is });
        }
        self.weight().map(|_| ()).ok_or(MapError::WeightUnknown)
    }

    pub fn check(&self, table: &TableMap) -> Result<(), MapError> {
        if Attitude::of_table(table)?.is_none() {
            return Err(MapError::WeightWithoutPose);
        }
        must("weight.mass_kg", self.mass_kg, POSITIVE)?;
        let centre = self.centre_m.into_iter().flatten();
        centre.into_iter().try_for_each(|x| must("weight.centre_m", x, FINITE))?;
        self.gravity.into_iter().try_for_each(|x| must("weight.gravity", x, FINITE))
    }
}
