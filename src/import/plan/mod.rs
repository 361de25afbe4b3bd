//! Plan for reading the columns of one file. The plan is made from a column map that was checked and applied to the file.
//!
//! Guarantees of a plan: times come from one source, or the rows have no times. There are at most 64 gauges. A file with only a
//! reference load has at least one axis. No axis occurs twice. Every unit that must be converted is known.

mod making;
mod parts;

use super::named_column::NamedColumn;
use crate::{
    formats::text::{TextLayout, times::TimeForm},
    recording::Axis,
};
pub(super) use parts::{
    AUXILIARY_LIMIT, CHANNEL_LIMIT, Channels, GAUGE_LIMIT, PosePlan, Side, TimeScale, Use,
};

/// Use of each column of a file. Lists of columns have the order of the columns in the file.
#[derive(Debug)]
pub struct Plan {
    /// Number of the line with the header, or with the first row of a table without header.
    pub line: u64,
    pub text: TextLayout,
    pub uses: Vec<Use>,
    pub names: Vec<String>,
    /// For each column, the numbers that mark a missing value. The list is empty if no column has such a mark.
    pub dropouts: Vec<Vec<f64>>,
    pub time_scale: TimeScale,
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
    /// Plan for the columns of the sensor's pose, if the load is computed from the pose.
    pub pose: Option<PosePlan>,
    /// True if the columns that are read may be blank in a row, because the row belongs to the other clock (gauges or
    /// reference).
    pub may_be_blank: bool,
    /// True if the rows have no times.
    pub is_static: bool,
}

impl Plan {
    /// Returns true if the times are times of day without a date, so that they start again at midnight.
    pub fn is_time_of_day(&self) -> bool {
        let is_date = |usage: &Use| matches!(usage, Use::TimeText(TimeForm::Date(_)));
        let is_clock = |usage: &Use| *usage == Use::TimeText(TimeForm::TimeOfDay);
        self.uses.iter().any(is_clock) && !self.uses.iter().any(is_date)
    }

    /// Returns true if [`Self::since`] is subtracted from the numbers of this column.
    #[inline]
    pub fn is_since_off(&self, index: usize) -> bool {
        let is_date = |usage: &Use| matches!(usage, Use::TimeText(TimeForm::Date(_)));
        // Most calls end at the first condition, because `since` is mostly 0. This matters, because the function is called
        // for each cell of a file.
        self.since != 0 && self.uses.iter().position(is_date).or(self.time_column) == Some(index)
    }

    pub fn since_of(&self, index: usize) -> i64 {
        i64::from(self.is_since_off(index)) * self.since
    }

    pub fn column(&self, index: usize) -> NamedColumn {
        NamedColumn::new(index, &self.names[index])
    }

    /// Returns the time column, or the first column if the row number gives the time.
    pub fn time(&self) -> NamedColumn {
        self.column(self.time_column.unwrap_or_default())
    }

    pub fn group_column(&self) -> Option<usize> {
        self.uses.iter().position(|usage| *usage == Use::Group)
    }

    /// Returns the name of the group of a row, from the value in the group column. `None` without a group column.
    pub fn group_name(&self, value: &str) -> Option<String> {
        Some(format!("{} {value}", self.names[self.group_column()?]))
    }

    pub fn pose_width(&self) -> usize {
        self.pose.as_ref().map_or(0, |pose| pose.width)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{plan_and_notes, plan_of_names};
    use super::*;
    use crate::import::error::{ReadError, TableError};

    #[test]
    fn loads_come_in_axis_order_and_gauges_in_file_order() {
        let (plan, notes) = plan_and_notes("Tz_Nmm,S2,t,Fx [kN],S1 [mV/V]").unwrap();
        assert_eq!(plan.axes, [Axis::Fx, Axis::Mz]);
        assert_eq!(plan.gauges.names, ["S2", "S1"]);
        assert_eq!(plan.gauges.units, ["", "mV/V"]);
        let load = |slot, factor| Use::Load { slot, factor };
        assert_eq!(plan.uses[0], load(1, 1e-3));
        assert_eq!(plan.uses[3], load(0, 1e3));
        assert_eq!(plan.time_scale, TimeScale::ByValues);
        assert!(notes.is_empty());
    }

    #[test]
    fn a_bracketed_unit_stays_with_its_name_between_blanks() {
        let plan = plan_of_names("time [ms]  S1 (mV / V)  Mx (N mm)");
        assert_eq!(plan.time_scale, TimeScale::PerSecond(1e3));
        assert_eq!(plan.names, ["time", "S1", "Mx"]);
        assert_eq!(plan.axes, [Axis::Mx]);
    }

    #[test]
    fn an_error_gives_the_line_and_the_column() {
        let message = |text: &str| plan_and_notes(text).unwrap_err().to_string();
        let missing = message("t,a\tb");
        assert!(missing.contains("no column of numbers among t"), "{missing}");
        let unit = message("t,S1,Fx [stone]");
        assert!(unit.contains("column 3 (Fx) has the unknown unit stone. Known units: N, kN"));
        assert!(message("t,S1,Mx (N)").contains("unknown unit N. Known units: N·m"));
        assert!(message("t [week],S1").contains("unknown unit week. Known units: s, ms"));
        assert_eq!(plan_of_names("t,S1,Fx,ATI_Fx").axes, [Axis::Fx]);
        assert_eq!(plan_of_names("t,S1 [V],x,S1 [mV]").gauges.names, ["S1", "S1 (2)"]);
    }

    #[test]
    fn sixty_four_gauges_are_the_limit() {
        let gauges = |n: usize| (0..n).map(|k| format!(",ch{k}")).collect::<String>();
        assert_eq!(plan_of_names(&format!("t{}", gauges(64))).gauges.names.len(), 64);
        let error = plan_and_notes(&format!("t{}", gauges(70))).unwrap_err();
        assert!(matches!(
            error,
            ReadError::Table { source: TableError::TooMany { count: 70, .. }, .. }
        ));
        assert!(error.to_string().ends_with("ch6 and 63 more"));
    }
}
