use std::fmt;

use crate::features::{
    channel::AuxiliaryChannel,
    gauge_scale::GaugeScale,
    monomial::Monomial,
    setting::Setting,
    source::{Rows, Source},
};

/// Most by which a share of the fade, or the weight of a play operator, rises from one sample to the next. So a load has no jump
/// where a gauge travels far between two samples.
pub(crate) const MOST_RISE: f64 = 0.03;

/// Feature block: one kind of regression columns that are added to the present gauges. Its [`Setting`] is a list of values,
/// such as time constants.
///
/// Each block is one source file and one entry of [`BLOCKS`](crate::features::BLOCKS). Window, command line, files, exports
/// and guide need only this trait. Every block is causal and needs bounded memory. Its state starts anew in each recording
/// and after each pause in a recording. The block contributes nothing until its state is determined.
pub trait Block: Send + Sync {
    fn name(&self) -> &'static str;

    /// Returns the description of the block's values, such as time constants, radii or a degree.
    fn setting(&self) -> &'static Setting;

    /// Returns the block's equation for a gauge signal s, as text for the guide.
    fn formula(&self) -> &'static str;

    fn appends(&self) -> Appends;

    fn n_columns(&self, values: &[f64], n_gauges: usize) -> usize {
        values.len() * n_gauges
    }

    /// Returns the time for which the block stores samples (s); zero if it stores none.
    fn window_secs(&self, _values: &[f64]) -> f64 {
        0.0
    }

    /// Returns the time from a start without earlier samples until the block's state is determined (s), for states that
    /// depend on time.
    fn settling_secs(&self, values: &[f64]) -> f64 {
        self.window_secs(values)
    }

    /// Returns the range that a gauge must cover after a start until the state is determined (in standard deviations of the
    /// gauge); zero if none is needed.
    fn travel(&self, _value: f64) -> f64 {
        0.0
    }

    /// Returns the effect of each of the block's states on the load, from the squared effect `columns` of each column per unit of
    /// its gauge. Empty if the states are known at once, or depend only on samples of a fixed time.
    fn effects(&self, _values: &[f64], _columns: &[f64], _scale: &GaugeScale) -> Vec<f64> {
        Vec::new()
    }

    /// Returns the squared error by what is not known of the states, as [`Stream::missing`], in the middle of the training
    /// samples.
    fn usually_missing(&self, _values: &[f64], _effects: &[f64], _scale: &GaugeScale) -> f64 {
        0.0
    }

    /// Returns the name of the memory in which the block keeps its state, in calibration files. Blocks with the same name share
    /// a memory; `None` if the block has no state.
    fn memory(&self) -> Option<&'static str> {
        Some(self.setting().key)
    }

    /// Returns the block's state before the first sample.
    fn stream(&self, values: &[f64], inputs: &Inputs<'_>) -> Box<dyn Stream>;

    /// Returns the block's source code for exported calibrations, in every language.
    fn source(&self, values: &[f64], rows: &Rows<'_>) -> Source;

    /// Returns the search for the best values of the block, or `None` if the user must enter the values.
    fn search(&self) -> Option<Search> {
        None
    }
}

/// Name of the memory of the samples that look-backs and lags share.
pub(crate) const STORED_SAMPLES: &str = "stored_samples";

/// Kind of regression columns that a feature block appends to the present gauges.
#[derive(Clone, Copy, Debug)]
pub enum Appends {
    /// For each value of the block, one past value of each gauge. The function converts a value to the second part of the
    /// column name `<gauge>_<name>`.
    Past(fn(f64) -> String),
    /// Products of present gauges. The function converts a value of the block and the number of gauges to the list of
    /// products.
    Monomials(fn(f64, usize) -> Vec<Monomial>),
    /// For each value of the block and each auxiliary channel: the channel, and its product with each present gauge.
    Auxiliary,
}

/// Scale of the gauges, and auxiliary channels, from which a [`Stream`] computes its columns.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    pub scale: &'a GaugeScale,
    pub channels: &'a [AuxiliaryChannel],
    /// Minimum time between two samples that the block stores (s).
    pub history_step_secs: f64,
}

/// State of a feature block, which each sample of a recording or of a running sensor updates.
pub trait Stream: fmt::Debug + Send + Sync {
    /// Updates the state with the next sample and writes the columns of the block to `out`. Past gauges are written as they
    /// are, not relative to the present gauges.
    fn step(&mut self, time: f64, gauges: &[f64], auxiliary: &[f64], out: &mut [f64]);

    /// Is called after a pause through which the state is kept, with the time of the next sample (s). By default, nothing
    /// happens, so the next sample comes after a long time step.
    fn resume(&mut self, _time: f64) {}

    /// Returns the squared error of the load by what the samples so far do not tell of the states. `effects` are those of
    /// [`Block::effects`].
    fn missing(&self, _effects: &[f64]) -> f64 {
        0.0
    }
}

/// Search of the values of a feature block by cross-validation.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Values to try, in rising order. Times in seconds are limited to those that the recordings can resolve.
    pub candidates: &'static [f64],
    pub lists: Lists,
}

#[derive(Clone, Copy, Debug)]
pub enum Lists {
    /// Tries lists of `min` to `max` evenly spaced candidates. The shortest list whose error is within 1 % of the lowest
    /// error is chosen.
    Even { min: usize, max: usize },
    /// Maximum number of values. The best candidate is chosen first. Others are added one by one if they lower the error with
    /// 90 % confidence.
    OneByOne(usize),
}

/// Two feature blocks are equal if their settings have the same key.
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
