//! Types of which a plan for reading a file consists: uses of columns, which columns of a table are read, the conversion of
//! times, and the columns of a pose.

use crate::{
    formats::text::times::TimeForm,
    import::map::{Attitude, ColumnMap, ColumnRole},
};

/// Maximum number of gauges. No known force/torque sensor has more, and with this number least squares are still fast.
pub const GAUGE_LIMIT: usize = 64;
/// Maximum number of auxiliary channels. More channels would give too many features, because each channel may be multiplied
/// by each gauge.
pub const AUXILIARY_LIMIT: usize = 8;
/// Maximum number of channels that are only shown.
pub const CHANNEL_LIMIT: usize = 64;

/// Channels of one kind, in the order of their columns.
#[derive(Clone, Debug, Default)]
pub struct Channels {
    pub names: Vec<String>,
    /// Unit of each channel; empty if unknown.
    pub units: Vec<String>,
}

impl Channels {
    /// Adds a channel. If an earlier one has the same name, the name gets a number.
    pub fn add(&mut self, name: String, unit: String) {
        let numbered = (2..).map(|number| format!("{name} ({number})"));
        let mut names = std::iter::once(name.clone()).chain(numbered);
        self.names.extend(names.find(|name| !self.names.contains(name)));
        self.units.push(unit);
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Use {
    Ignored,
    /// Number that is the time of the row, or a part of the time.
    Time,
    /// Date or time of day as a text. Dates and times of day are added to give the time of the row.
    TimeText(TimeForm),
    /// Fraction of a second that is added to the time. `factor` converts it to the unit of the time.
    TimeFraction {
        factor: f64,
    },
    /// Value of a gauge. It is multiplied by `factor`, which the column map gives.
    Gauge {
        factor: f64,
    },
    /// Value of an auxiliary channel: the number times `factor`, plus `shift`. If the cell has no number, the previous value
    /// of the channel is used.
    Auxiliary {
        factor: f64,
        shift: f64,
    },
    /// Value of a channel that is only shown. Without a number in the cell, the value is NaN.
    Channel {
        factor: f64,
    },
    /// Reference load on one axis. `slot` is the index of the axis among the axes of the file, in the order of
    /// [`Axis`](crate::recording::Axis). `factor` converts to SI.
    Load {
        slot: usize,
        factor: f64,
    },
    Status,
    /// Text that names the group to which the row belongs.
    Group,
    /// One number of the sensor's pose. `slot` is its index in the order of [`PosePlan`], and `factor` converts to SI.
    Pose {
        slot: usize,
        factor: f64,
    },
    /// Name of the weight that hangs from the sensor. Its index in the list of `mounts` is stored as number `slot` of the
    /// pose.
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
            | Self::Channel { factor }
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
            Self::Channel { .. } => "channel",
            Self::Load { .. } => "reference",
        }
    }
}

/// Choice of the columns that are read from a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    /// Gauges and reference load, which have the same clock.
    Both,
    Gauges,
    /// Reference load from the file with the gauges. It has a time column of its own.
    SecondClock,
    /// Reference load from a separate file.
    ReferenceFile,
}

impl Side {
    /// Returns the choice of the columns that are read from the file with the gauges.
    pub fn of_gauges(map: &ColumnMap) -> Self {
        if map.has_two_clocks() { Self::Gauges } else { Self::Both }
    }

    pub fn has_gauges(self) -> bool {
        matches!(self, Self::Both | Self::Gauges)
    }

    pub fn reads(self, role: ColumnRole) -> bool {
        use ColumnRole::{
            Auxiliary, Channel, Date, Gauge, Group, Ignore, Load, Mount, Pose, Status, Time,
            TimeFraction, TimeReference,
        };
        match role {
            Ignore => false,
            Gauge | Auxiliary | Channel | Group => self.has_gauges(),
            Load(_) | Pose(_) | Mount | Status => self != Self::Gauges,
            Time | Date | TimeFraction => self != Self::SecondClock,
            TimeReference => self == Self::SecondClock,
        }
    }

    pub fn time_role(self) -> ColumnRole {
        if self == Self::SecondClock { ColumnRole::TimeReference } else { ColumnRole::Time }
    }
}

/// Conversion of the times in a file to seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeScale {
    PerSecond(f64),
    ByValues,
}

/// Plan for the numbers of the sensor's pose in each row. Their order is: orientation, position, mount (the weight that hangs
/// from the sensor).
#[derive(Clone, Debug)]
pub struct PosePlan {
    pub attitude: Attitude,
    /// Index of the first of the three numbers of the position. `None` if the position is unknown.
    pub position: Option<usize>,
    /// Position, among the numbers of a pose, of the number that selects the mount. `None` if no column names the mount.
    pub mount: Option<usize>,
    pub mounts: Vec<String>,
    pub width: usize,
}

impl PosePlan {
    /// Maximum number of numbers of a pose: 9 for a rotation matrix, 3 for a position and 1 for the mount.
    pub const WIDTH_LIMIT: usize = 13;
}
