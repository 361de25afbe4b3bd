//! Rows as measuring devices print them. The known forms are plain numbers, `name:value` pairs, and JSON without a time.
//!
//! Guarantees: times that are computed from the sample rate or taken from this computer's clock always increase. A number
//! keeps its value.

use std::ops::{Range, RangeInclusive};
use std::path::Path;

use super::map::{ColumnMap, Rest};
use crate::{
    formats::text::{Delimiter, TextLayout, cells::Cells, labelled, stamped, times::TimeForm},
    import::timeline,
    recording::{gap::median_step, units::TimeUnit},
};

/// Minimum time step (s) between two rows. It is used for rows that arrive at the same clock reading.
const LEAST_STEP_SECS: f64 = 1e-6;

/// Names of the time in rows of plain numbers, in one column or in two.
const TIME: [&str; 1] = ["time"];
const STAMP: [&str; 2] = ["stamp.sec", "stamp.nanosec"];

/// Source of live rows, with the gauges and auxiliary channels that it must supply: those of the calibration, in the
/// calibration's order.
#[derive(Clone, Copy, Debug)]
pub struct LiveSource<'a> {
    /// Name by which messages call the source: the path of a file, or a name for the pipe.
    pub path: &'a Path,
    pub map: Option<&'a ColumnMap>,
    /// Sample interval of the recordings from which the calibration was made (s).
    pub step_secs: Option<f64>,
    pub gauges: &'a [String],
    pub auxiliary: &'a [String],
    /// Form of the rows. `None` to guess the form from the first ten rows.
    pub form: Option<RowForm>,
    /// Names of the columns, if the user gave them. The rows are then those of a table with this header.
    pub header: Option<&'a str>,
    /// Unit of times whose unit is not in the rows. `None` to find the unit from the step of the times.
    pub time_unit: Option<TimeUnit>,
    /// Sample rate (Hz) from which the times of rows without a time are computed. `None` to take these times from the clock
    /// of this computer.
    pub rate_hz: Option<f64>,
}

impl<'a> LiveSource<'a> {
    pub(crate) fn channels(self) -> impl Iterator<Item = &'a String> {
        self.gauges.iter().chain(self.auxiliary)
    }

    /// Returns the column map, if it tells how lines are divided. A typed map does not, and leaves the other columns to their
    /// proposal.
    pub(crate) fn whole_map(self) -> Option<&'a ColumnMap> {
        self.map.filter(|map| map.table.has_shape() && map.table.rest == Rest::Ignored)
    }

    /// Returns true if a line of the source may be the header of a table.
    pub(crate) fn may_have_header(self) -> bool {
        let is_table = matches!(self.form, None | Some(RowForm::Table));
        is_table && self.header.is_none() && self.whole_map().is_none()
    }

    pub(crate) fn n_channels(self) -> usize {
        self.gauges.len() + self.auxiliary.len()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RowForm {
    Table,
    Numbers,
    TimedNumbers,
    Pairs,
    Json,
}

impl RowForm {
    /// All forms of rows, each with its name as a value on the command line and its description. Pairs are what Arduino's
    /// serial plotter reads.
    pub const ALL: [(Self, &'static str, &'static str); 5] = [
        (Self::Table, "table", "a table with a header, or JSON lines, both with a time"),
        (
            Self::Numbers,
            "numbers",
            "numbers without a header: the gauges, then the auxiliary channels",
        ),
        (
            Self::TimedNumbers,
            "timed-numbers",
            "numbers without a header: the time, the gauges, then the auxiliary channels",
        ),
        (Self::Pairs, "pairs", "name:value pairs"),
        (Self::Json, "json", "JSON lines without a time"),
    ];

    pub fn words(self) -> &'static str {
        let own = Self::ALL.iter().find(|(form, ..)| *form == self);
        own.map_or("", |(_, _, words)| words)
    }

    pub(crate) fn is_numbers(self) -> bool {
        matches!(self, Self::Numbers | Self::TimedNumbers)
    }

    /// Returns the form that a line has as a row with these gauges. `None` for any other line.
    pub(crate) fn of(row: &str, gauges: &[String]) -> Option<Self> {
        if row.trim_start().starts_with('{') {
            return Some(Self::Json);
        }
        if let Some(pairs) = pairs(row) {
            let is_there = |gauge: &String| pairs.iter().any(|(name, _)| name == gauge);
            return gauges.iter().all(is_there).then_some(Self::Pairs);
        }
        numbers(row).map(|_| Self::Numbers)
    }
}

