//! Turns the rows of a file into recordings: converts the times, reports irregularities, and starts a new recording after
//! each long pause.

use std::collections::BTreeMap;
use std::path::Path;

use super::{
    error::at,
    map::ColumnRole,
    named_column::NamedColumn,
    plan::{Channels, Plan},
    rows::Rows,
    two_clocks::Table,
    warning::{Cause, Findings, Trouble},
};
use crate::{
    finding::Id,
    import::{
        error::{ReadError, TableError},
        timeline,
    },
    recording::{self, Axis, MOST_READINGS, Recording, Source, units::TimeUnit},
};

/// Maximum number of recordings in a file. With more recordings, the column that was chosen as time cannot hold times.
const RECORDING_LIMIT: usize = 50_000;

pub fn no_usable_row(path: &Path, plan: &Plan, rows: Rows) -> ReadError {
    let n_full_rows = rows.n_skipped - rows.findings.short_rows();
    let is_culprit = |index: &usize| n_full_rows > 0 && rows.bad_cells[*index] == n_full_rows;
    let culprits: Vec<usize> = (0..rows.bad_cells.len()).filter(is_culprit).collect();
    if let [index] = culprits[..] {
        let column = plan.column(index);
        return at(path, plan.line)(TableError::NoNumberInColumn { column });
    }
    let found = rows.findings.into_findings(path);
    match found.into_iter().find(|own| own.id == Id::RowsSkipped) {
        Some(first) => ReadError::NoUsableRow { first: Box::new(first) },
        None => at(path, plan.line)(TableError::NoRows),
    }
}

/// Converts the times of all rows to seconds. Rows that were written newest first are reversed, and this is reported. If their unit was derived from the values, this is reported.
pub fn settle_times(plan: &Plan, rows: &mut Rows) {
    if timeline::is_newest_first(&rows.times) {
        let order: Vec<usize> = (0..rows.times.len()).rev().collect();
        rows.arrange(&order);
        rows.findings.note(plan.line, Cause::NewestFirst);
    }
    let per_second = plan.per_second.unwrap_or_else(|| {
        let unit = timeline::unit_by_values(&rows.times, plan.since as f64);
        if unit != TimeUnit::Seconds {
            let cause = Cause::AssumedTimeUnit { column: plan.time(), unit };
            rows.findings.note(plan.line, cause);
        }
        unit.per_second()
    });
    if per_second != 1.0 {
        for time in &mut rows.times {
            *time /= per_second;
        }
    }
    rows.zero_secs = plan.since as f64 / per_second;
    if plan.is_time_of_day() {
        timeline::count_days(&mut rows.times);
    }
    // Division by a number below one makes the times larger, possibly too large for a floating-point number.
    if per_second < 1.0
        && let Some(row) = rows.times.iter().position(|time| !time.is_finite())
    {
        let cause = Cause::Cell {
            column: plan.time(),
            value: rows.times[row].to_string(),
            trouble: Trouble::NotFinite,
        };
        rows.note_row(row, cause);
        let is_finite: Vec<bool> = rows.times.iter().map(|time| time.is_finite()).collect();
        rows.retain(|row| is_finite[row]);
    }
}

/// Minimum mean number of rows from one turn of the load to the next, for the order of the rows to mean something.
const ROWS_TO_A_TURN: usize = 4;

/// Returns the recordings of rows without times. A table of load cases gives one recording for each load. Any other table is one
/// recording, in the order of its rows.
pub fn without_times(table: Table) -> Result<(Vec<Recording>, Findings), ReadError> {
    let rows = &table.rows;
    if !table.plan.axes.is_empty()
        && !table.plan.gauges.names.is_empty()
        && rows.times.len() <= MOST_READINGS
        && !has_order(rows, &table.plan.axes)
    {
        return Ok(load_cases(table));
    }
    let Table { path, plan, mut rows, .. } = table;
    note_constant_gauges(&plan, &mut rows);
    let n_rows = rows.times.len();
    rows.findings.note(plan.line, Cause::RowOrder { n_rows });
    if (3..=12).contains(&n_rows) && plan.gauges.names.len() == n_rows && plan.axes.is_empty() {
        rows.findings.note(plan.line, Cause::Square { n: n_rows });
    }
    rows.times = (0..rows.times.len()).map(|row| row as f64).collect();
    let cuts = timeline::Cuts::of_rows(rows.group_changes());
    check_number(&path, &plan, &rows, &cuts.starts, plan.group_column())?;
    let findings = std::mem::take(&mut rows.findings);
    let recordings = cut(&path, &plan, rows, &cuts, &numbered(cuts.starts.len()));
    Ok((recordings.into_iter().map(Recording::in_row_order).collect(), findings))
}

