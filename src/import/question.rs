//! Questions about the columns of a table whose answers change a result.

use std::fmt;

use serde::Serialize;

use crate::{
    import::{
        column_report::ColumnReport,
        map::{ColumnMap, ColumnRole},
    },
    recording::{
        Axis,
        units::{force_in_newtons, moment_in_newton_metres},
    },
    shown::{listed, shown},
};

/// Question about the columns of a file that neither their names nor their values answer. Columns are counted from 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(into = "String")]
pub enum Question {
    /// Is one of these columns the time of the reference?
    ReferenceClock(Vec<usize>),
    /// Which of these columns, all of which look like loads, is the reference?
    LoadAxis(Vec<usize>),
    /// Which of these columns, which are read as gauges, is the reference, if any?
    Load(Vec<usize>),
    /// Which unit does each of these load columns have? The file gives none, and the values may be counts.
    LoadUnit(Vec<usize>),
}

impl Question {
    /// Returns true if no result that needs a load is right without an answer.
    pub fn is_about_load(&self) -> bool {
        !matches!(self, Self::ReferenceClock(_))
    }

    /// Returns true if this column map does not answer the question.
    pub fn is_open(&self, map: &ColumnMap, columns: &[ColumnReport]) -> bool {
        let has_loads = map.reference_table().columns.iter().any(|rule| rule.is.is_load())
            || map.weight.is_some()
            || map.reference.is_some();
        match self {
            Self::ReferenceClock(clocks) => {
                let is_unused = |number: &usize| {
                    let role = columns.get(number - 1).map(|column| column.is);
                    matches!(role, Some(ColumnRole::Ignore | ColumnRole::Channel))
                };
                !map.has_two_clocks() && clocks.iter().any(is_unused)
            }
            Self::LoadAxis(_) | Self::Load(_) => !has_loads,
            Self::LoadUnit(numbers) => {
                let is_open = |number: &usize| {
                    let column = columns.get(number - 1);
                    column.is_some_and(|own| own.is.is_load() && own.unit.is_none())
                };
                numbers.iter().any(is_open)
            }
        }
    }

    /// Returns the numbers of the columns that the question is about.
    pub(crate) fn columns(&self) -> &[usize] {
        let (Self::ReferenceClock(all)
        | Self::LoadAxis(all)
        | Self::Load(all)
        | Self::LoadUnit(all)) = self;
        all
    }

