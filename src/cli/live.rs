//! `loopscope apply` with - or `--follow`: computes the load of each row as it arrives.

use std::io::{self, BufRead as _};
use std::path::Path;

use super::error::JobError;
use super::messages::Messages;
use crate::{
    calibration::{Calibration, Estimator, Status},
    export::{LiveSample, LoadRows, name_gauges},
    formats::text::ArrivingLines,
    import::{
        ReadError, TableError,
        live::{
            Arrived, GrowingFile, Grown, LiveHead, LiveRow, LiveSource, LiveTable, Places,
            Rejected, RowForm,
        },
        map::ColumnMap,
    },
    recording::{Axis, RecordingError, Tare, units::TimeUnit},
};

/// Status of a row that gets no load, because the rows are being averaged for a tare.
const TARING: &str = "taring";
/// Maximum number of unusable lines that are reported one by one. Later lines are only counted.
const REPORTED_ONE_BY_ONE: u64 = 5;
/// Maximum duration (s) of a tare that a line asks for. A larger number was probably meant in milliseconds.
const TARE_LIMIT_SECS: f64 = 100.0;
/// Number of lines without a row of the given form after which the user is told to look at the form.
const LINES_WITHOUT_A_ROW: usize = 10;

/// Computes the loads of the rows on standard input until the input ends.
pub fn standard_input(tap: Tap<'_>) -> Result<(), JobError> {
    let mut input = io::stdin().lock();
    let mut lines = ArrivingLines::default();
    let path = Path::new("standard input");
    tap.answer(path, &mut || {
        loop {
            if let Some(line) = lines.next_line() {
                return Ok(Some(Grown::Line(line)));
            }
            let new = match input.fill_buf() {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                new => new.map_err(|error| hung_up(path, &error))?,
            };
            let n = new.len();
            if n == 0 {
                return Ok(lines.last_line().map(Grown::Line));
            }
            lines.push(new);
            input.consume(n);
        }
    })
}

/// Computes the loads of the rows of a file, and of each row that is appended, until the user ends the program.
pub fn follow(tap: Tap<'_>, path: &Path) -> Result<(), JobError> {
    let mut file = GrowingFile::open(path)
        .map_err(|error| JobError::other(format!("{}: {error}", path.display())))?;
    let say = tap.say;
    tap.answer(path, &mut || {
        let grown = file.look().map_err(|error| hung_up(path, &error))?;
        if grown == Grown::Replaced {
            say.note(format_args!(
                "{}: the file was replaced or shortened; reading starts again at its beginning",
                path.display()
            ));
        }
        Ok(Some(grown))
    })
}

fn hung_up(path: &Path, error: &io::Error) -> JobError {
    JobError::SourceEnded(format!("{}: the source ended: {error}", path.display()))
}

#[derive(Debug)]
pub struct Tap<'a> {
    pub say: &'a Messages,
    pub calibration: Calibration,
    /// True if the calibration names its gauges. Otherwise, the gauges of the rows are taken in order.
    pub names_gauges: bool,
    pub map: Option<ColumnMap>,
    /// Time interval in which the sensor is unloaded, in s after the first row.
    pub tare: Option<Tare>,
    pub form: Option<RowForm>,
    /// Names of the columns, if the rows are those of a table without a header.
    pub header: Option<String>,
    pub time_unit: Option<TimeUnit>,
    /// Sample rate of rows without a time (Hz).
    pub rate_hz: Option<f64>,
    pub json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Request {
    /// Tare by the mean of the rows that arrive within this time (s); with 0, by the newest row.
    Tare(f64),
    Reset,
}

impl Request {
    /// Returns the command (tare or reset) in a line; `None` if the line is no command.
    fn of(line: &str) -> Option<Self> {
        let mut words = line.split_whitespace();
        let request = match (words.next()?, words.next()) {
            ("tare", None) => Self::Tare(0.0),
            ("tare", Some(secs)) => {
                Self::Tare(secs.parse().ok().filter(|secs: &f64| secs.is_finite() && *secs >= 0.0)?)
            }
            ("reset", None) => Self::Reset,
            _ => return None,
        };
        words.next().is_none().then_some(request)
    }
}

