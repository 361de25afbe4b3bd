//! What a column can be, and how that is spelled.

use std::fmt;

use serde::{Deserialize, Serialize};
use strum::VariantArray as _;

use crate::import::map::error::MapError;
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
    /// What is added to the `time` column: the nanoseconds, or milliseconds, of a stamp that has its seconds there.
    TimeFraction,
    /// A gauge channel.
    Gauge,
    /// A channel that is no gauge but moves them: temperature, supply voltage, humidity.
    Auxiliary,
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::IntoStaticStr, strum::VariantArray)]
#[strum(prefix = "pose_", serialize_all = "snake_case")]
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

    /// Whether this is an angle or a length along an axis of one.
    pub const fn is_angle(self) -> bool {
        matches!(self, Self::Roll | Self::Pitch | Self::Yaw | Self::Rx | Self::Ry | Self::Rz)
    }
}

impl ColumnRole {
    /// Everything that a column can be.
    pub fn all() -> impl Iterator<Item = Self> {
        let first = [
            Self::Ignore,
            Self::Time,
            Self::TimeReference,
            Self::Date,
            Self::TimeFraction,
            Self::Gauge,
            Self::Auxiliary,
        ];
        let poses = PosePart::VARIANTS.iter().copied().map(Self::Pose);
        first
            .into_iter()
            .chain(Axis::ALL.map(Self::Load))
            .chain([Self::Status])
            .chain(poses)
            .chain([Self::Mount])
    }

    /// As in the file of a map.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ignore => "ignore",
            Self::Time => "time",
            Self::TimeReference => "time_reference",
            Self::Date => "date",
            Self::TimeFraction => "time_fraction",
            Self::Gauge => "gauge",
            Self::Auxiliary => "auxiliary",
            Self::Load(axis) => axis.symbol(),
            Self::Status => "status",
            Self::Pose(part) => part.into(),
            Self::Mount => "mount",
        }
    }

    /// As people call it.
    pub fn label(self) -> String {
        match self {
            Self::TimeReference => "Reference clock".to_owned(),
            Self::Auxiliary => "Auxiliary channel".to_owned(),
            Self::Mount => "Mounting pose".to_owned(),
            other => {
                let name = other.name().replace('_', " ");
                let initial = name.chars().take(1).flat_map(char::to_uppercase);
                initial.chain(name.chars().skip(1)).collect()
            }
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
        if let Some(role) = Self::all().find(|role| role.name() == name) {
            return Ok(role);
        }
        let known: Vec<&str> = Self::all().map(Self::name).collect();
        let known = known.join(", ");
        Err(MapError::UnknownRole { name, known })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_role_is_read_by_its_own_name() {
        for role in ColumnRole::all() {
            assert_eq!(ColumnRole::try_from(role.name().to_owned()).unwrap(), role);
        }
        let error = |name: &str| ColumnRole::try_from(name.to_owned()).unwrap_err();
        assert!(matches!(error("Fq"), MapError::UnknownRole { .. }));
        assert!(error("Fq").to_string().contains("time_reference, date"));
    }
}
