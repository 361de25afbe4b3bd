//! Source code of a feature block in exported programs: constants, memory, and the update (statements for one sample) in C,
//! Rust, Python and MATLAB.
//!
//! In an update, the array `row` starts with the present gauges minus their centre, and the block writes its columns from
//! index `next` on. Past gauges are written minus the present gauges. Python code appends to `row` instead. In MATLAB, `next`
//! is the index of the last written column. Other code of the exported program declares constants and memory.
//!
//! The texts are Jinja templates with the variables `{{ prefix }}`, `{{ n_gauges }}`, `{{ n_auxiliary }}` and `{{ sets }}`, the
//! number of the block's values; `{{ fades }}` is true if the load fades in, and `{{ most_rise }}` is the most by which a weight rises
//! in one sample.
//! `auxiliary` holds the auxiliary channels of the sample. In C, an update has its own braces,
//! and `g` is the index of a gauge.

use serde::Serialize;

use crate::features::{channel::AuxiliaryChannel, gauge_scale::GaugeScale};

/// Gauges and auxiliary channels of a calibration, as the source code of a feature block needs them.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Shift and scale of the gauges over the training recordings.
    pub scale: &'a GaugeScale,
    /// Factor and constant of each gauge: `z = factor · (gauge − centre) + constant` is the standardised gauge.
    pub standardise: &'a [(f64, f64)],
    /// Auxiliary channels of the calibration.
    pub channels: &'a [AuxiliaryChannel],
    /// Effect of each state of the block on the load, see [`Block::effects`](crate::features::Block::effects).
    pub effects: &'a [f64],
    /// Factor of each state in the fade of the load, see [`Calibration::fade`](crate::calibration::Calibration::fade); empty
    /// without a fade.
    pub fade: &'a [f64],
}

impl Rows<'_> {
    /// Returns the factors and constants of [`Self::standardise`] as two constants of the exported program with these names.
    pub fn standard(&self, [factor, constant]: [&'static str; 2]) -> [Constant; 2] {
        let pairs = self.standardise.iter();
        [
            Constant::reals(factor, pairs.clone().map(|(factor, _)| *factor)),
            Constant::reals(constant, pairs.map(|(_, constant)| *constant)),
        ]
    }
}

/// Source code of a feature block in all languages of exported programs.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Source {
    /// Constants that the code reads, such as the time constants of creep.
    pub constants: Vec<Constant>,
    /// Arrays that the code keeps between samples, initially zero.
    pub memory: Vec<Memory>,
    /// C code.
    pub c: Code,
    /// Rust code.
    pub rust: Code,
    /// Python code, which creates its memory itself.
    pub python: Code,
    /// MATLAB code.
    pub matlab: Code,
}

impl Source {
    /// Creates the source code of a feature block from its updates in C, Rust, Python and MATLAB.
    pub fn new(constants: Vec<Constant>, memory: Vec<Memory>, updates: [&str; 4]) -> Self {
        let [c, rust, python, matlab] = updates.map(Code::update);
        Self { constants, memory, c, rust, python, matlab }
    }
}

/// Source code of a feature block in one language.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Code {
    /// Functions that the update calls. In Rust and Python, they are methods of the program's state.
    pub functions: &'static str,
    /// Statements that process one sample and write the columns of the feature block.
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
    /// Real number in the floating-point type of the exported program, which may have single precision.
    Real,
    /// Time (s), which a C program may count in ticks.
    Clock,
    /// Number of samples.
    Index,
}

#[derive(Clone, Debug, Serialize)]
pub struct Constant {
    /// Name of the constant in the exported code, in lower case.
    pub name: &'static str,
    pub precision: Precision,
    pub numbers: Numbers,
}

impl Constant {
    pub fn reals(name: &'static str, values: impl Iterator<Item = f64>) -> Self {
        Self { name, precision: Precision::Real, numbers: Numbers::List(values.collect()) }
    }
}

/// Values of a constant in an exported program.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Numbers {
    List(Vec<f64>),
    /// One row for each value of the feature block's setting, with one entry per gauge.
    Rows(Vec<Vec<f64>>),
}

/// Array that an exported program keeps between samples.
#[derive(Clone, Debug, Serialize)]
pub struct Memory {
    /// Name of the array in the exported code, in lower case.
    pub name: &'static str,
    pub precision: Precision,
    /// Number of entries of the array. For many feature blocks, it is the number of values of their setting, such as radii.
    pub sets: usize,
    /// True if each entry is an array with one number per gauge.
    pub of_gauges: bool,
    /// Comment on the array in the exported code; may be empty.
    pub comment: &'static str,
}

impl Memory {
    /// Creates an array whose `sets` entries are arrays with one number per gauge.
    pub fn of_gauges(name: &'static str, sets: usize) -> Self {
        Self { of_gauges: true, ..Self::single(name, sets) }
    }

    /// Creates an array of `sets` numbers.
    pub fn single(name: &'static str, sets: usize) -> Self {
        Self { name, precision: Precision::Real, sets, of_gauges: false, comment: "" }
    }

    pub fn about(self, comment: &'static str) -> Self {
        Self { comment, ..self }
    }
}
