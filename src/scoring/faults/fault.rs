//! Kinds of faults, and the channels that have them.

use std::ops::Range;

use crate::recording::Channel;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, strum::Display)]
#[strum(serialize_all = "lowercase")]
pub enum FaultKind {
    /// The channel stays at the limit of the logger while the load changes further.
    Saturated,
    /// The channel repeats one value, or shows only noise, while the load moves.
    Stuck,
    /// Some samples of the channel have a value far from all others, such as zero.
    #[strum(serialize = "dropped out")]
    Dropout,
    /// A few samples of the channel are far from their neighbours, and no other channel shows it.
    #[strum(serialize = "in spikes")]
    Spike,
    /// The load exceeds the rated load of its axis.
    #[strum(serialize = "overloaded")]
    Overload,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    pub kind: FaultKind,
    pub channel: Channel,
    pub samples: Range<usize>,
}
