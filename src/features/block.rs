use std::fmt;

use crate::features::channel::AuxiliaryChannel;
use crate::features::gauge_scale::GaugeScale;
use crate::features::monomial::Monomial;
use crate::features::setting::Setting;
use crate::features::source::{Rows, Source};

/// One kind of columns added to the present gauges, with one [`Setting`], a list of values such as time constants.
///
/// Each block is one file in this room and one entry of [`BLOCKS`](crate::features::BLOCKS). Window, command line, files,
/// exports and guide take all they need from this trait. Every block is causal and runs in bounded memory. It starts anew in
/// each recording and after each gap, and contributes nothing until its state is determined.
pub trait Block: Send + Sync {
    fn name(&self) -> &'static str;

    /// Returns the setting that describes the values: time constants, radii or a degree.
    fn setting(&self) -> &'static Setting;

    /// Returns the equation of the block for a gauge s.
    fn formula(&self) -> &'static str;

    fn appends(&self) -> Appends;

    fn n_columns(&self, values: &[f64], n_gauges: usize) -> usize {
        values.len() * n_gauges
    }

    /// Returns how long the block keeps samples (s); zero if it keeps none.
    fn window_secs(&self, _values: &[f64]) -> f64 {
        0.0
    }

    /// Returns the time from a cold start until the block's state is determined (s), if that depends on time.
    fn settling_secs(&self, values: &[f64]) -> f64 {
        self.window_secs(values)
    }

    /// Returns the distance that a gauge must move from a cold start until the state of a value is determined (σ), or zero.
    fn travel(&self, _value: f64) -> f64 {
        0.0
    }

    /// Returns the state before the first sample. Of samples within `history_step_secs`, one is kept, besides the newest.
    fn stream(
        &self,
        values: &[f64],
        scale: &GaugeScale,
        channels: &[AuxiliaryChannel],
        history_step_secs: f64,
    ) -> Box<dyn Stream>;

    /// Returns the block as source code for exports.
    fn source(&self, values: &[f64], rows: &Rows<'_>) -> Source;

    /// Returns the search for the best values, or `None` if the user must enter them.
    fn search(&self) -> Option<Search> {
        None
    }
}

/// Kind of columns that a block appends.
#[derive(Clone, Copy, Debug)]
pub enum Appends {
    /// A history: one set of past gauges for each value, fitted relative to the present gauges. The function returns the name
    /// in the columns `<gauge>_<name>` of a value.
    Past(fn(f64) -> String),
    /// Products of present gauges, for a value and the number of gauges. They do not depend on the past.
    Monomials(fn(f64, usize) -> Vec<Monomial>),
    /// For each value and each auxiliary channel: the channel, and its product with each gauge. No past gauges.
    Auxiliary,
}

/// State of a block, updated with each sample. Whole recordings and live estimators use the same code.
pub trait Stream: fmt::Debug + Send + Sync {
    /// Processes the next sample and writes its columns. A history writes past gauges, not differences.
    fn step(&mut self, time: f64, gauges: &[f64], auxiliary: &[f64], out: &mut [f64]);

    /// Returns true if the samples so far determine the state. Until then the columns contribute nothing, or less.
    fn is_determined(&self) -> bool {
        true
    }
}

/// Search for the values of a block by cross-validation.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Candidates in rising order. Candidates in seconds are limited to what the recordings can resolve.
    pub candidates: &'static [f64],
    pub lists: Lists,
}

#[derive(Clone, Copy, Debug)]
pub enum Lists {
    /// Evenly spaced lists of `min` to `max` values. The shortest list within 1 % of the lowest error is chosen.
    Even { min: usize, max: usize },
    /// The best value, then the best additional values, up to this number, if each lowers the error with 90 % confidence.
    OneByOne(usize),
}

/// Blocks are equal if the keys of their settings are equal.
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
