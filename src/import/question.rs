//! Questions about the columns of a table whose answers change a result.

use std::fmt;

use serde::Serialize;

use crate::{
    import::{
        column_report::{ColumnReport, Reason},
        map::{ColumnMap, ColumnRole},
    },
    recording::{
        Axis, Missing,
        units::{force_in_newtons, moment_in_newton_metres},
    },
    shown::{listed, shown},
};

/// Question about the columns of a file that neither their names nor their values answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(into = "String")]
pub struct Question {
    /// What is asked about the columns.
    pub about: About,
    /// Numbers of the columns, counted from 1.
    pub columns: Vec<usize>,
}

/// What a question about columns asks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum About {
    /// Is one of these columns the time of the reference?
    ReferenceClock,
    /// Which of these columns, which look like loads or are read as gauges, is the reference, if any?
    Load,
    /// Which of these columns are the gauges? None of the columns is one.
    Gauges,
    /// Do the rows belong to several sensors, which this column names?
    Sensors,
    /// Which unit does each of these load columns have? The file gives none, and the values may be counts.
    LoadUnit,
}

impl Question {
    /// Returns the question about the gauges or the load that recordings lack, unless another one is about the load. It is
    /// asked about the columns that may be them.
    pub fn about_missing(
        missing: Option<Missing>,
        questions: &[Self],
        columns: &[ColumnReport],
    ) -> Option<Self> {
        if questions.iter().any(Self::is_about_load) {
            return None;
        }
        let about = match missing? {
            Missing::Gauges => About::Gauges,
            Missing::Load => About::Load,
        };
        let may_be = |own: &&ColumnReport| match (own.is, about) {
            (ColumnRole::Channel, About::Gauges) => {
                !own.is_unnamed_load()
                    && !own.is_counter()
                    && !own.named.has_clock_word()
                    && !own.named.is_computed(own.unit.as_deref())
            }
            (ColumnRole::Channel, _) => {
                !own.is_counter() && !own.is_other_quantity() && !own.named.has_clock_word()
            }
            (ColumnRole::Auxiliary, _) => about == About::Gauges,
            (ColumnRole::Gauge, _) => about == About::Load && own.why == Reason::Moves,
            _ => false,
        };
        let columns = columns.iter().filter(may_be).map(|own| own.number).collect();
        Some(Self { about, columns })
    }

    /// Returns true if no result that needs a load is right without an answer.
    pub fn is_about_load(&self) -> bool {
        self.about != About::ReferenceClock
    }

    /// Returns true if this column map does not answer the question.
    pub fn is_open(&self, map: &ColumnMap, columns: &[ColumnReport]) -> bool {
        let mut asked = self.columns.iter().filter_map(|number| columns.get(number - 1));
        match self.about {
            About::ReferenceClock => {
                let is_unused =
                    |own: &ColumnReport| matches!(own.is, ColumnRole::Ignore | ColumnRole::Channel);
                !map.has_two_clocks() && asked.any(is_unused)
            }
            About::Gauges => asked.all(|own| own.is != ColumnRole::Gauge),
            About::Load => {
                let mut rules = map.reference_table().columns.iter();
                let has_loads = rules.any(|rule| rule.is.is_load());
                !has_loads && map.weight.is_none() && map.reference.is_none()
            }
            About::Sensors => asked.any(|own| own.is == ColumnRole::Ignore),
            About::LoadUnit => asked.any(|own| own.is.is_load() && own.unit.is_none()),
        }
    }

    /// Returns the question in few words, as it stands beside one of its columns.
    pub(crate) fn short(&self) -> &'static str {
        match self.about {
            About::ReferenceClock => "Is this the time of the reference?",
            About::Load => "Is this the reference load?",
            About::Gauges => "Is this a gauge?",
            About::Sensors => "Are these several sensors?",
            About::LoadUnit => "Which unit?",
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
        match (self.about, column.usual_load()) {
            (About::ReferenceClock, _) => {
                vec![("Yes".to_owned(), ColumnRole::TimeReference, None)]
            }
            (About::Gauges, _) => vec![("Yes".to_owned(), ColumnRole::Gauge, None)],
            (About::Sensors, _) => vec![("No, groups".to_owned(), ColumnRole::Group, None)],
            (About::LoadUnit, _) if column.is_moment() => {
                with_units(column.is, &["N·m", "N·mm", "lbf·in"])
            }
            (About::LoadUnit, _) => with_units(column.is, &["N", "kgf", "g", "lbf"]),
            (_, (axis, Some(_))) => {
                vec![(format!("Yes, as {}", axis.symbol()), ColumnRole::Load(axis), None)]
            }
            (_, (axis, None)) => with_units(ColumnRole::Load(axis), &["N", "kgf", "g"]),
        }
    }

