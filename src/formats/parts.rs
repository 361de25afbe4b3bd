//! Files with several tables: topics of a recording, sheets of a workbook, groups of an archive, structs.
//!
//! Guarantees: a table that the user names is read, or the error lists the existing ones. Otherwise the chosen table and its
//! alternatives are reported.

use super::arrays::{self, Array};
use super::column_name::{ColumnName, Kind};
use super::columns::{Column, Columns, FilePart};
use super::error::FileError;

#[derive(Clone, Debug)]
pub(super) struct Part {
    pub name: String,
    pub columns: Columns,
}

/// Arrays of one group or struct. The group of the file itself has an empty name.
#[derive(Clone, Debug, Default)]
pub(super) struct Group {
    pub name: String,
    pub arrays: Vec<Array>,
}

pub(super) fn check_wanted<'a>(
    wanted: &[String],
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<(), FileError> {
    match wanted.iter().find(|name| !names.clone().any(|own| own == *name)) {
        None => Ok(()),
        Some(missing) => Err(FileError::NoSuchPart {
            part: missing.clone(),
            parts: names.map(str::to_owned).collect(),
        }),
    }
}

/// Returns the wanted tables, joined if their column names agree. If none is named, chooses the one with the most kinds of
/// columns (time, gauges, loads), then with the most rows.
pub(super) fn choose(parts: Vec<Part>, wanted: &[String]) -> Result<Columns, FileError> {
    check_wanted(wanted, parts.iter().map(|part| part.name.as_str()))?;
    if parts.len() <= 1 {
        let only = parts.into_iter().next();
        return Ok(only.map_or_else(Columns::default, |part| part.columns));
    }
    let is_used: Vec<bool> = if wanted.is_empty() {
        let score = |part: &Part| (kinds(&part.columns), part.columns.n_rows());
        // `max_by_key` returns the last of equal elements.
        let best = (0..parts.len()).rev().max_by_key(|&at| score(&parts[at]));
        (0..parts.len()).map(|at| Some(at) == best).collect()
    } else {
        parts.iter().map(|part| wanted.contains(&part.name)).collect()
    };
    let listed = parts.iter().zip(&is_used).map(|(part, &is_used)| FilePart {
        name: part.name.clone(),
        what: format!("{} rows of {} columns", part.columns.n_rows(), part.columns.columns.len()),
        is_used,
    });
    let listed: Vec<FilePart> = listed.collect();
    let used = parts.into_iter().zip(is_used).filter(|(_, is_used)| *is_used);
    let mut used = used.map(|(part, _)| part);
    let Some(mut table) = used.next() else {
        return Ok(Columns::default());
    };
    for next in used {
        let names = |part: &Part| -> Vec<String> {
            part.columns.columns.iter().map(|column| column.name.clone()).collect()
        };
        if names(&table) != names(&next) {
            return Err(FileError::PartsDiffer { first: table.name, second: next.name });
        }
        let n_rows = table.columns.n_rows();
        for (column, more) in table.columns.columns.iter_mut().zip(next.columns.columns) {
            // Pads a shorter column, so that its next values stay in their own rows.
            column.values.resize(n_rows, f64::NAN);
            let later = (more.since - column.since) as f64;
            let more = more.values.into_iter().map(|value| value + later);
            column.values.extend(more);
        }
        table.columns.left_out.extend(next.columns.left_out);
    }
    Ok(Columns { parts: listed, is_guessed_part: wanted.is_empty(), ..table.columns })
}

fn kinds(columns: &Columns) -> usize {
    let kind = |column: &Column| ColumnName::parse(&column.name).kind;
    let has = |is_it: fn(Kind) -> bool| columns.columns.iter().filter_map(kind).any(is_it);
    usize::from(has(|kind| kind == Kind::Time))
        + usize::from(has(|kind| kind == Kind::Gauge))
        + usize::from(has(|kind| matches!(kind, Kind::Load(_))))
}

/// Returns the table of a file of groups. Groups of equal length with at most one time form one table, otherwise one each.
pub(super) fn of_groups(
    mut groups: Vec<Group>,
    separator: char,
    left_out: Vec<String>,
    wanted: &[String],
) -> Result<Columns, FileError> {
    let is_table = |group: &Group| group.arrays.iter().any(|array| array.values.len() > 1);
    let tables = || groups.iter().filter(|group| is_table(group));
    let n_tables = tables().count();
    let mut n_rows = tables().map(|group| arrays::n_rows(&group.arrays));
    let first = n_rows.next();
    let are_alike = n_rows.all(|n_rows| Some(n_rows) == first);
    let has_time = |group: &&Group| group.arrays.iter().any(Array::is_time);
    let n_times = tables().filter(has_time).count();
    if wanted.is_empty() && (n_tables <= 1 || (are_alike && n_times <= 1)) {
        let all = groups.into_iter().flat_map(|group| {
            let name = move |name: &str| match group.name.as_str() {
                "" => name.to_owned(),
                // The name of the only group carries no information. Fields of a struct keep theirs.
                _ if n_tables <= 1 && separator == '/' => name.to_owned(),
                group => format!("{group}{separator}{name}"),
            };
            let arrays = group.arrays.into_iter();
            arrays.map(move |array| Array { name: name(&array.name), ..array })
        });
        return Ok(arrays::columns(all.collect(), left_out));
    }
    groups.retain(is_table);
    let part = |group: Group| Part {
        name: match group.name.as_str() {
            "" => "(top level)".to_owned(),
            _ => group.name,
        },
        columns: arrays::columns(group.arrays, Vec::new()),
    };
    let mut columns = choose(groups.into_iter().map(part).collect(), wanted)?;
    columns.left_out.extend(left_out);
    Ok(columns)
}