/// Returns an error if there are too many starts of recordings, which the values in this column give.
fn check_number(
    path: &Path,
    plan: &Plan,
    rows: &Rows,
    starts: &[usize],
    column: Option<usize>,
) -> Result<(), ReadError> {
    if starts.len() < RECORDING_LIMIT {
        return Ok(());
    }
    let (count, column) = (starts.len(), plan.column(column.unwrap_or_default()));
    Err(at(path, rows.line_of(starts[0]))(TableError::TooManyRecordings { count, column }))
}

/// Returns the ends of the names of recordings, of which this many start within a file.
fn numbered(n_starts: usize) -> Vec<String> {
    if n_starts == 0 {
        return vec![String::new()];
    }
    (0..=n_starts).map(|at| format!(" #{}", at + 1)).collect()
}

/// Maximum number of rows of a table of load cases on one axis whose loads hardly repeat.
const FEW_ROWS: usize = 200;
/// Minimum mean number of rows with the same load in a longer table of load cases on one axis.
const ROWS_OF_A_CASE: usize = 4;

/// Returns true if the order of rows without times means something: the load on a single axis goes up and down, so that the
/// order tells the branch, or it takes so many values that the table is a log.
fn has_order(rows: &Rows, axes: &[Axis]) -> bool {
    let (loads, n_rows) = (&rows.loads, rows.times.len());
    if axes.len() != 1 {
        return false;
    }
    let n_cases = recording::load_cases(loads, axes).into_iter().max().map_or(0, |last| last + 1);
    if n_rows > FEW_ROWS && n_rows < ROWS_OF_A_CASE * n_cases {
        return true;
    }
    let steps: Vec<bool> =
        loads.windows(2).filter(|pair| pair[0] != pair[1]).map(|pair| pair[1] > pair[0]).collect();
    let n_turns = steps.windows(2).filter(|pair| pair[0] != pair[1]).count();
    n_turns > 0 && steps.len() >= ROWS_TO_A_TURN * n_turns
}

/// Returns one recording without times for each load case: all rows with the same load.
fn load_cases(table: Table) -> (Vec<Recording>, Findings) {
    let Table { path, plan, mut rows, .. } = table;
    note_constant_gauges(&plan, &mut rows);
    let of = recording::load_cases(&rows.loads, &plan.axes);
    let n_cases = of.iter().max().map_or(0, |last| last + 1);
    let cause = Cause::LoadCases { n_rows: of.len(), n_cases };
    rows.findings.note(plan.line, cause);
    let mut rows_of: BTreeMap<(usize, String), Vec<usize>> = BTreeMap::new();
    for (row, case) in of.into_iter().enumerate() {
        rows_of.entry((case, rows.group_of(row).to_owned())).or_default().push(row);
    }
    let name = |(case, group): &(usize, String)| match plan.group_name(group) {
        Some(group) => format!(" case {} ({group})", case + 1),
        None => format!(" case {}", case + 1),
    };
    let names: Vec<String> = rows_of.keys().map(name).collect();
    let mut n_before = 0;
    let start = |rows: &Vec<usize>| {
        n_before += rows.len();
        n_before
    };
    let mut starts: Vec<usize> = rows_of.values().map(start).collect();
    starts.pop();
    rows.times = (0..rows.times.len()).map(|row| row as f64).collect();
    rows.arrange(&rows_of.into_values().collect::<Vec<_>>().concat());
    let findings = std::mem::take(&mut rows.findings);
    let cases = cut(&path, &plan, rows, &timeline::Cuts::of_rows(starts), &names);
    (cases.into_iter().map(Recording::without_times).collect(), findings)
}

