//! Uses of columns, sides of a table, and the plans for times and poses.

use crate::formats::text::times::TimeForm;
use crate::import::map::{Attitude, ColumnMap, ColumnRole};

/// Maximum number of gauges: more than any force/torque sensor has, and small enough for normal equations.
pub(crate) const GAUGE_LIMIT: usize = 64;
/// Maximum number of auxiliary channels; each may give products with all gauges.
pub(crate) const AUXILIARY_LIMIT: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Use {
    Ignored,
    /// Number, part of the time.
    Time,
    /// Date or time of day, part of the time.
    TimeText(TimeForm),
    /// Fraction of the time; `factor` converts it to the unit of the time.
    TimeFraction {
        factor: f64,
    },
    /// Gauge; `factor` scales it as the map requires.
    Gauge {
        factor: f64,
    },
    /// Auxiliary channel; `factor`, then `shift`, converts to its unit. A cell without a number keeps the previous value.
    Auxiliary {
        factor: f64,
        shift: f64,
    },
    /// Reference load with index `slot` in the order of [`Axis`](crate::recording::Axis); `factor` converts it to SI.
    Load {
        slot: usize,
        factor: f64,
    },
    Status,
    /// Text that names the group of the row.
    Group,
    /// Pose value `slot`; `factor` converts it to SI.
    Pose {
        slot: usize,
        factor: f64,
    },
    /// Name of a mount; its index in the list of mounts becomes pose value `slot`.
    Mount {
        slot: usize,
    },
}

impl Use {
    pub const fn is_number(self) -> bool {
        !matches!(self, Self::TimeText(_) | Self::Status | Self::Group | Self::Mount { .. })
    }

    /// Returns true for a part of the time.
    pub const fn is_time(self) -> bool {
        matches!(self, Self::Time | Self::TimeText(_) | Self::TimeFraction { .. })
    }

    #[inline(always)]
    pub const fn factor(self) -> f64 {
        match self {
            Self::Gauge { factor }
            | Self::Auxiliary { factor, .. }
            | Self::Load { factor, .. }
            | Self::Pose { factor, .. }
            | Self::TimeFraction { factor } => factor,
            _ => 1.0,
        }
    }

    pub fn noun(self) -> &'static str {
        match self {
            Self::Ignored | Self::Status | Self::Group | Self::Mount { .. } => "column",
            Self::Pose { .. } => "pose",
            Self::Time | Self::TimeText(_) | Self::TimeFraction { .. } => "time",
            Self::Gauge { .. } => "gauge",
            Self::Auxiliary { .. } => "auxiliary channel",
            Self::Load { .. } => "reference",
        }
    }
}

/// Part of a table that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Gauges and reference, on one clock.
    Both,
    Gauges,
    /// Reference alone, with a second time in the file of the gauges.
    SecondClock,
    /// Reference alone, in a file of its own.
    ReferenceFile,
}

impl Side {
    /// Returns the side that is read from the file with the gauges.
    pub fn of_gauges(map: &ColumnMap) -> Self {
        if map.has_two_clocks() { Self::Gauges } else { Self::Both }
    }

    pub(super) fn has_gauges(self) -> bool {
        matches!(self, Self::Both | Self::Gauges)
    }

    pub(super) fn reads(self, role: ColumnRole) -> bool {
        use ColumnRole::{
            Auxiliary, Date, Gauge, Group, Ignore, Load, Mount, Pose, Status, Time, TimeFraction,
            TimeReference,
        };
        match role {
            Ignore => false,
            Gauge | Auxiliary | Group => self.has_gauges(),
            Load(_) | Pose(_) | Mount | Status => self != Self::Gauges,
            Time | Date | TimeFraction => self != Self::SecondClock,
            TimeReference => self == Self::SecondClock,
        }
    }

    pub(super) fn time_role(self) -> ColumnRole {
        if self == Self::SecondClock { ColumnRole::TimeReference } else { ColumnRole::Time }
    }
}

/// Conversion of times to seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TimeScale {
    /// Number of time units per second.
    PerSecond(f64),
    /// Unit derived from the values.
    ByValues,
}

/// Values of a pose, in this order: orientation, position, mount.
#[derive(Clone, Debug)]
pub(crate) struct PosePlan {
    pub attitude: Attitude,
    /// Index of the first of three position values, if there are any.
    pub position: Option<usize>,
    /// Index of the mount value, if there is one.
    pub mount: Option<usize>,
    pub mounts: Vec<String>,
    pub width: usize,
}

impl PosePlan {
    /// Maximum number of pose values: a matrix, a position and a mount.
    pub const WIDTH_LIMIT: usize = 13;
}
