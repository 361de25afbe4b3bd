//! Rows that arrive live, from a pipe or from a file that another program writes.
//!
//! Guarantees: the columns are determined once, by the code that reads whole files. After that, only the cells of each line
//! are parsed. A line that is not a row is reported and changes nothing. In JSON lines, the keys are the names of the
//! columns.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::device_rows::{DeviceRows, GUESSED_BY};
pub use super::device_rows::{LiveSource, RowForm};
use super::error::{at, of_file};
use super::load::{BLOCK_BYTES, by_names};
use super::plan::{Plan, Side, TimeScale};
use super::rows::Rows;
use super::warning::Cause;
use crate::formats::text::ArrivingLines;
use crate::formats::{self, FileError, LineKeys, Opened, Part};
use crate::import::error::ReadError;
use crate::import::error::TableError;
use crate::import::timeline;
use crate::progress::Progress;
use crate::recording::gap::{median_step, pause_by_step};
use crate::recording::units::TimeUnit;
use crate::recording::{Axis, places};

/// Maximum number of lines at the start of a live source in which the columns must be found.
const MAX_HEAD_LINES: usize = 200;
/// Number of rows, at the start of a live source, from whose median time step the unit of time is derived.
const ROWS_FOR_A_STEP: usize = 5;

/// Columns of a live source, and the rows in the lines by which the columns were found.
pub type Begun = (LiveTable, Vec<LiveRow>);

/// Line of a live source that cannot be used, with the reason and the time of the row if it is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejected {
    pub time: Option<f64>,
    pub why: String,
}

/// First lines of a source, collected until the columns of the source are known.
#[derive(Debug)]
pub struct LiveHead {
    lines: Vec<String>,
    /// Time (s) between `start` and the arrival of each line.
    arrived_secs: Vec<f64>,
    start: Instant,
}

impl Default for LiveHead {
    fn default() -> Self {
        Self { lines: Vec::new(), arrived_secs: Vec::new(), start: Instant::now() }
    }
}

impl LiveHead {
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// Adds the next line, and returns the table once its columns are known. After an error, no further lines may be added.
    pub fn push(
        &mut self,
        line: String,
        source: LiveSource<'_>,
    ) -> Result<Option<Begun>, ReadError> {
        self.lines.push(line);
        self.arrived_secs.push(self.start.elapsed().as_secs_f64());
        let begun = match source.form {
            None | Some(RowForm::Table) => LiveTable::begin(&self.lines, source),
            _ => Ok(None),
        };
        match begun {
            Ok(None) if source.form.is_none() && self.lines.len() < GUESSED_BY => Ok(None),
            Ok(None) => self.of_device(source, false),
            begun => begun,
        }
    }

    /// Returns the table of the lines so far, after the source has ended.
    pub fn end(&self, source: LiveSource<'_>) -> Result<Begun, ReadError> {
        match self.of_device(source, true)? {
            Some(begun) => Ok(begun),
            None => LiveTable::of_all(&self.lines, source),
        }
    }

    fn of_device(&self, source: LiveSource<'_>, is_all: bool) -> Result<Option<Begun>, ReadError> {
        let n_needed = source.gauges.len() + source.auxiliary.len();
        let form = match (source.form, source.map) {
            (None, None) => RowForm::guess(&self.lines, n_needed),
            (form, _) => form,
        };
        let Some(form) = form.filter(|form| *form != RowForm::Table && n_needed > 0) else {
            return Ok(None);
        };
        let device = DeviceRows::new(form, &self.lines, source);
        let (mut device, map) = match device {
            Err(_) if !is_all && self.lines.len() < GUESSED_BY => return Ok(None),
            device => device.map_err(at(source.path, 1))?,
        };
        let lines = self.lines.iter().zip(&self.arrived_secs);
        let rows: Vec<String> =
            lines.filter_map(|(line, arrived)| device.line(line, *arrived)).collect();
        let table_source = LiveSource { map: map.as_ref(), ..source };
        let begun = match is_all || !rows.is_empty() && self.lines.len() >= GUESSED_BY {
            true => Some(LiveTable::of_all(&rows, table_source)?),
            false => LiveTable::begin(&rows, table_source)?,
        };
        Ok(begun.map(|(mut table, rows)| {
            table.device = Some((device, self.start));
            (table, rows)
        }))
    }
}

