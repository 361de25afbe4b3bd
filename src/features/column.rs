//! What a column of the design matrix is.
//!
//! Guarantees: columns are told apart by their kind, never by their name: a gauge may be called `offset` or `S1_past`.
//! Names are printed from them, for people, and two columns may have the same.

use std::fmt;

use crate::features::block::{Appends, Block};
use crate::features::monomial::Monomial;

/// Which past of the gauges a set of columns holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum History {
    /// What the look-back at this place of the settings' list finds.
    LookBack(usize),
    /// What a block makes of this value of its list.
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

/// One column; gauges by their position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Column {
    /// A present gauge.
    Gauge(usize),
    /// A gauge of the past.
    Past {
        /// Which past.
        history: History,
        /// Which gauge.
        gauge: usize,
    },
    /// A product of standardised gauges.
    Monomial(Monomial),
    /// An auxiliary channel in deviations from its reference, alone or times a standardised gauge.
    Auxiliary {
        /// Which channel.
        channel: usize,
        /// The time constant of its low-pass (s); zero for the present value.
        tau_secs: f64,
        /// Which gauge it is multiplied with.
        gauge: Option<usize>,
    },
    /// 1.
    Offset,
}

/// What a column does in a fit, in the order in which columns explain the load: whatever an earlier one can say is not left to a
/// later one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ColumnKind {
    /// Always one. A gauge that stands still says nothing beside it.
    Offset,
    /// A present gauge.
    Gauge,
    /// What a block brought; the only kind that a ridge shrinks.
    Appended,
}

impl ColumnKind {
    /// All kinds, the first to explain first.
    pub const IN_ORDER: [Self; 3] = [Self::Offset, Self::Gauge, Self::Appended];
}

impl Column {
    /// What it does in a fit.
    pub fn kind(self) -> ColumnKind {
        match self {
            Self::Offset => ColumnKind::Offset,
            Self::Gauge(_) => ColumnKind::Gauge,
            Self::Past { .. } | Self::Monomial(_) | Self::Auxiliary { .. } => ColumnKind::Appended,
        }
    }

    /// What it is called where the gauges have these names: `<gauge>`, `<gauge>_past` (further look-backs
    /// `<gauge>_past2` …), `<gauge>_<history>` as its block says, `<gauge>*<gauge>`, `aux<channel>`, `aux<channel>_<τ>s` and
    /// `aux<channel>*<gauge>` with channels counted from 1, `offset`.
    ///
    /// # Panics
    /// If a gauge has no name.
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

    /// The names of columns, in their order.
    pub fn names(columns: &[Self], gauges: &[String]) -> Vec<String> {
        columns.iter().map(|column| column.name(gauges)).collect()
    }
}
