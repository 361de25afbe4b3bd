//! Taring: what the gauges show without load is taken off, each recording for itself.
//!
//! Guarantees: nothing is changed but the gauges, and each by one number; a interval that is not there or never quiet is
//! refused, never guessed.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::Recording;

/// How long a quiet interval is (s); shorter ones say little about the mean.
const QUIET_SECS: f64 = 0.5;
/// Fewer samples have no scatter worth the name.
const FEWEST_SAMPLES: usize = 4;
/// The first interval is taken whose scatter is at most so many times that of the quietest.
const NEARLY_AS_QUIET: f64 = 2.0;
/// A interval in which a gauge moves by more than this share of all it does is not quiet.
const LARGEST_SHARE: f64 = 0.02;

/// Over which interval the mean gauges are taken off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tare {
    /// The first quiet half second, found by the gauges alone: whether the sensor was unloaded then, a person must know.
    Auto,
    /// From here to there (s), counted from the recording's first sample.
    #[serde(rename = "stretch")]
    Interval(f64, f64),
}

impl fmt::Display for Tare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("the first quiet interval of each recording"),
            Self::Interval(from, to) => write!(f, "{from} s to {to} s of each recording"),
        }
    }
}

impl FromStr for Tare {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let interval = text.split_once(':').and_then(|(from, to)| {
            let (from, to) = (from.trim().parse().ok()?, to.trim().parse().ok()?);
            (0.0 <= from && from <= to && f64::is_finite(to)).then_some(Self::Interval(from, to))
        });
        interval.ok_or_else(|| {
            format!("{text:?} is neither \"auto\" nor two numbers of seconds like 0:1.5")
        })
    }
}

/// Why a recording cannot be tared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TareError {
    #[error("{name}: no sample from {from} s to {to} s to tare by; it is {duration_secs} s long")]
    NoSamples {
        name: String,
        from: f64,
        to: f64,
        duration_secs: f64,
    },
    #[error(
        "{name}: its samples have no times, so there is no interval to tare by; take the unloaded reading off in the table, or fit with the offset"
    )]
    NoTimes { name: String },
    #[error("{name}: no half second without movement to tare by; name one, e.g. --tare 0:1.5")]
    NeverQuiet { name: String },
}

impl Recording {
    /// The recording less its mean gauges over a interval, and where that is (s, from the first sample).
    ///
    /// # Errors
    /// [`TareError`] if the interval has no sample, or there is no quiet one.
    pub fn tared(self, tare: Tare) -> Result<(Self, (f64, f64)), TareError> {
        if self.is_static() {
            return Err(TareError::NoTimes {
                name: self.name().to_owned(),
            });
        }
        let times = self.times();
        let (start, end) = match tare {
            Tare::Auto => first_quiet(&self).ok_or_else(|| TareError::NeverQuiet {
                name: self.name().to_owned(),
            })?,
            Tare::Interval(from, to) => (
                times.partition_point(|time| time - times[0] < from),
                times.partition_point(|time| time - times[0] <= to),
            ),
        };
        if start >= end {
            let (Tare::Interval(from, to), duration_secs) = (tare, self.duration_secs()) else {
                unreachable!("a quiet interval has samples")
            };
            return Err(TareError::NoSamples {
                name: self.name().to_owned(),
                from,
                to,
                duration_secs,
            });
        }
        let n_gauges = self.n_gauges();
        let interval = &self.gauges()[start * n_gauges..end * n_gauges];
        let mean = |gauge: usize| {
            let values = interval[gauge..].iter().step_by(n_gauges);
            values.sum::<f64>() / (end - start) as f64
        };
        let offsets: Vec<f64> = (0..n_gauges).map(mean).collect();
        let since_start = |k: usize| times[k] - times[0];
        let place = (since_start(start), since_start(end - 1));
        Ok((self.less_offsets(&offsets, tare), place))
    }
}

