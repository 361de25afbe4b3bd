//! Chooses among several tables of one file: topics of a ROS recording, sheets of a workbook, groups of an archive, structs.
//!
//! Guarantees: a table that the user names is read, or the error lists the existing tables. Without a choice of the user,
//! the chosen table and its alternatives are reported.

use std::collections::HashSet;

use super::arrays::{self, Array};
use super::column_name::ColumnName;
use super::columns::{Columns, FilePart};
use super::error::FileError;

#[derive(Clone, Debug)]
pub struct Part {
    pub name: String,
    pub columns: Columns,
}

/// Arrays of one group or struct of a file. Arrays outside of any group form a group with an empty name.
#[derive(Debug, Default)]
pub struct Group {
    pub name: String,
    pub arrays: Vec<Array>,
}

pub fn check_wanted<'a>(
    wanted: &[String],
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<(), FileError> {
    match wanted.iter().find(|name| !names.clone().any(|known| known == *name)) {
        None => Ok(()),
        Some(missing) => Err(FileError::NoSuchPart {
            part: missing.clone(),
            parts: names.map(str::to_owned).collect(),
        }),
    }
}

/// Returns the tables that the user wants, joined to one. Tables whose column names differ are refused. Without a choice of
/// the user, returns the table with the most kinds of columns (time, gauges, loads), then with the most rows.
pub fn choose(parts: Vec<Part>, wanted: &[String]) -> Result<Columns, FileError> {
    check_wanted(wanted, parts.iter().map(|part| part.name.as_str()))?;
    if parts.len() <= 1 {
        return Ok(parts.into_iter().next().map_or_else(Columns::default, |part| part.columns));
    }
    let names = if wanted.is_empty() {
        let score = |part: &&Part| (n_kinds(&part.columns), part.columns.n_rows());
        // `max_by_key` returns the last of equal elements, so the order is reversed to get the first.
        parts.iter().rev().max_by_key(score).map(|part| part.name.clone()).into_iter().collect()
    } else {
        wanted.to_vec()
    };
    let is_used = |part: &Part| names.contains(&part.name);
    let listed = parts.iter().map(|part| FilePart {
        name: part.name.clone(),
        what: format!("{} rows of {} columns", part.columns.n_rows(), part.columns.columns.len()),
        is_used: is_used(part),
    });
    let listed: Vec<FilePart> = listed.collect();
    let mut used = parts.into_iter().filter(is_used);
    let mut table = used.next().expect("the tables that the user names exist");
    for next in used {
        let names = |part: &Part| -> Vec<String> {
            part.columns.columns.iter().map(|column| column.name.clone()).collect()
        };
        if names(&table) != names(&next) {
            return Err(FileError::PartsDiffer { first: table.name, second: next.name });
        }
        let n_rows = table.columns.n_rows();
        for (column, more) in table.columns.columns.iter_mut().zip(next.columns.columns) {
            // Pads a shorter column with NaN, so that its values from the next table stay in their own rows.
            column.values.resize(n_rows, f64::NAN);
            let later = (more.since - column.since) as f64;
            column.values.extend(more.values.into_iter().map(|value| value + later));
            if let (Some(texts), Some(more)) = (&mut column.texts, more.texts) {
                texts.extend(more.into_iter().map(|(row, text)| (n_rows + row, text)));
            }
        }
        table.columns.left_out.extend(next.columns.left_out);
    }
    Ok(Columns { parts: listed, is_guessed_part: wanted.is_empty(), ..table.columns })
}

/// Returns the number of different kinds (time, gauge, load) among the columns of a table.
fn n_kinds(columns: &Columns) -> usize {
    let kinds: HashSet<_> = columns
        .columns
        .iter()
        .filter_map(|column| ColumnName::parse(&column.name).kind)
        .map(|kind| std::mem::discriminant(&kind))
        .collect();
    kinds.len()
}

/// Returns the table of a file that consists of groups. Groups of equal length with at most one time column together form one
/// table. Otherwise each group is a table.
pub fn of_groups(
    mut groups: Vec<Group>,
    separator: char,
    left_out: Vec<String>,
    wanted: &[String],
) -> Result<Columns, FileError> {
    let is_table = |group: &Group| group.arrays.iter().any(|array| array.values.len() > 1);
    let tables: Vec<&Group> = groups.iter().filter(|group| is_table(group)).collect();
    let n_tables = tables.len();
    let n_rows = |group: &Group| arrays::n_rows(&group.arrays);
    let are_alike = tables.windows(2).all(|two| n_rows(two[0]) == n_rows(two[1]));
    let has_time = |group: &&&Group| group.arrays.iter().any(Array::is_time);
    let n_times = tables.iter().filter(has_time).count();
    if wanted.is_empty() && (n_tables <= 1 || (are_alike && n_times <= 1)) {
        let all = groups.into_iter().flat_map(|group| {
            let name = move |name: &str| match group.name.as_str() {
                "" => name.to_owned(),
                // The name of the only group carries no information and is left out. A struct's name stays in front of its
                // fields.
                _ if n_tables <= 1 && separator == '/' => name.to_owned(),
                group => format!("{group}{separator}{name}"),
            };
            group.arrays.into_iter().map(move |array| Array { name: name(&array.name), ..array })
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
