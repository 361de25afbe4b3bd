//! Taring: subtracts the mean gauge readings of an unloaded interval, separately for each recording.
//!
//! Guarantees: taring subtracts one number from each gauge and changes nothing else. An interval without samples, or a
//! recording that is never quiet, is an error.

use std::ops::Range;

use super::load_cases::largest_loads;
use crate::{
    finding::{Advice, Finding, Id, Verdict, Way},
    min_max::MinMax,
    recording::{
        axis::Axis,
        recording::{Recording, RecordingError},
        tare::Tare,
    },
};

/// Length of the intervals among which taring searches for a quiet one (s). The mean of a shorter interval is too noisy.
const QUIET_SECS: f64 = 0.5;
/// Minimum number of samples in such an interval. The range of fewer samples does not show whether the gauges are quiet.
const FEWEST_SAMPLES: usize = 4;
/// Maximum gauge range in a quiet interval, as a multiple of the range in the quietest interval.
const NEARLY_AS_QUIET: f64 = 2.0;
/// Maximum gauge range in a quiet interval, as a share of the gauge's range in the whole recording.
const LARGEST_SHARE: f64 = 0.02;
/// Maximum mean reference load in an interval that counts as unloaded, as a share of the largest force or moment in the
/// recording.
const UNLOADED_SHARE: f64 = 0.02;

impl Advice for RecordingError {
    fn ways(&self) -> &'static [Way] {
        match self {
            Self::NeverUnloaded { .. } => &[Way::Tare],
            _ => &[],
        }
    }
}

impl Recording {
    /// Subtracts the mean gauge readings of an interval in which the sensor is unloaded. Returns the recording, and start and
    /// end of the interval (s from the first sample).
    ///
    /// # Errors
    /// [`RecordingError`] if the interval has no sample, or if no interval is both quiet and unloaded.
    pub fn tared(self, tare: Tare) -> Result<(Self, (f64, f64)), RecordingError> {
        if self.is_static() {
            return Err(RecordingError::NoTimes { name: self.name().to_owned() });
        }
        if self.n_gauges() == 0 {
            let (name, why) = (self.name().to_owned(), "it has no gauges");
            return Err(RecordingError::NeverUnloaded { name, why });
        }
        let times = self.times();
        let Range { start, end } = match tare {
            Tare::Auto => first_quiet_unloaded(&self)?,
            Tare::Interval(from, to) => self.samples_between(from, to),
        };
        if start >= end {
            let (Tare::Interval(from, to), duration_secs) = (tare, self.duration_secs()) else {
                unreachable!("a quiet interval has samples")
            };
            return Err(RecordingError::NothingToTare {
                name: self.name().to_owned(),
                from,
                to,
                duration_secs,
            });
        }
        let n_gauges = self.n_gauges();
        let offsets: Vec<f64> =
            (0..n_gauges).map(|gauge| mean(self.gauges(), n_gauges, gauge, start..end)).collect();
        let since_start = |k: usize| times[k] - times[0];
        let place = (since_start(start), since_start(end - 1));
        Ok((self.less_offsets(&offsets, tare), place))
    }

    /// Returns a finding if the mean reference load is not zero in the interval used for taring. `from` and `to` are seconds
    /// from the first sample.
    pub fn loaded_while_tared(&self, (from, to): (f64, f64)) -> Option<Finding> {
        let samples = self.samples_between(from, to);
        if self.axes().is_empty() || samples.is_empty() || is_unloaded(self, samples.clone()) {
            return None;
        }
        let n_axes = self.axes().len();
        let means = self.axes().iter().enumerate().map(|(at, axis)| {
            let mean = mean(self.loads(), n_axes, at, samples.clone());
            format!("{axis} {mean:.3} {}", axis.unit())
        });
        let seen = format!(
            "{}: the mean reference load is not zero in the interval that was used for taring, {from:.3} s to {to:.3} s",
            self.name()
        );
        let means = means.collect::<Vec<_>>().join(", ");
        Some(Finding::new(Id::TaredUnderLoad, Verdict::Doubtful, seen).with(means))
    }