/// The first interval in which all gauges stay as still as they ever do.
fn first_quiet(recording: &Recording) -> Option<(usize, usize)> {
    let (times, n_gauges) = (recording.times(), recording.n_gauges());
    let ranges: Vec<f64> = (0..n_gauges)
        .map(|gauge| range(recording, gauge, 0, times.len()))
        .collect();
    let mut intervals = Vec::new();
    let mut start = 0;
    while start < times.len() {
        let end = start + times[start..].partition_point(|time| *time < times[start] + QUIET_SECS);
        let end = end.max(start + FEWEST_SAMPLES);
        if end > times.len() {
            break;
        }
        let share = |gauge: usize| {
            let all = ranges[gauge];
            if all > 0.0 {
                range(recording, gauge, start, end) / all
            } else {
                0.0
            }
        };
        let most = (0..n_gauges).map(share).fold(0.0, f64::max);
        intervals.push((start, end, most));
        start = end;
    }
    let quietest = intervals
        .iter()
        .map(|interval| interval.2)
        .reduce(f64::min)?;
    let limit = (NEARLY_AS_QUIET * quietest).min(LARGEST_SHARE);
    let first = intervals.into_iter().find(|interval| interval.2 <= limit)?;
    Some((first.0, first.1))
}

/// From the smallest to the largest value of a gauge among these samples.
fn range(recording: &Recording, gauge: usize, start: usize, end: usize) -> f64 {
    let n_gauges = recording.n_gauges();
    let values =
        recording.gauges()[start * n_gauges + gauge..(end - 1) * n_gauges + gauge + 1].iter();
    let (low, high) = values
        .step_by(n_gauges)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
            (low.min(value), high.max(value))
        });
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Axis, Source};

    /// 100 Hz: gauges at 5 and −2 with a little ripple, quiet only from 1 s to 3 s.
    fn run() -> Recording {
        let times: Vec<f64> = (0..600).map(|k| f64::from(k) / 100.0).collect();
        let load = |t: f64| {
            if (1.0..3.0).contains(&t) {
                0.0
            } else {
                (7.0 * t).sin()
            }
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
    fn the_mean_of_a_chosen_stretch_is_taken_off() {
        let (tared, place) = run().tared(Tare::Interval(1.5, 2.49)).unwrap();
        assert!(
            (place.0 - 1.5).abs() < 1e-9 && (place.1 - 2.49).abs() < 1e-9,
            "{place:?}"
        );
        assert!((tared.gauges_at(200)[0] - 1e-3).abs() < 1e-12);
        assert!(tared.gauges_at(200)[1].abs() < 1e-12);
        assert_eq!(
            (tared.loads(), tared.times()),
            (run().loads(), run().times())
        );
        assert_eq!(tared.tare(), Some(Tare::Interval(1.5, 2.49)));
    }

    #[test]
    fn the_first_quiet_stretch_is_found_by_the_gauges() {
        let (tared, place) = run().tared(Tare::Auto).unwrap();
        assert!((1.0..1.5).contains(&place.0) && place.1 < 3.0, "{place:?}");
        assert!(tared.gauges_at(150)[1].abs() < 1e-12);
    }

    #[test]
    fn what_is_never_quiet_or_too_short_is_refused() {
        let busy = run().split(0.15).unwrap().0;
        assert!(matches!(
            busy.tared(Tare::Auto),
            Err(TareError::NeverQuiet { .. })
        ));
        let beyond = run()
            .tared(Tare::Interval(7.0, 9.0))
            .unwrap_err()
            .to_string();
        assert!(
            beyond.contains("no sample from 7 s to 9 s") && beyond.contains("5.99 s long"),
            "{beyond}"
        );
    }

    #[test]
    fn a_choice_is_read_from_text() {
        assert_eq!("auto".parse(), Ok(Tare::Auto));
        assert_eq!("0: 1.5".parse(), Ok(Tare::Interval(0.0, 1.5)));
        for wrong in ["", "2", "2:1", "-1:1", "a:b", "0:inf"] {
            assert!(wrong.parse::<Tare>().is_err(), "{wrong}");
        }
    }
}
