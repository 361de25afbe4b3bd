//! Parts of a plan: uses of columns, the part of a table that is read, the unit of times, the columns of a pose.

use crate::formats::text::times::TimeForm;
use crate::import::map::{Attitude, ColumnMap, ColumnRole};

/// Maximum number of gauges. No known force/torque sensor has more, and least squares stay fast.
pub(crate) const GAUGE_LIMIT: usize = 64;
/// Maximum number of auxiliary channels. More channels give too many features: each may be multiplied by all gauges.
pub(crate) const AUXILIARY_LIMIT: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Use {
    Ignored,
    /// Number that is the time or a part of it.
    Time,
    /// Date or time of day, which are added to the time.
    TimeText(TimeForm),
    /// Fraction of a second. `factor` converts to the unit of the time.
    TimeFraction {
        factor: f64,
    },
    /// Gauge. The map gives `factor`.
    Gauge {
        factor: f64,
    },
    /// Auxiliary channel. The value is the number times `factor` plus `shift`. For a cell without a number, the previous
    /// value is used.
    Auxiliary {
        factor: f64,
        shift: f64,
    },
    /// Reference load. `slot` is its index in the order of [`Axis`](crate::recording::Axis), and `factor` converts to SI.
    Load {
        slot: usize,
        factor: f64,
    },
    Status,
    /// Text that names the group of the row.
    Group,
    /// Number of a pose. `slot` is its index in the order of [`PosePlan`], and `factor` converts to SI.
    Pose {
        slot: usize,
        factor: f64,
    },
    /// Name of a mount. Number `slot` of the pose is its index in the list of mounts.
    Mount {
        slot: usize,
    },
}

impl Use {
    pub const fn is_number(self) -> bool {
        !matches!(self, Self::TimeText(_) | Self::Status | Self::Group | Self::Mount { .. })
    }

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

/// Columns of a table that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Gauges and reference with one clock.
    Both,
    Gauges,
    /// Reference in the file of the gauges, with its own time column.
    SecondClock,
    /// Reference in a separate file.
    ReferenceFile,
}

impl Side {
    /// Returns the columns that are read from the file with the gauges.
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
    PerSecond(f64),
    ByValues,
}

/// Numbers of a pose in each row, in this order: orientation, position, mount.
#[derive(Clone, Debug)]
pub(crate) struct PosePlan {
    pub attitude: Attitude,
    /// Index of the first of the three numbers of the position, if the position is known.
    pub position: Option<usize>,
    /// Index of the number of the mount, if a column gives the mount.
    pub mount: Option<usize>,
    pub mounts: Vec<String>,
    pub width: usize,
}

impl PosePlan {
    /// Maximum number of numbers in a row: 9 for a matrix, 3 for a position and 1 for a mount.
    pub const WIDTH_LIMIT: usize = 13;
}