/// Reports irregularities of the rows, and starts a new recording after each time step longer than `gap_secs` (by default
/// derived from the time steps).
pub fn recordings(
    table: Table,
    gap_secs: Option<f64>,
) -> Result<(Vec<Recording>, Findings), ReadError> {
    let Table { path, plan, mut rows, .. } = table;
    note_constant_gauges(&plan, &mut rows);
    if let Some((row, [from_secs, to_secs])) = timeline::unwrap_counters(&mut rows.times, gap_secs)
    {
        rows.note_row(row, Cause::WrappedClock { from_secs, to_secs });
    }
    let mut cuts = timeline::cuts(&rows.times, gap_secs);
    let changes = rows.group_changes();
    check_number(&path, &plan, &rows, &cuts.starts, plan.time_column)?;
    check_number(&path, &plan, &rows, &changes, plan.group_column())?;
    cuts.note(&mut rows);
    cuts.starts.extend(&changes);
    cuts.starts.sort_unstable();
    cuts.starts.dedup();
    let findings = std::mem::take(&mut rows.findings);
    let mut recordings = cut(&path, &plan, rows, &cuts, &numbered(cuts.starts.len()));
    // Only a change of the group starts another run. All other starts cut one run into pieces.
    if recordings.len() > 1 {
        let starts = [0].iter().chain(&cuts.starts);
        for (recording, start) in recordings.iter_mut().zip(starts) {
            recording.run = Some(changes.partition_point(|change| change <= start));
        }
    }
    Ok((recordings, findings))
}

fn note_constant_gauges(plan: &Plan, rows: &mut Rows) {
    let n_axes = rows.loads.len() / rows.times.len().max(1);
    let rests = |axis: usize| {
        let mut loads = rows.loads[axis..].iter().step_by(n_axes);
        loads.all(|load| *load == rows.loads[axis])
    };
    // While the load rests, the gauges rest too.
    let has_resting_load = n_axes > 0 && (0..n_axes).all(rests);
    if rows.times.len() < 2 || has_resting_load {
        return;
    }
    let n_gauges = plan.gauges.names.len();
    for (gauge, column) in plan.with_role(ColumnRole::Gauge).enumerate() {
        let value = rows.gauges[gauge];
        let mut values = rows.gauges[gauge..].iter().step_by(n_gauges);
        if values.all(|other| *other == value) {
            let column = NamedColumn::new(column, &plan.gauges.names[gauge]);
            rows.findings.note(plan.line, Cause::ConstantGauge { column, value });
        }
    }
}

/// Cuts the rows into recordings, whose names end as in `names`.
fn cut(
    path: &Path,
    plan: &Plan,
    mut rows: Rows,
    cuts: &timeline::Cuts,
    names: &[String],
) -> Vec<Recording> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut held = held_by_part(plan, &rows, &cuts.starts);
    let starts = [&[0][..], &cuts.starts].concat();
    let part = |(at, start): (usize, &usize)| {
        let [times, gauges, auxiliary, loads, channels, _] = rows.lists().map(|(width, values)| {
            let mut part = match start {
                0 => std::mem::take(values),
                _ => values.split_off(start * width),
            };
            values.shrink_to_fit();
            part.shrink_to_fit();
            part
        });
        let source = Source::File(path.to_owned());
        let Channels { names: of_gauges, units } = plan.gauges.clone();
        let axes = plan.axes.clone();
        let name = format!("{stem}{}", names[at]);
        let mut part = Recording::new(name, source, times, of_gauges, gauges, axes, loads)
            .expect("all rows have finite numbers and equal length, and the times of a recording never go back")
            .with_gauge_units(units)
            .with_auxiliary(plan.auxiliary.names.clone(), plan.auxiliary.units.clone(), auxiliary)
            .expect("missing values were replaced by the last ones, so each row has a number for each auxiliary channel")
            .with_others(plan.others.names.clone(), plan.others.units.clone(), channels)
            .expect("each row has a value for each channel");
        part.auxiliary.held = std::mem::take(&mut held[at]);
        part.group = plan.group_name(rows.group_of(*start));
        part.columns = columns(plan);
        (part.gap_secs, part.zero_secs) = (Some(cuts.gap_secs), rows.zero_secs);
        part
    };
    // The recordings are cut off from the end, the last one first, so that at most one recording is in memory twice.
    let mut recordings: Vec<Recording> = starts.iter().enumerate().rev().map(part).collect();
    recordings.reverse();
    recordings
}

/// Returns the index of the column of each channel: gauges, loads, auxiliary channels, channels that are only shown.
fn columns(plan: &Plan) -> Vec<usize> {
    let places = plan.columns.iter().enumerate().filter_map(|(at, column)| {
        let place = match column.is {
            ColumnRole::Gauge => (0, at),
            ColumnRole::Load(_) => (1, column.slot),
            ColumnRole::Auxiliary => (2, at),
            ColumnRole::Channel => (3, at),
            _ => return None,
        };
        Some((place, at))
    });
    let mut places: Vec<_> = places.collect();
    places.sort_unstable();
    places.into_iter().map(|(_, at)| at).collect()
}

