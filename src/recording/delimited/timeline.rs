//! What the times of a file say: their unit where the header does not, and where one recording ends and the next starts.

use super::rows::Rows;
use super::warning::Finding;
use crate::recording::recording::median;
use crate::recording::units::TimeUnit;

/// A step this many times the median is a pause between recordings, not a few lost samples.
const PAUSE_IN_STEPS: f64 = 20.0;
/// This many pauses, if they are also more than one step in [`STEPS_PER_BURST`], are the rhythm of a logger that
/// writes rows in bursts.
const FEWEST_BURSTS: usize = 20;
/// See [`FEWEST_BURSTS`].
const STEPS_PER_BURST: usize = 50;
/// No calibration is logged more slowly than one sample a minute (s): slower, and the unit is another.
const SLOWEST_STEP_SECS: f64 = 60.0;

/// Where recordings start and where times repeat.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Cuts {
    /// The first row of each recording but the first.
    pub(super) starts: Vec<usize>,
    /// The first and the last row with the time of the row before, and how many there are.
    pub(super) repeats: Option<(usize, usize, u64)>,
}

/// Cuts at every pause and wherever time goes back, given times in seconds.
pub(super) fn cuts(times: &[f64]) -> Cuts {
    let pause = shortest_pause(times);
    let mut cuts = Cuts::default();
    for (before, pair) in times.windows(2).enumerate() {
        let (step, row) = (pair[1] - pair[0], before + 1);
        if step < 0.0 || step > pause {
            cuts.starts.push(row);
        } else if step == 0.0 {
            let (first, _, count) = cuts.repeats.unwrap_or((row, row, 0));
            cuts.repeats = Some((first, row, count + 1));
        }
    }
    cuts
}

/// A longer step is a pause: 20 median steps, or where rows come in bursts, 20 times the median pause between those.
fn shortest_pause(times: &[f64]) -> f64 {
    let steps = || times.windows(2).map(|pair| pair[1] - pair[0]);
    let Some(step) = median_step(times) else {
        return f64::INFINITY;
    };
    let pause = PAUSE_IN_STEPS * step;
    let between_bursts = || steps().filter(|step| *step > pause);
    let n_bursts = between_bursts().count();
    if n_bursts < FEWEST_BURSTS || n_bursts * STEPS_PER_BURST < times.len() {
        return pause;
    }
    PAUSE_IN_STEPS * median(between_bursts()).unwrap_or(step)
}

/// The unit that the times have by their values.
///
/// Values like today's UNIX time name their unit by their size, if the steps fit a logger; otherwise the steps decide:
/// whole numbers with a median step from 2 to 1e5 are milliseconds, from 1e5 on nanoseconds, everything else seconds.
pub(super) fn unit_by_values(times: &[f64]) -> TimeUnit {
    let step = median_step(times);
    let by_epoch = [
        TimeUnit::Seconds,
        TimeUnit::Milliseconds,
        TimeUnit::Microseconds,
        TimeUnit::Nanoseconds,
    ]
    .into_iter()
    .find(|unit| {
        // From 2001 to 2286.
        let is_epoch = |&time: &f64| (1e9..1e10).contains(&(time / unit.per_second()));
        let is_plausible = |step: f64| step <= SLOWEST_STEP_SECS * unit.per_second();
        times.first().is_some_and(is_epoch) && step.is_none_or(is_plausible)
    });
    by_epoch.unwrap_or(match step {
        Some(step) if step >= 1e5 => TimeUnit::Nanoseconds,
        Some(step) if step >= 2.0 && times.iter().all(|time| time.fract() == 0.0) => {
            TimeUnit::Milliseconds
        }
        _ => TimeUnit::Seconds,
    })
}

/// The median of the steps forward; `None` if there are none.
fn median_step(times: &[f64]) -> Option<f64> {
    let steps = times.windows(2).map(|pair| pair[1] - pair[0]);
    median(steps.filter(|step| *step > 0.0))
}

impl Cuts {
    /// Notes the cuts and repeats as findings about `rows`.
    pub(super) fn note(&self, rows: &mut Rows) {
        for &row in &self.starts {
            let finding = Finding::NewRecording {
                from_secs: rows.times[row - 1],
                to_secs: rows.times[row],
            };
            rows.findings.note(rows.line_of(row), finding);
        }
        if let Some((first, last, count)) = self.repeats {
            let finding = Finding::RepeatedTime {
                time_secs: rows.times[first],
            };
            let (first, last) = (rows.line_of(first), rows.line_of(last));
            rows.findings.note_many(first, last, count, finding);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_or_a_step_back_cuts() {
        let times = [0.0, 0.1, 0.2, 2.1, 2.2, 4.3, 4.4, 1.0, 1.1, 1.1];
        let cuts = cuts(&times);
        assert_eq!(cuts.starts, [5, 7]); // 1.9 is 19 median steps, 2.1 is 21
        assert_eq!(cuts.repeats, Some((9, 9, 1)));
    }

    #[test]
    fn rows_in_many_bursts_are_one_recording() {
        let bursts = (0..600).map(|k| f64::from(k / 15) * 0.16 + f64::from(k % 15) * 0.0004);
        assert_eq!(cuts(&bursts.collect::<Vec<_>>()), Cuts::default());
    }

    #[test]
    fn standing_time_never_cuts() {
        let cuts = cuts(&[3.0; 4]);
        assert!(cuts.starts.is_empty());
        assert_eq!(cuts.repeats, Some((1, 3, 3)));
        assert_eq!(super::cuts(&[]), Cuts::default());
    }

    #[test]
    fn values_tell_the_unit() {
        use TimeUnit::{Microseconds, Milliseconds, Nanoseconds, Seconds};
        for (start, step, unit) in [
            (0.0, 0.001, Seconds),
            (0.0, 0.5, Seconds),
            (0.0, 0.75, Seconds), // not whole
            (5.0, 1.0, Seconds),
            (5.0, 2.0, Milliseconds),
            (0.0, 5e4, Milliseconds),
            (0.0, 1e5, Nanoseconds),
            (5e12, 1e6, Nanoseconds), // since a computer started
            (1.7e9, 0.25, Seconds),
            (1.7e9, 10.0, Seconds),
            (1.7e12, 1.0, Milliseconds),
            (1.7e15, 1e3, Microseconds),
            (1.7e18, 1e6, Nanoseconds),
            (2e9, 1e3, Milliseconds), // no log takes a sample every 17 minutes
        ] {
            let times: Vec<f64> = (0..9).map(|k| start + step * f64::from(k)).collect();
            assert_eq!(unit_by_values(&times), unit, "{start} + {step} k");
        }
        assert_eq!(unit_by_values(&[7.0]), Seconds);
        assert_eq!(unit_by_values(&[1.7e12]), Milliseconds);
    }
}
