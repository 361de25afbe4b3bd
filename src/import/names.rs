//! Derives the roles of columns from their names. It does not matter which program wrote the file.

use std::collections::HashSet;
use std::path::Path;

use super::map::{
    ColumnMap, ColumnRole, ColumnRule, Header, ReferenceFile, Shape, Stamps, TableMap,
};
use super::named_column::NamedColumn;
use super::plan::AUXILIARY_LIMIT;
use super::warning::Cause;
use crate::{
    formats::{
        Cell,
        column_name::{ColumnName, Kind},
        text::{Head, Preamble, TextLayout, times::TimeForm},
    },
    recording::Axis,
};

const DATES: [&str; 4] = ["date", "day", "datum", "tag"];

#[derive(Clone, Debug)]
pub(super) struct Guess {
    /// Index and rule of each column that was given a role.
    pub rules: Vec<(usize, ColumnRule)>,
    /// Warnings about what was assumed, and about columns without a role.
    pub notes: Vec<Cause>,
    /// Indices of columns whose unit or name is that of a load, but does not say of which axis. Empty if the loads were
    /// found in columns whose axis is known.
    pub unnamed_loads: Vec<usize>,
}

impl Guess {
    pub fn table(&self, text: &TextLayout, head: &Head) -> TableMap {
        let rules = self.rules.iter();
        TableMap {
            shape: Shape { columns: head.n_columns, names: head.names.clone() },
            text: text.clone(),
            sample_rate_hz: None,
            stamps: Stamps::default(),
            columns: rules.map(|(_, rule)| rule.clone()).collect(),
        }
    }