    /// Returns the shortest answer, such as `Mass=Fz kgf`, of the kind that the option `--columns` takes.
    fn answer(&self, columns: &[ColumnReport]) -> Vec<String> {
        let asked = self.columns.iter().map(|number| &columns[number - 1]);
        match self.about {
            About::ReferenceClock => Vec::new(),
            About::Load => {
                // A reference has mostly round values, so that it has the fewest different ones.
                let load = asked.min_by_key(|own| {
                    let is_force = own.named.name.eq_ignore_ascii_case("f");
                    let is_signal = own.named.is_signal(own.unit.as_deref());
                    (!is_force, is_signal, own.is_other_quantity(), own.n_different)
                });
                let answer = |load: &ColumnReport| {
                    let (axis, unit) = load.usual_load();
                    format!("{}={} {}", load.key(columns), axis.symbol(), unit.unwrap_or("N"))
                };
                Vec::from_iter(load.map(answer))
            }
            About::Gauges => {
                let gauge = asked.min_by_key(|own| own.is_other_quantity());
                Vec::from_iter(gauge.map(|gauge| format!("{}=gauge", gauge.key(columns))))
            }
            About::Sensors => asked.map(|own| format!("{}=group", own.key(columns))).collect(),
            About::LoadUnit => {
                let answer = |own: &ColumnReport| {
                    let unit = match (own.is_moment(), own.named.is_mass()) {
                        (true, _) => "N·m",
                        (_, true) => "g",
                        _ => "N",
                    };
                    format!("{}={} {unit}", own.key(columns), own.is)
                };
                asked.map(answer).collect()
            }
        }
    }

    pub(crate) fn text(&self, columns: &[ColumnReport]) -> String {
        let name = |number: &usize| match columns.get(number - 1) {
            Some(column) if !column.named.name.is_empty() => column.named.name.clone(),
            _ => format!("column {number}"),
        };
        let names = listed(&self.columns.iter().map(name).collect::<Vec<_>>());
        match self.about {
            About::ReferenceClock => format!(
                "These columns also increase steadily like a time: {names}. If one of them is the time of the reference load, give it the role Reference clock."
            ),
            About::Gauges | About::Load if self.columns.is_empty() => {
                let is_load = self.about == About::Load;
                let what = if is_load { "reference load" } else { "gauge" };
                format!("There is no {what}, and no other column of numbers can be one.")
            }
            About::Gauges => {
                format!(
                    "There is no gauge. Which columns are the gauges? They may be among {names}."
                )
            }
            About::Load => {
                format!(
                    "Which column is the reference load, and on which axis? It may be one of these: {names}."
                )
            }
            About::Sensors => format!(
                "Do the rows belong to several sensors, which {names} tells? Then give each sensor a file of its own. If it is one sensor, give the column the role group."
            ),
            About::LoadUnit => format!(
                "Which unit does the load have in {names}? The file gives none, and the values need not be N or N·m. For counts, give the counts per unit, e.g. Fx=Fx N/1000."
            ),
        }
    }
}

/// Returns the text for `--columns` that answers these questions; `None` if none of them is about a load, or no column can
/// answer it.
pub fn answer(questions: &[Question], columns: &[ColumnReport]) -> Option<String> {
    let all: Vec<String> = questions.iter().flat_map(|own| own.answer(columns)).collect();
    (!all.is_empty()).then(|| all.join(", "))
}

impl ColumnReport {
    fn is_moment(&self) -> bool {
        matches!(self.is, ColumnRole::Load(axis) if !axis.is_force())
    }

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
