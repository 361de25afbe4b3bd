//! Changes the role of one channel of a file, as a change of its column map.

use std::path::{Path, PathBuf};

use crate::{
    import::{
        error::ReadError,
        inspect::{Inspection, Known, TableReport, inspect},
        map::{ColumnMap, ColumnRole, ColumnRule, Header, TableMap},
    },
    progress::Progress,
    recording::{Axis, Channel},
};

/// New role of a channel of a recording.
#[derive(Clone, Debug)]
pub struct ChannelRole {
    pub channel: Channel,
    /// Name of the channel. In other files with the same name, the column gets the same role.
    pub name: String,
    /// Axes of the recording's reference load.
    pub axes: Vec<Axis>,
    pub role: ColumnRole,
    /// Unit of the values; `None` for the unit in the file.
    pub unit: Option<String>,
}

/// Change of the columns of the open files.
#[derive(Clone, Debug)]
pub enum ColumnChange {
    Role(ChannelRole),
    /// Column map of one of the files. Other files with the same columns take it, too.
    Map(PathBuf, Box<ColumnMap>),
}

impl ColumnChange {
    /// Returns the changed column map of a file; `None` if the change does not concern this file. Without a `map`, the present
    /// map is the one that is proposed from the file.
    ///
    /// # Errors
    /// [`ReadError`] if the file cannot be read, or `progress` is cancelled.
    pub fn map_of(
        &self,
        path: &Path,
        map: Option<&ColumnMap>,
        progress: &Progress,
    ) -> Result<Option<ColumnMap>, ReadError> {
        let (of, changed) = match self {
            Self::Role(asked) => return with_role(path, map, asked, progress),
            Self::Map(of, changed) => (of, changed),
        };
        // A second file with the loads belongs to one recording only.
        let takes_it = path == of
            || changed.reference.is_none()
                && inspect(path, known(map), progress)?.map.table.shape == changed.table.shape;
        Ok(takes_it.then(|| (**changed).clone()))
    }
}

/// Returns the column map of a file in which the channel has its new role; `None` if the file has no such channel. Without a
/// `map`, the map is proposed from the file. If another column had the role and only one can have it, that column loses it.
///
/// # Errors
/// [`ReadError`] if the file cannot be read, or `progress` is cancelled.
fn with_role(
    path: &Path,
    map: Option<&ColumnMap>,
    asked: &ChannelRole,
    progress: &Progress,
) -> Result<Option<ColumnMap>, ReadError> {
    let Inspection { mut map, table: report, reference, .. } = inspect(path, known(map), progress)?;
    // The loads may be in a file of their own.
    let of_reference = reference.filter(|_| matches!(asked.channel, Channel::Load(_)));
    let (table, report) = match (&mut map.reference, of_reference) {
        (Some(file), Some(report)) => (&mut file.table, report),
        _ => (&mut map.table, report),
    };
    let Some(index) = place(asked, &report) else {
        return Ok(None);
    };
    give(table, &report, index, asked);
    Ok(Some(map))
}

fn known(map: Option<&ColumnMap>) -> Known {
    map.map_or(Known::Nothing, |map| Known::Map(Box::new(map.clone())))
}

/// Returns the index of the column that holds the channel.
fn place(asked: &ChannelRole, report: &TableReport) -> Option<usize> {
    let columns = || report.columns.iter();
    let nth = |role: ColumnRole, n: usize| {
        let mut of_role = columns().enumerate().filter(|(_, column)| column.is == role);
        of_role.nth(n).map(|(index, _)| index)
    };
    match asked.channel {
        Channel::Time => nth(ColumnRole::Time, 0),
        Channel::Gauge(at) => nth(ColumnRole::Gauge, at),
        Channel::Load(at) => nth(ColumnRole::Load(*asked.axes.get(at)?), 0),
        Channel::Auxiliary(at) => nth(ColumnRole::Auxiliary, at),
        Channel::Other(at) => nth(ColumnRole::Channel, at),
    }
}

