//! A block: one way of appending columns to the present gauges.

use std::fmt;

use crate::features::channel::AuxiliaryChannel;
use crate::features::gauge_scale::GaugeScale;
use crate::features::monomial::Monomial;
use crate::features::setting::Setting;
use crate::features::source::{Rows, Source};

/// One way of appending columns; what it appends them for is a list of values, the numbers of its one [`Setting`].
///
/// A block is a file of its own in this room and a line in [`BLOCKS`](crate::features::BLOCKS); whatever else there is to say
/// of it (in the window, on the command line, in files, exports and the guide) follows from what it says here.
///
/// Every block is causal, runs in bounded memory and starts anew in each recording and after each gap. What the samples since then do
/// not determine, it does not say.
pub trait Block: Send + Sync {
    /// Its name.
    fn name(&self) -> &'static str;

    /// What its values are: time constants, radii, a degree.
    fn setting(&self) -> &'static Setting;

    /// What it computes of a gauge s, as an equation.
    fn formula(&self) -> &'static str;

    /// What its columns are.
    fn appends(&self) -> Appends;

    /// Returns the number of columns that it appends to `n_gauges` gauges.
    fn n_columns(&self, values: &[f64], n_gauges: usize) -> usize {
        values.len() * n_gauges
    }

    /// How long samples are kept for it (s); zero where none are.
    fn window_secs(&self, _values: &[f64]) -> f64 {
        0.0
    }

    /// How long after a cold start it is before everything that it appends is known, where that is a matter of time (s).
    fn settling_secs(&self, values: &[f64]) -> f64 {
        self.window_secs(values)
    }

    /// Returns how far a gauge must have moved since a cold start before the state of a value is known (σ); zero where that is
    /// not what it takes.
    fn travel(&self, _value: f64) -> f64 {
        0.0
    }

    /// Its memory before the first sample of a recording.
    ///
    /// Where samples are kept, of those that come less than `history_step_secs` after the last kept one only the newest is.
    fn stream(
        &self,
        values: &[f64],
        scale: &GaugeScale,
        channels: &[AuxiliaryChannel],
        history_step_secs: f64,
    ) -> Box<dyn Stream>;

    /// What it is in exported code.
    fn source(&self, values: &[f64], rows: &Rows<'_>) -> Source;

    /// How its values are found where nobody knows them beforehand.
    fn search(&self) -> Option<Search> {
        None
    }
}

/// What the columns of a block are.
#[derive(Clone, Copy, Debug)]
pub enum Appends {
    /// For each value one set of gauges of the past: a history. It is fitted relative to the present gauges. Its columns are
    /// called `<gauge>_<name>`; the name is made of the value.
    Past(fn(f64) -> String),
    /// Products of present gauges, for the value and the number of gauges: no past in them.
    Monomials(fn(f64, usize) -> Vec<Monomial>),
    /// For each value and each auxiliary channel, the channel and its product with each gauge. No gauge of the past in them.
    Auxiliary,
}

/// A block's memory of one recording, sample by sample: a whole recording and a live estimator run the same.
pub trait Stream: fmt::Debug + Send + Sync {
    /// Takes the next sample and writes its columns; for a history the gauges of the past as they are.
    fn step(&mut self, time: f64, gauges: &[f64], auxiliary: &[f64], out: &mut [f64]);

    /// Whether the samples so far determine what it remembers; until then it says nothing, or less than later.
    fn is_determined(&self) -> bool {
        true
    }
}

/// How the values of a block are found by cross-validation.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Values that are tried, rising; of those in seconds as many as the recordings can show.
    pub candidates: &'static [f64],
    /// How lists are made of them.
    pub lists: Lists,
}

/// How lists of values are made of candidates.
#[derive(Clone, Copy, Debug)]
pub enum Lists {
    /// Every evenly spaced list of a length between two; of those within 1 % of the lowest error the shortest is taken.
    Even {
        /// The shortest.
        min: usize,
        /// The longest.
        max: usize,
    },
    /// The best one first, then the best beside it, up to this number, as long as each is better with 90 % confidence.
    OneByOne(usize),
}

/// Blocks are told apart by the keys of their settings.
impl PartialEq for dyn Block + '_ {
    fn eq(&self, other: &Self) -> bool {
        self.setting().key == other.setting().key
    }
}

impl fmt::Debug for dyn Block + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.setting().key)
    }
}
