//! Rows that arrive live, from a pipe or from a file that another program writes.
//!
//! Guarantees: the columns are determined once, by the code that reads whole files. After that, only the cells of each line
//! are parsed. A line that is not a row is reported and changes nothing. In JSON lines, the keys are the names of the
//! columns.

mod growing;
mod head;

use std::cmp::Ordering;
use std::time::Instant;

pub use super::device_rows::{LiveSource, RowForm};
use super::{
    device_rows::{RowClock, cells, pairs_as_json, without_stamp},
    error::{at, of_file},
    map::{ColumnMap, ColumnRole, ColumnRule, Header},
    plan::{Plan, Side},
    proposal::mapped,
    rows::Rows,
    warning::Cause,
};
use crate::{
    formats::{
        LineKeys, Opened, Part,
        text::{Head, TextLayout, numbers_in},
    },
    import::{
        error::{ReadError, TableError},
        timeline,
    },
    progress::Progress,
    recording::{
        Axis,
        gap::{median_step, pause_by_step},
        places,
        units::TimeUnit,
    },
};
pub use growing::{GrowingFile, Grown};
pub use head::{Arrived, LiveHead};
use head::{TableHeader, is_named};

/// Line of a live source that cannot be used, with the reason and the time of the row if it is known.
#[derive(Debug, PartialEq)]
pub struct Rejected {
    pub time: Option<f64>,
    pub why: String,
}

/// One row of a live source. Its values are in the order of the channels in [`LiveTable`].
#[derive(Debug, Default, PartialEq)]
pub struct LiveRow {
    pub time: f64,
    pub gauges: Vec<f64>,
    /// Value of each auxiliary channel. If the row has no value for a channel, the last known value is repeated.
    pub auxiliary: Vec<f64>,
    /// For each auxiliary channel, the time (s) since its last value arrived, and the mean time (s) between its values.
    pub auxiliary_ages: Vec<(f64, f64)>,
    pub loads: Vec<f64>,
}

/// Indices of the calibration's gauges and auxiliary channels in the rows of a [`LiveTable`].
#[derive(Debug)]
pub struct Places {
    gauges: Vec<usize>,
    auxiliary: Vec<usize>,
}

impl Places {
    pub fn gauges(&self, row: &LiveRow) -> Vec<f64> {
        self.gauges.iter().map(|place| row.gauges[*place]).collect()
    }

    pub fn auxiliary(&self, row: &LiveRow) -> Vec<f64> {
        self.auxiliary.iter().map(|place| row.auxiliary[*place]).collect()
    }

    /// Returns true if an auxiliary value of the row is too old: older than `gap_secs`, and older than a usual pause between
    /// the values of its channel.
    pub fn is_held(&self, row: &LiveRow, gap_secs: f64) -> bool {
        let mut ages = self.auxiliary.iter().map(|place| row.auxiliary_ages[*place]);
        ages.any(|(age, step)| age > gap_secs.max(pause_by_step(step)))
    }
}

/// Columns of a live source, which are known after its first lines.
#[derive(Debug)]
pub struct LiveTable {
    plan: Plan,
    per_second: f64,
    assumed_unit: Option<TimeUnit>,
    /// Keys of the JSON objects, if each line is a JSON object. The keys are the names of the columns.
    keys: Option<LineKeys>,
    n_rows: f64,
    held: Vec<Newest>,
    form: RowForm,
    /// Clock of rows without a time.
    clock: RowClock,
    /// Description of the source of the times, if this is no table with its own times.
    times_from: Option<String>,
    /// True if rows of plain numbers may have further cells, which are ignored.
    may_have_more: bool,
    /// Text between the numbers of each row, if it is more than a delimiter.
    text: Option<String>,
    /// Moment from which times of arrival are counted.
    start: Instant,
    /// Names in the header; `None` without one.
    header: Option<Vec<String>>,
    /// Number of lines above the first row.
    n_above: usize,
}

/// Newest value of an auxiliary channel, and its age.
#[derive(Clone, Copy, Debug)]
struct Newest {
    /// Newest value; NaN if none has arrived.
    value: f64,
    secs: f64,
    /// Time (s) from the first to the newest value, and the number of values after the first one.
    since_first: (f64, u64),
}

impl Newest {
    const NONE: Self = Self { value: f64::NAN, secs: f64::NAN, since_first: (0.0, 0) };

