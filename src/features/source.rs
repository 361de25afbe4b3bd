//! Source code of a block for exports: constants, memory, and the update in C, Rust, Python and MATLAB.
//!
//! In an update, `row` starts with the present gauges minus their centre. The block writes its columns from `next` on;
//! histories are written minus the present gauges. Python appends to `row`; in MATLAB `next` is the last written column. The
//! export target declares constants and memory.
//!
//! The texts are Jinja templates with the variables `{{ prefix }}`, `{{ n_gauges }}`, `{{ n_auxiliary }}` and `{{ sets }}`, the
//! number of values of the block. `auxiliary` holds the auxiliary channels of the sample. In C an update has its own braces,
//! and `g` is the index of a gauge.

use serde::Serialize;

use crate::features::channel::AuxiliaryChannel;
use crate::features::gauge_scale::GaugeScale;

/// Gauges and channels that a block processes.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Scale of the gauges over the training recordings.
    pub scale: &'a GaugeScale,
    /// Factor and constant that standardise each gauge after its centre is subtracted.
    pub standardise: &'a [(f64, f64)],
    /// Auxiliary channels of the calibration.
    pub channels: &'a [AuxiliaryChannel],
}

impl Rows<'_> {
    /// Returns the factors and constants that standardise gauges, as constants with these names.
    pub fn standard(&self, [factor, constant]: [&'static str; 2]) -> [Constant; 2] {
        let pairs = self.standardise.iter();
        [
            Constant::reals(factor, pairs.clone().map(|(factor, _)| *factor)),
            Constant::reals(constant, pairs.map(|(_, constant)| *constant)),
        ]
    }
}

/// Source code of a block.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Source {
    /// Constants of the block.
    pub constants: Vec<Constant>,
    /// Values kept between samples, initially zero.
    pub memory: Vec<Memory>,
    /// C code.
    pub c: Code,
    /// Rust code.
    pub rust: Code,
    /// Python code; memory needs no declaration there.
    pub python: Code,
    /// MATLAB code; memory is declared there.
    pub matlab: Code,
}

impl Source {
    /// Creates the source of a block whose updates need no extra functions.
    pub fn new(constants: Vec<Constant>, memory: Vec<Memory>, updates: [&str; 4]) -> Self {
        let [c, rust, python, matlab] = updates.map(Code::update);
        Self { constants, memory, c, rust, python, matlab }
    }
}

/// Source code of a block in one language.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Code {
    /// Extra functions; in Rust and Python methods of the state.
    pub functions: &'static str,
    /// Processes a sample and writes its columns.
    pub update: String,
}

impl Code {
    pub fn update(text: impl Into<String>) -> Self {
        Self { functions: "", update: text.into() }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// The program's floating-point type, which may have single precision.
    Real,
    /// A time (s), which a C program may count in ticks.
    Clock,
    /// A number of samples.
    Index,
}

#[derive(Clone, Debug, Serialize)]
pub struct Constant {
    /// In lower case.
    pub name: &'static str,
    pub precision: Precision,
    pub numbers: Numbers,
}

impl Constant {
    pub fn reals(name: &'static str, values: impl Iterator<Item = f64>) -> Self {
        Self { name, precision: Precision::Real, numbers: Numbers::List(values.collect()) }
    }
}

/// One list, or one list for each value.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Numbers {
    List(Vec<f64>),
    /// For each value, one row with an entry per gauge.
    Rows(Vec<Vec<f64>>),
}

/// Memory between samples.
#[derive(Clone, Debug, Serialize)]
pub struct Memory {
    /// In lower case.
    pub name: &'static str,
    pub precision: Precision,
    /// Number of entries, one for each value.
    pub sets: usize,
    /// True if each entry is an array with one number per gauge.
    pub of_gauges: bool,
    /// Comment in the exported code.
    pub comment: &'static str,
}

impl Memory {
    /// Creates memory for one array of gauges per value.
    pub fn of_gauges(name: &'static str, sets: usize) -> Self {
        Self { of_gauges: true, ..Self::single(name, sets) }
    }

    /// Creates memory for one number per value.
    pub fn single(name: &'static str, sets: usize) -> Self {
        Self { name, precision: Precision::Real, sets, of_gauges: false, comment: "" }
    }

    pub fn about(self, comment: &'static str) -> Self {
        Self { comment, ..self }
    }
}