/// Splits off the time stamp and the arrow that a serial terminal writes before each row, and the brackets around a row.
pub fn without_stamp(line: &str) -> (Option<&str>, &str) {
    let (stamp, row) = match stamped(line.as_bytes()) {
        Some((time, row)) => (line.get(..time), line.get(row..).unwrap_or_default()),
        None => (None, line),
    };
    let inside = |open, close| row.trim().strip_prefix(open)?.strip_suffix(close);
    let inside = inside('[', ']').or_else(|| inside('(', ')'));
    (stamp, inside.filter(|row| !row.contains(['[', ']', '(', ')'])).unwrap_or(row))
}

/// Returns the delimiter of the numbers in a line; `None` if the line is not a row of numbers.
pub fn delimiter(line: &str) -> Option<Delimiter> {
    use Delimiter::{Comma, Semicolon, Spaces, Tab};
    [Semicolon, Tab, Comma, Spaces].into_iter().find(|own| {
        let layout = TextLayout { delimiter: *own, ..TextLayout::default() };
        // A line with a single number counts as delimited by commas. With any other delimiter, a comma in the number would be
        // read as a decimal point.
        let is_cut = *own == Comma || cells(line, *own).nth(1).is_some();
        is_cut && cells(line, *own).all(|cell| layout.number(cell).is_some())
    })
}

/// Returns the cells of a line. A delimiter at the end of the line is ignored.
pub fn cells(line: &str, delimiter: Delimiter) -> impl Iterator<Item = &[u8]> {
    let line = line.trim_end().trim_end_matches(char::from(delimiter.byte()));
    Cells::new(line.as_bytes(), delimiter)
}

/// Returns the numbers of a line. `None` if a cell of the line is not a number.
pub fn numbers(line: &str) -> Option<Vec<f64>> {
    let layout = TextLayout { delimiter: delimiter(line)?, ..TextLayout::default() };
    cells(line, layout.delimiter).map(|cell| Some(layout.number(cell)?.0)).collect()
}

/// Returns the names and numbers of a line in which each number has a name.
fn pairs(line: &str) -> Option<Vec<(String, &str)>> {
    let numbers = labelled(line)?.into_iter();
    let pairs: Vec<_> = numbers.map(|own| (own.label, &line[own.place])).collect();
    pairs.iter().all(|(name, _)| !name.is_empty()).then_some(pairs)
}

/// Returns a line of pairs as a JSON line; an empty one for any other line.
pub fn pairs_as_json(line: &str) -> String {
    let text = |text: &str| serde_json::Value::from(text).to_string();
    let member = |(name, value): (String, &str)| format!("{}:{}", text(&name), text(value));
    let members: Vec<String> = pairs(line).into_iter().flatten().map(member).collect();
    format!("{{{}}}", members.join(","))
}

/// Returns rows of plain numbers as a table with a header. `times` are the columns of the time: none, one column, or two with
/// seconds and nanoseconds. All other columns are the channels of the calibration.
pub fn table_of_numbers(
    rows: &[&str],
    times: &Range<usize>,
    source: LiveSource<'_>,
) -> Vec<String> {
    let mut names: Vec<&str> = source.channels().map(String::as_str).collect();
    let of_time = if times.len() == 2 { &STAMP[..] } else { &TIME[..times.len()] };
    names.splice(times.start..times.start, of_time.iter().copied());
    let delimiter = rows.iter().find_map(|row| delimiter(row)).unwrap_or_default();
    let between = char::from(delimiter.byte()).to_string();
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    let row = |row: &&str| {
        let cells = cells(row, delimiter).take(names.len()).map(String::from_utf8_lossy);
        cells.collect::<Vec<_>>().join(&between)
    };
    [quoted.join(&between)].into_iter().chain(rows.iter().map(row)).collect()
}

/// Clock of rows without a time.
#[derive(Clone, Debug)]
pub struct RowClock {
    /// Sample rate (Hz). `None` for the clock of this computer.
    pub rate_hz: Option<f64>,
    n_rows: f64,
    last_secs: f64,
}

impl RowClock {
    pub fn new(rate_hz: Option<f64>) -> Self {
        Self { rate_hz, n_rows: 0.0, last_secs: f64::NEG_INFINITY }
    }

    /// Returns the time of the next row (s): the time stamp of the line if there is one, else the row number divided by the
    /// sample rate, else the time of arrival. Rows that arrived at the same time are 1 µs apart. Lines before the first row take
    /// no time.
    pub fn time(&mut self, stamp: Option<&str>, arrived_secs: f64, is_row: bool) -> f64 {
        let secs = match self.rate_hz {
            Some(rate_hz) => self.n_rows / rate_hz,
            None => arrived_secs.max(self.last_secs + LEAST_STEP_SECS),
        };
        self.n_rows += f64::from(is_row || self.n_rows > 0.0);
        self.last_secs = secs;
        let of_stamp = |stamp: &str| {
            let form = TimeForm::of_all([stamp.as_bytes()].into_iter());
            form.map_or_else(|| stamp.trim().parse().ok(), |form| form.secs(stamp.as_bytes()))
        };
        stamp.and_then(of_stamp).unwrap_or(secs)
    }
}

