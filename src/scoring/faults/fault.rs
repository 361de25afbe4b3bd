//! Kinds of faults, and the channels that have them.

use std::fmt;
use std::ops::Range;

use crate::recording::Channel;

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

#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    pub kind: FaultKind,
    pub channel: Channel,
    pub samples: Range<usize>,
}