    fn take(&mut self, secs: f64, value: f64) {
        let step = secs - self.secs;
        if step >= 0.0 {
            self.since_first.0 += step;
            self.since_first.1 += 1;
        }
        (self.value, self.secs) = (value, secs);
    }

    fn age(&self, secs: f64) -> (f64, f64) {
        let (all, n) = self.since_first;
        (secs - self.secs, all / n.max(1) as f64)
    }
}

impl LiveTable {
    pub fn gauge_names(&self) -> &[String] {
        &self.plan.gauges.names
    }

    /// Returns the indices of the calibration's channels in a row, or a message about missing channels. Gauges are found by
    /// name. If the names differ, but JSON lines have one list of as many gauges, the order of this list is used instead.
    pub fn places(&self, gauges: &[String], auxiliary: &[String]) -> Result<Places, String> {
        let names = self.gauge_names();
        let has_list = self.keys.as_ref().is_some_and(LineKeys::have_list);
        let is_list = has_list && names.len() == gauges.len();
        let by_name = places(gauges, names).ok();
        let found = by_name.or_else(|| is_list.then(|| (0..names.len()).collect()));
        Ok(Places {
            gauges: found.ok_or_else(|| {
                format!(
                    "the live rows have the gauges {}, but the calibration needs the gauges {}",
                    names.join(" "),
                    gauges.join(" ")
                )
            })?,
            auxiliary: places(auxiliary, self.auxiliary_names()).map_err(|missing| {
                format!("the live rows do not have the auxiliary channel {missing}, which the calibration needs")
            })?,
        })
    }

    pub fn auxiliary_names(&self) -> &[String] {
        &self.plan.auxiliary.names
    }

    pub fn axes(&self) -> &[Axis] {
        &self.plan.axes
    }

