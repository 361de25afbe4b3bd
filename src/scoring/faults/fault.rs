//! Kinds of faults, and the channels that have them.

use std::fmt;
use std::ops::Range;

use crate::recording::Recording;

/// A channel of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    /// A gauge by its position.
    Gauge(usize),
    /// An axis of the reference by its position.
    Load(usize),
    /// An auxiliary channel by its position.
    Auxiliary(usize),
}

impl Channel {
    pub(super) fn of(self, recording: &Recording, k: usize) -> f64 {
        match self {
            Self::Gauge(gauge) => recording.gauges_at(k)[gauge],
            Self::Load(axis) => recording.loads()[k * recording.axes().len() + axis],
            Self::Auxiliary(at) => recording.auxiliary().at(k)[at],
        }
    }

    /// Returns the name of the channel.
    pub fn name(self, recording: &Recording) -> &str {
        match self {
            Self::Gauge(gauge) => &recording.gauge_names()[gauge],
            Self::Load(axis) => recording.axes()[axis].symbol(),
            Self::Auxiliary(at) => &recording.auxiliary().names()[at],
        }
    }
}

/// Kind of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaultKind {
    /// The channel stays at the limit of the logger while the load moves on.
    Saturated,
    /// The channel repeats one value, or shows noise around one, while the load moves.
    Stuck,
    /// Some samples show a value far from all others, such as zero.
    Dropout,
    /// A few samples are far off, and no other channel shows it.
    Spike,
    /// The load exceeds the rated load.
    Overload,
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Saturated => "saturated",
            Self::Stuck => "stuck",
            Self::Dropout => "dropped out",
            Self::Spike => "spikes",
            Self::Overload => "overloaded",
        })
    }
}

/// One fault of one channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Kind of the fault.
    pub kind: FaultKind,
    /// Channel of the fault.
    pub channel: Channel,
    /// Samples of the fault.
    pub samples: Range<usize>,
}
