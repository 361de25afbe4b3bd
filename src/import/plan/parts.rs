//! What a column is used for, and what is said of times and poses.

use crate::formats::text::times::TimeForm;
use crate::import::map::{Attitude, ColumnMap, ColumnRole};

/// More channels than any force/torque sensor has, few enough for normal equations to stay small.
pub(crate) const GAUGE_LIMIT: usize = 64;
/// As many products with gauges as one would ever fit.
pub(crate) const AUXILIARY_LIMIT: usize = 8;

/// What a column is used for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Use {
    Ignored,
    /// A number, part of the time.
    Time,
    /// A date or a time of day, part of the time.
    TimeText(TimeForm),
    /// Times `factor` it is in the unit of the time, and part of it.
    TimeFraction {
        factor: f64,
    },
    /// Times `factor` it is as the map wants it.
    Gauge {
        factor: f64,
    },
    /// Times `factor` and with `shift` added it is in the channel's unit; a cell without a number leaves the last one standing.
    Auxiliary {
        factor: f64,
        shift: f64,
    },
    /// The reference load number `slot` in [`Axis`](crate::recording::Axis) order; times `factor` it is SI.
    Load {
        slot: usize,
        factor: f64,
    },
    Status,
    /// Number `slot` of a pose; times `factor` it is in SI.
    Pose {
        slot: usize,
        factor: f64,
    },
    /// The name of a mount, whose place in the list becomes number `slot` of a pose.
    Mount {
        slot: usize,
    },
}

impl Use {
    /// Whether it is read as a number.
    pub const fn is_number(self) -> bool {
        !matches!(self, Self::TimeText(_) | Self::Status | Self::Mount { .. })
    }

    /// Whether it is a part of the time.
    pub const fn is_time(self) -> bool {
        matches!(self, Self::Time | Self::TimeText(_) | Self::TimeFraction { .. })
    }

    /// What one of its numbers is as the map wants it.
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

    /// What a message calls such a column.
    pub fn noun(self) -> &'static str {
        match self {
            Self::Ignored | Self::Status | Self::Mount { .. } => "column",
            Self::Pose { .. } => "pose",
            Self::Time | Self::TimeText(_) | Self::TimeFraction { .. } => "time",
            Self::Gauge { .. } => "gauge",
            Self::Auxiliary { .. } => "auxiliary channel",
            Self::Load { .. } => "reference",
        }
    }
}

/// Which part of a table is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Everything: gauges and reference have one clock.
    Both,
    /// The gauges alone.
    Gauges,
    /// The reference, whose time is a second one in the file of the gauges.
    SecondClock,
    /// The reference, in a file of its own.
    ReferenceFile,
}

impl Side {
    /// The part of a file that is read for its gauges.
    pub fn of_gauges(map: &ColumnMap) -> Self {
        if map.has_two_clocks() { Self::Gauges } else { Self::Both }
    }

    pub(super) fn has_gauges(self) -> bool {
        matches!(self, Self::Both | Self::Gauges)
    }

    /// Whether columns with this role are read.
    pub(super) fn reads(self, role: ColumnRole) -> bool {
        use ColumnRole::{
            Auxiliary, Date, Gauge, Ignore, Load, Mount, Pose, Status, Time, TimeFraction,
            TimeReference,
        };
        match role {
            Ignore => false,
            Gauge | Auxiliary => self.has_gauges(),
            Load(_) | Pose(_) | Mount | Status => self != Self::Gauges,
            Time | Date | TimeFraction => self != Self::SecondClock,
            TimeReference => self == Self::SecondClock,
        }
    }

    pub(super) fn time_role(self) -> ColumnRole {
        if self == Self::SecondClock { ColumnRole::TimeReference } else { ColumnRole::Time }
    }
}

/// Where times come from and what they count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TimeScale {
    /// This number makes one second.
    PerSecond(f64),
    /// By their values.
    ByValues,
}

/// The numbers of a pose, as they stand beside each other: how the sensor is turned, where it is, what it carries.
#[derive(Clone, Debug)]
pub(crate) struct PosePlan {
    pub attitude: Attitude,
    /// Where the three numbers of the position stand, if they are there.
    pub position: Option<usize>,
    /// Where the number of the mount stands, if it is there.
    pub mount: Option<usize>,
    /// The mounts' names.
    pub mounts: Vec<String>,
    pub width: usize,
}

impl PosePlan {
    /// No pose has more numbers: a matrix, a position, a mount.
    pub const WIDTH_LIMIT: usize = 13;
}
