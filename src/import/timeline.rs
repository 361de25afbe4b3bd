//! Examines the times of a file: derives their unit if the header has none, and finds the rows at which recordings start.

use std::ops::Range;

use super::{rows::Rows, warning::Cause};
use crate::recording::{
    gap::{after_wrap, gap_by_steps, median_step, steps_of_a_pause},
    median,
    units::TimeUnit,
};

/// Minimum number of pauses from which the rows of a file are taken to come in bursts, see [`bursts`].
const FEWEST_BURSTS: usize = 5;
/// Maximum median number of rows between two long steps for which the rows are taken to be written at events, such as a
/// change of the load. Long steps are then as usual as short ones.
const ROWS_BETWEEN_EVENTS: f64 = 3.0;
/// Minimum length of a gap between rows that are written at events, in median long steps.
const GAP_IN_LONG_STEPS: f64 = 20.0;
/// Maximum mean number of rows between two pauses for which rows are taken to come in bursts, see [`bursts`].
const STEPS_PER_BURST: usize = 50;
/// Maximum median pause (s) for which rows are taken to come in bursts. A logger writes its rows at least once a second;
/// longer pauses are made by the user.
const LONGEST_BURST_PAUSE_SECS: f64 = 1.0;
/// Shortest pause (s) that starts a new recording if rows come in bursts.
const GAP_BETWEEN_BURSTS_SECS: f64 = 2.0;
/// Maximum plausible sample interval (s). A unit of time that gives a longer interval is not assumed.
const SLOWEST_STEP_SECS: f64 = 60.0;

const UNITS: [TimeUnit; 4] =
    [TimeUnit::Seconds, TimeUnit::Milliseconds, TimeUnit::Microseconds, TimeUnit::Nanoseconds];
/// Minimum median time step at which whole numbers are read as microseconds. For example, steps of 1000 are read as 1000 µs
/// (1 kHz), not as 1000 ms (1 Hz).
const SHORTEST_STEP_MICROSECONDS: f64 = 900.0;
/// Minimum median time step at which times are read as nanoseconds. For example, steps of 333,000 are read as nanoseconds (3
/// kHz), not as microseconds (3 Hz).
const SHORTEST_STEP_NANOSECONDS: f64 = 3e5;

/// Rows of a file at which recordings start, and rows that repeat a time.
#[derive(Debug, Default)]
pub struct Cuts {
    /// First row of each recording, except the first recording.
    pub starts: Vec<usize>,
    /// First and last row that has the same time as the row before, and the number of such rows.
    pub repeats: Option<(usize, usize, u64)>,
    /// Shortest pause (s) that starts a new recording.
    pub gap_secs: f64,
    /// Pauses between bursts of rows. They do not start a new recording.
    bursts: Option<Bursts>,
}

/// Pauses between bursts of rows. Some loggers collect rows and write several at once.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bursts {
    /// Row after the first pause, and row after the last one.
    rows: (usize, usize),
    n_pauses: u64,
    pause_secs: f64,
    /// Shortest pause (s) that starts a new recording.
    gap_secs: f64,
}

/// Finds the rows at which recordings start: where time goes back, and after a pause of more than `gap_secs`. If it is
/// `None`, this length is derived from the times.
pub fn cuts(times: &[f64], gap_secs: Option<f64>) -> Cuts {
    let mut cuts = Cuts::default();
    let gap = gap_secs.unwrap_or_else(|| {
        cuts.bursts = bursts(times);
        match cuts.bursts {
            Some(bursts) => bursts.gap_secs,
            None => gap_by_steps(times),
        }
    });
    cuts.gap_secs = gap;
    for (before, pair) in times.windows(2).enumerate() {
        let (step, row) = (pair[1] - pair[0], before + 1);
        if step < 0.0 || step > gap {
            cuts.starts.push(row);
        } else if step == 0.0 {
            let (first, _, count) = cuts.repeats.unwrap_or((row, row, 0));
            cuts.repeats = Some((first, row, count + 1));
        }
    }
    cuts
}