#[derive(Debug)]
struct Taring {
    /// Start and end of the interval in which the gauges are averaged, in s after the first row.
    interval: (f64, f64),
    first_secs: Option<f64>,
    sums: Vec<f64>,
    n: u32,
}

impl Taring {
    fn new(interval: (f64, f64)) -> Self {
        Self { interval, first_secs: None, sums: Vec::new(), n: 0 }
    }

    /// Takes a row into the mean. Returns the mean gauges of the interval at the first row after the interval.
    fn take(&mut self, time: f64, gauges: &[f64]) -> Result<Option<Vec<f64>>, RecordingError> {
        let (from, to) = self.interval;
        let since = match self.first_secs {
            Some(first) if first <= time => time - first,
            // This is the first row, or the clock has been reset.
            _ => {
                *self = Self::new(self.interval);
                self.sums = vec![0.0; gauges.len()];
                self.first_secs = Some(time);
                0.0
            }
        };
        if since <= to {
            if since >= from {
                let sums = self.sums.iter_mut().zip(gauges);
                sums.for_each(|(sum, gauge)| *sum += gauge);
                self.n += 1;
            }
            return Ok(None);
        }
        let mean = self.sums.iter().map(|sum| sum / f64::from(self.n));
        match self.n {
            0 => Err(RecordingError::NothingToTare {
                name: "the rows".to_owned(),
                from,
                to,
                duration_secs: since,
            }),
            _ => Ok(Some(mean.collect())),
        }
    }
}

/// State that stays when the file is replaced: the tare, and the number of unusable lines.
#[derive(Debug, Default)]
struct Zero {
    /// Mean gauges of the unloaded sensor, which are the tare.
    unloaded: Option<Vec<f64>>,
    taring: Option<Taring>,
    n_broken: u64,
}

struct Answering<'a, 'c> {
    say: &'a Messages,
    estimator: Estimator<'c>,
    places: Places,
    gap_secs: f64,
    axes: Vec<Axis>,
    zero: &'a mut Zero,
    out: &'a mut LoadRows<io::StdoutLock<'static>>,
    newest: Option<Vec<f64>>,
}

impl Answering<'_, '_> {
    fn row(&mut self, row: &LiveRow) -> Result<(), JobError> {
        let gauges = self.places.gauges(row);
        self.newest = Some(gauges.clone());
        if let Some(taring) = &mut self.zero.taring {
            let Some(mean) = taring.take(row.time, &gauges)? else {
                self.out.write_without_load(Some(row.time), TARING, None)?;
                return Ok(self.out.flush()?);
            };
            self.zero.taring = None;
            self.tare(mean)?;
        }
        let auxiliary = self.places.auxiliary(row);
        let sample = LiveSample {
            time: row.time,
            clock_secs: row.time,
            gauges: &gauges,
            auxiliary: &auxiliary,
            reference: (&self.axes, &row.loads),
            is_held: self.places.is_held(row, self.gap_secs),
        };
        self.out.write(&mut self.estimator, sample)?;
        Ok(self.out.flush()?)
    }

    fn tare(&mut self, mean: Vec<f64>) -> Result<(), JobError> {
        self.estimator.tare(&mean)?;
        self.zero.unloaded = Some(mean);
        Ok(())
    }

