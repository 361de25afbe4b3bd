//! What a person has to decide about a proposal, and when it is decided.

use std::fmt;

use serde::Serialize;

use super::columns::ColumnReport;
use crate::import::map::{ColumnMap, ColumnRole};
use crate::shown::listed;

/// What the file does not say; its text says what to do about it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub enum Question {
    /// The file holds a reference alone: it belongs to another file's map.
    ReferenceAlone,
    /// Which column is the time.
    Time,
    /// Whether the reference has a clock of its own: these columns (from 1 on) could be one.
    ReferenceClock(Vec<usize>),
    /// Which axes these columns (from 1 on) are of; they look like loads.
    LoadAxis(Vec<usize>),
    /// Which columns are gauges; these (from 1 on) are proposed.
    Gauges {
        /// The proposed ones.
        proposed: Vec<usize>,
        /// Whether the reference is known by its names.
        has_loads: bool,
    },
}

impl Question {
    /// As it stands by a map, after which the columns are these; `None` once that answers it.
    pub fn still_open(&self, map: &ColumnMap, columns: &[ColumnReport]) -> Option<Self> {
        let role_of = |number: usize| columns.get(number - 1).map(|report| report.is);
        let has_loads = || {
            let rules = &map.reference_table().columns;
            let by_column = rules.iter().any(|r| matches!(r.is, ColumnRole::Load(_)));
            by_column || map.weight.is_some() || map.reference.is_some()
        };
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
            Self::LoadAxis(_) | Self::Gauges { has_loads: false, .. } => !has_loads(),
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
                "this log of ATI's Net F/T holds the reference alone: put this table under \"reference\" in the map of the file with the gauges",
            ),
            Self::Time => f.write_str(
                "no column runs like a clock: say which is the time, or give \"sample_rate_hz\"; without either, rows with gauges and loads are load cases",
            ),
            Self::ReferenceClock(columns) => write!(
                f,
                "other columns that run like a clock: {}; if the reference has its own clock, one of them is \"time_reference\"",
                numbers(columns)
            ),
            Self::LoadAxis(columns) => write!(
                f,
                "columns that look like a load: {}; say which axis each is, Fx to Mz",
                numbers(columns)
            ),
            Self::Gauges {
                has_loads: false, ..
            } => f.write_str(
                "which columns are gauges and which the reference is not written in the file: all numbers that change are proposed as gauges, but for those with a unit of load; make the reference's columns \"Fx\" to \"Mz\" with their unit, and \"ignore\" the others",
            ),
            Self::Gauges { .. } => f.write_str(
                "which columns are gauges is not written in the file: all other numbers that change are proposed; \"ignore\" those that are none",
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