fn give(table: &mut TableMap, report: &TableReport, index: usize, asked: &ChannelRole) {
    let header = Header::new(report.columns.iter().map(|column| &*column.header));
    if asked.role.is_of_one_column() {
        for at in (0..report.columns.len()).filter(|at| *at != index) {
            let rule = table.rule(&header, at);
            if rule.is == asked.role {
                table.set_rule(&header, at, ColumnRule { is: ColumnRole::Channel, ..rule });
            }
        }
    }
    // A gauge without a name keeps its number when another column becomes a gauge, or is none any more.
    let is_gauge = |at: &usize| table.rule(&header, *at).is == ColumnRole::Gauge;
    let gauges: Vec<usize> = (0..report.columns.len()).filter(is_gauge).collect();
    for (number, at) in gauges.into_iter().enumerate() {
        let rule = table.rule(&header, at);
        if rule.name.is_none() && report.columns[at].header.is_empty() {
            let name = Some(format!("S{}", number + 1));
            table.set_rule(&header, at, ColumnRule { name, ..rule });
        }
    }
    let mut rule = table.rule(&header, index);
    let is_kept = rule.is == asked.role;
    rule.is = asked.role;
    rule.unit = asked.unit.clone().or(rule.unit.filter(|_| is_kept));
    table.set_rule(&header, index, rule);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_role_of_one_column_moves_from_one_column_to_another() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        let rows: String = (0..60).map(|k| format!("{k}.5,{},{k},a,b\n", 60 - k)).collect();
        std::fs::write(&path, format!("t [s],S1,Fz [N],press,day\n{rows}")).unwrap();
        let column = |map: &ColumnMap, name: &str| {
            let header = Header::new(["t [s]", "S1", "Fz [N]", "press", "day"]);
            let at = ["t", "S1", "Fz", "press", "day"].iter().position(|own| *own == name);
            map.table.rule(&header, at.unwrap()).is
        };
        let asked = |channel, role| ChannelRole {
            channel,
            name: "x".to_owned(),
            axes: vec![Axis::Fz],
            role,
            unit: None,
        };
        let progress = Progress::default();
        let change = |map: Option<&ColumnMap>, asked: &ChannelRole| {
            with_role(&path, map, asked, &progress).unwrap().unwrap()
        };
        let group = change(None, &asked(Channel::Gauge(0), ColumnRole::Group));
        assert_eq!(column(&group, "S1"), ColumnRole::Group);
        let moved = change(Some(&group), &asked(Channel::Load(0), ColumnRole::Group));
        assert_eq!(
            [column(&moved, "S1"), column(&moved, "Fz")],
            [ColumnRole::Channel, ColumnRole::Group]
        );
    }

    /// Column 2 is no gauge any more, so column 3 would be the second of two.
    #[test]
    fn unnamed_gauges_keep_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        let rows: String =
            (0..60).map(|k| format!("{k}.5,{},{},{}\n", 60 - k, k * k, 7 * k % 11)).collect();
        std::fs::write(&path, rows).unwrap();
        let progress = Progress::default();
        let change = |map: Option<&ColumnMap>, channel, role| {
            let name = "x".to_owned();
            let asked = ChannelRole { channel, name, axes: Vec::new(), role, unit: None };
            with_role(&path, map, &asked, &progress).unwrap().unwrap()
        };
        let before = inspect(&path, Known::Nothing, &progress).unwrap().table.columns;
        let gauges = before.iter().filter(|column| column.is == ColumnRole::Gauge).count();
        assert_eq!(gauges, 3);
        let map = change(None, Channel::Gauge(1), ColumnRole::Auxiliary);
        let header = Header::new(["", "", "", ""]);
        let names: Vec<_> = (1..4).map(|at| map.table.rule(&header, at).name).collect();
        let expected = ["S1", "S2", "S3"].map(|name| Some(name.to_owned()));
        assert_eq!(names, expected);
    }
}
