use std::fmt;

use crate::features::channel::AuxiliaryChannel;
use crate::features::gauge_scale::GaugeScale;
use crate::features::monomial::Monomial;
use crate::features::setting::Setting;
use crate::features::source::{Rows, Source};

/// Feature block: one kind of columns beside the present gauges. Its [`Setting`] is a list of values, such as time constants.
///
/// Each block is one source file and one entry of [`BLOCKS`](crate::features::BLOCKS). Window, command line, files, exports and
/// guide need only this trait. Every block is causal and runs in bounded memory. Its state starts anew in each recording and
/// after each gap. The block contributes nothing until its state is determined.
pub trait Block: Send + Sync {
    fn name(&self) -> &'static str;

    /// Returns the description of the values: time constants, radii or a degree.
    fn setting(&self) -> &'static Setting;

    /// Returns the block's equation for a gauge signal s, as text.
    fn formula(&self) -> &'static str;

    fn appends(&self) -> Appends;

    fn n_columns(&self, values: &[f64], n_gauges: usize) -> usize {
        values.len() * n_gauges
    }

    /// Returns the time for which the block keeps samples (s); zero if it keeps none.
    fn window_secs(&self, _values: &[f64]) -> f64 {
        0.0
    }

    /// Returns the time from a cold start until the block's state is determined (s), if that depends on time.
    fn settling_secs(&self, values: &[f64]) -> f64 {
        self.window_secs(values)
    }

    /// Returns the range that a gauge must cover after a cold start until the state is determined (σ); zero if none is needed.
    fn travel(&self, _value: f64) -> f64 {
        0.0
    }

    /// Returns the block's state before the first sample.
    fn stream(&self, values: &[f64], inputs: &Inputs<'_>) -> Box<dyn Stream>;

    /// Returns the block's source code for exported programs.
    fn source(&self, values: &[f64], rows: &Rows<'_>) -> Source;

    /// Returns the search for the best values, or `None` if the user must enter them.
    fn search(&self) -> Option<Search> {
        None
    }
}

/// Kind of columns that a feature block appends.
#[derive(Clone, Copy, Debug)]
pub enum Appends {
    /// One set of past gauges for each value. The function converts a value to the name in `<gauge>_<name>`.
    Past(fn(f64) -> String),
    /// Products of present gauges. The function converts a value and the number of gauges to the list of products.
    Monomials(fn(f64, usize) -> Vec<Monomial>),
    /// For each value and each auxiliary channel: the channel, and its product with each present gauge.
    Auxiliary,
}

/// Description of the gauges and channels from which a [`Stream`] computes its columns.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    pub scale: &'a GaugeScale,
    pub channels: &'a [AuxiliaryChannel],
    /// Minimum time between two samples that are kept (s).
    pub history_step_secs: f64,
}

/// State of a feature block, updated with each sample of a recording or of a running sensor.
pub trait Stream: fmt::Debug + Send + Sync {
    /// Processes the next sample and writes its columns. Past gauges are not written as differences from the present ones.
    fn step(&mut self, time: f64, gauges: &[f64], auxiliary: &[f64], out: &mut [f64]);

    /// Returns true if the samples so far determine the state. Until then the columns contribute little or nothing to the load.
    fn is_determined(&self) -> bool {
        true
    }
}

/// Values that cross-validation tries for a feature block.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Candidates in rising order. Candidates in seconds are limited to what the recordings can resolve.
    pub candidates: &'static [f64],
    pub lists: Lists,
}

#[derive(Clone, Copy, Debug)]
pub enum Lists {
    /// Lists of `min` to `max` evenly spaced candidates. The shortest list with an error within 1 % of the lowest is chosen.
    Even { min: usize, max: usize },
    /// Maximum number of values. After the best candidate, others are added that lower the error with 90 % confidence.
    OneByOne(usize),
}

/// Feature blocks are equal if their settings have the same key.
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
