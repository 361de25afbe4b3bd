//! Questions about a proposed column map that the user has to decide.

use std::fmt;

use serde::Serialize;

use crate::{
    import::{
        column_report::ColumnReport,
        map::{ColumnMap, ColumnRole, ColumnRule, Header},
    },
    shown::listed,
};

/// Question about the columns of a file that neither their names nor their values answer. The text of the question names the
/// choices. Columns are counted from 1.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub enum Question {
    /// The file holds only a reference load, so the column map of the file with the gauges should name it.
    ReferenceAlone,
    /// Which column is the time?
    Time,
    /// Is one of these columns the time of the reference?
    ReferenceClock(Vec<usize>),
    /// Which axis does each of these columns have? They look like loads.
    LoadAxis(Vec<usize>),
    /// Which unit does each of these load columns have? The file gives none.
    LoadUnit(Vec<usize>),
    /// Which columns are gauges?
    Gauges {
        /// Columns proposed as gauges.
        proposed: Vec<usize>,
        /// True if the names of the columns show which of them are the reference load.
        has_loads: bool,
    },
}

impl Question {
    /// Returns the question, updated to the roles in this column map, or `None` if the map answers the question.
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
                "This log of ATI's Net F/T holds only the reference load. Name this file as the reference file in the column map of the file with the gauges.",
            ),
            Self::Time => f.write_str(
                "No column increases steadily like a time. Choose the time column, or set the sample rate. Otherwise, the rows are read as load cases without times.",
            ),
            Self::ReferenceClock(columns) => write!(
                f,
                "These columns also increase steadily like a time: {}. If one of them is the time of the reference load, give it the role Reference clock.",
                numbers(columns)
            ),
            Self::LoadAxis(columns) => write!(
                f,
                "These columns look like reference loads: {}. Choose the axis of each column, Fx to Mz.",
                numbers(columns)
            ),
            Self::LoadUnit(columns) => write!(
                f,
                "The file does not show the unit of the load in column {}. Enter the unit, for example N, kN, kgf, lbf, N·m or N·mm. Without a unit, forces are read in N and moments in N·m.",
                numbers(columns)
            ),
            Self::Gauges {
                has_loads: false, ..
            } => f.write_str(
                "The file does not show which columns are gauges and which are the reference load. All changing numeric columns without a unit of load are proposed as gauges. Choose axis and unit of each reference load, and the role Ignore for all other columns.",
            ),
            Self::Gauges { .. } => f.write_str(
                "The file does not show which columns are gauges. All numeric columns that change and have no other role are proposed as gauges. Give the role Ignore to columns that are not gauges.",
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