    /// Returns the samples from the time `from` to the time `to`, both included (s from the first sample).
    fn samples_between(&self, from: f64, to: f64) -> Range<usize> {
        let times = self.times();
        times.partition_point(|time| time - times[0] < from)
            ..times.partition_point(|time| time - times[0] <= to)
    }
}

/// Returns the samples of the first interval in which all gauges are quiet and the reference shows no load.
fn first_quiet_unloaded(recording: &Recording) -> Result<Range<usize>, RecordingError> {
    let (times, n_gauges) = (recording.times(), recording.n_gauges());
    let (gauges, n) = (recording.gauges(), times.len());
    let ranges: Vec<f64> =
        (0..n_gauges).map(|gauge| range(gauges, n_gauges, gauge, 0..n).span()).collect();
    let mut intervals = Vec::new();
    let mut start = 0;
    while start < n {
        let end = start + times[start..].partition_point(|time| *time < times[start] + QUIET_SECS);
        let end = end.max(start + FEWEST_SAMPLES);
        if end > n {
            break;
        }
        let share = |gauge: usize| {
            let all = ranges[gauge];
            if all > 0.0 { range(gauges, n_gauges, gauge, start..end).span() / all } else { 0.0 }
        };
        let most = (0..n_gauges).map(share).fold(0.0, f64::max);
        intervals.push((start, end, most));
        start = end;
    }
    let quietest = intervals.iter().map(|interval| interval.2).fold(f64::INFINITY, f64::min);
    let limit = (NEARLY_AS_QUIET * quietest).min(LARGEST_SHARE);
    let mut quiet = intervals.into_iter().filter(|interval| interval.2 <= limit).peekable();
    let why = if quiet.peek().is_none() {
        "there is no half second without movement of the gauge readings"
    } else if recording.axes().is_empty() {
        "there is no reference load that shows when the sensor is unloaded"
    } else {
        "the reference shows a load in every half second in which the gauges are quiet"
    };
    quiet
        .map(|(start, end, _)| start..end)
        .find(|samples| is_unloaded(recording, samples.clone()))
        .ok_or_else(|| RecordingError::NeverUnloaded { name: recording.name().to_owned(), why })
}

/// Returns true if, on every axis, the mean reference load of these samples is near zero, or the reference reaches zero
/// within them.
fn is_unloaded(recording: &Recording, samples: Range<usize>) -> bool {
    let (axes, loads) = (recording.axes(), recording.loads());
    let n_axes = axes.len();
    let largest = largest_loads(loads, axes);
    let is_near_zero = |(at, axis): (usize, &Axis)| {
        let noise = range(loads, n_axes, at, samples.clone());
        let mean = mean(loads, n_axes, at, samples.clone());
        let limit = UNLOADED_SHARE * largest[usize::from(axis.is_force())];
        mean.abs() <= limit || noise.contains(0.0)
    };
    n_axes > 0 && axes.iter().enumerate().all(is_near_zero)
}

fn mean(values: &[f64], width: usize, column: usize, rows: Range<usize>) -> f64 {
    let channel = values[rows.start * width + column..].iter().step_by(width);
    channel.take(rows.len()).sum::<f64>() / rows.len() as f64
}

