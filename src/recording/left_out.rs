//! Samples that were left out of a recording because the data check found them faulty, and the limits that the check used.

use serde::{Deserialize, Serialize};

use crate::recording::tare::Tare;

/// Limits of gauge readings and loads that the user entered. Samples beyond a limit are not used.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ValidRange {
    /// Minimum and maximum reading of each gauge, in the logger's unit. A reading at a limit counts as clipped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gauges: Option<GaugeRange>,
    /// Rated load of each axis (N, N·m); `None` for an axis without an entered rated load.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rated: Vec<Option<f64>>,
    /// Excess of a load over the rated load that is still allowed, as a share of the rated load. `None` means
    /// [`RATED_TOLERANCE`](Self::RATED_TOLERANCE).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overload_tolerance: Option<f64>,
}

impl ValidRange {
    /// Default for [`overload_tolerance`](Self::overload_tolerance). A small excess is no overload, because references have
    /// errors and rated loads are round numbers.
    pub const RATED_TOLERANCE: f64 = 0.02;

    /// Returns the magnitude (N or N·m) above which a load counts as overload, for an axis with this rated load.
    pub fn overload_above(&self, rated: f64) -> f64 {
        rated * (1.0 + self.overload_tolerance.unwrap_or(Self::RATED_TOLERANCE))
    }
}

/// Minimum and maximum reading of the gauges, in the logger's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum GaugeRange {
    /// The same minimum and maximum for all gauges.
    All((f64, f64)),
    /// Minimum and maximum of each gauge; `None` for a gauge with unknown limits.
    Each(Vec<Option<(f64, f64)>>),
}

impl GaugeRange {
    pub fn of(&self, gauge: usize) -> Option<(f64, f64)> {
        match self {
            Self::All(range) => Some(*range),
            Self::Each(ranges) => ranges.get(gauge).copied().flatten(),
        }
    }

    /// Returns true if every minimum is below the maximum of the same gauge.
    pub fn rises(&self) -> bool {
        let rises = |(low, high): &(f64, f64)| low < high;
        match self {
            Self::All(range) => rises(range),
            Self::Each(ranges) => ranges.iter().flatten().all(rises),
        }
    }
}

/// Limits and tare with which the data check judged the samples of a recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Judged {
    #[serde(flatten)]
    pub range: ValidRange,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tared: Option<Tare>,
}

/// Description of the samples that were left out of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Name of the recording before samples were left out.
    pub of: String,
    pub judged: Judged,
    pub n_samples: usize,
    /// Lower and upper reading at which the logger clips each gauge; `None` for a limit that was not found.
    pub unclipped: Vec<(Option<f64>, Option<f64>)>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::axis::Axis;
    use crate::recording::recording::{Recording, Source};

    #[test]
    fn history_does_not_cross_samples_left_out_for_longer_than_a_gap() {
        let times: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k)).collect();
        let values: Vec<f64> = (0..100).map(f64::from).collect();
        let recording = Recording::new(
            "push",
            Source::Simulated,
            times,
            vec!["S1".into()],
            values.clone(),
            vec![Axis::Fz],
            values,
        );
        let recording = recording.unwrap();
        let left_out = LeftOut {
            of: "push".into(),
            judged: Judged::default(),
            n_samples: 0,
            unclipped: Vec::new(),
        };
        let [one] = &recording.without(&[0..2, 5..8], &left_out)[..] else {
            panic!("three samples are no gap");
        };
        assert_eq!((one.name(), one.n_samples()), ("push", 95));
        assert_eq!(one.gauges()[..5], [2.0, 3.0, 4.0, 8.0, 9.0]);
        let parts = recording.without(&[40..60, 60..70], &left_out);
        assert_eq!(parts.len(), 2);
        assert_eq!(parts[1].name(), "push (part 2)");
        assert_eq!((parts[1].times()[0], parts[1].loads()[0]), (7.0, 70.0));
        assert!(recording.without(&[0..50, 50..100], &left_out).is_empty());
    }
}