/// Returns true if a time counts from the year 1970, in s, ms, us or ns. `secs` are the seconds since then that it may have.
pub fn counts_from_1970(time: f64, secs: &Range<f64>) -> bool {
    [1.0, 1e3, 1e6, 1e9].iter().any(|unit| secs.contains(&(time / unit)))
}

/// Returns true if the rows were written newest first: most times are earlier than the time of the row before.
pub fn is_newest_first(times: &[f64]) -> bool {
    /// Minimum ratio of steps back to steps forward. A file of recordings that each start at zero has far fewer steps back.
    const BACK_TO_FORWARD: usize = 4;
    let count = |is_meant: fn(f64) -> bool| {
        times.windows(2).filter(|pair| is_meant(pair[1] - pair[0])).count()
    };
    let (back, forward) = (count(|step| step < 0.0), count(|step| step > 0.0));
    back > 1 && back >= BACK_TO_FORWARD * forward
}

/// Adds a day to times of day (s) after each midnight, so that times count from the first midnight.
pub fn count_days(times: &mut [f64]) {
    const DAY_SECS: f64 = 86_400.0;
    let mut midnight = 0.0;
    let mut before = f64::NEG_INFINITY;
    for time in times {
        if *time + midnight < before - 0.5 * DAY_SECS {
            midnight += DAY_SECS;
        }
        *time += midnight;
        before = *time;
    }
}

pub fn sort(rows: &mut Rows) {
    let mut order: Vec<usize> = (0..rows.times.len()).collect();
    order.sort_by(|a, b| rows.times[*a].total_cmp(&rows.times[*b]));
    rows.arrange(&order);
}

/// Spreads rows with the same time stamp evenly up to the next stamp. Rows with the first stamp, with the last stamp, and
/// before a pause are spaced by the median time step of the file instead. The rows with the first stamp are placed so that
/// the next step reaches the second stamp.
pub fn spread(times: &mut [f64]) {
    let stamps: Vec<(f64, usize)> =
        (times.chunk_by(|a, b| a == b)).map(|own| (own[0], own.len())).collect();
    let inner = stamps.get(1..).unwrap_or_default().windows(2);
    let Some(step) = median(inner.map(|pair| (pair[1].0 - pair[0].0) / pair[0].1 as f64)) else {
        return;
    };
    let longest = 2.0 * median_step(times).unwrap_or(0.0);
    let mut row = 0;
    for (at, &(stamp, n)) in stamps.iter().enumerate() {
        let until = stamps.get(at + 1).map_or(0.0, |next| next.0 - stamp);
        let is_cut = until <= 0.0 || until > longest;
        let (start, step) = match (at, is_cut) {
            (0, false) => (stamp + until - step * n as f64, step),
            (_, true) => (stamp, step),
            (_, false) => (stamp, until / n as f64),
        };
        for k in 0..n {
            times[row + k] = start + step * k as f64;
        }
        row += n;
    }
}

/// Returns the longest time step (s) over which a reference is interpolated: 20 median steps, or the shortest gap if rows come
/// in bursts.
pub fn longest_bridge(times: &[f64]) -> f64 {
    match bursts(times) {
        Some(bursts) => bursts.gap_secs,
        None => steps_of_a_pause(times),
    }
}

