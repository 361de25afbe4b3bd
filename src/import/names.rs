//! What the names of columns make of them. The rules look at names alone, never at who wrote the file.

use super::ReadError;
use super::warning::Finding;
use crate::formats::column_name::{ColumnName, Kind};
use crate::formats::text::layout::{Detected, Start, unbracketed};
use crate::formats::text::times::TimeForm;
use crate::formats::text::{Preamble, TextLayout};
use crate::import::map::{ColumnRole, ColumnRule, Header, Shape, TableMap};

/// What a column of days is called.
const DATES: [&str; 4] = ["date", "day", "datum", "tag"];

/// A table as its names describe it, and what they leave out.
#[derive(Clone, Debug)]
pub(super) struct Named {
    pub(super) table: TableMap,
    /// The column that each rule of the table speaks of, from 0 on.
    pub(super) indices: Vec<usize>,
    pub(super) notes: Vec<Finding>,
}

/// Makes a map from the names of a table whose first rows are `rows`.
pub(super) fn by_names(detected: &Detected, start: &Start, rows: &[Vec<&[u8]>]) -> Named {
    let names = if detected.text.header {
        &start.names
    } else {
        &detected.names_in_comment
    };
    let columns: Vec<ColumnName> = names.iter().map(|name| ColumnName::parse(name)).collect();
    let times: Vec<usize> = (0..columns.len())
        .filter(|&index| columns[index].kind == Some(Kind::Time))
        .filter(|&index| start.reference_time != Some(index))
        .collect();
    let keys = start.header();
    let mut rules: Vec<(usize, ColumnRule)> = Vec::new();
    for (index, column) in columns.iter().enumerate() {
        let is = match column.kind {
            _ if start.reference_time == Some(index) => ColumnRole::TimeReference,
            Some(Kind::Time) if times.first() == Some(&index) => ColumnRole::Time,
            Some(Kind::Gauge) => ColumnRole::Gauge,
            Some(Kind::Load(axis)) => ColumnRole::Load(axis),
            Some(Kind::Time) | None => continue,
        };
        let in_units_row = start
            .units
            .get(index)
            .map(|cell| unbracketed(cell).to_owned());
        let rule = ColumnRule {
            unit: column
                .unit
                .clone()
                .or(in_units_row.filter(|unit| !unit.is_empty())),
            name: (!detected.text.header && is == ColumnRole::Gauge).then(|| column.name.clone()),
            ..ColumnRule::new(keys.key(index), is)
        };
        rules.push((index, rule));
    }
    let mut ignored_times = times.get(1..).unwrap_or_default().to_vec();
    if detected.text.preamble == Some(Preamble::AtiNetFt) {
        name_ati_columns(&mut rules, start, &keys);
        ignored_times.clear();
    } else if let Some(&time) = times.first() {
        settle_time_form(&mut rules, &keys, names, time, rows);
    }
    let mut notes = notes(&detected.text, &rules, names, &times, &ignored_times);
    notes.extend(date_order(&rules, names, rows));
    let (indices, columns) = rules.into_iter().unzip();
    Named {
        table: TableMap {
            shape: Shape {
                columns: start.n_columns,
                names: start.names.clone(),
            },
            text: detected.text.clone(),
            sample_rate_hz: None,
            columns,
        },
        indices,
        notes,
    }
}

