//! Open decisions about a proposed column map, and the test of whether each is settled.

use std::fmt;

use serde::Serialize;

use super::columns::ColumnReport;
use crate::import::map::{ColumnMap, ColumnRole, ColumnRule, Header};
use crate::shown::listed;

/// Fact that the file does not give and the user has to decide. The question's text names the choices.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub enum Question {
    /// The file holds only a reference, so it belongs in the map of another file.
    ReferenceAlone,
    /// Choice of the time column.
    Time,
    /// Columns (counted from 1), one of which may be a separate clock of the reference.
    ReferenceClock(Vec<usize>),
    /// Load axis of each of these columns (counted from 1), which look like loads.
    LoadAxis(Vec<usize>),
    /// Units of load columns for which the file gives no unit, by the number of the column (from 1).
    LoadUnit(Vec<usize>),
    /// Choice of the gauge columns.
    Gauges {
        /// Columns proposed as gauges, counted from 1.
        proposed: Vec<usize>,
        /// True if the names of the columns show which are the reference.
        has_loads: bool,
    },
}

impl Question {
    /// Returns the question if it is still open under a map with these columns, else `None`.
    pub fn still_open(&self, map: &ColumnMap, columns: &[ColumnReport]) -> Option<Self> {
        let role_of = |number: usize| columns.get(number - 1).map(|report| report.is);
        let has_loads = map.reference_table().columns.iter().any(|rule| rule.is.is_load())
            || map.weight.is_some()
            || map.reference.is_some();
        let is_open = match self {
            Self::ReferenceAlone => true,
            Self::Time => {
                !map.table.has_role(ColumnRole::Time) && map.table.sample_rate_hz.is_none()
            }
            Self::ReferenceClock(_) => {
                let clocks = columns
                    .iter()
                    .filter(|report| report.runs_like_clock && report.is == ColumnRole::Ignore);
                let clocks: Vec<usize> = clocks.map(|report| report.number).collect();
                let is_open = !map.has_two_clocks() && !clocks.is_empty();
                return is_open.then_some(Self::ReferenceClock(clocks));
            }
            Self::LoadAxis(_) | Self::LoadUnit(_) | Self::Gauges { has_loads: false, .. }
                if has_loads =>
            {
                let header = Header::new(columns.iter().map(|report| report.header.as_str()));
                let rules = header.rules(&map.table).unwrap_or_default();
                let has_no_unit = |index: usize, rule: &ColumnRule| {
                    let in_file = columns.get(index).and_then(|report| report.unit.as_ref());
                    rule.is.is_load() && rule.unit.as_ref().or(in_file).is_none()
                };
                let without = rules.iter().filter(|(index, rule)| has_no_unit(*index, rule));
                let without: Vec<usize> = without.map(|(index, _)| index + 1).collect();
                return (!without.is_empty()).then_some(Self::LoadUnit(without));
            }
            Self::LoadAxis(_) | Self::LoadUnit(_) | Self::Gauges { has_loads: false, .. } => true,
            Self::Gauges { proposed, .. } => {
                proposed.iter().all(|number| role_of(*number) == Some(ColumnRole::Gauge))
            }
        };
        is_open.then(|| self.clone())
    }
}

impl fmt::Display for Question {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ReferenceAlone => f.write_str(
                "This log of ATI's Net F/T holds only the reference. Name it as the reference file in the column map of the file with the gauges.",
            ),
            Self::Time => f.write_str(
                "No column increases steadily like a time. Choose the time column or set the sample rate; without either, rows with gauges and loads are read as load cases.",
            ),
            Self::ReferenceClock(columns) => write!(
                f,
                "Other columns that increase steadily: {}. Is one of them the clock of the reference?",
                numbers(columns)
            ),
            Self::LoadAxis(columns) => write!(
                f,
                "Columns that look like a load: {}. Choose the axis of each, Fx to Mz.",
                numbers(columns)
            ),
            Self::LoadUnit(columns) => write!(
                f,
                "The file does not show the unit of the load in column {}. Enter the unit in the table below, for example N, kN, kgf, lbf, N·m or N·mm; if this question is ticked, forces are in N and moments in N·m.",
                numbers(columns)
            ),
            Self::Gauges {
                has_loads: false, ..
            } => f.write_str(
                "The file does not show which columns are gauges and which are the reference. All numeric columns that change, except those with a unit of load, are proposed as gauges. Choose axis and unit of the reference's columns, and ignore the columns that are neither.",
            ),
            Self::Gauges { .. } => f.write_str(
                "The file does not show which columns are gauges. All other numeric columns that change are proposed; ignore those that are not gauges.",
            ),
        }
    }
}

fn numbers(columns: &[usize]) -> String {
    let columns: Vec<String> = columns.iter().map(usize::to_string).collect();
    listed(&columns)
}

impl From<Question> for String {
    fn from(question: Question) -> Self {
        question.to_string()
    }
}