    fn obey(&mut self, request: Request) -> Result<(), JobError> {
        let taring = match request {
            Request::Reset => {
                self.estimator.reset();
                let ended = self.zero.taring.take().map_or("", |_| ", and the tare is ended");
                self.say.note(format_args!("reset: the earlier rows are forgotten{ended}"));
                return Ok(());
            }
            Request::Tare(secs) if secs > TARE_LIMIT_SECS => {
                self.say.warning(format_args!(
                    "tare {secs} is ignored: the duration is in seconds, at most {TARE_LIMIT_SECS}"
                ));
                return Ok(());
            }
            Request::Tare(0.0) => match self.newest.clone() {
                Some(newest) => {
                    self.say.note("tared by the gauges of the newest row");
                    self.tare(newest)?;
                    None
                }
                None => {
                    self.say
                        .note("tare: the first row will be taken as that of the unloaded sensor");
                    Some(Taring::new((0.0, 0.0)))
                }
            },
            Request::Tare(secs) => {
                self.say.note(format_args!(
                    "taring by the mean gauges of the rows of the next {secs} s"
                ));
                Some(Taring::new((0.0, secs)))
            }
        };
        self.zero.taring = taring;
        Ok(())
    }

    /// Writes the load of the row in a line. A line that is no row is reported, and its output has no load.
    fn answer(&mut self, row: Result<LiveRow, Rejected>, line: &str) -> Result<(), JobError> {
        let rejected = match row {
            Ok(row) => return self.row(&row),
            Err(rejected) => rejected,
        };
        self.zero.n_broken += 1;
        let why = &rejected.why;
        if self.zero.n_broken <= REPORTED_ONE_BY_ONE {
            self.say.warning(format_args!("line not usable as a row: {line}: {why}"));
        }
        let status = Status::REJECTED_VALUE.to_string();
        self.out.write_without_load(rejected.time, &status, Some(why))?;
        Ok(self.out.flush()?)
    }
}

/// Function that returns the next line of the source of rows; `None` at its end.
type Lines<'a> = dyn FnMut() -> Result<Option<Grown>, JobError> + 'a;