fn range(values: &[f64], width: usize, column: usize, rows: Range<usize>) -> MinMax {
    let channel = values[rows.start * width + column..].iter().step_by(width);
    channel.take(rows.len()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::recording::Source;

    /// Returns a recording at 100 Hz with gauges at 5 and −2 and a small ripple. It is quiet only from 1 s to 3 s.
    fn run() -> Recording {
        let times: Vec<f64> = (0..600).map(|k| f64::from(k) / 100.0).collect();
        let load = |t: f64| {
            if (1.0..3.0).contains(&t) { 0.0 } else { (7.0 * t).sin() }
        };
        let ripple = |k: usize| if k.is_multiple_of(2) { 1e-3 } else { -1e-3 };
        let gauges = times.iter().enumerate();
        let gauges = gauges.flat_map(|(k, &t)| [5.0 + load(t) + ripple(k), -2.0 - 2.0 * load(t)]);
        let names = vec!["S1".to_owned(), "S2".to_owned()];
        let loads = times.iter().map(|&t| load(t)).collect();
        Recording::new(
            "run",
            Source::Simulated,
            times.clone(),
            names,
            gauges.collect(),
            vec![Axis::Fz],
            loads,
        )
        .unwrap()
    }

    #[test]
    fn the_mean_of_a_chosen_interval_is_subtracted() {
        let (tared, place) = run().tared(Tare::Interval(1.5, 2.49)).unwrap();
        assert!((place.0 - 1.5).abs() < 1e-9 && (place.1 - 2.49).abs() < 1e-9, "{place:?}");
        assert!((tared.gauges_at(200)[0] - 1e-3).abs() < 1e-12);
        assert!(tared.gauges_at(200)[1].abs() < 1e-12);
        assert_eq!((tared.loads(), tared.times()), (run().loads(), run().times()));
        assert_eq!(tared.tare(), Some(Tare::Interval(1.5, 2.49)));
    }

    #[test]
    fn the_first_quiet_interval_without_load_is_found() {
        let (tared, place) = run().tared(Tare::Auto).unwrap();
        assert!((1.0..1.5).contains(&place.0) && place.1 < 3.0, "{place:?}");
        assert!(tared.gauges_at(150)[1].abs() < 1e-12);
    }

    /// In the first reference, the sensor is under load in the first quiet half second, which starts at 1 s.
    #[test]
    fn a_quiet_interval_under_load_is_skipped_and_without_an_unloaded_one_taring_fails() {
        let with_loads = |axes: &[Axis], load: &dyn Fn(f64) -> Vec<f64>| {
            let loads = run().times().iter().flat_map(|t| load(*t)).collect();
            Recording::new(
                "run",
                Source::Simulated,
                run().times().to_vec(),
                run().gauge_names().to_vec(),
                run().gauges().to_vec(),
                axes.to_vec(),
                loads,
            )
            .unwrap()
        };
        let noise = |t: f64| 1e-3 * (1e4 * t).sin();
        let axes = [Axis::Fz, Axis::Mx];
        let later = |t: f64| vec![if t < 2.0 { 40.0 } else { 100.0 * noise(t) }, noise(t)];
        let (_, place) = with_loads(&axes, &later).tared(Tare::Auto).unwrap();
        assert!(place.0 >= 2.0 && place.1 < 3.0, "{place:?}");
        let never = |t: f64| vec![if t < 3.0 { 40.0 } else { 0.0 }, 0.0];
        for (recording, why) in [
            (with_loads(&axes, &never), "shows a load"),
            (with_loads(&[Axis::Fz], &|_| vec![3.0]), "shows a load"),
            (with_loads(&[], &|_| Vec::new()), "no reference"),
        ] {
            let asked = recording.tared(Tare::Auto).unwrap_err();
            assert!(asked.to_string().contains(why), "{asked}");
            assert_eq!(asked.ways(), [Way::Tare]);
        }
    }

    #[test]
    fn a_recording_that_is_never_quiet_or_too_short_is_refused() {
        let busy = run().split(0.15).unwrap().0;
        let moving = busy.tared(Tare::Auto).unwrap_err().to_string();
        assert!(moving.contains("no half second without movement"), "{moving}");
        let beyond = run().tared(Tare::Interval(7.0, 9.0)).unwrap_err().to_string();
        assert!(
            beyond.contains("no sample from 7 s to 9 s") && beyond.contains("5.99 s long"),
            "{beyond}"
        );
    }

    #[test]
    fn a_tare_interval_is_read_from_text() {
        assert_eq!("auto".parse(), Ok(Tare::Auto));
        assert_eq!("0: 1.5".parse(), Ok(Tare::Interval(0.0, 1.5)));
        for wrong in ["", "2", "2:1", "-1:1", "a:b", "0:inf"] {
            assert!(wrong.parse::<Tare>().is_err(), "{wrong}");
        }
    }
}