/// Returns, for each recording and auxiliary channel, the time intervals (s) in which the channel's last measured value is
/// too old to be held.
fn held_by_part(plan: &Plan, rows: &Rows, starts: &[usize]) -> Vec<Vec<Vec<(f64, f64)>>> {
    let n_channels = plan.auxiliary.names.len();
    let mut parts = vec![vec![Vec::new(); n_channels]; starts.len() + 1];
    for held in &rows.held {
        let mut from = held.rows.start;
        while from < held.rows.end {
            let part = starts.partition_point(|start| *start <= from);
            let to = starts.get(part).map_or(held.rows.end, |end| held.rows.end.min(*end));
            parts[part][held.channel].push((rows.times[from], rows.times[to - 1]));
            from = to;
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::super::tests::TestFile;
    use super::*;
    use crate::finding::Finding;
    use crate::import::named_column::NamedColumn;

    fn load(text: &str) -> (Vec<Recording>, Vec<Finding>) {
        let loaded = TestFile::new(text).read().unwrap();
        (loaded.recordings, loaded.warnings)
    }

    #[test]
    fn seconds_stay_exactly_as_written() {
        let (recordings, findings) = load("time,S1\n0.1,1\n0.30000000000000004,2\n");
        assert_eq!(recordings[0].times(), [0.1, 0.300_000_000_000_000_04]);
        assert!(findings.is_empty(), "{findings:?}");
    }

    #[test]
    fn an_assumed_time_unit_is_reported() {
        let (recordings, findings) = load("S1,time\n1,0\n2,3\n4,6\n");
        assert_eq!(recordings[0].times(), [0.0, 0.003, 0.006]);
        let expected = Cause::AssumedTimeUnit {
            column: NamedColumn::new(1, "time"),
            unit: TimeUnit::Milliseconds,
        };
        assert_eq!(findings, [expected]);
        let (recordings, findings) = load("S1,time_s\n1,0\n2,3\n4,6\n");
        assert_eq!(recordings[0].times(), [0.0, 3.0, 6.0]);
        assert!(findings.is_empty(), "{findings:?}");
    }

    /// Without a date, days are counted from the first sample.
    #[test]
    fn a_time_of_day_goes_on_past_midnight() {
        let rows = ["23:59:59.5,1", "0:00:00,2", "00:00:00.5,4"];
        let (recordings, findings) = load(&format!("time,S1\n{}\n", rows.join("\n")));
        assert_eq!(recordings.len(), 1);
        assert_eq!(recordings[0].times(), [86_399.5, 86_400.0, 86_400.5]);
        assert!(findings.is_empty(), "{findings:?}");
        let days = ["2025-03-04", "2025-03-05", "2025-03-05"];
        let dated: Vec<String> =
            days.iter().zip(rows).map(|(d, row)| format!("{d},{row}")).collect();
        let (recordings, _) = load(&format!("date,time,S1\n{}\n", dated.join("\n")));
        let times = recordings[0].times();
        assert_eq!([times[1] - times[0], times[2] - times[1]], [0.5, 0.5]);
    }

    #[test]
    fn a_constant_gauge_is_reported_and_kept() {
        let (recordings, findings) = load("S1,S2,t,S3\n7,1,0,2\n7,2,0.1,2\n");
        assert_eq!(recordings[0].n_gauges(), 3);
        let constant = |index, name: &str, value| Cause::ConstantGauge {
            column: NamedColumn::new(index, name),
            value,
        };
        let expected = [constant(0, "S1", 7.0), constant(3, "S3", 2.0)];
        assert_eq!(findings, expected);
        assert!(load("t,S1\n0,1\n").1.is_empty());
        let of_loads = |last: u8| load(&format!("t,S1,Fx,Fz\n0,1,5,0\n0.1,1,5,{last}\n")).1.len();
        assert_eq!([of_loads(0), of_loads(3)], [0, 1], "the load rests, or moves");
    }

    #[test]
    fn a_pause_or_a_step_back_starts_a_recording() {
        let text = "t,S1,Fx\n0,1,1\n0.1,2,2\n0.2,3,3\n9,4,4\n\n9.1,5,5\n0,6,6\n0,7,7\n";
        let loaded = TestFile::new(text).read().unwrap();
        let names: Vec<_> = loaded.recordings.iter().map(Recording::name).collect();
        assert_eq!(names, ["run #1", "run #2", "run #3"]);
        assert_eq!(loaded.recordings[1].times(), [9.0, 9.1]);
        assert_eq!(loaded.recordings[2].loads(), [6.0, 7.0]);
        let [cut, repeat] = &loaded.warnings[..] else {
            panic!("two warnings: {:?}", loaded.warnings)
        };
        let lines = |own: &Finding| {
            let place = own.place.as_ref().unwrap();
            (place.first_line, place.last_line, place.count)
        };
        assert_eq!(lines(cut), (5, 8, 2));
        let expected = Cause::NewRecording { from_secs: 0.2, to_secs: 9.0 };
        assert_eq!(*cut, expected);
        assert_eq!(lines(repeat), (9, 9, 1));
        assert_eq!(*repeat, Cause::RepeatedTime { time_secs: 0.0 });
    }

    /// Each change of the value in the group column starts a recording. A row with an empty cell is skipped.
    #[test]
    fn a_group_column_starts_recordings_and_names_their_groups() {
        let text = "t,S1,group\n0,1,a\n0.1,2,a\n0.2,3,b\n0.3,4,\n0.4,5,b\n0.5,6,a\n9,7,a\n";
        let loaded = TestFile::new(text).read().unwrap();
        let found: Vec<_> =
            loaded.recordings.iter().map(|own| (own.group().unwrap(), own.gauges())).collect();
        let expected: [(&str, &[f64]); 4] = [
            ("group a", &[1.0, 2.0]),
            ("group b", &[3.0, 5.0]),
            ("group a", &[6.0]),
            ("group a", &[7.0]),
        ];
        assert_eq!(found, expected);
        let skipped = Cause::Cell {
            column: NamedColumn::new(2, "group"),
            value: String::new(),
            trouble: Trouble::Empty,
        };
        assert!(loaded.warnings.iter().any(|own| *own == skipped), "{:?}", loaded.warnings);
    }

    #[test]
    fn load_cases_of_two_groups_are_separate() {
        let text = "S1,Fz,group\n1,5,1\n2,0,1\n3,5,2\n4,5,2\n";
        let found: Vec<(String, usize)> =
            load(text).0.iter().map(|own| (own.name().to_owned(), own.n_samples())).collect();
        let expected =
            [("run case 1 (group 1)", 1), ("run case 1 (group 2)", 2), ("run case 2 (group 1)", 1)];
        assert_eq!(found, expected.map(|(name, n)| (name.to_owned(), n)));
    }

    #[test]
    fn thousands_of_cuts_are_one_warning() {
        let mut text = String::from("t,S1\n");
        for row in 0..20_000 {
            writeln!(text, "{},{row}", row % 2).unwrap();
        }
        let (recordings, findings) = load(&text.replace("t,", "t_s,"));
        assert_eq!((recordings.len(), findings.len()), (10_000, 1));
        assert_eq!(recordings[4_321].gauges(), [8_642.0, 8_643.0]);
        assert_eq!(recordings[9_999].name(), "run #10000");
    }

    #[test]
    fn rows_written_newest_first_are_one_recording() {
        let rows = (0..60).map(|row| format!("{},{row}\n", 100 - row));
        let text = format!("t_s,S1\n{}", rows.collect::<String>());
        let (recordings, findings) = load(&text);
        assert_eq!(recordings.len(), 1);
        assert!(recordings[0].times().is_sorted());
        assert_eq!((recordings[0].gauges()[0], recordings[0].run), (59.0, None));
        assert_eq!(findings, [Cause::NewestFirst]);
        // After a late row, the rows start anew. Both recordings are pieces of one run.
        let (recordings, _) = load(&(text + "70,60\n"));
        let found: Vec<_> = recordings.iter().map(|own| (own.n_samples(), own.run)).collect();
        assert_eq!(found, [(1, Some(0)), (60, Some(0))]);
    }

    #[test]
    fn a_time_column_that_often_goes_back_is_an_error() {
        let mut text = String::from("# count\nt,S1\n");
        for row in 0..120_000 {
            writeln!(text, "{},{row}", row % 2).unwrap();
        }
        let error = TestFile::new(text).read().unwrap_err();
        assert!(matches!(
            error,
            ReadError::Table {
                line: 5,
                source: TableError::TooManyRecordings { count: 59_999, .. },
                ..
            }
        ));
    }
}