/// Returns the pauses between bursts of rows, or the long steps between rows that are written at events. A gap is a rare
/// interruption, so steps that are usual in a file are none. `None` if there are too few long steps, there are too many rows
/// between them, or the median of them is too long.
fn bursts(times: &[f64]) -> Option<Bursts> {
    let shortest = steps_of_a_pause(times);
    let steps = times.windows(2).map(|pair| pair[1] - pair[0]).enumerate();
    let mut pauses: Vec<(usize, f64)> = steps.filter(|(_, step)| *step > shortest).collect();
    let between = median(pauses.windows(2).map(|pair| (pair[1].0 - pair[0].0) as f64));
    let is_at_events = between.is_some_and(|n_rows| n_rows <= ROWS_BETWEEN_EVENTS);
    let mut gap_secs = GAP_BETWEEN_BURSTS_SECS;
    if is_at_events {
        let usual = median(pauses.iter().map(|(_, step)| *step))?;
        gap_secs = gap_secs.max(GAP_IN_LONG_STEPS * usual);
    }
    pauses.retain(|(_, step)| *step <= gap_secs);
    let is_often = is_at_events || pauses.len() * STEPS_PER_BURST >= times.len();
    let is_rhythm = pauses.len() >= FEWEST_BURSTS && is_often;
    let pause_secs = median(pauses.iter().map(|(_, step)| *step))?;
    let (first, last) = (pauses.first()?, pauses.last()?);
    (is_rhythm && pause_secs <= LONGEST_BURST_PAUSE_SECS).then_some(Bursts {
        rows: (first.0 + 1, last.0 + 1),
        n_pauses: pauses.len() as u64,
        pause_secs,
        gap_secs,
    })
}

/// Derives the unit of times from their values, to which `since` is added. If one unit makes them UNIX times of today with
/// plausible time steps, it is this unit. Otherwise the median step decides: whole numbers with a step of at least 2 are
/// milliseconds, with longer steps microseconds or nanoseconds. All other times are seconds.
pub fn unit_by_values(times: &[f64], since: f64) -> TimeUnit {
    let step = median_step(times);
    let by_epoch = UNITS.into_iter().find(|unit| {
        // UNIX times (s) from the years 2001 to 2286.
        let is_epoch = |&time: &f64| (1e9..1e10).contains(&((since + time) / unit.per_second()));
        let is_plausible = |step: f64| step <= SLOWEST_STEP_SECS * unit.per_second();
        times.first().is_some_and(is_epoch) && step.is_none_or(is_plausible)
    });
    let is_whole = || times.iter().all(|time| time.fract() == 0.0);
    by_epoch.unwrap_or_else(|| match step {
        Some(step) if step >= SHORTEST_STEP_NANOSECONDS => TimeUnit::Nanoseconds,
        Some(step) if step >= SHORTEST_STEP_MICROSECONDS && is_whole() => TimeUnit::Microseconds,
        Some(step) if step >= 2.0 && is_whole() => TimeUnit::Milliseconds,
        _ => TimeUnit::Seconds,
    })
}

/// Factor by which the time step of live rows may differ from that of the calibration's recordings, if no unit is given. The
/// factor for the next unit is then above 60.
const STEP_FACTOR_LIMIT: f64 = 15.0;

/// Returns the unit in which the time step `step` is nearest to the time step of a calibration's recordings (s). If the two
/// differ by more than [`STEP_FACTOR_LIMIT`], returns unit and factor as an error.
pub fn unit_by_step(step: f64, trained_secs: f64) -> Result<TimeUnit, (TimeUnit, f64)> {
    let off = |unit: TimeUnit| {
        let times = step / unit.per_second() / trained_secs;
        (unit, times.max(1.0 / times))
    };
    let nearest = UNITS.into_iter().map(off);
    let nearest = nearest.min_by(|a, b| a.1.total_cmp(&b.1));
    let (unit, off) = nearest.expect("the list of units is not empty");
    if off <= STEP_FACTOR_LIMIT { Ok(unit) } else { Err((unit, off)) }
}

/// Makes times (s) increase that come from a 32-bit counter which starts again from zero. Returns the first row after the
/// first restart, and the times before and after it.
pub fn unwrap_counters(times: &mut [f64], gap_secs: Option<f64>) -> Option<(usize, [f64; 2])> {
    if times.is_sorted() {
        return None;
    }
    let gap_secs = gap_secs.unwrap_or_else(|| gap_by_steps(times));
    if !gap_secs.is_finite() {
        return None;
    }
    let (mut first, mut added) = (None, 0.0);
    for row in 1..times.len() {
        if let Some(wrap) = after_wrap(times[row] + added - times[row - 1], gap_secs) {
            first = first.or(Some((row, [times[row - 1], times[row]])));
            added += wrap;
        }
        times[row] += added;
    }
    first
}