    /// Returns the column map of the file. If gauges and loads are in separate rows, the map names the same file as the file
    /// with the reference.
    pub fn map(
        &mut self,
        text: &TextLayout,
        head: &Head,
        path: &Path,
        rows: &[Vec<Cell<'_>>],
    ) -> ColumnMap {
        let mut table = self.table(text, head);
        if !self.is_turn_by_turn(rows) {
            return ColumnMap::of_table(table);
        }
        self.notes.push(Cause::TurnByTurn);
        let is_of_gauges =
            |rule: &ColumnRule| [ColumnRole::Gauge, ColumnRole::Auxiliary].contains(&rule.is);
        let mut of_loads = table.clone();
        of_loads.columns.retain(|rule| !is_of_gauges(rule));
        table.columns.retain(|rule| !rule.is.is_load());
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        ColumnMap {
            table,
            reference: Some(ReferenceFile { file: format!("{{stem}}.{ending}"), table: of_loads }),
            ..ColumnMap::default()
        }
    }

    /// Returns true if each row has either gauges or loads, but not both, and both kinds of rows occur.
    fn is_turn_by_turn(&self, rows: &[Vec<Cell<'_>>]) -> bool {
        const FEWEST_ROWS: usize = 3;
        let columns = |is_it: fn(ColumnRole) -> bool| -> Vec<usize> {
            let own = self.rules.iter().filter(|(_, rule)| is_it(rule.is));
            own.map(|(index, _)| *index).collect()
        };
        let gauges = columns(|role| role == ColumnRole::Gauge);
        let loads = columns(ColumnRole::is_load);
        let has = |row: &Vec<Cell<'_>>, columns: &[usize]| {
            let mut cells = columns.iter().filter_map(|index| row.get(*index));
            cells.any(|cell| !cell.is_blank())
        };
        let mut counts = [0; 2];
        for row in rows {
            match (has(row, &gauges), has(row, &loads)) {
                (true, true) => return false,
                (true, false) => counts[0] += 1,
                (false, true) => counts[1] += 1,
                (false, false) => {}
            }
        }
        counts.iter().all(|count| *count >= FEWEST_ROWS)
    }

    /// Returns true if the column with this index has no role yet.
    pub fn is_free(&self, index: usize) -> bool {
        self.rules.iter().all(|(own, _)| *own != index)
    }

    pub fn has_role(&self, role: ColumnRole) -> bool {
        self.rules.iter().any(|(_, rule)| rule.is == role)
    }
}

/// Derives the roles of columns from their names in a header or a comment, and the notation of times from the first rows.
pub(super) fn by_names(text: &TextLayout, head: &Head, rows: &[Vec<Cell<'_>>]) -> Guess {
    let names = if text.header { &head.names } else { &head.names_in_comment };
    let mut columns: Vec<ColumnName> = names.iter().map(|name| ColumnName::parse(name)).collect();
    for (index, column) in columns.iter_mut().enumerate() {
        // Some files give the units in a row of their own below the header.
        let unit = column.unit.clone().or_else(|| head.unit(index));
        column.kind = column.kind.and_then(|kind| kind.with_unit(unit.as_deref()));
    }
    let (several_references, other_loads) = choose_reference(&mut columns).unzip();
    let mut times: Vec<usize> = (0..columns.len())
        .filter(|&index| columns[index].kind == Some(Kind::Time))
        .filter(|&index| head.reference_time != Some(index))
        .collect();
    let fraction = stamp_fraction(&mut times, &columns);
    let keys = Header::of(head);
    let mut rules: Vec<(usize, ColumnRule)> = Vec::new();
    let has_gauges = columns.iter().any(|column| column.kind == Some(Kind::Gauge));
    let others: &[usize] = other_loads.as_deref().unwrap_or_default();
    let mut auxiliaries: Vec<&str> = Vec::new();
    for (index, column) in columns.iter().enumerate() {
        let mut unit = column.unit.clone().or_else(|| head.unit(index));
        let is = match column.kind {
            _ if head.reference_time == Some(index) => ColumnRole::TimeReference,
            Some(Kind::Time) if times.first() == Some(&index) => ColumnRole::Time,
            Some(Kind::Time) if fraction == Some(index) => ColumnRole::TimeFraction,
            Some(Kind::Gauge) => ColumnRole::Gauge,
            Some(Kind::Load(axis)) => ColumnRole::Load(axis),
            None if column.name.eq_ignore_ascii_case("group")
                && rules.iter().all(|(_, rule)| rule.is != ColumnRole::Group) =>
            {
                ColumnRole::Group
            }
            None if has_gauges && !others.contains(&index) => {
                unit = column.auxiliary_unit(head.unit(index).as_deref());
                let is_new = !auxiliaries.contains(&&*column.name);
                if unit.is_none() || !is_new || auxiliaries.len() == AUXILIARY_LIMIT {
                    continue;
                }
                auxiliaries.push(&column.name);
                ColumnRole::Auxiliary
            }
            Some(Kind::Time) | None => continue,
        };
        let is_channel = [ColumnRole::Gauge, ColumnRole::Auxiliary].contains(&is);
        let rule = ColumnRule {
            unit: unit.filter(|unit| !unit.is_empty()),
            name: (!text.header && is_channel).then(|| column.name.clone()),
            ..ColumnRule::new(keys.key(index), is)
        };
        rules.push((index, rule));
    }
    let mut ignored_times = times.get(1..).unwrap_or_default().to_vec();
    if text.preamble == Some(Preamble::AtiNetFt) {
        name_ati_columns(&mut rules, head, &keys);
        ignored_times.clear();
    } else if let Some(&time) = times.first() {
        settle_time_form(&mut rules, &keys, names, time, rows);
    }
    let reported = [ignored_times.as_slice(), &other_loads.unwrap_or_default()];
    let mut notes = notes(text, &rules, names, &times, reported);
    let has_load = rules.iter().any(|(_, rule)| rule.is.is_load());
    let is_unnamed_load = |index: &usize| {
        let is_free = rules.iter().all(|(own, _)| own != index);
        is_free && columns[*index].is_unnamed_load(head.unit(*index).as_deref())
    };
    let unnamed_loads: Vec<usize> =
        if has_load { Vec::new() } else { (0..columns.len()).filter(is_unnamed_load).collect() };
    if !unnamed_loads.is_empty() {
        let names = unnamed_loads.iter().map(|index| names[*index].clone());
        notes.push(Cause::UnnamedLoads { names: names.collect() });
    }
    notes.extend(several_references);
    notes.extend(date_order(&rules, names, rows));
    Guess { rules, notes, unnamed_loads }
}

/// If several topics or structs of a log contain the same axis, keeps only the loads of one of them as the reference.
/// Preferred are names such as `ref`, then the larger number of axes, then the first one in the file.
fn choose_reference(columns: &mut [ColumnName]) -> Option<(Cause, Vec<usize>)> {
    const REFERENCES: [&str; 7] =
        ["ati", "ref", "reference", "referenz", "truth", "gt", "ground_truth"];
    let axis_of = |column: &ColumnName| match column.kind {
        Some(Kind::Load(axis)) => Some(axis),
        _ => None,
    };
    let mut sources: Vec<(&str, Vec<Axis>)> = Vec::new();
    for column in columns.iter() {
        if let Some(axis) = axis_of(column) {
            match sources.iter_mut().find(|(source, _)| *source == column.source) {
                Some((_, axes)) => axes.push(axis),
                None => sources.push((&column.source, vec![axis])),
            }
        }
    }
    let is_shared = |axis: &Axis| {
        let having = sources.iter().filter(|(_, axes)| axes.contains(axis));
        having.count() > 1
    };
    Axis::ALL.iter().find(|axis| is_shared(axis))?;
    let calls_itself_so =
        |source: &str| source.split(['/', '_']).any(|word| REFERENCES.contains(&word));
    let rank = |(source, axes): &&(&str, Vec<Axis>)| (calls_itself_so(source), axes.len());
    // The order is reversed, because `max_by_key` returns the last of equal elements, and the first is wanted.
    let used = sources.iter().rev().max_by_key(rank)?.0.to_owned();
    let names = |is_used: bool| -> Vec<String> {
        let loads = columns.iter().filter(|column| axis_of(column).is_some());
        let own = loads.filter(|column| (column.source == used) == is_used);
        own.map(|column| column.name.clone()).collect()
    };
    let cause = Cause::SeveralReferences { used: names(true), others: names(false) };
    let is_other = |column: &ColumnName| axis_of(column).is_some() && column.source != used;
    let others = (0..columns.len()).filter(|&index| is_other(&columns[index]));
    let others: Vec<usize> = others.collect();
    for &index in &others {
        columns[index].kind = None;
    }
    Some((cause, others))
}

/// Finds a time stamp that is divided into two columns, seconds and nanoseconds. Moves the column with the seconds to the
/// front of `times`, and returns the column with the nanoseconds.
fn stamp_fraction(times: &mut Vec<usize>, columns: &[ColumnName]) -> Option<usize> {
    let first = *times.first()?;
    let is_pair = |secs: usize, rest: usize| columns[secs].is_completed_by(&columns[rest]);
    let (secs, rest) = times.iter().copied().find_map(|other| match () {
        () if is_pair(first, other) => Some((first, other)),
        () if is_pair(other, first) => Some((other, first)),
        () => None,
    })?;
    times.retain(|&time| time != secs && time != rest);
    times.insert(0, secs);
    Some(rest)
}

/// Sets the roles of the columns in a log of ATI's Net F/T. The time is derived from the count of samples, because the column
/// "time" only tells when a row was written.
fn name_ati_columns(rules: &mut Vec<(usize, ColumnRule)>, head: &Head, keys: &Header<'_>) {
    rules.retain(|(_, rule)| rule.is != ColumnRole::Time);
    let column = |name: &str| head.names.iter().position(|other| other.starts_with(name));
    if let Some(index) = column("RDT Sequence") {
        let sequence = ColumnRule {
            unit: Some("samples".to_owned()),
            ..ColumnRule::new(keys.key(index), ColumnRole::Time)
        };
        rules.push((index, sequence));
    }
    if let Some(index) = column("Status") {
        let status = ColumnRule::new(keys.key(index), ColumnRole::Status);
        rules.push((index, status));
    }
}

/// Sets the notation of times that are not numbers, such as 10:22:01. If they are times of day and a column holds dates, also
/// gives that column the role of the date.
fn settle_time_form(
    rules: &mut Vec<(usize, ColumnRule)>,
    keys: &Header<'_>,
    names: &[String],
    time: usize,
    rows: &[Vec<Cell<'_>>],
) {
    let form = |index| form_of_column(rows, index);
    let Some(time_form) = form(time) else {
        return;
    };
    if let Some((_, rule)) = rules.iter_mut().find(|(_, rule)| rule.is == ColumnRole::Time)
        && rule.unit.is_none()
    {
        rule.unit = Some(time_form.name().to_owned());
    }
    let is_date = |name: &String| DATES.contains(&name.to_lowercase().as_str());
    if time_form == TimeForm::TimeOfDay
        && let Some(date) = names.iter().position(is_date)
        && let Some(date_form) = form(date)
    {
        let rule = ColumnRule {
            unit: Some(date_form.name().to_owned()),
            ..ColumnRule::new(keys.key(date), ColumnRole::Date)
        };
        rules.push((date, rule));
    }
}

/// Returns a warning if it is unclear whether day or month comes first in the dates.
fn date_order(
    rules: &[(usize, ColumnRule)],
    names: &[String],
    rows: &[Vec<Cell<'_>>],
) -> Option<Cause> {
    let is_day = |rule: &ColumnRule| [ColumnRole::Time, ColumnRole::Date].contains(&rule.is);
    let days = rules.iter().filter(|(_, rule)| is_day(rule));
    let mut days = days.filter_map(|&(index, _)| {
        let form = form_of_column(rows, index)?;
        let other = form.other_order(written(rows, index)?.into_iter())?;
        Some(Cause::AssumedDateOrder {
            column: NamedColumn::new(index, names.get(index).cloned().unwrap_or_default()),
            order: form.name(),
            other: other.name(),
        })
    });
    days.next()
}

fn written<'a>(rows: &[Vec<Cell<'a>>], index: usize) -> Option<Vec<&'a [u8]>> {
    let cells = rows.iter().filter_map(|row| row.get(index).copied());
    let filled = cells.filter(|cell| !cell.is_empty());
    filled.map(Cell::written).collect()
}

pub(super) fn form_of_column(rows: &[Vec<Cell<'_>>], index: usize) -> Option<TimeForm> {
    TimeForm::of_all(written(rows, index)?.into_iter())
}

/// Returns the warnings about what was assumed, and about columns without a role.
fn notes(
    text: &TextLayout,
    rules: &[(usize, ColumnRule)],
    names: &[String],
    times: &[usize],
    [ignored_times, other_loads]: [&[usize]; 2],
) -> Vec<Cause> {
    let mut notes = Vec::new();
    if text.preamble.is_none() && text.skip_rows > 0 {
        notes.push(Cause::SkippedPreamble { n_lines: text.skip_rows });
    }
    if let (Some(&used), false) = (times.first(), ignored_times.is_empty()) {
        notes.push(Cause::SeveralTimes {
            used: names[used].clone(),
            others: ignored_times.iter().map(|&index| names[index].clone()).collect(),
        });
    }
    let rules = rules.iter().map(|(index, _)| index);
    let known: HashSet<&usize> = rules.chain(ignored_times).chain(other_loads).collect();
    let ignored = (0..names.len()).filter(|at| !known.contains(at) && !names[*at].is_empty());
    let ignored: Vec<String> = ignored.map(|at| names[at].clone()).collect();
    if !ignored.is_empty() {
        notes.push(Cause::IgnoredColumns { names: ignored });
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::super::plan::Use;
    use super::super::tests::plan_and_notes;
    use super::*;
    use crate::import::error::{ReadError, TableError};
    use crate::import::map::ColumnKey;

    #[test]
    fn the_first_time_is_used_and_the_others_are_reported() {
        let (plan, notes) = plan_and_notes("label,stamp,S1,time,,").unwrap();
        let gauge = Use::Gauge { factor: 1.0 };
        assert_eq!(plan.uses, [Use::Ignored, Use::Time, gauge, Use::Ignored]);
        let several = Cause::SeveralTimes { used: "stamp".into(), others: vec!["time".into()] };
        let ignored = Cause::IgnoredColumns { names: vec!["label".into()] };
        assert_eq!(notes, [several, ignored]);
    }

    /// With this number of columns, an algorithm of quadratic cost would not end.
    #[test]
    fn many_columns_are_understood_at_once() {
        let header = |name: &str| {
            let names = (0..20_000).map(|k| format!(",{name}{k}"));
            format!("t{}", names.collect::<String>())
        };
        let (plan, notes) = plan_and_notes(&format!("{},S1", header("x"))).unwrap();
        assert_eq!(plan.gauge_names, ["S1"]);
        let Cause::IgnoredColumns { names } = &notes[0] else { panic!("{notes:?}") };
        assert_eq!(names.len(), 20_000);
        let error = plan_and_notes(&header("ch")).unwrap_err();
        assert!(matches!(
            error,
            ReadError::Table { source: TableError::TooManyGauges { count: 20_000, .. }, .. }
        ));
    }

    #[test]
    fn a_repeated_name_is_listed_by_its_number() {
        let head =
            Head { names: ["t", "x", "x", ""].map(str::to_owned).to_vec(), ..Head::default() };
        let keys = Header::of(&head);
        let keys: Vec<_> = (0..4).map(|index| keys.key(index)).collect();
        let number = ColumnKey::Number;
        assert_eq!(keys, [ColumnKey::Name("t".into()), number(2), number(3), number(4)]);
    }
}