    /// Returns the unit of the times, if it was assumed because the header has none: the unit in which the time step is
    /// nearest to that of the calibration's recordings.
    pub fn assumed_unit(&self) -> Option<&'static str> {
        self.assumed_unit.map(TimeUnit::symbol)
    }

    /// Returns a description of the rows that a device prints: their form, and where their times come from. `None` for a
    /// table with its own times.
    pub fn device(&self) -> Option<String> {
        let times_from = self.times_from.as_ref()?;
        let rows = match self.form {
            RowForm::Table => "a table without a time",
            form => form.words(),
        };
        Some(format!("the rows of the device are {rows}; the times come from {times_from}"))
    }

    /// Returns the names in a line that is the header of a table with every gauge, if they differ from the present names. An
    /// empty list stands for the present header.
    pub fn new_header(&self, line: &str, source: LiveSource<'_>) -> Option<Vec<String>> {
        let header = TableHeader::of(without_stamp(line).1, source)?;
        let is_header = source.may_have_header() && header.has_gauges;
        let is_new = self.header.as_ref() != Some(&header.names);
        is_header.then(|| if is_new { header.names } else { Vec::new() })
    }

    /// Finds the columns in the first lines of a table. Without a column map, the first line is the header. Returns `None` if
    /// the unit of time must be derived from the time step, and there are fewer than `n_needed` rows.
    fn begin(
        lines: &[String],
        form: RowForm,
        source: LiveSource<'_>,
        n_needed: usize,
    ) -> Result<Option<Self>, ReadError> {
        let name = source.path;
        let progress = Progress::default();
        let (opened, keys) = match Opened::of_json_lines(lines) {
            Some((opened, keys)) => (opened, Some(keys)),
            None => {
                let text = Opened::of_bytes((lines.join("\n") + "\n").into_bytes());
                (text.map_err(of_file(name))?, None)
            }
        };
        let no_header = || ReadError::NoHeader { path: name.to_owned() };
        let text = match source.whole_map() {
            Some(map) => map.table.text.clone(),
            None => {
                let text = opened.layout().ok_or_else(no_header)?;
                TextLayout { header: true, skip_rows: 0, ..text.with_either_mark() }
            }
        };
        let head = opened.head(&text).ok_or_else(no_header)?;
        let mut map = mapped(name, &opened, source.map, Some(&text))?.map;
        if source.whole_map().is_none() {
            map = named_channels(map, &head, source);
        }
        // If the reference has another clock, only the gauges are read, because a reference value in the same row belongs to
        // another time.
        let plan = Plan::new(&map.table, &head, Side::of_gauges(&map), None);
        let plan = plan.map_err(at(name, head.line))?;
        if plan.gauges.names.is_empty() {
            return Err(at(name, head.line)(TableError::no_gauges(head.names.clone())));
        }
        let rows = Rows::read(opened, &head, &plan, &progress).map_err(of_file(name))?;
        if rows.times.is_empty() {
            return Err(at(name, plan.line)(TableError::NoRows));
        }
        let assumed_unit = match source.step_secs.filter(|_| plan.per_second.is_none()) {
            Some(_) if source.time_unit.is_some() => source.time_unit,
            Some(_) if rows.times.len() < n_needed => return Ok(None),
            Some(secs) => {
                by_step_of(&rows.times, secs, &plan, source).map_err(at(name, plan.line))?
            }
            None => None,
        };
        let by_values = || timeline::unit_by_values(&rows.times, 0.0);
        let per_second = || assumed_unit.unwrap_or_else(by_values).per_second();
        Ok(Some(Self {
            per_second: plan.per_second.unwrap_or_else(per_second),
            assumed_unit,
            held: vec![Newest::NONE; plan.auxiliary.names.len()],
            plan,
            keys,
            n_rows: 0.0,
            form,
            clock: RowClock::new(source.rate_hz),
            times_from: None,
            may_have_more: source.form.is_some(),
            text: None,
            start: Instant::now(),
            header: None,
            n_above: head.n_lines as usize,
        }))
    }

    /// Reads one line that arrives now.
    pub fn row(&mut self, line: &str) -> Result<LiveRow, Rejected> {
        self.row_at(line, self.start.elapsed().as_secs_f64())
    }

    /// Reads one line that arrived at this time (s).
    pub fn row_at(&mut self, line: &str, secs: f64) -> Result<LiveRow, Rejected> {
        // The texts in a JSON line with its own times are left as they are.
        let (stamp, row) = match self.keys {
            Some(_) if !self.plan.is_static => (None, line),
            _ => without_stamp(line),
        };
        let (numbers, text) = self.text.as_ref().map(|_| numbers_in(row)).unzip();
        let numbers = numbers.map(|places| {
            places.into_iter().map(|place| &row[place]).collect::<Vec<_>>().join(",")
        });
        let row = numbers.as_deref().unwrap_or(row);
        let other = (text != self.text)
            .then(|| "the text between its numbers differs from that of the first rows".to_owned());
        if let Some(why) = other.or_else(|| self.misfit(row)) {
            let time = self.plan.is_static.then(|| self.clock.time(stamp, secs, false));
            return Err(Rejected { time, why });
        }
        if self.form == RowForm::Pairs {
            return self.table_row(&pairs_as_json(row), stamp, secs);
        }
        self.table_row(row, stamp, secs)
    }

    /// Returns a message if a line of plain numbers has fewer values than the calibration needs, or more than the first rows
    /// had. No load can be computed from such a line.
    fn misfit(&self, row: &str) -> Option<String> {
        let needed = self.plan.columns.len();
        let n = cells(row, self.plan.text.delimiter).filter(|cell| !cell.is_empty()).count();
        match n.cmp(&needed) {
            _ if !self.form.is_numbers() => None,
            Ordering::Less => {
                Some(format!("the line has {n} of the {needed} values that the calibration needs"))
            }
            Ordering::Greater if !self.may_have_more => {
                Some(format!("the line has {n} values, but the first rows had {needed}"))
            }
            _ => None,
        }
    }

    fn table_row(
        &mut self,
        line: &str,
        stamp: Option<&str>,
        arrived_secs: f64,
    ) -> Result<LiveRow, Rejected> {
        let columns;
        let part = match &self.keys {
            Some(keys) => {
                columns = keys.row(line).ok_or_else(|| Rejected {
                    time: None,
                    why: "the line is not a JSON object".to_owned(),
                })?;
                Part::Rows(&columns, 0..1)
            }
            None => Part::Lines(line.as_bytes()),
        };
        let rows = Rows::parse(part.clone(), &self.plan);
        let of_row = rows.times.first().copied();
        let time = if self.plan.is_static {
            Some(self.clock.time(stamp, arrived_secs, of_row.is_some()))
        } else {
            let time = of_row.or_else(|| Rows::time_of_first(part, &self.plan, 0.0));
            let is_counted = self.plan.time_column.is_none();
            let time = time.map(|time| if is_counted { self.n_rows } else { time });
            // If the row number gives the time, a row that cannot be used is counted, too.
            self.n_rows += f64::from(time.is_some());
            time.map(|time| time / self.per_second)
        };
        let (Some(_), Some(secs)) = (of_row, time) else {
            let why = match rows.findings.most_skipped() {
                Some((Cause::Cell { column, value, .. }, _)) => {
                    format!("{} is {value:?}", column.name)
                }
                Some((cause, _)) => cause.to_string().trim_end_matches(". Row skipped").to_owned(),
                None => "the line is blank or a comment".to_owned(),
            };
            return Err(Rejected { time, why });
        };
        let known = self.held.iter_mut().zip(&rows.auxiliary).filter(|(_, new)| new.is_finite());
        known.for_each(|(held, new)| held.take(secs, *new));
        Ok(LiveRow {
            time: secs,
            gauges: rows.gauges,
            auxiliary: self.held.iter().map(|own| own.value).collect(),
            auxiliary_ages: self.held.iter().map(|own| own.age(secs)).collect(),
            loads: rows.loads,
        })
    }
}