impl Cuts {
    /// Returns starts of recordings among rows without times.
    pub fn of_rows(starts: Vec<usize>) -> Self {
        Self { starts, gap_secs: f64::INFINITY, ..Self::default() }
    }

    /// Adds warnings about the starts of recordings and about repeated times.
    pub fn note(&self, rows: &mut Rows) {
        let back = |row: &&usize| {
            let step = rows.times[**row] - rows.times[**row - 1];
            -self.gap_secs < step && step < 0.0
        };
        let mut late = self.starts.iter().filter(back);
        // If the time goes back in more than a quarter of the rows, the column is not a time, so this warning would mislead.
        const LATE_SHARE: usize = 4;
        if let Some(&first) = late.next()
            && let count = 1 + late.count()
            && count * LATE_SHARE <= rows.times.len()
        {
            rows.note_row(first, Cause::LateRows { count });
        }
        for &row in &self.starts {
            let cause =
                Cause::NewRecording { from_secs: rows.times[row - 1], to_secs: rows.times[row] };
            rows.note_row(row, cause);
        }
        if let Some((first, last, count)) = self.repeats {
            // If at least half of the rows repeat a time, the resolution of the clock is coarser than the sample interval.
            let is_coarse = 2 * count >= rows.times.len() as u64;
            let cause = if is_coarse {
                Cause::CoarseStamps
            } else {
                Cause::RepeatedTime { time_secs: rows.times[first] }
            };
            rows.note_rows(first, last, count, cause);
        }
        if let Some(bursts) = self.bursts {
            let cause = Cause::Bursts { pause_secs: bursts.pause_secs, gap_secs: bursts.gap_secs };
            let (first, last) = bursts.rows;
            rows.note_rows(first, last, bursts.n_pauses, cause);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_or_a_step_back_cuts() {
        let times = [0.0, 0.1, 0.2, 2.1, 2.2, 4.3, 4.4, 1.0, 1.1, 1.1];
        let found = cuts(&times, None);
        assert_eq!(found.starts, [5, 7]); // 1.9 is 19 median steps, 2.1 is 21
        assert_eq!(found.repeats, Some((9, 9, 1)));
        assert_eq!(cuts(&times, Some(1.8)).starts, [3, 5, 7]);
        assert_eq!(cuts(&times, Some(9.0)).starts, [7]);
    }

    /// Returns the times (s) of `n` runs of `samples` samples.
    fn runs(n: u32, samples: u32, step: f64, pause: f64) -> Vec<f64> {
        let period = f64::from(samples - 1) * step + pause;
        let time = |k: u32| f64::from(k / samples) * period + f64::from(k % samples) * step;
        (0..n * samples).map(time).collect()
    }

    #[test]
    fn rows_in_many_bursts_are_one_recording() {
        for pause in [0.16, 0.99] {
            let found = cuts(&runs(40, 15, 0.0004, pause), None);
            assert!(found.starts.is_empty());
            let bursts = found.bursts.unwrap();
            assert_eq!((bursts.rows, bursts.n_pauses), ((15, 585), 39));
            assert!((bursts.pause_secs - pause).abs() < 1e-9);
        }
    }

    /// A testing machine writes a row when the load or the travel has changed by some amount.
    #[test]
    fn rows_written_at_events_are_one_recording() {
        let mut times = vec![0.0];
        let mut add = |n: u32, step: &dyn Fn(u32) -> f64| {
            (0..n).for_each(|k| times.push(times[times.len() - 1] + step(k)));
        };
        add(900, &|_| 0.01);
        add(15, &|k| 0.3 + 0.15 * f64::from(k));
        add(800, &|k| if k < 40 && k % 3 == 0 { 0.3 } else { 0.01 });
        let found = cuts(&times, None);
        assert_eq!((found.starts, found.bursts.map(|own| own.n_pauses)), (vec![], Some(29)));
        // A break of half a minute is still one.
        times.push(times[times.len() - 1] + 30.0);
        assert_eq!(cuts(&times, None).starts.len(), 1);
    }

    #[test]
    fn packets_with_short_pauses_are_one_recording_without_a_warning() {
        let found = cuts(&runs(40, 50, 0.001, 0.004), None);
        assert_eq!((found.starts, found.repeats, found.bursts), (vec![], None, None));
    }

    #[test]
    fn presses_one_after_the_other_are_recordings() {
        for (samples, step, pause) in [(30, 0.01, 10.0), (30, 0.05, 1.5), (15, 0.0004, 3.0)] {
            let found = cuts(&runs(690, samples, step, pause), None);
            assert_eq!(found.starts.len(), 689, "every {pause} s");
            assert_eq!(found.bursts, None);
        }
    }

    #[test]
    fn presses_are_recordings_even_if_rows_come_in_bursts() {
        let press = runs(20, 15, 0.0004, 0.16);
        let presses =
            (0..60).flat_map(|k| press.iter().map(move |time| time + 12.0 * f64::from(k)));
        let found = cuts(&presses.collect::<Vec<_>>(), None);
        assert_eq!(found.starts.len(), 59);
        assert_eq!(found.bursts.unwrap().n_pauses, 60 * 19);
    }

    #[test]
    fn a_single_late_stamp_is_no_gap() {
        let mut times: Vec<f64> = (0..2000).map(|k| f64::from(k) / 1000.0).collect();
        times[1000..].iter_mut().for_each(|time| *time += 0.03);
        let found = cuts(&times, None);
        assert_eq!((found.starts, found.repeats, found.bursts), (vec![], None, None));
        times[1000..].iter_mut().for_each(|time| *time += 0.2);
        assert_eq!(cuts(&times, None).starts, [1000]);
    }

    #[test]
    fn a_pause_set_by_the_user_is_not_a_rhythm() {
        let found = cuts(&runs(40, 15, 0.0004, 0.16), Some(0.1));
        assert_eq!((found.starts.len(), found.bursts), (39, None));
    }

    #[test]
    fn constant_time_never_cuts() {
        let found = cuts(&[3.0; 4], None);
        assert!(found.starts.is_empty());
        assert_eq!(found.repeats, Some((1, 3, 3)));
        assert!(cuts(&[], None).starts.is_empty());
    }

    #[test]
    fn values_give_the_unit() {
        use TimeUnit::{Microseconds, Milliseconds, Nanoseconds, Seconds};
        for (start, step, unit) in [
            (0.0, 0.001, Seconds),
            (0.0, 0.5, Seconds),
            (0.0, 0.75, Seconds), // not whole
            (5.0, 1.0, Seconds),
            (5.0, 2.0, Milliseconds),
            (0.0, 500.0, Milliseconds),
            (0.0, 1e3, Microseconds), // of micros(), at 1 kHz
            (0.0, 5e4, Microseconds),
            (0.0, 1e5, Microseconds),
            (0.0, 4e5, Nanoseconds),
            (5e12, 1e6, Nanoseconds), // since a computer started
            (1.7e9, 0.25, Seconds),
            (1.7e9, 10.0, Seconds),
            (1.7e12, 1.0, Milliseconds),
            (1.7e15, 1e3, Microseconds),
            (1.7e18, 1e6, Nanoseconds),
            (2e9, 1e3, Microseconds), // no log takes a sample every 17 minutes
        ] {
            let times: Vec<f64> = (0..9).map(|k| start + step * f64::from(k)).collect();
            assert_eq!(unit_by_values(&times, 0.0), unit, "{start} + {step} k");
        }
        for (step, unit) in [(0.05, Seconds), (50.0, Milliseconds), (2e5, Microseconds)] {
            assert_eq!(unit_by_step(step, 0.05), Ok(unit));
        }
        // Time steps in minutes, and in units of 0.1 ms.
        for step in [8e-4, 801.0] {
            assert!(unit_by_step(step, 0.05).is_err(), "{step}");
        }
        assert_eq!(unit_by_values(&[7.0], 0.0), Seconds);
        assert_eq!(unit_by_values(&[1.7e12], 0.0), Milliseconds);
    }
}