/// One row of a live source. Its values are in the order of the channels in [`LiveTable`].
#[derive(Clone, Debug, Default, PartialEq)]
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
#[derive(Clone, Debug, PartialEq)]
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
    /// Converter of the rows that a device prints, and the moment from which times of arrival are counted. `None` for a table
    /// with its own times.
    device: Option<(DeviceRows, Instant)>,
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
        &self.plan.gauge_names
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
        &self.plan.auxiliary_names
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
        let (device, _) = self.device.as_ref()?;
        Some(format!(
            "the rows of the device are {}; the times come from {}",
            device.form.words(),
            device.clock
        ))
    }

    /// Finds the columns of the table in the first lines. Returns `None` if more lines are needed.
    pub fn begin(lines: &[String], source: LiveSource<'_>) -> Result<Option<Begun>, ReadError> {
        let begun = Self::begun(lines, source, ROWS_FOR_A_STEP);
        match begun {
            Err(ReadError::Table { source: TableError::NoTimeUnit { .. }, .. }) => begun,
            Err(_) if lines.len() < MAX_HEAD_LINES => Ok(None),
            begun => begun,
        }
    }

    /// Finds the columns as [`begin`](Self::begin) does, when the source has ended, so that no further lines follow.
    pub fn of_all(lines: &[String], source: LiveSource<'_>) -> Result<Begun, ReadError> {
        Ok(Self::begun(lines, source, 0)?.expect("all rows are available"))
    }

    /// Finds the columns of the table. Returns `None` if the unit of time must be derived from the time step, and there are
    /// fewer than `n_needed` rows.
    fn begun(
        lines: &[String],
        source: LiveSource<'_>,
        n_needed: usize,
    ) -> Result<Option<Begun>, ReadError> {
        let (plan, rows, keys) = Self::of_first(lines, source)?;
        let is_enough = rows.times.len() >= n_needed || lines.len() >= MAX_HEAD_LINES;
        let assumed_unit = match (plan.time_scale, source.step_secs) {
            (TimeScale::ByValues, Some(_)) if !is_enough => return Ok(None),
            (TimeScale::ByValues, Some(secs)) => {
                by_step_of(&rows.times, secs, &plan).map_err(at(source.path, plan.line))?
            }
            _ => None,
        };
        let by_values = || timeline::unit_by_values(&rows.times, 0.0);
        let mut table = Self {
            per_second: match plan.time_scale {
                TimeScale::PerSecond(per_second) => per_second,
                TimeScale::ByValues => assumed_unit.unwrap_or_else(by_values).per_second(),
            },
            assumed_unit,
            held: vec![Newest::NONE; plan.auxiliary_names.len()],
            plan,
            keys,
            n_rows: 0.0,
            device: None,
        };
        let rows = table.rows(rows);
        Ok(Some((table, rows)))
    }

    fn of_first(
        lines: &[String],
        source: LiveSource<'_>,
    ) -> Result<(Plan, Rows, Option<LineKeys>), ReadError> {
        let name = source.path;
        let progress = Progress::default();
        let (opened, keys) = match Opened::of_json_lines(lines) {
            Some((opened, keys)) => (opened, Some(keys)),
            None => (opened(lines, &progress).map_err(of_file(name))?, None),
        };
        let map = match source.map {
            Some(map) => map.clone(),
            None => by_names(name, &opened)?.0,
        };
        let head = opened.head(&map.table.text);
        let head = head.ok_or_else(|| ReadError::NoHeader { path: name.to_owned() })?;
        // If the reference has another clock, only the gauges are read, because a reference value in the same row belongs to
        // another time.
        let plan = Plan::new(&map.table, &head, Side::of_gauges(&map), None, false);
        let plan = plan.map_err(at(name, head.line))?;
        let rows = Rows::read(opened, &head, &plan, &progress).map_err(of_file(name))?;
        if rows.times.is_empty() {
            return Err(at(name, plan.line)(TableError::NoRows));
        }
        Ok((plan, rows, keys))
    }

    /// Reads one line. Returns `None` if more lines belong to the same row.
    pub fn row(&mut self, line: &str) -> Result<Option<LiveRow>, Rejected> {
        let Some((device, start)) = &mut self.device else {
            return self.table_row(line).map(Some);
        };
        let translated = device.line(line, start.elapsed().as_secs_f64());
        let row = translated.map(|line| self.table_row(&line)).transpose();
        row.map_err(|own| {
            let missing = self.device.as_ref().and_then(|(device, _)| device.missing(line));
            Rejected { why: missing.unwrap_or(own.why), ..own }
        })
    }

    fn table_row(&mut self, line: &str) -> Result<LiveRow, Rejected> {
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
        let why = rows.findings.most_skipped().map(|(cause, _)| cause.clone());
        self.rows(rows).pop().ok_or_else(|| {
            let time = Rows::time_of_first(part, &self.plan, self.n_rows);
            // If the row number gives the time, a row that cannot be used is counted, too.
            self.n_rows += f64::from(time.is_some());
            let why = match why {
                Some(Cause::Cell { column, value, .. }) => format!("{} is {value:?}", column.name),
                Some(cause) => cause.to_string().trim_end_matches(". Row skipped").to_owned(),
                None => "the line is blank or a comment".to_owned(),
            };
            Rejected { time: time.map(|time| time / self.per_second), why }
        })
    }

    fn rows(&mut self, rows: Rows) -> Vec<LiveRow> {
        let (n_gauges, n_axes) = (self.plan.gauge_names.len(), self.plan.axes.len());
        let first = self.n_rows;
        self.n_rows += rows.times.len() as f64;
        let counted = self.plan.time_column.is_none();
        let times = rows.times.iter().enumerate();
        let held = &mut self.held;
        times
            .map(|(k, time)| {
                let time = if counted { first + k as f64 } else { *time } / self.per_second;
                let row = &rows.auxiliary[k * held.len()..][..held.len()];
                let known = held.iter_mut().zip(row).filter(|(_, new)| new.is_finite());
                known.for_each(|(held, new)| held.take(time, *new));
                LiveRow {
                    time,
                    gauges: rows.gauges[k * n_gauges..][..n_gauges].to_vec(),
                    auxiliary: held.iter().map(|own| own.value).collect(),
                    auxiliary_ages: held.iter().map(|own| own.age(time)).collect(),
                    loads: rows.loads[k * n_axes..][..n_axes].to_vec(),
                }
            })
            .collect()
    }
}

