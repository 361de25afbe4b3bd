//! What a column can be, and how that is spelled.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::MapError;
use crate::recording::Axis;

/// What a column is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "&'static str", try_from = "String")]
pub enum ColumnRole {
    /// Looked at by nobody.
    Ignore,
    /// When the sample was taken.
    Time,
    /// When the reference of this row was taken, where that is another time.
    TimeReference,
    /// The day that belongs to a time of day in the `time` column.
    Date,
    /// A gauge channel.
    Gauge,
    /// One axis of the reference load.
    Load(Axis),
    /// A status word in hexadecimal digits; rows in which it reports an error are left out.
    Status,
    /// A part of the sensor's pose, from which the load of a known weight is computed.
    Pose(PosePart),
    /// Which of several weights the sensor carries, by name.
    Mount,
}

/// One number of a pose: of the sensor's position in the world, or of how it is turned (sensor to world).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are the documentation")]
pub enum PosePart {
    X,
    Y,
    Z,
    Qw,
    Qx,
    Qy,
    Qz,
    Roll,
    Pitch,
    Yaw,
    /// Of a rotation vector.
    Rx,
    Ry,
    Rz,
    /// Of a rotation matrix: row, column.
    R11,
    R12,
    R13,
    R21,
    R22,
    R23,
    R31,
    R32,
    R33,
}

impl PosePart {
    /// The position, which is only needed for the acceleration.
    pub const POSITION: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// As in the file of a map.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::X => "pose_x",
            Self::Y => "pose_y",
            Self::Z => "pose_z",
            Self::Qw => "pose_qw",
            Self::Qx => "pose_qx",
            Self::Qy => "pose_qy",
            Self::Qz => "pose_qz",
            Self::Roll => "pose_roll",
            Self::Pitch => "pose_pitch",
            Self::Yaw => "pose_yaw",
            Self::Rx => "pose_rx",
            Self::Ry => "pose_ry",
            Self::Rz => "pose_rz",
            Self::R11 => "pose_r11",
            Self::R12 => "pose_r12",
            Self::R13 => "pose_r13",
            Self::R21 => "pose_r21",
            Self::R22 => "pose_r22",
            Self::R23 => "pose_r23",
            Self::R31 => "pose_r31",
            Self::R32 => "pose_r32",
            Self::R33 => "pose_r33",
        }
    }

    /// Whether this is an angle or a length along an axis of one.
    #[must_use]
    pub const fn is_angle(self) -> bool {
        matches!(
            self,
            Self::Roll | Self::Pitch | Self::Yaw | Self::Rx | Self::Ry | Self::Rz
        )
    }
}

impl ColumnRole {
    /// Everything that a column can be.
    pub const ALL: [Self; 35] = [
        Self::Ignore,
        Self::Time,
        Self::TimeReference,
        Self::Date,
        Self::Gauge,
        Self::Load(Axis::Fx),
        Self::Load(Axis::Fy),
        Self::Load(Axis::Fz),
        Self::Load(Axis::Mx),
        Self::Load(Axis::My),
        Self::Load(Axis::Mz),
        Self::Status,
        Self::Pose(PosePart::X),
        Self::Pose(PosePart::Y),
        Self::Pose(PosePart::Z),
        Self::Pose(PosePart::Qw),
        Self::Pose(PosePart::Qx),
        Self::Pose(PosePart::Qy),
        Self::Pose(PosePart::Qz),
        Self::Pose(PosePart::Roll),
        Self::Pose(PosePart::Pitch),
        Self::Pose(PosePart::Yaw),
        Self::Pose(PosePart::Rx),
        Self::Pose(PosePart::Ry),
        Self::Pose(PosePart::Rz),
        Self::Pose(PosePart::R11),
        Self::Pose(PosePart::R12),
        Self::Pose(PosePart::R13),
        Self::Pose(PosePart::R21),
        Self::Pose(PosePart::R22),
        Self::Pose(PosePart::R23),
        Self::Pose(PosePart::R31),
        Self::Pose(PosePart::R32),
        Self::Pose(PosePart::R33),
        Self::Mount,
    ];

    /// As in the file of a map.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ignore => "ignore",
            Self::Time => "time",
            Self::TimeReference => "time_reference",
            Self::Date => "date",
            Self::Gauge => "gauge",
            Self::Load(axis) => axis.symbol(),
            Self::Status => "status",
            Self::Pose(part) => part.name(),
            Self::Mount => "mount",
        }
    }
}

impl fmt::Display for ColumnRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl From<ColumnRole> for &'static str {
    fn from(role: ColumnRole) -> Self {
        role.name()
    }
}

impl TryFrom<String> for ColumnRole {
    type Error = MapError;

    fn try_from(name: String) -> Result<Self, MapError> {
        if let Some(role) = Self::ALL.into_iter().find(|role| role.name() == name) {
            return Ok(role);
        }
        let known = Self::ALL.map(Self::name).join(", ");
        Err(MapError::UnknownRole { name, known })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_role_is_read_by_its_own_name() {
        for role in ColumnRole::ALL {
            assert_eq!(ColumnRole::try_from(role.name().to_owned()).unwrap(), role);
        }
        let error = |name: &str| ColumnRole::try_from(name.to_owned()).unwrap_err();
        assert!(matches!(error("Fq"), MapError::UnknownRole { .. }));
        assert!(error("Fq").to_string().contains("time_reference, date"));
    }
}
