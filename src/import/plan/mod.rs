//! Plan for reading the columns of one file. The plan is made from a column map that was checked and applied to the file.
//!
//! Guarantees of a plan: times come from one source, or the rows have no times. There are at most 64 gauges. A file with only a
//! reference load has at least one axis. No axis occurs twice. Every unit that must be converted is known.

mod making;

use super::named_column::NamedColumn;
use crate::{
    formats::text::{TextLayout, times::TimeForm},
    import::map::{Attitude, ColumnMap, ColumnRole},
    recording::Axis,
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

/// Use of one column of a file. A number of the column times `factor`, plus `shift`, is in SI units.
#[derive(Clone, Debug)]
pub struct PlannedColumn {
    /// Role of the column; `Ignore` if it is not read. The time of either clock has the role `Time`.
    pub is: ColumnRole,
    /// Name of the column for messages: from the header, else that of its channel, else its role.
    pub name: String,
    pub factor: f64,
    pub shift: f64,
    /// Index of the axis among the axes of the file, or of the number among the numbers of a pose.
    pub slot: usize,
    /// Notation of the date or time of day, if the column holds one as a text.
    pub form: Option<TimeForm>,
    /// Numbers that mark a missing value.
    pub dropouts: Vec<f64>,
}

impl PlannedColumn {
    pub const fn is_number(&self) -> bool {
        self.form.is_none() && !matches!(self.is, ColumnRole::Status | ColumnRole::Group)
    }

    pub const fn is_time(&self) -> bool {
        matches!(self.is, ColumnRole::Time | ColumnRole::Date | ColumnRole::TimeFraction)
    }

    /// Returns true if a row can be used without a value in this column.
    pub const fn may_be_missing(&self) -> bool {
        matches!(self.is, ColumnRole::Auxiliary | ColumnRole::Channel)
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
            Auxiliary, Channel, Date, Gauge, Group, Ignore, Load, Pose, Status, Time, TimeFraction,
            TimeReference,
        };
        match role {
            Ignore => false,
            Gauge | Auxiliary | Channel | Group => self.has_gauges(),
            Load(_) | Pose(_) | Status => self != Self::Gauges,
            Time | Date | TimeFraction => self != Self::SecondClock,
            TimeReference => self == Self::SecondClock,
        }
    }

    pub fn time_role(self) -> ColumnRole {
        if self == Self::SecondClock { ColumnRole::TimeReference } else { ColumnRole::Time }
    }
}

/// Use of each column of a file. Lists of columns have the order of the columns in the file.
#[derive(Debug)]
pub struct Plan {
    /// Number of the line with the header, or with the first row of a table without header.
    pub line: u64,
    pub text: TextLayout,
    pub columns: Vec<PlannedColumn>,
    /// Number by which times are divided to give seconds. `None` if it follows from the times.
    pub per_second: Option<f64>,
    /// Number that is subtracted from the times, in the unit of the file. It is subtracted because times since 1970 would
    /// lose digits.
    pub since: i64,
    /// Index of the time column. `None` if the row number gives the time.
    pub time_column: Option<usize>,
    pub gauges: Channels,
    pub auxiliary: Channels,
    /// Channels that are only shown.
    pub others: Channels,
    pub axes: Vec<Axis>,
    /// Representation of the sensor's orientation, if the load is computed from it.
    pub attitude: Option<Attitude>,
    /// True if the columns that are read may be blank in a row, because the row belongs to the other clock (gauges or
    /// reference).
    pub may_be_blank: bool,
    /// True if the rows have no times.
    pub is_static: bool,
}

impl Plan {
    /// Returns true if the times are times of day without a date, so that they start again at midnight.
    pub fn is_time_of_day(&self) -> bool {
        let is_clock = |column: &PlannedColumn| column.form == Some(TimeForm::TimeOfDay);
        self.columns.iter().any(is_clock) && self.date_column().is_none()
    }

    fn date_column(&self) -> Option<usize> {
        self.columns.iter().position(|column| matches!(column.form, Some(TimeForm::Date(_))))
    }

    /// Returns true if [`Self::since`] is subtracted from the numbers of this column.
    #[inline]
    pub fn is_since_off(&self, index: usize) -> bool {
        // Most calls end at the first condition, because `since` is mostly 0. This matters, because the function is called
        // for each cell of a file.
        self.since != 0
            && self.columns[index].is_time()
            && self.date_column().or(self.time_column) == Some(index)
    }

    pub fn since_of(&self, index: usize) -> i64 {
        i64::from(self.is_since_off(index)) * self.since
    }

    pub fn column(&self, index: usize) -> NamedColumn {
        NamedColumn::new(index, &self.columns[index].name)
    }

    /// Returns the time column, or the first column if the row number gives the time.
    pub fn time(&self) -> NamedColumn {
        self.column(self.time_column.unwrap_or_default())
    }

    /// Returns the indices of the columns with this role.
    pub fn with_role(&self, is: ColumnRole) -> impl Iterator<Item = usize> {
        let columns = self.columns.iter().enumerate();
        columns.filter(move |(_, column)| column.is == is).map(|(index, _)| index)
    }

    pub fn group_column(&self) -> Option<usize> {
        self.with_role(ColumnRole::Group).next()
    }

    /// Returns the name of the group of a row, from the value in the group column. `None` without a group column.
    pub fn group_name(&self, value: &str) -> Option<String> {
        Some(format!("{} {value}", self.columns[self.group_column()?].name))
    }

    /// Returns the number of numbers by which a row describes the orientation.
    pub fn pose_width(&self) -> usize {
        self.attitude.map_or(0, |attitude| attitude.parts().len())
    }
}
