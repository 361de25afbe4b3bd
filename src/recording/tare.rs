use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Interval of a recording in which the sensor is unloaded. Taring subtracts the mean gauge readings of this interval from
/// the recording.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tare {
    /// The first half second in which the gauges are quiet and the reference shows no load.
    Auto,
    /// Start and end of the interval, in seconds from the first sample of the recording.
    Interval(f64, f64),
}

impl Tare {
    /// Returns true if the interval starts at 0 s or later and does not end before its start.
    pub(crate) fn is_valid(self) -> bool {
        match self {
            Self::Auto => true,
            Self::Interval(from, to) => 0.0 <= from && from <= to && to.is_finite(),
        }
    }
}

impl fmt::Display for Tare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("the first quiet unloaded interval of each recording"),
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
            Some(Self::Interval(from.trim().parse().ok()?, to.trim().parse().ok()?))
        });
        interval.filter(|tare| tare.is_valid()).ok_or_else(|| {
            format!("the tare interval is {text:?}; it must be \"auto\" or two times in seconds, such as 0:1.5")
        })
    }
}