/// Returns the columns of the time in the first rows of plain numbers, all of which have equally many. `None` if it is unclear
/// which columns are the channels. As many numbers as the calibration has channels are the channels. One number more is a time
/// if exactly one column is a clock that has no jitter or counts from 1970. Two numbers more are a time in seconds and
/// nanoseconds if both together are a clock.
pub fn times_of_numbers(rows: &[Vec<f64>], source: LiveSource<'_>) -> Option<Range<usize>> {
    let n = source.n_channels();
    let times = |time: &dyn Fn(&Vec<f64>) -> f64| rows.iter().map(time).collect::<Vec<f64>>();
    let unit_of = |times: &[f64]| clock(times, source.step_secs?, source.time_unit);
    match rows.first()?.len().checked_sub(n)? {
        0 => Some(0..0),
        1 => {
            // The year is 2014 to 2036.
            let is_clock = |at: &usize| {
                let times = times(&|row| row[*at]);
                unit_of(&times).is_some()
                    && (is_steady(&times) || timeline::counts_from_1970(times[0], &(1.4e9..2.1e9)))
            };
            let mut clocks = (0..=n).filter(is_clock);
            clocks.next().filter(|_| clocks.next().is_none()).map(|at| at..at + 1)
        }
        2 => {
            let is_stamp = |row: &Vec<f64>| row[0].fract() == 0.0 && (0.0..1e9).contains(&row[1]);
            let unit = unit_of(&times(&|row| row[0] - rows[0][0] + 1e-9 * row[1]));
            let is_time = unit == Some(TimeUnit::Seconds) && rows.iter().all(is_stamp);
            is_time.then_some(0..2)
        }
        _ => None,
    }
}

/// Returns true if all steps of a clock are equal, except for rounding. A gauge under a growing load rises in steps that are
/// nearly equal, too, but they differ by its noise.
fn is_steady(times: &[f64]) -> bool {
    /// Maximum difference of a step to the median step, as a share of it.
    const JITTER: f64 = 0.03;
    /// Minimum step of whole numbers that may differ by 1.
    const ROUNDED: f64 = 5.0;
    let is_whole = times.iter().all(|time| time.fract() == 0.0);
    let mut rises = times.windows(2).map(|two| two[1] - two[0]).filter(|step| *step > 0.0);
    median_step(times).is_some_and(|step| {
        let is_rounded = is_whole && step >= ROUNDED;
        let most = (JITTER * step).max(f64::from(u8::from(is_rounded)));
        rises.all(|rise| (rise - step).abs() <= most)
    })
}

/// Returns the unit of a column of numbers that is a clock; `None` if this is not proven. If the user gave the unit, any step
/// is right. A clock never goes back, and its steps are near to the step of the calibration in one of the units. Each time of
/// a coarse clock is repeated in nearly equally many rows. A counter of rows looks like a clock, too, so the step of numbers
/// that rise by 1 in each row must be very near.
fn clock(times: &[f64], trained_secs: f64, given: Option<TimeUnit>) -> Option<TimeUnit> {
    /// Minimum number of steps.
    const FEWEST_STEPS: usize = 4;
    /// Factors of the calibration's step between which the step of a counter must be.
    const VERY_NEAR: RangeInclusive<f64> = 0.67..=1.5;
    let steps: Vec<f64> = times.windows(2).map(|two| two[1] - two[0]).collect();
    let step = median_step(times)?;
    let runs: Vec<usize> = times.chunk_by(|a, b| a == b).map(<[f64]>::len).collect();
    // The first and the last time may be cut.
    let whole_runs = runs.get(1..runs.len() - 1)?;
    let (shortest, longest) = (whole_runs.iter().min()?, whole_runs.iter().max()?);
    let unit = given.or_else(|| timeline::unit_by_step(step, trained_secs).ok())?;
    let is_counter = steps.iter().all(|own| *own == 1.0);
    let is_very_near = VERY_NEAR.contains(&(step / unit.per_second() / trained_secs));
    let is_clock = steps.iter().all(|own| *own >= 0.0)
        && runs.len() > FEWEST_STEPS
        && longest - shortest <= 1
        && (is_very_near || !is_counter || given.is_some());
    is_clock.then_some(unit)
}
