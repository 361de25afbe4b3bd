//! Columns of the design matrix, identified by kind and index, never by name, because a gauge may be named `offset` or
//! `S1_past`. Names are only for people; two columns may have the same name.

use std::fmt;

use crate::features::block::{Appends, Block};
use crate::features::monomial::Monomial;

/// Source of a set of past gauges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum History {
    /// The look-back with this index in the settings.
    LookBack(usize),
    /// A block with one of its values.
    Block(&'static dyn Block, f64),
}

impl fmt::Display for History {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LookBack(0) => write!(f, "past"),
            Self::LookBack(at) => write!(f, "past{}", at + 1),
            Self::Block(block, value) => match block.appends() {
                Appends::Past(name) => f.write_str(&name(*value)),
                Appends::Monomials(_) | Appends::Auxiliary => f.write_str(block.name()),
            },
        }
    }
}

/// One column. Gauges and channels are given by index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Column {
    /// A present gauge.
    Gauge(usize),
    /// A gauge of the past.
    Past {
        /// Source of the past gauges.
        history: History,
        /// Index of the gauge.
        gauge: usize,
    },
    /// A product of standardised gauges.
    Monomial(Monomial),
    /// An auxiliary channel in standard deviations from its reference, alone or multiplied by a standardised gauge.
    Auxiliary {
        /// Index of the channel.
        channel: usize,
        /// Time constant of the low-pass (s); zero for the present value.
        tau_secs: f64,
        /// Gauge that the channel is multiplied by.
        gauge: Option<usize>,
    },
    /// Constant column of ones.
    Offset,
}

/// Role of a column in a fit. In this order, a later kind explains only what the earlier kinds cannot explain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ColumnKind {
    /// The constant column. A gauge that never changes adds nothing to it.
    Offset,
    Gauge,
    /// A column of a block. Ridge shrinks only this kind.
    Appended,
}

impl ColumnKind {
    pub const IN_ORDER: [Self; 3] = [Self::Offset, Self::Gauge, Self::Appended];
}

impl Column {
    /// Returns the role of the column in a fit.
    pub fn kind(self) -> ColumnKind {
        match self {
            Self::Offset => ColumnKind::Offset,
            Self::Gauge(_) => ColumnKind::Gauge,
            Self::Past { .. } | Self::Monomial(_) | Self::Auxiliary { .. } => ColumnKind::Appended,
        }
    }

    /// Returns the name of the column: `<gauge>`, `<gauge>_past` (further look-backs `<gauge>_past2` …), `<gauge>_<history>`,
    /// `<gauge>*<gauge>`, `aux<channel>`, `aux<channel>_<τ>s`, `aux<channel>*<gauge>`, `offset`. Channels are counted from 1.
    /// Panics if a gauge has no name.
    pub fn name(self, gauges: &[String]) -> String {
        match self {
            Self::Gauge(gauge) => gauges[gauge].clone(),
            Self::Past { history, gauge } => format!("{}_{history}", gauges[gauge]),
            Self::Monomial(monomial) => monomial.name(gauges),
            Self::Auxiliary { channel, tau_secs, gauge } => {
                let mut name = format!("aux{}", channel + 1);
                if tau_secs > 0.0 {
                    name += &format!("_{tau_secs}s");
                }
                gauge.map_or(name.clone(), |gauge| format!("{name}*{}", gauges[gauge]))
            }
            Self::Offset => "offset".to_owned(),
        }
    }

    /// Returns the names of columns in order.
    pub fn names(columns: &[Self], gauges: &[String]) -> Vec<String> {
        columns.iter().map(|column| column.name(gauges)).collect()
    }
}
