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
pub(super) fn shortest_pause(times: &[f64]) -> f64 {
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

/// For how many samples a reference stays the same before it changes, if it does so steadily.
///
/// A reference that is measured less often than it is written shows runs of equal rows, nearly all of one length. Dead
/// weights show long runs of many lengths, a live signal runs of one.
pub(super) fn held_for(loads: &[f64], n_axes: usize) -> Option<usize> {
    const FEWEST_RUNS: usize = 30;
    const LONGEST_RUN: usize = 100;
    /// The start tells as much as the whole.
    const ROWS_LOOKED_AT: usize = 20_000;
    let mut runs = [0_usize; LONGEST_RUN + 1];
    let (mut n_runs, mut length) = (0, 1);
    let rows = || loads.chunks_exact(n_axes.max(1)).take(ROWS_LOOKED_AT);
    for (before, row) in rows().zip(rows().skip(1)) {
        if before == row {
            length += 1;
        } else {
            runs[length.min(LONGEST_RUN)] += 1;
            (n_runs, length) = (n_runs + 1, 1);
        }
    }
    // The steadiest length is the one that, with its neighbours, holds most runs.
    let near = |length: usize| -> usize { runs[length - 1..=length + 1].iter().sum() };
    let samples_each = (2..LONGEST_RUN).max_by_key(|&length| (near(length), runs[length]))?;
    let is_steady = near(samples_each) * 10 >= n_runs * 7 && runs[1] * 2 < n_runs;
    (n_runs >= FEWEST_RUNS && is_steady).then_some(samples_each)
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
    fn a_held_reference_is_told_from_weights_and_live_signals() {
        let runs = |lengths: &mut dyn Iterator<Item = usize>| -> Vec<f64> {
            let run = |(k, length)| vec![[k as f64, 1.0]; length];
            lengths.enumerate().flat_map(run).flatten().collect()
        };
        let held = runs(&mut (0..100).map(|k| 4 + k % 2));
        assert!(matches!(held_for(&held, 2), Some(4 | 5)));
        assert_eq!(held_for(&runs(&mut (0..100).map(|_| 2)), 2), Some(2));
        assert_eq!(held_for(&runs(&mut (0..100).map(|_| 1)), 2), None);
        let sometimes_equal = (0..100).map(|k| if k % 4 == 0 { 2 } else { 1 });
        assert_eq!(held_for(&runs(&mut sometimes_equal.clone()), 2), None);
        assert_eq!(held_for(&runs(&mut (0..20).map(|_| 4)), 2), None);
        let weights = (0..40).map(|k| 10 + (k * 7) % 60);
        assert_eq!(held_for(&runs(&mut weights.clone()), 2), None);
        assert_eq!(held_for(&[], 0), None);
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
