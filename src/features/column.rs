//! Columns of the design matrix, which has one row for each sample. Code identifies a column by its kind and index, never by
//! its name: a gauge may be named `offset` or `S1_past`, and two columns may have the same name. Names are shown to people
//! only.

use std::fmt;

use crate::features::{
    block::{Appends, Block},
    monomial::Monomial,
};

/// Origin of a set of past gauge values (one value per gauge, from before the present sample).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum History {
    /// Look-back, which chooses the past sample by its load difference, with this index in the settings.
    LookBack(usize),
    /// Feature block, such as a fixed lag, creep or play, with one value of its setting.
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

/// Column of the design matrix. Gauges and auxiliary channels are given by their index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Column {
    /// Present gauge.
    Gauge(usize),
    /// Past gauge.
    Past {
        /// Method that gives the past gauge value.
        history: History,
        /// Index of the gauge.
        gauge: usize,
    },
    /// Product of standardised gauges.
    Monomial(Monomial),
    /// Auxiliary channel minus its reference value, in standard deviations of the channel; alone, or multiplied by a
    /// standardised gauge.
    Auxiliary {
        /// Index of the auxiliary channel.
        channel: usize,
        /// Time constant of the low-pass filter of the channel (s); zero for its present value without a filter.
        tau_secs: f64,
        /// Gauge that multiplies the channel; `None` for the channel alone.
        gauge: Option<usize>,
    },
    /// Constant column of ones.
    Offset,
}

/// Role of a column in a fit. The fit uses the roles in this order: columns of a role explain only the part of the load that
/// the columns of earlier roles cannot explain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ColumnKind {
    /// Constant column of ones. It comes before the gauges, so that a gauge that never changes gets the coefficient zero.
    Offset,
    Gauge,
    /// Column that a feature block appends. A ridge penalty shrinks only the coefficients of these columns.
    Appended,
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

    /// Returns the name of the column, such as `S1`, `S1_past`, `S1_past2` (second look-back), `S1_lag_0.5s`, `S1*S2`, `aux1`,
    /// `aux1_10s`, `aux1*S1` or `offset`. Channels are counted from 1. Panics if a gauge has no name.
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

    /// Returns the names of these columns, in the same order.
    pub fn names(columns: &[Self], gauges: &[String]) -> Vec<String> {
        columns.iter().map(|column| column.name(gauges)).collect()
    }
}