    /// Returns the question in few words, as it stands beside one of its columns.
    pub(crate) fn short(&self) -> &'static str {
        match self {
            Self::ReferenceClock(_) => "Is this the time of the reference?",
            Self::LoadAxis(_) | Self::Load(_) => "Is this the reference load?",
            Self::LoadUnit(_) => "Which unit?",
        }
    }

    /// Returns the answers that a press gives for one of the columns: each as its label, role and unit.
    pub(crate) fn choices(
        &self,
        column: &ColumnReport,
    ) -> Vec<(String, ColumnRole, Option<String>)> {
        let with_units = |role: ColumnRole, units: &[&str]| {
            let choice = |unit: &&str| ((*unit).to_owned(), role, Some((*unit).to_owned()));
            units.iter().map(choice).collect()
        };
        match self {
            Self::ReferenceClock(_) => {
                vec![("Yes".to_owned(), ColumnRole::TimeReference, None)]
            }
            Self::LoadAxis(_) | Self::Load(_) => match column.usual_load() {
                (axis, Some(_)) => {
                    vec![(format!("Yes, as {}", axis.symbol()), ColumnRole::Load(axis), None)]
                }
                (axis, None) => with_units(ColumnRole::Load(axis), &["N", "kgf", "g"]),
            },
            Self::LoadUnit(_) => match column.is {
                ColumnRole::Load(axis) if !axis.is_force() => {
                    with_units(column.is, &["N·m", "N·mm", "lbf·in"])
                }
                _ => with_units(column.is, &["N", "kgf", "g", "lbf"]),
            },
        }
    }

    /// Returns the shortest answer, such as `Mass=Fz kgf`, of the kind that the option `--columns` takes.
    fn answer(&self, columns: &[ColumnReport]) -> Vec<String> {
        let key = |number: usize| columns[number - 1].key(columns);
        match self {
            Self::ReferenceClock(_) => Vec::new(),
            Self::LoadAxis(numbers) | Self::Load(numbers) => {
                // A reference has mostly round values, so that it has the fewest different ones.
                let n_different = |number: &&usize| columns[**number - 1].n_different;
                let Some(&load) = numbers.iter().min_by_key(n_different) else { return Vec::new() };
                let (axis, unit) = columns[load - 1].usual_load();
                vec![format!("{}={} {}", key(load), axis.symbol(), unit.unwrap_or("N"))]
            }
            Self::LoadUnit(numbers) => {
                let of = |number: &usize| {
                    let column = &columns[*number - 1];
                    let unit = match column.is {
                        ColumnRole::Load(axis) if !axis.is_force() => "N·m",
                        _ if column.named.is_mass() => "g",
                        _ => "N",
                    };
                    format!("{}={} {unit}", key(*number), column.is)
                };
                numbers.iter().map(of).collect()
            }
        }
    }

    pub(crate) fn text(&self, columns: &[ColumnReport]) -> String {
        let names = |numbers: &[usize]| -> String {
            let name = |number: &usize| match columns.get(number - 1) {
                Some(column) if !column.named.name.is_empty() => column.named.name.clone(),
                _ => format!("column {number}"),
            };
            listed(&numbers.iter().map(name).collect::<Vec<_>>())
        };
        match self {
            Self::ReferenceClock(numbers) => format!(
                "These columns also increase steadily like a time: {}. If one of them is the time of the reference load, give it the role Reference clock.",
                names(numbers)
            ),
            Self::LoadAxis(numbers) => format!(
                "Which of these columns is the reference load, and on which axis: {}?",
                names(numbers)
            ),
            Self::Load(numbers) => format!(
                "Which column is the reference load? These are read as gauges: {}.",
                names(numbers)
            ),
            Self::LoadUnit(numbers) => format!(
                "Which unit does the load have in {}? The file gives none, and the values need not be N or N·m. For counts, give the counts per unit, e.g. Fx=Fx N/1000.",
                names(numbers)
            ),
        }
    }
}

/// Returns the text for `--columns` that answers these questions; `None` if none of them is about a load.
pub fn answer(questions: &[Question], columns: &[ColumnReport]) -> Option<String> {
    let all: Vec<String> = questions.iter().flat_map(|own| own.answer(columns)).collect();
    (!all.is_empty()).then(|| all.join(", "))
}

impl ColumnReport {
    /// Returns the axis that the column is if it is the only load, and its unit if that is one of a force or a moment.
    fn usual_load(&self) -> (Axis, Option<&str>) {
        let unit = self.unit.as_deref();
        match unit.filter(|unit| moment_in_newton_metres(unit).is_some()) {
            Some(unit) => (Axis::Mz, Some(unit)),
            None => (Axis::Fz, unit.filter(|unit| force_in_newtons(unit).is_some())),
        }
    }

    /// Returns the name by which `--columns` calls this column, or its number if the name is not unique or cannot be typed.
    pub(crate) fn key(&self, columns: &[Self]) -> String {
        let name = &self.named.name;
        let n_alike = columns.iter().filter(|other| other.named.name == *name).count();
        let is_plain = !name.is_empty()
            && !self.header.is_empty()
            && !name.contains([',', '=', '"'])
            && !name.bytes().all(|byte| byte.is_ascii_digit());
        if n_alike == 1 && is_plain { shown(name).into_owned() } else { self.number.to_string() }
    }
}

impl fmt::Display for Question {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text(&[]))
    }
}

impl From<Question> for String {
    fn from(question: Question) -> Self {
        question.to_string()
    }
}
