//! Roles that the columns of a file can have, and their names in map files.

use std::fmt;

use serde::{Deserialize, Serialize};
use strum::VariantArray as _;

use crate::recording::Axis;

/// Role of a column of a file, as a column map gives it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "&'static str", try_from = "String")]
pub enum ColumnRole {
    /// Column that is not used.
    Ignore,
    /// Time of the sample.
    Time,
    /// Time of the reference load, if the reference has another clock than the gauges.
    TimeReference,
    /// Date that is added to the time of day in the `time` column.
    Date,
    /// Fraction of a second that is added to the time in the `time` column: nanoseconds or milliseconds.
    TimeFraction,
    /// Gauge channel.
    Gauge,
    /// Auxiliary channel: a quantity that influences the gauges, such as temperature, supply voltage or humidity.
    Auxiliary,
    /// Channel that is only shown, such as a displacement. No fit uses it.
    Channel,
    /// Text or number that names the group to which the sample belongs, such as a press, a condition or a day. A new
    /// recording starts wherever the value changes.
    Group,
    /// Axis of the reference load.
    Load(Axis),
    /// Status word of the measuring device in hexadecimal digits. Rows in which the status reports an error are skipped.
    Status,
    /// Part of the sensor's pose, from which the load of a known weight is computed.
    Pose(PosePart),
}

/// One number of a pose: part of the sensor's position in the world, or of its orientation (sensor to world).
#[derive(Clone, Copy, Debug, PartialEq, strum::IntoStaticStr, strum::VariantArray)]
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
    /// Components of the rotation vector start here.
    Rx,
    Ry,
    Rz,
    /// Elements of the rotation matrix start here. The digits are row and column.
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
    /// Parts of a pose that make up the position, from which no load is computed.
    pub const POSITION: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Returns true if this part of the pose is an angle or a component of a rotation vector, so that its unit is rad or deg.
    pub const fn is_angle(self) -> bool {
        matches!(self, Self::Roll | Self::Pitch | Self::Yaw | Self::Rx | Self::Ry | Self::Rz)
    }
}

impl ColumnRole {
    /// Returns all roles.
    pub fn all() -> impl Iterator<Item = Self> {
        let poses = PosePart::VARIANTS.iter().copied().map(Self::Pose);
        [Self::Gauge, Self::Time]
            .into_iter()
            .chain(Axis::ALL.map(Self::Load))
            .chain([Self::Ignore, Self::TimeReference, Self::Auxiliary, Self::Channel, Self::Group])
            .chain([Self::Date, Self::TimeFraction, Self::Status])
            .chain(poses)
    }

    pub(crate) const fn is_load(self) -> bool {
        matches!(self, Self::Load(_))
    }

    /// Returns true for the channels that one file may have in any number.
    pub(crate) const fn is_channel(self) -> bool {
        matches!(self, Self::Gauge | Self::Auxiliary | Self::Channel)
    }

    /// Returns true if only one column of a table can have the role.
    pub(crate) const fn is_of_one_column(self) -> bool {
        !self.is_channel() && !matches!(self, Self::Ignore)
    }

    /// Returns the name of the role in map files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ignore => "ignore",
            Self::Time => "time",
            Self::TimeReference => "time_reference",
            Self::Date => "date",
            Self::TimeFraction => "time_fraction",
            Self::Gauge => "gauge",
            Self::Auxiliary => "auxiliary",
            Self::Channel => "channel",
            Self::Group => "group",
            Self::Load(axis) => axis.symbol(),
            Self::Status => "status",
            Self::Pose(part) => part.into(),
        }
    }

    /// Returns the label of the role in the window.
    pub fn label(self) -> String {
        match self {
            Self::TimeReference => "Reference clock".to_owned(),
            Self::Auxiliary => "Auxiliary channel".to_owned(),
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
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        Self::all().find(|role| role.name() == name).ok_or_else(|| {
            let known: Vec<&str> = Self::all().map(Self::name).collect();
            format!(
                "a column cannot have the role \"{name}\"; use one of the roles {}",
                known.join(", ")
            )
        })
    }
}

/// Representation of the sensor's orientation by numbers.
#[derive(Clone, Copy, Debug)]
pub enum Attitude {
    Quaternion,
    RollPitchYaw,
    /// Vector along the axis of rotation. Its length is the angle of rotation (rad).
    RotationVector,
    Matrix,
}

impl Attitude {
    pub const ALL: [Self; 4] =
        [Self::Quaternion, Self::RollPitchYaw, Self::RotationVector, Self::Matrix];

    /// Returns the parts of the pose that make up the orientation, in the order in which
    /// [`pose::rotation`](crate::import::pose::rotation) expects them.
    pub const fn parts(self) -> &'static [PosePart] {
        use PosePart::{
            Pitch, Qw, Qx, Qy, Qz, R11, R12, R13, R21, R22, R23, R31, R32, R33, Roll, Rx, Ry, Rz,
            Yaw,
        };
        match self {
            Self::Quaternion => &[Qw, Qx, Qy, Qz],
            Self::RollPitchYaw => &[Roll, Pitch, Yaw],
            Self::RotationVector => &[Rx, Ry, Rz],
            Self::Matrix => &[R11, R12, R13, R21, R22, R23, R31, R32, R33],
        }
    }

    /// Returns the roles of the columns of each representation, as a text for messages.
    pub fn listed() -> String {
        let of_attitude = |attitude: Self| {
            let parts = attitude.parts();
            let [first, last] = [parts[0], parts[parts.len() - 1]].map(ColumnRole::Pose);
            format!("{first} to {last}")
        };
        let [first @ .., last] = Self::ALL.map(of_attitude);
        format!("{} or {last}", first.join(", "))
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
        let message = ColumnRole::try_from("Fq".to_owned()).unwrap_err();
        assert!(ColumnRole::all().all(|role| message.contains(role.name())), "{message}");
    }
}