/// Gives the columns that are named as channels of the calibration their roles, whatever their names usually mean.
fn named_channels(mut map: ColumnMap, head: &Head, source: LiveSource<'_>) -> ColumnMap {
    let keys = Header::of(head);
    let roles = [(source.gauges, ColumnRole::Gauge), (source.auxiliary, ColumnRole::Auxiliary)];
    for (names, is) in roles {
        for name in names {
            let column = head.names.iter().position(|cell| is_named(cell, name));
            let Some(column) = column.map(|at| keys.key(at)) else { continue };
            let rules = &mut map.table.columns;
            if !rules.iter().any(|rule| rule.column == column && rule.is == is) {
                rules.retain(|rule| rule.column != column);
                rules.push(ColumnRule { name: Some(name.clone()), ..ColumnRule::new(column, is) });
            }
        }
    }
    map
}

/// Returns the unit in which the time step of these times is nearest to `trained_secs`, the time step of the calibration's
/// recordings. `None` if all times are equal. If the form of the rows was given, the step may differ by any factor.
fn by_step_of(
    times: &[f64],
    trained_secs: f64,
    plan: &Plan,
    source: LiveSource<'_>,
) -> Result<Option<TimeUnit>, TableError> {
    let unit = |step| match timeline::unit_by_step(step, trained_secs) {
        Ok(unit) => Ok(unit),
        Err((nearest, _)) if source.form.is_some() => Ok(nearest),
        Err((nearest, off)) => Err(TableError::NoTimeUnit {
            column: plan.time(),
            step,
            trained_secs,
            nearest: nearest.symbol(),
            off,
        }),
    };
    median_step(times).map(unit).transpose()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    type Begun = (LiveTable, Vec<LiveRow>);

    /// Returns the table of the first lines, and the rows in these lines.
    fn begun(lines: &[String], source: LiveSource<'_>) -> Result<Option<Begun>, ReadError> {
        let mut head = LiveHead::default();
        let mut lines = lines.iter();
        while let Some(line) = lines.next() {
            if let Some(mut table) = head.push(line.clone(), source)? {
                let kept = head.into_kept().map(|kept| table.row_at(&kept.line, kept.secs));
                let mut rows: Vec<_> = kept.filter_map(|row| row.ok()).collect();
                rows.extend(lines.filter_map(|line| table.row(line).ok()));
                return Ok(Some((table, rows)));
            }
        }
        Ok(None)
    }

    fn begin(lines: &[&str]) -> Option<Begun> {
        let lines: Vec<String> = lines.iter().map(|line| (*line).to_owned()).collect();
        begun(&lines, of(None)).unwrap()
    }

    fn of(step_secs: Option<f64>) -> LiveSource<'static> {
        LiveSource {
            path: Path::new("log.csv"),
            map: None,
            step_secs,
            gauges: &[],
            auxiliary: &[],
            form: None,
            header: None,
            time_unit: None,
            rate_hz: None,
        }
    }

    fn gauges(n: usize) -> Vec<String> {
        (1..=n).map(|k| format!("S{k}")).collect()
    }

    /// Reads all lines of a source that ends. Returns the gauges of the calibration and the time in each row.
    fn read_all(
        lines: &[String],
        source: LiveSource<'_>,
    ) -> Result<Vec<(Vec<f64>, f64)>, ReadError> {
        let mut head = LiveHead::default();
        let mut table = None;
        let mut n = 0;
        while table.is_none() && n < lines.len() {
            table = head.push(lines[n].clone(), source)?;
            n += 1;
        }
        let mut table = table.map_or_else(|| head.end(source), Ok)?;
        let places = table.places(source.gauges, source.auxiliary).unwrap();
        let kept: Vec<String> = head.into_kept().map(|own| own.line).collect();
        let rows = kept.iter().chain(&lines[n..]).filter_map(|line| table.row(line).ok());
        Ok(rows.map(|row| (places.gauges(&row), row.time)).collect())
    }

    /// Lines of numbers, where `first` gives the cells before the gauges. The gauges of each row are 1, 2, 4.
    fn numbers_after(n: u32, first: impl Fn(u32) -> String) -> Vec<String> {
        (0..n).map(|k| format!("{}1,2,4", first(k))).collect()
    }

    /// One number more than gauges is a time only if its column is a clock: it never goes back, moves in even steps, and has
    /// a unit in which a step is near to the calibration's. The calibration is at 100 Hz.
    #[test]
    fn one_number_too_many_is_a_proven_clock_or_a_question() {
        let gauges = gauges(3);
        let source = LiveSource { gauges: &gauges, ..of(Some(0.01)) };
        let last_time = |lines: &[String]| -> Option<f64> {
            let rows = match read_all(lines, source) {
                Err(ReadError::Table { source: TableError::UnclearRows { .. }, .. }) => None,
                rows => Some(rows.unwrap()),
            }?;
            assert!(rows.iter().all(|(gauges, _)| gauges[..] == [1.0, 2.0, 4.0]), "{rows:?}");
            assert_eq!(rows.len(), lines.len());
            Some((1e9 * rows[rows.len() - 1].1).round() / 1e9)
        };
        for n in [10, 60] {
            let last = f64::from(n - 1);
            let of = |first: &dyn Fn(u32) -> String| last_time(&numbers_after(n, first));
            assert_eq!(of(&|k| format!("{},", 10 * k)), Some(0.01 * last), "ms");
            assert_eq!(of(&|k| format!("{},", k / 2)), Some(f64::from((n - 1) / 2) / 1e3), "2 kHz");
            assert_eq!(
                of(&|k| format!("{},", 20_000 * k)),
                Some((0.02 * last * 1e9).round() / 1e9)
            );
            let stamp = |k: u32| format!("{},{},", 1_700_000_000 + k / 50, 20_000_000 * (k % 50));
            assert_eq!(
                of(&stamp).map(|secs| (secs - 1.7e9 - 0.02 * last).abs() < 1e-6),
                Some(true)
            );
            assert_eq!(of(&|_| "0,".to_owned()), None, "a status");
            assert_eq!(
                of(&|k| format!("{k},")),
                None,
                "a counter, or a clock at ten times the rate"
            );
            assert_eq!(of(&|k| format!("{},", 7 * k * k % 5)), None, "a channel");
            assert_eq!(of(&|k| format!("{},", u32::from(k > 4))), None, "a switch");
            assert_eq!(of(&|_| "0,0,0,".to_owned()), None, "three numbers too many");
        }
        assert_eq!(last_time(&numbers_after(4, |k| format!("{},", 10 * k))), None, "too few rows");
        let last: Vec<String> = (0..10).map(|k| format!("1,2,4,{}", 10 * k)).collect();
        assert_eq!(last_time(&last), Some(0.09), "the clock may be in any column");
        // Under a growing load, a gauge rises nearly evenly. Its noise tells it from a clock, which has jitter only if it counts
        // from 1970.
        let ramp = |k: u32| 2.0 + 0.01 * f64::from(k) + 0.001 * f64::from(7 * k % 3);
        let rows = |first: &dyn Fn(u32) -> String| -> Vec<String> {
            (0..30).map(|k| format!("{}1,{},4", first(k), ramp(k))).collect()
        };
        let first = |lines: &[String]| read_all(lines, source).ok().map(|rows| rows[0].0.clone());
        assert_eq!(first(&rows(&|_| "0,".to_owned())), None, "a status");
        assert_eq!(first(&rows(&|k| format!("{k},"))), None, "a counter");
        let of_gauges = Some(vec![1.0, 2.0, 4.0]);
        assert_eq!(first(&rows(&|k| format!("{},", 25 * k / 2))), of_gauges, "ms");
        let now = |k: u32| format!("{},", 1.7e9 + 0.01 * f64::from(k) + 0.002 * f64::from(k % 2));
        assert_eq!(first(&rows(&now)), of_gauges, "seconds since 1970 with jitter");
        let fast = LiveSource { step_secs: Some(0.001), ..source };
        let counted = read_all(&numbers_after(12, |k| format!("{k},")), fast).unwrap();
        assert_eq!(counted[11].1, 0.011, "a counter at the rate of the calibration");
    }

    /// The header stands after up to 500 lines of a log, and above one row or many. It names the gauges in any order, with
    /// and without a time.
    #[test]
    fn a_line_with_all_gauge_names_is_the_header_wherever_it_stands() {
        let gauges = ["A0", "bridge 2", "S3"].map(str::to_owned);
        let source = LiveSource { gauges: &gauges, rate_hz: Some(100.0), ..of(Some(0.01)) };
        let log = |k: usize| format!("[  {k}.123] I (wifi): state: init, rssi: -{k}, chan {k}");
        for n_log in [0, 60, 500] {
            for n_rows in [1, 3, 30] {
                for (header, time) in
                    [("S3,t [ms],x,bridge 2,A0 [mV/V]", 10.0), ("S3,a,x,bridge 2,A0", 1.0)]
                {
                    let mut lines: Vec<String> = (0..n_log).map(log).collect();
                    lines.push(header.to_owned());
                    lines.extend(header.contains("ms").then(|| log(0)));
                    lines.extend((0..n_rows).map(|k| format!("4,{},0,2,1", time * f64::from(k))));
                    let rows = read_all(&lines, source).unwrap();
                    assert_eq!(rows.len(), n_rows as usize, "{header}");
                    assert!(rows.iter().all(|row| row.0 == [1.0, 2.0, 4.0]), "{header} {rows:?}");
                    let last = 0.01 * f64::from(n_rows - 1);
                    assert!((rows[rows.len() - 1].1 - last).abs() < 1e-9, "{header} {rows:?}");
                }
            }
        }
        let (mut table, _) =
            begun(&["t,A0,bridge 2,S3", "0,1,2,4"].map(str::to_owned), of(None)).unwrap().unwrap();
        assert!(table.row("0.01,1,2,4").is_ok());
        assert_eq!(table.new_header("t,A0,bridge 2,S3", source), Some(Vec::new()));
        assert_eq!(table.new_header("S3,bridge 2,A0", source).map(|names| names.len()), Some(3));
        assert_eq!(table.new_header("t,A0,S3", source), None);
    }

    /// With a given form, lines of another form before the rows are no error, and are kept to be reported.
    #[test]
    fn a_given_form_waits_for_its_first_row() {
        let gauges = gauges(3);
        let names = "x,S3,S2,S1,time [ms]";
        for (form, header, row) in [
            (RowForm::Numbers, None, "1,2,4,9"),
            (RowForm::TimedNumbers, None, "[20, 1, 2, 4]"),
            (RowForm::Pairs, None, "S1=1 S2=2,S3:4"),
            (RowForm::Json, None, r#"{"S1": 1, "S2": 2, "S3": 4}"#),
            (RowForm::Table, Some(names), "( 7 , 4 , 2 , 1 , 20 )"),
            (RowForm::Table, Some(names), "7 4 2 1 20"),
        ] {
            let form = Some(form);
            let source = LiveSource { gauges: &gauges, form, header, ..of(Some(0.01)) };
            let mut lines = vec!["rst:0x1 (POWERON),boot:0x13".to_owned(); 80];
            lines.extend(vec![row.to_owned(); 20]);
            let rows = read_all(&lines, source).unwrap();
            assert!(rows.len() == 20 && rows[19].0 == [1.0, 2.0, 4.0], "{form:?} {rows:?}");
            let mut head = LiveHead::default();
            for line in vec!["7 8".to_owned(); 6000] {
                assert!(head.push(line, source).unwrap().is_none(), "{form:?}");
            }
            assert!(head.end(source).is_err());
            assert!(head.into_kept().count() <= 2000);
        }
    }

    /// Each form of row that other programs print, for a calibration of three gauges at 100 Hz: read rightly, or a question.
    #[test]
    fn rows_of_other_programs_are_read_or_asked_for() {
        let gauges = gauges(3);
        let read = |row: &str, form: Option<RowForm>, header: Option<&str>| {
            let source = LiveSource { gauges: &gauges, form, header, ..of(Some(0.01)) };
            let lines: Vec<String> =
                (0..60).flat_map(|_| row.split('\n').map(str::to_owned)).collect();
            let rows = read_all(&lines, source).ok()?;
            assert!(rows.iter().all(|(gauges, _)| gauges[..] == [1.0, 2.0, 4.0]), "{row} {rows:?}");
            Some(rows.len())
        };
        for (row, n) in [
            ("( 1 , 2 , 4 )", 60),
            ("[1, 2, 4]", 60),
            ("S1=1 S2=2 S3=4", 60),
            ("S1: 1 mV/V, S3: 4 mV/V, S2: 2 mV/V", 60),
            ("S1=1mV;S2=2mV;S3=4e0mV", 60),
        ] {
            let found = read(row, None, None);
            assert!(found.is_some_and(|found| found >= n), "{row}: {found:?}");
        }
        for row in ["can0  123   [8]  11 22 33 44 55 66 77 88", "7,1,2,4", "0,0,1,2,4,9"] {
            assert_eq!(read(row, None, None), None, "{row}");
        }
    }

    /// A controller at 1 kHz counts milliseconds, and the calibration is at 100 Hz. The counter may be a clock or count rows.
    #[test]
    fn a_given_unit_of_time_decides() {
        let gauges = gauges(3);
        let source = LiveSource { gauges: &gauges, ..of(Some(0.01)) };
        let lines = numbers_after(60, |k| format!("{k},"));
        assert!(read_all(&lines, source).is_err());
        let time_unit = Some(TimeUnit::Milliseconds);
        let rows = read_all(&lines, LiveSource { time_unit, ..source }).unwrap();
        assert_eq!(rows[59].1, 0.059);
        let form = Some(RowForm::TimedNumbers);
        let rows = read_all(&lines, LiveSource { time_unit, form, ..source }).unwrap();
        assert_eq!((rows.len(), rows[59].1), (60, 0.059));
    }

    /// Times are 0, 50, 100 … as `millis()` counts, and the same times in other units. The calibration is at 20 Hz.
    #[test]
    fn a_clock_without_a_unit_gets_the_one_whose_step_is_nearest_to_the_calibration() {
        let lines = |step: f64| -> Vec<String> {
            let rows = (0..5).map(|k| format!("{},1,2", step * f64::from(k)));
            ["time,S1,S2".to_owned()].into_iter().chain(rows).collect()
        };
        for (step, unit) in [(0.05, "s"), (50.0, "ms"), (5e4, "us"), (5e7, "ns")] {
            let lines = lines(step);
            let early = begun(&lines[..5], of(Some(0.05))).unwrap();
            assert!(early.is_none(), "four rows do not determine the unit");
            let (table, rows) = begun(&lines, of(Some(0.05))).unwrap().unwrap();
            assert_eq!(table.assumed_unit(), Some(unit));
            assert!((rows[4].time - 0.2).abs() < 1e-9, "{unit}: {}", rows[4].time);
        }
        let refused = begun(&lines(1.2), of(Some(0.05))).unwrap_err();
        let refused = refused.to_string();
        assert!(
            refused.contains(
                "log.csv, line 1: the time in column 1 (time) has no unit, and no unit fits its time steps of 1.2"
            ),
            "{refused}"
        );
        let labelled: Vec<String> = ["time [s],S1", "0,1"].map(str::to_owned).to_vec();
        let (table, _) = begun(&labelled, of(Some(0.05))).unwrap().unwrap();
        assert_eq!(table.assumed_unit(), None);
    }

    #[test]
    fn a_file_without_a_table_is_refused_by_its_name() {
        let lines = vec!["a b c".to_owned(); 2000];
        let refused = begun(&lines, of(None)).unwrap_err().to_string();
        assert!(refused.starts_with("log.csv"), "{refused}");
    }

    #[test]
    fn a_head_and_a_row_make_a_table_and_broken_lines_change_nothing() {
        assert!(begin(&["# logger 3"]).is_none());
        assert!(begin(&["# logger 3", "t [ms],S1,S2,Fz"]).is_none());
        let (mut table, rows) =
            begin(&["# logger 3", "t [ms],S1,S2,Fz [kN]", "20,1,2,0.003"]).unwrap();
        assert_eq!(table.gauge_names(), ["S1", "S2"]);
        assert_eq!(table.axes(), [Axis::Fz]);
        let row = |time, gauges: [f64; 2], load| LiveRow {
            time,
            gauges: gauges.to_vec(),
            auxiliary: Vec::new(),
            auxiliary_ages: Vec::new(),
            loads: vec![load],
        };
        assert_eq!(rows, [row(0.02, [1.0, 2.0], 3.0)]);
        for broken in ["", "30,1", "x,1,2,0", "30,nan,2,0", "{}", "\u{0}"] {
            let time = broken.starts_with("30,").then_some(0.03);
            assert_eq!(table.row(broken).unwrap_err().time, time, "{broken:?}");
        }
        assert_eq!(table.row("30,x,2,0").unwrap_err().why, "S1 is \"x\"");
        let short = table.row("30,1").unwrap_err().why;
        assert_eq!(short, "the row has 2 cells, but the table has 4 columns");
        assert_eq!(table.row("30,4,5,0.001"), Ok(row(0.03, [4.0, 5.0], 1.0)));
    }

    #[test]
    fn an_auxiliary_value_is_held_until_the_next_one() {
        let (mut table, rows) = begin(&["t [s],S1,T [degF]", "0,1,", "1,2,212"]).unwrap();
        assert_eq!(table.auxiliary_names(), ["T"]);
        assert!(rows[0].auxiliary[0].is_nan());
        assert!((rows[1].auxiliary[0] - 100.0).abs() < 1e-12);
        let held = table.row("2,3,").unwrap();
        assert_eq!(held.auxiliary, rows[1].auxiliary);
        assert_eq!([rows[1].auxiliary_ages[0], held.auxiliary_ages[0]], [(0.0, 0.0), (1.0, 0.0)]);
        table.row("3,3,213").unwrap();
        assert_eq!(table.row("9,3,").unwrap().auxiliary_ages[0], (6.0, 2.0));
    }

    #[test]
    fn json_lines_are_rows_by_their_keys() {
        let (mut table, rows) = begin(&[r#"{"time": 0.5, "gauges": [1, 2.5], "Fz": 3}"#]).unwrap();
        assert_eq!(table.gauge_names(), ["S1", "S2"]);
        let own = ["A".to_owned(), "B".to_owned()];
        assert_eq!(table.places(&own, &[]).unwrap().gauges, [0, 1]);
        assert!(table.places(&own[1..], &[]).is_err());
        assert_eq!((rows[0].time, &rows[0].gauges[..]), (0.5, &[1.0, 2.5][..]));
        let row = table.row(r#"{"Fz": 4, "time": 0.6, "gauges": [7, 8]}"#).unwrap();
        assert_eq!((row.time, row.gauges, row.loads), (0.6, vec![7.0, 8.0], vec![4.0]));
        let nested =
            r#"{"header": {"stamp": {"sec": 7, "nanosec": 250000000}}, "gauges": [1], "Fz": 3}"#;
        assert_eq!(begin(&[nested]).unwrap().1[0].time, 7.25);
        for broken in ["", "[1]", r#"{"time": 1}"#, r#"{"time": 1, "gauges": [1], "Fz": 2}"#] {
            assert!(table.row(broken).is_err(), "{broken:?}");
        }
    }

    /// A calibration that was fitted on the file must find its gauges in the stream.
    #[test]
    fn json_lines_have_the_same_columns_in_a_file_and_in_a_stream() {
        let lines: Vec<String> = (0..9)
            .map(|k| {
                let time = format!(r#""stamp": {{"sec": {k}, "nanosec": 500000000}}"#);
                format!(
                    r#"{{"header": {{{time}}}, "gauges": [{k}, {}], "temp_degC": 2{k}, "Fz": {k}.5}}"#,
                    k * k
                )
            })
            .collect();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.jsonl");
        std::fs::write(&path, lines.join("\n")).unwrap();
        let file = crate::import::read(&path, None, &[], &Progress::default()).unwrap();
        let file = &file.recordings[0];
        let (mut table, mut rows) = begun(&lines, of(None)).unwrap().unwrap();
        let n_read = rows.len();
        rows.extend(lines[n_read..].iter().map(|line| table.row(line).unwrap()));
        assert_eq!(table.gauge_names(), file.gauge_names());
        assert_eq!(table.auxiliary_names(), ["temp_degC"]);
        assert_eq!(table.axes(), file.axes());
        for (k, row) in rows.iter().enumerate() {
            assert_eq!(row.time, file.times()[k]);
            assert!(row.gauges.iter().eq(file.gauges_at(k)));
            assert_eq!(row.loads, [file.loads()[k]]);
        }
    }
}
