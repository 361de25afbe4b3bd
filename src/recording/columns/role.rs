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
}

/// Names that will mean parts of a pose.
const RESERVED: [&str; 7] = [
    "pose_x", "pose_y", "pose_z", "pose_qw", "pose_qx", "pose_qy", "pose_qz",
];

impl ColumnRole {
    /// Everything that a column can be.
    pub const ALL: [Self; 12] = [
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
        Err(if RESERVED.contains(&name.as_str()) {
            MapError::ReservedRole { name }
        } else {
            let known = Self::ALL.map(Self::name).join(", ");
            MapError::UnknownRole { name, known }
        })
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
        assert!(matches!(error("pose_x"), MapError::ReservedRole { .. }));
    }
}