fn opened(lines: &[String], progress: &Progress) -> Result<Opened, FileError> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("lines");
    std::fs::write(&path, lines.join("\n") + "\n")?;
    formats::open(&path, BLOCK_BYTES, None, &[], progress)
}

/// Returns the unit in which the time step of these times is nearest to `trained_secs`, the time step of the calibration's
/// recordings. `None` if all times are equal.
fn by_step_of(
    times: &[f64],
    trained_secs: f64,
    plan: &Plan,
) -> Result<Option<TimeUnit>, TableError> {
    let unit = |step| {
        let unit = timeline::unit_by_step(step, trained_secs);
        unit.map_err(|(nearest, off)| TableError::NoTimeUnit {
            column: plan.time(),
            step,
            trained_secs,
            nearest: nearest.symbol(),
            off,
        })
    };
    median_step(times).map(unit).transpose()
}

/// Time after which a file without new lines is checked again.
const LOOK_AGAIN: Duration = Duration::from_millis(2);

/// Number of bytes of a growing file that are read at a time. The last [`TAIL_BYTES`] of them are remembered: if they change
/// in the file, the file was rewritten.
const READ_BYTES: usize = 1 << 16;
const TAIL_BYTES: usize = 256;

/// File that another program is still writing. If the file is replaced or rewritten, reading starts again at its beginning.
#[derive(Debug)]
pub struct GrowingFile {
    path: PathBuf,
    file: File,
    n_read: u64,
    tail: Vec<u8>,
    lines: ArrivingLines,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Grown {
    Line(String),
    Nothing,
    /// The file was replaced or rewritten. Its first lines follow.
    Replaced,
}

impl GrowingFile {
    pub fn open(path: &Path) -> io::Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            file: File::open(path)?,
            n_read: 0,
            tail: Vec::new(),
            lines: ArrivingLines::default(),
        })
    }

    /// Returns the next complete line. If there is none yet, waits briefly and returns [`Grown::Nothing`] or
    /// [`Grown::Replaced`].
    pub fn look(&mut self) -> io::Result<Grown> {
        if let Some(line) = self.lines.next_line() {
            return Ok(Grown::Line(line));
        }
        let mut new = Vec::new();
        let is_there = self.still_holds_its_tail()?;
        if is_there {
            let mut next = (&mut self.file).take(READ_BYTES as u64);
            next.read_to_end(&mut new)?;
        }
        if !is_there || new.is_empty() && self.is_replaced() {
            *self = Self::open(&self.path)?;
            return Ok(Grown::Replaced);
        }
        if new.is_empty() {
            std::thread::sleep(LOOK_AGAIN);
            return Ok(Grown::Nothing);
        }
        self.n_read += new.len() as u64;
        self.lines.push(&new);
        self.tail.append(&mut new);
        self.tail.drain(..self.tail.len().saturating_sub(TAIL_BYTES));
        Ok(self.lines.next_line().map_or(Grown::Nothing, Grown::Line))
    }

    /// Returns true if the last bytes that were read are unchanged, so that reading can continue after them. In a rewritten
    /// file these bytes differ, even if the file is longer.
    fn still_holds_its_tail(&mut self) -> io::Result<bool> {
        let mut again = vec![0; self.tail.len()];
        let start = self.n_read - self.tail.len() as u64;
        self.file.seek(SeekFrom::Start(start))?;
        match self.file.read_exact(&mut again) {
            Ok(()) => Ok(again == self.tail),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Returns true if another file is now at this path. If there is no file, returns false, because the file may come back.
    fn is_replaced(&self) -> bool {
        match (self.file.metadata(), std::fs::metadata(&self.path)) {
            (Ok(here), Ok(there)) => is_other(&here, &there),
            _ => false,
        }
    }
}

#[cfg(unix)]
fn is_other(here: &std::fs::Metadata, there: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (here.dev(), here.ino()) != (there.dev(), there.ino())
}

#[cfg(not(unix))]
fn is_other(here: &std::fs::Metadata, there: &std::fs::Metadata) -> bool {
    here.created().ok() != there.created().ok()
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    fn begin(lines: &[&str]) -> Option<(LiveTable, Vec<LiveRow>)> {
        let lines: Vec<String> = lines.iter().map(|line| (*line).to_owned()).collect();
        LiveTable::begin(&lines, of(None)).unwrap()
    }

    fn of(step_secs: Option<f64>) -> LiveSource<'static> {
        LiveSource {
            path: Path::new("log.csv"),
            map: None,
            step_secs,
            gauges: &[],
            auxiliary: &[],
            form: None,
            rate_hz: None,
        }
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
            let early = LiveTable::begin(&lines[..5], of(Some(0.05))).unwrap();
            assert!(early.is_none(), "four rows do not determine the unit");
            let (table, rows) = LiveTable::begin(&lines, of(Some(0.05))).unwrap().unwrap();
            assert_eq!(table.assumed_unit(), Some(unit));
            assert!((rows[4].time - 0.2).abs() < 1e-9, "{unit}: {}", rows[4].time);
        }
        let refused = LiveTable::begin(&lines(1.2), of(Some(0.05))).unwrap_err();
        let refused = refused.to_string();
        assert!(
            refused.contains(
                "log.csv, line 1: the time in column 1 (time) has no unit, and no unit fits its time steps of 1.2"
            ),
            "{refused}"
        );
        let labelled: Vec<String> = ["time [s],S1", "0,1"].map(str::to_owned).to_vec();
        let (table, _) = LiveTable::begin(&labelled, of(Some(0.05))).unwrap().unwrap();
        assert_eq!(table.assumed_unit(), None);
    }

    #[test]
    fn a_file_without_a_table_is_refused_by_its_name() {
        let lines = vec!["a b c".to_owned(); MAX_HEAD_LINES];
        let refused = LiveTable::begin(&lines, of(None)).unwrap_err().to_string();
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
        assert_eq!(table.row("30,4,5,0.001"), Ok(Some(row(0.03, [4.0, 5.0], 1.0))));
    }

    #[test]
    fn an_auxiliary_value_is_held_until_the_next_one() {
        let (mut table, rows) = begin(&["t [s],S1,T [degF]", "0,1,", "1,2,212"]).unwrap();
        assert_eq!(table.auxiliary_names(), ["T"]);
        assert!(rows[0].auxiliary[0].is_nan());
        assert!((rows[1].auxiliary[0] - 100.0).abs() < 1e-12);
        let held = table.row("2,3,").unwrap().unwrap();
        assert_eq!(held.auxiliary, rows[1].auxiliary);
        assert_eq!([rows[1].auxiliary_ages[0], held.auxiliary_ages[0]], [(0.0, 0.0), (1.0, 0.0)]);
        table.row("3,3,213").unwrap();
        assert_eq!(table.row("9,3,").unwrap().unwrap().auxiliary_ages[0], (6.0, 2.0));
    }

    #[test]
    fn json_lines_are_rows_by_their_keys() {
        let (mut table, rows) = begin(&[r#"{"time": 0.5, "gauges": [1, 2.5], "Fz": 3}"#]).unwrap();
        assert_eq!(table.gauge_names(), ["S1", "S2"]);
        let own = ["A".to_owned(), "B".to_owned()];
        assert_eq!(table.places(&own, &[]).unwrap().gauges, [0, 1]);
        assert!(table.places(&own[1..], &[]).is_err());
        assert_eq!((rows[0].time, &rows[0].gauges[..]), (0.5, &[1.0, 2.5][..]));
        let row = table.row(r#"{"Fz": 4, "time": 0.6, "gauges": [7, 8]}"#).unwrap().unwrap();
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
        for n_head in [1, 4] {
            let (mut table, mut rows) =
                LiveTable::begin(&lines[..n_head], of(None)).unwrap().unwrap();
            rows.extend(lines[n_head..].iter().map(|line| table.row(line).unwrap().unwrap()));
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

    #[test]
    fn a_growing_file_and_its_replacement_are_followed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let mut out = File::create(&path).unwrap();
        write!(out, "a\nb").unwrap();
        let mut file = GrowingFile::open(&path).unwrap();
        let mut next = || match file.look().unwrap() {
            Grown::Nothing => None,
            grown => Some(grown),
        };
        let line = |text: &str| Some(Grown::Line(text.to_owned()));
        assert_eq!(next(), line("a"));
        assert_eq!(next(), None);
        assert_eq!(next(), None);
        writeln!(out, "c").unwrap();
        assert_eq!(next(), line("bc"));
        std::fs::rename(&path, folder.path().join("log.1.csv")).unwrap();
        assert_eq!(next(), None);
        std::fs::write(&path, "d\n").unwrap();
        assert_eq!(next(), Some(Grown::Replaced));
        assert_eq!(next(), line("d"));
        std::fs::write(&path, "").unwrap();
        assert_eq!(next(), Some(Grown::Replaced));
        std::fs::write(&path, "head\n1\n").unwrap();
        assert_eq!([next(), next()], [line("head"), line("1")]);
        // The file is rewritten, and is longer than before at once.
        std::fs::write(&path, "other head\n7\n8\n").unwrap();
        assert_eq!(next(), Some(Grown::Replaced));
        assert_eq!([next(), next(), next()], ["other head", "7", "8"].map(line));
    }
}
