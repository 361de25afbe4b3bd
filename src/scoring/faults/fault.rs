//! What a fault is, and the channel that has it.

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

    /// What it is called.
    pub fn name(self, recording: &Recording) -> &str {
        match self {
            Self::Gauge(gauge) => &recording.gauge_names()[gauge],
            Self::Load(axis) => recording.axes()[axis].symbol(),
            Self::Auxiliary(at) => &recording.auxiliary().names()[at],
        }
    }
}

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaultKind {
    /// It stands at the end of what the logger can write, where the load goes on.
    Saturated,
    /// It repeats one value, or noise around one, while the load moves.
    Stuck,
    /// For some samples it shows a value that it shows nowhere near, such as zero.
    Dropout,
    /// A few samples are far off, and no other channel shows it.
    Spike,
    /// The load is beyond the rated one.
    Overload,
    /// It shows one value throughout.
    Dead,
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Saturated => "saturated",
            Self::Stuck => "stuck",
            Self::Dropout => "dropped out",
            Self::Spike => "spikes",
            Self::Overload => "overloaded",
            Self::Dead => "dead",
        })
    }
}

/// One fault of one channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What is wrong.
    pub kind: FaultKind,
    /// With what.
    pub channel: Channel,
    /// From when to when.
    pub samples: Range<usize>,
}