/// The time of a Net F/T log is its count of samples; what it calls time is when its program got to write the row.
fn name_ati_columns(rules: &mut Vec<(usize, ColumnRule)>, start: &Start, keys: &Header<'_>) {
    rules.retain(|(_, rule)| rule.is != ColumnRole::Time);
    let column = |name: &str| start.names.iter().position(|other| other.starts_with(name));
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

/// Where the time is no number, its form by its cells, and the day from its own column.
fn settle_time_form(
    rules: &mut Vec<(usize, ColumnRule)>,
    keys: &Header<'_>,
    names: &[String],
    time: usize,
    rows: &[Vec<&[u8]>],
) {
    let form = |index| form_of_column(rows, index);
    let Some(time_form) = form(time) else {
        return;
    };
    if let Some((_, rule)) = rules
        .iter_mut()
        .find(|(_, rule)| rule.is == ColumnRole::Time)
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

/// Says where day and month could be the other way round.
fn date_order(
    rules: &[(usize, ColumnRule)],
    names: &[String],
    rows: &[Vec<&[u8]>],
) -> Option<Finding> {
    let is_day = |rule: &ColumnRule| [ColumnRole::Time, ColumnRole::Date].contains(&rule.is);
    let days = rules.iter().filter(|(_, rule)| is_day(rule));
    let mut days = days.filter_map(|&(index, _)| {
        let form = form_of_column(rows, index)?;
        let cells = rows.iter().filter_map(|row| row.get(index).copied());
        let other = form.other_order(cells.filter(|cell| !cell.is_empty()))?;
        Some(Finding::AssumedDateOrder {
            column: index + 1,
            name: names.get(index).cloned().unwrap_or_default(),
            order: form.name(),
            other: other.name(),
        })
    });
    days.next()
}

/// The form of a column whose cells are dates or times of day.
pub(super) fn form_of_column(rows: &[Vec<&[u8]>], index: usize) -> Option<TimeForm> {
    let cells = rows.iter().filter_map(|row| row.get(index).copied());
    TimeForm::of_all(cells.filter(|cell| !cell.is_empty()))
}

/// What the names leave out.
fn notes(
    text: &TextLayout,
    rules: &[(usize, ColumnRule)],
    names: &[String],
    times: &[usize],
    ignored_times: &[usize],
) -> Vec<Finding> {
    let mut notes = Vec::new();
    if text.preamble.is_none() && text.skip_rows > 0 {
        notes.push(Finding::SkippedPreamble {
            n_lines: text.skip_rows,
        });
    }
    if let (Some(&used), false) = (times.first(), ignored_times.is_empty()) {
        notes.push(Finding::SeveralTimes {
            used: names[used].clone(),
            others: ignored_times
                .iter()
                .map(|&index| names[index].clone())
                .collect(),
        });
    }
    let mut is_told = vec![false; names.len()];
    for index in rules.iter().map(|(index, _)| index).chain(ignored_times) {
        is_told[*index] = true;
    }
    let ignored: Vec<String> = (0..names.len())
        .filter(|&index| !is_told[index] && !names[index].is_empty())
        .map(|index| names[index].clone())
        .collect();
    if !ignored.is_empty() {
        notes.push(Finding::IgnoredColumns { names: ignored });
    }
    notes
}

/// Whether there are no names to go by.
pub(super) fn check_named(
    path: &std::path::Path,
    detected: &Detected,
    start: &Start,
) -> Result<(), ReadError> {
    if detected.text.header || !detected.names_in_comment.is_empty() {
        return Ok(());
    }
    Err(ReadError::HeaderIsNumbers {
        path: path.to_owned(),
        line: start.line,
    })
}

#[cfg(test)]
mod tests {
    use super::super::plan::Use;
    use super::super::tests::plan_and_notes;
    use super::*;
    use crate::import::map::ColumnKey;

    #[test]
    fn the_first_time_wins_and_the_rest_is_noted() {
        let (plan, notes) = plan_and_notes("label,stamp,S1,time,,").unwrap();
        let gauge = Use::Gauge { factor: 1.0 };
        assert_eq!(plan.uses, [Use::Ignored, Use::Time, gauge, Use::Ignored]);
        let several = Finding::SeveralTimes {
            used: "stamp".into(),
            others: vec!["time".into()],
        };
        let ignored = Finding::IgnoredColumns {
            names: vec!["label".into()],
        };
        assert_eq!(notes, [several, ignored]);
    }

    /// So many that whatever grows faster than their number would not end.
    #[test]
    fn many_columns_are_understood_at_once() {
        let header = |name: &str| {
            let names = (0..20_000).map(|k| format!(",{name}{k}"));
            format!("t{}", names.collect::<String>())
        };
        let (plan, notes) = plan_and_notes(&format!("{},S1", header("x"))).unwrap();
        assert_eq!(plan.gauge_names, ["S1"]);
        let Finding::IgnoredColumns { names } = &notes[0] else {
            panic!("{notes:?}")
        };
        assert_eq!(names.len(), 20_000);
        let error = plan_and_notes(&header("ch")).unwrap_err();
        assert!(matches!(
            error,
            ReadError::TooManyGauges { count: 20_000, .. }
        ));
    }

    #[test]
    fn a_repeated_name_is_listed_by_its_number() {
        let start = Start {
            names: ["t", "x", "x", ""].map(str::to_owned).to_vec(),
            ..Start::default()
        };
        let keys = start.header();
        let keys: Vec<_> = (0..4).map(|index| keys.key(index)).collect();
        let number = ColumnKey::Number;
        assert_eq!(
            keys,
            [ColumnKey::Name("t".into()), number(2), number(3), number(4)]
        );
    }
}