impl Tap<'_> {
    fn answer(mut self, path: &Path, next: &mut Lines<'_>) -> Result<(), JobError> {
        let (map, header) = (self.map.take(), self.header.take());
        let channels =
            [self.calibration.gauges.clone(), self.calibration.features.auxiliary_names()];
        let source = LiveSource {
            path,
            map: map.as_ref(),
            step_secs: self.calibration.step_secs(),
            gauges: &channels[0],
            auxiliary: &channels[1],
            form: self.form,
            header: header.as_deref(),
            time_unit: self.time_unit,
            rate_hz: self.rate_hz,
        };
        let mut out = None;
        let mut zero = Zero::default();
        if let Some(Tare::Interval(from, to)) = self.tare {
            zero.taring = Some(Taring::new((from, to)));
        }
        let mut head = LiveHead::default();
        while let Some((mut table, kept)) = self.begin(std::mem::take(&mut head), source, next)? {
            self.note_assumptions(path, &table);
            if !self.names_gauges {
                name_gauges(&mut self.calibration, table.gauge_names());
            }
            let calibration = &self.calibration;
            let axes = table.axes().to_vec();
            let out = match &mut out {
                Some(out) => out,
                None => out.insert(LoadRows::live(
                    calibration,
                    axes.clone(),
                    self.json,
                    io::stdout().lock(),
                )?),
            };
            let places = table.places(&calibration.gauges, &calibration.features.auxiliary_names());
            let design = calibration.design();
            let mut estimator = Estimator::new(calibration, &design)?;
            if let Some(mean) = &zero.unloaded {
                estimator.tare(mean)?;
            }
            let mut answering = Answering {
                say: self.say,
                estimator,
                places: places.map_err(JobError::other)?,
                gap_secs: calibration.gap_secs,
                axes,
                zero: &mut zero,
                out,
                newest: None,
            };
            for Arrived { line, secs, .. } in kept {
                match Request::of(&line) {
                    Some(request) => answering.obey(request)?,
                    None => answering.answer(table.row_at(&line, secs), &line)?,
                }
            }
            loop {
                let line = match next()? {
                    Some(Grown::Nothing) => continue,
                    Some(Grown::Replaced) => break,
                    Some(Grown::Line(line)) => line,
                    None => {
                        let n = zero.n_broken;
                        if n > REPORTED_ONE_BY_ONE {
                            self.say.warning(format_args!("{n} lines were not usable as rows"));
                        }
                        return Ok(());
                    }
                };
                if let Some(request) = Request::of(&line) {
                    answering.obey(request)?;
                    continue;
                }
                let row = table.row(&line);
                match row.is_err().then(|| table.new_header(&line, source)).flatten() {
                    None => answering.answer(row, &line)?,
                    Some(names) if names.is_empty() => {}
                    Some(names) => {
                        self.say.note(format_args!(
                            "{}: a header with other columns follows: {}",
                            path.display(),
                            names.join(", ")
                        ));
                        head.push(line, source).map_err(unread)?;
                        break;
                    }
                }
            }
        }
        Ok(())
    }

    /// Prints the format of the rows and the unit of their times, if they were guessed.
    fn note_assumptions(&self, path: &Path, table: &LiveTable) {
        let path = path.display();
        if let Some(found) = table.device() {
            self.say.note(format_args!("{path}: {found}; --rows and --rate change this"));
        }
        if let Some(unit) = table.assumed_unit() {
            self.say.note(format_args!(
                "{path}: the times have no unit; {unit} is assumed, because it matches the calibration's sample rate best"
            ));
        }
    }

    /// Reads lines until the columns are known. Returns the table of the columns and the lines that it has to read; `None` if
    /// the input ends before its first line.
    fn begin(
        &self,
        mut head: LiveHead,
        source: LiveSource<'_>,
        next: &mut Lines<'_>,
    ) -> Result<Option<(LiveTable, Vec<Arrived>)>, JobError> {
        loop {
            let table = match next()? {
                None if head.is_empty() => return Ok(None),
                None => Some(head.end(source).map_err(unread)?),
                Some(Grown::Nothing) => None,
                Some(Grown::Replaced) => {
                    head = LiveHead::default();
                    None
                }
                Some(Grown::Line(line)) if Request::of(&line).is_some() => {
                    head.keep(line);
                    None
                }
                Some(Grown::Line(line)) => {
                    let table = head.push(line, source).map_err(unread)?;
                    let is_late = table.is_none() && head.n_lines() == LINES_WITHOUT_A_ROW;
                    if is_late && source.form.is_some() {
                        self.say.note(format_args!(
                            "{}: the first {LINES_WITHOUT_A_ROW} lines are no rows of the format given by --rows",
                            source.path.display()
                        ));
                    }
                    table
                }
            };
            if let Some(table) = table {
                return Ok(Some((table, head.into_kept().collect())));
            }
        }
    }
}

/// Returns the error with the answers to it. A `ReadError` contains advice that applies only to files, so the error is shown
/// without it.
fn unread(error: ReadError) -> JobError {
    if let ReadError::Table { source: TableError::UnclearRows { needed, .. }, .. } = &error {
        let names = needed.join(",");
        return JobError::other(format!(
            "{error}. Give all columns in their order: --rows \"x,{names}\", where x stands for a column that is not needed, or \"time [ms],{names}\" for a time. If the rows begin with these columns, use --rows numbers; if they begin with a time without a unit, --rows timed-numbers"
        ));
    }
    JobError::other(format!("{error}; --rows sets the format of the rows"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_asks_for_a_tare_or_a_reset_or_is_a_row() {
        for (line, request) in [
            ("tare", Some(Request::Tare(0.0))),
            ("  tare 0.5\r", Some(Request::Tare(0.5))),
            ("reset", Some(Request::Reset)),
            ("tare -1", None),
            ("tare 1 2", None),
            ("tared", None),
            ("1,2,3", None),
            ("", None),
        ] {
            assert_eq!(Request::of(line), request, "{line:?}");
        }
    }
}
