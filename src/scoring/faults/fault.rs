//! Kinds of faults, and the channels that have them.

use std::fmt;
use std::ops::Range;

use crate::recording::Recording;

/// Channel of a recording, by its position among the gauges, the axes of the reference or the auxiliary channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    Gauge(usize),
    Load(usize),
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

    pub(super) fn values(self, recording: &Recording) -> Vec<f64> {
        let (rows, width, at) = match self {
            Self::Gauge(gauge) => (recording.gauges(), recording.n_gauges(), gauge),
            Self::Load(axis) => (recording.loads(), recording.axes().len(), axis),
            Self::Auxiliary(_) => {
                return (0..recording.n_samples()).map(|k| self.of(recording, k)).collect();
            }
        };
        rows.iter().skip(at).step_by(width).copied().collect()
    }

    pub fn name(self, recording: &Recording) -> &str {
        match self {
            Self::Gauge(gauge) => &recording.gauge_names()[gauge],
            Self::Load(axis) => recording.axes()[axis].symbol(),
            Self::Auxiliary(at) => &recording.auxiliary().names()[at],
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaultKind {
    /// The channel stays at the limit of the logger while the load changes further.
    Saturated,
    /// The channel repeats one value, or shows only noise, while the load moves.
    Stuck,
    /// Some samples of the channel have a value far from all others, such as zero.
    Dropout,
    /// A few samples of the channel are far from their neighbours, and no other channel shows it.
    Spike,
    /// The load exceeds the rated load of its axis.
    Overload,
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Saturated => "saturated",
            Self::Stuck => "stuck",
            Self::Dropout => "dropped out",
            Self::Spike => "in spikes",
            Self::Overload => "overloaded",
        })
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    pub kind: FaultKind,
    pub channel: Channel,
    pub samples: Range<usize>,
}
